"""Precision of the new points: propagated, after the paper, and internal."""

import numpy as np

from einschalt.foundations.typesetting import length, lengths, number_word
from einschalt.pipeline.assessment.credibility import Reason, credible_figure
from einschalt.pipeline.block.facts import count_coverages
from einschalt.pipeline.summary.sections import simultaneous_vs_two_step
from einschalt.pipeline.summary.sections.section import Section
from einschalt.pipeline.summary.sections.verdict import mean_of

TOTAL = (
    "All figures are total point errors, √(σ_E² + σ_N²); the error of one coordinate "
    "is total / √2."
)
INTERNAL = (
    "internal: from the differences of the coverages; it sees only the uncorrelated "
    "part of the error."
)
HEIGHTS = "Heights are computed; no figure here judges them."
SINGLE = "single: paper for the value of one model, internal for that of one coverage."
PROPAGATED = (
    "propagated: errors of control and of both flights, of the sizes given, carried "
    "through every stage with their correlations."
)
ORIENTED = (
    "propagated: errors of control and of both flights, of the sizes given, and of the "
    "orientations, as sigma_0 of all models has them, carried through every stage with "
    "their correlations."
)
FROM_IMAGES = (
    "propagated: errors of control and of the image points of both flights, of the "
    "sizes given, carried through relative orientation and every stage; models that "
    "share a photograph share the errors of its points."
)
PAPER = "paper: Kovarik 1971, M² = (m_g · scale number)² + m_t²."
TOO_SMALL = "standard_error_paper is too small: {}."
HIGH_SHARED = "the approximate coordinates share the high flight's transformation error"
GIVEN_SHARED = "neighbouring approximate points share errors, which is not known here"
MODELS_SHARE = "what a model lacks on its control points, all of its points share"
BOTH_SHARE = "{} coverages share the approximate coordinates"
BELIEVE_PROPAGATED = (
    "Believe the propagated figure: it alone counts the errors that points and "
    "coverages share, which the other two leave out."
)
BELIEVE_NONE = (
    "Believe none of the three as it stands: the measurements contradict the sizes of "
    "errors that were given, and the largest figure is a lower bound."
)
BELIEVE_NEITHER = (
    "Believe the larger figure as a lower bound: neither of them counts the errors "
    "that points and coverages share."
)
BELIEVE = {
    Reason.PROPAGATED: BELIEVE_PROPAGATED,
    Reason.CONTRADICTED: BELIEVE_NONE,
}


def section(result) -> Section:
    """Precision of the new points: single value and mean, each as it is known."""
    if result.simultaneous is not None:
        return simultaneous_vs_two_step.section(result)
    figures = result.figures
    single = ("single", np.nan, figures.single_paper, figures.single_internal)
    mean = (
        mean_of(result),
        figures.mean_total,
        figures.mean_paper,
        figures.mean_internal,
    )
    titles, *columns = zip(single, mean, strict=True)
    header = ("", "propagated", "paper", "internal")
    shown = [
        (name, lengths(column))
        for name, column in zip(header[1:], columns, strict=True)
        if name != "propagated" or np.isfinite(figures.mean_total)
    ]
    rows = zip(titles, *(texts for _, texts in shown), strict=True)
    return Section(
        "Precision of the new points (total, RMS)",
        ("", *(name for name, _ in shown)),
        tuple(rows) if figures.n_new else (),
        (what_to_believe(result), too_small(result), *remarks(result)),
    )


def what_to_believe(result) -> str:
    """Say in one sentence which of the figures to believe, and why they differ."""
    return BELIEVE.get(credible_figure(result).reason, BELIEVE_NEITHER)


def remarks(result) -> tuple[str, ...]:
    """Say what the figures of precision mean."""
    if result.simultaneous is not None:
        return (TOTAL, *simultaneous_vs_two_step.remarks(result))
    chosen = [TOTAL, PAPER]
    if np.isfinite(result.figures.mean_total):
        chosen.insert(1, _propagated(result))
    if count_coverages(result.block.low_flight) > 1:
        chosen.append(INTERNAL)
        if result.settings.coverage_mean == "all":
            chosen.append(SINGLE)
    if "height" in result.points:
        chosen.append(_heights(result))
    return tuple(chosen)


def _propagated(result):
    """Say which errors are carried to the points."""
    if any(flight.has_images for flight in result.block.flights.values()):
        return FROM_IMAGES
    is_oriented = result.errors is not None and "orientation" in result.errors.parts
    return ORIENTED if is_oriented else PROPAGATED


def _heights(result):
    """Say how good heights are, where that is known."""
    points = result.points
    is_new = points["role"] == "new"
    if "standard_error_height" not in points or not is_new.any():
        return HEIGHTS
    size = length(np.sqrt(np.mean(points.loc[is_new, "standard_error_height"] ** 2)))
    said = f"Heights of the new points: {size} (propagated, RMS"
    if all(flight.has_images for flight in result.block.flights.values()):
        return f"{said})."
    return f"{said}; measured heights as the differences of the models show them)."


def too_small(result) -> str:
    """Say why the paper's figure is too small, as far as that is known here."""
    if result.simultaneous is not None:
        return simultaneous_vs_two_step.caution(result)
    n_coverages = count_coverages(result.block.low_flight)
    word = "both" if n_coverages == 2 else f"all {number_word(n_coverages)}"
    shared = [BOTH_SHARE.format(word)] if n_coverages > 1 else []
    if result.block.high_flight is not None:
        return TOO_SMALL.format(", and ".join([HIGH_SHARED, *shared]))
    if np.isfinite(result.figures.mean_total):
        return TOO_SMALL.format(", and ".join([MODELS_SHARE, *shared]))
    if shared:
        return TOO_SMALL.format(f"{shared[0]}; more so where {GIVEN_SHARED}")
    return f"standard_error_paper is too small where {GIVEN_SHARED}."
