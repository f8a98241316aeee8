"""Gross errors of the low flight in a whole block."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.assessment.findings.suspects import (
    gross_measurements,
    suspect_observations,
)
from einschalt.pipeline.densification.gross_errors import no_gross_measurements
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import simulate_block

KEY = ["flight", "coverage", "model_id", "point_id"]


@pytest.fixture(scope="module")
def block():
    """Neukirchen with 1 % gross errors of 50 µm in the low flight."""
    noise = BlockNoise(low_gross_error_share=0.01, low_gross_error_um=50.0)
    return simulate_block("neukirchen", seed=4, noise=noise)


@pytest.fixture(scope="module")
def clean():
    """The same without gross errors."""
    return simulate_block("neukirchen", seed=4)


def rms(result, truth):
    columns = ["easting", "northing"]
    true = truth.set_index("point_id").loc[result.solution.points["point_id"], columns]
    off = result.solution.points[columns].to_numpy() - true.to_numpy()
    return np.sqrt(np.mean(np.sum(off**2, axis=1)))


def suspects(result):
    rows = result.residuals[result.residuals["is_suspect"]]
    return set(rows[KEY].itertuples(index=False, name=None))


def test_gross_errors_are_named_worst_first(block):
    result = densify(block)
    gross = set(block.gross_errors[KEY].itertuples(index=False, name=None))
    found = suspects(result)
    # models alone find three of four (six seeds); less two binomial errors of forty
    assert len(found & gross) >= 0.61 * len(gross)
    assert len(found - gross) <= 2
    named = suspect_observations(result.examination)
    rows = result.residuals.loc[result.residuals["is_suspect"]]
    worst = rows.loc[rows["p_value"].idxmin()]
    assert named.facts["observations"][0] == tuple(worst[KEY])
    assert named.facts["n_observations"] == len(rows)
    assert named.remedy == "measure_again_or_snoop"


@pytest.mark.slow
@pytest.mark.parametrize("outliers", ["snoop", "huber", "tukey"])
def test_screened_blocks_are_nearly_as_good_as_clean_ones(block, clean, outliers):
    screened = densify(block, Settings(outliers=outliers))
    assert rms(screened, block.truth) < 1.05 * rms(densify(clean), clean.truth)
    assert rms(densify(block), block.truth) > 1.04 * rms(screened, block.truth)
    named = gross_measurements(screened.examination)
    found = screened.gross_measurements
    assert named.facts["n_observations"] == len(found)
    worst = found.loc[found["p_value"].astype(float).idxmin()]
    assert named.facts["observations"][0] == tuple(worst[KEY])
    assert named.remedy == "measure_rejected_again"
    # what was named once is not named again
    again = suspect_observations(screened.examination)
    assert again is None or tuple(worst[KEY]) not in again.facts["observations"]


@pytest.mark.slow
def test_suspects_do_not_enter_the_mean(block):
    screened = densify(block, Settings(outliers="snoop"))
    plain = densify(block)
    n_less = (
        plain.solution.points["n_models"].sum()
        - screened.solution.points["n_models"].sum()
    )
    assert 0 < n_less <= len(suspects(screened))
    # but every point keeps a value, and every residual its row
    assert len(screened.solution.points) == len(plain.solution.points)
    assert len(screened.residuals) == len(plain.residuals)


@pytest.mark.slow
def test_propagation_knows_of_the_points_that_were_taken_out(block):
    screened = densify(block, Settings(outliers="snoop"))
    assert screened.figures.mean_total > densify(block).figures.mean_total
    assert len(screened.solution.low.observed.weights) < len(
        screened.solution.low.residuals
    )


@pytest.mark.slow
def test_clean_blocks_lose_nothing(clean):
    for outliers in ("keep", "snoop"):
        result = densify(clean, Settings(outliers=outliers))
        assert suspect_observations(result.examination) is None
        assert len(suspects(result)) <= 2  # 0.3 are expected, in 314 models


def test_without_redundancy_there_is_no_suspicion(good_result):
    residuals = good_result.residuals.assign(p_value=np.nan, is_suspect=False)
    gross = no_gross_measurements()
    result = {"residuals": residuals, "named_measurements": gross}
    assert suspect_observations(SimpleNamespace(**result)) is None


def test_significance_decides_who_is_suspect(clean):
    result = densify(clean, Settings(significance=0.5))
    assert len(suspects(result)) > 3
    # what the summary says does not depend on it
    assert suspect_observations(result.examination) is None
    with pytest.raises(
        SettingsError, match=r"\[settings\] significance = 0; expected a"
    ):
        Settings(significance=0)
    with pytest.raises(SettingsError, match="outliers = 'ransac'; expected 'keep'"):
        Settings(outliers="ransac")


def test_columns_are_in_both_flights(clean):
    residuals = densify(clean).residuals
    assert {"w", "p_value", "is_suspect"} <= set(residuals)
    assert residuals["is_suspect"].dtype == bool
    by_flight = residuals.groupby("flight")["p_value"].count()
    assert (by_flight > 0).all()
    assert pd.api.types.is_float_dtype(residuals["w"])
