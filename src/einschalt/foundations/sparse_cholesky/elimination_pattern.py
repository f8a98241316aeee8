"""Which blocks of the factor are not zero, front by front, before anything is factored.

A front is a dense matrix of the models that it eliminates and of those later ones that
these touch, directly or through what was eliminated before: its boundary.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.kernels import compiled, copy_values


@dataclass(frozen=True, eq=False)
class BlockPattern:
    """Blocks on and below the diagonal of the normal equations, as eliminated."""

    # (n_models + 1,): block column k has the blocks ``start[k]:start[k + 1]``
    start: np.ndarray
    # (n_blocks,): block row of each, ascending; the first of a column is its diagonal
    row: np.ndarray


@dataclass(frozen=True, eq=False)
class Fronts:
    """Fronts with their boundaries."""

    # (n_fronts + 1,): front k eliminates the places ``start[k]:start[k + 1]``
    start: np.ndarray
    parent: np.ndarray  # (n_fronts,)
    n_children: np.ndarray  # (n_fronts,)
    boundary_start: np.ndarray  # (n_fronts + 1,)
    boundary: np.ndarray  # places of the boundary of each front, ascending

    @property
    def are_one(self):
        """Whether everything is eliminated at once."""
        return len(self.parent) == 1

    @property
    def n_own(self):
        """Models that each front eliminates."""
        return np.diff(self.start)

    @property
    def n_boundary(self):
        """Models in the boundary of each front."""
        return np.diff(self.boundary_start)


def block_pattern(neighbours, elimination) -> BlockPattern:
    """Blocks of the normal equations in the order of elimination.

    ``neighbours`` are those of the models in their old order.
    """
    start, row = _pattern(
        neighbours.start, neighbours.models, elimination.order, elimination.position
    )
    return BlockPattern(start, row)


@compiled
def _pattern(start, neighbours, order, position):
    n = order.size
    column = np.empty(n + 1, dtype=np.int64)
    column[0] = 0
    for i in range(n):
        m, count = order[i], 1
        for k in range(start[m], start[m + 1]):
            if position[neighbours[k]] > i:
                count += 1
        column[i + 1] = column[i] + count
    row = np.empty(column[n], dtype=np.int64)
    for i in range(n):
        m, place = order[i], column[i]
        row[place] = i
        for k in range(start[m], start[m + 1]):
            j = position[neighbours[k]]
            if j > i:
                # insertion: a model has few neighbours
                place += 1
                slot = place
                while row[slot - 1] > j:
                    row[slot] = row[slot - 1]
                    slot -= 1
                row[slot] = j
    return column, row


def find_fronts(pattern, elimination) -> Fronts:
    """Boundaries of all fronts."""
    if len(elimination.parent) == 1:
        none = np.zeros(2, dtype=np.int64)
        return Fronts(elimination.start, elimination.parent, none[1:], none, none[:0])
    n_children, start, boundary = _boundaries(
        pattern.start, pattern.row, elimination.start, elimination.parent
    )
    # all at once: in the kernel a sort takes more than a second to compile
    n = elimination.start[-1]
    first = n * np.repeat(np.arange(len(start) - 1), np.diff(start))
    boundary = np.sort(first + boundary) - first
    return Fronts(elimination.start, elimination.parent, n_children, start, boundary)


@compiled
def _boundaries(column, row, front_start, parent):
    """Of each front in any order, and the number of its children."""
    n_fronts, n = parent.size, front_start[-1]
    n_children = np.zeros(n_fronts, dtype=np.int64)
    start = np.zeros(n_fronts + 1, dtype=np.int64)
    boundary = np.empty(4 * n + 64, dtype=np.int64)
    seen = np.full(n, -1, dtype=np.int64)
    found = np.empty(n, dtype=np.int64)
    # children of a front, as a linked list
    first_child = np.full(n_fronts, -1, dtype=np.int64)
    next_child = np.full(n_fronts, -1, dtype=np.int64)
    for f in range(n_fronts):
        last, count = front_start[f + 1], 0
        for i in range(front_start[f], last):
            for k in range(column[i], column[i + 1]):
                j = row[k]
                if j >= last and seen[j] != f:
                    seen[j] = f
                    found[count] = j
                    count += 1
        child = first_child[f]
        while child >= 0:
            for k in range(start[child], start[child + 1]):
                j = boundary[k]
                if j >= last and seen[j] != f:
                    seen[j] = f
                    found[count] = j
                    count += 1
            child = next_child[child]
        if start[f] + count > boundary.size:
            larger = np.empty(2 * boundary.size + count, dtype=np.int64)
            copy_values(larger[: start[f]], boundary[: start[f]])
            boundary = larger
        copy_values(boundary[start[f] : start[f] + count], found[:count])
        start[f + 1] = start[f] + count
        above = parent[f]
        if above >= 0:
            n_children[above] += 1
            next_child[f] = first_child[above]
            first_child[above] = f
    return n_children, start, boundary[: start[n_fronts]].copy()


@dataclass(frozen=True, eq=False)
class Storage:
    """How many numbers the factor holds, for a number of unknowns a model."""

    # (n_fronts + 1,): first element of each front's columns of the factor
    panel_start: np.ndarray
    largest: int  # unknowns of the largest front


def storage_for(fronts, n_unknowns) -> Storage:
    """Sizes of the factor and its fronts, with so many unknowns of each model."""
    own, boundary = n_unknowns * fronts.n_own, n_unknowns * fronts.n_boundary
    panel = np.concatenate([[0], np.cumsum((own + boundary) * own)])
    return Storage(panel, int((own + boundary).max(initial=0)))
