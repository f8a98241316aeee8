"""The first line: how many new points, and how good they are."""

import numpy as np

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import count, length, number_word
from einschalt.pipeline.summary.suggestions.catalogue import (
    coverages_of_low_flight,
    has_credible_propagation,
    n_models,
)


def verdict(result) -> str:
    """Say in one line how many points the block has and how good they are."""
    return f"{printable(result.block.name)}: {verdict_on(result)}"


def verdict_on(result) -> str:
    """Say the verdict without the name of the block."""
    figures = result.figures
    new = count(figures.n_new, "new point") if figures.n_new else "no new points"
    verdict = f"{new}{_how_good(result)}"
    if result.failures.empty:
        return verdict
    failed = result.failures[["flight", "coverage", "model_id"]].drop_duplicates()
    n_all = sum(n_models(flight) for flight in result.block.flights.values())
    return f"{verdict}; {len(failed)} of {count(n_all, 'model')} failed"


def _how_good(result):
    """The propagated figure where it holds, and the paper's beside it; or a bound."""
    figures = result.figures
    if result.simultaneous is not None:
        return _how_good_adjusted(result)
    if not np.isfinite(figures.mean_paper):
        return ""
    paper = f"{length(figures.mean_paper)} after Kovarik's budget"
    if has_credible_propagation(result):
        return f", {length(figures.mean_total)} (total, {mean_of(result)}; {paper})"
    if np.isnan(figures.mean_total) and result.claim.is_supported:
        return f", {paper} (total, {mean_of(result)})"
    claimed = figures.mean_total
    if np.isnan(claimed):
        claimed = figures.mean_paper
    # what the measurements exceed the claim by is the least that it is too small by
    enlarged = claimed * result.claim.enlargement
    known = [enlarged, figures.mean_paper, figures.mean_internal]
    return f", {length(np.nanmax(known))} or worse (total, {mean_of(result)})"


def _how_good_adjusted(result):
    """The adjusted figure, and that of the two-step way beside it."""
    total = result.figures.mean_total
    if not np.isfinite(total):
        return " from the simultaneous adjustment"
    other = np.nan if result.two_step is None else result.two_step.figures.mean_total
    beside = f"; {length(other)} in two steps" if np.isfinite(other) else ""
    return f", {length(total)} (total, simultaneous adjustment{beside})"


def mean_of(result) -> str:
    """Say of how many coverages a final coordinate is the mean."""
    n_coverages = coverages_of_low_flight(result)
    if n_coverages == 1:
        return "one coverage"
    return f"mean of {number_word(n_coverages)} coverages"
