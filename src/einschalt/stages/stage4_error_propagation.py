"""The rigorous covariance of a block's final coordinates."""

from einschalt.foundations.errors import SettingsError
from einschalt.stages.error_propagation.covariances import propagate
from einschalt.stages.error_propagation.error_model import (
    HIGH,
    LOW,
    errors_are_stated,
    model_of_block,
    model_of_high_flight,
)
from einschalt.stages.error_propagation.given_points import (
    APPROXIMATE_POINTS,
    approximations_are_control,
    group_members,
)
from einschalt.stages.error_propagation.height_errors import with_measured_heights
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS
from einschalt.stages.value_weights import RIGOROUS

# what stands against the propagation of a block's errors, and the way round it
SHARED_UNKNOWN = "given approximate coordinates share errors of unknown size"
SIZE_UNKNOWN = "approximate points with a correlation_length_m have no m_0_m"
CONTROL_UNKNOWN = "the control points have no standard_error_m"
MIXED = "one flight is transformed in space, and the other one in plan"
REMEDIES = {
    SHARED_UNKNOWN: "Fly or give the high flight, or say what they share: a column "
    "group, or correlation_length_m and m_0_m",
    SIZE_UNKNOWN: "Give m_0_m in [approximate_points]",
    CONTROL_UNKNOWN: "Give standard_error_m of every control point",
    MIXED: "Transform both flights in space, or both in plan",
}
# what shows in the computation only
UNCHECKED = "nothing checks the block's orientations, or its heights"
MEASURE_MORE = "Measure more points per model"
GROUPS_UNKNOWN = "shifts of groups have no group_error_m"


def obstacle_to_propagation(block) -> str:
    """Say what stands against the propagation of a block's errors.

    Given approximate coordinates come with correlations that nobody knows, unless they
    are those of control points, or it is said what they share. Empty where nothing is
    known before the computation.
    """
    if block.high_flight is None and errors_are_stated(block):
        return ""
    if block.high_flight is None and not approximations_are_control(block):
        points = block.approximate_points
        length = block.correlation_lengths_m.get(APPROXIMATE_POINTS, 0.0)
        return SIZE_UNKNOWN if points is not None and length > 0.0 else SHARED_UNKNOWN
    if "standard_error_m" not in block.control_points:
        return CONTROL_UNKNOWN
    flights = block.flights.values()
    if len({TRANSFORMATION_KINDS[f.transformation].target for f in flights}) > 1:
        return MIXED
    return ""


def untold_sizes(block) -> str:
    """Say what may have left the size of an error untold, after the computation."""
    tables = block.control_points, block.approximate_points
    if any(t is not None and group_members(t) is not None for t in tables):
        return f"{UNCHECKED}, or {GROUPS_UNKNOWN}"
    return UNCHECKED


def require_rigorous(block, weighting):
    """Refuse rigorous weights where the size of an error is not known."""
    obstacle = obstacle_to_propagation(block) if weighting == RIGOROUS else ""
    if obstacle:
        raise _not_rigorous(obstacle, REMEDIES[obstacle])


def covariances_for(weighting, model, block):
    """Covariances by which the values of a block are averaged, if they are.

    A function of pairs of model points, None where the weights need none. SettingsError
    where the models do not tell the size of an error.
    """
    if weighting != RIGOROUS:
        return None
    if model is None:
        untold = untold_sizes(block)
        remedy = MEASURE_MORE
        if GROUPS_UNKNOWN in untold:
            remedy = "Measure more points per model and give group_error_m"
        raise _not_rigorous(untold, remedy)
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
    return propagate(names, model.chains, model.standard_errors, model.known)


def propagate_values(model, point_ids):
    """Carry the same errors to the value of every point in every low-flight model.

    ``point_ids`` are those of the model points of the low flight, row for row; NaN in
    the rows of models that are not usable.
    """
    names = point_ids.to_numpy(dtype=object)
    return propagate(names, model.chains_to_values, model.standard_errors, model.known)
