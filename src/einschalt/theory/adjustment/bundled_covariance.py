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

from einschalt.foundations.batches import numbered, over_segments, segment_sum
from einschalt.foundations.kernels import compiled
from einschalt.theory.adjustment.point_operator import (
    Axes,
    of_real_axes,
)

NUMBERS_OF_WHOLE = 10_000_000  # of a full matrix, of which there are three: 0.5 GB
QUICKER_AS_A_WHOLE = 20  # what a product of full matrices takes less, by the number
PAIRS_AT_ONCE = 200_000
IN_REGISTERS = (2, 1), (3, 1)  # blocks that are summed there, see _joint_of_pairs


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
        rows = self.rows
        shape = rows.shape[0] // self.axes.value, rows.shape[1] // self.size
        is_held = np.ones(len(rows.indices), dtype=bool)
        held = sparse.csr_array((is_held, rows.indices, rows.indptr), shape=shape)
        first, second = pairs.T
        if np.array_equal(first, second):
            met = held[np.unique(first)]
            met = met.T @ met
        else:
            met = sparse.csr_array((shape[1], shape[1]), dtype=bool)
            for part in np.array_split(pairs, max(1, -(-len(pairs) // PAIRS_AT_ONCE))):
                met = met + held[part[:, 0]].T @ held[part[:, 1]]
            met = met + met.T
        met = sparse.tril(met, format="csr")
        met.sort_indices()
        return BundlePairs(met.indptr.astype(np.int64), met.indices.astype(np.int64))

    def covariances(self, pairs, met, joint):
        """Covariances of pairs of points, (n_pairs, n_coordinates, n_coordinates) [m²].

        ``joint`` (n_met, size, size) are those of the bundles that meet in them.
        """
        dtype = self._dtype_with(met, joint)
        out = np.zeros((len(pairs), self.axes.value, self.axes.value), dtype)
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
        return of_real_axes(out) if self.axes is Axes.COMPLEX else out

    def variances(self, met, joint):
        """Covariances of each point with itself, (n_points, n_coordinates, …) [m²].

        As :meth:`covariances` has them, in a third of the time; ``met`` are the
        neighbours of every point with itself.
        """
        dtype = self._dtype_with(met, joint)
        pointer, *entries = self._entries(dtype)
        n_points, n_axes = len(pointer) - 1, self.axes.value
        out = np.zeros((n_points, n_axes, n_axes), dtype)
        joint = joint.astype(dtype, copy=False)
        given = (*entries, met.pointer, met.column, joint, out)
        work = {"work_of_row": self._in_a_row}
        over_segments(_through_bundles_of_point, pointer, *given, **work)
        return of_real_axes(out) if self.axes is Axes.COMPLEX else out

    def _dtype_with(self, met, joint):
        if joint.shape != (len(met), self.size, self.size):
            wanted = len(met), self.size, self.size
            raise ValueError(f"joint is {joint.shape}; expected {wanted}")
        return np.result_type(self.rows.dtype, joint)

    def covariances_with(self, shared, pairs):
        """What points make of the covariances of points with bundles, for their pairs.

        ``shared`` are BundledRows of these covariances; gives (n_pairs, n_coordinates,
        n_coordinates) [m²], of the first with the second and the second with the first.
        """
        dtype = np.result_type(self.rows.dtype, shared.rows.dtype)
        out = np.zeros((len(pairs), self.axes.value, self.axes.value), dtype)
        over_segments(
            _meet_in_bundles,
            np.arange(len(pairs) + 1),
            np.ascontiguousarray(pairs, dtype=np.int64),
            *self._entries(dtype),
            *shared._entries(dtype),
            out,
        )
        return of_real_axes(out) if self.axes is Axes.COMPLEX else out

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


@dataclass(frozen=True, eq=False)
class BundlePairs:
    """Pairs of bundles, the later one first, sorted."""

    pointer: np.ndarray  # (n_bundles + 1,): first pair of each later one
    column: np.ndarray  # (n_pairs,): the earlier one, or the same

    def __len__(self):
        return len(self.column)

    @property
    def _keys(self):
        later = np.repeat(np.arange(len(self.pointer) - 1), np.diff(self.pointer))
        return later * (len(self.pointer) - 1) + self.column

    def alone(self):
        """The bundles that meet any, and their pairs, numbered without the others.

        >>> bundles, pairs = BundlePairs(np.array([0, 0, 1, 1]), np.array([1])).alone()
        >>> bundles, pairs.pointer, pairs.column
        (array([1]), array([0, 1]), array([0]))
        """
        is_among = np.diff(self.pointer) > 0
        is_among[self.column] = True
        bundles = np.flatnonzero(is_among)
        pointer = np.append(self.pointer[bundles], len(self))
        return bundles, BundlePairs(pointer, (np.cumsum(is_among) - 1)[self.column])

    def places_of(self, others):
        """Where other pairs of the same bundles stand; None if one is not among these.

        >>> both = BundlePairs(np.array([0, 1, 3]), np.array([0, 0, 1]))
        >>> both.places_of(BundlePairs(np.array([0, 0, 1]), np.array([0]))).tolist()
        [1]
        """
        own, asked = self._keys, others._keys
        places = np.searchsorted(own, asked)
        # the largest one may stand beyond the end
        is_among = np.append(own, -1)[places] == asked
        return places if is_among.all() else None


def joint_covariance(operator, met, size, standard_errors):
    """Covariances of pairs of bundles from independent errors, (n_met, size, size).

    Parameters
    ----------
    operator : PointOperator
        Leads to the numbers of all bundles; quickest of blocks with ``size`` rows.
    met : BundlePairs
    size : int
    standard_errors : ndarray, shape (n_sources,) or (n_sources, n_axes)
        Per coordinate [m].
    """
    each = operator.axes.each(standard_errors)
    blocks = sparse.bsr_array(operator.matrix, blocksize=(size, operator.axes.value))
    scaled = blocks.data * each[blocks.indices][:, None]
    if blocks.blocksize not in IN_REGISTERS:
        rows = _full_if_quicker(blocks, scaled, met)
        if rows is not None:
            return _of_whole(rows, met, size)
    out = np.zeros((len(met), size, size), dtype=scaled.dtype)
    rows = blocks.indptr.astype(np.int64), blocks.indices.astype(np.int64)
    given = (*rows, len(each), scaled, out)
    in_a_bundle = len(blocks.indices) * size / max(1, blocks.shape[0])
    work = {"work_of_row": in_a_bundle}
    over_segments(_joint_of_pairs, met.pointer, met.column, *given, **work)
    return out


def _full_if_quicker(blocks, scaled, met):
    """Rows as a full matrix of the sources they use, if its product is quicker.

    Where enough entries are filled, and bundles meet; None otherwise, and of numbers
    that are none, of which pairs of other bundles know nothing.
    """
    sources, source = numbered(blocks.indices)
    (n_rows, _), (size, n_axes) = blocks.shape, blocks.blocksize
    n_columns = len(sources) * n_axes
    of_pairs = len(met) * blocks.nnz * size**2 / max(1, n_rows)
    is_small = n_rows * max(n_rows, n_columns) <= NUMBERS_OF_WHOLE
    is_quicker = n_rows**2 * n_columns < QUICKER_AS_A_WHOLE * of_pairs
    if not (is_small and is_quicker and np.isfinite(scaled).all()):
        return None
    n_bundles = n_rows // size
    rows = np.zeros((n_bundles, size, len(sources), n_axes), scaled.dtype)
    rows[np.repeat(np.arange(n_bundles), np.diff(blocks.indptr)), :, source] = scaled
    return rows.reshape(n_rows, n_columns)


def _of_whole(rows, met, size):
    n_bundles = len(rows) // size
    later = np.repeat(np.arange(n_bundles), np.diff(met.pointer))
    others = rows.conj() if np.iscomplexobj(rows) else rows
    whole = (rows @ others.T).reshape(n_bundles, size, n_bundles, size)
    return whole[later, :, met.column]


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
# registers: those of conformal models, two complex numbers, and of affine ones, three
# real numbers, of points with one axis, are nearly all.


@compiled
def _joint_of_pairs(
    first, last, start, column, pointer, source, n_sources, blocks, out
):
    size, n_axes = blocks.shape[1:]
    # where the source of the later bundle stands: it meets many, one after the other
    place = np.full(n_sources, -1)
    for later in range(first, last):
        for i in range(pointer[later], pointer[later + 1]):
            place[source[i]] = i
        for p in range(start[later], start[later + 1]):
            low, high = pointer[column[p]], pointer[column[p] + 1]
            if n_axes == 1 and size == 2:
                _join_two(place, source, low, high, blocks, out, p)
            elif n_axes == 1 and size == 3:
                _join_three(place, source, low, high, blocks, out, p)
            else:
                _join(place, source, low, high, blocks, out, p)
        for i in range(pointer[later], pointer[later + 1]):
            place[source[i]] = -1


@compiled
def _join(place, source, low, high, blocks, out, p):
    """Add the products of a bundle, whose sources are in place, with another one."""
    size, n_axes = blocks.shape[1:]
    for j in range(low, high):
        i = place[source[j]]
        if i < 0:
            continue
        for c in range(n_axes):
            for a in range(size):
                for b in range(size):
                    out[p, a, b] += blocks[i, a, c] * np.conj(blocks[j, b, c])


@compiled
def _join_two(place, source, low, high, blocks, out, p):
    aa = ab = ba = bb = out[p, 0, 0]
    for j in range(low, high):
        i = place[source[j]]
        if i < 0:
            continue
        a, b = blocks[i, 0, 0], blocks[i, 1, 0]
        with_a, with_b = np.conj(blocks[j, 0, 0]), np.conj(blocks[j, 1, 0])
        aa, ab = aa + a * with_a, ab + a * with_b
        ba, bb = ba + b * with_a, bb + b * with_b
    out[p, 0, 0], out[p, 0, 1], out[p, 1, 0], out[p, 1, 1] = aa, ab, ba, bb


@compiled
def _join_three(place, source, low, high, blocks, out, p):
    aa = ab = ac = ba = bb = bc = ca = cb = cc = out[p, 0, 0]
    for j in range(low, high):
        i = place[source[j]]
        if i < 0:
            continue
        a, b, c = blocks[i, 0, 0], blocks[i, 1, 0], blocks[i, 2, 0]
        with_a, with_b = np.conj(blocks[j, 0, 0]), np.conj(blocks[j, 1, 0])
        with_c = np.conj(blocks[j, 2, 0])
        aa, ab, ac = aa + a * with_a, ab + a * with_b, ac + a * with_c
        ba, bb, bc = ba + b * with_a, bb + b * with_b, bc + b * with_c
        ca, cb, cc = ca + c * with_a, cb + c * with_b, cc + c * with_c
    out[p, 0, 0], out[p, 0, 1], out[p, 0, 2] = aa, ab, ac
    out[p, 1, 0], out[p, 1, 1], out[p, 1, 2] = ba, bb, bc
    out[p, 2, 0], out[p, 2, 1], out[p, 2, 2] = ca, cb, cc


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
                for a in range(n_axes):
                    for v in range(size):
                        with_other = blocks[i, a, 0] * 0.0
                        for u in range(size):
                            if is_turned:
                                shared = np.conj(joint[met, v, u])
                            else:
                                shared = joint[met, u, v]
                            with_other += blocks[i, a, u] * shared
                        for b in range(n_axes):
                            out[p, a, b] += with_other * np.conj(blocks[j, b, v])


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
                times = 1.0 if i == j else 2.0
                for a in range(n_axes):
                    for v in range(size):
                        with_other = blocks[i, a, 0] * 0.0
                        for u in range(size):
                            with_other += blocks[i, a, u] * joint[met, u, v]
                        for b in range(n_axes):
                            number = with_other * np.conj(blocks[j, b, v])
                            out[p, a, b] += times * number
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
