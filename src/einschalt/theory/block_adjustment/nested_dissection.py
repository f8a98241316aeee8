"""An order of elimination in which little fills up: nested dissection.

The block is cut in two along its shorter extent; the models at the cut, which alone
hold the halves together, are eliminated last; each half is cut in the same way. For a
block of n models that spreads over an area the factor then has O(n log n) elements
and costs O(n^1.5) operations, which no other order can better (George 1973).
"""

from dataclasses import dataclass

import numba
import numpy as np

LEAF = 5  # models: smaller parts are eliminated as a whole
GOOD_CUT = 0.35  # of the smaller half; above, other directions are tried as well


@dataclass(frozen=True, eq=False)
class Elimination:
    """Order of elimination in fronts, groups of models that are eliminated together.

    Attributes
    ----------
    order : ndarray of int64, shape (n_models,)
        Models in their order.
    position : ndarray of int64, shape (n_models,)
        Place of each model in that order.
    start : ndarray of int64, shape (n_fronts + 1,)
        Front k eliminates the places ``start[k]:start[k + 1]``.
    parent : ndarray of int64, shape (n_fronts,)
        Front that takes over what a front leaves; −1 at a root. Children stand before
        their parents, and whole branches together.
    """

    order: np.ndarray
    position: np.ndarray
    start: np.ndarray
    parent: np.ndarray


def dissect(neighbours, positions) -> Elimination:
    """Order models by nested dissection.

    Parameters
    ----------
    neighbours : Neighbours
    positions : ndarray, shape (n_models, 2)
        Where the models lie, roughly; bad positions cost time, never correctness.

    Returns
    -------
    Elimination
    """
    xy = np.ascontiguousarray(positions, dtype=float)
    order, start, parent = _dissect(neighbours.start, neighbours.models, xy, LEAF)
    position = np.empty(len(order), dtype=np.int64)
    position[order] = np.arange(len(order))
    return Elimination(order, position, start, parent)


@numba.njit(cache=True, nogil=True)
def _put_smallest_first(models, key, count):
    """Partition, so that the ``count`` smallest keys stand first (Hoare's select)."""
    low, high = 0, models.size - 1
    while low < high:
        pivot = key[models[(low + high) // 2]]
        i, j = low, high
        while i <= j:
            while key[models[i]] < pivot:
                i += 1
            while key[models[j]] > pivot:
                j -= 1
            if i <= j:
                models[i], models[j] = models[j], models[i]
                i += 1
                j -= 1
        if count <= j:
            high = j
        elif count >= i:
            low = i
        else:
            return


@numba.njit(cache=True, nogil=True)
def _mark_boundary(models, own, other, side, start, neighbours, is_boundary):
    """Mark those of the models that have a neighbour on the other side; count them."""
    count = 0
    for m in models:
        is_boundary[m] = False
        if side[m] != own:
            continue
        for k in range(start[m], start[m + 1]):
            if side[neighbours[k]] == other:
                is_boundary[m] = True
                count += 1
                break
    return count


@numba.njit(cache=True, nogil=True)
def _levels(models, part, side, start, neighbours, key):
    """Distance of every model from one at the edge of its part, as a key."""
    queue = np.empty(models.size, dtype=np.int64)
    seed = models[0]
    for _ in range(2):
        for m in models:
            key[m] = -1.0
        head, tail, next_seed = 0, 1, 0
        queue[0] = seed
        key[seed] = 0.0
        while head < models.size:
            if head == tail:
                while key[models[next_seed]] >= 0.0:
                    next_seed += 1
                queue[tail] = models[next_seed]
                key[models[next_seed]] = key[queue[tail - 1]] + 1.0
                tail += 1
            m = queue[head]
            head += 1
            for k in range(start[m], start[m + 1]):
                other = neighbours[k]
                if side[other] == part and key[other] < 0.0:
                    key[other] = key[m] + 1.0
                    queue[tail] = other
                    tail += 1
        seed = queue[models.size - 1]


@numba.njit(cache=True, nogil=True)
def _cut(models, label, side, start, neighbours, xy, is_boundary, key):
    """Cut a part; reorders it as first half, second half, separator: their sizes."""
    n = models.size
    low0, high0, low1, high1 = np.inf, -np.inf, np.inf, -np.inf
    for m in models:
        side[m] = label
        low0, high0 = min(low0, xy[m, 0]), max(high0, xy[m, 0])
        low1, high1 = min(low1, xy[m, 1]), max(high1, xy[m, 1])
    longer = 0 if high0 - low0 >= high1 - low1 else 1
    best = n + 1
    best_models = models.copy()
    best_left = True
    half = n // 2
    for trial in range(3):
        if trial == 2:
            for m in models:
                side[m] = label
            _levels(models, label, side, start, neighbours, key)
        else:
            axis = longer if trial == 0 else 1 - longer
            for m in models:
                key[m] = xy[m, axis]
        _put_smallest_first(models, key, half)
        for i in range(n):
            side[models[i]] = label if i < half else label + 1
        left = _mark_boundary(
            models[:half], label, label + 1, side, start, neighbours, is_boundary
        )
        right = _mark_boundary(
            models[half:], label + 1, label, side, start, neighbours, is_boundary
        )
        if min(left, right) < best:
            best = min(left, right)
            best_left = left <= right
            best_models[:] = models
        if best <= GOOD_CUT * half:
            break
    models[:] = best_models
    for i in range(n):
        side[models[i]] = label if i < half else label + 1
    own = label if best_left else label + 1
    other = label + 1 if best_left else label
    _mark_boundary(models, own, other, side, start, neighbours, is_boundary)
    n_first, n_second = 0, 0
    for m in best_models:
        if side[m] == label and not is_boundary[m]:
            models[n_first] = m
            n_first += 1
    for m in best_models:
        if side[m] == label + 1 and not is_boundary[m]:
            models[n_first + n_second] = m
            n_second += 1
    place = n_first + n_second
    for m in best_models:
        if is_boundary[m]:
            models[place] = m
            place += 1
    return n_first, n_second


@numba.njit(cache=True, nogil=True)
def _dissect(start, neighbours, xy, leaf):
    n = start.size - 1
    order = np.arange(n)
    side = np.full(n, -1, dtype=np.int64)
    is_boundary = np.zeros(n, dtype=np.bool_)
    key = np.empty(n)
    label = 0
    # a node of the tree owns models[first:last] once its branches are cut off
    stack = np.empty((4 * 64 + 4, 4), dtype=np.int64)
    node_parent = np.empty(2 * n + 2, dtype=np.int64)
    front_of_node = np.full(2 * n + 2, -1, dtype=np.int64)
    node_of_front = np.empty(n + 1, dtype=np.int64)
    front_start = np.zeros(n + 2, dtype=np.int64)
    n_nodes, n_fronts, n_placed = 1, 0, 0
    node_parent[0] = -1
    result = np.empty(n, dtype=np.int64)
    # first, last, node, whether its branches are done
    stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = 0, n, 0, 0
    depth = 1
    while depth > 0:
        depth -= 1
        first, last, node = stack[depth, 0], stack[depth, 1], stack[depth, 2]
        is_cut = stack[depth, 3] == 1
        if not is_cut and last - first > leaf:
            n_first, n_second = _cut(
                order[first:last], label, side, start, neighbours, xy, is_boundary, key
            )
            label += 2
            if n_first + n_second > 0:
                middle, end = first + n_first, first + n_first + n_second
                stack[depth, 0], stack[depth, 1] = end, last
                stack[depth, 2], stack[depth, 3] = node, 1
                depth += 1
                for a, b in ((middle, end), (first, middle)):
                    if b > a:
                        node_parent[n_nodes] = node
                        stack[depth, 0], stack[depth, 1] = a, b
                        stack[depth, 2], stack[depth, 3] = n_nodes, 0
                        n_nodes += 1
                        depth += 1
                continue
        for i in range(first, last):
            result[n_placed] = order[i]
            n_placed += 1
        front_of_node[node] = n_fronts
        node_of_front[n_fronts] = node
        n_fronts += 1
        front_start[n_fronts] = n_placed
    parent = np.empty(n_fronts, dtype=np.int64)
    for f in range(n_fronts):
        above = node_parent[node_of_front[f]]
        parent[f] = -1 if above < 0 else front_of_node[above]
    return result, front_start[: n_fronts + 1].copy(), parent
