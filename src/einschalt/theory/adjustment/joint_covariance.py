"""Covariances of bundles of numbers, such as the parameters of models, that meet.

Each is computed once, from long rows of errors, however many points depend on it.

See docs/theory/propagation.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from einschalt.foundations.batches import numbered, over_segments
from einschalt.foundations.kernels import compiled

NUMBERS_OF_WHOLE = 10_000_000  # of a full matrix, of which there are three: 0.5 GB
QUICKER_AS_A_WHOLE = 20  # what a product of full matrices takes less, by the number
IN_REGISTERS = (2, 1), (3, 1)  # blocks that are summed there, see _joint_of_pairs


@dataclass(frozen=True, eq=False)
class BundlePairs:
    """Pairs of bundles, the later one first, sorted."""

    pointer: np.ndarray  # (n_bundles + 1,): first pair of each later one
    column: np.ndarray  # (n_pairs,): the earlier one, or the same

    @classmethod
    def of(cls, is_met):
        """Pairs of a symmetric matrix (n_bundles, n_bundles), full or sparse."""
        met = sparse.csr_array(sparse.tril(is_met, format="csr"))
        met.sort_indices()
        return cls(met.indptr.astype(np.int64), met.indices.astype(np.int64))

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


# Sums of small blocks take a third of the time in variables of their own, which stay in
# registers: those of conformal models, two complex numbers, and of affine ones, three
# real numbers, of points with one axis, are nearly all.


@compiled
def _joint_of_pairs(
    first, last, start, column, pointer, source, n_sources, blocks, out
):
    size, n_axes = blocks.shape[1:]
    # where the source of the later bundle stands: it meets many, one after the other
    place = np.empty(n_sources, dtype=np.int64)
    place[:] = -1
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
