"""Errors of approximate points are no matter of an adjustment that leaves them out."""

from dataclasses import replace

import numpy as np
import pytest

import einschalt as es
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

RATIO = 0.015  # that heights of approximate points are too large by


@pytest.fixture(scope="module")
def block():
    """One flight of spatial models, approximate points, and control that is right."""
    geometry = replace(
        PRESETS["demo"].geometry, n_check=0, relief=60.0, transformation="helmert_3d"
    )
    flown = simulate_block("demo", seed=4, geometry=geometry)
    points = flown.truth.copy()
    error = np.random.default_rng(4).normal(0.0, 0.05, (len(points), 3))
    points[["easting", "northing", "height"]] += error
    points["height"] += RATIO * (points["height"] - points["height"].mean())
    return es.Block(
        control_points=flown.control_points,
        approximate_points=points,
        low_flight=flown.low_flight,
        approximate_m_0_m=0.07,
    ), flown.truth


def kinds(result):
    return {finding.code for finding in result.assessment.findings}


def test_two_steps_go_onto_heights_out_of_scale(block):
    found = es.densify(block[0])
    assert "heights_out_of_scale" in kinds(found)


def test_an_adjustment_goes_onto_control(block):
    given, truth = block
    found = es.densify(given, es.Settings(method="simultaneous"))
    assert not kinds(found) & {"heights_out_of_scale", "broken_heights"}
    new = found.points[found.points["role"] == "new"].set_index("point_id")
    away = new["height"] - truth.set_index("point_id").loc[new.index, "height"]
    true = np.sqrt(np.mean(away**2))
    told = found.assessment.credible_heights
    assert not told.is_lower_bound
    assert 0.8 < told.value / true < 1.25
