"""Known points that do not agree with the claim."""

from dataclasses import replace

import pytest
from tests.changed_results import changed

from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings import known_points as judges


def with_differences(result, east=1.0, north=1.0, shift=0.0):
    """The result with the differences at known points stretched and shifted."""
    points = result.points.copy()
    points["difference_easting"] *= east
    points["difference_northing"] = north * points["difference_northing"] + shift
    return changed(result, points=points)


@pytest.mark.parametrize("judge", judges.TWO_STEP)
def test_a_good_block_has_none(good_result, judge):
    assert judge(good_result.examination) is None


def test_check_points_worse_than_the_claim(good_result):
    moved = with_differences(good_result, 4.0, 4.0)
    found = judges.check_points_beyond_claim(moved.examination)
    assert found.remedy == "trust_check_points"
    assert found.gravity is Gravity.GRAVE
    assert found.facts["n_points"] == 6
    assert found.observed == pytest.approx(4.0 * good_result.figures.check_rms)
    assert found.facts["ratio"] == pytest.approx(found.observed / found.expected)
    assert found.probability < 0.001
    assert judges.check_points_better_than_claim(moved.examination) is None


def test_check_points_better_than_the_claim(good_result):
    moved = with_differences(good_result, 0.05, 0.05)
    found = judges.check_points_better_than_claim(moved.examination)
    assert found.remedy == "give_smaller_errors"
    assert found.gravity is Gravity.NOTE
    assert found.probability > 0.999
    assert judges.check_points_beyond_claim(moved.examination) is None


def test_check_points_are_allowed_the_error_that_they_have(good_result):
    """With standard errors of 1 m given, differences of 10 cm prove nothing."""
    control = good_result.block.control_points.assign(standard_error_m=1.0)
    block = replace(good_result.block, control_points=control)
    moved = changed(good_result, block=block)
    assert judges.check_points_beyond_claim(moved.examination) is None
    found = judges.check_points_better_than_claim(moved.examination)
    assert found.expected == pytest.approx(1.0, rel=0.01)


def test_control_points_far_from_the_claim_are_named(good_result):
    points = good_result.points.copy()
    worst = points.loc[points["role"] == "control", "point_id"].iloc[3]
    points.loc[points["point_id"] == worst, "difference_easting"] = 2.0
    found = judges.control_points_beyond_claim(
        changed(good_result, points=points).examination
    )
    assert found.names[0] == worst
    assert found.facts["n_points"] == (points["role"] == "control").sum()


@pytest.mark.parametrize("role", ["check", "control"])
def test_a_shift_of_all_known_points_is_seen(good_result, role):
    moved = with_differences(good_result, shift=-0.5)
    if role == "control":
        points = moved.points[moved.points["role"] != "check"]
        moved = changed(moved, points=points)
    found = judges.shifted_block(moved.examination)
    assert found.facts["role"] == role
    assert found.facts["northing"] == pytest.approx(-0.5, abs=0.05)
    assert abs(found.facts["easting"]) < 0.05
    assert found.probability < 0.001
    if role == "check":
        assert found.facts["n_points"] == 6
