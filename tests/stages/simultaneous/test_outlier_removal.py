"""Gross errors are no sizes of errors, and what is taken out spoils nothing."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import einschalt as es
from einschalt.pipeline.simulation.simulate_block import PRESETS
from einschalt.stages.simultaneous import outlier_removal
from einschalt.stages.simultaneous.variance_components import Weighed
from einschalt.theory.block_adjustment.gross_errors import OutlierFreeBlock

PLAN = ["easting", "northing"]
HANDLED = ["snoop", "huber", "tukey"]


@pytest.fixture(scope="module")
def block():
    return es.simulate_block("neukirchen", seed=2)


@pytest.fixture(scope="module")
def clean_rms(block):
    return rms(es.adjust_block(block), block)


@pytest.fixture(scope="module")
def exchanged(block):
    """Two points of a model with each other's names, some hundred metres apart."""
    points = block.low_flight.model_points.copy()
    model = points[["coverage", "model_id"]].iloc[700]
    held = points.index[(points[["coverage", "model_id"]] == model).all(axis=1)]
    pair = held[[0, -1]]
    points.loc[pair, ["x", "y"]] = points.loc[pair[::-1], ["x", "y"]].to_numpy()
    names = set(points.loc[pair, "point_id"])
    return replace(
        block, low_flight=replace(block.low_flight, model_points=points)
    ), names


@pytest.fixture(scope="module")
def displaced(block):
    """Two control points, wrong by a metre and by forty centimetres."""
    control = block.control_points.copy()
    wrong = control.index[control["role"] == "control"][[20, 70]]
    control.loc[wrong, "easting"] += [1.0, 0.0]
    control.loc[wrong, "northing"] += [0.0, -0.4]
    return replace(block, control_points=control), set(control.loc[wrong, "point_id"])


def rms(found, block):
    """Total error of the new points, root mean square [m]."""
    points = found.points[found.points["role"] == "new"].set_index("point_id")
    true = block.truth.set_index("point_id").reindex(points.index)
    return np.sqrt(((points[PLAN] - true[PLAN]) ** 2).sum(axis=1).mean())


def claimed(found):
    """What the new points claim, root mean square [m]."""
    points = found.points[found.points["role"] == "new"]
    errors = points[["standard_error_easting", "standard_error_northing"]]
    return np.sqrt((errors**2).sum(axis=1).mean())


@pytest.mark.slow
@pytest.mark.parametrize("components", ["given", "estimated"])
@pytest.mark.parametrize("outliers", HANDLED)
def test_exchanged_names_cost_their_own_measurements(
    exchanged, clean_rms, outliers, components
):
    wrong, names = exchanged
    found = es.adjust_block(wrong, outliers=outliers, variance_components=components)
    # Tukey's norm uses 95 % of clean observations
    assert rms(found, wrong) < 1.08 * clean_rms
    assert 0.9 < claimed(found) / rms(found, wrong) < 1.1
    suspects = found.residuals[found.residuals["is_suspect"]]
    assert names <= set(suspects["point_id"])
    # two standard errors of the smallest group, the control, are 12 %
    np.testing.assert_allclose(found.components["factor"], 1.0, atol=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("outliers", HANDLED)
def test_wrong_control_is_named_and_set_aside(displaced, clean_rms, outliers):
    wrong, names = displaced
    found = es.adjust_block(wrong, outliers=outliers)
    suspects = found.control[found.control["is_suspect"]].set_index("point_id")
    assert set(suspects.index) == names
    assert suspects["is_set_aside"].all()
    sizes = np.sort(suspects[["strain_easting", "strain_northing"]].abs().max(axis=1))
    np.testing.assert_allclose(sizes, [0.4, 1.0], atol=0.15)
    # the difference is the whole of it, for nothing holds the block there
    moved = suspects[["difference_easting", "difference_northing"]].abs().max(axis=1)
    np.testing.assert_allclose(np.sort(moved), sizes, atol=0.01)
    assert rms(found, wrong) < 1.08 * clean_rms
    assert 0.9 < claimed(found) / rms(found, wrong) < 1.1
    assert "2 of" in found.summary()
    assert "disagree with the block and are set aside" in found.summary()
    given = wrong.control_points.set_index("point_id")["standard_error_m"]
    np.testing.assert_allclose(
        suspects["standard_error_given"], given.reindex(suspects.index)
    )


def test_what_is_kept_is_named_and_takes_part(displaced, clean_rms):
    wrong, names = displaced
    found = es.adjust_block(wrong, outliers="keep")
    suspects = found.control[found.control["is_suspect"]]
    assert names <= set(suspects["point_id"])
    assert not found.control["is_set_aside"].any()
    assert "disagree with the block:" in found.summary()
    assert rms(found, wrong) > 1.3 * clean_rms


def test_given_errors_are_shown_when_others_are_estimated(block):
    found = es.adjust_block(block, variance_components="estimated")
    given = block.control_points.set_index("point_id")["standard_error_m"]
    control = found.control.set_index("point_id")["standard_error_given"]
    np.testing.assert_allclose(control, given.reindex(control.index))


@pytest.mark.slow
def test_kilometres_that_are_kept_make_no_size_of_errors(exchanged):
    wrong, _ = exchanged
    found = es.adjust_block(wrong, outliers="keep", variance_components="estimated")
    assert np.isfinite(found.points["standard_error_easting"]).all()
    assert (found.components["factor"] > 0.5).all()


def with_errors_along_rays(seed):
    """Spatial models, far on one side, whose errors grow with the distance."""
    geometry = replace(
        PRESETS["demo"].geometry,
        transformation="helmert_3d",
        width=2_200.0,
        height=2_200.0,
        point_spacing=90.0,
    )
    block = es.simulate_block("demo", seed=seed, geometry=geometry)
    points = block.low_flight.model_points
    models = points.groupby(["coverage", "model_id"])
    away = points["x"] - models["x"].transform("mean")
    size = 0.01 * np.exp(1.5 * away / away.abs().max())  # mm
    error = size * np.random.default_rng(seed).standard_normal(len(points))
    moved = {axis: points[axis] + k * error for axis, k in RAY.items()}
    return with_points(block, points.assign(**moved))


RAY = {"x": 1.0, "y": 0.5, "z": 1.0}


def with_points(block, points):
    return replace(block, low_flight=replace(block.low_flight, model_points=points))


@pytest.mark.slow
@pytest.mark.parametrize("outliers", ["keep", "snoop"])
def test_errors_along_rays_are_no_gross_errors(outliers):
    """Sixty or seventy were named in each, far points all of them."""
    for seed in range(6):
        block = with_errors_along_rays(seed)
        found = es.adjust_block(block, kind="helmert_3d", outliers=outliers)
        assert found.residuals["is_suspect"].sum() <= 2


@pytest.mark.parametrize("outliers", ["keep", "snoop"])
def test_exchanged_names_of_neighbours_are_found_beside_errors_along_rays(outliers):
    block = with_errors_along_rays(3)
    points = block.low_flight.model_points.copy()
    sizes = points.groupby("model_id")["x"].transform("size")
    held = points[sizes == sizes.max()]
    held = held[held["model_id"] == held["model_id"].iloc[0]]
    middle = (held[["x", "y"]] - held[["x", "y"]].mean()).abs().max(axis=1).idxmin()
    distance = np.linalg.norm(
        held[["x", "y"]] - held.loc[middle, ["x", "y"]].to_numpy(), axis=1
    )
    pair = held.index[distance.argsort()[:2]]
    axes = ["x", "y", "z"]
    points.loc[pair, axes] = points.loc[pair[::-1], axes].to_numpy()
    spoilt = with_points(block, points)
    found = es.adjust_block(spoilt, kind="helmert_3d", outliers=outliers).residuals
    suspects = found[found["is_suspect"]]
    in_model = suspects[suspects["model_id"] == held["model_id"].iloc[0]]
    assert set(points.loc[pair, "point_id"]) <= set(in_model["point_id"])
    if outliers == "snoop":  # kept, they make others look wrong
        assert len(suspects) <= 4


@pytest.mark.parametrize(
    ("found", "last", "n_searches"),
    [
        ("ABABABA", "A", 3),
        ("XABABAB", "B", 5),  # an odd round is left
        ("ABCABCA", "A", 4),
        ("ABCDEFG", "G", 7),  # no circle
    ],
)
def test_circles_of_gross_errors_and_sizes_are_left_out(
    monkeypatch, found, last, n_searches
):
    """Each block was searched six times, though two of the searches told it all."""
    blocks = {
        name: OutlierFreeBlock(None, np.arange(26) == k, np.zeros(3, dtype=bool))
        for k, name in enumerate("ABCDEFGHIJKLMNOPQRSTUVWXYZ")
    }
    searched = []

    def search(*_):
        searched.append(blocks[found[len(searched)]])
        return searched[-1]

    def weigh(tables, part, block, **_):
        other = SimpleNamespace(observations=part.observations)
        return Weighed(other, block, 1.0, None, None)

    monkeypatch.setattr(outlier_removal, "outlier_free_block", search)
    monkeypatch.setattr(outlier_removal, "weigh_groups", weigh)
    monkeypatch.setattr(outlier_removal, "has_images", lambda _: False)
    monkeypatch.setattr(outlier_removal, "judge_of", lambda *_: None)
    part, begun = SimpleNamespace(observations=None), SimpleNamespace()
    begun.readjusted = lambda _: begun
    options = SimpleNamespace(
        outliers="snoop", variance_components="given", significance=0.001
    )
    weighed = outlier_removal.weigh_part(None, part, begun, options)
    assert weighed.block is blocks[last]
    assert len(searched) == n_searches
