"""Solutions of the factored block, up and down the tree of fronts.

On the way up every front leaves a vector to its parent, as it left an update when it
was factored: sums are formed in one order, whichever cores the branches are given to.
"""

import numpy as np

from einschalt.foundations.kernels import compiled, copy_values
from einschalt.foundations.sparse_cholesky.dense_kernels import (
    ADJOINT,
    LEFT,
    PLAIN,
    solve_triangle,
    solve_triangle_vector,
    subtract_matrix_vector,
    subtract_product,
)

# right sides for which products of matrices, which are rearranged first, do not pay
FEW = 3


@compiled
def _with_room(buffer, n_numbers):
    if buffer.size >= n_numbers:
        return buffer
    larger = np.empty(2 * n_numbers, dtype=buffer.dtype)
    copy_values(larger[: buffer.size], buffer)
    return larger


@compiled
def _solve_own(transposed, buffer, panel, k, size, n_right, work):
    """Replace a front's own part of each right side by op(L)⁻¹ of it."""
    if n_right > FEW:
        shape = (k, n_right)
        solve_triangle(LEFT, transposed, shape, panel, size, buffer, size, work)
        return
    for r in range(n_right):
        solve_triangle_vector(transposed, k, panel, size, buffer[r * size :], work)


@compiled
def _subtract_below(transposed, x, y, panel, k, size, n_right, work):
    """Subtract op(L_bs) x from y, both parts of a front's right sides."""
    rest, below = size - k, panel[k:]
    if rest == 0:
        return
    if n_right > FEW:
        shape = (rest, n_right, k) if transposed == PLAIN else (k, n_right, rest)
        subtract_product(transposed, below, size, x, size, y, size, shape, work)
        return
    for r in range(n_right):
        x_r, y_r = x[r * size :], y[r * size :]
        subtract_matrix_vector(transposed, (rest, k), below, size, x_r, y_r, work)


@compiled
def solve_forward(x, panels, panel_start, tree, part, u, work):
    """Replace x by L⁻¹ x in a branch or the trunk, children before their parents.

    A branch puts what its root leaves into ``left``, where the trunk finds it.
    """
    start, n_children, boundary_start, boundary = tree
    own_root, visited, left_start, left = part
    n_right = x.shape[0]
    buffer = np.empty(0, dtype=x.dtype)
    stack = np.empty(0, dtype=x.dtype)
    place = np.zeros(visited.size + 1, dtype=np.int64)  # of each waiting vector
    waiting = np.empty(visited.size, dtype=np.int64)
    local = np.empty(start[-1], dtype=np.int64)
    top = 0
    for f in visited:
        first, n_own = start[f], start[f + 1] - start[f]
        edge = boundary[boundary_start[f] : boundary_start[f + 1]]
        k, rest = n_own * u, edge.size * u
        size = k + rest
        buffer = _with_room(buffer, size * n_right)
        is_left = left_start[f] >= 0 and f != own_root
        if not is_left:
            for i in range(n_own):
                local[first + i] = i
            for i in range(edge.size):
                local[edge[i]] = n_own + i
            for r in range(n_right):
                own = x[r, first * u : first * u + k]
                copy_values(buffer[r * size : r * size + k], own)
                buffer[r * size + k : (r + 1) * size] = 0.0
            for _ in range(n_children[f]):
                top -= 1
                child = waiting[top]
                child_edge = boundary[boundary_start[child] : boundary_start[child + 1]]
                source = place[top]
                for r in range(n_right):
                    for i in range(child_edge.size):
                        target = r * size + local[child_edge[i]] * u
                        for a in range(u):
                            buffer[target + a] += stack[source]
                            source += 1
            if k > 0:
                panel = panels[panel_start[f] :]
                _solve_own(PLAIN, buffer, panel, k, size, n_right, work)
                below = buffer[k:]
                _subtract_below(PLAIN, buffer, below, panel, k, size, n_right, work)
        place[top + 1] = place[top] + rest * n_right
        stack = _with_room(stack, place[top + 1])
        for r in range(n_right):
            target = stack[place[top] + r * rest :][:rest]
            if is_left:
                copy_values(target, left[r, left_start[f] : left_start[f] + rest])
                continue
            copy_values(x[r, first * u : first * u + k], buffer[r * size :][:k])
            copy_values(target, buffer[r * size + k :][:rest])
            if f == own_root:
                copy_values(left[r, left_start[f] : left_start[f] + rest], target)
        waiting[top] = f
        top += 1


@compiled
def solve_backward(x, panels, panel_start, tree, part, u, work):
    """Replace x by Lᴴ⁻¹ x in a branch or the trunk, parents before their children."""
    start, _, boundary_start, boundary = tree
    own_root, visited, left_start, _ = part
    n_right = x.shape[0]
    buffer = np.empty(0, dtype=x.dtype)
    for f in visited[::-1]:
        first, k = start[f] * u, (start[f + 1] - start[f]) * u
        if k == 0 or (left_start[f] >= 0 and f != own_root):
            continue
        edge = boundary[boundary_start[f] : boundary_start[f + 1]]
        size = k + edge.size * u
        buffer = _with_room(buffer, size * n_right)
        panel = panels[panel_start[f] :]
        for r in range(n_right):
            copy_values(buffer[r * size : r * size + k], x[r, first : first + k])
            for i in range(edge.size):
                for a in range(u):
                    buffer[r * size + k + i * u + a] = x[r, edge[i] * u + a]
        below = buffer[k:]
        _subtract_below(ADJOINT, below, buffer, panel, k, size, n_right, work)
        _solve_own(ADJOINT, buffer, panel, k, size, n_right, work)
        for r in range(n_right):
            copy_values(x[r, first : first + k], buffer[r * size : r * size + k])
