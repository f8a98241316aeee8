"""A stretch that models share: of affine models, and of control for other kinds."""

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.evidence.ground.stretch import (
    affinities_onto_control,
    are_negative,
    stretch_of,
)


def surveyed(to_ground, *, n_models=6, n_points=8, noise=0.01, seed=0):
    """Models turned by any angle, and their control points on the ground."""
    rng = np.random.default_rng(seed)
    names = [f"{m}/{k}" for m in range(n_models) for k in range(n_points)]
    true = rng.uniform(-1000.0, 1000.0, (len(names), 2))
    given = true @ np.asarray(to_ground).T + rng.normal(0.0, noise, true.shape)
    angle = np.repeat(rng.uniform(0.0, 6.0, n_models), n_points)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    xy = np.einsum("abn,nb->na", turn, true) / 8.0
    model = np.repeat(np.arange(n_models).astype(str), n_points)
    points = pd.DataFrame({"model_id": model, "coverage": "1", "point_id": names})
    control = pd.DataFrame(given, columns=["easting", "northing"])
    return points.assign(x=xy[:, 0], y=xy[:, 1]), control.assign(
        point_id=names, role="control"
    )


@pytest.mark.parametrize("ratio", [1.01, 0.3048])
def test_models_that_keep_their_shape_show_an_axis_out_of_scale(ratio):
    found = affinities_onto_control(*surveyed(np.diag([ratio, 1.0])))
    stretch = stretch_of(found)
    assert stretch.east_by_north == pytest.approx(ratio, rel=1e-3)
    assert stretch.size == pytest.approx(max(ratio, 1.0 / ratio) - 1.0, rel=0.01)
    assert stretch.p_value < 1e-6
    assert not are_negative(found).any()


def test_control_with_an_axis_of_the_wrong_sign_mirrors_all_of_them():
    found = affinities_onto_control(*surveyed(np.diag([-1.0, 1.0])))
    assert len(found) == 6
    assert are_negative(found).all()
    assert stretch_of(found).size < 1e-3


def test_good_control_is_not_stretched():
    sizes = [
        stretch_of(affinities_onto_control(*surveyed(np.eye(2), seed=seed))).p_value
        for seed in range(40)
    ]
    assert min(sizes) > 0.001


def test_what_one_wrong_point_makes_of_its_models_is_not_common():
    points, control = surveyed(np.eye(2), n_models=8)
    is_near = control["point_id"].str.startswith(("0/", "1/"))
    control.loc[is_near, "easting"] *= 1.2
    found = stretch_of(affinities_onto_control(points, control))
    assert found.size < 0.001


def surveyed_in_space(to_ground, tilt, *, relief=60.0, n_models=6, n_points=8, seed=0):
    """Models of photographs tilted alike, each flown in another direction."""
    points, control = surveyed(to_ground, n_models=n_models, n_points=n_points)
    rng = np.random.default_rng(seed)
    height = rng.uniform(-relief, relief, len(points))
    noise = rng.normal(0.0, 0.02, len(points))
    y, z = points["y"], (height + noise) / 8.0
    points["y"] = np.cos(tilt) * y - np.sin(tilt) * z
    points["z"] = np.sin(tilt) * y + np.cos(tilt) * z
    return points, control.assign(height=height)


@pytest.mark.parametrize("relief", [0.0, 60.0])
@pytest.mark.parametrize("tilt", [0.0, 0.7])
def test_tilted_models_are_not_stretched(tilt, relief):
    """x and y of models as they were formed are shorter across the tilt."""
    given = surveyed_in_space(np.eye(2), tilt, relief=relief)
    if tilt:
        standing = affinities_onto_control(*given)
        assert stretch_of(standing).size > 0.2
        assert stretch_of(standing).p_value < 1e-3
    found = affinities_onto_control(*given, is_turned=True)
    assert len(found) == 6
    assert stretch_of(found).size < 1e-3


@pytest.mark.parametrize("ratio", [1.01, 0.3048])
def test_an_axis_out_of_scale_shows_in_tilted_models(ratio):
    given = surveyed_in_space(np.diag([ratio, 1.0]), 0.7)
    found = stretch_of(affinities_onto_control(*given, is_turned=True))
    assert found.east_by_north == pytest.approx(ratio, rel=0.02)
    assert found.p_value < 1e-3


def test_control_without_heights_turns_no_model():
    points, control = surveyed_in_space(np.eye(2), 0.7)
    control.loc[control["point_id"].str.startswith("0/"), "height"] = np.nan
    found = affinities_onto_control(points, control, is_turned=True)
    assert len(found) == 5
    assert stretch_of(found).size < 1e-3


def test_points_on_a_line_tell_nothing():
    points, control = surveyed(np.eye(2))
    points["y"] = 0.5 * points["x"]
    assert affinities_onto_control(points, control).empty
