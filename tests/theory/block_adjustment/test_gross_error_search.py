"""Gross errors that least squares shrink a whole block to are found all the same."""

from dataclasses import replace

import numpy as np
import pytest
from tests.truth.disturbed_blocks import with_grouped_control

import einschalt as es
from einschalt.pipeline.simulation.simulate_block import PRESETS
from einschalt.theory.block_adjustment import gross_error_search, gross_errors
from einschalt.theory.block_adjustment.spatial_solution import _Task

KINDS = ["affine", "helmert", "helmert_3d"]
PLAN = ["easting", "northing"]
KEY = ["coverage", "model_id", "point_id"]


def demo(kind, seed):
    geometry = replace(PRESETS["demo"].geometry, transformation=kind)
    return es.simulate_block("demo", seed=seed, geometry=geometry)


def with_poor_control(block, size_m, seed):
    """Control with further independent errors, stated, TOTAL [m]."""
    control = block.control_points.copy()
    is_control = (control["role"] != "check").to_numpy()
    rng = np.random.default_rng(seed)
    for axis in PLAN:
        errors = rng.normal(0.0, size_m / np.sqrt(2.0), len(control))
        control[axis] += np.where(is_control, errors, 0.0)
    own = control["standard_error_m"]
    stated = np.where(is_control, np.hypot(own, size_m), own)
    return replace(block, control_points=control.assign(standard_error_m=stated))


def with_exchanged_names(block, n_models):
    """First and last point of the largest low models under each other's name.

    Of six points that an affine model is fitted to, nobody knows which two are wrong.
    """
    points = block.low_flight.model_points.copy()
    models = points.groupby(KEY[:2]).size().sort_values(kind="stable").index
    wrong = []
    for model in models[-n_models:]:
        rows = points.index[(points[KEY[:2]] == list(model)).all(axis=1)]
        pair = rows[[0, -1]]
        points.loc[pair, "point_id"] = points.loc[pair[::-1], "point_id"].to_numpy()
        wrong += list(map(tuple, points.loc[pair, KEY].to_numpy()))
    low = replace(block.low_flight, model_points=points)
    return replace(block, low_flight=low), set(wrong)


def error_over_claim(adjusted, block):
    """Root mean square of true errors over that of the claimed ones."""
    points = adjusted.points.set_index("point_id")
    truth = block.truth.set_index("point_id").loc[points.index, PLAN]
    true = np.square(points[PLAN] - truth).sum(axis=1).mean()
    return float(np.sqrt(true / np.square(points["standard_error_total"]).mean()))


def suspects(adjusted):
    residuals = adjusted.residuals
    rows = residuals.loc[residuals["is_suspect"], KEY]
    return set(map(tuple, rows.to_numpy()))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("outliers", ["snoop", "huber", "tukey"])
def test_exchanged_names_beside_control_of_half_a_metre(kind, outliers):
    """Least squares shrink the block by a third: it was wrong by up to 1.8 km."""
    block, wrong = with_exchanged_names(with_poor_control(demo(kind, 3), 0.5, 3), 5)
    adjusted = es.adjust_block(block, kind=kind, outliers=outliers)
    assert adjusted.failures.empty
    assert 0.5 < error_over_claim(adjusted, block) < 1.5
    assert suspects(adjusted) == wrong


def test_what_is_kept_stays_in_the_adjustment():
    block, _ = with_exchanged_names(with_poor_control(demo("helmert", 3), 0.5, 3), 5)
    adjusted = es.adjust_block(block, kind="helmert")
    assert adjusted.s_0 > 100.0
    assert error_over_claim(adjusted, block) > 100.0


def test_wrong_control_is_still_what_is_wrong():
    block = demo("helmert", 5)
    control = block.control_points.copy()
    rows = control.index[control["role"] != "check"][[1, 6]]
    control.loc[rows, "easting"] += [300.0, -80.0]
    adjusted = es.adjust_block(
        replace(block, control_points=control), kind="helmert", outliers="snoop"
    )
    found = adjusted.control.loc[adjusted.control["is_suspect"], "point_id"]
    assert set(found) == set(control.loc[rows, "point_id"])
    assert not suspects(adjusted)
    assert 0.5 < error_over_claim(adjusted, block) < 1.5


@pytest.mark.parametrize("size_m", [0.0, 0.5])
def test_exchanged_control_places_no_spatial_block(size_m):
    """It ended without a result, or with good models given up for wrong control."""
    block = with_poor_control(demo("helmert_3d", 1), size_m, 1)
    control = block.control_points.copy()
    rows = control.index[control["role"] != "check"]
    axes = [*PLAN, "height"]
    wrong, right = rows[[0, 5, 3, 9]], rows[[5, 0, 9, 3]]
    control.loc[wrong, axes] = control.loc[right, axes].to_numpy()
    adjusted = es.adjust_block(
        replace(block, control_points=control), kind="helmert_3d", outliers="snoop"
    )
    assert adjusted.failures.empty
    found = adjusted.control.loc[adjusted.control["is_suspect"], "point_id"]
    assert set(found) == set(control.loc[wrong, "point_id"])
    assert 0.4 < error_over_claim(adjusted, block) < 1.5


def test_a_search_in_space_is_rough_and_ends_with_every_digit(monkeypatch):
    """Hundreds of steps took a pass for each of seven digits."""
    block = demo("helmert_3d", 3)
    points = block.low_flight.model_points.copy()
    wrong = points.index[20::40]
    points.loc[wrong, "x"] += 0.5
    low = replace(block.low_flight, model_points=points)
    n_passes, steps, ends = [], [], []
    one_pass, without, take_out = (
        _Task._pass,
        gross_errors._without,
        gross_error_search.take_out,
    )

    def counted(*given, **named):
        n_passes.append(1)
        return one_pass(*given, **named)

    def step(solution, *given, **named):
        before = len(n_passes)
        found = without(solution, *given, **named)
        steps.append(len(n_passes) - before)
        return found

    def search(begun, given, *how):
        found = take_out(begun, given, *how)
        ends.append((found, found.readjusted(given)))
        return found

    monkeypatch.setattr(_Task, "_pass", counted)
    monkeypatch.setattr(gross_errors, "_without", step)
    monkeypatch.setattr(gross_error_search, "take_out", search)
    adjusted = es.adjust_block(
        replace(block, low_flight=low), kind="helmert_3d", outliers="snoop"
    )
    found = set(map(tuple, points.loc[wrong, KEY].to_numpy()))
    # of two measurements of a point nothing may tell which one is wrong
    assert len(found - suspects(adjusted)) <= 2
    for found, exact in ends:
        away = found.solution.points - exact.solution.points
        assert np.abs(away).max() < 1e-6
    # 5.8 with every digit in every step
    assert len(steps) > 5
    assert np.mean(steps) < 4.5


def test_gross_errors_make_no_shifts_of_groups():
    """A size of 780 m was found, and then no model that is determined."""
    block = with_grouped_control(demo("helmert_3d", 4), 0.1, 4, is_stated=False)
    points = block.low_flight.model_points.copy()
    rows = points.index[[40, 130, 230, 320]]
    points.loc[rows, "x"] += 20.0  # 160 m
    low = replace(block.low_flight, model_points=points)
    adjusted = es.adjust_block(
        replace(block, low_flight=low), kind="helmert_3d", outliers="snoop"
    )
    assert adjusted.failures.empty
    assert set(map(tuple, points.loc[rows, KEY].to_numpy())) <= suspects(adjusted)
    clean = es.adjust_block(block, kind="helmert_3d", outliers="snoop")
    both = (
        np.sqrt(np.square(each.points["standard_error_total"]).mean())
        for each in (adjusted, clean)
    )
    assert next(both) == pytest.approx(next(both), rel=0.25)


def test_a_model_that_shrinks_beside_kept_names_lacks_no_points():
    block = with_poor_control(demo("helmert_3d", 3), 3.0, 3)
    block, _ = with_exchanged_names(block, 1)
    adjusted = es.adjust_block(block, kind="helmert_3d")
    assert adjusted.failures["reason"].str.contains("contradict").all()
    assert len(adjusted.failures) == 1
