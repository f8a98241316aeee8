"""Covariances of many points that follow from few numbers, in bundles of some.

The values of a model depend on its parameters, a handful of numbers, and these on all
points of the model, on the high flight and on control. So the covariances of values are
those of parameters of the same and of neighbouring models, of which there are far
fewer: each is computed once, from long rows, and enters many pairs of points through
rows of a few numbers.

See docs/theory/propagation.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from einschalt.foundations.batches import over_segments, segment_sum, used_places
from einschalt.foundations.kernels import compiled
from einschalt.theory.adjustment.joint_covariance import BundlePairs
from einschalt.theory.adjustment.point_operator import (
    Axes,
    of_real_axes,
)

NUMBERS_OF_TABLE = 10_000_000  # of pairs of bundles, a byte each
PAIRS_AT_ONCE = 200_000


@dataclass(frozen=True, eq=False)
class BundledRows:
    """Rows of points that depend on few bundles of numbers.

    Columns that the same points depend on stand together: the parameters of a model.
    """

    rows: sparse.bsr_array  # blocks (n_axes, size) of a point and a bundle
    axes: Axes

    @classmethod
    def of(cls, operator, size):
        """Rows of a PointOperator, by bundles of ``size`` numbers."""
        axes = operator.axes
        blocks = sparse.bsr_array(
            sparse.csr_array(operator.matrix), blocksize=(axes.value, size)
        )
        blocks.sort_indices()
        return cls(blocks, axes)

    @property
    def size(self):
        """How many numbers stand in a bundle."""
        return self.rows.blocksize[1]

    def neighbours(self, pairs):
        """Which bundles meet in pairs of points, (n_pairs, 2): BundlePairs."""
        rows, n_bundles = self.rows, self.rows.shape[1] // self.size
        # of values: a table is filled more quickly than a product is formed
        if n_bundles**2 <= NUMBERS_OF_TABLE and (np.diff(rows.indptr) == 1).all():
            is_met = np.zeros((n_bundles, n_bundles), dtype=bool)
            is_met[tuple(rows.indices[pairs].T)] = True
            return BundlePairs.of(is_met | is_met.T)
        is_held = np.ones(len(rows.indices), dtype=bool)
        shape = self.axes.count(rows.shape[0]), n_bundles
        held = sparse.csr_array((is_held, rows.indices, rows.indptr), shape=shape)
        first, second = pairs.T
        if np.array_equal(first, second):
            met = held[used_places(first, held.shape[0])]
            met = met.T @ met
        else:
            met = sparse.csr_array((n_bundles, n_bundles), dtype=bool)
            for part in np.array_split(pairs, max(1, -(-len(pairs) // PAIRS_AT_ONCE))):
                met = met + held[part[:, 0]].T @ held[part[:, 1]]
            met = met + met.T
        return BundlePairs.of(met)

    def covariances(self, pairs, met, joint, beside=()):
        """Covariances of pairs of points, (n_pairs, n_coordinates, n_coordinates) [m²].

        ``joint`` (n_met, size, size) are those of the bundles that meet in them;
        ``beside`` are BundledRows of covariances of points with bundles, of what does
        not go through these.
        """
        dtypes = [shared.rows.dtype for shared in beside]
        dtype = np.result_type(self._dtype_with(met, joint), *dtypes)
        out = self._none_yet(len(pairs), dtype)
        over_segments(
            _through_bundles,
            np.arange(len(pairs) + 1),
            np.ascontiguousarray(pairs, dtype=np.int64),
            *self._entries(dtype),
            met.pointer,
            met.column,
            joint.astype(dtype, copy=False),
            out,
            work_of_row=self._in_a_row**2,
        )
        for shared in beside:
            self._add_met(shared, pairs, out)
        return self._of_coordinates(out)

    def variances(self, met, joint):
        """Covariances of each point with itself, (n_points, n_coordinates, …) [m²].

        As :meth:`covariances` has them, in a third of the time; ``met`` are the
        neighbours of every point with itself.
        """
        dtype = self._dtype_with(met, joint)
        pointer, *entries = self._entries(dtype)
        out = self._none_yet(len(pointer) - 1, dtype)
        joint = joint.astype(dtype, copy=False)
        given = (*entries, met.pointer, met.column, joint, out)
        work = {"work_of_row": self._in_a_row}
        over_segments(_through_bundles_of_point, pointer, *given, **work)
        return self._of_coordinates(out)

    def covariances_with(self, shared, pairs):
        """What points make of the covariances of points with bundles, for their pairs.

        ``shared`` are BundledRows of these covariances; gives (n_pairs, n_coordinates,
        n_coordinates) [m²], of the first with the second and the second with the first.
        """
        dtype = np.result_type(self.rows.dtype, shared.rows.dtype)
        out = self._none_yet(len(pairs), dtype)
        self._add_met(shared, pairs, out)
        return self._of_coordinates(out)

    def _add_met(self, shared, pairs, out):
        """Add them to covariances of the pairs, (n_pairs, n_axes, n_axes)."""
        over_segments(
            _meet_in_bundles,
            np.arange(len(pairs) + 1),
            np.ascontiguousarray(pairs, dtype=np.int64),
            *self._entries(out.dtype),
            *shared._entries(out.dtype),
            out,
        )

    def _none_yet(self, n_pairs, dtype):
        return np.zeros((n_pairs, self.axes.value, self.axes.value), dtype)

    def _of_coordinates(self, of_axes):
        return of_real_axes(of_axes) if self.axes is Axes.COMPLEX else of_axes

    def _dtype_with(self, met, joint):
        if joint.shape != (len(met), self.size, self.size):
            wanted = len(met), self.size, self.size
            raise ValueError(f"joint is {joint.shape}; expected {wanted}")
        return np.result_type(self.rows.dtype, joint)

    def independent_variances(self, met, joint):
        """Sums of a point's variances if parameters were independent (n_points,) [m²].

        What a variance has been computed from: far less than that is rounding.
        """
        every = np.arange(len(met.pointer) - 1)
        # bundles that no point uses do not meet themselves
        is_used = np.diff(met.pointer) > 0
        of_bundle = np.zeros((len(every), self.size))
        own = np.diagonal(joint[met.pointer[1:][is_used] - 1], axis1=1, axis2=2)
        of_bundle[is_used] = own.real
        squares = np.square(np.abs(self.rows.data))
        each = np.einsum("nau,nu->n", squares, of_bundle[self.rows.indices])
        return segment_sum(each, self.rows.indptr)

    @property
    def _in_a_row(self):
        """How many bundles a point depends on, on the average."""
        return len(self.rows.indices) * self.axes.value / max(1, self.rows.shape[0])

    def _entries(self, dtype):
        rows = self.rows
        pointer, bundle = (a.astype(np.int64) for a in (rows.indptr, rows.indices))
        return pointer, bundle, rows.data.astype(dtype, copy=False)


def points_in_a_bundle(matrix, axes):
    """How many points, at least one, all rows of a matrix use together.

    Columns are told apart by the rows that use them: by the sum of numbers drawn for
    these. Bundles that are larger or smaller than models give the same covariances.
    """
    blocks = sparse.bsr_array(matrix, blocksize=(axes.value, axes.value))
    n_rows, n_columns = (axes.count(n) for n in matrix.shape)
    mark = np.random.default_rng(0).random(n_rows)
    row = np.repeat(np.arange(n_rows), np.diff(blocks.indptr))
    used = np.bincount(blocks.indices, mark[row], n_columns)
    edges = np.flatnonzero(np.diff(used)) + 1
    return max(1, int(np.gcd.reduce(np.append(edges, n_columns))))


# Sums of small blocks take a third of the time in variables of their own, which stay in
# registers, as in joint_covariance.


@compiled
def _add_through(blocks, later, earlier, joint, met, times, is_turned, out, p):
    """Add, so many times, what comes of a bundle and of an earlier one."""
    n_axes, size = blocks.shape[1:]
    for a in range(n_axes):
        for v in range(size):
            with_other = blocks[later, a, 0] * 0.0
            for u in range(size):
                with_other += blocks[later, a, u] * joint[met, u, v]
            for b in range(n_axes):
                number = times * with_other * np.conj(blocks[earlier, b, v])
                if is_turned:
                    out[p, b, a] += np.conj(number)
                else:
                    out[p, a, b] += number


@compiled
def _through_two(blocks, i, j, joint, met):
    a, b = blocks[i, 0, 0], blocks[i, 0, 1]
    with_a = a * joint[met, 0, 0] + b * joint[met, 1, 0]
    with_b = a * joint[met, 0, 1] + b * joint[met, 1, 1]
    return with_a * np.conj(blocks[j, 0, 0]) + with_b * np.conj(blocks[j, 0, 1])


@compiled
def _through_three(blocks, i, j, joint, met):
    a, b, c = blocks[i, 0, 0], blocks[i, 0, 1], blocks[i, 0, 2]
    with_a = a * joint[met, 0, 0] + b * joint[met, 1, 0] + c * joint[met, 2, 0]
    with_b = a * joint[met, 0, 1] + b * joint[met, 1, 1] + c * joint[met, 2, 1]
    with_c = a * joint[met, 0, 2] + b * joint[met, 1, 2] + c * joint[met, 2, 2]
    a, b, c = blocks[j, 0, 0], blocks[j, 0, 1], blocks[j, 0, 2]
    return with_a * np.conj(a) + with_b * np.conj(b) + with_c * np.conj(c)


@compiled
def _through_bundles(
    first, last, _, pairs, pointer, bundle, blocks, start, column, joint, out
):
    n_axes, size = blocks.shape[1:]
    for p in range(first, last):
        one, two = pairs[p, 0], pairs[p, 1]
        for i in range(pointer[one], pointer[one + 1]):
            for j in range(pointer[two], pointer[two + 1]):
                later, earlier = max(bundle[i], bundle[j]), min(bundle[i], bundle[j])
                met = _place_among(column, start[later], start[later + 1], earlier)
                is_turned = bundle[i] < bundle[j]
                k, m = (j, i) if is_turned else (i, j)
                if n_axes == 1 and size == 3:
                    number = _through_three(blocks, k, m, joint, met)
                    out[p, 0, 0] += np.conj(number) if is_turned else number
                elif n_axes == 1 and size == 2:
                    number = _through_two(blocks, k, m, joint, met)
                    out[p, 0, 0] += np.conj(number) if is_turned else number
                else:
                    _add_through(blocks, k, m, joint, met, 1.0, is_turned, out, p)


@compiled
def _through_bundles_of_point(
    first, last, pointer, bundle, blocks, start, column, joint, out
):
    n_axes, size = blocks.shape[1:]
    for p in range(first, last):
        for i in range(pointer[p], pointer[p + 1]):
            # bundles of a point ascend, as do those that one of them meets
            met = start[bundle[i]]
            for j in range(pointer[p], i + 1):
                while column[met] < bundle[j]:
                    met += 1
                if n_axes == 1 and size == 3:
                    number = _through_three(blocks, i, j, joint, met)
                    out[p, 0, 0] += number if i == j else 2.0 * number
                elif n_axes == 1 and size == 2:
                    number = _through_two(blocks, i, j, joint, met)
                    out[p, 0, 0] += number if i == j else 2.0 * number
                else:
                    times = 1.0 if i == j else 2.0
                    _add_through(blocks, i, j, joint, met, times, False, out, p)
        # of two bundles, each with the other: the mean of what was added twice
        for a in range(n_axes):
            for b in range(a + 1):
                mean = (out[p, a, b] + np.conj(out[p, b, a])) / 2.0
                out[p, a, b], out[p, b, a] = mean, np.conj(mean)


@compiled
def _place_among(ascending, low, high, number):
    """Place of a number that stands among some ascending ones, from low to high."""
    while low < high:
        middle = (low + high) >> 1
        if ascending[middle] < number:
            low = middle + 1
        else:
            high = middle
    return low


@compiled
def _meet_in_bundles(
    first,
    last,
    _,
    pairs,
    pointer,
    bundle,
    blocks,
    shared_pointer,
    shared_bundle,
    shared,
    out,
):
    n_axes, size = blocks.shape[1:]
    for p in range(first, last):
        for turn in range(2):
            row, other = pairs[p, turn], pairs[p, 1 - turn]
            i, last_i = pointer[row], pointer[row + 1]
            j, last_j = shared_pointer[other], shared_pointer[other + 1]
            while i < last_i and j < last_j:
                if bundle[i] < shared_bundle[j]:
                    i += 1
                elif bundle[i] > shared_bundle[j]:
                    j += 1
                else:
                    for a in range(n_axes):
                        for b in range(n_axes):
                            for u in range(size):
                                number = blocks[i, a, u] * np.conj(shared[j, b, u])
                                if turn == 0:
                                    out[p, a, b] += number
                                else:
                                    out[p, b, a] += np.conj(number)
                    i += 1
                    j += 1
