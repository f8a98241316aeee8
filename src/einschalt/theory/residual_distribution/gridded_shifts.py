"""Residuals of identical points, distributed to the nodes of a grid.

By collocation, or by natural neighbours whose error the collocation tells. See
docs/theory/collocation.md.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from einschalt.foundations.errors import SettingsError
from einschalt.theory.residual_distribution.collocation import collocate
from einschalt.theory.residual_distribution.distribution_weights import (
    distribution_weights,
)
from einschalt.theory.residual_distribution.held_out_ellipses import (
    HeldOutEllipses,
    held_out_ellipses,
)
from einschalt.theory.residual_distribution.robust_collocation import (
    RobustCollocation,
    robust_collocation,
)
from einschalt.theory.residual_distribution.shift_grid import (
    ShiftGrid,
    grid_layout,
    node_places,
)

COLLOCATION, NATURAL_NEIGHBOUR = "collocation", "natural_neighbour"
LEAST_POINTS = 10
NODES_PER_POINT = 3
LEAST_NODES, MOST_NODES = 20_000, 1_000_000
MOST_ASKED = 2e7  # nodes, where the user says how wide cells are
MORE_NODES = 2.0  # times as many as usual, if that makes interpolation exact
EXACT = 1e-4  # metres
N_TRIED = 500  # cells in which interpolation is compared
# mean square of what interpolation is off by in a cell, by the square in its middle
OVER_CELL = 0.5
PARTS = 10
SEED = 0  # a grid is the same in every run
MOST_ROUNDS = 20
TRIMMED = 5.0  # times the median residual, beyond which none counts


@dataclass(frozen=True, eq=False)
class GriddedShifts:
    """A grid of shifts, and what is known of it."""

    grid: ShiftGrid
    collocation: RobustCollocation
    ellipses: HeldOutEllipses
    differences: np.ndarray  # (n, 2), held-out points: predicted minus given [m]
    trusted: np.ndarray  # of bool, (n,)
    straining: np.ndarray  # of bool, (n,): left out since the way back needs it
    # between nodes, against the method itself, in plan [m]: RMS, and largest seen
    interpolation: tuple[float, float]

    @property
    def interpolation_square(self):
        """Mean square of what the grid is off by from the method, in plan [m²]."""
        return OVER_CELL * self.interpolation[0] ** 2


def gridded_shifts(source, target, method, *, keep_wrong=False, cell=None):
    """Distribute what an affine transformation leaves at identical points.

    ``source``, ``target``: (n, 2), n at least LEAST_POINTS; ``method``: COLLOCATION or
    NATURAL_NEIGHBOUR; ``cell``: width of the grid's cells [m], chosen where left out.
    None where no grid leads back; a SettingsError where the cell is none.
    """
    matrix, shift = _robust_affine(source, target)
    base = source @ matrix.T + shift
    shifts = target - base
    found = robust_collocation(base, shifts, keep_wrong=keep_wrong)
    trusted = found.trusted.copy()
    differences, ellipses = found.differences, found.ellipses
    if method == NATURAL_NEIGHBOUR:
        differences = _held_out(base, shifts, trusted)
        ellipses = held_out_ellipses(
            differences, found.variances, keep_wrong=keep_wrong
        )
    predict = _predictor(method, found.covariance)
    if cell is None:
        cell = chosen_cell(base[trusted], shifts[trusted], predict)
    _require_size(base[trusted], cell)
    corner, shape = grid_layout(base[trusted], cell)
    nodes = node_places(corner, cell, shape)
    straining = np.zeros(len(base), dtype=bool)
    for _ in range(MOST_ROUNDS):
        values, variances = predict(base[trusted], shifts[trusted], nodes)
        grid = ShiftGrid(
            matrix,
            shift,
            corner,
            cell,
            values.astype(np.float32).reshape(*shape, 2),
            variances.reshape(shape),
            ellipses.shape,
        )
        strained = grid.strained_cells()
        if not len(strained):
            error = interpolation_error(base[trusted], shifts[trusted], cell, predict)
            whole = _with_interpolation(grid, error[0])
            known = differences, trusted, straining
            return GriddedShifts(whole, found, ellipses, *known, error)
        going = _worst_beside(strained, base, differences, trusted)
        trusted[going], straining[going] = False, True
        if trusted.sum() < LEAST_POINTS:
            break
    return None


def _with_interpolation(grid, error):
    """Add to the variances what points between nodes are off by, RMS in cells [m]."""
    per_coordinate = OVER_CELL * error**2 / 2.0
    size = np.trace(grid.shape) / 2.0
    return replace(grid, variances=grid.variances + per_coordinate / size)


def _require_size(points, cell):
    """Refuse cells that no grid has, and grids that no memory holds."""
    least = np.sqrt(np.prod(np.ptp(points, axis=0)) / MOST_ASKED)
    if not (np.isfinite(cell) and cell > least):
        raise SettingsError(
            f"cell = {cell:g} m",
            expected=f"more than {least:.2g} m here: {MOST_ASKED:.0e} nodes at most",
        )


def _predictor(method, covariance):
    """Give a function of known points, their shifts, and places."""

    def of_neighbours(known, shifts, places):
        weights = distribution_weights(known, places, NATURAL_NEIGHBOUR)
        return weights @ shifts, collocate(known, shifts, places, covariance)[1]

    def of_covariance(known, shifts, places):
        return collocate(known, shifts, places, covariance)

    return of_neighbours if method == NATURAL_NEIGHBOUR else of_covariance


def _robust_affine(source, target):
    """Affine transformation of most points: matrix (2, 2), shift (2,)."""
    middle = np.median(source, axis=0)
    scale = np.abs(source - middle).max() or 1.0
    design = np.column_stack([np.ones(len(source)), (source - middle) / scale])
    ground = np.median(target, axis=0)
    kept = np.ones(len(source), dtype=bool)
    for _ in range(MOST_ROUNDS):
        factors = np.linalg.lstsq(design[kept], target[kept] - ground, rcond=None)[0]
        away = np.hypot(*(target - ground - design @ factors).T)
        again = away <= TRIMMED * np.median(away)
        if np.array_equal(again, kept) or again.sum() < LEAST_POINTS:
            break
        kept = again
    matrix = factors[1:].T / scale
    return matrix, ground + factors[0] - matrix @ middle


def _held_out(base, shifts, trusted):
    """Natural neighbours of trusted points, a tenth of all held out at a time."""
    differences = np.full((len(base), 2), np.nan)
    order = np.random.default_rng(SEED).permutation(len(base))
    for part in np.array_split(order, PARTS):
        others = trusted.copy()
        others[part] = False
        weights = distribution_weights(base[others], base[part], NATURAL_NEIGHBOUR)
        differences[part] = weights @ shifts[others] - shifts[part]
    return differences


def chosen_cell(known, shifts, predict):
    """Width of cells between whose nodes interpolation is exact, if it can be [m].

    About three nodes for each point, or up to twice as many.
    """
    n_nodes = np.clip(NODES_PER_POINT * len(known), LEAST_NODES, MOST_NODES)
    extent = np.maximum(np.ptp(known, axis=0), np.ptp(known) * 1e-3)
    usual = np.sqrt(np.prod(extent) / n_nodes) or 1.0
    error = interpolation_error(known, shifts, usual, predict)[1]
    # it grows with the square of the width
    finer = np.sqrt(EXACT / error) if error > EXACT else 1.0
    return _rounded(usual * finer if finer**-2 <= MORE_NODES else usual)


def _rounded(width):
    """Two digits of a width, downwards.

    >>> round(_rounded(0.0678), 6), _rounded(678.0)
    (0.067, 670.0)
    """
    unit = 10.0 ** (np.floor(np.log10(width)) - 1.0)
    return float(np.floor(width / unit) * unit)


def interpolation_error(known, shifts, cell, predict):
    """Error in the middle of cells beside known points, in plan [m]: RMS, largest."""
    rng = np.random.default_rng(SEED)
    places = known[rng.integers(0, len(known), N_TRIED)]
    corner = np.floor(places / cell) * cell
    steps = np.array([[0, 0], [1, 0], [0, 1], [1, 1], [0.5, 0.5]]) * cell
    asked = (corner + steps[:, None]).reshape(-1, 2)
    values = predict(known, shifts, asked)[0].reshape(5, -1, 2)
    missed = values[4] - values[:4].mean(axis=0)
    size = np.hypot(*missed.T)
    return float(np.sqrt(np.mean(size**2))), float(size.max())


def _worst_beside(places, base, differences, trusted):
    """Of the trusted points nearest to each place the one that is predicted worst."""
    rows = np.flatnonzero(trusted)
    n_near = min(4, len(rows))
    near = KDTree(base[rows]).query(places, np.arange(1, n_near + 1))[1]
    size = np.nan_to_num(np.hypot(*differences[rows].T))
    worst = size[near].argmax(axis=1)
    return np.unique(rows[near[np.arange(len(near)), worst]])
