"""The elements of the inverse where the normal equations have any, from the top down.

For a front that eliminates the models s and has the boundary b,

    Z_bs = −Z_bb Y,   Z_ss = (L_ss L_ssᴴ)⁻¹ − Yᴴ Z_bs,   Y = L_bs L_ss⁻¹,

and Z_bb is part of what its parent knows (Erisman and Tinney 1975).
"""

import numpy as np

from einschalt.foundations.kernels import compiled, copy_values
from einschalt.foundations.sparse_cholesky.dense_kernels import (
    ADJOINT,
    PLAIN,
    RIGHT,
    invert_lower,
    multiply_hermitian,
    solve_triangle,
    subtract_product,
)


@compiled
def _gather(known, size_known, target, n_edge, local, edge, u):
    """Lower triangle of the boundary's inverse, out of the parent's."""
    rest = n_edge * u
    for j in range(n_edge):
        left = local[edge[j]] * u
        for i in range(j, n_edge):
            top = local[edge[i]] * u
            for b in range(u):
                source = (left + b) * size_known + top
                place = (j * u + b) * rest + i * u
                for a in range(b if i == j else 0, u):
                    target[place + a] = known[source + a]


@compiled
def invert_fronts(inverse, pattern, panels, panel_start, fronts, part, path, work):
    """Fill the blocks of the inverse of a branch or the trunk, from the top down.

    See ``Factor.selected_inverse``. The trunk puts the inverse of its boundary into
    ``left`` for every branch.
    """
    column, row = pattern
    start, parent, n_children, boundary_start, boundary = fronts
    own_root, visited, left_start, left = part
    n_fronts, u = start.size - 1, inverse.shape[1]
    pile = np.empty(path, dtype=inverse.dtype)
    depth_of = np.zeros(n_fronts, dtype=np.int64)
    place = np.zeros(n_fronts + 1, dtype=np.int64)
    local = np.empty(start[-1], dtype=np.int64)
    y = np.empty(0, dtype=inverse.dtype)
    below = np.empty(0, dtype=inverse.dtype)
    edge_inverse = np.empty(0, dtype=inverse.dtype)
    own_inverse = np.empty(0, dtype=inverse.dtype)
    for f in visited[::-1]:
        first, last = start[f], start[f + 1]
        edge = boundary[boundary_start[f] : boundary_start[f + 1]]
        n_own, n_edge = last - first, edge.size
        k, rest = n_own * u, n_edge * u
        size = k + rest
        above = -1 if f == own_root else parent[f]
        depth = 0 if above < 0 else depth_of[above] + 1
        depth_of[f] = depth
        if edge_inverse.size < rest * rest:
            edge_inverse = np.empty(rest * rest, dtype=inverse.dtype)
        if y.size < rest * k:
            y = np.empty(rest * k, dtype=inverse.dtype)
            below = np.empty(rest * k, dtype=inverse.dtype)
        if own_inverse.size < k * k:
            own_inverse = np.empty(k * k, dtype=inverse.dtype)
        if f == own_root:
            copy_values(
                edge_inverse[: rest * rest], left[left_start[f] :][: rest * rest]
            )
        elif rest > 0:
            first_above, last_above = start[above], start[above + 1]
            edge_above = boundary[boundary_start[above] : boundary_start[above + 1]]
            n_above = last_above - first_above
            for i in range(first_above, last_above):
                local[i] = i - first_above
            for i in range(edge_above.size):
                local[edge_above[i]] = n_above + i
            size_above = (n_above + edge_above.size) * u
            known = pile[place[depth - 1] :]
            _gather(known, size_above, edge_inverse, n_edge, local, edge, u)
        if left_start[f] >= 0 and f != own_root:
            copy_values(
                left[left_start[f] :][: rest * rest], edge_inverse[: rest * rest]
            )
            continue
        panel = panels[panel_start[f] :]
        for j in range(k):
            copy_values(
                own_inverse[j * k + j : (j + 1) * k], panel[j * size + j : j * size + k]
            )
        if k > 0:
            if rest > 0:
                for j in range(k):
                    copy_values(
                        y[j * rest : (j + 1) * rest],
                        panel[j * size + k : (j + 1) * size],
                    )
                solve_triangle(RIGHT, PLAIN, (rest, k), panel, size, y, rest, work)
                multiply_hermitian(
                    edge_inverse, rest, y, rest, below, rest, (rest, k), work
                )
            invert_lower(own_inverse, k, k, work)
            if rest > 0:
                subtract_product(
                    ADJOINT, y, rest, below, rest, own_inverse, k, (k, k, rest), work
                )
        for i in range(first, last):
            local[i] = i - first
        for i in range(n_edge):
            local[edge[i]] = n_own + i
        for i in range(n_own):
            for slot in range(column[first + i], column[first + i + 1]):
                top = local[row[slot]]
                for b in range(u):
                    for a in range(u):
                        if top > i and top >= n_own:
                            value = below[(i * u + b) * rest + (top - n_own) * u + a]
                        elif top > i or a >= b:
                            value = own_inverse[(i * u + b) * k + top * u + a]
                        else:
                            value = np.conj(own_inverse[(i * u + a) * k + top * u + b])
                        inverse[slot, a, b] = value
        place[depth + 1] = place[depth]
        if n_children[f] > 0:
            whole = pile[place[depth] :]
            for j in range(k):
                low = j * size
                copy_values(
                    whole[low + j : low + k], own_inverse[j * k + j : (j + 1) * k]
                )
                copy_values(
                    whole[low + k : low + size], below[j * rest : (j + 1) * rest]
                )
            for j in range(rest):
                low = (k + j) * size + k
                copy_values(
                    whole[low + j : low + rest],
                    edge_inverse[j * rest + j : (j + 1) * rest],
                )
            place[depth + 1] = place[depth] + size * size
