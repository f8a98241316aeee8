"""A covariance function for collocation, estimated from the shifts themselves.

How much alike the shifts of two points are depends on their distance: a sum of Matérn
functions of several ranges, and a nugget, the part of each point that its neighbours do
not share. Not one range is chosen, but shares of a ladder of ranges, by non-negative
least squares: nothing has to be started or tuned, and every sum is a valid function.

See docs/theory/collocation.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls
from scipy.spatial import KDTree

N_RANGES = 8
N_LAGS = 24
N_NEIGHBOURS = 32
MOST_CENTRES = 2_000
N_FAR_PAIRS = 10_000
LEAST_PAIRS = 20  # of a class of distances
WEIGHED = 2_000  # pairs beyond which a class gets no more weight
ROUNDS = 3
SEED = 0  # which pairs are compared must be the same in every run
# share of the variance that is noise at least, so that no system is singular
LEAST_NOISE = 1e-8


@dataclass(frozen=True, eq=False)
class CovarianceFunction:
    """Covariance of the shifts of two points, per coordinate [m²].

    >>> function = CovarianceFunction(0.01, np.array([1.0]), np.array([100.0]))
    >>> function(np.array([0.0, 100.0])).round(3).tolist()
    [1.0, 0.483]
    """

    nugget: float  # of each point by itself, its noise
    # sills, ranges: (n,): the parts √(3)-Matérn of order 3/2, and their ranges [m]
    sills: np.ndarray
    ranges: np.ndarray

    def __call__(self, distance):
        """Covariance at distances [m], without the nugget."""
        return _matern(distance, self.ranges) @ self.sills

    def slope(self, distance):
        """Derivative of the covariance at distances [m]."""
        scaled = np.sqrt(3.0) * np.asarray(distance)[..., None] / self.ranges
        return (-np.sqrt(3.0) / self.ranges * scaled * np.exp(-scaled)) @ self.sills

    @property
    def half_range(self):
        """Distance at which the covariance has fallen to half [m]; NaN without any."""
        if not len(self.ranges):
            return np.nan
        distance = np.geomspace(self.ranges[0] / 10.0, 10.0 * self.ranges[-1], 400)
        fallen = self(distance) <= self.sills.sum() / 2.0
        return float(distance[fallen.argmax()])

    @property
    def variance(self):
        """Of one point, with its noise [m²]."""
        return self.nugget + float(self.sills.sum())


def _matern(distance, ranges):
    """Matérn functions of order 3/2, (n_distances, n_ranges): smooth at zero."""
    scaled = np.sqrt(3.0) * np.asarray(distance)[..., None] / ranges
    return (1.0 + scaled) * np.exp(-scaled)


def estimate_covariance(xy, shifts):
    """Estimate the covariance function of shifts (n_points, 2) [m] at places xy.

    From half squared differences of pairs by classes of distance, in both coordinates
    together; their fourth roots are averaged, so that a few wrong points count little
    (Cressie and Hawkins 1980).
    """
    lag, half_square, count = variogram(xy, shifts)
    known = half_square > 0.0
    if known.sum() < 2:  # all shifts alike, or too few points to tell
        size = float(np.var(shifts, axis=0).mean())
        return _with_noise(size, np.empty(0), np.empty(0))
    lag, half_square, count = lag[known], half_square[known], count[known]
    ranges = np.geomspace(lag[0], 1.5 * lag[-1], N_RANGES)
    design = np.column_stack([np.ones_like(lag), 1.0 - _matern(lag, ranges)])
    importance = np.sqrt(np.minimum(count, WEIGHED))
    fitted = half_square
    for _ in range(ROUNDS):  # a class is known to a share of its value
        weight = importance / np.maximum(fitted, 1e-9 * half_square.max())
        shares = nnls(design * weight[:, None], half_square * weight)[0]
        fitted = design @ shares
    part = shares[1:] > 0.0
    return _with_noise(shares[0], shares[1:][part], ranges[part])


def _with_noise(nugget, sills, ranges):
    least = LEAST_NOISE * (nugget + sills.sum())
    return CovarianceFunction(max(float(nugget), least, 1e-14), sills, ranges)


def variogram(xy, shifts):
    """Half squared differences of shifts by classes of distance.

    Returns
    -------
    lag, half_square, count : ndarray
        Of each class: mean distance [m], mean per coordinate [m²], number of pairs.
    """
    one, other = _pairs(xy)
    away = xy[one] - xy[other]
    distance = np.hypot(*away.T)
    roots = np.sqrt(np.abs(shifts[one] - shifts[other]))
    positive = distance[distance > 0.0]
    if not len(positive):
        return (np.empty(0),) * 3
    low, high = np.quantile(positive, 0.001), positive.max() / 2.0
    edges = np.concatenate([[0.0], np.geomspace(min(low, high / 2.0), high, N_LAGS)])
    lag_class = np.digitize(distance, edges) - 1
    inside = lag_class < N_LAGS
    count = np.bincount(lag_class[inside], minlength=N_LAGS)
    full = count >= min(LEAST_PAIRS, max(2, len(xy) // 2))

    def mean(values):
        return (
            np.bincount(lag_class[inside], values[inside], N_LAGS)[full] / count[full]
        )

    correction = 2.0 * (0.457 + 0.494 / count[full])
    squares = sum(mean(roots[:, axis]) ** 4 for axis in range(2)) / 2.0
    return mean(distance), squares / correction, count[full]


def _pairs(xy):
    """Pairs of neighbours, and as many at any distance."""
    n_points = len(xy)
    rng = np.random.default_rng(SEED)
    centres = rng.permutation(n_points)[:MOST_CENTRES]
    n_near = min(n_points - 1, N_NEIGHBOURS)
    near = KDTree(xy).query(xy[centres], np.arange(2, n_near + 2))[1]
    far = rng.integers(0, n_points, (2, N_FAR_PAIRS))
    far = far[:, far[0] != far[1]]
    one = np.concatenate([np.repeat(centres, n_near), far[0]])
    return one, np.concatenate([near.ravel(), far[1]])
