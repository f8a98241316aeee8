"""The rigorous covariance of a block's final coordinates."""

from einschalt.stages.error_propagation.error_model import (
    HIGH,
    LOW,
    approximations_are_control,
    model_of_block,
)
from einschalt.stages.error_propagation.height_errors import with_measured_heights
from einschalt.stages.error_propagation.operators import propagate
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS


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

    Given approximate coordinates come with correlations that nobody knows, unless they
    are those of control points.

    Parameters
    ----------
    block : Block

    Returns
    -------
    str
        Empty where nothing is known before the computation.
    """
    flights = block.flights.values()
    if block.high_flight is None and not approximations_are_control(block):
        return "given approximate coordinates share errors of unknown size"
    if "standard_error_m" not in block.control_points:
        return "the control points have no standard_error_m"
    if (
        len(
            {
                len(TRANSFORMATION_KINDS[flight.transformation].target)
                for flight in flights
            }
        )
        > 1
    ):
        return "one flight is transformed in space, and the other one in plan"
    return ""


def model_of_known_errors(block, flights, high, low_pass):
    """Model of a block's errors, where all their sizes are known.

    Parameters
    ----------
    block : Block
    flights : dict of str to RelativeOrientation
        Model points of each flight, the high one first.
    high : ApproximateCoordinates or None
    low_pass : LowFlightFit
        Onto the approximate coordinates.

    Returns
    -------
    ErrorModel or None
    """
    if not can_propagate(block):
        return None
    points = {name: oriented.model_points for name, oriented in flights.items()}
    errors = {name: oriented.errors for name, oriented in flights.items()}
    low = low_pass.low
    model = model_of_block(block, points, high, low, low_pass.means, errors)
    if model.is_assumed:
        return None
    machine = {n: p for n, p in points.items() if not block.flights[n].has_images}
    fits = {LOW: low, **({} if high is None else {HIGH: high.transformation})}
    return with_measured_heights(model, machine, fits)


def propagate_model(model, means):
    """Covariances of the final points by a model of errors.

    Parameters
    ----------
    model : ErrorModel
    means : CoverageMean
        The final points.

    Returns
    -------
    PropagatedErrors
    """
    names = means.points["point_id"].to_numpy(dtype=object)
    return propagate(names, model.chains, model.standard_errors)


def propagate_values(model, point_ids):
    """Carry the same errors to the value of every point in every low-flight model.

    Parameters
    ----------
    model : ErrorModel
    point_ids : Series
        Of the model points of the low flight, row for row.

    Returns
    -------
    PropagatedErrors
        Row for row as the model points of the low flight; NaN in the rows of models
        that are not usable.
    """
    names = point_ids.to_numpy(dtype=object)
    return propagate(names, model.chains_to_values, model.standard_errors)
