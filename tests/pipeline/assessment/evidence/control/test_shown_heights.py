"""Control heights worse than stated tilt models: in plan that is no pattern."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

PLAN = ["easting", "northing"]
GEOMETRY = replace(
    PRESETS["demo"].geometry,
    width=4200.0,
    height=3600.0,
    point_spacing=300.0,
    transformation="helmert_3d",
    measurement="images",
)


@pytest.fixture(scope="module")
def block():
    return simulate_block("demo", seed=3, geometry=GEOMETRY)


def noisy(block, size, seed=80):
    control = block.control_points
    noise = size * np.random.default_rng(seed).standard_normal(len(control))
    return replace(
        block, control_points=control.assign(height=control["height"] + noise)
    )


def true_error(result):
    new = result.points[result.points["role"] == "new"]
    truth = result.block.truth.set_index("point_id").loc[new["point_id"], PLAN]
    return float(np.sqrt(np.mean(np.sum((new[PLAN] - truth.to_numpy()) ** 2, axis=1))))


@pytest.fixture(scope="module")
def sound(block):
    return densify(block)


@pytest.fixture(scope="module")
def of_one_metre(block):
    return densify(noisy(block, 1.0))


@pytest.mark.slow
def test_heights_of_one_metre_are_no_step_in_plan(of_one_metre):
    patterns = of_one_metre.examination.control_patterns
    assert patterns.plan is None
    assert patterns.moved_plan == 0.0
    credible = of_one_metre.examination.credible
    assert credible.is_lower_bound
    assert 0.85 < credible.value / true_error(of_one_metre) < 1.5


@pytest.mark.slow
def test_what_they_do_in_plan_is_propagated(of_one_metre, sound):
    """As far as heights of one metre move the new points of the same block."""
    before = sound.points.set_index("point_id").loc[of_one_metre.points["point_id"]]
    is_new = (of_one_metre.points["role"] == "new").to_numpy()
    apart = of_one_metre.points[PLAN].to_numpy() - before[PLAN].to_numpy()
    moved = np.sqrt(np.mean(np.sum(apart[is_new] ** 2, axis=1)))
    assert 0.5 < of_one_metre.examination.moved_by_shown_heights / moved < 2.0


def test_sound_heights_change_nothing(sound):
    examined = sound.examination
    assert examined.model_with_shown_heights is examined.error_model
    assert examined.moved_by_shown_heights == 0.0


@pytest.mark.slow
def test_one_height_that_is_far_off_does_not_stand_for_all(block):
    control = block.control_points
    place = control.index[control["role"] == "control"][5]
    wrong = control["height"] + 20.0 * (control.index == place)
    result = densify(replace(block, control_points=control.assign(height=wrong)))
    examined = result.examination
    sizes = examined.model_with_shown_heights.standard_errors["control"]
    given = examined.error_model.standard_errors["control"]
    # by all differences it would be more than a hundred times as large
    assert np.max(sizes) < 20.0 * np.max(given)


@pytest.mark.slow
def test_a_step_in_plan_stands_out_of_what_heights_do(block):
    control = block.control_points
    east = control["easting"] > control["easting"].median()
    step = control.assign(northing=control["northing"] + 1.5 * east)
    result = densify(noisy(replace(block, control_points=step), 1.0))
    pattern = result.examination.control_patterns.plan
    assert pattern is not None
    assert pattern.kind is Kind.STEP
    assert result.examination.credible.value > 0.8 * true_error(result)
