"""Errors carried through linear steps, sparsely and block by block.

Every stage is linear in its observations up to second order. Its error operator is a
matrix of small blocks (one for each point and each point that it depends on), and the
covariance of the end is L Σ Lᵀ.

See docs/theory/propagation.md.
"""

import numpy as np
from scipy import sparse

from einschalt.theory.adjustment.point_operator import of_blocks


def through_parameters(design, cofactors, weights, weight_sum, model, fitted):
    """How points depend on the parameters of their models, and these on fitted points.

    Together they are the hat matrix of all models, H_ij = w_j (I / Σw + D_i Q D_jᴴ), in
    two steps of far fewer numbers. The parameters of a model stand for some points: its
    shift, then the rest, with zeros where that does not fill the last one.

    Parameters
    ----------
    design : ndarray, shape (n_rows, d, n_rest)
        Sensitivity of each row's point, for which d numbers stand.
    cofactors : ndarray, shape (n_models, n_rest, n_rest)
    weights : ndarray, shape (n_fitted,)
    weight_sum : ndarray, shape (n_models,)
    model : ndarray of int, shape (n_rows,)
    fitted : ndarray of int, shape (n_fitted,)
        Rows of the fitted points, sorted by model.

    Returns
    -------
    PointOperator, PointOperator
        From the parameters of all models to the rows, and from the fitted points to the
        parameters.
    """
    n_rows, d, n_rest = design.shape
    n_each = 1 + -(-n_rest // d)
    onto = np.zeros((n_rows, d, n_each * d), dtype=design.dtype)
    onto[:, :, :d] = np.eye(d)
    onto[:, :, d : d + n_rest] = design
    onto = onto.reshape(n_rows, d, n_each, d).swapaxes(1, 2).reshape(-1, d, d)
    columns = n_each * model[:, None] + np.arange(n_each)
    pointer = n_each * np.arange(n_rows + 1)
    of_rows = of_blocks(onto, columns.ravel(), pointer, n_each * len(cofactors))
    found = np.zeros((len(fitted), n_each * d, d), dtype=design.dtype)
    at = model[fitted]
    found[:, :d] = np.eye(d) / weight_sum[at, None, None]
    found[:, d : d + n_rest] = cofactors[at] @ design[fitted].conj().swapaxes(1, 2)
    found *= weights[:, None, None]
    found = found.reshape(len(fitted), n_each, d, d)
    return of_rows, _of_parameters(found, at, len(cofactors))


def _of_parameters(blocks, model, n_models):
    """Operator to the parameters of each model, row after row, from its fitted points.

    ``blocks`` (n_fitted, n_each, d, d) are sorted by fitted point.
    """
    n_fitted, n_each, d, _ = blocks.shape
    start = np.searchsorted(model, np.arange(n_models + 1))
    count, parameter = np.diff(start), np.arange(n_each)
    pointer = n_each * start[:-1, None] + parameter * count[:, None]
    place = pointer[model] + (np.arange(n_fitted) - start[model])[:, None]
    sorted_blocks = np.empty((n_each * n_fitted, d, d), dtype=blocks.dtype)
    sorted_blocks[place] = blocks
    columns = np.empty(n_each * n_fitted, dtype=np.int64)
    columns[place] = np.arange(n_fitted)[:, None]
    pointer = np.append(pointer.ravel(), n_each * n_fitted)
    return of_blocks(sorted_blocks, columns, pointer, n_fitted)


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
