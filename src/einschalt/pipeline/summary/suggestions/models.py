"""What to say of models that failed or are weak, and of points that hang on them."""

from einschalt.foundations.display_names import printable
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.pipeline.summary.suggestion import Suggestion, filled
from einschalt.pipeline.summary.wording import flight_name, some_of

MOST_REASONS, MOST_MODELS = 5, 3
REMEDIES = mark_each(
    {
        "look_at_their_models": (
            "Their models failed, or too few points of these models have approximate "
            "coordinates"
        ),
        "look_at_residuals": (
            "Check their residuals for gross errors and for wrong control"
        ),
        "exchange_axes_unless_left_handed": (
            "Correct if the machine's axes are left-handed; otherwise exchange easting "
            "and northing"
        ),
        "convert_these_models": "Convert them to the unit of the other models",
        "look_at_units_and_scale_number": (
            "Give control in metres, and scale_number as the denominator"
        ),
        "look_at_units_of_control": (
            "Both flights show it: check the unit of the control points first"
        ),
        "correct_scale_number": (
            "Correct the scale number (or the principal distance) before m_g_um: the "
            "stated precision follows from both"
        ),
        "look_at_units_of_each_axis": (
            "Correct if the machine's axes have different scales; otherwise check the "
            "decimal points and units of easting and northing, and of x and y"
        ),
        "look_for_exchanged_names": "Look for exchanged names of points in them",
        "nothing_confirms_them": "Nothing confirms a point in one model",
        "gross_errors_cannot_be_seen": (
            "Their m_0 is unknown, and gross errors in them cannot be detected"
        ),
    }
)


# of one reason why models failed, with and without a remedy
REASON = mark("{flight}, {n:model|models} ({models}): {reason}")
REASON_AND_REMEDY = mark("{flight}, {n:model|models} ({models}): {reason}. {remedy}.")


def failed_models(finding):
    """How many failed, and a line for each of the commonest reasons."""
    facts = finding.facts
    details = [_reason(**reason) for reason in facts["reasons"][:MOST_REASONS]]
    n_more = facts["n_reasons"] - MOST_REASONS
    if n_more > 0:
        message = mark("and {n:further reason|further reasons}, see failures.csv")
        details.append(translated(message, n=n_more))
    problem = filled(mark("{n_failed} of {n_models:count model} failed"), finding)
    return Suggestion(problem, details=tuple(details))


def _reason(flight, reason, remedy, n_models, models):
    return translated(
        REASON_AND_REMEDY if remedy else REASON,
        flight=flight_name(flight),
        n=n_models,
        models=some_of(models, n_models, MOST_MODELS),
        reason=_sentence(reason),
        remedy=_sentence(remedy),
    )


def _sentence(text):
    return retold(printable(text).strip().rstrip("."))


WORDS = mark_each(
    {
        "failed_models": failed_models,
        "points_without_coordinates": (
            "{n_points:count measured point} without coordinates "
            "({names:names of n_points})"
        ),
        "models_with_large_m_0": (
            "{n_models:count model} with m_0 more than {times_usual:.0f} times that of "
            "the flight: {models:models of n_models}; up to {largest_m_0:length}"
        ),
        "all_models_mirrored": "All {n_affine:count model} are mirrored",
        "stretched_models": (
            "One axis has another scale than the other: {n_models:count model} are "
            "stretched alike, by {per_cent:.3g} %, while film stretches by no more "
            "than {largest_per_cent:.1f} %"
        ),
        "models_in_another_unit": (
            "{n_models:count model} with coordinates about {ratio:.2g} times as "
            "large as those of the other models of the flight: "
            "{models:models of n_models}. "
            "y-parallaxes with their points and the base must have the same unit"
        ),
        "models_larger_than_film": (
            "The models of the {flight:flight} measure {diameter:length} on the "
            "ground, which is {on_film_mm:.0f} mm in photographs at "
            "1:{scale_number:.0f}; no film is larger than {largest_mm:.0f} mm across"
        ),
        "scale_numbers_contradicted": (
            "The photographs of the {flight:flight} have the scale 1:{found:.0f} on "
            "the ground, but scale_number is {scale_number:.0f}"
        ),
        "mirrored_models": (
            "{n_mirrored} of {n_affine:count affine model} mirrored: "
            "{models:models of n_mirrored}"
        ),
        "points_in_one_coverage": (
            "{n_points:count point} in one coverage only ({names:names of n_points}), "
            "{n_in_one_model} in one model only"
        ),
        "points_in_one_model": (
            "{n_points:count point} in one model only ({names:names of n_points})"
        ),
        "models_without_redundancy": (
            "{n_models:count model} without redundancy: {models:models of n_models}"
        ),
    }
)
