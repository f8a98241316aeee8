"""Residuals distributed in triangles, and held-out points of a fit."""

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.stages.held_out_points import DIFFERENCES, held_out_points


def tables(n_points=60, seed=5):
    rng = np.random.default_rng(seed)
    xy = rng.uniform(0.0, 1_000.0, (n_points, 2))
    en = xy + np.array([5e5, 6e6]) + rng.normal(0.0, 0.1, xy.shape)
    names = [f"P{k}" for k in range(n_points)]
    model = pd.DataFrame({"model_id": "1", "point_id": names})
    ground = pd.DataFrame({"point_id": names})
    model[["x", "y"]], ground[["easting", "northing"]] = xy, en
    return model, ground


def without(ground, name):
    return ground[ground["point_id"] != name]


@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_held_out_points_are_those_of_fits_without_them(kind):
    model, ground = tables(8)
    fit = es.transform_models(model, ground, kind)
    held = held_out_points(fit).set_index("point_id")
    for name in ground["point_id"]:
        alone = es.transform_models(model, without(ground, name), kind)
        predicted = alone.transform(model).set_index("point_id").loc[name]
        given = ground.set_index("point_id").loc[name]
        expected = predicted[["easting", "northing"]] - given
        np.testing.assert_allclose(
            held.loc[name, DIFFERENCES].to_numpy(float),
            expected.to_numpy(float),
            atol=1e-7,
        )


def test_points_go_where_they_were_measured_with_the_error_of_held_out_ones():
    model, ground = tables()
    net = es.transform_models(model, ground).distributed()
    moved = net.transform(model)
    plane = ["easting", "northing"]
    np.testing.assert_allclose(moved[plane], ground[plane], atol=1e-8)
    held = net.held_out[DIFFERENCES].to_numpy()
    rms = np.sqrt(np.nanmean((held**2).sum(axis=1)))
    np.testing.assert_allclose(moved["m_t"], rms)
    np.testing.assert_allclose(net.inverse(moved)[["x", "y"]], model[["x", "y"]])


def test_outside_of_the_triangles_there_are_no_coordinates():
    net = es.transform_models(*tables()).distributed()
    far = {"model_id": "1", "point_id": ["Q"], "x": -500.0, "y": 0.0}
    assert net.transform(pd.DataFrame(far))[["easting", "m_t"]].isna().all(axis=None)


def test_points_left_out_are_named_with_what_they_deviate_by():
    model, ground = tables()
    ground.loc[20, "easting"] += 400.0
    net = es.transform_models(model, ground).distributed()
    assert list(net.left_out["point_id"]) == ["P20"]
    assert net.left_out["deviation"].iloc[0] == pytest.approx(400.0, rel=0.02)
    assert "1 point left out" in net.summary()


def test_gross_errors_set_aside_leave_a_figure_that_holds():
    """One point in twenty is wrong by metres; 1000 new points tell how good it is."""
    rng = np.random.default_rng(7)
    n_known, n_new = 2_000, 1_000
    xy = rng.uniform(0.0, 5_000.0, (n_known + n_new, 2))
    strain = 0.3 * np.sin(xy / 700.0)
    en = xy + np.array([5e5, 6e6]) + strain + rng.normal(0.0, 0.03, xy.shape)
    wrong = rng.choice(n_known, n_known // 20, replace=False)
    en[wrong] += rng.choice([-1.0, 1.0], (len(wrong), 2)) * rng.uniform(1.0, 5.0)
    names = [f"P{k}" for k in range(len(xy))]
    model = pd.DataFrame({"model_id": "1", "point_id": names})
    ground = pd.DataFrame({"point_id": names})
    model[["x", "y"]], ground[["easting", "northing"]] = xy, en
    fit = es.transform_models(model[:n_known], ground[:n_known], "helmert")
    net = fit.distributed(outliers="set_aside")
    left_out = net.left_out.set_index("point_id")["reason"]
    assert {f"P{k}" for k in wrong} <= set(left_out.index)
    assert len(left_out) < 1.05 * len(wrong)
    assert left_out.eq("contradicts its neighbours").all()
    moved = net.transform(model[n_known:])
    inside = moved["m_t"].notna()
    misses = moved[["easting", "northing"]].to_numpy() - en[n_known:]
    radius = moved["m_t"] * np.sqrt(-np.log(0.05))
    share = (np.hypot(*misses.T) < radius)[inside].mean()
    assert 0.93 < share < 0.97


def test_triangles_can_be_given_and_must_be_of_identical_points():
    model, ground = tables(4)
    corners = pd.DataFrame({"a": ["P0"], "b": ["P1"], "c": ["P2"]})
    fit = es.transform_models(model, ground)
    net = fit.distributed(corners)
    assert net.triangles[["corner_1", "corner_2", "corner_3"]].to_numpy().tolist() == [
        ["P0", "P1", "P2"]
    ]
    with pytest.raises(es.EinschaltError, match="no identical point"):
        fit.distributed(corners.assign(c="Q"))
    with pytest.raises(es.EinschaltError, match="three, with the names of the corners"):
        fit.distributed(corners[["a"]])


def test_given_triangles_that_are_turned_over_are_refused():
    model, ground = tables()
    fit = es.transform_models(model, ground)
    known = fit.distributed().triangles
    ground.loc[20, "easting"] += 400.0
    with pytest.raises(es.EinschaltError, match="could not be undone"):
        es.transform_models(model, ground).distributed(known)


def test_spatial_transformations_have_no_triangles():
    model, ground = tables(6)
    fit = es.transform_models(
        model.assign(z=np.arange(6.0) ** 2), ground.assign(height=1.0), "helmert_3d"
    )
    with pytest.raises(es.EinschaltError, match="a transformation in plan"):
        fit.distributed()
