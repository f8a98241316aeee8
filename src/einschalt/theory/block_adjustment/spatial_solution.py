"""All spatial models of a block in one adjustment, each with seven parameters.

Gauss-Newton: a small step of a model about its centroid moves a point by

    dT = dt + dλ a + dω × a,    a = s R (x − c),

with shift, relative scale and turn in units of its extent, the root mean square of a.
Points are eliminated and the models are factored front by front as in the plane, with
three rows a point and seven unknowns a model; the last linearisation gives every
variance.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from einschalt.foundations.rotations import cross_matrix, rotation_by_vector
from einschalt.theory.block_adjustment.adjusted_block import (
    AdjustedBlock,
    in_old_order,
)
from einschalt.theory.block_adjustment.model_graph import incidence_of
from einschalt.theory.block_adjustment.solver import (
    Ordering,
    Solver,
    factor_block,
    order_block,
)
from einschalt.theory.block_adjustment.spatial_observations import SpatialObservations
from einschalt.theory.block_adjustment.spatial_start import Placement, place_models
from einschalt.theory.transformation.helmert_3d import (
    angles_of,
    parameters_from_step,
)

MOST_PASSES = 50
# a step that is as small as this changes nothing but its own square [m]
SETTLED = 1e-7
N_UNKNOWNS = 7


class NoConvergenceError(ArithmeticError):
    """The adjustment of the spatial models does not converge."""


@dataclass(frozen=True, eq=False)
class SpatialSolution(AdjustedBlock):
    """Adjusted block of spatial models, in the order of the observations.

    Attributes
    ----------
    observations : SpatialObservations
    placement : Placement
        Of the adjusted models.
    points : ndarray, shape (n_points, 3)
        Easting, northing, height [m].
    residuals : ndarray, shape (n_rows, 3)
        Transformed less adjusted [m].
    control_residuals : ndarray, shape (n_points, 3)
        Adjusted less given [m]; NaN where a point is no control, 0 where it is held.
    extent : ndarray, shape (n_models,)
        Root mean square distance of the points of each model from its centroid, on the
        ground [m]: unit of its scale and turn.
    redundancy : int
    sum_of_squares : float
        Σ w v² of all observations and of the control.
    solver : Solver
    ordering : Ordering
        The last two in the order of elimination.
    """

    observations: SpatialObservations
    placement: Placement
    points: np.ndarray
    residuals: np.ndarray
    control_residuals: np.ndarray
    extent: np.ndarray
    redundancy: int
    sum_of_squares: float
    solver: Solver
    ordering: Ordering

    def readjusted(self, observations, _terms=()):
        """Adjust the same block with other errors or given coordinates.

        Parameters
        ----------
        observations : SpatialObservations
            Of the same models and points.

        Returns
        -------
        SpatialSolution
        """
        return _Task(observations, self.ordering).solve(self.placement)

    @cached_property
    def point_cofactors(self):
        """Cofactors of the points, shape (n_points, 3, 3) [m²]."""
        points = self.solver.cofactors.points
        return in_old_order(points, self.ordering.reordered.points)

    @cached_property
    def adjusted_cofactors(self):
        """Cofactors of transformed less adjusted points, (n_rows, 3, 3) [m²]."""
        solver = self.solver
        differences = solver.cofactors.of_differences(solver.system.incidence.point)
        return in_old_order(differences, self.ordering.reordered.rows)

    @property
    def relative_errors(self):
        """Standard error of scale and turn of each model, relative.

        Returns
        -------
        ndarray, shape (n_models,)
            For σ_0 = 1; NaN where rounding has left no positive variance.
        """
        own = np.diagonal(self._step_cofactors, axis1=1, axis2=2)[:, 3:]
        largest = np.where((own >= 0.0).all(axis=1), own.max(axis=1), np.nan)
        return np.sqrt(largest)

    @cached_property
    def _step_cofactors(self):
        """Of shift, relative scale and turn about the centroid."""
        own = in_old_order(self.solver.model_cofactors, self.ordering.order)
        unit = np.ones((len(own), N_UNKNOWNS))
        unit[:, 3:] = 1.0 / self.extent[:, None]
        return own * unit[:, :, None] * unit[:, None, :]

    @cached_property
    def parameters(self):
        """Parameters te, tn, th, scale, ω, φ, κ, shape (n_models, 7)."""
        place = self.placement
        shift = place.centre + place.origin
        shift -= np.einsum("nij,nj->ni", place.matrix, place.centroid)
        return np.column_stack([shift, place.scale, angles_of(place.rotation)])

    @cached_property
    def parameter_cofactors(self):
        """Cofactors of the parameters, shape (n_models, 7, 7)."""
        place = self.placement
        jacobian = parameters_from_step(place.scale, place.rotation, place.centroid)
        jacobian[:, :, 3] *= place.scale[:, None]  # of the relative scale
        return jacobian @ self._step_cofactors @ np.swapaxes(jacobian, 1, 2)


def adjust_spatially(observations, start=None) -> SpatialSolution:
    """Adjust all spatial models of a block with its control.

    Parameters
    ----------
    observations : SpatialObservations
        Determined.
    start : Placement, optional
        Of the same models; without one they must stand upright but for some degrees.

    Returns
    -------
    SpatialSolution

    Raises
    ------
    NoConvergenceError
    """
    plan = observations.in_plan(is_affine=True)
    incidence = incidence_of(plan.model, plan.point, plan.n_models, plan.n_points)
    if start is None:
        start = place_models(observations)
    chained = plan.xy - start.centroid[plan.model][:, :2]
    return _Task(observations, order_block(incidence, chained)).solve(start)


class _Task:
    """A block that is adjusted, in the order of elimination."""

    def __init__(self, observations, ordering):
        self._given = observations
        self._ordering = ordering
        self._rows = ordering.reordered.rows
        self._points = ordering.reordered.points
        self._model = ordering.reordered.incidence.model
        self._xyz = observations.xyz[self._rows]
        self._weights = observations.standard_error[self._rows] ** -2.0
        self._prior = (
            observations.control_weight[self._points],
            observations.is_fixed[self._points],
        )
        self._control = observations.control[self._points]
        self._is_control = observations.is_control[self._points]

    def solve(self, start) -> SpatialSolution:
        """Iterate from a start."""
        order = self._ordering.order
        place = replace(
            start,
            **{
                name: getattr(start, name)[order]
                for name in ("centroid", "centre", "scale", "rotation")
            },
        )
        control = np.where(self._is_control[:, None], self._control - place.origin, 0.0)
        last = np.inf
        for _ in range(MOST_PASSES):
            arm = self._arms(place)
            extent = self._extents(arm)
            solver = self._factored(arm, extent)
            shift = -(place.centre[self._model] + arm)
            found = solver.project(shift[:, :, None], control[:, :, None])
            step = found.parameters[:, :, 0]
            size = np.abs(step).max()
            place = _moved(place, step, extent)
            if size < SETTLED:
                return self._solution(place, control, found, (solver, extent))
            if not np.isfinite(size) or (size > last > 1e6 * SETTLED):
                break
            last = size
        raise NoConvergenceError(f"the last step was {size:g} m")

    def _arms(self, place):
        """Points from the centre of their model, on the ground."""
        offset = self._xyz - place.centroid[self._model]
        return np.einsum("nij,nj->ni", place.matrix[self._model], offset)

    def _extents(self, arm):
        """Root mean square length of the arms of each model."""
        n_models = len(self._ordering.order)
        count = np.bincount(self._model, minlength=n_models)
        squares = np.bincount(self._model, (arm**2).sum(axis=1), n_models)
        return np.sqrt(squares / count)

    def _factored(self, arm, extent):
        design = np.zeros((len(arm), 3, N_UNKNOWNS))
        design[:, range(3), range(3)] = 1.0
        unit = arm / extent[self._model][:, None]
        design[:, :, 3] = unit
        design[:, :, 4:] = cross_matrix(-unit)
        return factor_block(self._ordering, design, self._weights, self._prior, None)

    def _solution(self, place, control, found, last):
        solver, extent = last
        given, order = self._given, self._ordering.order
        points, residuals = found.points[:, :, 0], found.residuals[:, :, 0]
        control_residuals = np.full_like(points, np.nan)
        difference = points - control
        control_residuals[self._is_control] = difference[self._is_control]
        known = np.nan_to_num(control_residuals)
        squares = np.sum(self._weights * residuals**2)
        squares += np.einsum("na,nab,nb->", known, self._prior[0], known)
        n_unknowns = N_UNKNOWNS * given.n_models + 3 * int((~given.is_fixed).sum())
        n_observed = 3 * len(given.xyz)
        n_observed += 3 * int((given.is_control & ~given.is_fixed).sum())
        return SpatialSolution(
            observations=given,
            placement=replace(
                place,
                **{
                    name: in_old_order(getattr(place, name), order)
                    for name in ("centroid", "centre", "scale", "rotation")
                },
            ),
            points=in_old_order(points + place.origin, self._points),
            residuals=in_old_order(residuals, self._rows),
            control_residuals=in_old_order(control_residuals, self._points),
            extent=in_old_order(extent, order),
            redundancy=int(n_observed - n_unknowns),
            sum_of_squares=float(squares),
            solver=solver,
            ordering=self._ordering,
        )


def _moved(place, step, extent):
    """Models after a step of shift, scale and turn (in units of their extent)."""
    relative = step[:, 3:] / extent[:, None]
    turn = rotation_by_vector(relative[:, 1:])
    return replace(
        place,
        centre=place.centre + step[:, :3],
        scale=place.scale * (1.0 + relative[:, 0]),
        rotation=turn @ place.rotation,
    )
