"""What to say of affinity of film and of strain of the control network."""

from math import isfinite

from einschalt.foundations.display_names import printable
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.typesetting import fixed, length
from einschalt.pipeline.summary.suggestion import Suggestion, filled
from einschalt.pipeline.summary.suggestions.causes import explained
from einschalt.pipeline.summary.wording import flight_name, ppm, probability

MOST_SHOWN = 3
REMEDIES = mark_each(
    {
        "correct_region_or_give_group": (
            "Check where their coordinates come from (part of a network, strip, "
            "photograph, system) and correct them, control in the region as well; or "
            "give the points a group of their own, with group_error_m as large as the "
            "shift"
        ),
        "correct_or_take_out_points": (
            "Check where their coordinates come from (misprint, exchanged names, "
            "another target) and correct them, or take these points out of the "
            "approximate points"
        ),
        "correct_control": (
            "Check whether they come from the same network, survey and system as the "
            "others, and correct their coordinates; or give them a group of their "
            "own, with group_error_m as large as the shift"
        ),
        "compare_both_parts": (
            "Nothing tells which part is off: compare where the coordinates of both "
            "come from (network, strip, photograph, system), and correct one of them, "
            "or give each part a group, with group_error_m as large as the shift"
        ),
        "check_network": (
            "Check the network there, and give control from another network, since "
            "more points of this one share it"
        ),
        "adjust_or_calibrate": (
            'Use method = "simultaneous", which models that, or calibrate camera and '
            "plotter"
        ),
        "check_network_or_adjust": (
            "Check the network there, and give control from another network, since "
            "more "
            'points of this one share it. method = "simultaneous" suffers less from it'
        ),
        "check_network_in_parts": (
            "Check whether its parts come from the same network, survey and system"
        ),
        "look_for_wrong_control_or_raise_errors": (
            "Look for wrong ones, or raise standard_error_m"
        ),
    }
)
STRAINED = mark(
    "The control network is strained: neighbours among the {n_control} control points "
    "are displaced together, by {size:length} (total, RMS) over {reach:length}, most "
    "at {worst}; standard_error_total does not include that"
)
STRAINED_BY = mark(
    "The control network is strained: neighbours among the {n_control} control points "
    "are displaced together, by {size:length} (total, RMS) over {reach:length}, most "
    "at {worst}; standard_error_total does not include that: allow for "
    "{claimed_with_strain:length}, not {claimed:length}"
)
DISPLACED = mark("{name} (easting {easting}, northing {northing})")
BENT = mark(
    "The control network is bent: a quadratic strain of its {n_control:count control "
    "point} has {size:length} (total, RMS). It moves the new points by {moved:length} "
    "(RMS)"
)
BROKEN = mark(
    "The control network is broken in two: on one side of a line {n_points} of its "
    "{n_control:count control point} lie apart from the others, by easting "
    "{easting:length}, northing {northing:length}: {names:names of n_points}. It moves "
    "the new points by {moved:length} (RMS)"
)
WRONG_POINTS = mark(
    "Given elsewhere than all models have it: {n_points:count approximate point} of "
    "{n_given}, by up to {largest:length}: {names:names of n_points}"
)
WRONG_POINTS_MOVE = mark(
    "Given elsewhere than all models have it: {n_points:count approximate point} of "
    "{n_given}, by up to {largest:length}: {names:names of n_points}. That moves the "
    "new points by {moved:length} (RMS)"
)
POINT_LIES = mark(
    "{name}: given less measured, easting {easting}, northing {northing} (standard "
    "error of each {standard_error}; {n:independent value|independent values})."
)
POINT_LIES_AT = mark(
    "{name}: given less measured, easting {easting}, northing {northing} (standard "
    "error of each {standard_error}; {n:independent value|independent values}). It "
    "lies where {other} is given, and {other} where {name} is: names are exchanged, in "
    "this list or in all measurements."
)
POINT_LIES_WITH_CONTROL = mark(
    "{name}: given less measured, easting {easting}, northing {northing} (standard "
    "error of each {standard_error}; {n:independent value|independent values}). "
    "Control gives it as wrong."
)
REGION = mark(
    "{n_points} of {n_given:count approximate point} are displaced together against "
    "all others, by easting {easting:length}, northing {northing:length} (standard "
    "error of each {standard_error:length}): {points:names of n_points}. The region is "
    "{extent:length} across, about easting {middle_east}, northing {middle_north}. It "
    "moves the new points by {moved:length} (RMS)"
)
REGION_OF_CONTROL = mark(
    "{n_points} of {n_given:count control point} are displaced together against all "
    "others, by easting {easting:length}, northing {northing:length} (standard error "
    "of each {standard_error:length}): {points:names of n_points}. The region is "
    "{extent:length} across, about easting {middle_east}, northing {middle_north}. It "
    "moves the new points by {moved:length} (RMS)"
)
SCATTERED_CONTROL = mark(
    "{n_points} of {n_given:count control point}, which lie among the others, are "
    "displaced together against these, by easting {easting:length}, northing "
    "{northing:length} (standard error of each {standard_error:length}): "
    "{points:names of n_points}. That moves the new points by {moved:length} (RMS)"
)
OF_SCATTERED_CONTROL = mark(
    "{n_points} of {n_given:count control point}, which lie among the others, by "
    "easting {easting:length}, northing {northing:length} (standard error of each "
    "{standard_error:length}): {points:names of n_points}."
)
OF_REGIONS_OF_CONTROL = mark(
    "{n_points} of {n_given:count control point}, by easting {easting:length}, "
    "northing {northing:length} (standard error of each {standard_error:length}): "
    "{points:names of n_points}. The region is {extent:length} across, about easting "
    "{middle_east}, northing {middle_north}."
)
CHECKS_ALIKE = mark(
    "Check points there are displaced as well: {control:names of n_control}."
)
REGIONS = mark(
    "{n_regions} regions of given coordinates are displaced, each by a vector of its "
    "own: they move the new points by {moved:length} (RMS)"
)
OF_REGIONS = mark(
    "{n_points} of {n_given:count approximate point}, by easting {easting:length}, "
    "northing {northing:length} (standard error of each {standard_error:length}): "
    "{points:names of n_points}. The region is {extent:length} across, about easting "
    "{middle_east}, northing {middle_north}."
)
CONTRADICTING = mark(
    "The {n_control} control points contradict each other by more than their standard "
    "errors (p {p})"
)
CONTRADICTING_AND_MOVING = mark(
    "The {n_control} control points contradict each other by more than their standard "
    "errors (p {p}), which may put the new points off by {moved:length}"
)
CONTRADICTING_GIVEN = mark(
    "The {n_control} control points contradict the approximate points, which agree "
    "among themselves as stated (p {p}); if some of control is wrong together, the new "
    "points are off by {moved:length}"
)
CONTROL_ALIKE = mark(
    "Control in the region is displaced as well: {control:names of n_control}."
)
CONTROL_APART = mark(
    "Control in the region is not displaced: {control:names of n_control}."
)
# by what is displaced, and whether it lies among the others: of one, of several
WORDS_OF_REGION = {
    ("approximate_points", False): (REGION, OF_REGIONS),
    ("approximate_points", True): (REGION, OF_REGIONS),
    ("control_points", False): (REGION_OF_CONTROL, OF_REGIONS_OF_CONTROL),
    ("control_points", True): (SCATTERED_CONTROL, OF_SCATTERED_CONTROL),
}
AFFINITY = mark(
    "in the {flight} x is longer than y by {stretch}, with a shear of {shear}; effect "
    "{bias} (total, RMS)"
)
AFFINITY_ON_GROUND = mark(
    "in the {flight} models are longer to the east than to the north by {stretch}, "
    "with a shear of {shear}, however they were turned in the machine; effect {bias} "
    "(total, RMS)"
)


CURVED = mark("in the {flight} by {size} (total, RMS)")


def curved_models(finding):
    """By how much the models of each flight are curved."""
    flights = "; ".join(
        translated(
            CURVED, flight=flight_name(part["flight"]), size=length(part["size"])
        )
        for part in finding.facts["flights"]
    )
    return translated(
        "Models are curved alike, by the square and cube of the position in the model: "
        "{flights}. That can make the control network look strained",
        flights=flights,
    )


def film_affinity(finding):
    """The affinity of each flight, and what it makes."""
    parts = finding.facts["flights"]
    affinities = "; ".join(
        translated(
            AFFINITY_ON_GROUND if part["axes"] == "ground" else AFFINITY,
            flight=flight_name(part["flight"]),
            stretch=ppm(part["stretch"], part["stretch_error"]),
            shear=ppm(part["shear"], part["shear_error"]),
            bias=length(part["bias"]),
        )
        for part in parts
    )
    flights = ", ".join(f"[{part['flight']}]" for part in parts)
    return Suggestion(
        translated("Film or machine has an affinity: {flights}", flights=affinities),
        translated('Set transformation = "affine" in {flights}', flights=flights),
        details=explained(finding.facts.get("explains", ())),
    )


def strained_network(finding):
    """Its size, where it is largest and where to, and what to reckon with."""
    facts = finding.facts
    worst = ", ".join(
        translated(
            DISPLACED,
            name=printable(point),
            easting=length(east),
            northing=length(north),
        )
        for point, east, north in facts["displacements"][:MOST_SHOWN]
    )
    is_known = isfinite(facts["claimed_with_strain"])
    return filled(STRAINED_BY if is_known else STRAINED, finding, worst=worst)


def broken_network(finding):
    """Which part lies apart, and where to; or by how much control is bent."""
    words = BENT if finding.facts["kind"] == "bend" else BROKEN
    return Suggestion(
        filled(words, finding),
        translated(REMEDIES[finding.remedy]),
        details=explained(finding.facts.get("explains", ())),
    )


def wrong_approximate_points(finding):
    """Which points, how far off each, and what that does."""
    facts = finding.facts
    words = WRONG_POINTS_MOVE if isfinite(facts["moved"]) else WRONG_POINTS
    return Suggestion(
        filled(words, finding),
        translated(REMEDIES[finding.remedy]),
        details=(
            *map(_point_lies, facts["wrong_points"][:MOST_SHOWN]),
            *explained(facts.get("explains", ())),
        ),
    )


def _point_lies(point):
    """A sentence on one wrong point."""
    words = POINT_LIES_WITH_CONTROL if point["control_is_alike"] else POINT_LIES
    words = POINT_LIES_AT if point["exchanged_with"] else words
    lengths = {
        name: length(point[name]) for name in ("easting", "northing", "standard_error")
    }
    name = printable(point["point_id"])
    other = printable(point["exchanged_with"])
    return translated(words, name=name, other=other, n=point["n_models"], **lengths)


def displaced_region(finding):
    """Which points, how far off and where; and whether control is off with them."""
    facts = finding.facts
    further = facts.get("further_regions", ())
    if further:
        parts = [facts, *further]
        message = filled(REGIONS, finding, n_regions=str(len(parts)))
        details = [
            line
            for part in parts
            for line in (
                _place(finding, part, is_one_of_several=True),
                *_control(finding, part),
            )
        ]
    else:
        message, details = _place(finding, facts), _control(finding, facts)
    return Suggestion(
        message,
        translated(REMEDIES[finding.remedy]),
        details=(*details, *explained(facts.get("explains", ()))),
    )


def _place(finding, part, *, is_one_of_several=False):
    """A sentence on one region."""
    given = finding.facts.get("given", "approximate_points")
    alone, among = WORDS_OF_REGION[given, part.get("is_scattered", False)]
    words = among if is_one_of_several else alone
    places = {
        "middle_east": fixed(part["middle_easting"], 0),
        "middle_north": fixed(part["middle_northing"], 0),
    }
    return filled(words, finding, **{**part, **places})


def _control(finding, part):
    """Whether control in a region is displaced as well; no line without control."""
    if not part["n_control"]:
        return ()
    words = CONTROL_ALIKE if part["control_is_alike"] else CONTROL_APART
    if finding.facts.get("given") == "control_points":
        words = CHECKS_ALIKE
    return (filled(words, finding, **part),)


def contradicting_control(finding):
    """How sure it is that they do, and what that may do to the points."""
    words = CONTRADICTING
    if finding.facts["moved"] > 0.0:
        words = CONTRADICTING_AND_MOVING
    if finding.facts["is_beside_given"]:
        words = CONTRADICTING_GIVEN
    return filled(words, finding, p=probability(finding.probability))


WORDS = mark_each(
    {
        "wrong_approximate_points": wrong_approximate_points,
        "displaced_region": displaced_region,
        "film_affinity": film_affinity,
        "curved_models": curved_models,
        "broken_network": broken_network,
        "strained_network": strained_network,
        "contradicting_control": contradicting_control,
    }
)
