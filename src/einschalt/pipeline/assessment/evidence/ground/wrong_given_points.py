"""Single given approximate points that are wrong, and the block without them.

Where no high flight makes them, a misprint or a wrong target puts the approximate
coordinates of one point off, and all models that it is fitted into with them. All
models adjusted at once tell which point it is; in the block without it each model says
where it lies. What they do not agree about is a measurement, and no given point.

See docs/theory/claim.md.
"""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.frame_columns import MODEL, values_of
from einschalt.foundations.key_columns import rows_among
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.evidence.control.suspects import residuals_stand_out
from einschalt.pipeline.assessment.evidence.ground.onto_given_points import (
    first_pass,
    observations,
    says_what_is_shared,
)
from einschalt.stages.error_propagation.error_model import LOW
from einschalt.stages.error_propagation.given_points import PLAN
from einschalt.theory.adjustment.single_given_points import find_wrong_points
from einschalt.theory.block_adjustment.control_information import control_checks

# of larger blocks the test takes longer than everything else
MOST_GIVEN = 20_000
FEWEST_MODELS = 2  # that agree about the point
LEAST_APART = 3.0  # times what they differ by, RMS, a point that is wrong lies off
# times the shift of a region: of points at its rim a part stands out by itself
BEYOND_REGIONS = 2.0
# of the shifts of two points: so near to each other's place they are exchanged
AT_PLACE = 0.1


@dataclass(frozen=True)
class WrongGivenPoint:
    """An approximate point that lies elsewhere by all of its models."""

    point_id: str
    n_given: int  # approximate points in all
    shift: tuple[float, float]  # easting, northing by which it is given too far [m]
    standard_error: float  # of each coordinate of the shift [m]
    p_value: float  # by chance, of all points together
    n_models: int  # that hold the point, or coverages where models share photographs
    control_is_alike: bool  # whether control gives it as wrong
    # the point with which it has exchanged places, empty without
    exchanged_with: str = ""

    @property
    def size(self):
        """Length of the shift [m]."""
        return float(np.hypot(*self.shift))


def look_for_wrong_points(two_step, examined_of):
    """Give each WrongGivenPoint, and the examination of the block without them.

    None of them, and no examination, where no residual stands out, or where it is said
    what given points share. ``examined_of`` makes the examination of a block.
    """
    nothing = (), None
    if not _is_looked_at(two_step):
        return nothing
    found = _snooped(two_step)
    while found:
        names = [point.point_id for point in found]
        try:
            without = examined_of(_without(two_step.block, found))
        except EinschaltError:  # the rest does not hold together
            return nothing
        least = BEYOND_REGIONS * without.largest_region
        seen = [_seen_without(two_step, without, point) for point in found]
        found = tuple(each for each in seen if each and each.size > least)
        if len(found) == len(names):
            found = _exchanged(two_step.block, found)
            return tuple(sorted(found, key=lambda each: -each.size)), without
    return nothing


def together(block, points, hidden):
    """Points that were found at once, and those that regions hid, the largest first."""
    if not hidden:
        return points
    n_given = len(block.approximate_points)
    hidden = (replace(each, n_given=n_given) for each in hidden)
    return tuple(sorted((*points, *hidden), key=lambda each: -each.size))


def points_beside(two_step, points):
    """Names of all points of the models that hold some wrong ones."""
    measured = two_step.model_points[LOW]
    is_wrong = is_among(measured["point_id"], [point.point_id for point in points])
    beside = rows_among(measured, measured.loc[is_wrong, MODEL], MODEL)
    return measured.loc[beside, "point_id"]


def _is_looked_at(two_step):
    known = two_step.block.approximate_points
    if known is None or len(known) > MOST_GIVEN or says_what_is_shared(two_step):
        return False
    return two_step.error_model is not None and residuals_stand_out(two_step)


def _snooped(two_step):
    """What stands out of the scores, as tuple of WrongGivenPoint."""
    known, points = two_step.block.approximate_points, two_step.model_points[LOW]
    # measurements of a wrong point look wrong as well: none is left out
    places, _, flight, given = observations(two_step, np.zeros(len(points), bool))
    if not len(flight.model):
        return ()
    found = find_wrong_points(control_checks([flight], given), given.weight)
    names = known["point_id"].to_numpy(dtype=object)[places][found.rows]
    exchanged = {name for pair in two_step.exchanged_names for name in pair.points}
    columns = names, found.shift, found.standard_error, found.p_value
    return tuple(
        _point(two_step.block, str(name), (shift.real, shift.imag), error, p_value)
        for name, shift, error, p_value in zip(*columns, strict=True)
        if name not in exchanged  # which are named by themselves
    )


def _point(block, name, shift, error, p_value):
    known, control = block.approximate_points, block.control_points
    is_alike = False
    if control is not None:
        is_held = (control["role"] != "check") & (control["point_id"] == name)
        there = values_of(known[known["point_id"] == name], PLAN)
        apart = values_of(control[is_held.to_numpy()], PLAN) - there[:1]
        # control that is right lies apart by the shift, the other way
        size = np.hypot(*shift)
        is_alike = bool((np.hypot(*apart.T) < 0.5 * size).any())
    sizes = float(error), float(p_value)
    shift = tuple(map(float, shift))
    return WrongGivenPoint(name, len(known), shift, *sizes, 0, is_alike)


def _without(block, found):
    """A block without some given points, and their control where that is as wrong."""
    names = {
        "approximate_points": [each.point_id for each in found],
        "control_points": [each.point_id for each in found if each.control_is_alike],
    }
    return replace(
        block,
        **{
            table: _others(getattr(block, table), some)
            for table, some in names.items()
            if some
        },
    )


def without_given(block, wrong):
    """A block without some points, among control and approximate points."""
    tables = {
        name: getattr(block, name) for name in ("control_points", "approximate_points")
    }
    return replace(
        block,
        **{
            name: _others(table, wrong)
            for name, table in tables.items()
            if table is not None
        },
    )


def _others(points, names):
    return points[~is_among(points["point_id"], names)].reset_index(drop=True)


def _exchanged(block, found):
    """The points, with the name of another one where each lies at the other's place."""
    known = block.approximate_points.drop_duplicates("point_id").set_index("point_id")
    given = values_of(known.loc[[each.point_id for each in found]], PLAN)
    shift, names = np.array([each.shift for each in found]), [p.point_id for p in found]
    size = np.hypot(*shift.T)
    apart = np.hypot(*np.moveaxis((given - shift)[:, None] - given[None], 2, 0))
    is_there = apart < AT_PLACE * size[:, None]
    is_pair = is_there & is_there.T
    return tuple(
        replace(each, exchanged_with=names[int(np.argmax(pair))])
        if pair.any()
        else each
        for each, pair in zip(found, is_pair, strict=True)
    )


def _seen_without(two_step, without, point):
    """A point as models without it place it; None where they do not agree.

    By all of them: one that measured something else would not agree with the others.
    """
    values = first_pass(without).own_values
    values = values[(values["point_id"] == point.point_id).to_numpy()]
    values = values[np.isfinite(values_of(values, PLAN)).all(axis=1)]
    # a photograph that two models share makes them agree about what is wrong in it
    apart = ["coverage"] if two_step.block.low_flight.has_images else MODEL
    n_models = len(values[apart].drop_duplicates())
    if n_models < FEWEST_MODELS:
        return None
    xy = values_of(values, PLAN)
    known = two_step.block.approximate_points
    given = values_of(known[known["point_id"] == point.point_id], PLAN)[0]
    middle = xy.mean(axis=0)
    scatter = np.sqrt(np.sum((xy - middle) ** 2) / (len(xy) - 1))
    shift = given - middle
    if np.hypot(*shift) < LEAST_APART * scatter:
        return None
    return replace(point, shift=tuple(map(float, shift)), n_models=n_models)
