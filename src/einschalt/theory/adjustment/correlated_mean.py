"""Mean of several values of one point that have a joint covariance.

With values x_1 … x_k of a point, each a vector, and their covariance C, the mean of
least variance is

    x̄ = (Eᵀ C⁻¹ E)⁻¹ Eᵀ C⁻¹ x,

E being k unit matrices below each other. C has no inverse where values share all their
errors. So the mean is formed as the plain mean less what the differences of the values
tell of its error: the same where C has an inverse, and always defined. The shares of
the values are matrices that add up to the unit matrix, so that the mean does not depend
on the direction of the axes.

Source: Aitken 1935; Rao 1973, section 4a; see docs/theory/double_coverage.md.
"""

from dataclasses import dataclass

import numpy as np

# of the mean variance: differences with less do not tell anything
LEAST_VARIANCE = 1e-10
# of the largest variance: what is not known counts for nothing beside what is
UNKNOWN_VARIANCE = 1e4
NUMBERS_AT_ONCE = 2_000_000


def best_shares(covariance):
    """Shares of the values of points in the mean of least variance.

    Parameters
    ----------
    covariance : ndarray, shape (n_points, k, k, d, d)
        Of the k values of each point, each of d coordinates [m²]. A value whose
        variance is NaN counts only where all others are not known either.

    Returns
    -------
    ndarray, shape (n_points, k, d, d)
        Matrices by which the values are multiplied; those of a point add up to the
        unit matrix. Of values that share all errors they are alike.
    """
    n_points, k, _, d, _ = covariance.shape
    if k == 1:
        return np.tile(np.eye(d), (n_points, 1, 1, 1))
    matrix = covariance.transpose(0, 1, 3, 2, 4).reshape(n_points, k * d, k * d)
    matrix = _with_known_variances(matrix)
    even = np.tile(np.eye(d), (k, 1)) / k
    common = even @ np.tile(np.eye(d), (1, k))
    away = np.eye(k * d) - common
    of_differences = away @ matrix @ away
    size = np.trace(matrix, axis1=1, axis2=2) / (k * d)
    size = np.where(size > 0.0, size, 1.0)[:, None, None]
    regular = of_differences + size * (common + LEAST_VARIANCE * np.eye(k * d))
    predicted = away @ np.linalg.solve(regular, away @ matrix @ even)
    return (even - predicted).reshape(n_points, k, d, d).swapaxes(2, 3)


def _with_known_variances(matrix):
    """Put a large variance in the place of those that are not known."""
    variance = np.diagonal(matrix, axis1=1, axis2=2)
    is_known = np.isfinite(variance)
    if is_known.all():
        return matrix
    largest = np.max(np.where(is_known, variance, 0.0), axis=1, keepdims=True)
    unknown = UNKNOWN_VARIANCE * np.where(largest > 0.0, largest, 1.0)
    is_pair = is_known[:, :, None] & is_known[:, None, :]
    large = np.where(is_known, 0.0, unknown)[:, :, None] * np.eye(matrix.shape[1])
    return np.where(is_pair, matrix, large)


@dataclass(frozen=True, eq=False)
class JointCovariance:
    """Covariances between all values of each point."""

    blocks: np.ndarray  # (n_pairs, d, d), in the order of pairs_of_values [m²]
    # (n_points + 1,): first value of each point, values sorted by point
    start: np.ndarray

    def among(self, values):
        """Covariances between k values of each of some points [m²].

        ``values`` (n_groups, k) are places among the sorted values, a row for each
        point. Of the shape (n_groups, k, k, d, d).
        """
        within = _places_within(self.start)
        first_pair = np.cumsum(within + 1) - (within + 1)
        row, column = values[:, :, None], values[:, None, :]
        later, earlier = np.maximum(row, column), np.minimum(row, column)
        found = self.blocks[first_pair[later] + within[earlier]]
        is_turned = (row < column)[..., None, None]
        return np.where(is_turned, found.swapaxes(-1, -2), found)

    def shares(self, order, start):
        """Shares of values in the mean of each group of them, (n, d, d).

        ``order`` (n,) has places among the sorted values, group after group; those of a
        group belong to one point.
        """
        d, count = self.blocks.shape[-1], np.diff(start)
        found = np.empty((len(order), d, d))
        for k in np.unique(count):
            groups = np.flatnonzero(count == k)
            n_parts = max(1, len(groups) * (k * d) ** 2 // NUMBERS_AT_ONCE)
            for part in np.array_split(groups, n_parts):
                places = start[part][:, None] + np.arange(k)
                found[places] = best_shares(self.among(order[places]))
        return found


def pairs_of_values(start):
    """All pairs of values of the same point, each value with itself among them.

    ``start`` (n_points + 1,) is the first value of each point. Places among the sorted
    values, (n_pairs, 2), the later one first.

    >>> pairs_of_values(np.array([0, 2, 3])).tolist()
    [[0, 0], [1, 0], [1, 1], [2, 2]]
    """
    within = _places_within(start)
    later = np.repeat(np.arange(len(within)), within + 1)
    first_pair = np.cumsum(within + 1) - (within + 1)
    other = np.arange(len(later)) - first_pair[later]
    return np.column_stack([later, later - within[later] + other])


def _places_within(start):
    """Place of each value among those of its point."""
    return np.arange(start[-1]) - np.repeat(start[:-1], np.diff(start))


def times(shares, vectors):
    """Vectors (n, d) multiplied by their shares: numbers (n,) or matrices (n, d, d)."""
    if shares.ndim == 1:
        return shares[:, None] * vectors
    return np.einsum("nab,nb->na", shares, vectors)


def squared_sizes(shares):
    """Factors by which shares change the variance of points in plan.

    Of the TOTAL variance, where errors are alike in easting and northing.
    """
    if shares.ndim == 1:
        return shares**2
    return np.sum(shares[:, :2, :2] ** 2, axis=(1, 2)) / 2.0
