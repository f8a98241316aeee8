"""Exchanged names are found where they are, and nowhere else."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.credibility import Reason
from einschalt.pipeline.assessment.evidence.exchanged_names import (
    find_exchanged_names,
    put_measured_names_right,
)
from einschalt.pipeline.assessment.evidence.names import exchange_trials
from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block


def with_exchange(block, flight, model, pair):
    """The block, two points of one model of a flight under each other's name."""
    measured = getattr(block, flight)
    points = measured.model_points.copy()
    is_model = (points["coverage"] == model[0]) & (points["model_id"] == model[1])
    rows = points.index[is_model & points["point_id"].isin(pair)]
    points.loc[rows, "point_id"] = points.loc[rows, "point_id"].to_numpy()[::-1]
    return replace(block, **{flight: replace(measured, model_points=points)})


def some_model(block, flight, rng):
    """A model of at least five points known on the ground, and two of these."""
    points = getattr(block, flight).model_points
    if flight == "high_flight":
        control = block.control_points.query("role == 'control'")["point_id"]
        points = points[points["point_id"].isin(control)]
    models = points.groupby(["coverage", "model_id"])["point_id"].agg(list)
    models = models[models.map(len) >= 5]
    model = models.index[rng.integers(len(models))]
    return model, tuple(rng.choice(models[model], 2, replace=False))


@pytest.mark.slow
@pytest.mark.parametrize("outliers", ["keep", "snoop"])
def test_a_pair_in_the_low_flight_is_named(demo_block, outliers):
    rng = np.random.default_rng(5)
    for _ in range(3):
        model, pair = some_model(demo_block, "low_flight", rng)
        block = with_exchange(demo_block, "low_flight", model, pair)
        settings = block.settings.updated({"outliers": outliers})
        found = find_exchanged_names(densify(block, settings).solution)
        assert len(found) == 1
        exchange = found[0]
        assert (exchange.coverage, exchange.model_id) == model
        assert set(exchange.points) == set(pair)
        # the other models of the demo block have some centimetres
        assert exchange.m_0_exchanged < 0.3 < exchange.m_0
        truth = demo_block.truth.set_index("point_id").loc[list(pair)]
        apart = np.hypot(*np.diff(truth[["easting", "northing"]].to_numpy(), axis=0)[0])
        assert exchange.apart == pytest.approx(apart, abs=0.5)


def test_a_pair_in_the_high_flight_is_named():
    block = simulate_block("neukirchen", seed=3)
    model, pair = some_model(block, "high_flight", np.random.default_rng(1))
    changed = with_exchange(block, "high_flight", model, pair)
    found = find_exchanged_names(densify(changed).solution)
    assert [(e.flight, e.coverage, e.model_id) for e in found] == [
        ("high_flight", *model)
    ]
    assert set(found[0].points) == set(pair)


@pytest.mark.slow
def test_control_exchanged_with_a_new_point_is_named(demo_block):
    # the new point is not known on the ground of the high flight
    points = demo_block.high_flight.model_points
    model = tuple(points.loc[points.index[0], ["coverage", "model_id"]])
    is_model = (points["coverage"] == model[0]) & (points["model_id"] == model[1])
    is_known = points["point_id"].isin(demo_block.control_points["point_id"])
    names = points["point_id"]
    pair = (names[is_model & is_known].iloc[0], names[is_model & ~is_known].iloc[0])
    block = with_exchange(demo_block, "high_flight", model, pair)
    result = densify(block, block.settings.updated({"outliers": "snoop"}))
    (exchange,) = find_exchanged_names(result.solution)
    assert set(exchange.points) == set(pair)
    assert "Exchanged names" in result.summary()


def test_good_blocks_and_other_gross_errors_have_none(demo_block, good_result):
    assert find_exchanged_names(good_result.solution) == ()
    flight = demo_block.low_flight
    points = flight.model_points.copy()
    points.loc[points.index[40], "x"] += 5.0  # 40 m on the ground
    wrong = replace(demo_block, low_flight=replace(flight, model_points=points))
    result = densify(wrong)
    assert result.residuals["is_suspect"].any()
    assert find_exchanged_names(result.solution) == ()


@pytest.mark.slow
def test_trials_part_by_part_find_the_same(demo_block, monkeypatch):
    model, pair = some_model(demo_block, "low_flight", np.random.default_rng(7))
    solution = densify(with_exchange(demo_block, "low_flight", model, pair)).solution
    whole = find_exchanged_names(solution)
    monkeypatch.setattr(exchange_trials, "MOST_ROWS", 1)  # each trial by itself
    assert find_exchanged_names(solution) == whole != ()


def test_a_model_of_which_nothing_is_known_disturbs_no_other():
    trials = exchange_trials.Trials.of(
        pd.DataFrame(
            {"coverage": "1", "model_id": ["a", "a", "b"], "point_id": ["1", "2", "9"]}
        )
    )
    measured = pd.DataFrame({"coverage": "1", "model_id": list("aaab")})
    measured = measured.assign(point_id=["1", "2", "3", "9"], x=[0.0, 1, 0, 1])
    measured = measured.assign(y=[0.0, 0, 1, 1])
    ground = pd.DataFrame({"point_id": ["1", "2", "3"], "easting": [0.0, 1, 0]})
    before, after = trials.m_0(measured, ground.assign(northing=[0.0, 0, 1]), "helmert")
    assert trials.pairs.tolist() == [["1", "2"]]
    assert before == pytest.approx([0.0], abs=1e-9)
    assert after[0] > 0.1


def exchanged_in(flight, kind, settings, seed=2):
    """A block of models of a kind with a pair in one model, densified, and the pair."""
    geometry = BlockGeometry(width=3e3, height=3e3, transformation=kind, n_check=0)
    block = simulate_block("demo", seed=seed, geometry=geometry)
    model, pair = some_model(block, flight, np.random.default_rng(seed))
    return densify(with_exchange(block, flight, model, pair), settings), set(pair)


def true_error(result):
    """Of the new points in plan, TOTAL, RMS [m]."""
    plan = ["easting", "northing"]
    new = result.points[result.points["role"] == "new"].set_index("point_id")[plan]
    true = result.block.truth.set_index("point_id").loc[new.index, plan]
    return float(np.sqrt(np.mean(np.sum((new - true) ** 2, axis=1))))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("flight", "kind", "method"),
    [
        ("high_flight", "affine", "two_step"),
        ("high_flight", "helmert", "simultaneous"),
        ("high_flight", "helmert_3d", "two_step"),
        ("low_flight", "affine", "simultaneous"),
    ],
)
def test_what_names_in_one_model_do_is_told(flight, kind, method):
    """28 km were told for 200 m, with models upside down as the cause."""
    result, pair = exchanged_in(flight, kind, Settings(method=method))
    judged, true = result.assessment, true_error(result)
    assert judged.credible.reason is Reason.EXCHANGED_NAMES
    assert judged.credible.is_lower_bound
    assert true > 1.0
    assert judged.credible.value == pytest.approx(true, rel=0.01)
    first, *others = judged.findings
    assert first.code == "exchanged_names"
    assert set(first.names) == pair
    follow = [found.explained_by for found in others if found.gravity is Gravity.GRAVE]
    assert follow
    assert set(follow) == {"exchanged_names"}


def mixed(block, flight, way, seed):
    """The block, names of one model mixed in a way, and those that are wrong then."""
    (coverage, model_id), _ = some_model(block, flight, np.random.default_rng(seed))
    measured = getattr(block, flight)
    points = measured.model_points.copy()
    is_its = (points["coverage"] == coverage) & (points["model_id"] == model_id)
    rows = points.index[is_its]
    if way != "slip":
        control = block.control_points.query("role == 'control'")["point_id"]
        is_tried = points.loc[rows, "point_id"].isin(control) | (flight == "low_flight")
        rows = rows[is_tried][:4] if way == "two pairs" else rows[is_tried][1:4]
    names = points.loc[rows, "point_id"].to_numpy()
    order = [1, 0, 3, 2] if way == "two pairs" else np.roll(np.arange(len(names)), 1)
    points.loc[rows, "point_id"] = names[order]
    wrong = replace(block, **{flight: replace(measured, model_points=points)})
    return wrong, dict(zip(names, names[order], strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("flight", ["high_flight", "low_flight"])
@pytest.mark.parametrize("way", ["two pairs", "round", "slip"])
def test_more_names_than_a_pair_are_put_right(demo_block, flight, way):
    """0.9 to 16 times the true error was told, and gross errors as the cause."""
    block, measured_as = mixed(demo_block, flight, way, seed=4)
    result = densify(block, block.settings.updated({"outliers": "keep"}))
    (exchange,) = result.examination.exchanged_names
    found = zip(exchange.points, exchange.measured_as, strict=True)
    assert dict(found) == measured_as
    assert exchange.is_slip == (way == "slip")
    told, true = result.assessment.credible, true_error(result)
    assert told.reason is Reason.EXCHANGED_NAMES
    assert true > 1.0
    assert told.value == pytest.approx(true, rel=0.01)
    first, *others = result.assessment.findings
    assert first.code == "exchanged_names"
    assert set(first.names) == set(measured_as)
    grave = [found for found in others if found.gravity is Gravity.GRAVE]
    assert {found.explained_by for found in grave} == {"exchanged_names"}


@pytest.mark.parametrize("flight", ["high_flight", "low_flight"])
def test_a_point_that_is_off_is_no_mixture_of_names(demo_block, flight):
    measured = getattr(demo_block, flight)
    points, kind = measured.model_points.copy(), measured.transformation
    control = demo_block.control_points.query("role == 'control'")
    is_known = points["point_id"].isin(control["point_id"])
    points.loc[points.index[is_known][1], ["x", "y"]] += 8.0
    block = replace(demo_block, **{flight: replace(measured, model_points=points)})
    solution = densify(
        block, demo_block.settings.updated({"outliers": "keep"})
    ).solution
    fits = solution.first_models(flight)
    assert kind == "affine"
    assert fits["m_0"].max() > 20.0 * fits["m_0"].median()  # it is looked at
    assert find_exchanged_names(solution) == ()


@pytest.mark.slow
def test_names_that_were_taken_out_move_nothing():
    settings = Settings(method="simultaneous", outliers="snoop")
    result, _ = exchanged_in("high_flight", "affine", settings)
    told = result.examination.credible
    assert result.examination.measured_names.moved.plan == 0.0
    assert told.reason is Reason.EXCHANGED_NAMES
    assert not told.is_lower_bound
    assert 0.8 < told.value / true_error(result) < 1.25


def test_names_of_photographs_are_not_put_right_behind_their_orientation():
    geometry = BlockGeometry(width=3e3, height=3e3, measurement="images", n_check=0)
    block = simulate_block("demo", seed=2, geometry=geometry)
    examined = densify(block).examination
    exchange = SimpleNamespace(flight="low_flight")
    vars(examined)["exchanged_names"] = (exchange,)
    assert put_measured_names_right(examined) is None


def crossed(block, flight, pair):
    """A pair exchanged in all models of a flight that hold both, and their number."""
    measured = getattr(block, flight)
    points = measured.model_points.copy()
    held = points[points["point_id"].isin(pair)].groupby(["coverage", "model_id"])
    models = [model for model, rows in held if len(rows) == 2]
    for model in models:
        block = with_exchange(block, flight, model, pair)
    return block, len(models)


@pytest.mark.slow
@pytest.mark.parametrize("outliers", ["keep", "snoop"])
@pytest.mark.parametrize(
    ("seed", "pair"), [(1, ("1032", "1046")), (2, ("1042", "1053"))]
)
def test_new_points_exchanged_in_the_high_flight_are_put_right_there(
    seed, pair, outliers
):
    """95 to 169 m were told for 3 cm where snooping had taken all of it out."""
    block = simulate_block("demo", seed=seed)
    block, n_models = crossed(block, "high_flight", pair)
    result = densify(block, block.settings.updated({"outliers": outliers}))
    found = result.examination.exchanged_names
    assert {(e.flight, *sorted(e.points)) for e in found} == {("high_flight", *pair)}
    assert len(found) == n_models > 1
    told, true = result.assessment.credible, true_error(result)
    assert told.reason is Reason.EXCHANGED_NAMES
    assert told.is_lower_bound == (outliers == "keep")
    assert 0.75 < told.value / true < 1.25
    first = result.assessment.findings[0]
    assert first.code == "exchanged_names"
    assert first.remedy == "put_the_names_right"
    assert "from where the other flight has them" in result.summary()


@pytest.mark.slow
def test_given_coordinates_tell_that_the_low_flight_is_wrong():
    pair = ("1043", "1053")
    block = simulate_block("demo", seed=2)
    assert "1043" in set(block.control_points["point_id"])
    block, n_models = crossed(block, "low_flight", pair)
    result = densify(block, block.settings.updated({"outliers": "snoop"}))
    found = result.examination.exchanged_names
    assert {e.flight for e in found} == {"low_flight"}
    assert len(found) == n_models > 1
    assert not any(e.is_everywhere for e in found)
    true = true_error(result)
    assert true > 1.0
    assert result.assessment.credible.value == pytest.approx(true, rel=0.01)


@pytest.mark.slow
def test_both_flights_are_compared_where_nothing_tells_which_is_wrong():
    """One model of the low flight holds both, and several one of them: all agree."""
    pair = ("1036", "1045")
    geometry = replace(PRESETS["demo"].geometry, transformation="helmert")
    block = simulate_block("demo", seed=3, geometry=geometry)
    block, n_models = crossed(block, "high_flight", pair)
    assert n_models == 5
    judged = densify(block, block.settings.updated({"outliers": "snoop"})).assessment
    first = judged.findings[0]
    assert first.code == "exchanged_names"
    assert first.remedy == "compare_names_of_both_flights"
    assert judged.credible.is_lower_bound
