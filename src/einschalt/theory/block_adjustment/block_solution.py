"""All models of a block and all of its points in one adjustment."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from einschalt.theory.block_adjustment.adjusted_block import (
    AdjustedBlock,
    in_old_order,
)
from einschalt.theory.block_adjustment.axis_coupling import (
    Channels,
    ModelFrames,
    reduce_models,
)
from einschalt.theory.block_adjustment.common_parameters import (
    Deformation,
    deformation_of,
)
from einschalt.theory.block_adjustment.model_graph import incidence_of
from einschalt.theory.block_adjustment.observations import BlockObservations
from einschalt.theory.block_adjustment.solver import (
    Ordering,
    Solver,
    build_solver,
    order_block,
)

# common parameters are bilinear with the models; they move by 1e-4 in the first pass
MOST_PASSES = 6
SETTLED = 1e-13
# what orientations do to points [m] follows from models that they move by 1e-4
SETTLED_ON_GROUND = 1e-10
# share of a term that models and other terms must leave of it
LEAST_LEFT = 1e-8


class UndeterminedTermsError(np.linalg.LinAlgError):
    """The points of the models do not determine the common terms."""


@dataclass(frozen=True, eq=False)
class Bordered:
    """What the common parameters add, in the order of elimination.

    Attributes
    ----------
    cofactors : ndarray, shape (n_terms, n_terms)
    points, residuals, unknowns : ndarray, shape (n, 2 or n_unknowns, n_terms)
        How points, residuals and unknowns of the models move with each term.
    """

    cofactors: np.ndarray
    points: np.ndarray
    residuals: np.ndarray
    unknowns: np.ndarray

    def spread(self, motion):
        """Cofactors that follow from those of the common parameters."""
        return motion @ self.cofactors @ np.swapaxes(motion, 1, 2)


@dataclass(frozen=True, eq=False)
class BlockSolution(AdjustedBlock):
    """Adjusted block, in the order of the observations that were given.

    Attributes
    ----------
    observations : BlockObservations
    affinities : ndarray, shape (n_models, 2, 3)
        Every model as E, N = shift + coefficient of x + coefficient of y, of model
        coordinates as they were measured, or as ``xy`` where they were corrected.
    points : ndarray, shape (n_points, 2)
        Easting, northing [m].
    residuals : ndarray, shape (n_rows, 2)
        Transformed less adjusted [m].
    control_residuals : ndarray, shape (n_points, 2)
        Adjusted less given [m]; NaN where a point is no control, 0 where it is held.
    xy : ndarray, shape (n_rows, 2)
        Model coordinates, corrected by the common parameters.
    common : ndarray, shape (n_terms,)
        Coefficients of the deformation: ratios, or model units at the edge.
    common_cofactors : ndarray, shape (n_terms, n_terms)
    deformation : Deformation
    redundancy : int
    sum_of_squares : float
        Σ w v² of all observations, of the control, and of the orientations' errors.
    orientation : ndarray, shape (n_models, n_elements)
        Errors of the orientations as adjusted, over their standard errors.
    solver : Solver
    ordering : Ordering
    bordered : Bordered
        The last three in the order of elimination.
    reduced : ModelFrames
        Of the reduced coordinates in which the models were solved.
    """

    observations: BlockObservations
    affinities: np.ndarray
    points: np.ndarray
    residuals: np.ndarray
    control_residuals: np.ndarray
    xy: np.ndarray
    common: np.ndarray
    common_cofactors: np.ndarray
    deformation: Deformation
    redundancy: int
    sum_of_squares: float
    orientation: np.ndarray
    solver: Solver
    ordering: Ordering
    bordered: Bordered
    reduced: ModelFrames

    def readjusted(self, observations, terms):
        """Adjust the same block with other errors or given coordinates.

        Parameters
        ----------
        observations : BlockObservations
            Of the same models and points.
        terms : sequence of CommonTerms

        Returns
        -------
        BlockSolution
        """
        return adjust(observations, terms, self.ordering)

    @cached_property
    def point_cofactors(self):
        """Cofactors of the points, shape (n_points, 2, 2) [m²]."""
        solver = self.solver
        plane = solver.channels.plane(solver.cofactors.points)
        plane = plane + self.bordered.spread(self.bordered.points)
        return in_old_order(plane, self.ordering.reordered.points)

    @cached_property
    def adjusted_cofactors(self):
        """Cofactors of transformed less adjusted points, (n_rows, 2, 2) [m²]."""
        solver = self.solver
        differences = solver.cofactors.of_differences(solver.system.incidence.point)
        plane = solver.channels.plane(differences)
        plane = plane + self.bordered.spread(self.bordered.residuals)
        return in_old_order(plane, self.ordering.reordered.rows)

    @property
    def relative_errors(self):
        """Standard error of the linear part of each model, relative to that part.

        Returns
        -------
        ndarray, shape (n_models,)
            For σ_0 = 1; NaN where rounding has left no positive variance.
        """
        cofactors = np.diagonal(self.parameter_cofactors, axis1=1, axis2=2)[:, 2:]
        linear = self.affinities[:, :, 1:]
        scale = np.sqrt(np.sum(linear**2, axis=(1, 2)) / 2.0)
        largest = np.where(
            (cofactors >= 0.0).all(axis=1), cofactors.max(axis=1), np.nan
        )
        return np.sqrt(largest) / scale

    @cached_property
    def parameter_cofactors(self):
        """Cofactors of the parameters of each model in measured coordinates.

        Returns
        -------
        ndarray, shape (n_models, n_parameters, n_parameters)
            Order E0, N0, E_x, N_x, E_y, N_y, or E0, N0, a, b where all are helmert.
        """
        solver = self.solver
        own = solver.channels.unknown_cofactors(solver.model_cofactors)
        own = own + self.bordered.spread(self.bordered.unknowns)
        n_own = own.shape[1] - solver.channels.n_shared
        reduced = in_old_order(own[:, :n_own, :n_own], self.ordering.order)
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


def adjust(observations, terms=(), ordering=None) -> BlockSolution:
    """Adjust all models of a block with its control.

    Parameters
    ----------
    observations : BlockObservations
        Determined: see :mod:`einschalt.theory.block_adjustment.determinacy`.
    terms : sequence of CommonTerms
        Deformations that the models of a flight share.
    ordering : Ordering, optional
        Of the same models and points, from an earlier adjustment.

    Returns
    -------
    BlockSolution

    Raises
    ------
    UndeterminedTermsError
        The points of the models do not determine the common terms.
    """
    task = _Task(observations, terms, ordering)
    common = np.zeros(len(task.deformation.names))
    passed = task.pass_with(common, None)
    used = None
    for _ in range(MOST_PASSES):
        if task.is_settled(passed.common - common) and task.is_oriented(passed, used):
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
    solver: Solver
    bordered: Bordered
    frames: ModelFrames
    xy: np.ndarray


class _Task:
    """A block that is adjusted, in the order of elimination."""

    def __init__(self, observations, terms, ordering):
        self._given = observations
        if ordering is None:
            n_models, n_points = observations.n_models, observations.n_points
            incidence = incidence_of(
                observations.model, observations.point, n_models, n_points
            )
            near = reduce_models(observations.xy, observations.model, n_models)
            chained = near.xy * near.frames.extent[observations.model][:, None]
            ordering = order_block(incidence, chained)
        self.ordering = ordering
        self._rows = ordering.reordered.rows
        self._points = ordering.reordered.points
        self._fans = ordering.reordered.incidence
        control = observations.control[self._points]
        is_control = observations.is_control[self._points]
        # the origin lies among the control: sums far from it lose digits
        first = control[int(np.argmax(is_control))]
        self._origin = first + (control[is_control] - first).mean(axis=0)
        self._is_control = is_control
        self._control = np.where(is_control[:, None], control - self._origin, 0.0)
        self._xy = observations.xy[self._rows]
        self._weights = observations.standard_error[self._rows] ** -2.0
        self._prior = (
            observations.control_weight[self._points],
            observations.is_fixed[self._points],
        )
        self.deformation = deformation_of(observations, terms)
        self._channels = Channels(
            observations.is_affine[ordering.order], is_coupled=observations.is_coupled
        )
        self._columns = self.deformation.columns[self._rows]
        self._orientation = None
        self._oriented = self._channels
        if observations.orientation is not None:
            self._orientation = observations.orientation[self._rows]
            self._oriented = Channels(
                self._channels.is_affine,
                is_coupled=True,
                n_shared=self._orientation.shape[2],
            )

    def is_oriented(self, passed, used):
        """Whether models lie where the errors of their orientations took them for."""
        if self._orientation is None:
            return True
        if used is None:
            return False
        change = (passed.affinities - used)[self._fans.model][:, :, 1:]
        return np.abs(change @ self._orientation).max() <= SETTLED_ON_GROUND

    def is_settled(self, step):
        """Whether a step of the common parameters moves nothing any more."""
        reach = np.abs(self._columns).max(axis=(0, 1), initial=0.0)
        return (np.abs(step) * reach <= SETTLED * self.deformation.extent).all()

    def pass_with(self, common, affinities):
        """Adjust with model coordinates corrected by known common parameters."""
        # a block of millions of observations has no room for copies
        xy = self._xy if len(common) == 0 else self._xy + self._columns @ common
        reduced = reduce_models(xy, self._fans.model, self._fans.n_models)
        channels, shared = self._channels, None
        if self._orientation is not None and affinities is not None:
            linear = affinities[self._fans.model][:, :, 1:]
            channels, shared = self._oriented, linear @ self._orientation
        solver = build_solver(
            self.ordering, reduced.xy, self._weights, self._prior, channels, shared
        )
        frames = reduced.frames
        points, residuals, unknowns = self._without_common(solver)
        if affinities is None:
            affinities = _measured(channels.affinities(unknowns), frames)
        bordered = self._border(solver, affinities)
        shift = self._shift_of(residuals, affinities, bordered)
        unknowns = unknowns + bordered.unknowns @ shift
        return _Pass(
            common + shift,
            _measured(channels.affinities(unknowns), frames),
            points + bordered.points @ shift,
            residuals + bordered.residuals @ shift,
            unknowns[:, channels.n_unknowns - channels.n_shared :],
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
        n_models, n_points = self._fans.n_models, self._fans.n_points
        if n_terms == 0:
            return Bordered(
                np.zeros((0, 0)),
                np.zeros((n_points, 2, 0)),
                self._columns,
                np.zeros((n_models, channels.n_unknowns, 0)),
            )
        on_ground = affinities[self._fans.model][:, :, 1:] @ self._columns
        held = channels.split(np.zeros((n_points, 2, n_terms)))
        answer = solver.project(channels.split(-on_ground), held)
        residuals = channels.join(answer.residuals)
        weighted = on_ground * self._weights[:, None, None]
        normals = np.einsum("ncj,nck->jk", weighted, residuals)
        whole = np.einsum("ncj,ncj->j", weighted, on_ground)
        return Bordered(
            _inverse_of_common((normals + normals.T) / 2.0, whole),
            channels.join(answer.points),
            residuals,
            channels.unknowns(answer.parameters),
        )

    def _shift_of(self, residuals, affinities, bordered):
        """Step of the common parameters."""
        if self._columns.shape[2] == 0:
            return np.zeros(0)
        on_ground = affinities[self._fans.model][:, :, 1:] @ self._columns
        weighted = on_ground * self._weights[:, None, None]
        right = np.einsum("ncj,nc->j", weighted, residuals)
        return -bordered.cofactors @ right

    def solution(self, passed) -> BlockSolution:
        """Everything in the given order."""
        given, is_control = self._given, self._is_control
        control_residuals = np.full_like(passed.points, np.nan)
        control_residuals[is_control] = (passed.points - self._control)[is_control]
        known = np.nan_to_num(control_residuals)
        squares = np.sum(self._weights[:, None] * passed.residuals**2)
        squares += np.einsum("na,nab,nb->", known, self._prior[0], known)
        squares += np.sum(passed.orientation**2)
        n_unknowns = np.where(given.is_affine, 6, 4).sum() + len(passed.common)
        n_unknowns += 2 * int((~given.is_fixed).sum())
        n_observed = 2 * len(given.xy)
        n_observed += 2 * int((given.is_control & ~given.is_fixed).sum())
        affinities = passed.affinities.copy()
        affinities[:, :, 0] += self._origin
        order = self.ordering.order
        return BlockSolution(
            observations=given,
            affinities=in_old_order(affinities, order),
            points=in_old_order(passed.points + self._origin, self._points),
            residuals=in_old_order(passed.residuals, self._rows),
            control_residuals=in_old_order(control_residuals, self._points),
            xy=given.xy
            if passed.xy is self._xy
            else in_old_order(passed.xy, self._rows),
            common=passed.common,
            common_cofactors=passed.bordered.cofactors,
            deformation=self.deformation,
            redundancy=int(n_observed - n_unknowns),
            sum_of_squares=float(squares),
            orientation=in_old_order(passed.orientation, order),
            solver=passed.solver,
            ordering=self.ordering,
            bordered=passed.bordered,
            reduced=ModelFrames(
                in_old_order(passed.frames.centroid, order),
                in_old_order(passed.frames.extent, order),
            ),
        )


def _inverse_of_common(normals, whole):
    """Cofactors of common terms, of which the models have left this much.

    ``whole`` is the diagonal before the models took up what they can.
    """
    size = np.sqrt(np.where(whole > 0.0, whole, 1.0))
    scaled = normals / np.outer(size, size)
    # eigenvalues of what is no number are an error of another kind
    is_finite = np.isfinite(scaled).all()
    if not is_finite or np.linalg.eigvalsh(scaled)[0] <= LEAST_LEFT:
        raise UndeterminedTermsError("the points do not determine the common terms")
    return np.linalg.inv(scaled) / np.outer(size, size)


def _measured(affinities, frames):
    """Affinities of measured coordinates from those of reduced ones."""
    result = affinities / frames.extent[:, None, None]
    shift = np.einsum("nij,nj->ni", result[:, :, 1:], frames.centroid)
    result[:, :, 0] = affinities[:, :, 0] - shift
    return result
