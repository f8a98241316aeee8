"""Residuals against those of their neighbours, where errors differ within a model.

Points of convergent or wide-angle models err along their rays, the far ones by several
times the near ones, while the adjustment knows one error for all points of a flight:
good points look like gross errors. Where the sizes of residuals go along with those of
their neighbours, a residual v is gross by the covariance C of its n neighbours in the
model alone,

    T² = vᵀ C⁻¹ v,  T² (n − d + 1)/(n d) ~ F(d, n − d + 1)

(Hotelling 1931). Two names that were exchanged are often neighbours: the covariance is
that of the neighbours without those that lie farthest by the covariance of all, made
larger by what they are missed by (a step of Rousseeuw and Van Driessen 1999).
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.special import chdtr, chdtri, fdtrc

from einschalt.theory.block_adjustment.block_tests import BlockTests

N_NEIGHBOURS = 24
N_LEFT_OUT = 4  # of them
# among fewer points a gross error moves its neighbours, by its model
LEAST_POINTS = 2 * N_NEIGHBOURS + 1
# so many neighbours tell a covariance of three coordinates
LEAST_NEIGHBOURS = 14
# rank correlation of sizes of residuals with those of their neighbours: of equal errors
# it is 0 ± 1/√n
LEAST_CORRELATION, CLEARLY = 0.15, 5.0
LARGEST_CONDITION = 1e12
# residuals that nobody doubts are not looked at
DOUBTED, REFUSED = 0.01, 1e-4


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Rows next to each other in the models that have many."""

    rows: np.ndarray  # (n,)
    others: np.ndarray  # (n, N_NEIGHBOURS): rows too


def neighbours_of(solution) -> Neighbours:
    """Measured points next to each measured point in its model, by their places."""
    observations = solution.observations
    model = observations.model
    n_points = np.bincount(model, minlength=observations.n_models)
    rows = np.flatnonzero(n_points[model] >= LEAST_POINTS)
    none = np.zeros((0, N_NEIGHBOURS), dtype=np.int64)
    if not len(rows):
        return Neighbours(rows, none)
    places = solution.points[observations.point[rows]]
    # models lie apart along an axis of their own
    apart = 2.0 * np.linalg.norm(np.ptp(places, axis=0)) + 1.0
    places = np.column_stack([places, apart * model[rows]])
    _, nearest = cKDTree(places).query(places, N_NEIGHBOURS + 1)
    # the point itself is the first, unless another has the very same place
    is_other = nearest != np.arange(len(rows))[:, None]
    is_other[is_other.all(axis=1), -1] = False
    return Neighbours(rows, rows[nearest[is_other].reshape(-1, N_NEIGHBOURS)])


def judge_among_neighbours(solution, known, given, neighbours, is_in) -> BlockTests:
    """Test measured points by their neighbours, where errors differ by place.

    Parameters
    ----------
    solution : AdjustedBlock
    known : BlockTests
        Of the same observations, with one error for all points of a flight.
    given : BlockObservations
        With the standard errors that the observations have.
    neighbours : Neighbours
    is_in : ndarray of bool, shape (n_rows,)
        Observations that take part.

    Returns
    -------
    BlockTests
        ``known`` where sizes do not go along with those of neighbours, and where a
        residual is no more likely by them.
    """
    n_rows, d = solution.residuals.shape
    share = np.clip(1.0 - solution.leverage, 0.0, 1.0)
    error = given.standard_error.reshape(n_rows, -1)
    is_told = np.isfinite(known.p_value) & (share > 0.0).all(axis=1)
    divisor = error * np.sqrt(np.where(is_told[:, None], share, 1.0))
    scaled = np.where(is_told[:, None], solution.residuals / divisor, 0.0)
    counts = (is_told & is_in).astype(float)
    rows, others = neighbours.rows, neighbours.others
    n_others = counts[others].sum(axis=1)
    is_asked = is_told[rows] & (n_others >= LEAST_NEIGHBOURS)
    square = np.sum(scaled**2, axis=1)
    around = np.sum((counts * square)[others], axis=1) / np.maximum(n_others, 1.0)
    if not _go_along(square[rows[is_asked]], around[is_asked]):
        return known
    is_asked &= known.p_value[rows] < DOUBTED
    rows, others, n = rows[is_asked], others[is_asked], n_others[is_asked]
    near = scaled[others] * counts[others][:, :, None]
    by_others = _chance_among(scaled[rows], near, n)
    p_value, w = known.p_value.copy(), known.w.copy()
    p_value[rows] = np.maximum(p_value[rows], by_others)
    # what both refuse keeps its w: the worst of the block is told by it
    likely, chance = rows[by_others > REFUSED], by_others[by_others > REFUSED]
    w[likely] = np.minimum(w[likely], np.sqrt(chdtri(d, chance)))
    return BlockTests(w, p_value, known.error)


def _chance_among(v, near, n):
    """Probability of residuals (n_rows, d) as large by ``n`` of their neighbours.

    ``near`` (n_rows, N_NEIGHBOURS, d), 0 of those that do not count. 1 where they have
    no errors in some coordinate, and tell nothing.
    """
    d = v.shape[1]
    all_of_them = np.swapaxes(near, 1, 2) @ near / n[:, None, None]
    chance = np.ones(len(v))
    regular = np.linalg.cond(all_of_them) < LARGEST_CONDITION
    v, near, n = v[regular], near[regular], n[regular]
    solved = np.linalg.solve(all_of_them[regular], np.swapaxes(near, 1, 2))
    away = np.sum(near * np.swapaxes(solved, 1, 2), axis=2)
    is_far = away.argsort(axis=1).argsort(axis=1) >= N_NEIGHBOURS - N_LEFT_OUT
    near = np.where(is_far[:, :, None], 0.0, near)
    share, n = N_LEFT_OUT / n, n - N_LEFT_OUT
    # what normal errors lose of their variances with so many of the farthest
    kept = chdtr(d + 2.0, chdtri(d, share)) / (1.0 - share)
    covariance = np.swapaxes(near, 1, 2) @ near / (n * kept)[:, None, None]
    v = v[:, :, None]
    hotelling = np.sum(v * np.linalg.solve(covariance, v), axis=(1, 2))
    # the choice costs half as many degrees of freedom again: of 200 000 normal errors
    # 1.05 of 1 %, 1.1 of 0.1 % and 1.4 of 0.01 % fall below
    n = n - 0.5 * N_LEFT_OUT
    left = n - d + 1.0
    chance[regular] = fdtrc(d, left, hotelling * left / (n * d))
    return chance


def _go_along(sizes, around):
    """Whether sizes of residuals rise with those of their neighbours, by their ranks.

    A few gross errors change no ranks.
    """
    n = len(sizes)
    if n < LEAST_POINTS:
        return False
    ranks = [values.argsort().argsort().astype(float) for values in (sizes, around)]
    correlation = np.corrcoef(*ranks)[0, 1]
    return bool(correlation > max(LEAST_CORRELATION, CLEARLY / np.sqrt(n)))
