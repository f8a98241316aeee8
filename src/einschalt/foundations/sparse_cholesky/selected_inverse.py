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

# columns of Z_ss at a time: of each such part only what is below its top is computed
STRIP = 48


@compiled
def _gather(known, size_known, target, ld, places):
    """Lower triangle of the boundary's inverse, out of the parent's."""
    for j in range(places.size):
        column = places[j] * size_known
        for i in range(j, places.size):
            target[j * ld + i] = known[column + places[i]]


@compiled
def _find_places(places, edge, first_above, last_above, edge_above, local, u):
    """Where the unknowns of a boundary stand in the parent."""
    for i in range(first_above, last_above):
        local[i] = i - first_above
    for i in range(edge_above.size):
        local[edge_above[i]] = last_above - first_above + i
    for i in range(edge.size):
        for a in range(u):
            places[i * u + a] = local[edge[i]] * u + a


@compiled
def _invert_own(whole, panel, k, rest, y, work):
    """Columns of a front's own unknowns, below the inverse of its boundary."""
    size = k + rest
    for j in range(k):
        low = j * size
        copy_values(whole[low + j : low + k], panel[low + j : low + k])
        copy_values(y[j * rest : (j + 1) * rest], panel[low + k : low + size])
    invert_lower(whole, k, size, work)
    if rest == 0:
        return
    solve_triangle(RIGHT, PLAIN, (rest, k), panel, size, y, rest, work)
    edge_inverse, below = whole[k * size + k :], whole[k:]
    multiply_hermitian(edge_inverse, size, y, rest, below, size, (rest, k), work)
    for j in range(0, k, STRIP):
        shape = (k - j, min(STRIP, k - j), rest)
        target, strip = whole[j * size + j :], whole[j * size + k :]
        y_j = y[j * rest :]
        subtract_product(ADJOINT, y_j, rest, strip, size, target, size, shape, work)


@compiled
def invert_fronts(inverse, pattern, panels, panel_start, fronts, part, path, work):
    """Fill the blocks of the inverse of a branch or the trunk, from the top down.

    See ``Factor.selected_inverse``. The trunk puts the inverse of its boundary into
    ``left`` for every branch.
    """
    column, row = pattern
    start, parent, boundary_start, boundary = fronts
    own_root, visited, left_start, left = part
    u = inverse.shape[1]
    # inverses of the fronts on the way down to this one
    pile = np.empty(path, dtype=inverse.dtype)
    depth_of = np.zeros(parent.size, dtype=np.int64)
    place = np.zeros(parent.size + 1, dtype=np.int64)
    local = np.empty(start[-1], dtype=np.int64)
    places = np.empty(0, dtype=np.int64)
    y = np.empty(0, dtype=inverse.dtype)
    for f in visited[::-1]:
        first, last = start[f], start[f + 1]
        edge = boundary[boundary_start[f] : boundary_start[f + 1]]
        n_own = last - first
        k, rest = n_own * u, edge.size * u
        size = k + rest
        above = -1 if f == own_root else parent[f]
        depth = 0 if above < 0 else depth_of[above] + 1
        depth_of[f] = depth
        whole = pile[place[depth] :]
        is_left = left_start[f] >= 0 and f != own_root
        if f == own_root:
            for j in range(rest):
                low = (k + j) * size + k
                known = left[left_start[f] + j * rest :]
                copy_values(whole[low + j : low + rest], known[j:rest])
        elif rest > 0:
            if places.size < rest:
                places = np.empty(2 * rest, dtype=np.int64)
            own_above = start[above], start[above + 1]
            edge_above = boundary[boundary_start[above] : boundary_start[above + 1]]
            _find_places(places, edge, *own_above, edge_above, local, u)
            size_above = (own_above[1] - own_above[0] + edge_above.size) * u
            target, ld = whole[k * size + k :], size
            if is_left:
                target, ld = left[left_start[f] :], rest
            known = pile[place[depth - 1] :]
            _gather(known, size_above, target, ld, places[:rest])
        if is_left:
            continue
        if y.size < rest * k:
            y = np.empty(rest * k, dtype=inverse.dtype)
        place[depth + 1] = place[depth] + size * size
        if k == 0:
            continue
        _invert_own(whole, panels[panel_start[f] :], k, rest, y, work)
        for i in range(n_own):
            local[first + i] = i
        for i in range(edge.size):
            local[edge[i]] = n_own + i
        for i in range(n_own):
            for slot in range(column[first + i], column[first + i + 1]):
                top = local[row[slot]]
                for b in range(u):
                    for a in range(u):
                        if top > i or a >= b:
                            value = whole[(i * u + b) * size + top * u + a]
                        else:
                            value = np.conj(whole[(i * u + a) * size + top * u + b])
                        inverse[slot, a, b] = value
