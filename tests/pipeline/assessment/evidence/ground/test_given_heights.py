"""Given heights against those of models that go straight onto them."""

from dataclasses import replace

import numpy as np
import pytest
from tests.judged_alone import judged_alone
from tests.photographs_onto_control import AXES, ERROR, GEOMETRY, one_flight

from einschalt.pipeline.assessment.evidence.claim import RESIDUALS
from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import simulate_block


@pytest.fixture(scope="module")
def block():
    return one_flight(seed=2)


@pytest.fixture(scope="module")
def clean(block):
    return densify(block)


def with_distance(block, times):
    flight = block.low_flight
    distance = flight.principal_distance_mm * times
    return replace(block, low_flight=replace(flight, principal_distance_mm=distance))


def with_heights(block, change):
    """The block with other given heights, of control as well."""
    tables = {
        name: table.assign(height=change(table))
        for name in ("approximate_points", "control_points")
        if (table := getattr(block, name)) is not None
    }
    return replace(block, **tables)


def true_error(result, block):
    points = result.points[result.points["role"] == "new"].set_index("point_id")
    true = block.truth.set_index("point_id")["height"].reindex(points.index)
    return float(np.sqrt(np.nanmean((points["height"] - true) ** 2)))


def codes(result):
    return judged_alone(result)


@pytest.mark.slow
def test_residuals_vary_as_their_covariance_says(clean):
    """Squares of the independent numbers have mean 1, by their own number."""
    squares = [float(np.sum(clean.examination.given_heights.observed() ** 2))]
    numbers = [len(clean.examination.given_heights.observed())]
    for seed in (3, 4, 5):
        given = densify(one_flight(seed)).examination.given_heights
        squares.append(float(np.sum(given.observed() ** 2)))
        numbers.append(len(given.observed()))
    n = sum(numbers)
    assert n > 80
    assert abs(sum(squares) / n - 1.0) < 3.5 * np.sqrt(2.0 / n)


def test_clean_heights_keep_their_claim(clean):
    assert clean.examination.given_heights is not None
    test = clean.examination.height_claim.of(RESIDUALS)
    assert test.n_points == 24  # one of them lies in no model that can be used
    assert test.p_value > 0.01
    assert clean.examination.control_patterns.height is None
    assert "unseen_height_scale" not in codes(clean)
    assert not clean.examination.credible_heights.is_lower_bound


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_a_wrong_principal_distance_is_named_and_counts(block, method):
    result = densify(with_distance(block, 1.3), Settings(method=method))
    found = result.examination.control_patterns.height
    assert found.kind is Kind.SCALE
    assert found.amplitude[0] == pytest.approx(0.3 / 1.3, rel=0.05)
    assert "heights_out_of_scale" in codes(result)
    true = true_error(result, block)
    assert true > 3.0
    assert 0.7 * true < result.assessment.credible_heights.value < 1.5 * true
    told = " ".join(result.summary().split())
    finding = next(
        f for f in result.assessment.findings if f.code == "heights_out_of_scale"
    )
    distance = finding.facts["principal_distance_mm"]
    right = block.low_flight.principal_distance_mm
    assert distance == pytest.approx(right, rel=0.02)
    assert f"a principal distance of {distance:.1f} mm instead" in told


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_a_distance_that_is_wrong_by_a_per_cent_is_named_and_counts(block, method):
    """It moved heights by twice what was claimed, and given points did not show it."""
    result = densify(with_distance(block, 1.01), Settings(method=method))
    found = result.examination.control_patterns.height
    assert found.kind is Kind.SCALE
    assert found.is_of_adjustment
    assert found.amplitude[0] == pytest.approx(0.01, abs=0.004)
    assert "heights_out_of_scale" in codes(result)
    true = true_error(result, block)
    assert true > 0.14
    assert 0.7 * true < result.assessment.credible_heights.value < 1.5 * true


def test_one_wrong_height_is_named_and_counts(block):
    def change(table):
        return table["height"] + 10.0 * (table.index == 5)

    result = densify(with_heights(block, change))
    found = result.examination.control_patterns.height
    assert found.kind is Kind.POINT
    assert found.point_ids == (block.control_points["point_id"].iloc[5],)
    assert found.amplitude[0] == pytest.approx(10.0, rel=0.02)
    true = true_error(result, block)
    assert true > 0.5
    assert 0.7 * true < result.examination.credible_heights.value < 1.5 * true


def test_heights_that_are_all_worse_than_stated_are_no_pattern(block):
    rng = np.random.default_rng(7)
    errors = rng.normal(0.0, 0.3, len(block.control_points))
    result = densify(with_heights(block, lambda table: table["height"] + errors))
    assert "heights_beyond_claim" in codes(result)
    assert result.examination.control_patterns.height is None
    assert result.examination.credible_heights.is_lower_bound


@pytest.mark.slow
def test_given_points_that_are_no_control_are_told_by_their_name(block):
    def change(table):
        return table["height"] + 10.0 * (table.index == 5)

    without = with_heights(replace(block, control_points=None), change)
    result = densify(without)
    assert result.examination.control_patterns.height.kind is Kind.POINT
    name = block.approximate_points["point_id"].iloc[5]
    told = " ".join(result.summary().split())
    assert f"The height of approximate point {name} is 9.9 m off" in told
    found = densify(with_distance(replace(block, control_points=None), 1.3))
    assert found.examination.control_patterns.height.kind is Kind.SCALE
    assert found.examination.credible_heights.is_lower_bound


def test_approximations_that_share_errors_have_no_steps(block):
    """Half of them lies 10 m higher: no control is broken in two."""

    def change(table):
        return table["height"] + 10.0 * (table["easting"] > table["easting"].median())

    result = densify(with_heights(replace(block, control_points=None), change))
    assert "broken_heights" not in codes(result)
    assert result.examination.credible_heights.is_lower_bound


@pytest.mark.slow
def test_flat_control_does_not_tell_the_scale_and_the_summary_says_so():
    """Only points within a few metres in height are given, on ground of 30 m relief."""
    block = one_flight(seed=5)
    middle = block.truth["height"].median()
    near = (block.truth["height"] - middle).abs() < 3.0
    given = block.truth[near].reset_index(drop=True)[["point_id", *AXES]]
    assert len(given) > 6
    rng = np.random.default_rng(11)
    given[AXES] += rng.normal(0.0, ERROR, (len(given), 3))
    control = given.assign(standard_error_m=np.sqrt(2.0) * ERROR, role="control")
    flat = replace(block, approximate_points=given, control_points=control)
    result = densify(flat)
    (found,) = (
        f for f in result.assessment.findings if f.code == "unseen_height_scale"
    )
    assert found.facts["per_cent"] > 2.0
    assert found.facts["per_cent"] * found.facts["moved_per_cent"] > 0.05
    # what a per cent does, by what it does
    points, others = (
        densify(one).points.set_index("point_id")
        for one in (flat, with_distance(flat, 1.01))
    )
    new = points.index[points["role"] == "new"]
    moved = others.loc[new, "height"] - points.loc[new, "height"]
    size = np.sqrt(np.nanmean(moved**2))
    assert size == pytest.approx(found.facts["moved_per_cent"], rel=0.05)
    told = " ".join(result.summary().split())
    assert "differ too little to check the principal distance" in told
    assert "Each per cent moves the heights of the new points by" in told


@pytest.mark.slow
def test_with_a_high_flight_control_is_left_out_instead(block):
    both = densify(simulate_block("demo", seed=2, geometry=GEOMETRY))
    assert both.examination.given_heights is None
    assert both.examination.left_out_control is not None


@pytest.mark.slow
def test_a_height_in_feet_is_told_as_large_as_it_is(block):
    """It turns its models over: linear operators tell a part of it."""

    def change(table):
        return table["height"] * np.where(table.index == 5, 3.2808, 1.0)

    result = densify(with_heights(block, change))
    (found,) = (
        f for f in result.assessment.findings if f.code == "wrong_control_height"
    )
    error = 2.2808 * block.control_points["height"].iloc[5]
    assert found.names == (block.control_points["point_id"].iloc[5],)
    assert found.facts["size"] == pytest.approx(error, rel=0.01)
    good = densify(block).points.set_index("point_id")["height"]
    points = result.points[result.points["role"] == "new"].set_index("point_id")
    moved = np.sqrt(np.mean((points["height"] - good.reindex(points.index)) ** 2))
    assert found.facts["moved"] == pytest.approx(moved, rel=0.1)
