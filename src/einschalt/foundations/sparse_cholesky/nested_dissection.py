"""An order of elimination in which little fills up: nested dissection.

The block is cut in two along its shorter extent, about in the middle, where fewest
models hold the halves together; these are eliminated last, and each half is cut in the
same way. For a block of n models that spreads over an area the factor then has
O(n log n) elements and costs O(n^1.5) operations, which no other order can better
(George 1973).
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from einschalt.foundations import batches
from einschalt.foundations.kernels import compiled, copy_values

LEAF = 5  # models: smaller parts are eliminated as a whole
LEAST_PART = 0.3  # of a part, that either half of it has
# of a half: with more models at the cut, other directions are tried as well
GOOD_CUT = 0.35
MODELS_WORTH_A_THREAD = 10_000  # more than a leaf, or the order would change


@dataclass(frozen=True, eq=False)
class Elimination:
    """Order of elimination in fronts, groups of models that are eliminated together."""

    order: np.ndarray  # (n_models,): models in their order
    position: np.ndarray  # (n_models,): place of each model in that order
    # (n_fronts + 1,): front k eliminates the places ``start[k]:start[k + 1]``
    start: np.ndarray
    # (n_fronts,): front that takes over what a front leaves; −1 at a root. Children
    # stand before their parents, and whole branches together
    parent: np.ndarray


def at_once(n_models) -> Elimination:
    """Models in the order that they have, in one front."""
    order = np.arange(n_models)
    return Elimination(order, order, np.array([0, n_models]), np.array([-1]))


def dissect(neighbours, positions) -> Elimination:
    """Order models by nested dissection.

    ``positions`` say roughly where they lie; bad ones cost time, never correctness.
    """
    xy = np.ascontiguousarray(positions, dtype=float)
    # of one layout: for another one all of it would be compiled again
    start, models = map(np.ascontiguousarray, (neighbours.start, neighbours.models))
    n = len(start) - 1
    scratch = np.zeros(n, dtype=bool), np.empty(n), np.empty(n, dtype=np.int64)
    given = np.full(n, -1), start, models, xy, *scratch
    order, start, parent = _dissected(np.arange(n), 0, given, batches.n_cores())
    position = np.empty(len(order), dtype=np.int64)
    position[order] = np.arange(len(order))
    return Elimination(order, position, start, parent)


def _dissected(models, label, given, n_cores):
    """Order, fronts and parents of a part; its halves side by side where it is large.

    The halves write of their own models only, and are labelled apart, so that neither
    takes models of the other for its own.
    """
    if n_cores < 2 or len(models) < MODELS_WORTH_A_THREAD:
        return _dissect(models, label, *given, LEAF)
    n_first, n_second = _cut(models, label, *given)
    if n_first + n_second == 0:
        return _dissect(models, label, *given, LEAF)
    end = n_first + n_second
    labels = label + 2, label + 2 + 2 * (2 * n_first + 2)
    with ThreadPoolExecutor(1) as pool:
        half = n_cores // 2
        first = pool.submit(_dissected, models[:n_first], labels[0], given, half)
        second = _dissected(models[n_first:end], labels[1], given, n_cores - half)
        parts = [part for part in (first.result(), second) if len(part[0]) > 0]
    return _joined(parts, models[end:])


def _joined(parts, separator):
    """Put the fronts of parts one after the other, and below that of the separator."""
    n_fronts, n_placed = 0, 0
    orders, starts, parents = [], [], []
    last = sum(len(part[2]) for part in parts)
    for order, start, parent in parts:
        orders.append(order)
        starts.append(n_placed + start[:-1])
        parents.append(np.where(parent < 0, last, n_fronts + parent))
        n_placed, n_fronts = n_placed + len(order), n_fronts + len(parent)
    return (
        np.concatenate([*orders, separator]),
        np.concatenate([*starts, [n_placed, n_placed + len(separator)]]),
        np.append(np.concatenate(parents), -1),
    )


@compiled
def _best_place(models, rank, side, part, start, neighbours):
    """Where to cut a sorted part: models of the first half, and of its separator.

    A model stands at the edge of the first half while the cut lies between it and the
    last of its neighbours, at the edge of the second half from the first of them on.
    """
    n = models.size
    for i in range(n):
        rank[models[i]] = i
    change = np.zeros((2, n + 1), dtype=np.int64)
    for i in range(n):
        m = models[i]
        first, last = i, i
        for k in range(start[m], start[m + 1]):
            other = neighbours[k]
            if side[other] == part:
                first, last = min(first, rank[other]), max(last, rank[other])
        change[0, i + 1] += 1
        change[0, last + 1] -= 1
        change[1, first + 1] += 1
        change[1, i + 1] -= 1
    best, place, least = np.inf, n // 2, n
    left, right = 0, 0
    for cut in range(1, n):
        left += change[0, cut]
        right += change[1, cut]
        size = min(left, right)
        if cut < LEAST_PART * n or n - cut < LEAST_PART * n:
            continue
        cost = (size + 0.5) / (cut * float(n - cut))
        if cost < best:
            best, place, least = cost, cut, size
    return place, least


@compiled
def _mark_boundary(models, other, side, start, neighbours, is_boundary):
    """Mark those of the models that have a neighbour on the other side; count them."""
    count = 0
    for m in models:
        is_boundary[m] = False
        for k in range(start[m], start[m + 1]):
            if side[neighbours[k]] == other:
                is_boundary[m] = True
                count += 1
                break
    return count


@compiled
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


@compiled
def _sort(models, key):
    """Sort models by their keys; those with the same one stay in their order.

    By merging ever longer runs: numba's own stable sort takes 1 s to compile.
    """
    n = models.size
    given, merged = models.copy(), np.empty_like(models)
    width = 1
    while width < n:
        for begin in range(0, n, 2 * width):
            middle, end = min(begin + width, n), min(begin + 2 * width, n)
            left, right = begin, middle
            for k in range(begin, end):
                is_left = left < middle
                if is_left and right < end:
                    is_left = key[given[left]] <= key[given[right]]
                if is_left:
                    merged[k] = given[left]
                    left += 1
                else:
                    merged[k] = given[right]
                    right += 1
        given, merged = merged, given
        width *= 2
    copy_values(models, given)


@compiled
def _cut(models, label, side, start, neighbours, xy, is_boundary, key, rank):
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
    half = n // 2
    for trial in range(3):
        for m in models:
            side[m] = label
        if trial == 2:
            _levels(models, label, side, start, neighbours, key)
        else:
            axis = longer if trial == 0 else 1 - longer
            for m in models:
                key[m] = xy[m, axis]
        _sort(models, key)
        place, size = _best_place(models, rank, side, label, start, neighbours)
        if size < best:
            best, half = size, place
            copy_values(best_models, models)
        if best <= GOOD_CUT * (n // 2):
            break
    copy_values(models, best_models)
    for i in range(n):
        side[models[i]] = label if i < half else label + 1
    left = _mark_boundary(
        models[:half], label + 1, side, start, neighbours, is_boundary
    )
    right = _mark_boundary(models[half:], label, side, start, neighbours, is_boundary)
    if left <= right:
        is_boundary[models[half:]] = False
    else:
        is_boundary[models[:half]] = False
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


@compiled
def _dissect(order, label, side, start, neighbours, xy, is_boundary, key, rank, leaf):
    n = order.size
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
            part = order[first:last]
            n_first, n_second = _cut(
                part, label, side, start, neighbours, xy, is_boundary, key, rank
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
