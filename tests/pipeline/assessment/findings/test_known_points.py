"""Known points that do not agree with the claim."""

from dataclasses import replace

import pytest
from tests.changed_results import changed

from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings import known_points as judges
from einschalt.pipeline.densify import densify

PLACE = "point_id"


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
    moved = with_differences(good_result, 6.0, 6.0)
    found = judges.check_points_beyond_claim(moved.examination)
    assert found.remedy == "trust_check_points"
    assert found.gravity is Gravity.GRAVE
    assert found.facts["n_points"] == 6
    assert found.observed == pytest.approx(6.0 * good_result.figures.check_rms)
    assert found.facts["ratio"] == pytest.approx(found.observed / found.expected)
    assert found.probability < 0.001
    assert judges.check_points_better_than_claim(moved.examination) is None


def with_moved_check_points(result, *rows, by=1.0):
    points = result.points.copy()
    check = points.index[points["role"] == "check"]
    points.loc[check[list(rows)], "difference_easting"] += by
    return changed(result, points=points), list(points.loc[check[list(rows)], PLACE])


def test_a_lone_wrong_check_point_is_named(good_result):
    moved, names = with_moved_check_points(good_result, 2)
    examined = moved.examination
    found = judges.lone_wrong_check_point(examined)
    assert list(found.names) == names
    others = found.facts["rms_of_others"]
    assert others < 0.1 < found.facts["rms"]
    assert examined.known_check.are_beyond
    beyond = judges.check_points_beyond_claim(examined)
    assert beyond.names[0] == names[0]
    assert beyond.facts["median"] < others < beyond.facts["largest"]


@pytest.mark.slow
def test_two_wrong_check_points_are_both_named_and_not_relied_on(good_result):
    moved, names = with_moved_check_points(good_result, 1, 4)
    found = judges.check_points_beyond_claim(moved.examination)
    assert found.facts["n_far"] == 2
    assert set(found.names[:2]) == set(names)
    assert found.remedy == "check_far_points"
    assert "rely on" not in moved.summary().lower()
    # where most contradict it, it is the block that is wrong
    moved, _ = with_moved_check_points(good_result, 1, 2, 3, 4)
    found = judges.check_points_beyond_claim(moved.examination)
    assert found.facts["n_far"] == 0
    assert found.remedy == "trust_check_points"


@pytest.mark.slow
def test_beside_a_lone_wrong_check_point_no_check_point_is_relied_on(good_result):
    moved, names = with_moved_check_points(good_result, 2)
    summary = moved.summary()
    assert f"Check point {names[0]} differs by 1.0 m" in summary
    assert "rely on" not in summary.lower()


@pytest.mark.parametrize("rows", [(1, 2), (0, 1, 2, 3, 4, 5)])
def test_several_wrong_check_points_are_no_lone_one(good_result, rows):
    moved, _ = with_moved_check_points(good_result, *rows)
    assert judges.check_points_beyond_claim(moved.examination) is not None
    assert judges.lone_wrong_check_point(moved.examination) is None


def test_no_check_point_is_the_lone_one_where_wrong_control_is_near(good_result):
    """A right check point in a block that wrong control moves."""
    control = good_result.block.control_points.copy()
    row = control.index[control["role"] == "control"][3]
    control.loc[row, "easting"] += 0.8
    spoilt = densify(replace(good_result.block, control_points=control))
    assert spoilt.control_left_out["is_suspect"].any()
    high = spoilt.examination.oriented_high_points
    wrong = high["point_id"] == control.loc[row, "point_id"]
    models = set(high.loc[wrong, "model_id"])
    points = spoilt.points
    check = points.index[points["role"] == "check"]
    near = high.loc[high["model_id"].isin(models), "point_id"]
    rows = [k for k, r in enumerate(check) if points.loc[r, PLACE] in set(near)]
    moved, _ = with_moved_check_points(spoilt, rows[0])
    assert moved.examination.known_check.are_beyond
    assert judges.lone_wrong_check_point(moved.examination) is None


@pytest.mark.parametrize(("n_kept", "is_named"), [(2, False), (4, True)])
def test_one_other_check_point_is_too_few(good_result, n_kept, is_named):
    moved, _ = with_moved_check_points(good_result, 0)
    points = moved.solution.points  # of which none is judged yet
    check = points.index[points["role"] == "check"]
    fewer = changed(moved, points=points.drop(check[n_kept:]))
    assert fewer.examination.known_check.are_beyond
    found = judges.lone_wrong_check_point(fewer.examination)
    assert (found is not None) == is_named


def test_where_the_others_are_beyond_as_well_none_is_lone(good_result):
    worse = with_differences(good_result, 3.0, 3.0)
    moved, _ = with_moved_check_points(worse, 2)
    assert judges.lone_wrong_check_point(moved.examination) is None


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
