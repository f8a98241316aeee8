"""The rigorous covariance of a block's final coordinates."""

import numpy as np

from einschalt.foundations.units import METRES_PER_UM
from einschalt.stages.stage4_error_propagation import (
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
    control, check = block.control_points, _check_ids(block)
    is_control = (control["role"] != "check").to_numpy()
    high_points = block.high_flight.points_to_fit
    low_points = block.low_flight.points_to_fit
    n_high, n_low, n_approximate = len(high_points), len(low_points), len(high.points)
    is_conformal = {high.transformation.kind, low.kind} <= set(CONFORMAL)
    n_axes = 1 if is_conformal else 2
    of_high = flight_operator(
        high.transformation,
        high_points,
        GroundSources(np.flatnonzero(is_control), len(control)),
        is_conformal=is_conformal,
    )
    approximate = mean_operator(high.means, np.arange(n_high), n_high, n_axes)
    is_ground = ~high.points["point_id"].isin(check).to_numpy()
    of_low = flight_operator(
        low,
        low_points,
        GroundSources(np.flatnonzero(is_ground), n_approximate),
        is_conformal=is_conformal,
    )
    final = final_operator(n_low, n_axes)
    through_ground = (final, of_low.ground, approximate)
    return propagate(
        point_ids.to_numpy(dtype=object),
        {
            "control": (*through_ground, of_high.ground),
            "high_flight": (*through_ground, of_high.measured),
            "low_flight": (final, of_low.measured),
        },
        given_errors(block),
        n_axes,
    )


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
