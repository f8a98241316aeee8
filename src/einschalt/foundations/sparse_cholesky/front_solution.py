"""Solutions of the factored block, up and down the tree of fronts."""

import numpy as np

from einschalt.foundations.kernels import compiled, copy_values
from einschalt.foundations.sparse_cholesky.dense_kernels import (
    ADJOINT,
    LEFT,
    PLAIN,
    solve_triangle,
    subtract_product,
)


@compiled
def _front(f, start, boundary_start, boundary, u):
    """First of a front's own unknowns, how many they are, and its boundary."""
    edge = boundary[boundary_start[f] : boundary_start[f + 1]]
    return start[f] * u, (start[f + 1] - start[f]) * u, edge


@compiled
def _with_room(buffer, n_numbers):
    if buffer.size < n_numbers:
        return np.empty(n_numbers, dtype=buffer.dtype)
    return buffer


@compiled
def solve_backward(x, panels, panel_start, start, boundary_start, boundary, u, work):
    """Replace x by Lᴴ⁻¹ x, from the last front to the first."""
    n_right = x.shape[0]
    buffer = np.empty(0, dtype=x.dtype)
    for f in range(start.size - 2, -1, -1):
        first, k, edge = _front(f, start, boundary_start, boundary, u)
        rest = edge.size * u
        size = k + rest
        if k == 0:
            continue
        buffer = _with_room(buffer, size * n_right)
        panel = panels[panel_start[f] :]
        for r in range(n_right):
            copy_values(buffer[r * size : r * size + k], x[r, first : first + k])
            for i in range(edge.size):
                for a in range(u):
                    buffer[r * size + k + i * u + a] = x[r, edge[i] * u + a]
        if rest > 0:
            shape = (k, n_right, rest)
            subtract_product(
                ADJOINT, panel[k:], size, buffer[k:], size, buffer, size, shape, work
            )
        solve_triangle(LEFT, ADJOINT, (k, n_right), panel, size, buffer, size, work)
        for r in range(n_right):
            copy_values(x[r, first : first + k], buffer[r * size : r * size + k])


@compiled
def solve_fronts(x, panels, panel_start, start, boundary_start, boundary, u, work):
    """Replace the right sides x by the solution; see ``Factor.solve``."""
    n_right = x.shape[0]
    buffer = np.empty(0, dtype=x.dtype)
    for f in range(start.size - 1):
        first, k, edge = _front(f, start, boundary_start, boundary, u)
        rest = edge.size * u
        size = k + rest
        if k == 0:
            continue
        buffer = _with_room(buffer, size * n_right)
        panel = panels[panel_start[f] :]
        for r in range(n_right):
            copy_values(buffer[r * size : r * size + k], x[r, first : first + k])
            buffer[r * size + k : (r + 1) * size] = 0.0
        solve_triangle(LEFT, PLAIN, (k, n_right), panel, size, buffer, size, work)
        if rest > 0:
            shape = (rest, n_right, k)
            subtract_product(
                PLAIN, panel[k:], size, buffer, size, buffer[k:], size, shape, work
            )
        for r in range(n_right):
            copy_values(x[r, first : first + k], buffer[r * size : r * size + k])
            for i in range(edge.size):
                for a in range(u):
                    x[r, edge[i] * u + a] += buffer[r * size + k + i * u + a]
    solve_backward(x, panels, panel_start, start, boundary_start, boundary, u, work)
