"""Blocks of which two models of the high flight have three control points only.

The approximate coordinates of their points are extrapolated and off by decimetres,
together: nothing is wrong with any measurement.
"""

from functools import cache

import numpy as np
import pandas as pd
import pytest
from tests.judged_alone import judged_alone

import einschalt as es

SPACING, ORIGIN = 250.0, (450_000.0, 5_250_000.0)
HIGH, LOW = 12_000.0, 6_000.0
# what would send somebody to measure again, or to look for mistakes
OF_GROSS_ERRORS = {
    "kept_gross_measurements",
    "suspect_observations",
    "coverages_that_differ",
    "points_that_differ",
    "models_with_large_m_0",
    "wrong_measuring_errors",
}


def measured(rng, ground, centres, scale_number, m_g_um, reach):
    """Model points [mm] of models over their centres, turned by a few degrees."""
    parts = []
    for model, centre in enumerate(centres, start=1):
        apart = ground[["easting", "northing"]].to_numpy() - ORIGIN - centre
        is_in = (np.abs(apart) < reach).all(axis=1)
        turn = rng.normal(0.3, 0.02)
        turned = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        xy = apart[is_in] @ turned * 1000.0 / scale_number
        xy += rng.normal(0.0, m_g_um / 1000.0 / np.sqrt(2.0), xy.shape)
        part = pd.DataFrame(100.0 + xy, columns=["x", "y"])
        part["point_id"] = ground["point_id"].to_numpy()[is_in]
        parts.append(part.assign(model_id=str(model)))
    return pd.concat([part for part in parts if len(part) > 3], ignore_index=True)


def centres(first, last, step):
    """Centres of models in rows, with the strips one after the other."""
    east, north = (np.arange(*limits) for limits in zip(first, last, step, strict=True))
    return np.array([(e, n) for n in north for e in east])


@cache
def weak_block(seed):
    rng = np.random.default_rng(seed)
    grid = np.mgrid[0:13, 0:11].reshape(2, -1).T * SPACING
    plane = grid + ORIGIN + rng.uniform(-30.0, 30.0, grid.shape)
    ground = pd.DataFrame(plane, columns=["easting", "northing"])
    ground["point_id"] = [f"P{k + 1}" for k in range(len(ground))]
    of_high = centres((400, 900), (3551, 3600), (1100, 1900))
    high = measured(rng, ground, of_high, HIGH, 7.0, (660.0, 1100.0))
    flown = []
    for coverage, first in (("I", (200, 450)), ("II", (450, 10))):
        of_low = centres(first, (3276, 3051), (550, 960))
        part = measured(rng, ground, of_low, LOW, 5.0, (330.0, 550.0))
        flown.append(part.assign(coverage=coverage))
    control = ground.iloc[::5].copy()
    control[["easting", "northing"]] += rng.normal(0.0, 0.02, (len(control), 2))
    is_check = np.arange(len(control)) % 7 == 3
    control["role"] = np.where(is_check, "check", "control")
    control["standard_error_m"] = 0.03
    return control, high, pd.concat(flown, ignore_index=True)


def densified(control, high, low, **settings):
    flights = {
        "high_flight": es.Flight(high, scale_number=HIGH, m_g_um=7.0),
        "low_flight": es.Flight(low, scale_number=LOW, m_g_um=5.0),
    }
    block = es.Block(control_points=control, crs="EPSG:25833", **flights)
    return es.densify(block, es.Settings(**settings))


def told(result):
    return {found.code for found in result.assessment.findings}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_what_is_weak_is_no_gross_error(seed):
    result = densified(*weak_block(seed))
    models = result.models[result.models["flight"] == "high_flight"]
    assert (models["redundancy"] == 0).sum() == 2
    # it is there: points of weak models lie far apart, and are said to be imprecise
    spread = result.points["spread_total"]
    assert spread.max() > 20.0 * spread.median()
    assert told(result) & OF_GROSS_ERRORS == set()
    assert "imprecise_points" in told(result)


@pytest.mark.slow
@pytest.mark.parametrize("iterations", [2, 3])
def test_nor_is_it_in_further_passes(iterations):
    for seed in (1, 2, 5):
        result = densified(*weak_block(seed), iterations=iterations)
        assert result.solution.iteration.n_held > 0
        assert not result.residuals["is_suspect"].any()
        assert told(result) & OF_GROSS_ERRORS == set()


def test_a_gross_error_is_named_after_a_further_pass():
    control, high, low = weak_block(2)
    seen = low.groupby("point_id")["x"].transform("size")
    is_new = ~low["point_id"].isin(control["point_id"])
    wrong = low.index[(seen > 2) & is_new][40]
    moved = low["x"] + 0.15 * (low.index == wrong)
    result = densified(control, high, low.assign(x=moved), iterations=2)
    suspects = result.residuals[result.residuals["is_suspect"]]
    assert low.loc[wrong, "point_id"] in suspects["point_id"].tolist()
    assert "suspect_observations" in judged_alone(result)


def test_the_estimated_m_g_is_that_of_the_good_points():
    for seed in (2, 3):
        components = densified(*weak_block(seed)).components
        for flight, m_g_um in (("high_flight", 7.0), ("low_flight", 5.0)):
            component = getattr(components, flight)
            assert component.standard_error < 1.5
            apart = abs(component.estimated - m_g_um)
            assert apart < 3.5 * component.standard_error


def test_a_gross_error_beside_weak_models_is_named():
    control, high, low = weak_block(2)
    size = low.groupby(["coverage", "model_id"])["x"].transform("size")
    is_new = ~low["point_id"].isin(control["point_id"])
    wrong = low.index[(size > 9) & is_new][5]
    moved = low["x"] + 0.2 * (low.index == wrong)
    result = densified(control, high, low.assign(x=moved))
    assert "suspect_observations" in judged_alone(result)
    suspects = result.residuals[result.residuals["is_suspect"]]
    assert suspects["point_id"].tolist() == [low.loc[wrong, "point_id"]]


@pytest.mark.slow
def test_a_gross_error_that_only_its_flight_contradicts_is_told():
    control, high, low = weak_block(2)
    seen = low.groupby("point_id")["x"].transform("size")
    is_new = ~low["point_id"].isin(control["point_id"])
    wrong = low.index[(seen > 2) & is_new][40]
    moved = low["x"] + 0.05 * (low.index == wrong)
    result = densified(control, high, low.assign(x=moved))
    assert told(result) & OF_GROSS_ERRORS >= {"kept_gross_measurements"}
    (found,) = (
        each
        for each in result.assessment.findings
        if each.code == "kept_gross_measurements"
    )
    assert found.names == (low.loc[wrong, "point_id"],)
    assert found.facts["explains"] == ()
