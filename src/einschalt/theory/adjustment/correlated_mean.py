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

from einschalt.foundations.batches import over_segments
from einschalt.foundations.kernels import compiled
from einschalt.theory.adjustment.point_operator import of_real_axes

# of the mean variance: differences with less do not tell anything
LEAST_VARIANCE = 1e-10
# of the largest variance: what is not known counts for nothing beside what is
UNKNOWN_VARIANCE = 1e4


@dataclass(frozen=True, eq=False)
class JointCovariance:
    """Covariances between all values of each point.

    A value whose variance is NaN counts only where all others are not known either.
    """

    blocks: np.ndarray  # (n_pairs, d, d), in the order of pairs_of_values [m²]
    # (n_points + 1,): first value of each point, values sorted by point
    start: np.ndarray

    def shares(self, order, start):
        """Shares of values in the mean of each group of them, (n, d, d).

        Matrices by which the values are multiplied; those of a group add up to the unit
        matrix. Of values that share all errors they are alike.
        ``order`` (n,) has places among the sorted values, group after group; those of a
        group belong to one point.
        """
        within = _places_within(self.start)
        # shares of each coordinate alone, or of both as one number, are found sooner
        blocks = _of_one_number(self.blocks)
        found = np.empty((len(order), *blocks.shape[1:]), blocks.dtype)
        over_segments(
            _share_out,
            np.ascontiguousarray(start, dtype=np.int64),
            np.ascontiguousarray(order, dtype=np.int64),
            within,
            np.cumsum(within + 1) - (within + 1),
            np.ascontiguousarray(blocks),
            found,
            # a system of equations for each point, as large as it has values
            work_of_row=(len(order) / max(1, len(start) - 1)) ** 2,
        )
        if np.iscomplexobj(found):
            return of_real_axes(found)
        is_of_one = found.shape[1:] != self.blocks.shape[1:]
        return found * np.eye(self.blocks.shape[1]) if is_of_one else found


def _of_one_number(blocks):
    """Give blocks (n, d, d) as one number each, (n, 1, 1), if that tells all of them.

    Multiples of the unit matrix, as those of affine models, by this number; what turns
    and scales a plane, as of conformal models, by a complex one.
    """
    first = blocks[:, :1, :1]
    d = blocks.shape[1]
    entries = {(a, b): blocks[:, a, b] for a, b in np.ndindex(d, d)}
    if not all(np.array_equal(entries[a, a], entries[0, 0]) for a in range(1, d)):
        return np.asarray(blocks, dtype=float)
    if not any(entries[a, b].any() for a, b in entries if a != b):
        return np.asarray(first, dtype=float)
    if d == 2 and np.array_equal(entries[0, 1], -entries[1, 0]):
        return first + 1j * blocks[:, 1:, :1]
    return np.asarray(blocks, dtype=float)


@compiled
def _share_out(first, last, start, order, within, first_pair, blocks, shares):
    d, most = blocks.shape[1], 1
    for group in range(first, last):
        most = max(most, start[group + 1] - start[group])
    joint = np.empty((most * d, most * d), dtype=blocks.dtype)
    # of contrasts: of value j, and of those before it
    unit = np.empty(most)
    for later in range(most):
        unit[later] = 1.0 / np.sqrt(max(1.0, later * (later + 1.0)))
    for group in range(first, last):
        if start[group + 1] == start[group]:
            continue
        values = order[start[group] : start[group + 1]]
        _fill_joint(joint, values, within, first_pair, blocks)
        _share(joint, unit, shares[start[group] : start[group + 1]])


@compiled
def _fill_joint(joint, values, within, first_pair, blocks):
    """Covariance of some values of one point; large where it is not known."""
    k, d = len(values), blocks.shape[1]
    largest = 0.0
    for i in range(k):
        for j in range(k):
            later, earlier = max(values[i], values[j]), min(values[i], values[j])
            block = blocks[first_pair[later] + within[earlier]]
            is_turned = values[i] < values[j]
            for a in range(d):
                for b in range(d):
                    entry = np.conj(block[b, a]) if is_turned else block[a, b]
                    joint[i * d + a, j * d + b] = entry
        for a in range(d):
            variance = np.real(joint[i * d + a, i * d + a])
            if np.isfinite(variance):
                largest = max(largest, variance)
    unknown = UNKNOWN_VARIANCE * (largest if largest > 0.0 else 1.0)
    for row in range(k * d):
        if not np.isfinite(np.real(joint[row, row])):
            joint[row, : k * d] = 0.0
            joint[: k * d, row] = 0.0
            joint[row, row] = unknown


@compiled
def _share(joint, unit, shares):
    """Plain mean, less what the contrasts of the values tell of its error.

    Orthonormal contrasts (Helmert's): value j against the mean of those before it.
    """
    k, d = shares.shape[:2]
    size, of_mean = k * d, 1.0 / np.sqrt(k)
    scale = 0.0
    for row in range(size):
        scale += np.real(joint[row, row])
    scale /= size
    least = LEAST_VARIANCE * (scale if scale > 0.0 else 1.0)
    for column in range(size):
        _to_contrasts(joint[:size, column], unit, k, d)
    for row in range(size):
        _to_contrasts(joint[row, :size], unit, k, d)
    for row in range(d, size):
        joint[row, row] += least
    _eliminate(joint, d, size)
    for b in range(d):
        _from_contrasts(joint[:size, b], unit, k, d)
        for i in range(k):
            for a in range(d):
                even = 1.0 / k if a == b else 0.0
                shares[i, b, a] = even - of_mean * np.conj(joint[i * d + a, b])


@compiled
def _to_contrasts(numbers, unit, k, d):
    for a in range(d):
        total = numbers[a]
        for j in range(1, k):
            own = numbers[j * d + a]
            numbers[j * d + a] = unit[j] * (total - j * own)
            total += own
        numbers[a] = total / np.sqrt(k)


@compiled
def _from_contrasts(numbers, unit, k, d):
    """From contrasts to values whose sum is 0."""
    for a in range(d):
        later = 0.0
        for j in range(k - 1, 0, -1):
            own = unit[j] * numbers[j * d + a]
            numbers[j * d + a] = later - j * own
            later += own
        numbers[a] = later


@compiled
def _eliminate(matrix, d, size):
    """Solve for the first d columns, from row d on, of what is Hermitian there.

    Positive definite, so that any pivot will do; what stands below the diagonal is not
    looked at.
    """
    for p in range(d, size):
        for row in range(p + 1, size):
            factor = np.conj(matrix[p, row]) / matrix[p, p]
            for column in range(row, size):
                matrix[row, column] -= factor * matrix[p, column]
            for column in range(d):
                matrix[row, column] -= factor * matrix[p, column]
    for p in range(size - 1, d - 1, -1):
        for column in range(d):
            total = matrix[p, column]
            for other in range(p + 1, size):
                total -= matrix[p, other] * matrix[other, column]
            matrix[p, column] = total / matrix[p, p]


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
    in_plan = shares[:, :2, :2]
    return np.einsum("nab,nab->n", in_plan, in_plan) / 2.0
