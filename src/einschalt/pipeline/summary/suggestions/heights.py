"""What to say of heights that are not as good as stated."""

from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.typesetting import length, names, number
from einschalt.pipeline.summary.suggestion import Suggestion, filled
from einschalt.pipeline.summary.suggestions.causes import explained
from einschalt.pipeline.summary.wording import flight_name

REMEDIES = mark_each(
    {
        "check_that_height": "Check its height, and set it aside if it is wrong",
        "check_lone_height": (
            "Check its height, its name and its measurements first; until then heights "
            "near it may be as wrong"
        ),
        "check_height_network": (
            "Look for control heights of different levelling networks or datums"
        ),
        "check_principal_distance": (
            "Check the principal distance, the scale of z and the base"
        ),
        "make_sure_of_principal_distance": (
            "Make sure of the principal distance, or give points at other heights"
        ),
        "calibrate": (
            "The models were corrected by it, and standard errors contain what it is "
            "not known by; a calibration, or the curvature of the Earth taken off, "
            "would give smaller ones"
        ),
        "give_system": (
            'Give the reference system of the coordinates, such as crs = "EPSG:31255"; '
            'or earth_curvature = "ignored" if they are those of a plane, or the '
            "models are corrected"
        ),
        "check_heights": (
            "Check the heights of control and check points, their standard errors and "
            "the principal distance"
        ),
    }
)
NOT_SUPPORTED = mark("The stated precision of the heights is not supported: {tests}")
FAR_OFF = mark("{tests}; far off: {far}")
LONE = mark_each(
    {
        "check": (
            "The height of check point {point} differs by {largest:length}: those of "
            "{n_others:count other known point} differ by {rms_of_others:length} (RMS)"
        ),
        "control": (
            "The height of control point {point}, which took no part, differs by "
            "{largest:length}: those of {n_others:count other known point} differ by "
            "{rms_of_others:length} (RMS)"
        ),
    }
)
MISSED = mark("{quantity}: RMS {observed}, expected {expected}")
BENT = mark(
    "The heights of {n_control:count control point} are bent by {size:length}, which "
    "moves heights by {moved:length} (RMS)"
)
APART = mark(
    "The heights of {n_points} of {n_control:count control point} lie {size:length} "
    "from the others, on one side of a line: {names:names of n_points}, which moves "
    "heights by {moved:length} (RMS)"
)
SCATTERED = mark(
    "The heights of {n_points} of {n_control:count control point} lie {size:length} "
    "from the others, between which they lie: {names:names of n_points}, which moves "
    "heights by {moved:length} (RMS)"
)
OR_LARGER = mark("{told}; larger errors of all heights would explain it as well")
OF_KIND = {"bend": BENT, "step": APART, "group": SCATTERED}
OUT_OF_SCALE = mark(
    "{flights}: the scale of model heights differs from that of given heights "
    "({per_cent:+.2f} %), which moves heights by {moved:length} (RMS)"
)
UNSEEN = mark(
    "Given heights differ too little to check the principal distance: an error of it "
    "would be noticed from {per_cent} per cent on. Each per cent moves the heights of "
    "the new points by {moved} (RMS)"
)
UNSEEN_AT_ALL = mark(
    "Given heights differ too little to check the principal distance. Each per cent of "
    "an error moves the heights of the new points by {moved} (RMS)"
)
MOST_NAMED = 3
MOST_PER_CENT = 1000.0  # of errors that are worth a figure
POINT_OFF = mark_each(
    {
        "control_points": (
            "The height of control point {names:names of n_points} is {size:length} "
            "off, which moves heights by {moved:length} (RMS)"
        ),
        "approximate_points": (
            "The height of approximate point {names:names of n_points} is {size:length}"
            " off, which moves heights by {moved:length} (RMS)"
        ),
    }
)
OF_DISTANCE = mark(
    "{told}; a principal distance of {distance} mm instead of the stated one would "
    "explain it"
)


def heights_beyond_claim(finding):
    """Every comparison that contradicts the claimed heights, and which are far off."""
    tests = "; ".join(
        translated(
            MISSED,
            quantity=translated(test["quantity"]),
            observed=length(test["observed"]),
            expected=length(test["predicted"]),
        )
        for test in finding.facts["rejected"]
    )
    if finding.names:
        far = names(finding.names[:MOST_NAMED])
        tests = translated(FAR_OFF, tests=tests, far=far)
    return translated(NOT_SUPPORTED, tests=tests)


def lone_wrong_height(finding):
    """Of which known point, and how near the others are."""
    words = LONE[finding.facts["role"]]
    return filled(words, finding, point=names(finding.names))


BENT_IMAGES = mark(
    "All models of the {flight} are bent alike, by {size:length} in height at their "
    "edge (RMS): by a lens that its calibration does not describe, or by the curvature "
    "of the Earth and refraction"
)
BENT_MODELS = mark(
    "All models of the {flight} are bent alike, by {size:length} in height at their "
    "edge (RMS): by the plates of the plotter, a lens, or the curvature of the Earth "
    "and refraction"
)


def broken_heights(finding):
    """Which part lies apart, and by how much; or by how much control is bent."""
    told, facts = filled(OF_KIND[finding.facts["kind"]], finding), finding.facts
    if not facts["is_told_apart"]:
        told = translated(OR_LARGER, told=told)
    return Suggestion(
        told,
        translated(REMEDIES[finding.remedy]),
        details=explained(facts.get("explains", ())),
    )


def wrong_control_height(finding):
    """Of which point, and by how much."""
    return filled(POINT_OFF[finding.facts["height_of"]], finding)


def unseen_height_scale(finding):
    """From which error on it would be noticed, and what smaller ones do."""
    moved = length(finding.facts["moved_per_cent"])
    per_cent = finding.facts["per_cent"]
    if not per_cent < MOST_PER_CENT:
        return translated(UNSEEN_AT_ALL, moved=moved)
    return translated(UNSEEN, per_cent=number(per_cent), moved=moved)


def heights_out_of_scale(finding):
    """Of which flights, and by how much."""
    flights = ", ".join(map(flight_name, finding.names))
    told = filled(OUT_OF_SCALE, finding, flights=flights)
    distance = finding.facts["principal_distance_mm"]
    if distance is None:
        return told
    return translated(OF_DISTANCE, told=told, distance=number(distance, 4))


def bent_models(finding):
    """By how much, and what may have done it."""
    words = BENT_IMAGES if finding.facts["has_images"] else BENT_MODELS
    return filled(words, finding, flight=flight_name(finding.facts["flight"]))


WORDS = mark_each(
    {
        "bent_models": bent_models,
        "curvature_untold": (
            "No reference system is given, and the ground is taken for flat. On a map "
            "the Earth's curvature bends the heights in a model by {bend:length} "
            "(RMS), and their standard error is {stated:length}"
        ),
        "heights_beyond_claim": heights_beyond_claim,
        "lone_wrong_height": lone_wrong_height,
        "broken_heights": broken_heights,
        "heights_out_of_scale": heights_out_of_scale,
        "wrong_control_height": wrong_control_height,
        "unseen_height_scale": unseen_height_scale,
    }
)
