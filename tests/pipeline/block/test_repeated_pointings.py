"""Points that were set several times: the means of their settings."""

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
from einschalt.foundations.errors import EinschaltError


@pytest.fixture(scope="module")
def result():
    return es.densify(set_again())


@pytest.mark.slow
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
