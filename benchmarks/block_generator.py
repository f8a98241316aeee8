"""Large blocks on a grid: as many models as wanted, sixteen points in each."""

import numpy as np

from einschalt.theory.block_adjustment.observations import BlockObservations

POINTS_PER_MODEL = 7  # of the block; a model holds 16, since its neighbours overlap
SIDE = np.sqrt(16 / POINTS_PER_MODEL)
SPACING_M = 1000.0
CONTROL_EVERY = 5  # point at the edge of the block
SIGMA_M = 0.03


def generate_block(n_across, n_along, *, is_affine=False, seed=0):
    """Lay models on a grid and measure them with errors of 3 cm.

    Parameters
    ----------
    n_across, n_along : int
    is_affine : bool
    seed : int

    Returns
    -------
    BlockObservations
    """
    rng = np.random.default_rng(seed)
    per_axis = np.sqrt(POINTS_PER_MODEL)
    n_x, n_y = int(n_across * per_axis) + 1, int(n_along * per_axis) + 1
    grid = np.stack(np.meshgrid(np.arange(n_x), np.arange(n_y), indexing="ij"), -1)
    place = grid.reshape(-1, 2) + rng.uniform(-0.3, 0.3, (n_x * n_y, 2))
    place = place / per_axis
    model, point = _held(place, n_across, n_along)
    points, point = np.unique(point, return_inverse=True)
    place = place[points]
    ground = place @ [1.0, 1j] * SPACING_M
    n_models = n_across * n_along
    turn = np.exp(1j * rng.uniform(-0.1, 0.1, n_models)) / 8.0
    centre = np.column_stack(np.divmod(np.arange(n_models), n_along)) + 0.5
    about = ground[point] - (centre @ [1.0, 1j] * SPACING_M)[model]
    z = about * turn[model]
    xy = np.column_stack([z.real, z.imag]) + SIGMA_M / 8.0 * rng.standard_normal(
        (len(model), 2)
    )
    near = np.minimum(place, np.array([n_across, n_along]) - place).min(axis=1) < 0.5
    is_control = np.zeros(len(points), dtype=bool)
    is_control[np.flatnonzero(near)[::CONTROL_EVERY]] = True
    control = np.column_stack([ground.real, ground.imag])
    control[~is_control] = np.nan
    covariance = np.zeros((len(points), 2, 2))
    covariance[is_control] = SIGMA_M**2 * np.eye(2)
    return BlockObservations(
        model=model,
        point=point,
        xy=xy,
        standard_error=np.full(len(model), SIGMA_M),
        is_affine=np.full(n_models, is_affine),
        flight=np.zeros(n_models, dtype=np.int64),
        control=control,
        control_covariance=covariance,
    )


def _held(place, n_across, n_along):
    """Which models hold each point: those within half a side of their centres."""
    models, points = [], []
    low = np.floor(place - 0.5 - SIDE / 2.0).astype(np.int64) + 1
    for i in range(2):
        for j in range(2):
            cell = low + np.array([i, j])
            is_near = (np.abs(place - 0.5 - cell) <= SIDE / 2.0).all(axis=1)
            is_in = (cell >= 0).all(axis=1) & (cell < [n_across, n_along]).all(axis=1)
            rows = np.flatnonzero(is_near & is_in)
            models.append(cell[rows, 0] * n_along + cell[rows, 1])
            points.append(rows)
    model, point = np.concatenate(models), np.concatenate(points)
    order = np.lexsort((point, model))
    return model[order], point[order]
