"""Points that were set several times: m_g from their settings."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.pipeline.block.repeated_settings import (
    KEY,
    M_G_UM,
    rows_of_settings,
    set_again,
    with_low_flight,
)

import einschalt as es
from einschalt.interfaces.reports.html_report import render
from einschalt.pipeline.assessment.findings.suspects import (
    scattered_points,
    settings_that_scatter,
)
from einschalt.pipeline.summary.summary import sections


@pytest.fixture(scope="module")
def result():
    return es.densify(set_again())


CASES = [
    ("affine", 1.0, "two_step"),
    ("helmert", 2.5, "two_step"),
    ("affine", 2.5, "simultaneous"),
]
N_BLOCKS = 6


@pytest.fixture(scope="module")
def rows():
    """What the settings of six blocks show in each case; no two have the same noise."""
    return {
        case: [_shown(N_BLOCKS * place + k, *case) for k in range(N_BLOCKS)]
        for place, case in enumerate(CASES)
    }


def _shown(seed, kind, scale, method):
    block = set_again(seed, scale=scale, transformation=kind)
    found = es.densify(block, es.Settings(method=method)).repeated_settings
    assert found["flight"].tolist() == ["low_flight"]
    return found.iloc[0]


def z_of(row):
    return (row["m_g_settings_um"] - M_G_UM) / row["standard_error_um"]


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=str)
def test_settings_give_back_the_m_g_that_made_them(rows, case):
    for row in rows[case]:
        assert row["redundancy"] == 2 * row["n_points"]
        assert not row["is_larger"]
        assert row["p_value"] > 0.001
    # 6 blocks: mean within 3.3 / √6
    assert abs(np.mean([z_of(row) for row in rows[case]])) < 1.35


def test_p_values_are_even_where_the_given_m_g_is_right(rows):
    every = [row for case in CASES for row in rows[case]]
    z, p = [z_of(row) for row in every], [row["p_value"] for row in every]
    # 18 blocks: mean within 3.3 / √18, standard deviation within 3 / √36
    assert abs(np.mean(z)) < 0.78
    assert 0.5 < np.std(z) < 1.5
    # uniform: mean 1/2 within 3.3 / √(12 · 18)
    assert np.mean(p) == pytest.approx(0.5, abs=0.225)


@pytest.mark.slow
def test_summary_and_report_say_both_figures(result):
    text = result.summary()
    assert "Repeated settings (m_g of one setting, total)" in text
    assert "no contradiction" in text
    assert "5.0 µm" in sections(result.assessment)["repeated_settings"].text()
    assert "Repeated settings" in render(result)
    assert settings_that_scatter(result.examination) is None
    assert scattered_points(result.examination) is None


@pytest.mark.slow
def test_a_larger_scatter_is_called_out_and_a_smaller_is_not():
    larger = es.densify(set_again(m_g_um=M_G_UM / 1.5))
    assert larger.repeated_settings["is_larger"].all()
    found = settings_that_scatter(larger.examination)
    assert found.names == ("low_flight",)
    assert found.expected == pytest.approx(M_G_UM / 1.5 * 1e-6)
    assert found.observed == pytest.approx(M_G_UM * 1e-6, abs=0.15e-6)
    assert found.probability < 0.001
    assert found.remedy == "give_at_least_that_m_g"
    # all are too wide: single ones are not named
    assert scattered_points(larger.examination) is None
    assert "larger" in sections(larger.assessment)["repeated_settings"].text()
    smaller = es.densify(set_again(m_g_um=M_G_UM * 1.5))
    assert smaller.repeated_settings["p_value"].iloc[0] > 0.99
    assert settings_that_scatter(smaller.examination) is None
    # √(7.5² − 5² (1 − 1/3)) instead of 7.5 / √3
    said = " ".join(sections(smaller.assessment)["repeated_settings"].text().split())
    assert smaller.repeated_settings["is_smaller"].all()
    assert "a mean of 3 settings has 6.3 µm, not 4.3 µm; m_g_um = 11 corr" in said


def test_one_wrong_setting_is_named():
    rows = rows_of_settings()
    rows.loc[4, "x"] += 0.05
    low = replace(set_again().low_flight, model_points=rows)
    block = with_low_flight(set_again(), low)
    result = es.densify(block)
    assert settings_that_scatter(result.examination) is None
    found = scattered_points(result.examination)
    assert found.facts["n_points"] == 1
    assert found.facts["observations"] == (("low_flight", *rows.loc[4, KEY]),)
    assert found.remedy == "set_again"


@pytest.mark.slow
def test_means_with_their_spread_say_the_same(result, tmp_path):
    result.block.write(tmp_path / "block")
    again = es.densify(es.read_block(tmp_path / "block"))
    pd.testing.assert_frame_equal(
        again.repeated_settings, result.repeated_settings, rtol=1e-6
    )
    result.write(tmp_path / "out")
    written = pd.read_csv(tmp_path / "out" / "repeated_settings.csv")
    assert written["n_points"].tolist() == result.repeated_settings["n_points"].tolist()


def test_blocks_without_repeats_have_no_section(good_result):
    assert good_result.repeated_settings.empty
    assert not sections(good_result.assessment)["repeated_settings"].rows
    assert settings_that_scatter(good_result.examination) is None
    assert scattered_points(good_result.examination) is None
