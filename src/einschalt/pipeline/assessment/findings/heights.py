"""Whether heights are as good as stated, and what is wrong where they are not."""

from dataclasses import replace

import numpy as np

from einschalt.pipeline.assessment.evidence.control.displacements import (
    new_points_apart,
)
from einschalt.pipeline.assessment.evidence.control.heights import (
    LEAST_OF_SCALE,
    unseen_scale,
)
from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.pipeline.assessment.evidence.fits.bent_models import bent_flights_of
from einschalt.pipeline.assessment.evidence.ground.flat_ground import (
    bend_without_system,
)
from einschalt.pipeline.assessment.findings.kinds import finding

# beyond it an error of heights is no longer what was stated
OF_THE_CLAIM = 0.5
LEFT_OUT = "pattern in the heights of control points that were left out"
CORRECTIONS = "pattern in the corrections of the heights of control points"


def heights_beyond_claim(examined):
    """Heights of known points that are missed by more than the claim predicts."""
    rejected = examined.height_claim.rejected
    if not rejected:
        return None
    worst = min(rejected, key=lambda test: test.p_value)
    believed = examined.credible_heights
    return finding(
        "heights_beyond_claim",
        names=examined.known_heights.far,
        statistic=f"heights of {worst.name}",
        observed=worst.observed,
        expected=worst.predicted,
        probability=worst.p_value,
        remedy="check_heights",
        facts={
            "rejected": tuple(
                {
                    "quantity": test.name,
                    "n_points": int(test.n_points),
                    "observed": float(test.observed),
                    "predicted": float(test.predicted),
                }
                for test in rejected
            ),
            "believed": float(believed.value),
        },
    )


def lone_wrong_height(examined):
    """The height of a single known point that took no part and is far off."""
    lone = examined.lone_height
    if lone is None:
        return None
    return finding(
        "lone_wrong_height",
        names=(lone.point_id,),
        statistic="difference in height at a known point",
        observed=lone.size,
        expected=lone.expected,
        remedy="check_lone_height",
        facts={
            "role": lone.role,
            "largest": lone.size,
            "n_others": lone.n_others,
            "rms_of_others": lone.rms_of_others,
        },
    )


def wrong_control_height(examined):
    """The height of one control point that the others contradict."""
    pattern = _pattern(examined, Kind.POINT)
    if pattern is None:
        return None
    known = _told(pattern, names=pattern.point_ids)
    given = examined.two_step.given_heights
    is_control = given is None or given.are_control
    table = "control_points" if is_control else "approximate_points"
    known["facts"] |= {"height_of": table}
    return finding("wrong_control_height", remedy="check_that_height", **known)


def height_as_without_it(cause, examined, again):
    """The wrong height as the block without it shows it.

    One of hundreds of metres tilts its models by more than linear operators tell.
    """
    (name,) = cause.names
    table = getattr(examined.block, cause.facts["height_of"])
    points = again.points
    found = points.loc[points["point_id"] == name, "height"]
    given = table.loc[table["point_id"] == name, "height"]
    if found.empty or not np.isfinite(found.iloc[0]):
        return cause
    size = abs(float(found.iloc[0] - given.iloc[0]))
    moved = new_points_apart(examined, points).height
    return replace(
        cause, observed=size, facts=cause.facts | {"size": size, "moved": moved}
    )


def broken_heights(examined):
    """Control heights of which one part lies apart from the other, or bent ones."""
    pattern = _pattern(examined, Kind.STEP, Kind.GROUP, Kind.BEND)
    if pattern is None:
        return None
    known = _told(pattern, names=pattern.point_ids)
    return finding("broken_heights", remedy="check_height_network", **known)


def heights_out_of_scale(examined):
    """Flights whose model heights do not have the scale of control."""
    pattern = _pattern(examined, Kind.SCALE)
    if pattern is None:
        return None
    known = _told(pattern, names=pattern.flights)
    ratio = pattern.amplitude[0]
    distances = {
        float(distance) * (1.0 - ratio)
        for name in pattern.flights
        if np.isscalar(distance := examined.block.flights[name].principal_distance_mm)
    }
    # the same for all, or none
    distance = distances.pop() if len(distances) == 1 and ratio < 1.0 else None
    known["facts"] |= {"per_cent": 100.0 * ratio, "principal_distance_mm": distance}
    return finding("heights_out_of_scale", remedy="check_principal_distance", **known)


def unseen_height_scale(examined):
    """Given heights that do not tell whether the principal distance is right."""
    unseen = unseen_scale(examined)
    if unseen is None:
        return None
    return finding(
        "unseen_height_scale",
        statistic="error of the scale of model heights that would be noticed",
        observed=unseen.detectable,
        expected=LEAST_OF_SCALE,
        remedy="make_sure_of_principal_distance",
        facts={
            "per_cent": 100.0 * unseen.detectable,
            "moved_per_cent": unseen.moved_per_cent,
        },
    )


def bent_models(examined):
    """Spatial models of a flight that are bent alike, and were corrected by it."""
    found = bent_flights_of(examined)
    if not found:
        return None
    clearest = min(found, key=lambda each: each.p_value)
    flights = examined.block.flights
    return finding(
        "bent_models",
        names=tuple(each.flight for each in found),
        statistic="bend that all models of a flight share, in height at their edge",
        observed=clearest.size_edge,
        expected=0.0,
        probability=clearest.p_value,
        remedy="calibrate",
        facts={
            "size": clearest.size_edge,
            "flight": clearest.flight,
            "has_images": flights[clearest.flight].has_images,
        },
    )


def curvature_untold(examined):
    """Heights that a curved Earth would bend, where nobody says what the map is.

    Not where models were found to be bent, and corrected, whatever has bent them.
    """
    if bent_flights_of(examined):
        return None
    stated = examined.stated_height
    bend = bend_without_system(examined) if stated > 0.0 else 0.0
    if not bend > OF_THE_CLAIM * stated:
        return None
    return finding(
        "curvature_untold",
        statistic="what straight models miss curved ground by, in height",
        observed=bend,
        expected=stated,
        remedy="give_system",
        facts={"bend": bend, "stated": stated},
    )


def _pattern(examined, *kinds):
    pattern = examined.control_patterns.height
    return pattern if pattern is not None and pattern.kind in kinds else None


def _told(pattern, names):
    """What all patterns have to say."""
    return {
        "names": names,
        "statistic": CORRECTIONS if pattern.is_of_adjustment else LEFT_OUT,
        "observed": pattern.size,
        "expected": 0.0,
        "probability": pattern.p_value,
        "facts": {
            "kind": str(pattern.kind),
            "n_points": len(pattern.point_ids),
            "n_control": pattern.n_control,
            "size": pattern.size,
            "moved": float(pattern.moved),
            "is_told_apart": pattern.is_told_apart,
        },
    }


TWO_STEP = SIMULTANEOUS = (
    wrong_control_height,
    broken_heights,
    heights_out_of_scale,
    lone_wrong_height,
    heights_beyond_claim,
    unseen_height_scale,
    bent_models,
    curvature_untold,
)
