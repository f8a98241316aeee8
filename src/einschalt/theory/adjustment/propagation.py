"""Errors carried through linear steps, sparsely and block by block.

Every stage is linear in its observations up to second order. Its error operator is a
matrix of small blocks (n_axes × n_axes, one for each point and each point that it
depends on), and the covariance of the end is L Σ Lᵀ.

See docs/theory/propagation.md.
"""

import numba
import numpy as np
from scipy import sparse

from einschalt.foundations.batches import segment_sum


def hat_operator(design, cofactors, weight_sum, weights, layout):
    """Hat matrix of all models: what each row takes from the fitted points.

    Parameters
    ----------
    design : ndarray, shape (n_rows, n_axes, n_rest)
        Sensitivity of each row's point, rows sorted by model.
    cofactors : ndarray, shape (n_models, n_rest, n_rest)
    weight_sum : ndarray, shape (n_models,)
    weights : ndarray, shape (n_fitted,)
        Of the fitted points, sorted by model.
    layout : PairLayout
        Which rows depend on which fitted points.

    Returns
    -------
    bsr_array, shape (n_rows · n_axes, n_fitted · n_axes)
        Blocks H_ij = w_j (I / Σw + D_i Q D_jᴴ).
    """
    n_axes = design.shape[1]
    left = np.einsum("nau,nuv->nav", design, cofactors[layout.model_of_row])
    blocks = np.empty((len(layout.row), n_axes, n_axes), dtype=left.dtype)
    _fill_hat(
        blocks,
        (left, design),
        weight_sum[layout.model_of_row],
        weights,
        (layout.row, layout.fitted, layout.row_of_fitted),
    )
    return sparse.bsr_array(
        (blocks, layout.fitted, layout.pointer),
        shape=(len(design) * n_axes, len(weights) * n_axes),
    )


@numba.njit(cache=True, nogil=True)
def _fill_hat(blocks, designs, weight_sum, weights, pairs):
    # in one pass: gathered for all pairs, the designs would take a gigabyte
    left, right = designs
    row, fitted, row_of_fitted = pairs
    n_pairs, n_axes, _ = blocks.shape
    for p in range(n_pairs):
        i, j = row[p], row_of_fitted[fitted[p]]
        for a in range(n_axes):
            for b in range(n_axes):
                blocks[p, a, b] = 1.0 / weight_sum[i] if a == b else 0.0
                for u in range(left.shape[2]):
                    blocks[p, a, b] += left[i, a, u] * np.conj(right[j, b, u])
                blocks[p, a, b] *= weights[fitted[p]]


class PairLayout:
    """All pairs of a row and a fitted point of the same model.

    Parameters
    ----------
    start_rows : ndarray of int, shape (n_models + 1,)
        Segments of all rows, sorted by model.
    row_of_fitted : ndarray of int, shape (n_fitted,)
        Which rows were fitted, ascending.

    Attributes
    ----------
    model_of_row : ndarray of int, shape (n_rows,)
    row, fitted : ndarray of int, shape (n_pairs,)
        The row, and the position of the fitted point among the fitted ones.
    pointer : ndarray of int, shape (n_rows + 1,)
        First pair of each row.
    """

    def __init__(self, start_rows, row_of_fitted):
        n_rows = int(start_rows[-1])
        count = np.diff(start_rows)
        self.row_of_fitted = row_of_fitted
        self.model_of_row = np.repeat(np.arange(len(count)), count)
        start_fitted = np.searchsorted(row_of_fitted, start_rows)
        per_row = np.diff(start_fitted)[self.model_of_row]
        self.pointer = np.concatenate([[0], np.cumsum(per_row)])
        self.row = np.repeat(np.arange(n_rows), per_row)
        within = np.arange(len(self.row)) - self.pointer[self.row]
        self.fitted = start_fitted[self.model_of_row[self.row]] + within


def scattered(blocks, rows, columns, shape):
    """Sum of small matrices, each at its rows and columns of a large one.

    Parameters
    ----------
    blocks : ndarray, shape (n_blocks, n_rows, n_columns)
        NaN, of models that are not usable, has no part in the sum.
    rows : ndarray of int, shape (n_blocks, n_rows)
    columns : ndarray of int, shape (n_blocks, n_columns)
    shape : tuple of int
        Of the large matrix.

    Returns
    -------
    csr_array
    """
    places = [
        np.broadcast_to(part, blocks.shape).ravel()
        for part in (rows[:, :, None], columns[:, None, :])
    ]
    return sparse.csr_array((np.nan_to_num(blocks).ravel(), tuple(places)), shape=shape)


def selection(columns, n_columns, n_axes):
    """Pick a column for each row: row i of the result is the point ``columns[i]``.

    Parameters
    ----------
    columns : ndarray of int, shape (n_rows,)
    n_columns, n_axes : int

    Returns
    -------
    bsr_array, shape (n_rows · n_axes, n_columns · n_axes)
    """
    blocks = np.broadcast_to(np.eye(n_axes), (len(columns), n_axes, n_axes))
    pointer = np.arange(len(columns) + 1)
    shape = (len(columns) * n_axes, n_columns * n_axes)
    return sparse.bsr_array((blocks.copy(), columns, pointer), shape=shape)


def weighted_mean(rows, weights, start, shape):
    """Weighted mean of the values of each point, as an operator.

    Parameters
    ----------
    rows : ndarray of int, shape (n_values,)
        Which values, sorted by point.
    weights : ndarray, shape (n_values,)
    start : ndarray of int, shape (n_points + 1,)
    shape : tuple of int
        Number of all values, and number of axes.

    Returns
    -------
    bsr_array, shape (n_points · n_axes, n_all · n_axes)
    """
    n_all, n_axes = shape
    count = np.diff(start)
    share = weights / np.repeat(segment_sum(weights, start), count)
    blocks = share[:, None, None] * np.eye(n_axes)
    return sparse.bsr_array(
        (blocks, rows, start), shape=(len(count) * n_axes, n_all * n_axes)
    )


def sum_of_chains(one, other):
    """Chain whose product is the sum of the products of two, without forming them.

    Parameters
    ----------
    one, other : tuple of sparse arrays
        Their products have one shape.

    Returns
    -------
    tuple of sparse arrays
        As many as the longer chain has.
    """
    length = max(len(one), len(other))
    pairs = list(zip(_padded(one, length), _padded(other, length), strict=True))
    if length == 1:
        return (one[0] + other[0],)
    (first, *middle, last) = pairs
    return (
        sparse.hstack(first, format="csr"),
        *(sparse.block_diag(pair, format="csr") for pair in middle),
        sparse.vstack(last, format="csr"),
    )


def _padded(chain, length):
    through = sparse.eye_array(chain[-1].shape[1], format="csr")
    return (*chain, *(through for _ in range(length - len(chain))))


def by_axis(standard_errors, n_axes):
    """Sizes of errors of every axis, where one size stands for all of them.

    Parameters
    ----------
    standard_errors : ndarray, shape (n_sources,) or (n_sources, n_axes)
    n_axes : int

    Returns
    -------
    ndarray, shape (n_sources, n_axes)
    """
    columns = np.reshape(standard_errors, (len(standard_errors), -1))
    return np.broadcast_to(columns, (len(standard_errors), n_axes))


def point_covariances(operator, standard_errors, n_axes):
    """Covariance of each point from independent sources.

    Parameters
    ----------
    operator : sparse array, shape (n_points · n_axes, n_sources · n_axes)
    standard_errors : ndarray, shape (n_sources,) or (n_sources, n_axes)
        Of each source, per coordinate [m].
    n_axes : int

    Returns
    -------
    ndarray, shape (n_points, n_axes, n_axes)
        [m²]. With one complex axis E + iN it is the variance of either coordinate:
        equal and uncorrelated errors stay so under conformal operators.
    """
    blocks = sparse.bsr_array(operator, blocksize=(n_axes, n_axes))
    scaled = blocks.data * by_axis(standard_errors, n_axes)[blocks.indices][:, None, :]
    if n_axes == 1:
        squares = np.abs(scaled) ** 2
        return segment_sum(squares, blocks.indptr)
    return segment_sum(scaled @ np.swapaxes(scaled, 1, 2), blocks.indptr)


def pair_covariances(operator, standard_errors, pairs, n_axes):
    """Covariances between pairs of points from independent sources.

    Parameters
    ----------
    operator : sparse array, shape (n_points · n_axes, n_sources · n_axes)
    standard_errors : ndarray, shape (n_sources,) or (n_sources, n_axes)
        Of each source, per coordinate [m].
    pairs : ndarray of int, shape (n_pairs, 2)
        Places of the points of each pair.
    n_axes : int

    Returns
    -------
    ndarray, shape (n_pairs, n_axes, n_axes)
        [m²]; complex where the operator is. Rows belong to the first point.
    """
    rows = sparse.csr_array(operator)
    rows.sort_indices()
    pairs = np.ascontiguousarray(pairs, dtype=np.int64)
    out = np.zeros((len(pairs), n_axes, n_axes), dtype=rows.dtype)
    variances = np.square(by_axis(standard_errors, n_axes)).ravel()
    entries = (rows.indptr, rows.indices, rows.data)
    _multiply_rows(*entries, variances, pairs, out)
    return out


@numba.njit(cache=True, nogil=True)
def _multiply_rows(pointer, column, value, variances, pairs, out):
    n_axes = out.shape[1]
    for p in range(len(pairs)):
        for a in range(n_axes):
            row_a = pairs[p, 0] * n_axes + a
            for b in range(n_axes):
                row_b = pairs[p, 1] * n_axes + b
                i, last_i = pointer[row_a], pointer[row_a + 1]
                j, last_j = pointer[row_b], pointer[row_b + 1]
                while i < last_i and j < last_j:
                    if column[i] < column[j]:
                        i += 1
                    elif column[i] > column[j]:
                        j += 1
                    else:
                        product = value[i] * np.conj(value[j])
                        out[p, a, b] += variances[column[i]] * product
                        i += 1
                        j += 1
