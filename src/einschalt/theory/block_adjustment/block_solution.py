"""All models of a block and all of its points in one adjustment."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from einschalt.theory.block_adjustment.adjusted_block import (
    AdjustedBlock,
    BlockInOrder,
    in_old_order,
    largest_error,
)
from einschalt.theory.block_adjustment.axis_coupling import (
    Channels,
    ModelFrames,
    reduce_models,
)
from einschalt.theory.block_adjustment.common_border import (
    Bordered,
    inverse_of_common,
    normals_of_common,
)
from einschalt.theory.block_adjustment.common_parameters import (
    CommonTerms,
    Deformation,
    deformation_of,
)
from einschalt.theory.block_adjustment.model_graph import incidence_of
from einschalt.theory.block_adjustment.solver import Solver, build_solver, order_block

# common parameters are bilinear with the models; they move by 1e-4 in the first pass
MOST_PASSES = 6
# share of the size of a model by which their last step moves a point; the next would
# be 1e-4 as large
SETTLED, ROUGHLY = 1e-13, 1e-5
# what orientations do to points [m] follows from models that they move by 1e-4
SETTLED_ON_GROUND = 1e-10


@dataclass(frozen=True, eq=False)
class BlockSolution(AdjustedBlock):
    """Adjusted block of plane models."""

    # (n_models, 2, 3): every model as E, N = shift + coefficient of x + coefficient of
    # y, of model coordinates as they were measured, or as ``xy`` where they were
    # corrected
    affinities: np.ndarray
    xy: np.ndarray  # (n_rows, 2): model coordinates, corrected by the common parameters
    # (n_terms,): coefficients of the deformation: ratios, or model units at the edge
    common: np.ndarray
    common_cofactors: np.ndarray  # (n_terms, n_terms)
    terms: tuple[CommonTerms, ...]  # deformations that the models of a flight share
    deformation: Deformation  # what these make of the observations
    # (n_models, n_elements): errors of the orientations as adjusted, over their
    # standard errors
    orientation: np.ndarray
    # (n_models, n_bent, 2): coefficients of each model's own deformation, likewise
    bent: np.ndarray
    reduced: ModelFrames  # of the reduced coordinates in which the models were solved

    def readjusted(self, observations, *, is_rough=False):
        """Adjust the same models and points with other errors or given coordinates.

        A rough solution is for sums over the block, and starts from this one.
        """
        if not is_rough:
            return adjust(observations, self.terms, self.ordering)
        start = self.common, self.affinities
        return adjust(observations, self.terms, self.ordering, start, is_rough=True)

    @property
    def linear(self):
        """Linear part of each model, from model to ground, (n_models, 2, 2)."""
        return self.affinities[:, :, 1:]

    def adjusted_anew(self, observations):
        """Adjust other observations with the same deformations."""
        return adjust(observations, self.terms)

    def with_terms(self, terms):
        """Adjust the same observations with other deformations."""
        return adjust(self.observations, terms, self.ordering)

    def answer_to(self, errors, control_errors, *, is_rough=False):
        """Errors of the points, and residuals, that follow from given errors.

        ``errors`` (n_rows, 2, n_draws) are of the measured points on the ground,
        ``control_errors`` (n_points, 2, n_draws) of the given coordinates, 0 where
        there are none [m]. Points (n_points, 2, n_draws), residuals as the errors [m].
        A rough answer is for sums over the block.
        """
        channels = self.solver.channels
        right = channels.split(-errors), channels.split(control_errors)
        found = self._projected(*right, is_rough=is_rough)
        points, residuals = map(channels.join, found)
        on_ground = self.linear[self.observations.model] @ self.deformation.columns
        return self._with_common(points, residuals, on_ground)

    def _cofactors(self, quantity):
        plane = self.solver.channels.plane(super()._cofactors(quantity))
        return self.bordered.with_spread(plane, getattr(self.bordered, quantity))

    @property
    def relative_errors(self):
        """Standard error of the linear part of each model, relative to that part.

        For σ_0 = 1; NaN where rounding has left no positive variance.
        """
        cofactors = np.diagonal(self.parameter_cofactors, axis1=1, axis2=2)[:, 2:]
        linear = self.affinities[:, :, 1:]
        scale = np.sqrt(np.sum(linear**2, axis=(1, 2)) / 2.0)
        return largest_error(cofactors) / scale

    @cached_property
    def unknown_cofactors(self):
        """Of everything unknown of each model, (n_models, n_unknowns, n_unknowns)."""
        solver = self.solver
        own = solver.channels.unknown_cofactors(solver.model_cofactors)
        own = self.bordered.with_spread(own, self.bordered.unknowns)
        return in_old_order(own, self.ordering.order)

    @property
    def log_determinant(self):
        """Of the normal equations without the points."""
        own = self.solver.factor.log_determinant
        # one complex pivot stands for two real ones, one real system for two axes
        own *= 1.0 if self.solver.channels.way == "coupled" else 2.0
        return own - np.linalg.slogdet(self.common_cofactors)[1]

    @cached_property
    def parameter_cofactors(self):
        """Cofactors of the parameters of each model in measured coordinates.

        Order E0, N0, E_x, N_x, E_y, N_y, or E0, N0, a, b where all are helmert.
        """
        n_own = self.solver.channels.n_parameters
        reduced = self.unknown_cofactors[:, :n_own, :n_own]
        jacobian = _to_measured(
            self.reduced, reduced.shape[1], self.observations.is_affine
        )
        return jacobian @ reduced @ np.swapaxes(jacobian, 1, 2)


def _to_measured(frames, n_unknowns, is_affine):
    """Jacobian from reduced to measured coordinates of the real unknowns."""
    n_models = len(frames.extent)
    jacobian = np.zeros((n_models, n_unknowns, n_unknowns))
    jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0
    per_unit = 1.0 / frames.extent
    x, y = frames.centroid.T * per_unit
    for k in range(2, n_unknowns):
        jacobian[:, k, k] = per_unit
    jacobian[:, 0, 2] = jacobian[:, 1, 3] = -x
    helmert = ~is_affine
    jacobian[helmert, 0, 3], jacobian[helmert, 1, 2] = y[helmert], -y[helmert]
    if n_unknowns == 6:
        jacobian[is_affine, 0, 4] = jacobian[is_affine, 1, 5] = -y[is_affine]
    return jacobian


def adjust(
    observations, terms=(), ordering=None, start=None, *, is_rough=False
) -> BlockSolution:
    """Adjust all models of a block with its control.

    The block is determined (see :mod:`.determinacy`); ``terms`` are deformations that
    the models of a flight share; an ``ordering`` comes from an earlier adjustment of
    the same models and points, and so does a ``start``: common parameters, and
    affinities. A rough solution is for sums over the block. Raises
    UndeterminedTermsError where the points of the models do not determine the terms.
    """
    task = _Task(observations, terms, ordering, is_rough=is_rough)
    common, used = np.zeros(len(task.deformation.names)), None
    if start is not None:
        common, used = start[0], start[1][task.ordering.order]
    passed = task.pass_with(common, used)
    for _ in range(MOST_PASSES):
        is_settled = task.is_settled(passed.common - common)
        if is_settled and task.is_oriented(passed, used):
            break
        common, used = passed.common, passed.affinities
        passed = task.pass_with(common, used)
    return task.solution(passed)


@dataclass(frozen=True, eq=False)
class _Pass:
    """One pass: everything in the order of elimination."""

    common: np.ndarray
    affinities: np.ndarray
    points: np.ndarray
    residuals: np.ndarray
    orientation: np.ndarray
    bent: np.ndarray
    solver: Solver
    bordered: Bordered
    frames: ModelFrames
    xy: np.ndarray


def _n_solved(observations):
    """Real unknowns of a model that are solved together."""
    is_coupled = observations.is_coupled or observations.orientation is not None
    n_bent = 0 if observations.bent is None else observations.bent.shape[1]
    channels = Channels(observations.is_affine, is_coupled=is_coupled, n_bent=n_bent)
    return 3 + n_bent if channels.way == "shared" else channels.n_unknowns


class _Task(BlockInOrder):
    """A plane block that is adjusted, in the order of elimination."""

    def __init__(self, observations, terms, ordering, *, is_rough=False):
        if ordering is None or ordering.has_outgrown(_n_solved(observations)):
            n_models, n_points = observations.n_models, observations.n_points
            incidence = incidence_of(
                observations.model, observations.point, n_models, n_points
            )
            near, frames = reduce_models(observations.xy, observations.model, n_models)
            chained = near * frames.extent[observations.model][:, None]
            ordering = order_block(incidence, chained, _n_solved(observations))
        super().__init__(observations, ordering)
        control = observations.control[self.points][self.is_control]
        # the origin lies among the control: sums far from it lose digits
        self._origin = control[0] + (control - control[0]).mean(axis=0)
        self._control = self.control_from(self._origin)
        self._xy = observations.xy.take(self.rows, axis=0)
        self._terms = tuple(terms)
        self._is_rough = is_rough
        self.deformation = deformation_of(observations, self._terms)
        self._bent = None
        if observations.bent is not None:
            self._bent = observations.bent[self.rows]
        n_bent = 0 if self._bent is None else self._bent.shape[1]
        self._channels = Channels(
            observations.is_affine[ordering.order],
            is_coupled=observations.is_coupled,
            n_bent=n_bent,
        )
        self._columns = self.deformation.columns[self.rows]
        self._orientation = None
        self._oriented = self._channels
        if observations.orientation is not None:
            self._orientation = observations.orientation[self.rows]
            self._oriented = Channels(
                self._channels.is_affine,
                is_coupled=True,
                n_shared=self._orientation.shape[2],
                n_bent=n_bent,
            )

    def is_oriented(self, passed, used):
        """Whether models lie where the errors of their orientations took them for."""
        if self._orientation is None:
            return True
        if used is None:
            return False
        change = (passed.affinities - used)[self.incidence.model][:, :, 1:]
        return np.abs(change @ self._orientation).max() <= SETTLED_ON_GROUND

    def is_settled(self, step):
        """Whether a step of the common parameters moves nothing any more."""
        settled = ROUGHLY if self._is_rough else SETTLED
        reach = np.abs(self._columns).max(axis=(0, 1), initial=0.0)
        return (np.abs(step) * reach <= settled * self.deformation.extent).all()

    def pass_with(self, common, affinities):
        """Adjust with model coordinates corrected by known common parameters."""
        # a block of millions of observations has no room for copies
        xy = self._xy if len(common) == 0 else self._xy + self._columns @ common
        incidence = self.incidence
        reduced, frames = reduce_models(xy, incidence.model, incidence.n_models)
        channels, shared = self._channels, None
        if self._orientation is not None and affinities is not None:
            linear = affinities[incidence.model][:, :, 1:]
            channels, shared = self._oriented, linear @ self._orientation
        solver = build_solver(
            self.ordering,
            reduced,
            self.weights,
            self.prior,
            channels,
            (shared, self._bent),
        )
        points, residuals, unknowns = self._without_common(solver)
        if affinities is None:
            affinities = _measured(channels.affinities(unknowns), frames)
        bordered = self._border(solver, affinities)
        shift = self._shift_of(residuals, affinities, bordered)
        if len(shift) > 0:
            points = points + bordered.points @ shift
            residuals = residuals + bordered.residuals @ shift
            unknowns = unknowns + bordered.unknowns @ shift
        return _Pass(
            common + shift,
            _measured(channels.affinities(unknowns), frames),
            points,
            residuals,
            *_further(unknowns, channels),
            solver,
            bordered,
            frames,
            xy,
        )

    def _without_common(self, solver):
        """Points, residuals and unknowns for the common parameters as they are."""
        channels = solver.channels
        own = solver.project(0.0, channels.split(self._control[:, :, None]))
        return (
            channels.join(own.points)[:, :, 0],
            channels.join(own.residuals)[:, :, 0],
            channels.unknowns(own.parameters)[:, :, 0],
        )

    def _border(self, solver, affinities):
        """How the block answers to the common parameters, and their cofactors."""
        channels, n_terms = solver.channels, self._columns.shape[2]
        n_models, n_points = self.incidence.n_models, self.incidence.n_points
        if n_terms == 0:
            return Bordered(
                np.zeros((0, 0)),
                np.zeros((n_points, 2, 0)),
                self._columns,
                np.zeros((n_models, channels.n_unknowns, 0)),
            )
        on_ground = affinities[self.incidence.model][:, :, 1:] @ self._columns
        held = channels.split(np.zeros((n_points, 2, n_terms)))
        right = channels.split(-on_ground), held
        answer = solver.project(*right, is_rough=self._is_rough)
        residuals = channels.join(answer.residuals)
        left = normals_of_common(on_ground, self.weights[:, None], residuals)
        return Bordered(
            inverse_of_common(*left),
            channels.join(answer.points),
            residuals,
            channels.unknowns(answer.parameters),
        )

    def _shift_of(self, residuals, affinities, bordered):
        """Step of the common parameters."""
        if self._columns.shape[2] == 0:
            return np.zeros(0)
        on_ground = affinities[self.incidence.model][:, :, 1:] @ self._columns
        weighted = on_ground * self.weights[:, None, None]
        right = np.einsum("ncj,nc->j", weighted, residuals)
        return -bordered.cofactors @ right

    def solution(self, passed) -> BlockSolution:
        """Everything in the given order."""
        given = self.given
        n_unknowns = np.where(given.is_affine, 6, 4).sum() + len(passed.common)
        common = self.common_fields(
            passed.points, passed.residuals, self._control, self._origin, n_unknowns
        )
        for coefficients in (passed.orientation, passed.bent):
            common["sum_of_squares"] += float(np.sum(coefficients**2))
        affinities = passed.affinities.copy()
        affinities[:, :, 0] += self._origin
        order = self.ordering.order
        return BlockSolution(
            **common,
            affinities=in_old_order(affinities, order),
            xy=in_old_order(passed.xy, self.rows) if len(passed.common) else given.xy,
            common=passed.common,
            common_cofactors=passed.bordered.cofactors,
            terms=self._terms,
            deformation=self.deformation,
            orientation=in_old_order(passed.orientation, order),
            bent=in_old_order(passed.bent, order),
            solver=passed.solver,
            bordered=passed.bordered,
            reduced=ModelFrames(
                in_old_order(passed.frames.centroid, order),
                in_old_order(passed.frames.extent, order),
            ),
        )


def _further(unknowns, channels):
    """Errors of orientations, and coefficients of own deformations, of each model."""
    after = channels.n_parameters + channels.n_shared
    bent = unknowns[:, after:].reshape(len(unknowns), channels.n_bent, 2)
    return unknowns[:, channels.n_parameters : after], bent


def _measured(affinities, frames):
    """Affinities of measured coordinates from those of reduced ones."""
    result = affinities / frames.extent[:, None, None]
    shift = np.einsum("nij,nj->ni", result[:, :, 1:], frames.centroid)
    result[:, :, 0] = affinities[:, :, 0] - shift
    return result
