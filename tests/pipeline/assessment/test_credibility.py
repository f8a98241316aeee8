"""Which figure is believed, and why."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.assessment.credibility import (
    PAPER,
    TOTAL,
    Reason,
    claim_column,
    credible_figure,
    has_credible_propagation,
    high_flight_misfit,
)
from einschalt.pipeline.assessment.evidence.claim import Claim, ClaimTest
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings


def with_figures(result, **figures):
    return replace(result, figures=replace(result.figures, **figures))


def with_rejected_claim(result, ratio=2.0):
    """The result with coverages that differ by more than its claim predicts."""
    test = ClaimTest("coverage differences", 50, 0.05 * ratio, 0.05, 1e-9)
    changed = replace(result)
    # as if it had been asked for before
    vars(changed)["claim"] = Claim((test,), None, is_assumed=False)
    return changed


def test_the_propagated_figure_is_believed_where_nothing_contradicts_it(good_result):
    figure = credible_figure(good_result)
    assert figure.reason is Reason.PROPAGATED
    assert figure.value == good_result.figures.mean_total
    assert (figure.column, figure.factor) == (TOTAL, 1.0)
    assert not figure.is_lower_bound


def test_measurements_that_contradict_it_leave_a_lower_bound(faulty_result):
    """Propagation knows no measurement: a blunder of 200 m does not enlarge it."""
    assert not has_credible_propagation(faulty_result)
    assert claim_column(faulty_result) == PAPER
    figure, figures = credible_figure(faulty_result), faulty_result.figures
    assert figure.reason is Reason.CONTRADICTED
    assert figure.is_lower_bound
    enlarged = figures.mean_total * faulty_result.claim.enlargement
    assert figure.value == max(enlarged, figures.mean_paper, figures.mean_internal)


def test_a_high_flight_that_does_not_fit_takes_the_belief_away(good_result):
    assert has_credible_propagation(good_result)
    assert claim_column(good_result) == TOTAL
    changed = with_figures(good_result, m_0_high=0.5)
    assert not has_credible_propagation(changed)
    assert high_flight_misfit(changed).is_large
    assert not high_flight_misfit(good_result).is_large


def test_what_a_rejected_claim_is_exceeded_by_is_the_least_that_is_missing(good_result):
    changed = with_rejected_claim(good_result, ratio=2.0)
    figure = credible_figure(changed)
    assert figure.reason is Reason.CONTRADICTED
    assert figure.value == pytest.approx(2.0 * good_result.figures.mean_total)
    assert figure.factor == pytest.approx(2.0)


def test_without_propagation_the_budget_is_all_there_is(good_result):
    changed = with_figures(good_result, mean_total=np.nan)
    figure = credible_figure(changed)
    assert figure.reason is Reason.BUDGET
    assert figure.value == good_result.figures.mean_paper
    assert figure.column == PAPER
    assert not figure.is_lower_bound
    figure = credible_figure(with_rejected_claim(changed, ratio=3.0))
    assert figure.reason is Reason.BUDGET_CONTRADICTED
    assert figure.is_lower_bound
    assert figure.value == pytest.approx(3.0 * good_result.figures.mean_paper)


def test_nothing_is_believed_where_nothing_is_known(good_result):
    unknown = with_figures(good_result, mean_total=np.nan, mean_paper=np.nan)
    figure = credible_figure(unknown)
    assert figure.reason is Reason.UNKNOWN
    assert np.isnan(figure.value)
    assert not figure.is_lower_bound


def test_one_adjustment_has_its_own_figure(demo_block):
    result = densify(demo_block, Settings(method="simultaneous"))
    figure = credible_figure(result)
    assert figure.reason is Reason.ADJUSTED
    assert figure.value == result.figures.mean_total
    assert figure.column == TOTAL
    assert figure.factor == max(1.0, result.simultaneous.s_0)
    unknown = credible_figure(with_figures(result, mean_total=np.nan))
    assert unknown.reason is Reason.UNKNOWN


def test_a_block_without_control_errors_has_no_misfit(demo_block):
    control = demo_block.control_points.drop(columns="standard_error_m")
    result = densify(replace(demo_block, control_points=control))
    assert high_flight_misfit(result) is None
