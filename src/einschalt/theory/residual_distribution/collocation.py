"""Least-squares collocation of shifts among their nearest known points.

Each place takes the shift that is best by the covariance function, from its N_NEAREST
known points, with a mean of its own that is unknown (ordinary kriging): the cost grows
with the number of places alone, and no matrix is larger than the neighbourhood.

See docs/theory/collocation.md.
"""

import numpy as np
from scipy.spatial import KDTree

from einschalt.foundations.batches import n_cores, over_segments
from einschalt.foundations.kernels import compiled

N_NEAREST = 16
AT_ONCE = 50_000
N_TABULATED, MOST_TABULATED = 4_096, 65_536
FINE = 100.0  # steps of the table in the shortest range, at least
USUAL = 0.99  # of places have all neighbours within half of what is tabulated
FLATTEST = 1e-12  # share of the variance below which a pivot is rounding


def collocate(known_xy, shifts, xy, covariance):
    """Shifts at places, and the variance of each coordinate of a point there.

    Parameters
    ----------
    known_xy, shifts : ndarray, shape (n_known, 2)
        Known points and their shifts [m], with noise.
    xy : ndarray, shape (n, 2)
    covariance : CovarianceFunction

    Returns
    -------
    shifts : ndarray, shape (n, 2)
    variances : ndarray, shape (n,)
        Of a new point's shift, with its own noise [m²].
    """
    n_near = min(N_NEAREST, len(known_xy))
    return _collocated(known_xy, shifts, xy, covariance, np.arange(1, n_near + 1))


def collocate_left_out(known_xy, shifts, covariance, trusted=None):
    """Each known point, collocated from its neighbours without itself.

    ``trusted``: of bool, (n_known,), those that may be neighbours; all where left out.
    Shapes and units as :func:`collocate`.
    """
    n_known = len(known_xy)
    trusted = np.ones(n_known, dtype=bool) if trusted is None else trusted
    found, variances = np.empty((n_known, 2)), np.empty(n_known)
    for own, rank in ((True, 2), (False, 1)):  # a trusted one is its own nearest
        rows = np.flatnonzero(trusted == own)
        n_near = min(N_NEAREST, trusted.sum() - own)
        if not len(rows):
            continue
        found[rows], variances[rows] = _collocated(
            known_xy[trusted],
            shifts[trusted],
            known_xy[rows],
            covariance,
            np.arange(rank, rank + n_near),
        )
    return found, variances


def _collocated(known_xy, shifts, xy, covariance, ranks):
    tree = KDTree(known_xy)
    found, variances = np.empty((len(xy), 2)), np.empty(len(xy))
    table = None
    for first in range(0, len(xy), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        distance, near = tree.query(xy[part], ranks, workers=n_cores())
        if table is None:
            table = _tabulated(covariance, np.quantile(distance[:, -1], USUAL))
        of_part = found[part], variances[part]
        arrays = known_xy, shifts, near, xy[part], table, *of_part
        # a place is as much work as the rows of its system
        start = len(ranks) * np.arange(len(near) + 1)
        over_segments(_solve_neighbourhoods, start, *arrays)
    return found, variances


def _tabulated(covariance, radius):
    """Covariances and slopes by distance, and what it takes to compute others.

    Reading them is five times as quick, and exact to 1e-9 between.
    """
    end = 2.0 * radius if radius > 0.0 else 1.0
    step = min(end / N_TABULATED, covariance.ranges.min(initial=np.inf) / FINE)
    distance = step * np.arange(min(int(end / step), MOST_TABULATED) + 1)
    slope = covariance.slope(distance) * step
    exact = covariance.sills, np.sqrt(3.0) / covariance.ranges
    return covariance(distance), slope, 1.0 / step, covariance.variance, *exact


@compiled
def _covariance(east, north, table):
    values, slopes, per_step, _, sills, rates = table
    distance = np.sqrt(east**2 + north**2)
    place = distance * per_step
    cell = int(place)
    if cell < values.size - 1:  # the cubic through two values and their slopes
        t = place - cell
        rise = values[cell + 1] - values[cell]
        a, b = slopes[cell] - rise, rise - slopes[cell + 1]
        return values[cell] + t * rise + t * (1.0 - t) * (a * (1.0 - t) + b * t)
    total = 0.0
    for part in range(sills.size):
        scaled = distance * rates[part]
        total += sills[part] * (1.0 + scaled) * np.exp(-scaled)
    return total


@compiled
def _solve_neighbourhoods(
    first, last, _, known, shifts, near, places, table, found, variances
):
    n_near = near.shape[1]
    factor = np.empty((n_near, n_near))
    to_place, to_mean = np.empty(n_near), np.empty(n_near)
    variance = table[3]
    east, north = np.empty(n_near), np.empty(n_near)
    for row in range(first, last):
        for i in range(n_near):  # from the place
            east[i] = known[near[row, i], 0] - places[row, 0]
            north[i] = known[near[row, i], 1] - places[row, 1]
            for j in range(i):
                factor[i, j] = _covariance(
                    east[i] - east[j], north[i] - north[j], table
                )
            factor[i, i] = variance
            to_place[i] = _covariance(east[i], north[i], table)
            to_mean[i] = 1.0
        _factorize(factor, FLATTEST * variance)
        _forward(factor, to_place)
        _forward(factor, to_mean)
        both, mean = _product(to_place, to_mean), _product(to_mean, to_mean)
        lacking = 1.0 - both
        variances[row] = variance - _product(to_place, to_place) + lacking**2 / mean
        for i in range(n_near):
            to_place[i] += lacking / mean * to_mean[i]
        _backward(factor, to_place)
        for axis in range(2):
            total = 0.0
            for i in range(n_near):
                total += to_place[i] * shifts[near[row, i], axis]
            found[row, axis] = total


@compiled
def _product(one, other):
    total = 0.0
    for i in range(one.size):
        total += one[i] * other[i]
    return total


@compiled
def _factorize(matrix, least):
    """Cholesky factor in the lower triangle."""
    for i in range(matrix.shape[0]):
        for j in range(i + 1):
            rest = matrix[i, j]
            for k in range(j):
                rest -= matrix[i, k] * matrix[j, k]
            if i == j:
                matrix[i, i] = np.sqrt(max(rest, least))
            else:
                matrix[i, j] = rest / matrix[j, j]


@compiled
def _forward(factor, right):
    for i in range(right.size):
        for k in range(i):
            right[i] -= factor[i, k] * right[k]
        right[i] /= factor[i, i]


@compiled
def _backward(factor, right):
    for i in range(right.size - 1, -1, -1):
        for k in range(i + 1, right.size):
            right[i] -= factor[k, i] * right[k]
        right[i] /= factor[i, i]
