"""Errors carried through linear steps, sparsely and block by block.

Every stage is linear in its observations up to second order. Its error operator is a
matrix of small blocks (one for each point and each point that it depends on), and the
covariance of the end is L Σ Lᵀ.

See docs/theory/propagation.md.
"""

import numpy as np
from scipy import sparse

from einschalt.foundations.kernels import compiled
from einschalt.theory.adjustment.point_operator import of_blocks


def hat_operator(design, cofactors, weight_sum, weights, layout):
    """Hat matrix of all models: what each row takes from the fitted points.

    Parameters
    ----------
    design : ndarray, shape (n_rows, d, n_rest)
        Sensitivity of each row's point, rows sorted by model; d numbers stand for it.
    cofactors : ndarray, shape (n_models, n_rest, n_rest)
    weight_sum : ndarray, shape (n_models,)
    weights : ndarray, shape (n_fitted,)
        Of the fitted points, sorted by model.
    layout : PairLayout
        Which rows depend on which fitted points.

    Returns
    -------
    PointOperator
        From the fitted points to the rows: blocks H_ij = w_j (I / Σw + D_i Q D_jᴴ).
    """
    left = np.einsum("nau,nuv->nav", design, cofactors[layout.model_of_row])
    d = design.shape[1]
    blocks = np.empty((len(layout.row), d, d), dtype=left.dtype)
    _fill_hat(
        blocks,
        (left, design),
        weight_sum[layout.model_of_row],
        weights,
        (layout.row, layout.fitted, layout.row_of_fitted),
    )
    return of_blocks(blocks, layout.fitted, layout.pointer, len(weights))


@compiled
def _fill_hat(blocks, designs, weight_sum, weights, pairs):
    # in one pass: gathered for all pairs, the designs would take a gigabyte
    left, right = designs
    row, fitted, row_of_fitted = pairs
    n_pairs, d, _ = blocks.shape
    for p in range(n_pairs):
        i, j = row[p], row_of_fitted[fitted[p]]
        for a in range(d):
            for b in range(d):
                blocks[p, a, b] = 1.0 / weight_sum[i] if a == b else 0.0
                for u in range(left.shape[2]):
                    blocks[p, a, b] += left[i, a, u] * np.conj(right[j, b, u])
                blocks[p, a, b] *= weights[fitted[p]]


class PairLayout:
    """All pairs of a row and a fitted point of the same model.

    ``start_rows`` (n_models + 1,) has the segments of all rows, sorted by model;
    ``row_of_fitted`` (n_fitted,) says which were fitted, ascending. ``row`` and
    ``fitted`` (n_pairs,) are the row, and the position of the fitted point among the
    fitted ones; ``pointer`` (n_rows + 1,) is the first pair of each row.
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
    """Sum of small matrices, each at its rows and columns of a large sparse one.

    ``blocks`` (n_blocks, n_rows, n_columns): NaN, of models that are not usable, has no
    part in the sum.
    """
    places = [
        np.broadcast_to(part, blocks.shape).ravel()
        for part in (rows[:, :, None], columns[:, None, :])
    ]
    return sparse.csr_array((np.nan_to_num(blocks).ravel(), tuple(places)), shape=shape)
