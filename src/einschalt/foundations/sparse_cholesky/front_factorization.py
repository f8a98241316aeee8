"""Front by front: collect, eliminate with dense LAPACK, leave the rest to the parent.

A pivot that has lost all its digits belongs to an unknown that nothing determines; it
is held, so that the part of the block that is determined can be solved all the same.
"""

import numpy as np

from einschalt.foundations.kernels import compiled, copy_values
from einschalt.foundations.sparse_cholesky.dense_kernels import (
    ADJOINT,
    RIGHT,
    factor_lower,
    solve_triangle,
    subtract_square,
)

# a pivot that has lost all but this share has no digit left that means anything
LEAST_PIVOT = 1e-14
# in place of such a pivot: the unknown is held
HELD = 1e100


@compiled
def _collect(panel, sizes, own_first, blocks, column, row, local):
    """Put the blocks of a front's own columns into its panel."""
    n_own, size, u = sizes
    for i in range(own_first, own_first + n_own):
        left = (i - own_first) * u
        for k in range(column[i], column[i + 1]):
            top = local[row[k]] * u
            for b in range(u):
                for a in range(u):
                    panel[(left + b) * size + top + a] += blocks[k, a, b]


@compiled
def _add_update(panel, update, own, size, child, places):
    """Add what a child left, lower triangle, to panel and update of its parent.

    ``places`` are those of the child's unknowns in the parent, ascending.
    """
    ld, rest = places.size, size - own
    for j in range(ld):
        column = places[j]
        if column < own:
            for i in range(j, ld):
                panel[column * size + places[i]] += child[j * ld + i]
        else:
            target = (column - own) * rest - own
            for i in range(j, ld):
                update[target + places[i]] += child[j * ld + i]


@compiled
def _factor_carefully(panel, k, size, reference, held):
    """Cholesky factor of a front's own part; pivots that vanish are held."""
    for j in range(k):
        pivot = panel[j * size + j].real
        for c in range(j):
            value = panel[c * size + j]
            pivot -= value.real**2 + value.imag**2
        if pivot <= LEAST_PIVOT * reference[j]:
            held[j] = True
            panel[j * size + j] = HELD
            for i in range(j + 1, k):
                panel[j * size + i] = 0.0
            continue
        root = np.sqrt(pivot)
        panel[j * size + j] = root
        for i in range(j + 1, k):
            value = panel[j * size + i]
            for c in range(j):
                value -= panel[c * size + i] * np.conj(panel[c * size + j])
            panel[j * size + i] = value / root


@compiled
def _factor_own(panel, k, size, reference, held, copy, work):
    for j in range(k):
        for i in range(j, k):
            copy[j * k + i] = panel[j * size + i]
    is_sound = factor_lower(panel, k, size, work) == 0
    for j in range(k):
        pivot = panel[j * size + j].real
        # not so written that NaN would pass
        if not pivot * pivot > LEAST_PIVOT * reference[j]:
            is_sound = False
    if is_sound:
        return
    for j in range(k):
        for i in range(j, k):
            panel[j * size + i] = copy[j * k + i]
    _factor_carefully(panel, k, size, reference, held)


@compiled
def factor_fronts(
    blocks, pattern, panels, panel_start, fronts, part, sizes, is_held, work
):
    """Factor a branch or the trunk, children before their parents.

    See :func:`factorize`. A branch puts the update of its root into ``left``, where
    the trunk finds it.
    """
    column, row = pattern
    start, parent, n_children, boundary_start, boundary = fronts
    own_root, visited, left_start, left = part
    stack_size, largest = sizes
    n_fronts, u = start.size - 1, blocks.shape[1]
    # a front and its parent take different stacks, so that an update is computed where
    # it waits while those of its children are still there
    stacks = np.empty((2, stack_size), dtype=blocks.dtype)
    free = np.zeros(2, dtype=np.int64)
    stack_of = np.zeros(n_fronts, dtype=np.int64)
    for f in visited[::-1]:
        if f != own_root and parent[f] >= 0:
            stack_of[f] = 1 - stack_of[parent[f]]
    place = np.zeros(n_fronts, dtype=np.int64)  # of the update of each front
    waiting = np.empty(n_fronts, dtype=np.int64)
    local = np.empty(start[-1], dtype=np.int64)
    places = np.empty(largest, dtype=np.int64)
    reference = np.empty(largest)
    held = np.zeros(largest, dtype=np.bool_)
    copy = np.empty(0, dtype=blocks.dtype)
    top = 0
    for f in visited:
        first, last = start[f], start[f + 1]
        edge = boundary[boundary_start[f] : boundary_start[f + 1]]
        n_own, n_edge = last - first, edge.size
        k, rest = n_own * u, n_edge * u
        size = k + rest
        place[f] = free[stack_of[f]]
        free[stack_of[f]] += rest * rest
        update = stacks[stack_of[f], place[f] : place[f] + rest * rest]
        if left_start[f] >= 0 and f != own_root:
            copy_values(update, left[left_start[f] :][: rest * rest])
            waiting[top] = f
            top += 1
            continue
        if copy.size < k * k:
            copy = np.empty(k * k, dtype=blocks.dtype)
        for i in range(first, last):
            local[i] = i - first
        for i in range(n_edge):
            local[edge[i]] = n_own + i
        panel = panels[panel_start[f] : panel_start[f + 1]]
        for j in range(rest):
            update[j * rest + j : (j + 1) * rest] = 0.0
        dims = (n_own, size, u)
        _collect(panel, dims, first, blocks, column, row, local)
        for _ in range(n_children[f]):
            top -= 1
            child = waiting[top]
            edge_of_child = boundary[boundary_start[child] : boundary_start[child + 1]]
            for i in range(edge_of_child.size):
                for a in range(u):
                    places[i * u + a] = local[edge_of_child[i]] * u + a
            left_by_it = stacks[stack_of[child], place[child] :]
            free[stack_of[child]] = place[child]
            found = places[: edge_of_child.size * u]
            _add_update(panel, update, k, size, left_by_it, found)
        if k > 0:
            for i in range(n_own):
                for a in range(u):
                    reference[i * u + a] = blocks[column[first + i], a, a].real
            held[:k] = False
            _factor_own(panel, k, size, reference, held, copy, work)
            for i in range(n_own):
                for a in range(u):
                    is_held[first + i, a] = held[i * u + a]
            if rest > 0:
                solve_triangle(
                    RIGHT, ADJOINT, (rest, k), panel, size, panel[k:], size, work
                )
                subtract_square(panel[k:], rest, k, size, update, rest, work)
        if f == own_root:
            copy_values(left[left_start[f] :][: rest * rest], update)
        waiting[top] = f
        top += 1
