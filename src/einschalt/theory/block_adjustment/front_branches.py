"""Branches of the tree of fronts, for cores that work side by side.

Fronts of different branches share nothing but what each branch leaves to the front
above it. So whole branches are given to the cores, and the trunk that holds them
together waits for all of them. Every front is computed in the same way wherever it is
computed, and takes up its children in the same order: results do not depend on the
number of cores, to the last bit.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numba
import numpy as np

from einschalt.foundations import batches

NO_BRANCH = -1  # in place of the root: the trunk
# multiplications below which threads cost more than they gain: some milliseconds
LEAST_WORK = 1e8
# of a core's share: smaller branches stay with the trunk
LEAST_SHARE = 0.02


@dataclass(frozen=True, eq=False)
class Branches:
    """Parts of the tree of fronts.

    Attributes
    ----------
    roots : ndarray of int64, shape (n_branches,)
        Topmost front of each branch, the branch with most work first.
    first : ndarray of int64, shape (n_branches,)
        A branch has the fronts from ``first`` to its root, without a gap.
    trunk : ndarray of int64
        All other fronts and, in their places among these, the roots of the branches.
    left_start : ndarray of int64, shape (n_fronts,)
        Where a branch leaves the square matrix of its boundary; −1 at other fronts.
    n_left : int
        Elements of all these matrices.
    """

    roots: np.ndarray
    first: np.ndarray
    trunk: np.ndarray
    left_start: np.ndarray
    n_left: int

    def each(self, function):
        """Call a function with every branch, on all cores.

        Parameters
        ----------
        function : callable
            Of the root of a branch and of its fronts, ascending.
        """
        if len(self.roots) == 0:
            return
        fronts = [
            np.arange(first, root + 1)
            for first, root in zip(self.first, self.roots, strict=True)
        ]
        with ThreadPoolExecutor(batches.n_cores()) as pool:
            # the list asks for every answer, and so for what went wrong
            list(pool.map(function, self.roots.tolist(), fronts))


def part_fronts(fronts, n_unknowns) -> Branches:
    """Find branches of which no core gets more than its share.

    Parameters
    ----------
    fronts : Fronts
    n_unknowns : int
        Of each model.

    Returns
    -------
    Branches
        Without any, where there is one core or little work.
    """
    own, edge = n_unknowns * fronts.n_own, n_unknowns * fronts.n_boundary
    parent, work = fronts.parent, own * (own + edge).astype(float) ** 2
    first = np.arange(len(parent))
    _gather_upwards(work, first, parent)
    is_top = parent < 0
    total, most = work[is_top].sum(), 0.0
    if batches.n_cores() > 1 and total > LEAST_WORK:
        most = total / batches.n_cores()
    is_root = (work <= most) & (is_top | (work[parent] > most))
    roots = np.flatnonzero(is_root & (work > LEAST_SHARE * most))
    roots = roots[np.argsort(-work[roots], kind="stable")]
    is_inside = np.zeros(len(parent), dtype=bool)
    for root, begin in zip(roots, first[roots], strict=True):
        is_inside[begin:root] = True
    size = edge[roots] ** 2
    left_start = np.full(len(parent), -1, dtype=np.int64)
    left_start[roots] = np.cumsum(size) - size
    trunk = np.flatnonzero(~is_inside)
    return Branches(roots, first[roots], trunk, left_start, int(size.sum()))


@numba.njit(cache=True, nogil=True)
def _gather_upwards(work, first, parent):
    """Add up the work of each branch; find its first front."""
    for f in range(parent.size):
        above = parent[f]
        if above >= 0:
            work[above] += work[f]
            first[above] = min(first[above], first[f])
