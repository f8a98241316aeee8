"""What plane and spatial blocks have in common, while and once they are adjusted."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from einschalt.theory.block_adjustment.common_border import Bordered
from einschalt.theory.block_adjustment.observations import ObservedBlock
from einschalt.theory.block_adjustment.solver import Ordering, Solver


@dataclass(frozen=True, eq=False)
class AdjustedBlock:
    """Adjusted block with d coordinates, in the order of the observations."""

    observations: ObservedBlock
    points: np.ndarray  # (n_points, d): easting, northing [, height] [m]
    residuals: np.ndarray  # (n_rows, d): transformed less adjusted [m]
    # (n_points, d): adjusted minus given [m]; NaN where nothing is given, 0 where it is
    # held
    control_residuals: np.ndarray
    redundancy: int
    # Σ w v² of all observations, of the control, and of the orientations' errors
    sum_of_squares: float
    bordered: Bordered  # what models share, in the order of elimination
    solver: Solver  # likewise
    ordering: Ordering

    @property
    def s_0(self):
        """Standard error of unit weight, 1 where the errors are as large as given."""
        if self.redundancy <= 0:
            return np.nan
        return float(np.sqrt(self.sum_of_squares / self.redundancy))

    @property
    def is_held(self):
        """Unknowns that nothing determines, shape (n_models, n_solved)."""
        return in_old_order(self.solver.factor.is_held, self.ordering.order)

    def null_motion(self, model, unknown):
        """How far each model moves at its edge with an undetermined unknown [m].

        ``model`` and ``unknown`` are one of ``is_held``.
        """
        place = int(np.flatnonzero(self.ordering.order == model)[0])
        motion = np.abs(self.solver.factor.null_vector(place, unknown)).max(axis=1)
        return in_old_order(motion, self.ordering.order)

    @cached_property
    def point_cofactors(self):
        """Cofactors of the points, shape (n_points, d, d) [m²]."""
        return in_old_order(self._cofactors("points"), self.ordering.reordered.points)

    @cached_property
    def adjusted_cofactors(self):
        """Cofactors of transformed less adjusted points, (n_rows, d, d) [m²]."""
        return in_old_order(self._cofactors("residuals"), self.ordering.reordered.rows)

    def _cofactors(self, quantity):
        """Of points or residuals, in the order of elimination."""
        cofactors = self.solver.cofactors
        if quantity == "points":
            return cofactors.points
        return cofactors.of_differences(self.solver.system.incidence.point)

    def _projected(self, errors, control_errors, *, is_rough=False):
        """Points and residuals for right sides of the solver."""
        new = self.ordering.reordered
        right = errors[new.rows], control_errors[new.points]
        found = self.solver.project(*right, is_rough=is_rough)
        residuals = in_old_order(found.residuals, new.rows)
        return in_old_order(found.points, new.points), residuals

    def _with_common(self, points, residuals, on_ground):
        """Points and residuals once common parameters have taken up what they can.

        ``on_ground`` (n_rows, d, n_terms): what these do to the observations [m].
        """
        weights = (
            self.observations.standard_error.reshape(len(residuals), -1, 1) ** -2.0
        )
        right = np.tensordot(on_ground * weights, residuals, axes=((0, 1), (0, 1)))
        shift, new = self.bordered.cofactors @ right, self.ordering.reordered
        points -= in_old_order(self.bordered.points, new.points) @ shift
        residuals -= in_old_order(self.bordered.residuals, new.rows) @ shift
        return points, residuals

    @cached_property
    def leverage(self):
        """Share of each observation in its own adjusted value, (n_rows, d)."""
        diagonal = np.diagonal(self.adjusted_cofactors, axis1=1, axis2=2)
        error = self.observations.standard_error
        return diagonal / error.reshape(len(error), -1) ** 2

    @cached_property
    def control_leverage(self):
        """The same of the control, (n_points, d); NaN where there is none."""
        product = self.observations.control_weight @ self.point_cofactors
        diagonal = np.diagonal(product, axis1=1, axis2=2).copy()
        diagonal[~self.observations.is_given] = np.nan
        diagonal[self.observations.is_fixed] = np.nan
        return diagonal


def held_coordinates(observations):
    """Coordinates that are held as they are given, (n_points, d)."""
    return observations.is_fixed[:, None] & observations.is_given


class BlockInOrder:
    """Observations and control of a block, in the order of elimination.

    ``given`` has them in their own order; ``rows`` and ``points`` are the old numbers
    of each observation and point; ``prior`` is the weight of each point's given
    coordinates, and whether they are held.
    """

    def __init__(self, observations, ordering):
        self.given, self.ordering = observations, ordering
        self.rows = ordering.reordered.rows
        self.points = ordering.reordered.points
        self.incidence = ordering.reordered.incidence
        self.weights = observations.standard_error[self.rows] ** -2.0
        self.prior = (
            observations.control_weight.take(self.points, axis=0),
            observations.is_fixed[self.points],
        )
        self.is_control = observations.is_control[self.points]

    def control_from(self, origin):
        """Given coordinates, counted from an origin; 0 where there are none."""
        control = self.given.control.take(self.points, axis=0)
        return np.where(self.given.is_given[self.points], control - origin, 0.0)

    def common_fields(self, points, residuals, control, origin, n_unknowns):
        """Fields of the adjusted block that are known whatever its models are.

        ``points`` (adjusted) and ``control`` (given) count from the origin [m];
        ``n_unknowns`` are those of the models. The fields are in the order of the
        observations as given.
        """
        given = self.given
        known = np.flatnonzero(self.is_control)
        away = points[known] - control[known]
        control_residuals = np.full_like(points, np.nan)
        is_given = given.is_given
        control_residuals[known] = np.where(is_given[self.points[known]], away, np.nan)
        squares = np.sum(self.weights.reshape(len(residuals), -1) * residuals**2)
        squares += np.einsum("na,nab,nb->", away, self.prior[0][known], away)
        is_held = held_coordinates(given)
        n_free = int((~is_held).sum())
        n_observed = residuals.size + int((is_given & ~is_held).sum())
        return {
            "observations": given,
            "points": in_old_order(points + origin, self.points),
            "residuals": in_old_order(residuals, self.rows),
            "control_residuals": in_old_order(control_residuals, self.points),
            "redundancy": int(n_observed - n_free - n_unknowns),
            "sum_of_squares": float(squares),
            "ordering": self.ordering,
        }


def in_old_order(values, old_number):
    """Put rows back into their old order."""
    place = np.empty(len(old_number), dtype=np.int64)
    place[old_number] = np.arange(len(place))
    return values.take(place, axis=0)  # indexing takes four times as long


def largest_error(cofactors):
    """Largest standard error of the unknowns of each model, for σ_0 = 1.

    From the diagonal elements, (n_models, n_unknowns); NaN where rounding has left no
    positive variance.
    """
    is_possible = (cofactors >= 0.0).all(axis=1)
    return np.sqrt(np.where(is_possible, cofactors.max(axis=1), np.nan))
