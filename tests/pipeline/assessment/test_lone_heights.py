"""The height of a single known point that took no part and is far off."""

from dataclasses import replace

import numpy as np
import pytest
from tests.given_approximations import beside_control

from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

PLACE = ["easting", "northing", "height"]
WAYS = ("two_step", "simultaneous")


@pytest.fixture(scope="module")
def spatial():
    geometry = replace(PRESETS["demo"].geometry, transformation="helmert_3d")
    return simulate_block("demo", seed=5, geometry=geometry)


@pytest.fixture(scope="module")
def onto_given_points(spatial):
    """The low flight alone, onto approximate coordinates: control takes no part."""
    return beside_control(spatial, PLACE)


def with_wrong_height(block, by, role="check", rows=(3,)):
    """The block with heights of known points given wrong, and their names."""
    control = block.control_points.copy()
    index = control.index[control["role"] == role][list(rows)]
    control.loc[index, "height"] += by
    names = control.loc[index, "point_id"].tolist()
    return replace(block, control_points=control), names


def computed(block, method):
    return densify(block, block.settings.updated({"method": method}))


@pytest.mark.parametrize("method", WAYS)
def test_a_wrong_check_height_is_named_and_leaves_the_figure(spatial, method):
    block, (name,) = with_wrong_height(spatial, 30.0)
    right, wrong = (computed(each, method) for each in (spatial, block))
    assert right.examination.lone_height is None
    believed = wrong.assessment.credible_heights
    assert believed == right.assessment.credible_heights
    assert not believed.is_lower_bound
    found = wrong.assessment.findings[0]
    assert (found.code, found.names) == ("lone_wrong_height", (name,))
    assert found.facts["largest"] == pytest.approx(30.0, abs=0.3)
    assert found.facts["n_others"] == 5
    assert found.facts["rms_of_others"] < 0.2
    assert wrong.assessment.claim_is_supported is False
    assert f"the height of point {name} is 30 m off" in wrong.summary()


@pytest.mark.parametrize("method", WAYS)
def test_several_wrong_check_heights_are_named_and_make_a_bound(spatial, method):
    block, names = with_wrong_height(spatial, np.array([30.0, 20.0]), rows=(3, 4))
    result = computed(block, method)
    assert result.examination.lone_height is None
    found = next(
        f for f in result.assessment.findings if f.code == "heights_beyond_claim"
    )
    assert list(found.names) == names  # the farther one first
    assert result.assessment.credible_heights.is_lower_bound
    assert result.assessment.credible_heights.value > 10.0
    assert f"far off: {names[0]}, {names[1]}" in " ".join(result.summary().split())


@pytest.mark.parametrize(
    ("method", "role"), [("two_step", "control"), ("simultaneous", "check")]
)
def test_onto_given_points_known_heights_are_compared(onto_given_points, method, role):
    """No covariance of points is known there: 30 m passed without a word."""
    block, (name,) = with_wrong_height(onto_given_points, 30.0, role)
    right, wrong = (computed(each, method) for each in (onto_given_points, block))
    assert not right.examination.height_claim.rejected
    assert right.examination.lone_height is None
    lone = wrong.examination.lone_height
    assert (lone.point_id, lone.role) == (name, role)
    assert lone.size == pytest.approx(30.0, abs=0.3)
    assert wrong.assessment.findings[0].code == "lone_wrong_height"


def test_onto_given_points_several_wrong_heights_refute_the_claim(onto_given_points):
    block, names = with_wrong_height(
        onto_given_points, np.array([5.0, 4.0]), rows=(1, 2)
    )
    for method in WAYS:
        result = computed(block, method)
        (test,) = result.examination.height_claim.rejected
        assert test.name == "check points"
        assert test.observed > 20.0 * test.predicted
        assert result.assessment.credible_heights.is_lower_bound
        found = next(
            f for f in result.assessment.findings if f.code == "heights_beyond_claim"
        )
        assert list(found.names) == names


def test_several_wrong_heights_of_control_that_took_no_part(onto_given_points):
    """Also where errors are propagated, since it is said what approximations share."""
    block, names = with_wrong_height(
        onto_given_points, np.array([5.0, 4.0]), "control", rows=(1, 2)
    )
    block = replace(block, correlation_lengths_m={"approximate_points": 500.0})
    result = computed(block, "two_step")
    assert result.examination.errors is not None
    tests = {test.name: test for test in result.examination.height_claim.rejected}
    assert tests["control points"].observed > 10.0 * tests["control points"].predicted
    found = next(
        f for f in result.assessment.findings if f.code == "heights_beyond_claim"
    )
    assert list(found.names) == names


def test_heights_of_a_group_may_be_shifted_as_stated(spatial):
    control = spatial.control_points.assign(group="network")
    control["height"] += 1.0
    block = replace(
        spatial, control_points=control, group_errors_m={"control_points": 2.0}
    )
    result = computed(block, "two_step")
    known = result.examination.known_heights
    assert known.count
    assert (known.standard_errors > 1.0).all()
    assert not len(known.far)
    assert result.examination.lone_height is None
