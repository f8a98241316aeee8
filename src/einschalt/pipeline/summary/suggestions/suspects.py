"""What to say of gross errors and of wrong sizes of errors."""

from einschalt.foundations.language import mark, mark_each, translated
from einschalt.pipeline.summary.suggestion import Suggestion, filled
from einschalt.pipeline.summary.wording import two_figures

REMEDIES = mark_each(
    {
        "measure_again": "Measure them again",
        "measure_again_or_snoop": 'Measure them again, or set outliers = "snoop"',
        "measure_excluded_again": "They are excluded; measure them again",
        "measure_rejected_again": (
            "Measure them again; gross_measurements.csv lists all of them"
        ),
        "measure_again_see_coverages": (
            "Measure them again; coverages.csv has the values of their coverages"
        ),
        "look_for_gross_errors_and_exchanged_names": (
            "Look for gross errors and for exchanged names"
        ),
        "check_worst_control": (
            "Check the first one and its measurements: a wrong one spoils the others"
        ),
        "check_control": "Check the coordinates and names",
        "check_all_control": (
            "Check the coordinates of these points and of the control around them; "
            "until then only check points tell how good the new points are"
        ),
        "check_control_or_snoop": (
            'Check the coordinates and names, or set outliers = "snoop"'
        ),
        "look_for_gross_errors": "Look for gross errors",
        "check_scale_and_independence": (
            "Check m_g_um and scale_number, and that no coordinates were measured once "
            "and given twice"
        ),
        "give_that_m_g": "Give that figure, if no gross error made it",
        "give_at_least_that_m_g": (
            "Give at least that figure, if no gross error made it"
        ),
        "set_again": "Set them again: their mean is wrong",
    }
)
AGAINST = mark(
    "{n_points:count control point contradicts|control points contradict} the block, "
    "by up to {largest:length}: {names:names of n_points}. If kept, they make the new "
    "points near them worse than stated"
)
SET_ASIDE = mark(
    "{n_points:count control point} set aside for contradicting the block, by up to "
    "{largest:length}: {names:names of n_points}"
)
ALIKE = mark(
    "All of them are off in one direction, as if they shared an error, or as if the "
    "control that is kept did: nothing measured tells which of the two is wrong."
)
MANY = mark(
    "These are {n_points} of {n_control} control points: where so many are refused, "
    "nothing tells whether they are wrong or the control that is kept."
)
MEASURED = mark(
    "m_g_um of the {flight} is given as {given}, but the measurements show {shown}"
)
REJECTED = mark(
    "{n_observations:count measurement}, off by up to {largest:length} "
    "compared with the other models of the flight, excluded, worst first "
    "(flight, coverage, model, point): "
    "{observations:observations of n_observations}"
)
UNDECIDED = mark(
    "Of {n_undecided:count point} all measurements of a flight are excluded: they "
    "contradict each other, and nothing tells which of them is wrong: "
    "{undecided:names of n_undecided}."
)
SET = mark(
    "m_g_um of the {flight} is given as {given}, but repeated settings scatter by "
    "{shown}"
)


def gross_measurements(finding):
    """What was excluded, and where that may be too much."""
    details = ()
    if finding.facts["n_undecided"]:
        details = (filled(UNDECIDED, finding),)
    remedy = translated(REMEDIES[finding.remedy])
    return Suggestion(filled(REJECTED, finding), remedy, details)


def control_against_block(finding):
    """Which control points, and what they do to the points near them."""
    return filled(AGAINST, finding)


def control_set_aside(finding):
    """Which control points, and whether they may be right."""
    facts, details = finding.facts, ()
    if facts["are_alike"]:
        details = (translated(ALIKE),)
    elif facts["are_many"]:
        n_points, n_control = facts["n_points"], facts["n_control"]
        details = (translated(MANY, n_points=n_points, n_control=n_control),)
    remedy = translated(REMEDIES[finding.remedy])
    return Suggestion(filled(SET_ASIDE, finding), remedy, details)


def wrong_measuring_errors(finding):
    """Both figures of each flight."""
    return two_figures(finding.facts["flights"], MEASURED)


def settings_that_scatter(finding):
    """Both figures of each flight."""
    return two_figures(finding.facts["flights"], SET)


WORDS = mark_each(
    {
        "suspect_observations": (
            "{n_observations:count residual} of up to {largest:length} that chance "
            "does not explain, worst first (flight, coverage, model, point): "
            "{observations:observations of n_observations}"
        ),
        "gross_measurements": gross_measurements,
        "coverages_that_differ": (
            "{n_points:count point} with coverages that differ significantly, by up to "
            "{largest:length}: {names:names of n_points}"
        ),
        "points_that_differ": (
            "{n_points:count point} with values more than {times_usual:.0f} times as "
            "widely scattered as the median of {median:length} (spread_total): "
            "{names:names of n_points}; up to {largest:length}"
        ),
        "control_that_contradicts": (
            "{n_points:count control point}, each predicted without itself, off by up "
            "to {largest:length}, more than chance explains, worst first: "
            "{names:names of n_points}"
        ),
        "control_set_aside": control_set_aside,
        "control_against_block": control_against_block,
        "wrong_measuring_errors": wrong_measuring_errors,
        "settings_that_scatter": settings_that_scatter,
        "scattered_points": (
            "{n_points:count point} with settings up to {widest_um:number} µm apart in "
            "the image (total, one setting), which chance does not explain, worst "
            "first (flight, coverage, model, point): "
            "{observations:observations of n_points}"
        ),
    }
)
