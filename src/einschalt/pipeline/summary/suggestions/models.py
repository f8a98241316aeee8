"""What to say of models that failed or are weak, and of points that hang on them."""

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import count, length
from einschalt.pipeline.summary.suggestion import Suggestion
from einschalt.pipeline.summary.wording import flight_name, some_models, some_of

MOST_REASONS, MOST_MODELS = 5, 3
REMEDIES = {
    "look_at_their_models": (
        "Their models failed, or too few points of these have approximate coordinates"
    ),
    "look_at_residuals": (
        "Look at their residuals for gross errors and for wrong control"
    ),
    "exchange_axes_unless_left_handed": (
        "Right where the machine's axes are left-handed; otherwise exchange easting "
        "and northing"
    ),
    "look_for_exchanged_names": "Look for exchanged names of points in them",
    "nothing_confirms_them": "Nothing confirms a point in one model",
    "gross_errors_cannot_be_seen": (
        "Their m_0 is unknown and gross errors in them cannot be seen"
    ),
}


def failed_models(finding):
    """How many failed, and a line for each of the commonest reasons."""
    facts = finding.facts
    details = [_reason(**reason) for reason in facts["reasons"][:MOST_REASONS]]
    n_more = facts["n_reasons"] - MOST_REASONS
    if n_more > 0:
        details.append(f"and {count(n_more, 'further reason')}, see failures.csv")
    return Suggestion(
        f"{facts['n_failed']} of {count(facts['n_models'], 'model')} failed",
        details=tuple(details),
    )


def _reason(flight, reason, remedy, n_models, models):
    shown = some_of(models, n_models, MOST_MODELS)
    text = (
        f"{flight_name(flight)}, {count(n_models, 'model')} ({shown}): "
        f"{_sentence(reason)}"
    )
    return f"{text}. {_sentence(remedy)}." if remedy else text


def _sentence(text):
    return printable(text).strip().rstrip(".")


def points_without_coordinates(finding):
    """Which points have none."""
    n_points = finding.facts["n_points"]
    return Suggestion(
        f"{count(n_points, 'measured point')} without coordinates "
        f"({some_of(finding.names, n_points)})",
        REMEDIES[finding.remedy],
    )


def models_with_large_m_0(finding):
    """Which models, and the largest m_0."""
    facts = finding.facts
    return Suggestion(
        f"{count(facts['n_models'], 'model')} with m_0 more than "
        f"{facts['times_usual']:.0f} times that of the flight: "
        f"{some_models(facts['models'], facts['n_models'])}; up to "
        f"{length(facts['largest_m_0'])}",
        REMEDIES[finding.remedy],
    )


def all_models_mirrored(finding):
    """Axes, more likely than names."""
    return Suggestion(
        f"All {count(finding.facts['n_affine'], 'affine model')} are mirrored",
        REMEDIES[finding.remedy],
    )


def mirrored_models(finding):
    """Which models."""
    facts = finding.facts
    return Suggestion(
        f"{facts['n_mirrored']} of {count(facts['n_affine'], 'affine model')} "
        f"mirrored: {some_models(facts['models'], facts['n_mirrored'])}",
        REMEDIES[finding.remedy],
    )


def points_in_one_coverage(finding):
    """Which points, and how many of them are in one model only."""
    facts = finding.facts
    return Suggestion(
        f"{count(facts['n_points'], 'point')} in one coverage only "
        f"({some_of(finding.names, facts['n_points'])}), "
        f"{facts['n_in_one_model']} of them in one model only",
        REMEDIES[finding.remedy],
    )


def points_in_one_model(finding):
    """Which points."""
    n_points = finding.facts["n_points"]
    return Suggestion(
        f"{count(n_points, 'point')} in one model only "
        f"({some_of(finding.names, n_points)})",
        REMEDIES[finding.remedy],
    )


def models_without_redundancy(finding):
    """Which models."""
    facts = finding.facts
    return Suggestion(
        f"{count(facts['n_models'], 'model')} without redundancy: "
        f"{some_models(facts['models'], facts['n_models'])}",
        REMEDIES[finding.remedy],
    )


WORDS = {
    "failed_models": failed_models,
    "points_without_coordinates": points_without_coordinates,
    "models_with_large_m_0": models_with_large_m_0,
    "all_models_mirrored": all_models_mirrored,
    "mirrored_models": mirrored_models,
    "points_in_one_coverage": points_in_one_coverage,
    "points_in_one_model": points_in_one_model,
    "models_without_redundancy": models_without_redundancy,
}
