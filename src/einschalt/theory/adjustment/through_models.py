"""Covariances of errors that are measured once, and act in two ways.

The points on which a model is fitted move its parameters, and their own values too:
through few parameters, and the mean of each point, instead of through every point.

See docs/theory/propagation.md.
"""

import numpy as np
from scipy import sparse

from einschalt.theory.adjustment.joint_covariance import joint_covariance
from einschalt.theory.adjustment.point_operator import Axes, PointOperator


def joint_through_models(rows_of, chain, met, size, standard_errors):
    """Covariances of pairs of bundles, as joint_covariance has them; None of others.

    Of a chain G (X P + M): P leads from independent errors to the parameters of models,
    none of which shares an error with another one, and M to points, none of which does.
    With their covariances Q = P Σ Pᴴ = R Rᴴ, C = M Σ Pᴴ and V = M Σ Mᴴ, which is
    diagonal, and N = C R⁻ᴴ, completing the square,

        L Σ Lᴴ = G ((X R + N) (X R + N)ᴴ − N Nᴴ + V) Gᴴ.

    Parameters
    ----------
    rows_of : callable
        Rows of the bundles in a PointOperator that is one product, as sparse blocks.
    chain : PointOperator
        With axes that stand for points as complex numbers.
    met : BundlePairs
    size : int
        Numbers of a bundle, and of a model.
    standard_errors : ndarray, shape (n_sources,)
        Per coordinate [m].

    Returns
    -------
    ndarray, shape (n_met, size, size), or None
    """
    parts = _parts_of(chain)
    if parts is None:
        return None
    ground, to_points, of_models, of_points = parts
    each = np.asarray(standard_errors, dtype=float).reshape(-1)
    if len(each) != chain.n_sources:
        return None
    of_models, of_points = (
        sparse.csr_array(sparse.csr_array(part) * each)
        for part in (of_models, of_points)
    )
    variances = _diagonal_of(of_points)
    roots = _roots_of_models(of_models, size)
    if variances is None or roots is None:
        return None
    root, inverse = roots
    shared = of_points @ of_models.conj().T @ inverse.conj().T
    both = sparse.csr_array(to_points) @ root + shared
    one = np.ones(root.shape[0])

    def joint(matrix, sizes):
        return joint_covariance(PointOperator((matrix,), chain.axes), met, size, sizes)

    rows = rows_of(PointOperator(ground, chain.axes))
    found = joint(rows, np.sqrt(variances))
    found = found - joint(_times(rows, shared), one)
    return found + joint(_times(rows, both), one)


def _parts_of(chain):
    """G, X, P and M of a chain G (X P + M); None if it is none."""
    if len(chain.products) != 2 or chain.axes is not Axes.COMPLEX:
        return None
    short, long = sorted((one.factors for one in chain.products), key=len)
    ground = short[:-1]
    is_alike = list(map(id, ground)) == list(map(id, long[:-2]))
    if not ground or len(long) != len(short) + 1 or not is_alike:
        return None
    return ground, long[-2], long[-1], short[-1]


def _diagonal_of(of_points):
    """Variances of points that share no error; None if some do."""
    held = of_points.indices[of_points.data != 0.0]
    if np.bincount(held, minlength=1).max() > 1:
        return None
    return np.asarray(np.square(np.abs(of_points)).sum(axis=1)).ravel()


def _roots_of_models(of_models, size):
    """R of the parameters, and its inverse, by blocks; None where there are none."""
    n_parameters = of_models.shape[0]
    if n_parameters % size or not np.isfinite(of_models.data).all():
        return None
    cofactors = sparse.bsr_array(of_models @ of_models.conj().T, blocksize=(size, size))
    cofactors.sort_indices()
    n_models = n_parameters // size
    is_apart = np.array_equal(cofactors.indices, np.arange(n_models))
    if not is_apart or (np.diff(cofactors.indptr) != 1).any():
        return None
    try:
        roots = np.linalg.cholesky(cofactors.data)
        inverse = np.linalg.inv(roots)
    except np.linalg.LinAlgError:  # of measurements without errors
        return None
    places = cofactors.indices, cofactors.indptr
    return tuple(
        sparse.csr_array(sparse.bsr_array((blocks, *places), shape=cofactors.shape))
        for blocks in (roots, inverse)
    )


def _times(rows, matrix):
    """Rows in blocks, with as many numbers in a column as a point has."""
    return rows @ sparse.bsr_array(matrix, blocksize=(1, 1))
