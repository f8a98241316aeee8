"""Control that contradicts approximate points which agree among themselves."""

from dataclasses import replace

import pytest
from scipy.stats import kstest
from tests.given_approximations import beside_control
from tests.pipeline.assessment.evidence.fits.test_adjusted_plan import (
    adjusted,
    east_off,
    told,
    true_error,
)

from einschalt.pipeline.assessment.evidence.fits.control_beside_given import (
    given_points_agree,
    p_value_of_control,
)
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

PLAN = ["easting", "northing"]


def affine_block(seed):
    """Control that hardly holds affine models, beside points of GNSS."""
    geometry = replace(PRESETS["demo"].geometry, n_check=0)
    block = beside_control(simulate_block("demo", seed=seed, geometry=geometry))
    control = block.control_points
    few = control[control["role"] != "check"].iloc[::2].reset_index(drop=True)
    return replace(block, control_points=few)


def control_of(block):
    control = block.control_points
    return control["point_id"]


@pytest.fixture(scope="module")
def broken():
    block, _ = east_off(affine_block(4), 0.15, ("control_points",))
    return adjusted(block), block


def test_what_the_adjustment_hides_is_told(broken):
    result, block = broken
    assert told(result)
    believed, true = result.assessment.credible, true_error(result, block)
    assert believed.is_lower_bound
    assert 0.67 < believed.value / true < 1.5


def test_the_pattern_by_itself_needs_no_residual(broken):
    result, block = broken
    two_step = result.examination.two_step
    assert given_points_agree(result.examination)
    assert p_value_of_control(two_step, control_of(block)) < 0.01


@pytest.mark.parametrize("seed", [4, 5, 6])
def test_good_control_agrees(seed):
    block = affine_block(seed)
    result = adjusted(block)
    assert not told(result)
    two_step = result.examination.two_step
    assert p_value_of_control(two_step, control_of(block)) > 0.01


def test_another_system_is_no_error_of_control():
    """Approximate points turned, stretched and shifted against control."""
    block = affine_block(5)
    points = block.approximate_points.copy()
    xy = points[PLAN].to_numpy()
    x, y = (xy - xy.mean(axis=0)).T
    points["easting"] += 0.4 + 1e-4 * x - 5e-5 * y
    points["northing"] += -0.3 + 5e-5 * x + 1e-4 * y
    result = adjusted(replace(block, approximate_points=points))
    two_step = result.examination.two_step
    assert two_step.claim.of("control points").p_value < 1e-6
    assert p_value_of_control(two_step, control_of(block)) > 0.01
    assert not told(result)


def test_points_that_share_errors_tell_nothing_of_control():
    """Half of the approximate points displaced: the region shows itself."""
    block = affine_block(6)
    points = block.approximate_points.copy()
    is_east = points["easting"] > points["easting"].median()
    points.loc[is_east, "northing"] += 0.5
    result = adjusted(replace(block, approximate_points=points))
    assert not given_points_agree(result.examination)
    assert not told(result)


def test_nothing_is_known_without_a_stated_error():
    block = replace(affine_block(4), approximate_m_0_m=None)
    assert not given_points_agree(adjusted(block).examination)


def test_few_points_leave_nothing_to_test(broken):
    result, block = broken
    names = control_of(block)
    assert p_value_of_control(result.examination.two_step, names[:2]) == 1.0


def test_probabilities_of_good_control_are_uniform():
    """Of good blocks one in a hundred may be told."""
    found = []
    for seed in range(12):
        block = affine_block(20 + seed)
        two_step = adjusted(block).examination.two_step
        found.append(p_value_of_control(two_step, control_of(block)))
    assert kstest(found, "uniform").pvalue > 0.01
