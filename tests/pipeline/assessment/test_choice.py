"""method = "auto": both ways are computed, the one that is better supported is kept."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from tests.given_approximations import beside_control
from tests.photographs_onto_control import one_flight

from einschalt.foundations.errors import EinschaltError, GeometryError
from einschalt.foundations.typesetting import length
from einschalt.pipeline.assessment import choice
from einschalt.pipeline.assessment.assess import assess
from einschalt.pipeline.assessment.choice import (
    ChoiceReason,
    adjustment_beside,
    better_beside,
    better_of,
    is_untried,
)
from einschalt.pipeline.assessment.credibility import CredibleFigure, Reason
from einschalt.pipeline.assessment.credible_heights import CredibleHeights
from einschalt.pipeline.assessment.evidence.ground import displaced_region
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.pipeline.summary.summary import lasting_summary

AUTO = Settings(method="auto")
PLANE = ["easting", "northing"]


def way(
    value,
    n_models=10,
    *,
    is_lower_bound=False,
    left_out=None,
    n_left_out=10,
    keeps_wrong_control=False,
    knows_wrong_control=False,
    n_new=100,
    mean_total=0.05,
    check=(),
    heights=None,
    heights_are_bound=False,
    left_out_heights=(),
):
    figure = CredibleFigure(value, is_lower_bound, "", 1.0, Reason.PROPAGATED)
    models = pd.DataFrame({"is_usable": np.arange(12) < n_models})
    n_left_out = 0 if left_out is None else n_left_out
    control = pd.DataFrame(
        {"easting": left_out, "northing": 0.0},
        index=[f"c{k}" for k in range(n_left_out)],
    )
    parts = {"models": models, "left_out_differences": control}
    parts["keeps_wrong_control"] = keeps_wrong_control
    parts["knows_wrong_control"] = knows_wrong_control
    parts["left_out_control"] = control if n_left_out else None
    parts["figures"] = SimpleNamespace(n_new=n_new, mean_total=mean_total)
    stated = pd.DataFrame({"standard_error_m": [0.03]})
    parts["block"] = SimpleNamespace(control_points=stated)
    points = {"point_id": [f"k{k}" for k in range(len(check))], "role": "check"}
    differences = {"difference_easting": check, "difference_northing": 0.0}
    parts["points"] = pd.DataFrame({**points, **differences})
    parts |= {"lone_points": (), "shares_control_errors": False}
    in_height = heights and CredibleHeights(heights, heights_are_bound, 1.0)
    parts["credible_heights"] = in_height
    parts["left_out_heights"] = pd.DataFrame({"height": left_out_heights})
    return SimpleNamespace(credible=figure, **parts)


@pytest.mark.parametrize(
    ("two_step", "simultaneous", "method", "reason"),
    [
        (way(0.05), way(0.03), "simultaneous", ChoiceReason.SMALLER),
        (way(0.03), way(0.05), "two_step", ChoiceReason.SMALLER),
        (way(0.05), way(0.03, is_lower_bound=True), "two_step", "supported"),
        (way(0.05, is_lower_bound=True), way(0.3), "simultaneous", "supported"),
        (
            way(0.09, is_lower_bound=True),
            way(0.03, is_lower_bound=True),
            "two_step",
            ChoiceReason.CONTRADICTED,
        ),
        (
            way(0.05, left_out=0.06),
            way(0.03, is_lower_bound=True, left_out=0.04),
            "simultaneous",
            ChoiceReason.LEFT_OUT,
        ),
        (
            way(0.09, is_lower_bound=True, left_out=0.06),
            way(0.03, is_lower_bound=True, left_out=0.07),
            "two_step",
            ChoiceReason.CONTRADICTED,
        ),
        # wrong control that both keep spoils both: left-out control decides
        (
            way(0.09, is_lower_bound=True, left_out=0.06),
            way(0.08, is_lower_bound=True, left_out=0.04, keeps_wrong_control=True),
            "simultaneous",
            ChoiceReason.LEFT_OUT,
        ),
        (
            way(0.09, is_lower_bound=True, left_out=0.06),
            way(0.08, is_lower_bound=True, left_out=0.05, keeps_wrong_control=True),
            "two_step",
            ChoiceReason.CONTRADICTED,
        ),
        (
            way(0.08, is_lower_bound=True, left_out=0.06),
            way(0.09, is_lower_bound=True, left_out=0.04, keeps_wrong_control=True),
            "two_step",
            ChoiceReason.CONTRADICTED,
        ),
        (
            way(0.05, left_out=0.06, n_left_out=7),
            way(0.03, is_lower_bound=True, left_out=0.04, n_left_out=7),
            "two_step",
            ChoiceReason.SUPPORTED,
        ),
        (
            way(0.05, left_out=0.06),
            way(0.03, is_lower_bound=True, left_out=0.059),
            "two_step",
            ChoiceReason.SUPPORTED,
        ),
        (
            way(0.05, left_out=0.06),
            way(0.03, is_lower_bound=True, left_out=0.04, keeps_wrong_control=True),
            "two_step",
            ChoiceReason.SUPPORTED,
        ),
        (
            way(0.05, left_out=0.06),
            way(0.03, is_lower_bound=True, left_out=[np.nan] * 3 + [0.04] * 7),
            "two_step",
            ChoiceReason.SUPPORTED,
        ),
        (
            way(0.05, left_out=0.06),
            way(0.07, is_lower_bound=True, left_out=0.04),
            "simultaneous",
            ChoiceReason.LEFT_OUT,
        ),
        (
            way(0.05, left_out=0.06),
            way(0.07, is_lower_bound=True, left_out=0.05),
            "two_step",
            ChoiceReason.SUPPORTED,
        ),
        (
            way(0.02, is_lower_bound=True, left_out=0.01),
            way(0.03, left_out=0.04),
            "two_step",
            ChoiceReason.LEFT_OUT,
        ),
        (way(0.050), way(0.051), "two_step", ChoiceReason.SMALLER),
        (way(0.050, 8), way(0.051), "simultaneous", ChoiceReason.MORE_MODELS),
        (way(0.05, n_new=89), way(0.09), "simultaneous", ChoiceReason.MORE_POINTS),
        (
            way(0.05, n_new=89),
            way(0.09, is_lower_bound=True),
            "simultaneous",
            ChoiceReason.MORE_POINTS,
        ),
        (way(0.09), way(0.05, n_new=89), "two_step", ChoiceReason.MORE_POINTS),
        (way(0.05, n_new=89), way(0.11), "two_step", ChoiceReason.SMALLER),
        (way(0.05, n_new=91), way(0.09), "two_step", ChoiceReason.SMALLER),
        (
            way(0.05, n_new=89),
            way(0.5, is_lower_bound=True, knows_wrong_control=True),
            "simultaneous",
            ChoiceReason.WRONG_CONTROL,
        ),
        (way(np.nan), way(0.05), "simultaneous", ChoiceReason.ONLY_FIGURE),
        (way(0.05), way(np.nan), "two_step", ChoiceReason.ONLY_FIGURE),
        # whose figure is the budget, which lacks the same error
        (way(0.05, mean_total=np.nan), way(np.nan), "two_step", "no_figure"),
        (
            way(0.05, left_out=0.06),
            way(np.nan, left_out=0.04),
            "simultaneous",
            ChoiceReason.KNOWN_POINTS,
        ),
        (
            way(0.05, left_out=0.04),
            way(np.nan, left_out=0.06),
            "two_step",
            ChoiceReason.KNOWN_POINTS,
        ),
        (
            way(0.05, left_out=0.06),
            way(np.nan, left_out=0.05),
            "two_step",
            ChoiceReason.ONLY_FIGURE,
        ),
        (
            way(0.05, left_out=0.06),
            way(np.nan, left_out=0.04, keeps_wrong_control=True),
            "two_step",
            ChoiceReason.ONLY_FIGURE,
        ),
        (
            way(0.05, check=[0.06] * 8),
            way(np.nan, check=[-0.04] * 8),
            "simultaneous",
            ChoiceReason.KNOWN_POINTS,
        ),
        (way(0.05, n_new=89), way(np.nan), "simultaneous", "more_points"),
        (way(np.nan), way(np.nan), "two_step", ChoiceReason.NO_FIGURE),
    ],
)
def test_the_better_supported_way_is_taken(two_step, simultaneous, method, reason):
    assert better_of(two_step, simultaneous) == (method, reason)


@pytest.mark.parametrize(
    ("two_step", "simultaneous", "method", "reason"),
    [
        # heights of the way that is better in plan are known to be wrong
        (
            way(0.04, heights=0.5, heights_are_bound=True),
            way(0.055, heights=0.08),
            "simultaneous",
            ChoiceReason.HEIGHTS,
        ),
        (
            way(0.055, heights=0.08),
            way(0.04, heights=0.5, heights_are_bound=True),
            "two_step",
            ChoiceReason.HEIGHTS,
        ),
        # not by much; worse in plan by more; contradicted themselves, or in plan
        (
            way(0.04, heights=0.12, heights_are_bound=True),
            way(0.055, heights=0.08),
            "two_step",
            ChoiceReason.SMALLER,
        ),
        (
            way(0.04, heights=0.5, heights_are_bound=True),
            way(0.6, heights=0.08),
            "two_step",
            ChoiceReason.SMALLER,
        ),
        (
            way(0.04, heights=0.5, heights_are_bound=True),
            way(0.055, heights=0.08, heights_are_bound=True),
            "two_step",
            ChoiceReason.SMALLER,
        ),
        (
            way(0.04, heights=0.5, heights_are_bound=True),
            way(0.055, is_lower_bound=True, heights=0.08),
            "two_step",
            ChoiceReason.SUPPORTED,
        ),
        # control that was left out tells it
        (
            way(0.04, heights=0.3, left_out_heights=[0.4] * 8),
            way(0.055, heights=0.08, left_out_heights=[-0.1] * 8),
            "simultaneous",
            ChoiceReason.HEIGHTS,
        ),
        (
            way(0.04, heights=0.3, left_out_heights=[0.4] * 7),
            way(0.055, heights=0.08, left_out_heights=[-0.1] * 7),
            "two_step",
            ChoiceReason.SMALLER,
        ),
        (
            way(0.04, heights=0.3, left_out_heights=[0.4] * 8),
            way(0.055, heights=0.08, left_out_heights=[-0.3] * 8),
            "two_step",
            ChoiceReason.SMALLER,
        ),
        # the figures in plan say the same
        (
            way(0.05, heights=0.5, heights_are_bound=True),
            way(0.03, heights=0.08),
            "simultaneous",
            ChoiceReason.SMALLER,
        ),
    ],
)
def test_heights_that_are_known_to_be_wrong_count(
    two_step, simultaneous, method, reason
):
    assert better_of(two_step, simultaneous) == (method, reason)


@pytest.mark.slow
def test_given_heights_that_are_wrong_alike_do_not_win_by_their_plan(spatial_block):
    """The antenna height is 50 cm off in all given points beside good control.

    These have so small errors in plan that two steps are better there.
    """
    axes = ("easting", "northing", "height")
    block = beside_control(spatial_block, axes, error=0.02)
    given = block.approximate_points
    given = given.assign(height=given["height"] + 0.5)
    result = densify(replace(block, approximate_points=given), AUTO)
    choice = result.choice
    assert (choice.method, choice.reason) == ("simultaneous", ChoiceReason.HEIGHTS)
    assert choice.two_step.value < choice.simultaneous.value
    assert "much worse" in " ".join(result.summary().split())
    assert not result.assessment.credible_heights.is_lower_bound
    sound = densify(block, AUTO).choice
    assert sound.reason is not ChoiceReason.HEIGHTS


@pytest.mark.slow
def test_a_sound_block_is_adjusted_at_once(demo_block):
    result = densify(demo_block, AUTO)
    expected = densify(demo_block, Settings(method="simultaneous"))
    assert result.choice.method == "simultaneous"
    assert result.choice.two_step.value > result.choice.simultaneous.value
    np.testing.assert_array_equal(result.points[PLANE], expected.points[PLANE])
    assert result.assessment.to_dict()["choice"]["reason"] == "smaller"
    assert "Chosen: simultaneous adjustment" in result.summary()
    assert "method = auto" in result.summary()


@pytest.mark.slow
def test_unstated_errors_of_control_tell_nothing_for_two_steps(demo_block):
    """What a block of control with stated errors would do is done without them."""
    control = demo_block.control_points.drop(columns="standard_error_m")
    block = replace(demo_block, control_points=control)
    auto = densify(block, AUTO)
    assert auto.choice.method == densify(demo_block, AUTO).choice.method
    assert auto.choice.method == "simultaneous"
    assert auto.choice.reason is ChoiceReason.KNOWN_POINTS
    assert "known points that took no part" in " ".join(auto.summary().split())
    told = densify(block, AUTO.updated({"method": "simultaneous"}))
    assert told.assessment.better is None
    assert "--method two_step" not in told.summary()
    # whose figure lacks those errors, and says so
    two_step = densify(block)
    assert two_step.assessment.credible.is_lower_bound
    assert "or worse" in two_step.summary().split("\n")[0]


@pytest.mark.slow
def test_what_only_one_adjustment_needs_stops_nothing(demo_block):
    """Control with errors along one line alone: two steps do not read covariances."""
    control = demo_block.control_points
    along = control["standard_error_m"] ** 2 / 2.0
    control = control.assign(covariance_en=along)
    result = densify(replace(demo_block, control_points=control), AUTO)
    assert result.choice.method == "two_step"
    assert "contradict each other" in result.choice.obstacle


@pytest.mark.slow
def test_a_block_that_one_adjustment_does_not_suit_is_done_in_two_steps(demo_block):
    iterated = densify(demo_block, AUTO.updated({"iterations": 2}))
    assert iterated.choice.reason is ChoiceReason.ONLY_WAY
    assert "Only one method is possible" in iterated.summary()
    geometry = replace(PRESETS["demo"].geometry, transformation="rigid")
    rigid = densify(simulate_block("demo", seed=3, geometry=geometry), AUTO)
    assert rigid.choice.method == "two_step"
    assert "rigid" in rigid.choice.obstacle


def beside(two_step, adjusted, *, is_possible=True):
    """What stands beside one adjustment, as better_beside is asked."""
    whole = SimpleNamespace(is_possible=is_possible)
    adjusted.solution = SimpleNamespace(all_in_two_steps=whole)
    adjusted.all_in_two_steps = two_step
    return better_beside(adjusted)


def test_two_steps_are_named_where_they_are_known_to_be_better():
    better = beside(way(0.05), way(0.03, is_lower_bound=True))
    assert (better.method, better.reason) == ("two_step", ChoiceReason.SUPPORTED)
    assert better.two_step.value == 0.05
    assert beside(way(0.03), way(0.05)).reason is ChoiceReason.SMALLER
    # where both are contradicted, or nothing is known, nothing is recommended
    assert beside(way(0.09, is_lower_bound=True), way(0.1, is_lower_bound=True)) is None
    assert beside(way(np.nan), way(np.nan)) is None
    assert beside(way(0.05), way(0.03)) is None
    assert beside(way(0.03), way(0.05), is_possible=False) is None
    # nor are the two steps by what is not known of the adjustment
    assert beside(way(0.05), way(np.nan)) is None
    known = beside(way(0.05, left_out=0.04), way(np.nan, left_out=0.06))
    assert known.reason is ChoiceReason.KNOWN_POINTS


@pytest.mark.slow
def test_one_adjustment_is_made_beside_two_steps_where_it_may_gain(
    good_result, faulty_result
):
    assert is_untried(good_result.examination)
    better = good_result.assessment.better
    auto = densify(good_result.block, AUTO).choice
    assert (better.method, better.reason) == (auto.method, auto.reason)
    assert better.simultaneous == auto.simultaneous
    assert not is_untried(faulty_result.examination)
    assert adjustment_beside(faulty_result.examination) is None
    assert "--method" not in faulty_result.summary()
    block = good_result.block
    rigid = replace(block.low_flight, transformation="rigid")
    solution = replace(good_result.solution, block=replace(block, low_flight=rigid))
    assert not is_untried(replace(good_result, solution=solution).examination)


def with_own_affinities(block, size):
    """The block with another affinity in each model of both flights."""
    random = np.random.default_rng(7)

    def bent(rows):
        xy = rows[["x", "y"]].to_numpy()
        rows[["x", "y"]] = xy + (xy - xy.mean(axis=0)) @ random.normal(0, size, (2, 2))
        return rows

    flights = {}
    for name, flight in block.flights.items():
        parts = flight.model_points.groupby(["coverage", "model_id"], sort=False)
        points = pd.concat([bent(rows.copy()) for _, rows in parts])
        flights[name] = replace(flight, model_points=points, transformation="helmert")
    return replace(block, **flights)


@pytest.mark.slow
@pytest.mark.parametrize("size", [8e-5, 2e-4])
def test_own_deformations_do_not_keep_the_better_way_back(demo_block, size):
    result = densify(with_own_affinities(demo_block, size))
    assert result.solution.own_deformation is not None
    assert is_untried(result.examination)
    better = result.assessment.better
    auto = densify(result.block, AUTO).choice
    assert (better.method, better.reason) == (auto.method, auto.reason)
    assert better.method == "simultaneous"
    figure = length(better.simultaneous.value)
    told = f"a simultaneous adjustment is better: {figure} (--method simultaneous)"
    assert told in " ".join(result.summary().split())


@pytest.mark.slow
def test_control_beside_approximations_that_are_shifted_is_made_use_of(demo_block):
    """Two steps told "28 cm or worse" of such a block, and no way out."""
    block = beside_control(demo_block)
    points = block.approximate_points.assign(
        easting=lambda given: given["easting"] + 0.36
    )
    result = densify(replace(block, approximate_points=points))
    better = result.assessment.better
    assert result.assessment.credible.is_lower_bound
    assert (better.method, better.reason) == ("simultaneous", ChoiceReason.SUPPORTED)
    figure = length(better.simultaneous.value)
    told = f"a simultaneous adjustment is better: {figure} (--method simultaneous)"
    assert told in " ".join(result.summary().split())
    unstated = block.control_points.drop(columns="standard_error_m")
    held = densify(replace(block, control_points=unstated))
    assert not is_untried(held.examination)


@pytest.fixture(scope="module")
def thin_block():
    """Photographs onto six control points, of which few models show three."""
    return one_flight(seed=1, n_given=6)


@pytest.mark.slow
def test_models_with_too_little_control_are_adjusted_together(thin_block):
    result = densify(thin_block)
    better = result.assessment.better
    assert (better.method, better.reason) == ("simultaneous", ChoiceReason.MORE_POINTS)
    assert better.n_two_step == result.figures.n_new < 40
    assert better.n_simultaneous == 94
    told = f"gives 94 new points: {length(better.simultaneous.value)} (--method simul"
    assert told in " ".join(result.summary().split())
    # each of the models that failed says so as well, unless that was done
    remedies = result.failures["remedy"]
    assert remedies.str.contains("or adjust all models together").all()
    auto = densify(thin_block, AUTO)
    assert not auto.failures["remedy"].str.contains("together").any()
    assert (auto.choice.method, auto.choice.reason) == (better.method, better.reason)
    # here all models were bent as the map before, there those alone that are used
    assert auto.choice.two_step.value == pytest.approx(better.two_step.value, rel=1e-3)
    assert auto.figures.n_new == 94
    assert auto.assessment.to_dict()["choice"]["n_two_step"] == better.n_two_step
    said = " ".join(auto.summary().split())
    assert "leaves many points without coordinates" in said


@pytest.mark.slow
def test_where_no_model_has_enough_control_one_adjustment_is_named():
    thin = one_flight(seed=2, n_given=6)
    with pytest.raises(GeometryError, match="Or adjust all models together"):
        densify(thin)
    choice = densify(thin, AUTO).choice
    assert choice.method == "simultaneous"
    assert "no model of the low flight could be" in choice.obstacle
    assert "together" not in choice.obstacle  # which was done
    # where both fail, neither is recommended in place of the other
    gross = thin.low_flight.image_points.copy()
    gross[["x", "y"]] = np.random.default_rng(1).permutation(gross[["x", "y"]])
    lost = replace(thin, low_flight=replace(thin.low_flight, image_points=gross))
    with pytest.raises(EinschaltError) as caught:
        densify(lost, AUTO)
    assert "method" not in str(caught.value)
    two = thin.control_points[:2], thin.approximate_points[:2]
    with pytest.raises(EinschaltError) as caught:  # which hold nothing, by whatever way
        replace(thin, control_points=two[0], approximate_points=two[1])
    assert "together" not in str(caught.value)


def test_of_a_large_block_one_adjustment_is_only_recommended(good_result, monkeypatch):
    monkeypatch.setattr(displaced_region, "MOST_TRIED", 100)
    assert adjustment_beside(good_result.examination) is None
    told = assess(good_result)
    assert told.is_untried
    assert told.better is None
    assert "--method auto computes both" in lasting_summary(told)


def test_who_does_not_compare_methods_has_the_other_one_recommended(good_result):
    told = assess(replace(good_result, compares_methods=False))
    assert told.is_untried
    assert told.better is None
    assert good_result.assessment.better is not None


def test_nothing_is_recommended_that_cannot_be_computed(good_result, monkeypatch):
    def impossible(*_):
        raise GeometryError("no")

    monkeypatch.setattr(choice, "adjust_beside", impossible)
    assert adjustment_beside(good_result.examination) is None
