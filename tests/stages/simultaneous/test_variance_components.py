"""Sizes of errors that the residuals of a block show."""

from dataclasses import replace

import numpy as np
import pytest

import einschalt as es
from einschalt.pipeline.simulation.simulate_block import PRESETS
from einschalt.stages.simultaneous import variance_components
from einschalt.stages.simultaneous.adjustment import simultaneous_adjustment
from einschalt.stages.simultaneous.observations import MeasuredFlight, code_block

GROUPS = ["high_flight", "low_flight", "control"]


@pytest.fixture(scope="module")
def block():
    return es.simulate_block("demo", seed=6)


def with_m_g(block, factor):
    low = replace(block.low_flight, m_g_um=factor * block.low_flight.m_g_um)
    return replace(block, low_flight=low)


def test_factors_are_one_where_errors_are_as_given():
    z = []
    for seed in range(8):
        found = es.adjust_block(es.simulate_block("demo", seed=seed)).components
        assert list(found["group"]) == GROUPS
        assert not found["is_estimated"].any()
        z.append((found["factor"] - 1.0) / found["factor_standard_error"])
    mean = np.mean(z, axis=0)
    assert np.abs(mean).max() < 3.3 / np.sqrt(8)


@pytest.mark.parametrize("wrong_by", [0.5, 2.0])
def test_a_wrong_m_g_is_shown_and_taken_back(block, wrong_by):
    wrong = with_m_g(block, wrong_by)
    right = es.adjust_block(block, variance_components="estimated")
    found = es.adjust_block(wrong, variance_components="estimated")
    first, second = (a.components.set_index("group") for a in (right, found))
    assert second["is_estimated"].all()
    # the same errors in metres, whatever was given
    np.testing.assert_allclose(
        second["standard_error_m"], first["standard_error_m"], rtol=0.05
    )
    ratio = second.loc["low_flight", "factor"] / first.loc["low_flight", "factor"]
    assert ratio == pytest.approx(1.0 / wrong_by, rel=0.02)
    np.testing.assert_allclose(
        found.points[["easting", "northing"]],
        right.points[["easting", "northing"]],
        rtol=0,
        atol=2e-3,
    )
    assert found.s_0 == pytest.approx(1.0, abs=0.01)
    given = es.adjust_block(wrong)
    assert abs(given.s_0 - 1.0) > 0.15


def test_estimates_have_the_truth_within_their_errors():
    z = []
    for seed in range(6):
        block = with_m_g(es.simulate_block("demo", seed=seed), 1.5)
        found = es.adjust_block(block, variance_components="estimated").components
        true = np.array([1.0, 1.0 / 1.5, 1.0])
        z.append((found["factor"] - true) / found["factor_standard_error"])
    assert np.abs(np.mean(z, axis=0)).max() < 3.3 / np.sqrt(6)
    assert np.std(z, axis=0).max() < 1.8


def test_one_step_from_a_wrong_size_claims_no_precision(block):
    wrong = with_m_g(block, 4.0)
    step = es.adjust_block(wrong).components.set_index("group")
    whole = es.adjust_block(wrong, variance_components="estimated").components
    whole = whole.set_index("group")
    # the step is on the way to what the residuals show, and has not arrived
    one, all_steps = step.loc["low_flight"], whole.loc["low_flight"]
    short = one["factor"] - all_steps["factor"]
    assert 5.0 * all_steps["factor_standard_error"] < short < 1.0 - all_steps["factor"]
    assert step["factor_standard_error"].isna().all()
    assert np.isfinite(whole["factor_standard_error"]).all()


def test_groups_without_redundancy_keep_their_errors():
    noise = PRESETS["demo"].noise
    block = es.simulate_block("demo", seed=6, noise=noise)
    control = block.control_points.drop(columns="standard_error_m")
    held = es.adjust_block(
        replace(block, control_points=control), variance_components="estimated"
    )
    # control that is held has no errors to estimate
    assert list(held.components["group"]) == GROUPS[:2]


def test_unknown_word_is_said(block):
    with pytest.raises(
        es.EinschaltError, match="variance_components = 'known' is unknown; exp"
    ):
        es.adjust_block(block, variance_components="known")


def test_the_setting_is_that_of_adjust_block(block):
    settings = es.Settings(method="simultaneous", variance_components="estimated")
    found = es.densify(block, settings)
    assert found.simultaneous.components["is_estimated"].all()
    said = (
        "Errors of one coordinate (standard errors estimated from the residuals): high"
    )
    assert said in found.summary().replace("\n    ", " ")


def test_sizes_are_those_of_the_last_adjustment(block, monkeypatch):
    """Also where the estimation is cut off: no step counts twice."""
    wrong = with_m_g(block, 2.0)
    full = es.adjust_block(wrong, variance_components="estimated").components
    monkeypatch.setattr(variance_components, "MOST_PASSES", 1)
    first = es.adjust_block(wrong, variance_components="estimated").components
    # one pass comes near with the flights; a step that counted twice gives the square
    np.testing.assert_allclose(first["factor"][:2], full["factor"][:2], rtol=0.1)


@pytest.mark.slow
def test_without_redundancy_nothing_is_known_of_a_factor():
    """Rounding may leave less than nothing; warnings are errors in these tests."""
    for seed in range(6):
        block = es.simulate_block("demo", seed=seed)
        truth = block.truth
        for _, rows in block.low_flight.model_points.groupby(["coverage", "model_id"]):
            held = truth[truth["point_id"].isin(rows["point_id"].iloc[[0, 3, -1]])]
            flight = MeasuredFlight(
                "low_flight", rows, np.full(len(rows), 0.03), "affine"
            )
            tables = code_block([flight], held.assign(standard_error_m=0.03))
            found = simultaneous_adjustment(tables)
            assert found.redundancy == 0
            assert found.components["factor"].isna().all()
            assert found.components["factor_standard_error"].isna().all()
            assert (found.components["redundancy"] >= 0.0).all()
