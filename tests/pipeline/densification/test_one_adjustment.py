"""What one adjustment takes out is listed; control that it sets aside is marked."""

from dataclasses import replace

import numpy as np
import pytest
from tests.judged_alone import judged_alone

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

FIVE = 5  # rows from the end: a new point in the middle of a model


@pytest.fixture(scope="module")
def spoilt(demo_block):
    """One control point 50 cm off, and one measurement of the low flight 1.6 m."""
    control = demo_block.control_points.copy()
    row = control.index[control["role"] == "control"][3]
    control.loc[row, "easting"] += 0.5
    low = demo_block.low_flight
    points = low.model_points.reset_index(drop=True).copy()
    new = points.index[~points["point_id"].isin(control["point_id"])][FIVE]
    points.loc[new, "x"] += 0.2
    block = replace(
        demo_block,
        control_points=control,
        low_flight=replace(low, model_points=points),
    )
    return block, control.loc[row, "point_id"], points.loc[new]


def result_of(block, outliers):
    return densify(block, Settings(method="simultaneous", outliers=outliers))


@pytest.mark.slow
def test_snooping_lists_what_it_took_out(spoilt):
    block, control, row = spoilt
    result = result_of(block, "snoop")
    out = result.gross_measurements
    assert out["point_id"].tolist() == [row["point_id"]]
    assert out["model_id"].tolist() == [row["model_id"]]
    # told once, with the residuals
    codes = [found.code for found in result.assessment.findings]
    assert codes.count("suspect_observations") == 1
    assert "gross_measurements" not in codes
    points = result.points
    assert points.loc[points["is_set_aside"], "point_id"].tolist() == [control]


def test_what_is_kept_is_neither_listed_nor_marked(spoilt):
    result = result_of(spoilt[0], "keep")
    assert result.gross_measurements.empty
    assert "is_set_aside" not in result.points


@pytest.mark.slow
def test_less_weight_is_not_taken_out(spoilt):
    block, control, _ = spoilt
    result = result_of(block, "huber")
    assert result.gross_measurements.empty
    points = result.points
    assert points.loc[points["is_set_aside"], "point_id"].tolist() == [control]


@pytest.fixture(scope="module")
def names_mixed_up():
    """A block in space with the names of a model mixed up, and without that model."""
    geometry = replace(PRESETS["demo"].geometry, transformation="helmert_3d")
    block = simulate_block("demo", seed=4, geometry=geometry)
    low, keys = block.low_flight, ["coverage", "model_id"]
    points = low.model_points.reset_index(drop=True)
    is_it = (points[keys] == points[keys].iloc[0]).all(axis=1).to_numpy()
    names = points["point_id"].to_numpy(dtype=object, copy=True)
    names[is_it] = np.roll(names[is_it], 3)
    mixed = points.assign(point_id=names)
    without = points[~is_it].reset_index(drop=True)
    return [
        replace(block, low_flight=replace(low, model_points=rows))
        for rows in (mixed, without)
    ]


@pytest.mark.slow
@pytest.mark.parametrize("outliers", ["snoop", "huber", "tukey"])
def test_a_model_that_was_given_up_counts_for_nothing(names_mixed_up, outliers):
    """What is told is what would be told without its measurements."""
    mixed, without = (result_of(block, outliers) for block in names_mixed_up)
    assert len(mixed.failures) == 1
    assert mixed.examination.credible == without.examination.credible
    told, expected = (set(judged_alone(result)) for result in (mixed, without))
    assert told - expected == {"failed_models"}
    beside = ["two_step_easting", "two_step_northing"]
    np.testing.assert_allclose(mixed.points[beside], without.points[beside], atol=1e-6)
    both = mixed.solution.two_step, mixed.solution.all_in_two_steps
    held, whole = (len(each.model_points["low_flight"]) for each in both)
    assert held == len(names_mixed_up[1].low_flight.model_points) < whole


def test_with_no_model_given_up_both_are_the_same(demo_block):
    solution = result_of(demo_block, "snoop").solution
    assert solution.two_step is solution.all_in_two_steps


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_a_model_of_two_points_that_is_given_up_is_judged_beside(demo_block, method):
    """The two steps of the others look for patterns in what they hold, and no more."""
    flight = demo_block.low_flight
    points, keys = flight.model_points, ["coverage", "model_id"]
    is_first = (points[keys] == points.loc[0, keys]).all(axis=1)
    few = points[~is_first | (points.index < 2)].reset_index(drop=True)
    block = replace(demo_block, low_flight=replace(flight, model_points=few))
    result = densify(block, Settings(method=method))
    assert len(result.failures) == 1
    beside = result.assessment  # ended in an IndexError
    assert np.isfinite(beside.credible.value)
    assert not beside.credible.is_lower_bound
