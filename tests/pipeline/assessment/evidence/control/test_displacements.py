"""What is wrong is covered by the figure to believe: how far it moves the points."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.evidence.control.displacements import (
    NOTHING,
    Displacement,
    _pulled_in_adjustment,
    _that_agree,
    largest,
    moved_between_ways,
    moved_by_suspects,
    where_it_matters,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import simulate_block

PLAN = ["easting", "northing"]


def true_error(result):
    """TOTAL error of the new points, RMS [m]."""
    new = result.points[result.points["role"] == "new"]
    truth = result.block.truth.set_index("point_id").loc[new["point_id"], PLAN]
    miss = new[PLAN].to_numpy() - truth.to_numpy()
    return float(np.sqrt(np.mean(np.sum(miss**2, axis=1))))


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_wrong_control_counts_by_what_it_does_to_the_points(demo_block, method):
    control = demo_block.control_points.copy()
    used = control.index[control["role"] == "control"][[2, 9]]
    control.loc[used, "easting"] += [1.5, -0.8]
    block = replace(demo_block, control_points=control)
    result = densify(block, block.settings.updated({"method": method}))
    believed, true = result.assessment.credible.value, true_error(result)
    assert true > 1.5 * result.figures.mean_total
    assert 0.5 * true < believed < 4.0 * true
    assert not result.assessment.claim_is_supported


@pytest.mark.slow
def test_a_point_that_a_whole_flight_has_elsewhere(demo_block):
    low = demo_block.low_flight
    points = low.model_points.copy()
    new = demo_block.truth["point_id"]
    new = new[~new.isin(demo_block.control_points["point_id"])]
    is_it = points["point_id"] == new.iloc[30]
    points.loc[is_it, "x"] += 0.5
    block = replace(demo_block, low_flight=replace(low, model_points=points))
    result = densify(block, block.settings.updated({"method": "simultaneous"}))
    assert result.examination.credible.value > 0.5 * true_error(result) > 0.05


def test_clean_blocks_are_not_moved(good_result, simultaneous_result):
    for result in (good_result, simultaneous_result):
        examined = result.examination
        claimed = result.figures.mean_total
        plan = examined.displaced.plan
        assert where_it_matters(plan, claimed, is_refuted=False) == 0.0
        assert result.examination.credible.factor < 1.1
    assert simultaneous_result.examination.apart_from_two_steps.plan < 0.05


@pytest.mark.parametrize(
    ("moved", "is_refuted", "counted"),
    [(0.05, False, 0.0), (0.05, True, 0.05), (0.08, False, 0.08)],
)
def test_what_chance_may_do_counts_where_the_claim_falls(moved, is_refuted, counted):
    assert where_it_matters(moved, 0.1, is_refuted=is_refuted) == counted


def test_the_largest_of_several():
    found = largest(Displacement(0.1, 3.0), NOTHING, Displacement(0.2, 1.0))
    assert found == Displacement(0.2, 3.0)


def fake(points, s_0=1.0, p_value=np.nan):
    table = pd.DataFrame({"point_id": list("abcd"), **points, "role": "new"})
    table = table.assign(spread_total=0.1, is_suspect=table["point_id"] == "d")
    table = table.assign(n_models=2, p_value=p_value)
    return SimpleNamespace(
        points=table,
        solution=SimpleNamespace(points=table),
        figures=SimpleNamespace(mean_within=0.1),
        stated_height=np.nan,
        adjustment=SimpleNamespace(s_0=s_0),
        residuals=table[["point_id", "is_suspect", "p_value"]],
        suspects=set(),
        coverages=table[["point_id", "is_suspect", "p_value"]],
        screening=SimpleNamespace(n_tested=4),
        far_apart=np.zeros(4, dtype=bool),
        named_measurements=table.iloc[:0],
        is_possible=True,
        is_put_off=False,
        displaced_regions=(),
        means=SimpleNamespace(points=table, used=pd.concat([table, table])),
        high=None,
        approximations=table.assign(easting=table["easting"] - [9.0, 0.0, 0.0, 3.0]),
    )


def test_suspects_may_be_where_the_other_flight_has_them():
    one = fake({"easting": np.zeros(4), "northing": np.zeros(4)}, p_value=1e-5)
    one.two_step = one
    # d alone is a suspect: 3 m of four points, and the spread across
    assert moved_by_suspects(one).plan == pytest.approx(1.5, rel=0.01)


def test_suspects_that_do_not_stand_out_of_all_tests_move_nothing():
    one = fake({"easting": np.zeros(4), "northing": np.zeros(4)}, p_value=5e-4)
    one.two_step = one
    assert moved_by_suspects(one) == NOTHING
    # what a finding names counts, whichever test it was
    one.suspects = {"d"}
    assert moved_by_suspects(one).plan > 1.0


def test_a_clean_block_is_not_doubted_for_a_suspect_that_chance_makes():
    # 1 of 922 residuals with p 1.2e-5: none of the block's findings names it
    block = simulate_block("demo", seed=930009)
    result = densify(block, block.settings.updated({"method": "simultaneous"}))
    assert result.residuals["is_suspect"].sum() == 1
    assert result.assessment.claim_is_supported
    assert not result.assessment.credible.is_lower_bound


@pytest.mark.parametrize(("s_0", "expected"), [(1.0, 1.9950), (50.0, 1.9799)])
def test_ways_that_come_apart_by_more_than_their_errors(s_0, expected):
    one = fake({"easting": np.full(4, 2.0), "northing": np.zeros(4)}, s_0)
    one.two_step = fake({"easting": np.zeros(4), "northing": np.zeros(4)})
    found = moved_between_ways(one, one.two_step)
    # errors beyond twice the stated ones explain nothing: s_0 counts up to 2
    assert found.plan == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(("regions", "expected"), [((), 0.0), (("west",), 1.9950)])
def test_ways_are_held_apart_without_what_the_two_steps_alone_follow(regions, expected):
    one = fake({"easting": np.full(4, 2.0), "northing": np.zeros(4)})
    one.displaced_regions = regions
    one.two_step = fake({"easting": np.zeros(4), "northing": np.zeros(4)})
    one.two_step.is_put_off = True
    one.two_step.corrected = fake({"easting": np.full(4, 2.0), "northing": np.zeros(4)})
    assert moved_between_ways(one, one.two_step).plan == pytest.approx(
        expected, abs=1e-4
    )


def test_points_that_two_steps_contradict_themselves_do_not_count():
    """The median stands for three values and more, nothing for two."""
    apart = {"easting": [9.0, 9.0, 0.0, 0.0], "northing": np.zeros(4)}
    one = fake({"easting": np.zeros(4), "northing": np.zeros(4)})
    one.two_step = fake(apart)
    assert moved_between_ways(one, one.two_step).plan > 6.0
    one.two_step.far_apart = np.array([True, True, False, False])
    values = pd.DataFrame(
        {
            "point_id": list("aaabb"),
            "easting": [0.0, 0.0, 27.0, 0.0, 18.0],
            "northing": 0.0,
        }
    )
    one.two_step.means.used = values
    assert moved_between_ways(one, one.two_step) == NOTHING


@pytest.mark.parametrize(
    ("heights", "expected"),
    [
        # 5 m where two steps know 3.5 m: the others agree to what both are known by
        ([5.0, 0.05, -0.05, 0.03], 0.0),
        ([0.5, 0.5, 0.5, 0.5], 0.49),
        ([5.0, 0.5, 0.5, 0.5], 0.49),
    ],
)
def test_heights_that_two_steps_hardly_know_tell_little(heights, expected):
    plan = {"easting": np.zeros(4), "northing": np.zeros(4)}
    one = fake({**plan, "height": np.zeros(4), "standard_error_height": 0.04})
    stated = [3.5, 0.08, 0.08, 0.08]
    one.two_step = fake({**plan, "height": heights, "standard_error_height": stated})
    found = moved_between_ways(one, one.two_step)
    assert found.height == pytest.approx(expected, abs=0.01)


def residuals_of(easting, suspects):
    return pd.DataFrame(
        {
            "point_id": "a",
            "residual_easting": easting,
            "residual_northing": 0.0,
            "is_suspect": suspects,
        }
    )


@pytest.mark.parametrize(
    ("easting", "suspects", "expected"),
    [
        # two that confirm each other hold the point, whatever else there is
        ([0.1, -0.1, 40.0, -30.0, 20.0], [False, False, True, True, True], 0.0),
        # a norm leaves the gross ones a share: the point lies 0.3 m beside the others
        ([0.2, 0.4, 9.0], [False, False, True], 0.3),
        # one against one, and one against two: the nearest is right in half of all
        ([0.0, 2.0], [False, True], np.sqrt(2.0)),
        ([0.0, 2.0, 70.0], [False, True, True], np.sqrt(2.0)),
        ([0.0], [False], np.nan),
    ],
)
def test_what_one_wrong_value_does_in_an_adjustment(easting, suspects, expected):
    found = _pulled_in_adjustment(residuals_of(easting, suspects), pd.Series(["a"]))
    np.testing.assert_allclose(found, [expected], atol=1e-12)


def test_approximations_that_nothing_confirms_tell_nothing_of_an_adjustment():
    given = pd.DataFrame(
        {
            "point_id": list("abcdef"),
            "n_models": [2, 2, 1, 3, 2, 3],
            "spread_total": [0.1, 9.0, np.nan, 9.0, 0.2, 0.1],
        }
    )
    two_step = SimpleNamespace(high=object(), approximations=given)
    assert list(_that_agree(given, two_step)["point_id"]) == list("adef")
    two_step.high = None
    assert _that_agree(given, two_step) is given
