"""Points that were set several times: their means, and m_g from their settings."""

import re
from dataclasses import fields, replace

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.reports.html_report import render
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.pipeline.summary.sections import repeated_settings
from einschalt.pipeline.summary.suggestions.suspects import settings_that_scatter

M_G_UM = 5.0
KEY = ["coverage", "model_id", "point_id"]


def true_block(seed):
    """A demo block whose low flight was measured without errors."""
    noise = replace(PRESETS["demo"].noise, low_m_g_um=0.0)
    return simulate_block("demo", seed=seed, noise=noise)


def rows_of_settings(seed=0, *, n_settings=3, scale=1.0):
    """Model points set several times with known errors, a row for each setting."""
    true = true_block(seed).low_flight.model_points
    rows = true.loc[true.index.repeat(n_settings)].reset_index(drop=True)
    sigma_mm = M_G_UM * 1e-3 / np.sqrt(2.0)
    error = np.random.default_rng(seed).normal(0.0, sigma_mm, (len(rows), 2))
    rows[["x", "y"]] = scale * (rows[["x", "y"]] + error)
    number = np.tile(np.arange(1, n_settings + 1), len(true))
    return rows.assign(setting=number.astype(str))


def set_again(seed=0, *, m_g_um=M_G_UM, scale=1.0, **facts):
    """A block of them; ``facts`` are those of the flight."""
    block, rows = true_block(seed), rows_of_settings(seed, scale=scale)
    facts = {"model_points": rows, "m_g_um": m_g_um, **facts}
    return with_low_flight(block, replace(block.low_flight, **facts))


def with_low_flight(block, low):
    plain = {f.name: getattr(block, f.name) for f in fields(es.Block)}
    return es.Block(**{**plain, "low_flight": low})


@pytest.fixture(scope="module")
def result():
    return es.densify(set_again())


def test_settings_are_averaged_as_if_their_means_had_been_given(result):
    measured = set_again().low_flight.model_points
    raw = rows_of_settings()
    means = raw.groupby(KEY, sort=False)[["x", "y"]].mean()
    given = measured.set_index(KEY)
    np.testing.assert_allclose(given[["x", "y"]], means.loc[given.index], rtol=1e-13)
    assert (given["n_settings"] == 3.0).all()
    plain = given[["x", "y"]].assign(n_settings=3).reset_index()
    low = replace(result.block.low_flight, model_points=plain)
    other = es.densify(with_low_flight(result.block, low))
    pd.testing.assert_frame_equal(result.points, other.points)
    assert other.repeated_settings.empty
    # the errors of the measurements are those of the means
    sigma = result.errors.standard_errors["low_flight"]
    expected = M_G_UM / np.sqrt(3.0) * 1e-6 * 8000 / np.sqrt(2.0)
    np.testing.assert_allclose(sigma, expected)


@pytest.mark.parametrize(
    ("kind", "scale", "method"),
    [
        ("affine", 1.0, "two_step"),
        ("helmert", 2.5, "two_step"),
        ("affine", 2.5, "simultaneous"),
    ],
)
def test_settings_give_back_the_m_g_that_made_them(kind, scale, method):
    z = []
    for seed in range(8):
        block = set_again(seed, scale=scale, transformation=kind)
        found = es.densify(block, es.Settings(method=method)).repeated_settings
        assert found["flight"].tolist() == ["low_flight"]
        row = found.iloc[0]
        assert row["redundancy"] == 2 * row["n_points"]
        z.append((row["m_g_settings_um"] - M_G_UM) / row["standard_error_um"])
        assert not row["is_larger"]
        assert row["p_value"] > 0.001
    # 8 blocks: mean within 3.3 / √8, standard deviation within 3 / √16
    assert abs(np.mean(z)) < 1.17
    assert 0.25 < np.std(z) < 1.75


def test_p_values_are_even_where_the_given_m_g_is_right():
    p = [
        es.densify(set_again(seed)).repeated_settings["p_value"].iloc[0]
        for seed in range(20, 32)
    ]
    # uniform: mean 1/2 within 3.3 / √(12 · 12)
    assert np.mean(p) == pytest.approx(0.5, abs=0.275)


def test_summary_and_report_say_both_figures(result):
    text = result.summary()
    assert "Repeated settings (m_g of one setting, total)" in text
    assert "no contradiction" in text
    assert "5.0 µm" in repeated_settings.section(result).text()
    assert "Repeated settings" in render(result)
    assert settings_that_scatter(result) is None


def test_a_larger_scatter_is_called_out_and_a_smaller_is_not():
    larger = es.densify(set_again(m_g_um=M_G_UM / 1.5))
    assert larger.repeated_settings["is_larger"].all()
    said = settings_that_scatter(larger)
    assert said.problem.startswith("m_g_um of the low flight is given as 3.3, but")
    assert re.search(r"repeated settings scatter by (4\.9|5\.0)", said.problem)
    assert said.remedy.startswith("Give at least that figure")
    assert "larger" in repeated_settings.section(larger).text()
    smaller = es.densify(set_again(m_g_um=M_G_UM * 1.5))
    assert smaller.repeated_settings["p_value"].iloc[0] > 0.99
    assert settings_that_scatter(smaller) is None
    # √(7.5² − 5² (1 − 1/3)) instead of 7.5 / √3
    said = " ".join(repeated_settings.section(smaller).text().split())
    assert smaller.repeated_settings["is_smaller"].all()
    assert "a mean of 3 settings has 6.3 µm and not 4.3; m_g_um = 11 makes" in said


def test_one_wrong_setting_is_named():
    rows = rows_of_settings()
    rows.loc[4, "x"] += 0.05
    low = replace(set_again().low_flight, model_points=rows)
    block = with_low_flight(set_again(), low)
    said = settings_that_scatter(es.densify(block))
    assert said.problem.startswith("1 point with settings up to ")
    coverage, model, point = rows.loc[4, KEY]
    assert f"low {coverage} {model} {point}" in said.problem
    assert said.remedy == "Set them again: their mean is wrong"


def test_means_with_their_spread_say_the_same(result, tmp_path):
    result.block.write(tmp_path / "block")
    again = es.densify(es.read_block(tmp_path / "block"))
    pd.testing.assert_frame_equal(
        again.repeated_settings, result.repeated_settings, rtol=1e-6
    )
    result.write(tmp_path / "out")
    written = pd.read_csv(tmp_path / "out" / "repeated_settings.csv")
    assert written["n_points"].tolist() == result.repeated_settings["n_points"].tolist()


def test_rows_of_settings_are_read_from_files(tmp_path):
    block = set_again()
    block.write(tmp_path)
    rows_of_settings().to_csv(tmp_path / "low_flight.csv", index=False)
    again = es.read_block(tmp_path)
    np.testing.assert_allclose(
        again.low_flight.model_points[["x", "y"]],
        block.low_flight.model_points[["x", "y"]],
    )


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"setting": "1"}, "row 1, .*repeats row 0; expected .* \\+ setting once"),
        ({"n_settings": 2}, "column 'n_settings' stands beside 'setting'"),
        ({"settings_spread": 0.1}, "'settings_spread' stands beside 'setting'"),
        ({"setting": ""}, "setting is missing; expected a name"),
    ],
)
def test_settings_that_contradict_are_refused(change, match):
    low = replace(
        set_again().low_flight, model_points=rows_of_settings().head(3).assign(**change)
    )
    with pytest.raises(EinschaltError, match=match):
        with_low_flight(set_again(), low)


def test_repeated_rows_without_a_number_are_refused_with_the_way_out():
    low = set_again().low_flight
    rows = rows_of_settings().drop(columns="setting").head(2)
    with pytest.raises(EinschaltError, match="number repeated settings in a column"):
        with_low_flight(set_again(), replace(low, model_points=rows))


def test_a_spread_below_zero_is_refused():
    low = set_again().low_flight
    wrong = low.model_points.assign(settings_spread=-0.1)
    with pytest.raises(EinschaltError, match=r"settings_spread '-0\.1' is negative"):
        with_low_flight(set_again(), replace(low, model_points=wrong))


def test_blocks_without_repeats_have_no_section(good_result):
    assert good_result.repeated_settings.empty
    assert not repeated_settings.section(good_result).rows
    assert settings_that_scatter(good_result) is None
