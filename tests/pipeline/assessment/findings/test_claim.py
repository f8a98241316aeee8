"""Figures that the measurements contradict, and what is missing for them."""

from dataclasses import replace

import numpy as np
import pytest
from tests.changed_results import changed

from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings import claim as judges


def with_figures(result, **figures):
    figures = replace(result.figures, **figures)
    return changed(result, figures=figures).examination


@pytest.mark.parametrize("judge", judges.TWO_STEP)
def test_a_good_block_has_none(good_result, judge):
    assert judge(good_result.examination) is None


def test_coverages_that_differ_more_than_the_budget(good_result):
    paper = good_result.figures.mean_paper
    doubted = with_figures(good_result, mean_internal=2.0 * paper, mean_total=np.nan)
    found = judges.contradicted_budget(doubted)
    assert found.facts == {"internal": 2.0 * paper, "paper": paper}
    assert found.remedy == "raise_m_g"
    assert judges.contradicted_propagation(doubted) is None
    unknown = with_figures(good_result, mean_internal=np.nan, mean_total=np.nan)
    assert judges.contradicted_budget(unknown) is None


def test_a_propagated_figure_that_the_measurements_contradict(faulty_result):
    """Propagation knows no measurement: a blunder of 200 m does not enlarge it."""
    found = judges.contradicted_propagation(faulty_result.examination)
    figures = faulty_result.figures
    assert found.gravity is Gravity.GRAVE
    assert found.facts["propagated"] == found.expected == figures.mean_total
    assert found.observed == max(figures.mean_paper, figures.mean_internal)
    assert found.observed > 1.25 * found.expected
    # it is said once
    assert judges.contradicted_budget(faulty_result.examination) is None


def test_a_high_flight_that_fits_worse_than_its_errors(good_result):
    found = judges.high_flight_that_misfits(with_figures(good_result, m_0_high=0.5))
    assert found.facts["m_0"] == 0.5
    # m_g of 7.5 µm at 1:15 000 and control of 3 cm
    assert found.facts["explained"] == pytest.approx(np.hypot(0.1125, 0.03))
    assert found.facts["ratio"] == pytest.approx(0.5 / found.facts["explained"])
    assert found.probability < 0.001


def test_a_claim_that_does_not_stand_names_every_test(faulty_result):
    found = judges.claim_that_does_not_stand(faulty_result.examination)
    rejected = faulty_result.claim.rejected
    assert [part["quantity"] for part in found.facts["rejected"]] == [
        test.name for test in rejected
    ]
    assert found.probability == min(test.p_value for test in rejected)
    assert found.remedy == "doubt_sizes_of_errors"
    assert found.gravity is Gravity.GRAVE


def test_a_block_without_check_points_says_so(unchecked_result):
    found = judges.no_check_points(unchecked_result.examination)
    assert found.untested == "no_check_points"
    assert found.remedy == "give_check_points"


def test_what_the_propagated_figure_lacks_is_said(good_result):
    from einschalt.pipeline.block.block import Block
    from einschalt.pipeline.densify import densify

    block = good_result.block
    control = block.control_points.drop(columns="standard_error_m")
    flights = {"high_flight": block.high_flight, "low_flight": block.low_flight}
    result = densify(Block(control_points=control, crs=block.crs, **flights))
    assert "standard_error_total" not in result.points
    found = judges.figure_left_out(result.examination)
    assert found.untested == "control_without_standard_errors"
    said = " ".join(result.summary().split())
    assert "standard_error_total is missing: the control points have no stand" in said
    assert "Give standard_error_m, TOTAL in metres, in [control_points]." in said
