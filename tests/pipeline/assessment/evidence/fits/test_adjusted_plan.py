"""Control that is wrong together in plan, in blocks without a high flight."""

from dataclasses import replace

import numpy as np
import pytest
from tests.given_approximations import beside_control
from tests.photographs_onto_control import one_flight, with_wrong_control

from einschalt.pipeline.assessment.evidence.fits.adjusted_plan import (
    pattern_of_adjusted_plan,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

PLAN = ["easting", "northing"]
NETWORK = {"broken_network", "contradicting_control"}
NOTHING = (None, 0.0, 1.0)


def adjusted(block, method="simultaneous", **settings):
    return densify(block, block.settings.updated({"method": method, **settings}))


def east_off(block, shift, names):
    """The eastern half of the control shifted in some tables [m]."""
    control = block.control_points
    control = control[control["role"] != "check"]
    is_east = control["easting"] > control["easting"].median()
    inside = control.loc[is_east, "point_id"]

    def moved(points):
        is_off = points["point_id"].isin(inside).to_numpy()
        return points.assign(northing=points["northing"] + shift * is_off)

    tables = {name: moved(getattr(block, name)) for name in names}
    return replace(block, **tables), set(inside)


def true_error(result, block):
    new = result.points[result.points["role"] == "new"]
    truth = block.truth.set_index("point_id").loc[new["point_id"], PLAN]
    miss = new[PLAN].to_numpy() - truth.to_numpy()
    return float(np.sqrt(np.mean(np.sum(miss**2, axis=1))))


def told(result):
    return NETWORK & {found.code for found in result.assessment.findings}


def assert_covered(result, block):
    believed, true = result.assessment.credible, true_error(result, block)
    assert believed.is_lower_bound
    assert 0.67 < believed.value / true < 1.5
    assert not result.assessment.claim_is_supported


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous", "auto"])
def test_half_of_the_control_under_photographs_is_told(method):
    """12.7 cm were told as 5.5 cm that nothing contradicts, or as 5.6 cm or worse."""
    block, inside = east_off(
        one_flight(1, n_given=16), 0.3, ("control_points", "approximate_points")
    )
    result = adjusted(block, method)
    (code,) = told(result)
    assert_covered(result, block)
    if code == "broken_network":
        (found,) = (f for f in result.assessment.findings if f.code == code)
        part = min((inside, set(found.names)), key=len)
        assert len(part) >= 2
    assert result.summary()


@pytest.mark.slow
def test_one_wrong_point_under_photographs_breaks_no_network():
    block = with_wrong_control(one_flight(2, n_given=16), 3, 0.5)
    result = adjusted(block)
    assert "broken_network" not in told(result)
    assert result.assessment.credible.is_lower_bound


@pytest.mark.parametrize("transformation", ["affine", "helmert"])
def test_control_beside_given_approximations_is_tested(transformation):
    """Half of it 20 cm off was taken up by the models in silence."""
    geometry = replace(
        PRESETS["demo"].geometry, transformation=transformation, n_check=0
    )
    good = beside_control(simulate_block("demo", seed=4, geometry=geometry))
    block, _ = east_off(good, 0.2, ("control_points",))
    result = adjusted(block)
    assert told(result)
    assert_covered(result, block)
    assert not told(adjusted(good))


def plane_block(seed):
    geometry = replace(PRESETS["demo"].geometry, transformation="helmert", n_check=0)
    return beside_control(simulate_block("demo", seed=seed, geometry=geometry))


def test_a_part_that_is_set_aside_may_be_the_right_one():
    """Each point by itself was set aside, and the rest taken for good."""
    block, _ = east_off(plane_block(5), 0.5, ("control_points",))
    result = adjusted(block, outliers="snoop")
    assert result.examination.adjustment.control["is_set_aside"].any()
    assert told(result) == {"broken_network"}
    assert result.assessment.credible.is_lower_bound
    assert result.assessment.credible.value > 0.67 * true_error(result, block)


def test_one_point_that_is_set_aside_is_no_part():
    block = plane_block(6)
    control = block.control_points.copy()
    control.loc[2, "easting"] += 0.5
    result = adjusted(replace(block, control_points=control), outliers="snoop")
    assert result.examination.adjustment.control["is_set_aside"].sum() == 1
    assert not told(result)
    assert not result.assessment.credible.is_lower_bound


@pytest.mark.parametrize("seed", [0, 1])
def test_good_control_shows_nothing(seed):
    block = one_flight(seed, n_given=16)
    examined = adjusted(block).examination
    assert pattern_of_adjusted_plan(examined) == NOTHING
    assert examined.control_patterns.plan is None


def test_without_errors_of_control_nothing_is_tested():
    block = one_flight(1, n_given=16)
    control = block.control_points.drop(columns="standard_error_m")
    block = replace(block, control_points=control)
    assert pattern_of_adjusted_plan(adjusted(block).examination) == NOTHING


def test_a_part_that_is_off_in_plan_is_no_step_of_metres_in_height():
    """Models on three or four points tilt by it: 17 cm were told as 2.9 m."""
    block, _ = east_off(
        one_flight(3, n_given=16), 0.5, ("control_points", "approximate_points")
    )
    result = adjusted(block, "two_step")
    new = result.points[result.points["role"] == "new"]
    truth = block.truth.set_index("point_id").loc[new["point_id"], "height"]
    true = np.sqrt(np.nanmean((new["height"].to_numpy() - truth.to_numpy()) ** 2))
    believed = result.assessment.credible_heights.value
    assert 0.6 * true < believed < 2.0 * true
    given = result.examination.given_heights
    assert given.p_value > 1e-6
    assert given.moved_by_plan < true
