"""Control of spatial blocks that is known in plan alone, or in height alone."""

from dataclasses import replace

import numpy as np
import pytest
from tests.photographs_onto_control import one_flight

import einschalt as es
from einschalt.foundations.errors import EinschaltError
from einschalt.pipeline.assessment.evidence.control.larger_errors import (
    larger_control_errors,
)
from einschalt.pipeline.simulation.simulate_block import PRESETS

SPATIAL = replace(PRESETS["demo"].geometry, transformation="helmert_3d")
PLAN = ["easting", "northing"]
SIMULTANEOUS = es.Settings(method="simultaneous")
ROUGH = 3.0  # standard error where a coordinate is hardly known [m]


def simulated(seed=2):
    """A block without check points."""
    block = es.simulate_block("demo", seed=seed, geometry=SPATIAL)
    control = block.control_points
    control = control[control["role"] == "control"].reset_index(drop=True)
    return replace(block, control_points=control)


@pytest.fixture(scope="module")
def block():
    return simulated()


def some_in_plan(block, every=2):
    """Every second control point without its height, with its name."""
    control = block.control_points
    is_flat = np.arange(len(control)) % every == 0
    names = control["point_id"][is_flat]
    height = control["height"].mask(is_flat)
    return replace(block, control_points=control.assign(height=height)), list(names)


def errors_in_plan(result, block):
    new = result.points[result.points["role"] == "new"]
    true = block.truth.set_index("point_id").loc[new["point_id"], PLAN]
    return new[PLAN].to_numpy() - true.to_numpy()


def test_points_without_heights_hold_the_adjustment_in_plan(block):
    """As points do whose heights are hardly known."""
    flat, names = some_in_plan(block)
    adjusted = es.adjust_block(flat, kind="helmert_3d")
    control = block.control_points
    is_flat = control["point_id"].isin(names)
    own = control["standard_error_m"] / np.sqrt(2.0)
    # the largest one that may be stated
    rough = control.assign(standard_error_height=np.where(is_flat, 10.0, own))
    loose = es.adjust_block(replace(block, control_points=rough), kind="helmert_3d")
    columns = [*PLAN, "height", "standard_error_total", "standard_error_height"]
    np.testing.assert_allclose(
        adjusted.points[columns], loose.points[columns], rtol=0, atol=1e-4
    )
    # a height that is not given is no observation
    assert adjusted.redundancy == loose.redundancy - len(names)
    without = control[~is_flat].reset_index(drop=True)
    fewer = es.adjust_block(replace(block, control_points=without), kind="helmert_3d")
    assert adjusted.redundancy == fewer.redundancy + 2 * len(names)


def test_nothing_is_said_of_heights_that_are_not_given(block):
    flat, names = some_in_plan(block)
    result = es.densify(flat, SIMULTANEOUS)
    points = result.points.set_index("point_id").loc[names]
    assert (points["role"] == "control").all()
    assert points["difference_height"].isna().all()
    assert points[["difference_easting", "height"]].notna().all(axis=None)
    control = es.adjust_block(flat, kind="helmert_3d").control.set_index("point_id")
    assert control.loc[names, "difference_height"].isna().all()
    assert control.loc[names, "strain_height"].isna().all()
    assert control.loc[names, ["w", "p_value", "strain_easting"]].notna().all(axis=None)
    others = control.drop(names)
    assert others[["difference_height", "strain_height"]].notna().all(axis=None)


def test_a_wrong_point_without_a_height_is_named(block):
    flat, names = some_in_plan(block)
    control = flat.control_points
    is_wrong = (control["point_id"] == names[3]).to_numpy()
    moved = control.assign(northing=control["northing"] + 0.6 * is_wrong)
    adjusted = es.adjust_block(replace(flat, control_points=moved), kind="helmert_3d")
    found = adjusted.control.set_index("point_id")
    assert list(found.index[found["is_suspect"]]) == [names[3]]
    assert found.loc[names[3], "strain_northing"] == pytest.approx(0.6, abs=0.15)
    told = es.densify(replace(flat, control_points=moved), SIMULTANEOUS)
    (finding,) = (
        f for f in told.assessment.findings if f.code == "control_against_block"
    )
    plan = found.loc[names[3], ["strain_easting", "strain_northing"]]
    assert finding.facts["largest"] == pytest.approx(np.hypot(*plan))


def test_errors_that_are_larger_than_stated_are_measured_by_what_is_given(block):
    flat, names = some_in_plan(block)
    control = flat.control_points
    rng = np.random.default_rng(3)
    moved = control.assign(
        **{name: control[name] + rng.normal(0.0, 0.08, len(control)) for name in PLAN}
    )
    examined = es.densify(replace(flat, control_points=moved), SIMULTANEOUS).examination
    examined.adjustment.control["is_suspect"] = False
    found = larger_control_errors(examined)
    w = examined.adjustment.control.set_index("point_id")["w"]
    n_axes = np.where(w.index.isin(names), 2, 3)[w.notna()]
    assert found.factor == pytest.approx(np.sqrt((w**2).sum() / n_axes.sum()))


def test_control_that_is_held_is_held_in_plan(block):
    flat, names = some_in_plan(block)
    given = flat.control_points.drop(columns="standard_error_m")
    held = es.adjust_block(replace(flat, control_points=given), kind="helmert_3d")
    points = held.points.set_index("point_id")
    known = given.set_index("point_id")
    np.testing.assert_allclose(
        points.loc[names, PLAN], known.loc[names, PLAN], rtol=0, atol=1e-9
    )
    assert (points.loc[names, "standard_error_height"] > 0.0).all()
    assert (
        points.loc[known.index.difference(names), "standard_error_height"] == 0
    ).all()


def test_two_steps_compare_them_as_check_points_and_name_them(block):
    flat, names = some_in_plan(block)
    result = es.densify(flat, es.Settings(method="two_step"))
    points = result.points.set_index("point_id")
    assert set(points.index[points["role"] == "check"]) == set(names)
    assert points.loc[names, PLAN].notna().all(axis=None)
    assert result.figures.n_check == len(names)
    known = block.control_points.set_index("point_id").loc[names]
    missed = points.loc[names, PLAN].to_numpy() - known[PLAN].to_numpy()
    rms = np.sqrt(np.mean((missed**2).sum(axis=1)))
    assert result.figures.check_rms == pytest.approx(rms)
    said = f"{len(names)} of {len(block.control_points)} control points have no height"
    assert said in " ".join(str(result).split())
    assert [note for note in flat.notes if said in note]
    plain = es.densify(block, es.Settings(method="two_step"))
    assert "have no height" not in str(plain)
    assert set(plain.points["role"]) == {"new", "control"}


def test_models_of_one_flight_are_fitted_onto_the_others():
    block = one_flight(1, n_given=16)
    flat, names = some_in_plan(block)
    approximate = flat.control_points[["point_id", *PLAN, "height"]]
    flat = replace(flat, approximate_points=approximate)
    assert "8 of 16 control points have no height" in flat.notes[0]
    points = es.densify(flat, es.Settings(method="two_step")).points
    checks = points.loc[points["role"] == "check", "point_id"]
    assert len(checks) > 3
    assert set(checks) <= set(names)
    adjusted = es.densify(flat, SIMULTANEOUS).points
    assert set(adjusted["role"]) == {"new", "control"}


def test_a_missing_height_needs_no_standard_error(block):
    flat, names = some_in_plan(block)
    control = flat.control_points
    is_flat = control["point_id"].isin(names)
    stated = control.assign(standard_error_height=np.where(is_flat, np.nan, 0.05))
    points = es.densify(replace(flat, control_points=stated), SIMULTANEOUS).points
    assert len(points)
    lost = stated.assign(standard_error_height=np.where(is_flat, 0.05, np.nan))
    with pytest.raises(EinschaltError, match="standard_error_height is missing"):
        replace(flat, control_points=lost)


def test_a_point_of_height_alone_is_asked_for_rough_coordinates(block):
    control = block.control_points
    easting = control["easting"].mask(np.arange(len(control)) == 2)
    with pytest.raises(EinschaltError, match=r"easting is missing.*rough coordinates"):
        replace(block, control_points=control.assign(easting=easting))


@pytest.mark.slow
def test_plan_control_apart_from_height_control_is_as_good_as_claimed():
    """Where one third is known in plan, and another one in height."""
    squares, height_squares = [], []
    for seed in range(8):
        block = simulated(seed)
        control, rng = block.control_points, np.random.default_rng(seed)
        third = np.arange(len(control)) % 3
        off = rng.normal(0.0, ROUGH / np.sqrt(2.0), (len(control), 2))
        error = control["standard_error_m"].to_numpy()
        rough = control.assign(
            height=control["height"].mask(third == 0),
            standard_error_m=np.where(third == 1, ROUGH, error),
            standard_error_height=np.where(third == 0, np.nan, error / np.sqrt(2.0)),
            **{
                name: control[name] + off[:, k] * (third == 1)
                for k, name in enumerate(PLAN)
            },
        )
        result = es.densify(replace(block, control_points=rough), SIMULTANEOUS)
        new = result.points[result.points["role"] == "new"]
        missed = errors_in_plan(result, block)
        claimed = new["standard_error_total"].to_numpy() ** 2
        squares.append((missed**2).sum() / claimed.sum())
        true = block.truth.set_index("point_id").loc[new["point_id"], "height"]
        away = new["height"].to_numpy() - true.to_numpy()
        height_squares.append(
            (away**2).sum() / (new["standard_error_height"] ** 2).sum()
        )
    assert 0.7 < np.mean(squares) < 1.3
    assert 0.7 < np.mean(height_squares) < 1.3
