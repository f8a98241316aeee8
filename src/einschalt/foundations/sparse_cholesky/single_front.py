"""A block of one front: a dense matrix, that LAPACK takes without anything compiled.

It stands as the other fronts do, so that a factor is the same whichever way it came
about. A first run would wait longer for the kernels of the fronts than for any number
of solutions of a small block.
"""

import numpy as np
from scipy.linalg import get_lapack_funcs

from einschalt.foundations.sparse_cholesky.front_factorization import HELD, LEAST_PIVOT


def factor_whole(blocks, pattern):
    """Panel of the only front, flat, column by column, and which unknowns are held."""
    matrix = _matrix(blocks, pattern)
    reference = np.diagonal(matrix).real.copy()
    (factorize,) = get_lapack_funcs(("potrf",), (matrix,))
    lower, first_bad = factorize(matrix, lower=True, clean=False, overwrite_a=True)
    is_held = np.zeros(len(reference), dtype=np.bool_)
    # not so written that NaN would pass
    is_sound = np.diagonal(lower).real ** 2 > LEAST_PIVOT * reference
    if first_bad != 0 or not is_sound.all():
        lower = _matrix(blocks, pattern)
        _factor_carefully(lower, reference, is_held)
    return lower.T.ravel(), is_held.reshape(-1, blocks.shape[1])


def _matrix(blocks, pattern):
    """Lower triangle of the normal equations, columns one after the other."""
    n, u = len(pattern.start) - 1, blocks.shape[1]
    panel = np.zeros((n, u, n, u), dtype=blocks.dtype)
    row, column = _places(pattern)
    panel[column, :, row] = np.swapaxes(blocks, 1, 2)
    return panel.reshape(n * u, n * u).T


def _places(pattern):
    """Row and column of each block."""
    size = np.diff(pattern.start)
    return pattern.row, np.repeat(np.arange(len(size)), size)


def _factor_carefully(lower, reference, is_held):
    """Cholesky factor in place; pivots that vanish are held."""
    for j in range(len(lower)):
        column = lower[j:, j] - lower[j:, :j] @ np.conj(lower[j, :j])
        pivot = column[0].real
        if pivot <= LEAST_PIVOT * reference[j]:
            is_held[j] = True
            lower[j, j], lower[j + 1 :, j] = HELD, 0.0
        else:
            lower[j:, j] = column / np.sqrt(pivot)


def solve_whole(x, panel, *, is_forward_done=False):
    """Replace x, (n_right, n), by (L Lᴴ)⁻¹ x, or by Lᴴ⁻¹ x."""
    lower = panel.reshape(x.shape[1], -1).T
    (solve,) = get_lapack_funcs(("trtrs",), (lower,))
    for adjoint in (2,) if is_forward_done else (0, 2):
        x.T[:] = solve(lower, x.T, lower=True, trans=adjoint)[0]


def invert_whole(panel, pattern, n_unknowns):
    """Blocks of the inverse where the normal equations have any, in their order."""
    n = len(pattern.start) - 1
    lower = panel.reshape(n * n_unknowns, -1).T
    (invert,) = get_lapack_funcs(("potri",), (lower,))
    half = invert(lower, lower=True)[0].T.reshape(n, n_unknowns, n, n_unknowns)
    row, column = _places(pattern)
    blocks = np.swapaxes(half[column, :, row], 1, 2).copy()
    own = np.tril(blocks[pattern.start[:-1]])
    blocks[pattern.start[:-1]] = own + np.conj(np.swapaxes(np.tril(own, -1), 1, 2))
    return blocks
