"""Sums of two products of sparse matrices, formed at once, in blocks of rows.

The parameters of a model depend on the same points: their rows have the same gaps, and
a block of them is multiplied as one. Errors that reach them in two ways, as those of
control by the models that it places and by its own values, make two products.

See docs/theory/propagation.md.
"""

from typing import NamedTuple

import numpy as np
from scipy import sparse

from einschalt.foundations.batches import over_segments
from einschalt.foundations.kernels import compiled

# pairs of blocks that are multiplied: for fewer the kernels are not worth loading
WORTH_A_KERNEL = 100_000


class Product(NamedTuple):
    """Rows in blocks, times a matrix; not formed."""

    rows: sparse.bsr_array  # blocks (size, n_axes)
    matrix: sparse.bsr_array  # blocks (n_axes, n_axes)

    @classmethod
    def of(cls, rows, matrix):
        """With the matrix in blocks that fit those of the rows."""
        n_axes = rows.blocksize[1]
        return cls(rows, sparse.bsr_array(matrix, blocksize=(n_axes, n_axes)))

    @property
    def work(self):
        """How many pairs of blocks are multiplied."""
        return int(np.diff(self.matrix.indptr)[self.rows.indices].sum())

    def formed(self):
        """Multiply."""
        return self.rows @ self.matrix

    def places(self):
        """Where the blocks of both stand: pointers and columns of each."""
        found = (a for part in self for a in (part.indptr, part.indices))
        return [a.astype(np.int64) for a in found]


def sum_of_two(first, second):
    """Form the sum of two Products of one shape, in blocks as those of their rows.

    The columns of a row stand in no order.
    """
    work = first.work + second.work
    if work < WORTH_A_KERNEL:
        return first.formed() + second.formed()
    places = *first.places(), *second.places()
    n_axes = first.matrix.blocksize[1]
    n_rows, n_columns = len(places[0]) - 1, first.matrix.shape[1] // n_axes
    every, in_a_row = np.arange(n_rows + 1), {"work_of_row": work / n_rows}
    pointer = np.zeros(n_rows + 1, dtype=np.int64)
    over_segments(_count, every, *places, n_columns, pointer[1:], **in_a_row)
    np.cumsum(pointer, out=pointer)
    blocks = [part.data for part in (*first, *second)]
    dtype = np.result_type(*blocks)
    blocks = [data.astype(dtype, copy=False) for data in blocks]
    column = np.empty(pointer[-1], dtype=np.int64)
    out = np.zeros((len(column), first.rows.blocksize[0], n_axes), dtype)
    into = pointer, column, out
    over_segments(_multiply, every, *places, *blocks, n_columns, *into, **in_a_row)
    shape = first.rows.shape[0], first.matrix.shape[1]
    return sparse.bsr_array((out, column, pointer), shape=shape)


@compiled
def _count(
    first, last, _, start, step, pointer, to, start_2, step_2, pointer_2, to_2, n, count
):
    """Count the columns, of ``n``, that are used in each row."""
    used_in = np.full(n, -1)
    for row in range(first, last):
        for i in range(start[row], start[row + 1]):
            for j in range(pointer[step[i]], pointer[step[i] + 1]):
                count[row] += used_in[to[j]] != row
                used_in[to[j]] = row
        for i in range(start_2[row], start_2[row + 1]):
            for j in range(pointer_2[step_2[i]], pointer_2[step_2[i] + 1]):
                count[row] += used_in[to_2[j]] != row
                used_in[to_2[j]] = row


@compiled
def _multiply(
    first,
    last,
    _,
    start,
    step,
    pointer,
    to,
    start_2,
    step_2,
    pointer_2,
    to_2,
    rows,
    matrix,
    rows_2,
    matrix_2,
    n_columns,
    row_pointer,
    column,
    out,
):
    place = np.full(n_columns, -1)
    for row in range(first, last):
        begin = end = row_pointer[row]
        for i in range(start[row], start[row + 1]):
            low, high = pointer[step[i]], pointer[step[i] + 1]
            end = _add_row(
                rows[i], matrix, to, low, high, begin, end, place, column, out
            )
        for i in range(start_2[row], start_2[row + 1]):
            low, high = pointer_2[step_2[i]], pointer_2[step_2[i] + 1]
            end = _add_row(
                rows_2[i], matrix_2, to_2, low, high, begin, end, place, column, out
            )


@compiled
def _add_row(block, matrix, to, low, high, begin, end, place, column, out):
    """Add a block times a row of the matrix to the row that begins at a place.

    Gives where that row ends.
    """
    size, n_axes = block.shape
    for j in range(low, high):
        at = place[to[j]]
        if at < begin:  # of an earlier row, if of any
            at = place[to[j]] = end
            column[at] = to[j]
            end += 1
        if n_axes == 1:  # nearly all: twice as quick without the loops over axes
            number = matrix[j, 0, 0]
            for a in range(size):
                out[at, a, 0] += block[a, 0] * number
            continue
        for a in range(size):
            for b in range(n_axes):
                for c in range(n_axes):
                    out[at, a, c] += block[a, b] * matrix[j, b, c]
    return end
