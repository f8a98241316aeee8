"""The rigorous covariance of a block's final coordinates."""

from einschalt.foundations.errors import SettingsError
from einschalt.stages.error_propagation.error_model import (
    HIGH,
    LOW,
    approximations_are_control,
    errors_are_stated,
    model_of_block,
    model_of_high_flight,
)
from einschalt.stages.error_propagation.height_errors import with_measured_heights
from einschalt.stages.error_propagation.operators import propagate
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS
from einschalt.stages.value_weights import RIGOROUS


def obstacle_to_propagation(block) -> str:
    """Say what stands against the propagation of a block's errors.

    Given approximate coordinates come with correlations that nobody knows, unless they
    are those of control points, or it is said what they share. Empty where nothing is
    known before the computation.
    """
    if block.high_flight is None and errors_are_stated(block):
        return ""
    if block.high_flight is None and not approximations_are_control(block):
        return "given approximate coordinates share errors of unknown size"
    if "standard_error_m" not in block.control_points:
        return "the control points have no standard_error_m"
    flights = block.flights.values()
    if len({TRANSFORMATION_KINDS[f.transformation].target for f in flights}) > 1:
        return "one flight is transformed in space, and the other one in plan"
    return ""


REMEDIES = {
    "given approximate coordinates": "Fly or give the high flight, or say what they "
    "share: a column group, or correlation_length_m",
    "the control points": "Give standard_error_m of every control point",
    "one flight": "Transform both flights in space, or both in plan",
}


def require_rigorous(block, weighting):
    """Refuse rigorous weights where the size of an error is not known."""
    obstacle = obstacle_to_propagation(block) if weighting == RIGOROUS else ""
    if obstacle:
        remedy = next(r for start, r in REMEDIES.items() if obstacle.startswith(start))
        raise _not_rigorous(obstacle, remedy)


def covariances_for(weighting, model):
    """Covariances by which values are averaged, if they are.

    A function of pairs of model points, None where the weights need none. SettingsError
    where the models do not tell the size of an error.
    """
    if weighting != RIGOROUS:
        return None
    if model is None:
        raise _not_rigorous(
            "orientations or heights leave nothing that tells the size of their errors",
            "Measure more points per model",
        )
    return model.covariances_of_values


def _not_rigorous(obstacle, remedy):
    return SettingsError(
        f'weighting = "{RIGOROUS}", but {obstacle}',
        expected="a block whose errors all have a known size",
        remedy=f'{remedy}, or set weighting = "plain"',
        key="weighting",
    )


def model_of_known_errors(block, flights, high, low, bent=None):
    """Model of a block's errors, where all their sizes are known.

    Of the values of the low flight; None otherwise. ``flights`` are the orientations of
    each flight, the high one first; ``low`` was fitted onto the approximate
    coordinates.
    """
    if obstacle_to_propagation(block):
        return None
    points = {name: oriented.model_points for name, oriented in flights.items()}
    errors = {name: oriented.errors for name, oriented in flights.items()}
    model = model_of_block(block, points, high, low, errors, bent)
    fits = {LOW: low, **({} if high is None else {HIGH: high.transformation})}
    return _with_all_sizes(block, model, points, fits)


def model_of_known_high_errors(block, oriented, transformation):
    """Model of the errors of a high flight alone, where all their sizes are known.

    Of its values, in the place of those of the low flight; None otherwise.
    """
    if obstacle_to_propagation(block):
        return None
    points = oriented.model_points
    model = model_of_high_flight(block, points, transformation, oriented.errors)
    return _with_all_sizes(block, model, {HIGH: points}, {HIGH: transformation})


def _with_all_sizes(block, model, points, fits):
    if model.is_assumed:
        return None
    machine = {n: p for n, p in points.items() if not block.flights[n].has_images}
    return with_measured_heights(model, machine, fits)


def propagate_model(model, means):
    """Covariances of the final points by a model of errors."""
    names = means.points["point_id"].to_numpy(dtype=object)
    return propagate(names, model.chains, model.standard_errors)


def propagate_values(model, point_ids):
    """Carry the same errors to the value of every point in every low-flight model.

    ``point_ids`` are those of the model points of the low flight, row for row; NaN in
    the rows of models that are not usable.
    """
    names = point_ids.to_numpy(dtype=object)
    return propagate(names, model.chains_to_values, model.standard_errors)
