"""Affinity of film and strain of the control network."""

import numpy as np

from einschalt.pipeline.assessment.evidence.control.larger_errors import (
    larger_control_errors,
)
from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.pipeline.assessment.evidence.ground.network_step import region_of_step
from einschalt.pipeline.assessment.findings.kinds import MOST_NAMED, finding

# of the figure that is claimed: a smaller bias adds half a per cent to it
MIN_REPORTED_RATIO = 0.1
MOST_DISPLACEMENTS = 10
# from the middle of all points, over their extent: what is nearer lies in the middle
LEAST_WAY = 0.1
# counted from east, against the clock
SIDES = (
    *("east", "north_east", "north", "north_west"),
    *("west", "south_west", "south", "south_east"),
)


def film_affinity(examined):
    """Flights whose models have an affinity that their transformation leaves."""
    least = MIN_REPORTED_RATIO * examined.figures.mean_within
    found = [
        part
        for part in examined.patterns.affinities
        if part.is_significant and not part.is_absorbed and part.bias > least
    ]
    if not found:
        return None
    worst = max(found, key=lambda part: part.bias)
    return finding(
        "film_affinity",
        names=[part.flight for part in found],
        statistic="error that an affinity makes in a model, RMS",
        observed=worst.bias,
        expected=0.0,
        probability=worst.p_value,
        remedy="set_affine",
        facts={"flights": tuple(map(_affinity, found))},
    )


def curved_models(examined):
    """Flights whose models have a curvature in common that two steps leave."""
    least = MIN_REPORTED_RATIO * examined.figures.mean_within
    found = [
        part
        for part in examined.patterns.curvatures
        if part.is_significant and part.size > least
    ]
    if not found:
        return None
    worst = max(found, key=lambda part: part.size)
    return finding(
        "curved_models",
        names=[part.flight for part in found],
        statistic="displacement by quadratic and cubic terms of all models, RMS",
        observed=worst.size,
        expected=0.0,
        probability=worst.p_value,
        remedy="adjust_or_calibrate",
        facts={
            "flights": tuple(
                {"flight": part.flight, "size": part.size} for part in found
            )
        },
    )


def _affinity(part):
    numbers = ("stretch", "stretch_error", "shear", "shear_error", "bias")
    return {
        "flight": part.flight,
        "axes": str(part.axes),
        **{name: float(getattr(part, name)) for name in numbers},
    }


def strained_network(two_step):
    """Control points that are displaced together with their neighbours."""
    return _smooth_strain(two_step, remedy="check_network_or_adjust")


def strained_network_of_adjustment(adjusted):
    """The same in the adjustment that suffers less from it."""
    return _smooth_strain(adjusted, remedy="check_network")


def _smooth_strain(examined, remedy):
    """Its size, where it is largest and where to."""
    strain = examined.smooth_strain
    if strain is None:
        return None
    claimed = float(examined.figures.mean_within)
    is_known = claimed > 0.0
    largest = strain.displacements.head(MOST_DISPLACEMENTS)
    return finding(
        "strained_network",
        names=largest["point_id"],
        statistic="displacement of control points, RMS",
        observed=strain.size,
        expected=0.0,
        probability=strain.p_value,
        remedy=remedy,
        facts={
            "n_control": int(strain.n_control),
            "size": float(strain.size),
            "reach": float(strain.reach),
            "displacements": tuple(
                (str(point), float(east), float(north))
                for point, east, north in largest.itertuples(index=False)
            ),
            "claimed": claimed,
            "claimed_with_strain": (
                float(np.hypot(claimed, strain.size)) if is_known else np.nan
            ),
        },
    )


def broken_network(examined):
    """Control of which one part lies apart from the other, or that is bent."""
    pattern = examined.network_step
    if pattern is None:
        pattern = examined.control_patterns.plan
        if pattern is None or pattern.kind is not Kind.BEND:
            return None
        if examined.smooth_strain is not None:
            return None  # which says more
    easting, northing = pattern.amplitude
    remedy, part = "check_network_in_parts", {}
    if pattern.kind is Kind.STEP:
        two_step = examined.two_step
        beside = two_step if two_step.is_possible else examined
        remedy, part = _part_that_is_off(pattern, beside)
    return finding(
        "broken_network",
        names=pattern.point_ids,
        statistic="pattern in the corrections of the control points",
        observed=pattern.size,
        expected=0.0,
        probability=pattern.p_value,
        remedy=remedy,
        facts={
            "kind": str(pattern.kind),
            "n_points": len(pattern.point_ids),
            "n_control": pattern.n_control,
            "easting": easting,
            "northing": northing,
            "size": pattern.size,
            "moved": float(pattern.moved),
            **part,
        },
    )


def _part_that_is_off(step, examined):
    """What to do about a step, and facts on where it is."""
    region = region_of_step(examined, step)
    is_told = not region.may_be_the_others
    return "correct_control" if is_told else "compare_both_parts", {
        "given": "control_points",
        "where": _side(region.direction),
        "part_is_told": is_told,
        "further_regions": (),
    }


def contradicting_control(examined):
    """Control points that contradict each other by more than their errors."""
    # told whenever a claim is enlarged for control, and no pattern tells more
    strain = examined.strain
    if broken_network(examined) is not None:
        return None  # which says how
    patterns = examined.control_patterns
    p_values = [patterns.unnamed_p_value]
    if examined.smooth_strain is not None:
        return None  # a strained network
    if strain is not None and strain.is_significant:
        p_values.append(strain.p_value)
    if np.isnan(p_values).all():
        return None
    return finding(
        "contradicting_control",
        statistic="corrections of the control points",
        probability=float(np.nanmin(p_values)),
        remedy="look_for_wrong_control_or_raise_errors",
        facts={
            "n_control": patterns.n_control or getattr(strain, "n_control", 0),
            "moved": patterns.moved_plan if patterns.plan is None else 0.0,
            "is_beside_given": patterns.is_beside_given,
        },
    )


def contradicting_control_of_adjustment(adjusted):
    """The same, unless the adjustment names those that contradict it."""
    control = adjusted.adjustment.control
    if control["is_suspect"].any():
        return None
    says_more = (broken_network, strained_network_of_adjustment)
    found = contradicting_control(adjusted)
    if found or any(more(adjusted) for more in says_more):
        return found
    larger = larger_control_errors(adjusted)
    if larger is None:
        return None
    return finding(
        "contradicting_control",
        statistic="corrections of the control points",
        observed=larger.factor,
        expected=1.0,
        probability=larger.p_value,
        remedy="look_for_wrong_control_or_raise_errors",
        facts={"n_control": len(control), "moved": 0.0, "is_beside_given": False},
    )


def displaced_region(examined):
    """Regions whose given coordinates are off, all of each by the same vector."""
    regions = examined.displaced_regions
    if not regions:
        return None
    first, *others = (_told_region(region) for region in regions)
    is_told, is_of_control = examined.displaced_part_is_told, regions[0].is_of_control
    to_correct = "correct_control" if is_of_control else "correct_region_or_give_group"
    return finding(
        "displaced_region",
        names=[name for region in regions for name in region.point_ids],
        statistic="shift of a region of given points",
        observed=regions[0].size,
        expected=0.0,
        probability=max(region.p_value for region in regions),
        remedy=to_correct if is_told else "compare_both_parts",
        facts={
            **first,
            "given": "control_points" if is_of_control else "approximate_points",
            "where": _place(regions[0]),
            "part_is_told": is_told,
            "further_regions": tuple(others),
            "moved": examined.moved_at_once,
        },
    )


def wrong_approximate_points(examined):
    """Single given points that lie elsewhere by all models that hold them."""
    points = examined.wrong_given_points
    if not points:
        return None
    is_only = not examined.displaced_regions
    return finding(
        "wrong_approximate_points",
        names=[point.point_id for point in points],
        statistic="distance of a given point from where its models have it",
        observed=points[0].size,
        expected=0.0,
        probability=max(point.p_value for point in points),
        remedy="correct_or_take_out_points",
        facts={
            "n_points": len(points),
            "n_given": points[0].n_given,
            "largest": points[0].size,
            "wrong_points": tuple(map(_told_point, points[:MOST_NAMED])),
            # what single points and regions do together is told of the regions
            "moved": examined.moved_at_once if is_only else np.nan,
        },
    )


def _told_point(point):
    easting, northing = point.shift
    return {
        "point_id": point.point_id,
        "easting": easting,
        "northing": northing,
        "size": point.size,
        "standard_error": point.standard_error,
        "n_models": point.n_models,
        "control_is_alike": point.control_is_alike,
        "exchanged_with": point.exchanged_with,
    }


def _place(region):
    """Where a region lies: a word."""
    return "scattered" if region.is_scattered else _side(region.direction)


def _side(direction):
    """In which part of all points a region lies: a word."""
    if np.hypot(*direction) < LEAST_WAY:
        return "middle"
    east, north = direction
    eighth = round(np.arctan2(north, east) / (np.pi / 4.0)) % len(SIDES)
    return SIDES[eighth]


def _told_region(region):
    (easting, northing), middle = region.shift, region.middle
    return {
        "n_points": len(region.point_ids),
        "points": region.point_ids[:MOST_NAMED],
        "n_given": region.n_given,
        "easting": easting,
        "northing": northing,
        "size": region.size,
        "standard_error": region.standard_error,
        "middle_easting": middle[0],
        "middle_northing": middle[1],
        "extent": region.extent,
        "n_control": len(region.control_ids),
        "control": region.control_ids[:MOST_NAMED],
        "control_is_alike": region.control_is_alike,
        "is_scattered": region.is_scattered,
    }


TWO_STEP = (
    wrong_approximate_points,
    displaced_region,
    film_affinity,
    curved_models,
    strained_network,
    broken_network,
    contradicting_control,
)
SIMULTANEOUS = (
    displaced_region,
    film_affinity,
    strained_network_of_adjustment,
    broken_network,
    contradicting_control_of_adjustment,
)
