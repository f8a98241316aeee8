"""Pass or fail of every point, with the figure that was used."""

from dataclasses import replace

import numpy as np
import pytest
from tests.given_approximations import onto_given_approximations

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.assessment.tolerance import PRESETS
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import TOLERANCES, Settings
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.pipeline.summary.summary import sections, summarize


def said(result):
    return sections(result.assessment)["tolerance"].text().replace("\n    ", " ")


@pytest.fixture(scope="module")
def wrong_block(demo_block):
    """A block whose low flight is three times worse than it claims."""
    low = replace(demo_block.low_flight, m_g_um=demo_block.low_flight.m_g_um / 3.0)
    return replace(demo_block, low_flight=low)


def test_every_preset_of_the_settings_is_known():
    assert {"none", *PRESETS} == set(TOLERANCES)


# VermV 1994 § 7: 7 cm; 2010 § 6: 4 cm; 2016 § 6: 4 cm, residuals of control 5 cm
@pytest.mark.parametrize(
    ("preset", "metres"),
    [("vermv_1994", 0.07), ("vermv_2010", 0.04), ("vermv_2016", 0.04), (0.05, 0.05)],
)
def test_points_pass_by_the_propagated_figure(demo_block, preset, metres):
    points = densify(demo_block, Settings(tolerance=preset)).points
    figure = points["standard_error_total"]
    np.testing.assert_array_equal(points["standard_error_checked"], figure)
    expected = (figure <= metres) & ~points["is_suspect"]
    np.testing.assert_array_equal(points["is_within_tolerance"], expected)


def test_without_a_tolerance_nothing_is_judged(good_result):
    assert "is_within_tolerance" not in good_result.points
    assert "Tolerance" not in summarize(good_result)


@pytest.mark.slow
def test_the_summary_counts_and_names_the_figure(demo_block):
    limit = densify(demo_block).points["standard_error_total"].median()
    result = densify(demo_block, Settings(tolerance=float(limit)))
    new = result.points[result.points["role"] == "new"]
    n_pass = int(new["is_within_tolerance"].sum())
    assert 20 < n_pass < 60
    text = said(result)
    assert text in summarize(result).replace("\n    ", " ")
    row = next(line for line in text.splitlines() if "new points" in line).split()
    assert row[:4] == ["new", "points", str(n_pass), str(len(new) - n_pass)]
    assert "Figure used: the propagated one (standard_error_total)." in text


@pytest.mark.slow
def test_differences_at_control_are_counted_where_the_ordinance_asks(demo_block):
    result = densify(demo_block, Settings(tolerance="vermv_2016"))
    control = result.points[result.points["role"] == "control"]
    miss = np.hypot(control["difference_easting"], control["difference_northing"])
    counted = (
        f"At {(miss > 0.05).sum()} of {len(control)} control points the difference"
    )
    assert counted in said(result)
    assert "the difference" not in said(densify(demo_block, Settings(tolerance=0.04)))


@pytest.mark.slow
def test_nothing_passes_where_the_claim_does_not_stand(wrong_block):
    result = densify(wrong_block, Settings(tolerance=1.0))
    assert not result.claim.is_supported
    assert not result.points["is_within_tolerance"].any()
    assert result.points["standard_error_checked"].min() < 1.0
    text = said(result)
    assert "the stated precision is not supported" in text
    assert ", taken " in text


def test_suspects_do_not_pass():
    # one sound point in twenty is a suspect at this significance
    block = simulate_block("demo", seed=3)
    result = densify(block, Settings(tolerance=9.0, significance=0.05))
    suspects = result.points["is_suspect"]
    assert result.claim.is_supported
    assert 0 < suspects.sum() < 20
    np.testing.assert_array_equal(result.points["is_within_tolerance"], ~suspects)
    assert f"{suspects.sum()} suspect" in said(result)
    assert "not pass" in said(result)


def test_given_approximations_pass_by_the_budget_which_is_a_lower_bound(demo_block):
    block = onto_given_approximations(demo_block, photograph_error=0.0, seed=2)
    result = densify(block, Settings(tolerance=0.05))
    assert result.claim.is_supported
    np.testing.assert_array_equal(
        result.points["standard_error_checked"], result.points["standard_error_paper"]
    )
    assert "(standard_error_paper), a lower bound" in said(result)


def test_control_without_standard_errors_leaves_the_figure_untested(demo_block):
    control = demo_block.control_points.drop(columns="standard_error_m")
    block = replace(demo_block, control_points=control)
    text = said(densify(block, Settings(tolerance=0.05)))
    assert "The figure is not tested" in text


def test_the_adjustment_passes_by_its_own_figure(demo_block):
    settings = Settings(method="simultaneous", tolerance=0.03)
    result = densify(demo_block, settings)
    points, adjusted = result.points, result.simultaneous
    times = max(1.0, adjusted.s_0)
    expected = points["standard_error_total"] * times
    np.testing.assert_allclose(points["standard_error_checked"], expected)
    passes = (expected <= 0.03) & ~points["is_suspect"]
    np.testing.assert_array_equal(points["is_within_tolerance"], passes)
    assert "that of the simultaneous adjustment" in said(result)


@pytest.mark.slow
def test_the_adjustment_of_a_wrong_claim_is_enlarged_by_s_0(wrong_block):
    settings = Settings(method="simultaneous", tolerance=1.0)
    result = densify(wrong_block, settings)
    assert result.simultaneous.s_0 > 1.5
    ratio = (
        result.points["standard_error_checked"] / result.points["standard_error_total"]
    )
    np.testing.assert_allclose(ratio, result.simultaneous.s_0)
    assert ", taken " in said(result)


@pytest.mark.slow
def test_check_points_that_contradict_the_adjustment_let_nothing_pass(demo_block):
    control = demo_block.control_points.copy()
    control.loc[control["role"] == "check", "easting"] += 0.3
    block = replace(demo_block, control_points=control)
    settings = Settings(method="simultaneous", tolerance=1.0)
    result = densify(block, settings)
    assert not result.points["is_within_tolerance"].any()
    assert "is not supported" in said(result)


def test_unknown_figures_pass_nothing(demo_block):
    settings = Settings(
        method="simultaneous",
        tolerance=1.0,
        residual_distribution="natural_neighbour",
    )
    result = densify(demo_block, settings)
    assert not result.points["is_within_tolerance"].any()
    assert "No figure is known" in said(result)


@pytest.mark.parametrize(
    ("value", "match"),
    [
        (0, r"\[settings\] tolerance = 0; expected none, vermv_1994, .* 10\."),
        (-0.05, r"tolerance = -0\.05; expected"),
        (float("nan"), "tolerance = nan; expected"),
        (float("inf"), "tolerance = inf; expected"),
        (50, r"tolerance = 50; .* Did you give millimetres\?"),
        (10**400, "Did you give millimetres"),
        (True, "tolerance = true; expected"),
        (None, "tolerance = None; expected"),
        ([0.05], "tolerance = .*0.05.*; expected"),
        ("0,05", r"tolerance = '0,05'; .* Write 0\.05"),
        ("vermv_2017", "Write 'vermv_2016'"),
        ("VermV 1994", "Write 'vermv_1994'"),
        ("5 cm", "tolerance = '5 cm'; expected"),
        ("", "tolerance = ''; expected"),
    ],
)
def test_nonsense_is_refused(value, match):
    with pytest.raises(SettingsError, match=match):
        Settings(tolerance=value)


def test_metres_in_a_text_are_metres():
    assert Settings(tolerance="0.05") == Settings(tolerance=0.05)
