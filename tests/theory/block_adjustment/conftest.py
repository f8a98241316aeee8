"""Small blocks, and their adjustment with every unknown in one dense matrix."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import block_diag, qr, solve_triangular

from einschalt.theory.block_adjustment.common_parameters import deformation_of
from einschalt.theory.block_adjustment.observations import BlockObservations

LAYOUTS = {
    "one model": [(0.0, 0.0)],
    "two models": [(0.0, 0.0), (900.0, 0.0)],
    "grid": [(700.0 * i, 800.0 * j) for i in range(3) for j in range(3)],
    "dense grid": [(480.0 * i, 480.0 * j) for i in range(5) for j in range(5)],
    "strip": [(700.0 * i, 40.0 * (i % 2)) for i in range(14)],
    "ring": [
        (2400.0 * np.cos(a), 2400.0 * np.sin(a))
        for a in np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    ],
}
MM = 1e-3


def scatter(centres, rng, spacing=320.0):
    """Points on a disturbed grid that covers all models."""
    low, high = np.min(centres, axis=0) - 600.0, np.max(centres, axis=0) + 600.0
    e, n = np.meshgrid(
        np.arange(low[0], high[0], spacing), np.arange(low[1], high[1], spacing)
    )
    grid = np.column_stack([e.ravel(), n.ravel()])
    return grid + rng.uniform(-0.3, 0.3, grid.shape) * spacing


def _covariances(control, n_points, rng):
    """Covariances of control: even, correlated, or held."""
    matrix = rng.standard_normal((n_points, 2, 2)) * 0.02
    return {
        "even": np.broadcast_to(0.02**2 * np.eye(2), (n_points, 2, 2)).copy(),
        "unequal": np.broadcast_to(np.diag([4e-4, 1e-4]), (n_points, 2, 2)).copy(),
        "correlated": matrix @ np.swapaxes(matrix, 1, 2) + 1e-4 * np.eye(2),
        "held": np.zeros((n_points, 2, 2)),
    }[control]


@pytest.fixture(scope="session")
def make_block():
    """Simulate a block whose models were measured with errors of 4 cm."""

    def make(layout="grid", kind="affine", control="even", *, every=4, **options):
        rng = np.random.default_rng(options.get("seed", 3))
        centres = np.array(LAYOUTS[layout])
        ground = scatter(centres, rng)
        away = np.abs(ground[None] - centres[:, None]).max(axis=2)
        model, point = np.nonzero(away < 560.0)
        holders = np.bincount(point, minlength=len(ground))
        kept = np.flatnonzero(holders > 0)
        ground, point = ground[kept], np.searchsorted(kept, point)
        n_models, n_points = len(centres), len(ground)
        turn = rng.uniform(0.0, 2.0 * np.pi, n_models)
        scale = 8000.0 * MM * (1.0 + 1e-3 * rng.standard_normal(n_models))
        a = np.exp(1j * turn) / scale
        z = (ground - centres[:, None]) @ [1.0, 1j]
        flight = np.arange(n_models) % options.get("n_flights", 1)
        sigma = np.where(flight[model] == 1, 0.08, 0.03)
        if options.get("weights"):
            sigma = sigma * rng.uniform(0.5, 2.0, len(model))
        error = sigma[:, None] * rng.standard_normal((len(model), 2)) / 8.0
        measured = (a[:, None] * z)[model, point]
        xy = np.column_stack([measured.real, measured.imag]) + error + (300.0, -120.0)
        xy = xy * (1.0 + np.array([0.5, -0.5]) * options.get("affinity", 0.0))
        given = ground + rng.normal(0.0, 0.02, ground.shape)
        is_control = np.zeros(n_points, dtype=bool)
        is_control[options.get("chosen", np.arange(0, n_points, every))] = True
        given[~is_control] = np.nan
        kinds = {"affine": [True], "helmert": [False], "mixed": [True, False]}[kind]
        covariance = _covariances(control, n_points, rng)
        covariance[~is_control] = 0.0
        if options.get("some_held"):
            covariance[np.flatnonzero(is_control)[::2]] = 0.0
        origin = np.array(options.get("origin", (0.0, 0.0)))
        return BlockObservations(
            model=model,
            point=point,
            xy=xy,
            standard_error=sigma,
            is_affine=np.resize(kinds, n_models),
            flight=flight,
            control=given + origin,
            control_covariance=covariance,
        )

    make.layouts = LAYOUTS
    return make


def _reduced(observations):
    """Model coordinates about the centroid of each model, in units of its extent."""
    xy = np.empty_like(observations.xy)
    centroid = np.empty((observations.n_models, 2))
    for m in range(observations.n_models):
        rows = observations.model == m
        centroid[m] = observations.xy[rows].mean(axis=0)
        xy[rows] = (observations.xy[rows] - centroid[m]) / 60.0
    return xy, centroid


def _design_of_models(observations, xy):
    """T of each observation as a matrix of all unknowns of all models."""
    starts, n = [], 0
    for is_affine in observations.is_affine:
        starts.append(n)
        n += 6 if is_affine else 4
    design = np.zeros((len(xy), 2, n))
    for row, m in enumerate(observations.model):
        x, y = xy[row]
        s = starts[m]
        design[row, 0, s : s + 2] = 1.0, 0.0
        design[row, 1, s : s + 2] = 0.0, 1.0
        if observations.is_affine[m]:
            design[row, 0, s + 2 : s + 6] = x, 0.0, y, 0.0
            design[row, 1, s + 2 : s + 6] = 0.0, x, 0.0, y
        else:
            design[row, 0, s + 2 : s + 4] = x, -y
            design[row, 1, s + 2 : s + 4] = y, x
    return design, starts


def _linear_parts(observations, p, starts):
    """Linear part of each model, shape (n_models, 2, 2)."""
    parts = []
    for is_affine, s in zip(observations.is_affine, starts, strict=True):
        c = p[s + 2 : s + 6]
        rows = [[c[0], c[2]], [c[1], c[3]]] if is_affine else [[c[0], -c[1]], c[1::-1]]
        parts.append(rows)
    return np.array(parts)


def adjust_densely(observations, terms=()):
    """Gauss-Markov with every point and every model as unknowns, by QR.

    The common parameters are iterated (Gauss-Newton) with the full design.
    """
    columns = deformation_of(observations, terms).columns
    n_rows, n_terms = len(observations.xy), columns.shape[2]
    n_points = observations.n_points
    is_fixed, is_control = observations.is_fixed, observations.is_control
    origin = np.nanmean(observations.control, axis=0)
    control = observations.control - origin
    free = np.flatnonzero(~is_fixed)
    place = np.full(n_points, -1)
    place[free] = np.arange(len(free))
    observed = np.flatnonzero(is_control & ~is_fixed)
    roots = [
        np.linalg.inv(np.linalg.cholesky(observations.control_covariance[k]))
        for k in observed
    ]
    common = np.zeros(n_terms)
    linear = None
    for _ in range(1 if n_terms == 0 else 12):
        before, is_first = common, linear is None
        moved = BlockObservations(
            **{**vars(observations), "xy": observations.xy + columns @ common}
        )
        xy, centroid = _reduced(moved)
        models, starts = _design_of_models(observations, xy)
        n_model = models.shape[2]
        if linear is None:  # of the block without common parameters
            on_ground = np.zeros((n_rows, 2, n_terms))
        else:
            on_ground = linear[observations.model] / 60.0 @ columns
        n_all = n_model + 2 * len(free) + n_terms
        a = np.zeros((n_rows, 2, n_all))
        a[:, :, :n_model] = models
        a[:, :, n_model + 2 * len(free) :] = on_ground
        right = np.zeros((n_rows, 2))
        for row, p in enumerate(observations.point):
            if is_fixed[p]:
                right[row] = control[p]
                continue
            for c in range(2):
                a[row, c, n_model + 2 * place[p] + c] = -1.0
        whole = np.zeros((len(observed), 2, n_all))
        for k, p in enumerate(observed):
            whole[k, :, n_model + 2 * place[p] :][:, :2] = np.eye(2)
        weight = np.repeat(1.0 / observations.standard_error, 2)
        unweighted = np.concatenate([a.reshape(-1, n_all), whole.reshape(-1, n_all)])
        control_root = block_diag(*roots) if roots else np.zeros((0, 0))

        def whiten(values, weight=weight, control_root=control_root):
            n = len(weight)
            own = (values[:n].T * weight).T
            return np.concatenate([own, control_root @ values[n:]])

        design = whiten(unweighted)
        right_side = np.concatenate([right.ravel(), control[observed].ravel()])
        used = n_all - n_terms if linear is None else n_all
        # columns of unlike size, scaled so that rounding is even
        size = np.sqrt((design[:, :used] ** 2).sum(axis=0))
        q, r = qr(design[:, :used] / size, mode="economic")
        # refined with the digits of extended precision: little control far away lets
        # rounding swing
        x, exact = np.zeros(n_all, np.longdouble), unweighted.astype(np.longdouble)
        for _ in range(4):
            rest = whiten(np.asarray(right_side - exact @ x, float))
            x[:used] += solve_triangular(r, q.T @ rest) / size
        linear = _linear_parts(observations, x, starts)
        common = common + x.astype(float)[n_model + 2 * len(free) :]
        change = np.abs(common - before)
        if not is_first and (change <= 1e-12 * np.abs(common).max()).all():
            break
    inverse = solve_triangular(r, np.eye(used)) / size[:, None]
    cofactors = inverse @ inverse.T
    residuals = np.asarray(exact @ x - right_side, float)
    points = control.copy()
    points[free] = x[n_model : n_model + 2 * len(free)].reshape(-1, 2)
    point_cofactors = np.zeros((n_points, 2, 2))
    for k, p in enumerate(free):
        at = n_model + 2 * k
        point_cofactors[p] = cofactors[at : at + 2, at : at + 2]
    adjusted = unweighted[: 2 * n_rows].reshape(n_rows, 2, -1)
    whitened = whiten(residuals)
    return SimpleNamespace(
        points=points + origin,
        residuals=residuals[: 2 * n_rows].reshape(-1, 2),
        point_cofactors=point_cofactors,
        adjusted_cofactors=adjusted @ cofactors @ np.swapaxes(adjusted, 1, 2),
        affinity_of=lambda m: linear[m] / 60.0,
        model_cofactors=[
            cofactors[s : s + (6 if f else 4), s : s + (6 if f else 4)]
            for s, f in zip(starts, observations.is_affine, strict=True)
        ],
        starts=starts,
        common=common,
        common_cofactors=cofactors[used - n_terms : used, used - n_terms : used],
        sum_of_squares=float(whitened @ whitened),
        redundancy=len(right_side) - used,
        design=design,
        right_side=whiten(right_side),
        centroid=centroid,
    )


@pytest.fixture(scope="session")
def dense():
    """Adjust a block densely; the same block, for whatever it is asked, once."""
    found = {}

    def adjusted(observations, terms=()):
        key = pickle.dumps((vars(observations), terms))
        if key not in found:
            found[key] = adjust_densely(observations, terms)
        return found[key]

    return adjusted
