"""Heights of control that are wrong together, as one adjustment shows them."""

from dataclasses import replace

import numpy as np
import pytest

import einschalt as es
from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.pipeline.assessment.evidence.fits.adjusted_heights import (
    pattern_of_adjusted_heights,
)
from einschalt.pipeline.assessment.examination import examine
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

AXES = ["easting", "northing", "height"]
STEP = 0.3  # six standard errors of a height


def spatial_block(seed, measurement="machine"):
    geometry = replace(
        PRESETS["demo"].geometry,
        transformation="helmert_3d",
        measurement=measurement,
    )
    return simulate_block("demo", seed=seed, geometry=geometry)


def with_heights(block, change):
    control = block.control_points
    heights = control["height"] + change(control)
    return replace(block, control_points=control.assign(height=heights))


def east_up(control):
    return STEP * (control["easting"] > control["easting"].median())


def adjusted(block, method="simultaneous"):
    return es.densify(block, block.settings.updated({"method": method}))


def true_error(result, block):
    new = result.points[result.points["role"] == "new"]
    true = block.truth.set_index("point_id").loc[new["point_id"], "height"]
    return float(np.sqrt(np.mean((new["height"].to_numpy() - true.to_numpy()) ** 2)))


def told(result, code):
    return [found for found in result.assessment.findings if found.code == code]


@pytest.mark.parametrize("method", ["two_step", "simultaneous", "auto"])
def test_a_step_that_left_out_control_does_not_show_is_told(method):
    block = with_heights(spatial_block(5), east_up)
    result = adjusted(block, method)
    (found,) = told(result, "broken_heights")
    control = block.control_points
    used = control[control["role"] != "check"]
    up = set(used.loc[used["easting"] > control["easting"].median(), "point_id"])
    lower = set(used["point_id"]) - up
    # points at the border of both parts may be counted to either
    part = min((up, lower), key=lambda side: len(side ^ set(found.names)))
    assert len(part ^ set(found.names)) <= 2
    assert found.facts["size"] == pytest.approx(STEP, abs=0.1)
    believed = result.assessment.credible_heights
    assert believed.is_lower_bound
    assert believed.value > 0.6 * true_error(result, block)


def test_good_heights_show_nothing():
    examined = examine(adjusted(spatial_block(5)).solution)
    assert pattern_of_adjusted_heights(examined) == (None, 0.0, 1.0)
    assert examined.control_patterns.height is None


def test_one_wrong_height_is_no_step():
    def one_up(control):
        place = control.index[control["role"] == "control"][3]
        return STEP * 2.0 * (control.index == place)

    block = with_heights(spatial_block(5), one_up)
    found, _, p_value = pattern_of_adjusted_heights(examine(adjusted(block).solution))
    control = block.control_points
    wrong = control.loc[control["role"] == "control", "point_id"].iloc[3]
    assert (found.kind, found.point_ids) == (Kind.POINT, (wrong,))
    assert p_value < 1e-6


def test_what_larger_errors_explain_as_well_is_told_with_that():
    """Heights that are three times worse than stated, each by itself."""

    def scattered(control):
        return np.random.default_rng(2).normal(0.0, 0.15, len(control))

    result = adjusted(with_heights(spatial_block(3), scattered))
    (found,) = told(result, "broken_heights")
    assert not found.facts["is_told_apart"]
    assert "larger errors of all heights would explain" in " ".join(
        result.summary().split()
    )


def test_points_at_the_edge_of_a_part_follow_from_it():
    block = with_heights(
        spatial_block(4), lambda control: east_up(control) * 0.5 / STEP
    )
    result = adjusted(block)
    (cause,) = told(result, "broken_heights")
    (edge,) = told(result, "control_against_block")
    assert edge.explained_by == "broken_heights"
    assert "control_against_block" in cause.facts["explains"]
    assert result.assessment.causes[0] == "broken_heights"
    headline = " ".join(result.summary().split("\n\n")[0].split())
    assert "compare the heights of control first" in headline


def beside_gnss(block, seed):
    """The same without a high flight, beside points of 5 cm."""
    rng = np.random.default_rng(seed)
    points = block.truth[["point_id", *AXES]].copy()
    points[AXES] += rng.normal(0.0, 0.05, (len(points), 3))
    return replace(
        block, high_flight=None, approximate_points=points, approximate_m_0_m=0.07
    )


def test_a_part_is_told_beside_the_one_point_of_it_that_stands_out():
    """Snooping names one at the edge; the others lean on it less than they say."""
    block = beside_gnss(spatial_block(9), 9)
    result = adjusted(with_heights(block, east_up))
    assert told(result, "control_against_block")
    (found,) = told(result, "broken_heights")
    assert found.facts["kind"] == "step"
    believed, true = result.assessment.credible_heights, true_error(result, block)
    assert believed.is_lower_bound
    assert 0.8 * true < believed.value < 1.5 * true


@pytest.mark.slow
@pytest.mark.parametrize("measurement", ["machine", "images"])
def test_steps_of_many_blocks_are_told(measurement):
    """Half of the control 50 cm up; the larger part of what that does is told."""
    n_told, ratios = 0, []
    for seed in range(2, 8):
        block = spatial_block(seed, measurement)
        up = with_heights(block, lambda control: east_up(control) * 0.5 / STEP)
        result = adjusted(up)
        n_told += len(told(result, "broken_heights"))
        figure = result.assessment.credible_heights.value
        ratios.append(figure / true_error(result, block))
    assert n_told >= 5
    assert np.median(ratios) > 0.75


@pytest.mark.slow
@pytest.mark.parametrize("measurement", ["machine", "images"])
def test_clean_blocks_have_no_pattern(measurement):
    """One in a hundred may: of twelve hardly more than one."""
    found = [
        pattern_of_adjusted_heights(
            examine(adjusted(spatial_block(seed, measurement)).solution)
        )[1]
        > 0.0
        for seed in range(30, 42)
    ]
    assert sum(found) <= 1
