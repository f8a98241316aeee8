"""The first line: how many new points, and how good they are."""

import numpy as np

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import count, length, number_word
from einschalt.pipeline.assessment.credibility import Reason, credible_figure
from einschalt.pipeline.block.facts import count_coverages, count_models


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
    n_all = sum(map(count_models, result.block.flights.values()))
    return f"{verdict}; {len(failed)} of {count(n_all, 'model')} failed"


def _how_good(result):
    """The propagated figure where it holds, and the paper's beside it; or a bound."""
    figures = result.figures
    if result.simultaneous is not None:
        return _how_good_adjusted(result)
    if not np.isfinite(figures.mean_paper):
        return ""
    figure = credible_figure(result)
    value, mean = length(figure.value), mean_of(result)
    if figure.is_lower_bound:
        return f", {value} or worse (total, {mean})"
    if figure.reason is Reason.BUDGET:
        return f", {value} after Kovarik's budget (total, {mean})"
    paper = f"{length(figures.mean_paper)} after Kovarik's budget"
    return f", {value} (total, {mean}; {paper})"


def _how_good_adjusted(result):
    """The adjusted figure, and that of the two-step way beside it."""
    figure = credible_figure(result)
    if figure.reason is Reason.UNKNOWN:
        return " from the simultaneous adjustment"
    other = np.nan if result.two_step is None else result.two_step.figures.mean_total
    beside = f"; {length(other)} in two steps" if np.isfinite(other) else ""
    return f", {length(figure.value)} (total, simultaneous adjustment{beside})"


def mean_of(result) -> str:
    """Say of how many coverages a final coordinate is the mean."""
    n_coverages = count_coverages(result.block.low_flight)
    if n_coverages == 1:
        return "one coverage"
    return f"mean of {number_word(n_coverages)} coverages"
