"""What to say of relative orientations."""

from math import isfinite

from einschalt.foundations.typesetting import count, fixed, length, number
from einschalt.pipeline.summary.suggestion import Suggestion
from einschalt.pipeline.summary.wording import (
    flight_name,
    some_image_points,
    some_models,
    with_error,
)

REMEDIES = {
    "look_for_gross_errors_of_orientation": (
        "Look for gross errors in their image coordinates or y-parallaxes"
    ),
    "measure_points_elsewhere": (
        "Measure points in them that lie higher or lower, or farther apart"
    ),
    "measure_more_points": "Measure more points in them, at different heights",
    "give_that_m_g_or_a_larger_one": (
        "Give that figure or a larger one, if neither gross errors nor a wrong camera "
        "made it: residuals of relative orientation see y-parallax only"
    ),
    "turn_sign_of_y_parallax": (
        "Turn the sign of y_parallax: y of the moved bundle less y of the fixed one "
        "(see orientation_case)"
    ),
    "turn_sign_of_x_or_y": (
        "Turn the sign of x or y in their image or model coordinates: x to the right, "
        "y upwards, z upwards"
    ),
    "measure_again_or_snoop": 'Measure them again, or set outliers = "snoop"',
    "taken_out": "They were taken out of the orientation: measure them again",
    "weighted_down": "They have less weight in the orientation: measure them again",
}


def orientations_without_convergence(finding):
    """Which models."""
    return Suggestion(
        f"{_count(finding.facts)} with a relative orientation that did not converge: "
        f"{_models(finding.facts)}",
        REMEDIES[finding.remedy],
    )


def models_near_a_dangerous_surface(finding):
    """Which models, and how uncertain omega is."""
    facts = finding.facts
    parts = ", ".join(
        f"{_count(facts[verdict])} {verdict} ({_models(facts[verdict])})"
        for verdict in ("critical", "weak")
        if facts[verdict]["n_models"]
    )
    uncertain = (
        f"up to {fixed(facts['inflation'], 1)} times as uncertain as on flat terrain"
    )
    known = uncertain if isfinite(facts["inflation"]) else "not determined"
    return Suggestion(
        f"Relative orientation near a dangerous surface: {parts}; omega is {known}",
        REMEDIES[finding.remedy],
    )


def ambiguous_orientations(finding):
    """Which models, and which orientation was taken."""
    return Suggestion(
        f"{_count(finding.facts)} with a second relative orientation that fits about "
        f"as well: {_models(finding.facts)}; the one nearer to the normal case was "
        "taken",
        REMEDIES[finding.remedy],
    )


def orientations_with_large_sigma_0(finding):
    """Which models, and the largest sigma_0."""
    facts = finding.facts
    return Suggestion(
        f"{_count(facts)} with sigma_0 of the relative orientation more than "
        f"{facts['times_usual']:.0f} times the median of the flight: "
        f"{_models(facts)}; up to {length(facts['largest_sigma_0'])}",
        REMEDIES[finding.remedy],
    )


def image_points_worse_than_given(finding):
    """Both figures of each flight."""
    said = "; ".join(
        f"m_g_um of the {flight_name(part['flight'])} is given as "
        f"{number(part['given_um'])}, but the residuals of the image points show "
        f"{with_error(part['estimated_um'], part['standard_error_um'])}"
        for part in finding.facts["flights"]
    )
    return Suggestion(said, REMEDIES[finding.remedy])


def corrections_that_spoil(finding):
    """m_0 with and without the corrections."""
    facts = finding.facts
    return Suggestion(
        f"The corrections by y-parallaxes make the {flight_name(facts['flight'])} fit "
        f"worse: m_0 {length(facts['m_0_corrected'])}, without them "
        f"{length(facts['m_0_uncorrected'])}",
        REMEDIES[finding.remedy],
    )


def models_upside_down(finding):
    """Which models."""
    facts = finding.facts
    return Suggestion(
        f"{count(facts['n_models'], 'spatial model')} upside down: {_models(facts)}",
        REMEDIES[finding.remedy],
    )


def image_points_that_contradict(finding):
    """Which points, the worst first."""
    facts = finding.facts
    shown = some_image_points(facts["image_points"], facts["n_points"])
    return Suggestion(
        f"{count(facts['n_points'], 'image point')} that contradict their pair, worst "
        f"first (flight, model, point): {shown}",
        REMEDIES[finding.remedy],
    )


def _count(facts):
    return count(facts["n_models"], "model")


def _models(facts):
    return some_models(facts["models"], facts["n_models"])


WORDS = {
    "orientations_without_convergence": orientations_without_convergence,
    "models_near_a_dangerous_surface": models_near_a_dangerous_surface,
    "ambiguous_orientations": ambiguous_orientations,
    "orientations_with_large_sigma_0": orientations_with_large_sigma_0,
    "image_points_worse_than_given": image_points_worse_than_given,
    "corrections_that_spoil": corrections_that_spoil,
    "models_upside_down": models_upside_down,
    "image_points_that_contradict": image_points_that_contradict,
}
