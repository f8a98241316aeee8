"""Cholesky factor, solutions and selected inverse, front by front.

Every front collects its part of the normal equations and what its children left,
eliminates its own models with dense LAPACK, and leaves an update to its parent
(multifrontal method, Duff and Reid 1983). The way back down gives the elements of the
inverse where the normal equations have any (Erisman and Tinney 1975):

    Z_bs = −Z_bb Y,   Z_ss = (L_ss L_ssᴴ)⁻¹ − Yᴴ Z_bs,   Y = L_bs L_ss⁻¹,

s the models that a front eliminates and b its boundary, whose Z_bb the parent knows.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from einschalt.foundations.blas_threads import one_blas_thread
from einschalt.foundations.sparse_cholesky.dense_kernels import work_arrays
from einschalt.foundations.sparse_cholesky.elimination_pattern import (
    BlockPattern,
    Fronts,
    Storage,
    storage_for,
)
from einschalt.foundations.sparse_cholesky.front_branches import part_fronts, unparted
from einschalt.foundations.sparse_cholesky.front_factorization import (
    HELD,
    factor_fronts,
)
from einschalt.foundations.sparse_cholesky.front_solution import (
    solve_backward,
    solve_forward,
)
from einschalt.foundations.sparse_cholesky.selected_inverse import invert_fronts
from einschalt.foundations.sparse_cholesky.single_front import (
    factor_whole,
    invert_whole,
    solve_whole,
)

# of the factor, once for each right side: below it threads cost a solution, which only
# passes over the factor, more than they gain; some milliseconds
BYTES_WORTH_BRANCHES = 1e8


@dataclass(frozen=True, eq=False)
class Factor:
    """Cholesky factor of the reduced normal equations."""

    pattern: BlockPattern
    fronts: Fronts
    storage: Storage
    panels: np.ndarray  # columns of the factor, front after front
    # (n_models, n_unknowns): unknowns, in the order of elimination, that nothing
    # determines
    is_held: np.ndarray

    @property
    def n_unknowns(self):
        """Unknowns of each model."""
        return self.is_held.shape[1]

    @cached_property
    def log_determinant(self):
        """Logarithm of the determinant, without what is held."""
        fronts = self.fronts
        own = np.diff(fronts.start) * self.n_unknowns
        size = own + np.diff(fronts.boundary_start) * self.n_unknowns
        first = np.repeat(self.storage.panel_start[:-1], own)
        within = np.arange(own.sum()) - np.repeat(np.cumsum(own) - own, own)
        diagonal = self.panels[first + within * np.repeat(size + 1, own)].real
        return 2.0 * float(np.log(diagonal[diagonal < HELD]).sum())

    def solve(self, right_sides):
        """Solve for several right sides, (n_models, n_unknowns, n_right).

        0 for what is held.
        """
        n_models, n_unknowns, n_right = right_sides.shape
        x = np.moveaxis(right_sides, 2, 0).reshape(n_right, -1)
        x = np.ascontiguousarray(x, dtype=self.panels.dtype).copy()
        self._solve_in_place(x)
        return np.moveaxis(x.reshape(n_right, n_models, n_unknowns), 0, 2)

    def null_vector(self, place, unknown):
        """How everything moves with an unknown that nothing determines.

        ``place`` and ``unknown`` are those of one of ``is_held``.
        """
        x = np.zeros((1, self.is_held.size), dtype=self.panels.dtype)
        x[0, place * self.n_unknowns + unknown] = HELD
        self._solve_in_place(x, is_forward_done=True)
        return x.reshape(self.is_held.shape)

    @cached_property
    def _branches(self):
        return part_fronts(self.fronts, self.n_unknowns)

    @cached_property
    def _trunk_alone(self):
        return unparted(self.fronts, self.n_unknowns)

    def _solve_in_place(self, x, *, is_forward_done=False):
        fronts, u = self.fronts, self.n_unknowns
        if fronts.are_one:
            with one_blas_thread():
                solve_whole(x, self.panels, is_forward_done=is_forward_done)
            return
        is_large = self.panels.nbytes * len(x) > BYTES_WORTH_BRANCHES
        branches = self._branches if is_large else self._trunk_alone
        panels = self.panels, self.storage.panel_start
        tree = fronts.start, fronts.n_children, fronts.boundary_start, fronts.boundary
        roots = np.array([part.root for part in branches.branches], dtype=np.int64)
        n_left = u * fronts.n_boundary[roots]
        left_start = np.full(len(fronts.parent), -1, dtype=np.int64)
        left_start[roots] = np.cumsum(n_left) - n_left
        left = np.empty((len(x), n_left.sum()), dtype=x.dtype)

        def pass_with(kernel):
            def solve(part):
                own = part.root, part.fronts, left_start, left
                kernel(x, *panels, tree, own, u, work_arrays(x.dtype))

            return solve

        with one_blas_thread():
            if not is_forward_done:
                branches.each(pass_with(solve_forward))
                pass_with(solve_forward)(branches.trunk)
            pass_with(solve_backward)(branches.trunk)
            branches.each(pass_with(solve_backward))

    def selected_inverse(self):
        """Blocks of the inverse where the normal equations have any, in their order.

        (n_blocks, n_unknowns, n_unknowns), on and below the diagonal.
        """
        fronts, n_unknowns = self.fronts, self.n_unknowns
        if fronts.are_one:
            with one_blas_thread():
                return invert_whole(self.panels, self.pattern, n_unknowns)
        shape = (len(self.pattern.row), n_unknowns, n_unknowns)
        inverse = np.zeros(shape, dtype=self.panels.dtype)
        branches = self._branches
        left = np.empty(branches.n_left, dtype=inverse.dtype)
        pattern = self.pattern.start, self.pattern.row
        panels = self.panels, self.storage.panel_start
        tree = fronts.start, fronts.parent, fronts.boundary_start, fronts.boundary

        def invert(part):
            own = part.root, part.fronts, branches.left_start, left
            work = work_arrays(inverse.dtype)
            invert_fronts(inverse, pattern, *panels, tree, own, part.path, work)

        with one_blas_thread():
            invert(branches.trunk)
            branches.each(invert)
        return inverse


def factorize(blocks, pattern, fronts) -> Factor:
    """Factor the reduced normal equations, float or complex blocks of the pattern."""
    n_unknowns = blocks.shape[1]
    storage = storage_for(fronts, n_unknowns)
    if fronts.are_one:
        with one_blas_thread():
            return Factor(pattern, fronts, storage, *factor_whole(blocks, pattern))
    panels = np.zeros(storage.panel_start[-1], dtype=blocks.dtype)
    is_held = np.zeros((len(pattern.start) - 1, n_unknowns), dtype=np.bool_)
    branches = part_fronts(fronts, n_unknowns)
    left = np.empty(branches.n_left, dtype=blocks.dtype)

    tree = fronts.start, fronts.parent, fronts.n_children
    tree = *tree, fronts.boundary_start, fronts.boundary

    def factor(part):
        factor_fronts(
            blocks,
            (pattern.start, pattern.row),
            panels,
            storage.panel_start,
            tree,
            (part.root, part.fronts, branches.left_start, left),
            (part.stack, storage.largest),
            is_held,
            work_arrays(blocks.dtype),
        )

    with one_blas_thread():
        branches.each(factor)
        factor(branches.trunk)
    return Factor(pattern, fronts, storage, panels, is_held)
