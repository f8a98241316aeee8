"""Which figure of the heights to believe: the propagated one, or a larger bound."""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.evidence.claim import LEFT_OUT, RESIDUALS
from einschalt.pipeline.assessment.evidence.control.displacements import (
    heights_contradict,
    where_it_matters,
)
from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.stages.error_propagation.error_model import CONTROL
from einschalt.theory.adjustment.least_squares import SQRT2

COLUMN = "standard_error_height"
# by which heights of models are too large or too small: beyond it no camera explains it
LEAST_OF_A_UNIT = 0.5
UNITS = (0.3048, 0.01, 0.001)  # metres
NEAR_A_UNIT = 0.1  # of logarithms


@dataclass(frozen=True)
class CredibleHeights:
    """The figure of the new points' heights to believe."""

    value: float  # RMS [m]; NaN where none is known
    # whether the heights are as good as that or worse, by an unknown amount
    is_lower_bound: bool
    factor: float  # by which the height error of single points is enlarged; at least 1


def credible_heights(examined) -> CredibleHeights | None:
    """Enlarge the propagated figure by what measurements show; None without heights.

    Each of these by itself, the largest counts: what check heights are missed by beyond
    the prediction, the control heights' errors as their left-out differences show them,
    and what a pattern in control or in models does to the points.
    """
    if "height" not in examined.solution.points:
        return None
    right = examined.names_put_right
    if right is not None:
        return _beside_wrong_names(examined.stated_height, right)
    stated = examined.stated_height
    total = _assumed(examined) if np.isnan(stated) else stated
    # without any, heights are hardly better than plan
    least = examined.credible.value / SQRT2 if np.isnan(total) else total
    rejected = examined.height_claim.rejected
    moved = max(examined.displaced.height, _tilted_by_plan(examined))
    is_refuted = bool(rejected) or heights_contradict(examined)
    moved = where_it_matters(moved, least, is_refuted=is_refuted)
    off = max(examined.frame.could_be_off.height, _of_another_unit(examined))
    is_refuted = is_refuted or moved > 0.0 or off > 0.0
    shown = [moved, *(_excess_of(examined, test) for test in rejected)]
    # what turns models in plan tilts them as well
    if is_refuted or examined.credible.is_lower_bound:
        apart = examined.apart_from_two_steps.height
        apart = where_it_matters(apart, least, is_refuted=is_refuted)
        is_refuted = is_refuted or apart > 0.0
        shown.append(apart)
    extra = max([0.0, *(size for size in shown if np.isfinite(size))])
    extra = float(np.hypot(extra, off))
    value = float(np.hypot(np.nan_to_num(total), extra)) if is_refuted else stated
    factor = value / total if is_refuted and total > 0.0 else 1.0
    return CredibleHeights(value, is_refuted, float(factor))


def _tilted_by_plan(examined):
    """What given places that contradict each other in plan do to heights, RMS [m].

    Of two steps that go straight onto them.
    """
    two_step = examined.two_step
    given = two_step.given_heights if two_step is examined else None
    return 0.0 if given is None else float(np.nan_to_num(given.moved_by_plan))


def _assumed(examined):
    """The figure by errors that are assumed of given points, RMS [m], or NaN."""
    two_step = examined.two_step
    given = two_step.given_heights if two_step.is_possible else None
    return np.nan if given is None else given.predicted


def _beside_wrong_names(total, right):
    """The figure with names put right, and how far that moves heights."""
    rest = right.corrected.credible_heights
    value = float(np.hypot(rest.value, right.moved.height))
    factor = max(1.0, value / total) if total > 0.0 else 1.0
    is_least = rest.is_lower_bound or right.moved.height > 0.0
    return CredibleHeights(value, is_least, float(factor))


def _of_another_unit(examined):
    """What heights are off by that are in another unit than the models, RMS [m].

    No base is taken for one of twice its length. A principal distance may be, which is
    no unit unless the ratio is that of one.
    """
    pattern = examined.control_patterns.height
    if pattern is None or pattern.kind is not Kind.SCALE:
        return 0.0
    ratio = abs(pattern.amplitude[0])
    block = examined.block
    has_images = all(block.flights[name].has_images for name in pattern.flights)
    is_another = not has_images or _is_of_units(1.0 - pattern.amplitude[0])
    if ratio < LEAST_OF_A_UNIT or not is_another:
        return 0.0
    known = block.control_points
    known = block.approximate_points if known is None else known
    given = known["height"].to_numpy(dtype=float)
    return float(np.sqrt(np.nanmean(given**2)) * ratio / (1.0 + ratio))


def _is_of_units(times):
    """Whether lengths differ by as many times as two units do."""
    if not times > 0.0:
        return False
    apart = np.abs(np.abs(np.log(times)) - np.abs(np.log(UNITS)))
    return bool(apart.min() < NEAR_A_UNIT)


def _excess_of(examined, test):
    """What a test shows beyond the prediction, at the new points, RMS [m]."""
    excess = np.sqrt(max(test.observed**2 - test.predicted**2, 0.0))
    if test.name == RESIDUALS:
        # what a pattern does is known; otherwise all errors are larger by a factor
        is_named = examined.control_patterns.height is not None
        return 0.0 if is_named else excess / test.predicted * examined.stated_height
    if test.name != LEFT_OUT:
        return excess
    # differences of left-out control hold its own errors: they are larger by a factor,
    # and so is what they do to the points
    of_differences, of_points = examined.control_height_parts
    if not of_differences > 0.0:
        return 0.0
    return excess / of_differences * of_points


def control_height_parts(two_step) -> tuple[float, float]:
    """What control of the given errors does, in height, RMS [m].

    To the differences of control that was left out, and to the new points.
    """
    left_out, errors = two_step.left_out_control, two_step.errors
    if left_out is None or errors is None or CONTROL not in errors.parts:
        return np.nan, np.nan
    given = two_step.error_model.high.control
    sizes = two_step.error_model.standard_errors
    of_differences = sum(
        left_out.chains[name].covariances(sizes[name])[:, 2, 2] for name in given.chains
    )
    points = two_step.solution.points
    new = points.loc[points["role"] == "new", "point_id"]
    is_new = is_among(errors.point_ids, new)
    of_points = sum(errors.parts[name][is_new, 2, 2] for name in given.chains)
    of_both = (of_differences, of_points)
    return tuple(
        float(np.sqrt(np.mean(part))) if len(part) else np.nan for part in of_both
    )
