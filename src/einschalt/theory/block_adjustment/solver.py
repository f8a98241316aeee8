"""The solver of a block: factored once, asked as often as needed."""

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from einschalt.foundations.sparse_cholesky.elimination_pattern import (
    BlockPattern,
    Fronts,
    block_pattern,
    find_fronts,
)
from einschalt.foundations.sparse_cholesky.multifrontal import Factor, factorize
from einschalt.foundations.sparse_cholesky.nested_dissection import at_once, dissect
from einschalt.theory.block_adjustment.axis_coupling import Channels
from einschalt.theory.block_adjustment.model_graph import (
    Reordered,
    chained_positions,
    neighbours_of,
)
from einschalt.theory.block_adjustment.point_elimination import (
    PointSystem,
    assemble,
    invert_point_blocks,
    point_cofactors,
)

# steps of iterative refinement: the first solves, the others take rounding away
MOST_STEPS = 6
CONVERGED = 1e-11
# unknowns, as real numbers, of a block that is one dense matrix: a few milliseconds
# more than by fronts, whose kernels take half a minute to compile
MOST_AT_ONCE = 1000


@dataclass(frozen=True, eq=False)
class Ordering:
    """What follows from which point lies in which model, whatever was measured."""

    reordered: Reordered
    order: np.ndarray  # (n_models,): old number of each model
    pattern: BlockPattern
    fronts: Fronts

    def has_outgrown(self, n_unknowns):
        """Whether models with so many unknowns are too many for the only front."""
        n_models = len(self.order)
        return self.fronts.are_one and not _is_small(n_models, n_unknowns)


def order_block(incidence, xy, n_unknowns) -> Ordering:
    """Find the order of elimination and what it fills.

    ``xy`` are model coordinates about the centre of each model, ``n_unknowns`` those
    of a model that are solved together; a complex one counts twice.
    """
    positions = partial(chained_positions, incidence, xy)
    return order_placed(incidence, positions, n_unknowns)


def order_placed(incidence, positions, n_unknowns) -> Ordering:
    """Find the order of elimination of models; ``positions()`` says where they lie."""
    neighbours = neighbours_of(incidence)
    if _is_small(incidence.n_models, n_unknowns):
        elimination = at_once(incidence.n_models)
    else:
        elimination = dissect(neighbours, positions())
    pattern = block_pattern(neighbours, elimination)
    fronts = find_fronts(pattern, elimination)
    return Ordering(
        incidence.reordered(elimination.order), elimination.order, pattern, fronts
    )


def _is_small(n_models, n_unknowns):
    """Whether a block is one dense matrix."""
    return n_models * n_unknowns <= MOST_AT_ONCE


@dataclass(frozen=True, eq=False)
class Projection:
    """Least-squares solution for given right sides."""

    parameters: np.ndarray  # (n_models, n_solved, n_right)
    points: np.ndarray  # (n_points, d, n_right)
    residuals: np.ndarray  # (n_rows, d, n_right): T − X − l


@dataclass(frozen=True, eq=False)
class Solver:
    """A factored block.

    All arrays are in the order of elimination.
    """

    system: PointSystem
    channels: Channels | None  # how easting and northing are arranged in it
    pattern: BlockPattern
    factor: Factor
    # (n_unknowns,): weight with which each unknown is 0 before it is observed
    prior: np.ndarray
    # (n_models, n_unknowns, n_unknowns): added to the normal equations of each model
    second: np.ndarray | None = None

    def project(self, shift, control, *, is_rough=False) -> Projection:
        """Adjust observations T − X = l (``shift``) and X = c (``control``).

        Both (n, d, n_right) [m]; a shift of 0.0 stands for all, c is 0 where a point is
        no control. A rough solution is not refined: for sums over the block.
        """
        system, incidence = self.system, self.system.incidence
        shape = (incidence.n_models, system.n_unknowns, control.shape[2])
        parameters = np.zeros(shape, dtype=system.design.dtype)
        last = np.inf
        # of parameters that are all 0; the next step refines them
        residuals = system.project(None, shift, control)[1]
        for _ in range(MOST_STEPS):
            gradient = system.gradient(residuals) + self.prior[:, None] * parameters
            if self.second is not None:
                gradient += self.second @ parameters
            step = self.factor.solve(gradient)
            size = np.abs(step).max(initial=0.0)
            if not np.isfinite(size):
                # handed on: parameters as they were would look like a solution
                return self._projection(parameters - step, shift, control)
            # rounding is all that is left once the steps grow no smaller
            if size >= 0.5 * last:
                break
            # the next step would be as much smaller than this one as this than the
            # last; the first says nothing of it
            expected = size * size / last if np.isfinite(last) else size
            parameters, last = parameters - step, size
            if is_rough or expected < CONVERGED:
                break
            residuals = system.project(parameters, shift, control)[1]
        return self._projection(parameters, shift, control)

    def _projection(self, parameters, shift, control):
        found = self.system.project(parameters, shift, control)
        return Projection(parameters, *found)

    @cached_property
    def inverse(self):
        """Blocks of the inverse that the normal equations have."""
        return self.factor.selected_inverse()

    @cached_property
    def cofactors(self):
        """Cofactors of points and observations: PointCofactors."""
        return point_cofactors(self.system, self.pattern, self.inverse)

    @property
    def model_cofactors(self):
        """Cofactors of the unknowns of each model, (n_models, n_solved, n_solved)."""
        return self.inverse[self.pattern.start[:-1]]


def build_solver(ordering, xy, weights, control, channels, further=()) -> Solver:
    """Assemble and factor a block of plane models.

    Arrays are in the order of elimination: reduced ``xy``, ``weights`` (n_rows,) of one
    coordinate [1/m²], and ``control``, the weight (n_points, 2, 2) of each point's
    given coordinates [1/m²] and whether they are held. ``further`` are ``shared`` and
    ``bent`` as :meth:`Channels.design` takes them.
    """
    model = ordering.reordered.incidence.model
    design = np.ascontiguousarray(channels.design(xy, model, *further))
    weight, is_fixed = control
    d = design.shape[1]
    return factor_block(
        ordering,
        design,
        np.repeat(weights[:, None], d, axis=1),
        (channels.control_weight(weight), is_fixed),
        channels.prior,
        channels,
    )


def factor_block(
    ordering, design, weights, control, prior, channels=None, second=None
) -> Solver:
    """Assemble and factor a block with any design, (n_rows, d, n_unknowns).

    Arrays are in the order of elimination: ``weights`` (n_rows, d), and ``control``,
    the weight (n_points, d, d) of each point's given coordinates [1/m²] and whether
    they are held, (n_points,), or which, (n_points, d); ``prior`` (n_unknowns,) that
    with which each unknown is 0 before it is observed. Without ``channels`` every model
    has every unknown. ``second``
    (n_models, n_unknowns, n_unknowns) is added to the normal equations.
    """
    incidence = ordering.reordered.incidence
    weight, is_held = control
    inverse = invert_point_blocks(incidence, weights, weight, is_held)
    is_fixed = is_held.reshape(len(is_held), -1).any(axis=1)
    system = PointSystem(incidence, design, weights, weight, is_fixed, inverse)
    blocks = assemble(system, ordering.pattern)
    if channels is not None:
        # unknowns that a model does not have stand alone
        models, unknowns = np.nonzero(channels.is_empty)
        blocks[ordering.pattern.start[models], unknowns, unknowns] = 1.0
    blocks[ordering.pattern.start[:-1]] += np.diag(prior)
    if second is not None:
        blocks[ordering.pattern.start[:-1]] += second
    factor = factorize(blocks, ordering.pattern, ordering.fronts)
    return Solver(system, channels, ordering.pattern, factor, prior, second)
