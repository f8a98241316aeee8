"""Which figure is believed, and why."""

from dataclasses import replace

import numpy as np
import pytest
from tests.changed_results import changed

from einschalt.pipeline.assessment.credibility import (
    PAPER,
    TOTAL,
    Reason,
    claimed_column,
    has_credible_propagation,
)
from einschalt.pipeline.assessment.evidence.claim import Claim, ClaimTest
from einschalt.pipeline.assessment.evidence.fits.high_flight_misfit import (
    high_flight_misfit,
)
from einschalt.pipeline.assessment.examination import examine
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block


def with_figures(result, **figures):
    return changed(result, figures=replace(result.figures, **figures))


def with_rejected_claim(result, ratio=2.0):
    """The result with coverages that differ by more than its claim predicts."""
    test = ClaimTest("coverage differences", 50, 0.05 * ratio, 0.05, 1e-9)
    doubted = replace(result)
    # as if it had been asked for before
    vars(doubted.examination)["claim"] = Claim((test,), None)
    return doubted


def test_the_propagated_figure_is_believed_where_nothing_contradicts_it(good_result):
    figure = good_result.examination.credible
    assert figure.reason is Reason.PROPAGATED
    assert figure.value == good_result.figures.mean_total
    assert (figure.column, figure.factor) == (TOTAL, 1.0)
    assert not figure.is_lower_bound


def test_measurements_that_contradict_it_leave_a_lower_bound(faulty_result):
    """Propagation knows no measurement: a blunder of 200 m does not enlarge it."""
    assert not has_credible_propagation(faulty_result.examination)
    assert claimed_column(faulty_result.examination) == PAPER
    told, figures = faulty_result.examination.credible, faulty_result.figures
    assert told.reason is Reason.EXCHANGED_NAMES
    new = faulty_result.points[faulty_result.points["role"] == "new"]
    true = faulty_result.block.truth.set_index("point_id").loc[new["point_id"]]
    plan = ["easting", "northing"]
    away = new[plan].to_numpy() - true[plan].to_numpy()
    assert told.value == pytest.approx(
        np.sqrt(np.mean(np.sum(away**2, axis=1))), rel=0.01
    )
    # where no names are known to be wrong
    examined = examine(faulty_result.solution)
    vars(examined)["measured_names"] = None
    figure = examined.credible
    assert figure.reason is Reason.CONTRADICTED
    assert figure.is_lower_bound
    enlarged = figures.mean_total * faulty_result.claim.enlargement
    assert figure.value == max(enlarged, figures.mean_paper, figures.mean_internal)


def test_a_high_flight_that_does_not_fit_takes_the_belief_away(good_result):
    assert has_credible_propagation(good_result.examination)
    assert claimed_column(good_result.examination) == TOTAL
    doubted = with_figures(good_result, m_0_high=0.5)
    assert not has_credible_propagation(doubted.examination)
    assert high_flight_misfit(doubted.examination).is_large
    assert not high_flight_misfit(good_result.examination).is_large


def test_what_a_rejected_claim_is_exceeded_by_is_the_least_that_is_missing(good_result):
    doubted = with_rejected_claim(good_result, ratio=2.0)
    figure = doubted.examination.credible
    assert figure.reason is Reason.CONTRADICTED
    assert figure.value == pytest.approx(2.0 * good_result.figures.mean_total)
    assert figure.factor == pytest.approx(2.0)


def test_without_propagation_the_budget_is_all_there_is(good_result):
    doubted = with_figures(good_result, mean_total=np.nan)
    figure = doubted.examination.credible
    assert figure.reason is Reason.BUDGET
    assert figure.value == good_result.figures.mean_paper
    assert figure.column == PAPER
    assert not figure.is_lower_bound
    figure = with_rejected_claim(doubted, ratio=3.0).examination.credible
    assert figure.reason is Reason.BUDGET_CONTRADICTED
    assert figure.is_lower_bound
    # the tests are those of what was propagated
    assert figure.value == pytest.approx(3.0 * good_result.figures.mean_total, rel=0.02)


@pytest.mark.slow
def test_known_points_that_the_budget_does_not_explain_enlarge_it(demo_block):
    control = demo_block.control_points.drop(columns="standard_error_m")
    result = densify(replace(demo_block, control_points=control))
    figure, known = result.examination.credible, result.examination.known_control
    assert np.isnan(result.figures.mean_total)
    assert known.are_beyond
    assert figure.reason is Reason.BUDGET_CONTRADICTED
    least = known.ratio * result.figures.mean_paper
    assert figure.value >= least * (1.0 - 1e-12)
    assert figure.is_lower_bound
    (told,) = (
        found
        for found in result.assessment.findings
        if found.code == "control_points_beyond_claim"
    )
    assert told.remedy == "state_control_errors"


@pytest.mark.slow
def test_errors_of_control_that_are_stated_are_not_asked_for(demo_block):
    """Approximate points of their own error leave no total figure; control has one."""
    truth = demo_block.truth[["point_id", "easting", "northing"]]
    control = demo_block.control_points.copy()
    control["easting"] += np.random.default_rng(1).normal(0.0, 0.5, len(control))
    block = replace(
        demo_block,
        high_flight=None,
        approximate_points=truth,
        approximate_m_0_m=0.2,
        control_points=control,
    )
    result = densify(block)
    assert np.isnan(result.figures.mean_total)
    (told,) = (
        found
        for found in result.assessment.findings
        if found.code == "control_points_beyond_claim"
    )
    assert told.remedy == "look_for_wrong_control"


def test_nothing_is_believed_where_nothing_is_known(good_result):
    unknown = with_figures(good_result, mean_total=np.nan, mean_paper=np.nan)
    figure = unknown.examination.credible
    assert figure.reason is Reason.UNKNOWN
    assert np.isnan(figure.value)
    assert not figure.is_lower_bound


def test_one_adjustment_has_its_own_figure(simultaneous_result):
    result = simultaneous_result
    figure = result.examination.credible
    assert figure.reason is Reason.ADJUSTED
    assert figure.value == result.figures.mean_total
    assert figure.column == TOTAL
    assert figure.factor == max(1.0, result.simultaneous.s_0)
    unknown = with_figures(result, mean_total=np.nan).examination.credible
    assert unknown.reason is Reason.ADJUSTED_UNKNOWN


def test_a_block_without_control_errors_has_no_misfit(demo_block):
    control = demo_block.control_points.drop(columns="standard_error_m")
    result = densify(replace(demo_block, control_points=control))
    assert high_flight_misfit(result.examination) is None


@pytest.mark.slow
def test_photographs_share_errors_in_the_misfit_of_a_clean_high_flight():
    """Taken for independent ones they made 3 of 25 clean blocks misfit."""
    geometry = replace(PRESETS["demo"].geometry, measurement="images")
    result = densify(simulate_block("demo", seed=910_007, geometry=geometry))
    misfit = high_flight_misfit(result.examination)
    high = result.examination.models.groupby("flight")["redundancy"].sum()
    assert misfit.degrees < 0.5 * high["high_flight"]
    assert misfit.p_value > 0.05


@pytest.fixture(scope="module")
def adjusted(demo_block):
    """The demo block in one adjustment, with control that a change has spoilt."""

    def densified(change, **settings):
        control = change(demo_block.control_points.copy())
        block = replace(demo_block, control_points=control)
        chosen = block.settings.updated({"method": "simultaneous", **settings})
        return densify(block, chosen)

    return densified


@pytest.mark.slow
def test_a_clean_adjustment_is_believed_as_it_is(adjusted):
    result = adjusted(lambda control: control)
    credible = result.examination.credible
    assert credible.reason is Reason.ADJUSTED
    assert credible.value == pytest.approx(result.figures.mean_total)
    assert result.examination.checked.is_supported


def test_names_shifted_by_one_row_are_no_centimetres(shifted_names_result):
    result = shifted_names_result
    credible = result.assessment.credible
    assert credible.is_lower_bound
    truth = result.block.truth.set_index("point_id").loc[result.points["point_id"]]
    axes = ["easting", "northing"]
    miss = result.points[axes].to_numpy() - truth[axes].to_numpy()
    is_new = (result.points["role"] == "new").to_numpy()
    true = np.sqrt(np.mean(np.sum(miss[is_new] ** 2, axis=1)))
    assert true > 100.0
    # never below half of what is true
    assert credible.value > 0.5 * true
    assert not result.points["is_within_tolerance"].any()
    assert "or worse" in result.summary().splitlines()[0]
    assert any(f.code == "adjustment_that_misfits" for f in result.assessment.findings)


@pytest.mark.slow
def test_errors_larger_than_given_enlarge_the_figure(demo_block):
    flight = replace(demo_block.low_flight, m_g_um=demo_block.low_flight.m_g_um / 2.0)
    block = replace(demo_block, low_flight=flight)
    result = densify(block, block.settings.updated({"method": "simultaneous"}))
    credible, s_0 = result.examination.credible, result.simultaneous.s_0
    assert 1.25 < s_0 < 2.0
    assert credible.reason is Reason.ADJUSTED_ENLARGED
    assert credible.value == pytest.approx(s_0 * result.figures.mean_total)
    assert not credible.is_lower_bound


@pytest.mark.slow
def test_a_tenth_more_enlarges_the_figure_as_it_does_single_points(demo_block):
    """An m_g of one flight that is too small by a half shows little in s_0."""
    low = replace(demo_block.low_flight, m_g_um=demo_block.low_flight.m_g_um / 1.5)
    settings = demo_block.settings.updated({"method": "simultaneous"})
    result = densify(replace(demo_block, low_flight=low), settings)
    figure, s_0 = result.examination.credible, float(result.simultaneous.s_0)
    assert 1.1 < s_0 < 1.3
    assert figure.reason is Reason.ADJUSTED_ENLARGED
    assert figure.value == pytest.approx(s_0 * result.figures.mean_total)
    assert figure.factor == pytest.approx(s_0)


@pytest.mark.slow
@pytest.mark.parametrize("is_deformed", [False, True])
def test_deformed_models_make_the_figure_a_lower_bound(
    demo_block, monkeypatch, is_deformed
):
    result = densify(demo_block, Settings(method="simultaneous"))
    kind = type(result.examination)
    monkeypatch.setattr(kind, "is_deformed", property(lambda _: is_deformed))
    credible = result.examination.credible
    assert credible.is_lower_bound == is_deformed
    assert credible.value == pytest.approx(result.figures.mean_total)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_a_strain_of_control_is_in_the_figure(method):
    """No residual shows what control makes of the points."""
    block = simulate_block("neukirchen", seed=1, noise=BlockNoise(network_strain=0.1))
    result = densify(
        block, block.settings.updated({"method": method, "tolerance": 0.1})
    )
    figure, strain = result.examination.credible, result.examination.strain
    assert strain.is_significant
    claimed = result.figures.mean_within
    assert figure.value >= np.hypot(claimed, strain.size) > 1.25 * claimed
    assert figure.is_lower_bound
    both = result.points.merge(block.truth, on="point_id", suffixes=("", "_true"))
    new = both[both["role"] == "new"]
    off = [new[axis] - new[f"{axis}_true"] for axis in ("easting", "northing")]
    true = np.sqrt(np.mean(np.hypot(*off) ** 2))
    assert true / figure.value == pytest.approx(1.0, abs=0.25)
    assert not result.points["is_within_tolerance"].any()
