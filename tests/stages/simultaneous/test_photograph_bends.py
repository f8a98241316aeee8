"""Photographs that are bent, each in its own way: found, and in the standard errors."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import BlockGeometry, simulate_block

GROUND = ["easting", "northing", "height"]
GEOMETRY = BlockGeometry(
    width=2_200.0,
    height=2_200.0,
    point_spacing=110.0,
    measurement="images",
    transformation="helmert_3d",
    control_per_model=9,
)
SIZE_UM = 10.0
SLOW = pytest.mark.slow


def bent_block(seed, size_um, geometry=GEOMETRY):
    """A simulated block with photographs bent by terms of second and third degree."""
    block = simulate_block("demo", seed=seed, geometry=geometry)
    low, rng = block.low_flight, np.random.default_rng(1000 + seed)
    images = low.image_points
    photograph = pd.factorize(images["image_id"])[0]
    half = images[["x", "y"]].abs().max(axis=None)
    u, v = (images[axis].to_numpy() / half for axis in ("x", "y"))
    terms = np.stack([u * u, u * v, v * v, u**3, u * u * v, u * v * v, v**3], axis=1)
    each = rng.normal(0.0, 1e-3 * size_um, (photograph.max() + 1, 7, 2))
    moved = np.einsum("nt,nta->na", terms, each[photograph])
    images = images.assign(x=images["x"] + moved[:, 0], y=images["y"] + moved[:, 1])
    return replace(block, low_flight=replace(low, image_points=images))


def edge_of_terms():
    """Root sum of squares of all terms at the edge of a square, but affine parts."""
    u, v = (each.ravel() for each in np.meshgrid(*[np.linspace(-1.0, 1.0, 41)] * 2))
    terms = np.stack([u * u, u * v, v * v, u**3, u * u * v, u * v * v, v**3], axis=1)
    plane = np.stack([np.ones(len(u)), u, v], axis=1)
    rest = terms - plane @ np.linalg.lstsq(plane, terms)[0]
    is_edge = np.maximum(abs(u), abs(v)) > 0.75
    return np.sqrt(np.sum(rest[is_edge] ** 2, axis=1).mean())


def adjusted(block, **settings):
    settings = {"method": "simultaneous", **settings}
    return densify(block, block.settings.updated(settings))


def told_over_true(result, truth):
    """In plan and in height, of the new points, RMS."""
    points = result.points[result.points["role"] == "new"]
    known = truth.set_index("point_id").loc[points["point_id"], GROUND]
    off = points[GROUND].to_numpy() - known.to_numpy()
    plan = np.sqrt(np.mean(np.sum(off[:, :2] ** 2, axis=1)))
    told = np.sqrt(np.mean(points["standard_error_total"] ** 2))
    height = np.sqrt(np.mean(off[:, 2] ** 2))
    of_height = np.sqrt(np.mean(points["standard_error_height"] ** 2))
    return float(told / plan), float(of_height / height)


def low_flight(result):
    found = result.solution.adjustment.deformations.set_index("flight")
    return found.loc["low_flight"]


@pytest.fixture(scope="module")
def bent():
    return bent_block(3, SIZE_UM)


@pytest.fixture(scope="module")
def result(bent):
    return adjusted(bent)


def test_bends_are_found_and_in_the_standard_errors(bent, result):
    found = low_flight(result)
    assert found["own_p_value"] < 1e-6
    assert found["own_is_modelled"]
    # 10 µm of each of seven terms in either axis, without what is affine
    on_ground = SIZE_UM * 1e-6 * bent.low_flight.scale_number
    edge = np.sqrt(2.0) * on_ground * edge_of_terms()
    assert 0.7 < found["own_size_edge"] / edge < 1.4
    for ratio in told_over_true(result, bent.truth):
        assert 0.75 < ratio < 1.35
    assert 0.9 < result.solution.adjustment.s_0 < 1.1


@SLOW
def test_they_are_told_and_left_out_where_they_are_only_tested(bent, result):
    tested = adjusted(bent, model_deformation="tested")
    found = low_flight(tested)
    assert found["own_p_value"] == pytest.approx(low_flight(result)["own_p_value"])
    assert not found["own_is_modelled"]
    assert max(told_over_true(tested, bent.truth)) < 0.8
    assert "The standard errors are without it." in tested.summary()
    assert "The coordinates are as without it, and" in result.summary()
    ignored = adjusted(bent, model_deformation="ignored")
    assert ignored.solution.adjustment.deformations.empty
    with_them, without = (
        each.points["standard_error_total"].mean() for each in (result, ignored)
    )
    assert without < 0.8 * with_them


@pytest.mark.parametrize("seed", [3, *(pytest.param(s, marks=SLOW) for s in (4, 5))])
def test_straight_photographs_are_not_bent(seed):
    block = bent_block(seed, 0.0)
    result = adjusted(block)
    found = low_flight(result)
    assert found["own_p_value"] > 0.01
    assert not found["own_is_modelled"]
    plain = adjusted(block, model_deformation="tested")
    name = "standard_error_total"
    pd.testing.assert_series_equal(result.points[name], plain.points[name])


@SLOW
def test_the_order_of_rows_changes_nothing(bent, result):
    low = bent.low_flight
    turned = low.image_points.iloc[::-1].reset_index(drop=True)
    again = adjusted(replace(bent, low_flight=replace(low, image_points=turned)))
    own = "own_size_edge"
    assert low_flight(again)[own] == pytest.approx(low_flight(result)[own], rel=1e-6)
    name = "standard_error_total"
    both = (each.points.set_index("point_id")[name] for each in (again, result))
    pd.testing.assert_series_equal(*both, check_like=True, rtol=1e-6)


def test_few_points_tell_nothing():
    few = replace(GEOMETRY, point_spacing=550.0)
    found = low_flight(adjusted(bent_block(3, SIZE_UM, few)))
    assert np.isnan(found["own_p_value"])
    assert not found["own_is_modelled"]
