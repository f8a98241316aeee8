"""What to say of relative orientations."""

from math import isfinite

from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.typesetting import factor, fixed, length, number
from einschalt.pipeline.summary.wording import flight_name, some_models, two_figures

REMEDIES = mark_each(
    {
        "look_for_gross_errors_of_orientation": (
            "Look for gross errors in their image coordinates or y-parallaxes"
        ),
        "measure_points_elsewhere": (
            "Measure points in them that lie higher or lower, or farther apart"
        ),
        "measure_more_points": "Measure more points in them, at different heights",
        "give_that_m_g_or_a_larger_one": (
            "Give that figure or a larger one, if neither gross errors nor a wrong "
            "camera made it: residuals of relative orientation see y-parallax only"
        ),
        "give_a_smaller_m_g": (
            "Give a figure near that one, and the standard errors of the points become "
            "smaller, if no photographs were copied: the block agrees as well"
        ),
        "turn_sign_of_y_parallax": (
            "Change the sign of y_parallax: y of the moved bundle minus y of the fixed "
            "one (see orientation_case)"
        ),
        "turn_sign_of_x_or_y": (
            "Change the sign of x or y in their image or model coordinates: x to the "
            "right, y upwards, z upwards"
        ),
        "measure_again_or_snoop": 'Measure them again, or set outliers = "snoop"',
        "taken_out": "They were taken out of the orientation: measure them again",
        "weigh_wrong_points_down": (
            'Match or measure them again, or set outliers = "tukey", which keeps the '
            "orientations of the good ones; the figures take all for alike"
        ),
        "wrong_points_weigh_less": (
            "They have less weight in the orientation, but their model points count as "
            "the others: match or measure them again"
        ),
        "weighted_down": "They have less weight in the orientation: measure them again",
    }
)


SURFACES = mark_each(
    {
        "critical": "{n:model|models} critical ({models})",
        "weak": "{n:model|models} weak ({models})",
    }
)
NEAR = mark(
    "Relative orientation near a dangerous surface: {models}; omega is up to {factor} "
    "as uncertain as on flat terrain"
)
UNDETERMINED = mark(
    "Relative orientation near a dangerous surface: {models}; omega is not determined"
)
WORSE = mark(
    "m_g_um of the {flight} is given as {given}, but the residuals of the image points "
    "show {shown}"
)
TAILS = mark(
    "{far} of the image points of the {flight} lie beyond 3 sigma_0 of the good ones "
    "({chance} expected by chance); the good ones have {sigma_0}, {share} of all have "
    "errors {factor} as large"
)


def models_near_a_dangerous_surface(finding):
    """Which models, and how uncertain omega is."""
    facts = finding.facts
    parts = ", ".join(
        translated(
            message,
            n=rows["n_models"],
            models=some_models(rows["models"], rows["n_models"]),
        )
        for verdict, message in SURFACES.items()
        if (rows := facts[verdict])["n_models"]
    )
    if not isfinite(facts["inflation"]):
        return translated(UNDETERMINED, models=parts)
    inflation = translated("{ratio} times", ratio=fixed(facts["inflation"], 1))
    return translated(NEAR, models=parts, factor=inflation)


def image_points_worse_than_given(finding):
    """Both figures of each flight."""
    return two_figures(finding.facts["flights"], WORSE)


def image_points_better_than_given(finding):
    """Both figures of each flight."""
    return two_figures(finding.facts["flights"], WORSE)


def heavy_tails_of_image_points(finding):
    """How many are far out, and how good the others are."""
    return "; ".join(
        translated(
            TAILS,
            far=_percent(part["far_out"]),
            flight=flight_name(part["flight"]),
            chance=_percent(finding.expected),
            sigma_0=length(part["good_sigma_0"]),
            share=_percent(part["share"]),
            factor=factor(part["times_as_large"]),
        )
        for part in finding.facts["flights"]
    )


def _percent(share):
    return f"{number(100.0 * share)} %"


WORDS = mark_each(
    {
        "orientations_without_convergence": (
            "{n_models:count model} with a relative orientation that did not converge: "
            "{models:models of n_models}"
        ),
        "models_near_a_dangerous_surface": models_near_a_dangerous_surface,
        "ambiguous_orientations": (
            "{n_models:count model} with a second relative orientation that fits about "
            "as well: {models:models of n_models}; the one nearer to the normal case "
            "was taken"
        ),
        "orientations_with_large_sigma_0": (
            "{n_models:count model} with sigma_0 of the relative orientation more than "
            "{times_usual:.0f} times the median of the flight: "
            "{models:models of n_models}; up to {largest_sigma_0:length}"
        ),
        "image_points_worse_than_given": image_points_worse_than_given,
        "image_points_better_than_given": image_points_better_than_given,
        "heavy_tails_of_image_points": heavy_tails_of_image_points,
        "corrections_that_spoil": (
            "The corrections by y-parallaxes make the {flight:flight} fit worse: m_0 "
            "{m_0_corrected:length}, without them {m_0_uncorrected:length}"
        ),
        "models_upside_down": (
            "{n_models:count spatial model} upside down: {models:models of n_models}"
        ),
        "image_points_that_contradict": (
            "{n_points:count image point} that contradict their pair, worst first "
            "(flight, model, point): {image_points:image_points of n_points}"
        ),
    }
)
