"""The rigorous covariance of a block's final coordinates."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from einschalt.foundations.units import METRES_PER_UM
from einschalt.stages.stage4_error_propagation import (
    FlightOperator,
    GroundSources,
    flight_operator,
    mean_operator,
    propagate,
)
from einschalt.stages.transformation_kinds import KINDS
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.propagation import selection
from einschalt.theory.transformation.sensitivity import CONFORMAL

PLANE = [name for name, kind in KINDS.items() if len(kind.target) == 2]


def can_propagate(block):
    """Whether every source of error of a block has a known size.

    Parameters
    ----------
    block : Block

    Returns
    -------
    bool
    """
    return not obstacle_to_propagation(block)


def obstacle_to_propagation(block):
    """Say what stands against the propagation of a block's errors.

    Given approximate coordinates come with correlations that nobody knows, and models
    from image coordinates or y-parallaxes share the errors of their orientation.

    Parameters
    ----------
    block : Block

    Returns
    -------
    str
        Empty where nothing does.
    """
    flights = block.flights.values()
    if block.high_flight is None:
        return "given approximate coordinates share errors of unknown size"
    if "standard_error_m" not in block.control_points:
        return "the control points have no standard_error_m"
    if not all(flight.transformation in PLANE for flight in flights):
        return "the errors of heights are unknown"
    if any(flight.is_oriented_numerically for flight in flights):
        return "models that were oriented here share errors of their orientation"
    return ""


def propagate_block(block, high, low, means):
    """Carry the errors of control and of both flights through to the final points.

    Parameters
    ----------
    block : Block
        Its ``m_g_um`` and ``standard_error_m`` are the sizes of the errors.
    high : ApproximateCoordinates
    low : ModelTransformation
    means : CoverageMean
        Of all values of the low flight, row for row as its model points.

    Returns
    -------
    PropagatedErrors
        With the sources ``control``, ``high_flight`` and ``low_flight``.
    """
    return _propagate(
        block,
        high,
        low,
        means.points["point_id"],
        lambda n_low, n_axes: mean_operator(means, np.arange(n_low), n_low, n_axes),
    )


def propagate_values(block, high, low):
    """Carry the same errors to the value of every point in every low-flight model.

    Parameters
    ----------
    block : Block
    high : ApproximateCoordinates
    low : ModelTransformation

    Returns
    -------
    PropagatedErrors
        Row for row as the model points of the low flight; NaN in the rows of models
        that are not usable.
    """
    return _propagate(
        block,
        high,
        low,
        block.low_flight.points_to_fit["point_id"],
        lambda n_low, n_axes: selection(np.arange(n_low), n_low, n_axes),
    )


def _propagate(block, high, low, point_ids, final_operator):
    operators = BlockOperators.of(block, high, low)
    n_axes, n_low = operators.n_axes, len(block.low_flight.points_to_fit)
    final = final_operator(n_low, n_axes)
    return propagate(
        point_ids.to_numpy(dtype=object),
        {name: (final, *rest) for name, rest in operators.to_low_values().items()},
        given_errors(block),
        n_axes,
    )


@dataclass(frozen=True, eq=False)
class BlockOperators:
    """Error operators of a block's flights and of its approximate coordinates.

    Attributes
    ----------
    high, low : FlightOperator
    approximate : bsr_array
        Means of the values of the high flight.
    onto : dict of str to bsr_array
        From the ground points of each flight to the points that were fitted.
    fitted : dict of str to bsr_array
        From all values of each flight to the points that were fitted.
    """

    high: FlightOperator
    low: FlightOperator
    approximate: sparse.bsr_array
    onto: dict
    fitted: dict

    @property
    def n_axes(self):
        """1 where one complex coordinate stands for two."""
        return self.low.n_axes

    @classmethod
    def of(cls, block, high, low):
        """Operators of a computed block.

        Parameters
        ----------
        block : Block
        high : ApproximateCoordinates
        low : ModelTransformation

        Returns
        -------
        BlockOperators
        """
        control, check = block.control_points, _check_ids(block)
        is_control = (control["role"] != "check").to_numpy()
        is_ground = ~high.points["point_id"].isin(check).to_numpy()
        is_conformal = {high.transformation.kind, low.kind} <= set(CONFORMAL)
        n_axes = 1 if is_conformal else 2
        parts = {
            "high_flight": (
                high.transformation,
                GroundSources(np.flatnonzero(is_control), len(control)),
            ),
            "low_flight": (
                low,
                GroundSources(np.flatnonzero(is_ground), len(high.points)),
            ),
        }
        points = {name: block.flights[name].points_to_fit for name in parts}
        found, onto, fitted = [], {}, {}
        for name, (transformation, ground) in parts.items():
            observed = transformation.observed
            found.append(
                flight_operator(
                    transformation, points[name], ground, is_conformal=is_conformal
                )
            )
            places = ground.places[observed.ground_rows]
            onto[name] = selection(places, ground.count, n_axes)
            n_rows = len(points[name])
            fitted[name] = selection(observed.row_numbers, n_rows, n_axes)
        n_high = len(points["high_flight"])
        approximate = mean_operator(high.means, np.arange(n_high), n_high, n_axes)
        return cls(*found, approximate, onto, fitted)

    def to_low_values(self):
        """Operators from every source to the values of the low flight, as products."""
        through_ground = (self.low.ground, self.approximate)
        return {
            "control": (*through_ground, self.high.ground),
            "high_flight": (*through_ground, self.high.measured),
            "low_flight": (self.low.measured,),
        }

    def covariance_of_sums(self, flight, coefficients, standard_errors):
        """Covariance of linear functions of what the fits of a flight were given.

        Parameters
        ----------
        flight : {"high_flight", "low_flight"}
        coefficients : ndarray, shape (n_fitted, n_sums, 2)
            Of each fitted point's ground coordinate less its transformed measurement.
        standard_errors : dict of str to ndarray
            Of the observations of each source, per coordinate [m].

        Returns
        -------
        ndarray, shape (n_sums, n_sums)
        """
        rows = np.swapaxes(coefficients, 0, 1)
        if self.n_axes == 1:
            rows = rows @ np.array([1.0, -1j])
        rows = rows.reshape(len(rows), -1)
        chains = {"control": (self.onto[flight],), flight: (-self.fitted[flight],)}
        if flight == "low_flight":
            through_ground = (self.onto[flight], self.approximate)
            chains["high_flight"] = (*through_ground, self.high.measured)
            chains["control"] = (*through_ground, self.high.ground)
        total = 0.0
        for source, chain in chains.items():
            carried = rows
            for matrix in chain:
                carried = carried @ matrix
            carried = carried * np.repeat(standard_errors[source], self.n_axes)
            total = total + np.real(carried @ carried.conj().T)
        return total


def given_errors(block):
    """Sizes of the errors of all observations as they were given, by their source.

    Parameters
    ----------
    block : Block

    Returns
    -------
    dict of str to ndarray
        ``control``, ``high_flight``, ``low_flight``, per coordinate [m].
    """
    return {
        "control": block.control_points["standard_error_m"].to_numpy() / SQRT2,
        "high_flight": _measuring_errors(block.high_flight),
        "low_flight": _measuring_errors(block.low_flight),
    }


def _check_ids(block):
    control = block.control_points
    return control.loc[control["role"] == "check", "point_id"]


def _measuring_errors(flight):
    """Error of each measured coordinate on the ground [m]; m_g is total."""
    m_g_um = flight.m_g_um_of(flight.model_points)
    return m_g_um * METRES_PER_UM * flight.scale_number / SQRT2
