"""Bends in height that models of a flight share, from lens to heights of points."""

from dataclasses import replace

import numpy as np
import pytest

import einschalt as es
from einschalt.pipeline.simulation.simulate_block import PRESETS

GEOMETRY = replace(PRESETS["demo"].geometry, transformation="helmert_3d")
MODELLED = {"kind": "helmert_3d", "deformation": "modelled"}
RADIUS = 100.0  # mm


def simulated(seed, measurement="machine"):
    geometry = replace(GEOMETRY, measurement=measurement)
    return es.simulate_block("demo", seed=seed, geometry=geometry)


def with_flights(block, change):
    names = ("high_flight", "low_flight")
    return replace(block, **{name: change(getattr(block, name)) for name in names})


def bent(flight, size):
    """Heights of each model raised by ``size`` at its edge [mm]."""
    points = flight.model_points
    models = points.groupby(["coverage", "model_id"])
    centre = models[["x", "y"]].transform("mean")
    away = points[["x", "y"]] - centre
    z = points["z"] + size * (away**2).sum(axis=1) / np.square(away.abs().max().max())
    return replace(flight, model_points=points.assign(z=z))


def distorted(flight, size):
    """Photographs of a lens with radial distortion of a ``size`` at the radius [mm]."""
    images = flight.image_points
    square = (images["x"] ** 2 + images["y"] ** 2) / RADIUS**2 - 0.5
    moved = {k: images[k] * (1.0 + size * square / RADIUS) for k in ("x", "y")}
    return replace(flight, image_points=images.assign(**moved))


def height_errors(adjusted, block):
    """True errors of the new heights, and those that are claimed [m]."""
    points = adjusted.points[adjusted.points["role"] == "new"]
    truth = block.truth.set_index("point_id").loc[points["point_id"], "height"]
    claimed = points["standard_error_height"].to_numpy()
    return points["height"].to_numpy() - truth.to_numpy(), claimed


def over_claimed(errors):
    """RMS of true errors over that of the claimed ones, of many blocks."""
    true, claimed = (np.concatenate(part) for part in zip(*errors, strict=True))
    return np.sqrt(np.mean(true**2) / np.mean(claimed**2))


@pytest.mark.slow
def test_models_from_a_machine_that_bends_them():
    errors, plain = [], []
    for seed in range(6):
        block = with_flights(simulated(seed), lambda flight: bent(flight, 0.03))
        adjusted = es.adjust_block(block, **MODELLED)
        assert adjusted.deformations["is_modelled"].all()
        assert list(adjusted.common["term"]) == ["dz:x2", "dz:xy", "dz:y2"] * 2
        errors.append(height_errors(adjusted, block))
        plain.append(height_errors(es.adjust_block(block, kind="helmert_3d"), block))
    assert over_claimed(errors) == pytest.approx(1.0, abs=0.15)
    assert over_claimed(plain) > 1.5


@pytest.mark.slow
def test_photographs_of_a_distorted_lens():
    errors, plain = [], []
    for seed in range(6):
        block = simulated(seed, "images")
        block = with_flights(block, lambda flight: distorted(flight, 0.02))
        adjusted = es.adjust_block(block, **MODELLED)
        assert adjusted.deformations["is_modelled"].any()
        errors.append(height_errors(adjusted, block))
        plain.append(height_errors(es.adjust_block(block, kind="helmert_3d"), block))
    assert over_claimed(errors) == pytest.approx(1.0, abs=0.15)
    assert over_claimed(plain) > 1.25 * over_claimed(errors)


@pytest.mark.slow
@pytest.mark.parametrize("measurement", ["machine", "images"])
def test_straight_models_beside_wrong_control_are_not_bent(measurement):
    """One height that is off by 50 cm bends a block, but not its models."""
    for seed in range(6):
        block = simulated(seed, measurement)
        control = block.control_points.copy()
        control.loc[control.index[4], "height"] += 0.5
        for own in (block, replace(block, control_points=control)):
            adjusted = es.adjust_block(own, **MODELLED)
            assert not adjusted.deformations["is_detected"].any()
            assert adjusted.common.empty


def test_a_bend_is_tested_only_where_that_is_asked_for():
    block = with_flights(simulated(1), lambda flight: bent(flight, 0.03))
    asked = {"kind": "helmert_3d", "deformation": "tested"}
    tested = es.adjust_block(block, **asked)
    assert tested.deformations["is_detected"].all()
    assert not tested.deformations["is_modelled"].any()
    assert tested.common.empty
    plain = es.adjust_block(block, kind="helmert_3d")
    assert plain.deformations.empty
    np.testing.assert_array_equal(tested.points["height"], plain.points["height"])
