"""What to say of gross errors and of wrong sizes of errors."""

from einschalt.foundations.typesetting import count, length, number
from einschalt.pipeline.summary.suggestion import Suggestion
from einschalt.pipeline.summary.wording import (
    flight_name,
    some_observations,
    some_of,
    with_error,
)

REMEDIES = {
    "measure_again": "Measure them again",
    "measure_again_or_snoop": 'Measure them again, or set outliers = "snoop"',
    "measure_rejected_again": (
        "Measure them again; all stand in gross_measurements.csv"
    ),
    "measure_again_see_coverages": (
        "Measure them again; the values of their coverages stand in coverages.csv"
    ),
    "look_for_gross_errors_and_exchanged_names": (
        "Look for gross errors and for exchanged names"
    ),
    "check_worst_control": (
        "Check the first one and its measurements: a wrong one spoils the others"
    ),
    "check_control": "Check their coordinates and names",
    "check_control_or_snoop": (
        'Check their coordinates and names, or set outliers = "snoop"'
    ),
    "look_for_gross_errors": "Look for gross errors",
    "give_that_m_g": "Give that figure, if no gross error made it",
    "give_at_least_that_m_g": "Give at least that figure, if no gross error made it",
    "set_again": "Set them again: their mean is wrong",
}
KEY = "(flight, coverage, model, point)"


def suspect_observations(finding):
    """Which observations, the worst first."""
    facts = finding.facts
    return Suggestion(
        f"{count(facts['n_observations'], 'residual')} of up to "
        f"{length(facts['largest'])} that chance does not explain, worst first {KEY}: "
        f"{_observations(facts)}",
        REMEDIES[finding.remedy],
    )


def gross_measurements(finding):
    """Which measurements took no part, the worst first."""
    facts = finding.facts
    return Suggestion(
        f"{count(facts['n_observations'], 'measurement')}, off by up to "
        f"{length(facts['largest'])} from what the other models of the flight say, "
        f"took no part, worst first {KEY}: {_observations(facts)}",
        REMEDIES[finding.remedy],
    )


def _observations(facts):
    return some_observations(facts["observations"], facts["n_observations"])


def coverages_that_differ(finding):
    """Which points, and the largest difference."""
    facts = finding.facts
    return Suggestion(
        f"{count(facts['n_points'], 'point')} with coverages that differ by up to "
        f"{length(facts['largest'])}, more than they may: {_points(finding)}",
        REMEDIES[finding.remedy],
    )


def points_that_differ(finding):
    """Which points, beside the usual spread."""
    facts = finding.facts
    return Suggestion(
        f"{count(facts['n_points'], 'point')} with values more than "
        f"{facts['times_usual']:.0f} times as widely scattered as the median of "
        f"{length(facts['median'])} (spread_total): {_points(finding)}; up to "
        f"{length(facts['largest'])}",
        REMEDIES[finding.remedy],
    )


def control_that_contradicts(finding):
    """Which control points, the worst first."""
    return Suggestion(
        f"{_control(finding)} missed by up to {length(finding.facts['largest'])} where "
        "predicted without themselves, more than chance explains, worst first: "
        f"{_points(finding)}",
        REMEDIES[finding.remedy],
    )


def control_set_aside(finding):
    """Which control points were set aside."""
    return Suggestion(
        f"{_control(finding)} set aside, for contradicting the block, by up to "
        f"{length(finding.facts['largest'])}: {_points(finding)}",
        REMEDIES[finding.remedy],
    )


def control_against_block(finding):
    """Which control points, and what they do to the points near them."""
    verb = "contradicts" if finding.facts["n_points"] == 1 else "contradict"
    return Suggestion(
        f"{_control(finding)} that {verb} the block, by up to "
        f"{length(finding.facts['largest'])}: {_points(finding)}. Kept, they make the "
        "new points near them worse than claimed",
        REMEDIES[finding.remedy],
    )


def _control(finding):
    return count(finding.facts["n_points"], "control point")


def _points(finding):
    return some_of(finding.names, finding.facts["n_points"])


def wrong_measuring_errors(finding):
    """Both figures of each flight."""
    return _two_figures(finding, "the measurements show")


def settings_that_scatter(finding):
    """Both figures of each flight."""
    return _two_figures(finding, "repeated settings scatter by")


def _two_figures(finding, what):
    said = "; ".join(
        f"m_g_um of the {flight_name(part['flight'])} is given as "
        f"{number(part['given_um'])}, but {what} "
        f"{with_error(part['estimated_um'], part['standard_error_um'])}"
        for part in finding.facts["flights"]
    )
    return Suggestion(said, REMEDIES[finding.remedy])


def scattered_points(finding):
    """Which points, the worst first."""
    facts = finding.facts
    shown = some_observations(facts["observations"], facts["n_points"])
    return Suggestion(
        f"{count(facts['n_points'], 'point')} with settings up to "
        f"{number(facts['widest_um'])} µm apart in the image (total, one setting), "
        f"which chance does not explain, worst first {KEY}: {shown}",
        REMEDIES[finding.remedy],
    )


WORDS = {
    "suspect_observations": suspect_observations,
    "gross_measurements": gross_measurements,
    "coverages_that_differ": coverages_that_differ,
    "points_that_differ": points_that_differ,
    "control_that_contradicts": control_that_contradicts,
    "control_set_aside": control_set_aside,
    "control_against_block": control_against_block,
    "wrong_measuring_errors": wrong_measuring_errors,
    "settings_that_scatter": settings_that_scatter,
    "scattered_points": scattered_points,
}
