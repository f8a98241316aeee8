"""Branches of the tree of fronts, for cores that work side by side.

Fronts of different branches share nothing but what each branch leaves to the front
above it. So whole branches are given to the cores, and the trunk that holds them
together waits for all of them. Every front is computed in the same way wherever it is
computed, and takes up its children in the same order: results do not depend on the
number of cores, to the last bit.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from einschalt.foundations import batches
from einschalt.foundations.kernels import compiled

NO_BRANCH = -1  # in place of the root: the trunk
# multiplications below which threads cost more than they gain: some milliseconds
LEAST_WORK = 2e8
# of a core's share: smaller branches stay with the trunk
LEAST_SHARE = 0.02


@dataclass(frozen=True, eq=False)
class TreePart:
    """A branch, or the trunk."""

    root: int  # topmost front of a branch; ``NO_BRANCH`` for the trunk
    # its fronts, ascending; those of the trunk with the roots of the branches, which it
    # does not compute, in their places
    fronts: np.ndarray
    stack: int  # elements of the largest pile of updates that wait for their parents
    path: int  # elements of all its fronts on the longest way from a root down


@dataclass(frozen=True, eq=False)
class Branches:
    """Parts of the tree of fronts."""

    branches: tuple[TreePart, ...]  # the one with most work first
    trunk: TreePart  # all other fronts
    # (n_fronts,): where a branch leaves the square matrix of its boundary; −1 at other
    # fronts
    left_start: np.ndarray
    n_left: int  # elements of all these matrices

    def each(self, function):
        """Call a function with every branch, on all cores."""
        if self.branches:
            with ThreadPoolExecutor(batches.n_cores()) as pool:
                # the list asks for every answer, and so for what went wrong
                list(pool.map(function, self.branches))


def part_fronts(fronts, n_unknowns) -> Branches:
    """Find branches of which no core gets more than its share.

    There are none where there is one core or little work.
    """
    own, edge = n_unknowns * fronts.n_own, n_unknowns * fronts.n_boundary
    parent, work = fronts.parent, own * (own + edge).astype(float) ** 2
    first = np.arange(len(parent))
    _gather_upwards(work, first, parent)
    is_top = parent < 0
    total = work[is_top].sum()
    if batches.n_cores() == 1 or total <= LEAST_WORK:
        return unparted(fronts, n_unknowns)
    most = total / batches.n_cores()
    is_root = (work <= most) & (is_top | (work[parent] > most))
    roots = np.flatnonzero(is_root & (work > LEAST_SHARE * most))
    roots = roots[np.argsort(-work[roots], kind="stable")]
    return _parted(fronts, n_unknowns, roots, first)


def unparted(fronts, n_unknowns) -> Branches:
    """Leave all fronts in the trunk."""
    none = np.zeros(0, dtype=np.int64)
    return _parted(fronts, n_unknowns, none, none)


def _parted(fronts, n_unknowns, roots, first):
    own, edge = n_unknowns * fronts.n_own, n_unknowns * fronts.n_boundary
    parent = fronts.parent
    is_inside = np.zeros(len(parent), dtype=bool)
    for root in roots:
        is_inside[first[root] : root] = True
    size = edge[roots] ** 2
    left_start = np.full(len(parent), -1, dtype=np.int64)
    left_start[roots] = np.cumsum(size) - size
    arrays = own, edge, parent, fronts.n_children, left_start
    trunk = np.flatnonzero(~is_inside)
    return Branches(
        tuple(_part(root, np.arange(first[root], root + 1), arrays) for root in roots),
        _part(NO_BRANCH, trunk, arrays),
        left_start,
        int(size.sum()),
    )


def _part(root, visited, arrays):
    stack, path = _room(root, visited, *arrays)
    return TreePart(int(root), visited, int(stack), int(path))


@compiled
def _room(own_root, visited, own, edge, parent, n_children, left_start):
    """Elements of stack and path; see ``TreePart``."""
    waiting = np.empty(visited.size, dtype=np.int64)
    top, pile, largest_pile = 0, 0, 0
    for f in visited:
        if left_start[f] < 0 or f == own_root:
            for _ in range(n_children[f]):
                top -= 1
                pile -= waiting[top]
        waiting[top] = edge[f] ** 2
        pile += waiting[top]
        top += 1
        largest_pile = max(largest_pile, pile)
    path = np.zeros(parent.size, dtype=np.int64)
    longest = 0
    for f in visited[::-1]:
        if left_start[f] >= 0 and f != own_root:
            continue
        above = 0 if f == own_root or parent[f] < 0 else path[parent[f]]
        path[f] = above + (own[f] + edge[f]) ** 2
        longest = max(longest, path[f])
    return largest_pile, longest


@compiled
def _gather_upwards(work, first, parent):
    """Add up the work of each branch; find its first front."""
    for f in range(parent.size):
        above = parent[f]
        if above >= 0:
            work[above] += work[f]
            first[above] = min(first[above], first[f])
