"""Mistakes of stage 2 that only the ground can show, each with a block that has it."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.foundations.errors import BlockError
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.pipeline.summary.suggestions import catalogue as sg
from einschalt.stages.relative_orientation.orient_from_images import orient_from_images
from einschalt.stages.stage2_relative_orientation import image_pairs


def block_of(measurement):
    geometry = replace(PRESETS["demo"].geometry, measurement=measurement)
    return simulate_block("demo", seed=5, geometry=geometry)


@pytest.fixture(scope="module")
def from_images():
    return block_of("images")


@pytest.fixture(scope="module")
def from_parallaxes():
    return block_of("parallaxes")


def with_low_flight(block, **changes):
    """The block with another low flight, checked anew."""
    fields = {name: getattr(block, name) for name in Block.__dataclass_fields__}
    return Block(**fields | {"low_flight": replace(block.low_flight, **changes)})


def with_image_points(block, change):
    points = block.low_flight.image_points.copy()
    change(points)
    return densify(with_low_flight(block, image_points=points))


@pytest.mark.parametrize("axis", ["x", "y"])
def test_mirrored_images_turn_flat_terrain_over(from_images, axis):
    def mirror(points):
        points[axis] *= -1.0

    result = with_image_points(from_images, mirror)
    # every pair can be oriented: nothing but the ground knows left from right
    assert result.failures.empty
    said = str(sg.models_upside_down(result))
    assert said.startswith("23 spatial models upside down: low 1/1, low 1/2")
    assert "Turn the sign of x or y in their image" in said


def test_upright_models_are_not_named(from_images, from_parallaxes, good_result):
    for result in (densify(from_images), densify(from_parallaxes), good_result):
        assert sg.models_upside_down(result) is None
        assert sg.corrections_that_spoil(result) is None
        assert sg.orientations_with_large_sigma_0(result) is None


def test_bad_image_coordinates_stand_out(from_images):
    def spoil(points):
        first = points["image_id"] == points["image_id"].iloc[100]
        rng = np.random.default_rng(1)
        points.loc[first, "y"] += rng.normal(scale=0.05, size=first.sum())

    result = with_image_points(from_images, spoil)
    said = str(sg.orientations_with_large_sigma_0(result))
    assert "with sigma_0 of the relative orientation more than 3 times the" in said
    image = from_images.low_flight.image_points["image_id"].iloc[100]
    models = from_images.low_flight.models
    is_in = (models["left_image"] == image) | (models["right_image"] == image)
    for model_id in models.loc[is_in, "model_id"]:
        assert f"low {model_id}" in said


def test_pairs_that_fit_twice_are_named(from_images):
    block = from_images
    pairs = image_pairs(block.low_flight.image_coordinates(), block.low_flight.models)
    five = pairs.groupby(["coverage", "model_id"], sort=False).head(5)
    # five points have several orientations, whatever is measured
    distance = block.low_flight.principal_distance_mm
    alone = orient_from_images(five, distance).orientations
    n_twice = int((alone["is_ambiguous"] & alone["is_converged"]).sum())
    assert n_twice > len(alone) // 2
    result = densify(block)
    rows = alone.assign(flight="low_flight")
    said = str(sg.ambiguous_orientations(replace(result, orientations=rows)))
    assert said.startswith(f"{n_twice} models with a second relative orientation that")
    rows = rows.assign(is_ambiguous=False)
    assert sg.ambiguous_orientations(replace(result, orientations=rows)) is None
    assert "is_ambiguous" in result.orientations


@pytest.mark.parametrize("mistake", ["sign", "case"])
def test_parallaxes_of_the_wrong_sign_are_said(from_parallaxes, mistake):
    parallaxes = from_parallaxes.low_flight.y_parallaxes
    turned = parallaxes.assign(y_parallax=-parallaxes["y_parallax"])
    # parallaxes of a dependent_right pair count the other way
    changes = {
        "sign": {"y_parallaxes": turned},
        "case": {"orientation_case": "dependent_right"},
    }[mistake]
    result = densify(with_low_flight(from_parallaxes, **changes))
    said = str(sg.corrections_that_spoil(result))
    assert said.startswith("The corrections by y-parallaxes make the low flight fit w")
    assert "Turn the sign of y_parallax: y of the moved bundle less y of" in said
    both = {"y_parallaxes": turned, "orientation_case": "dependent_right"}
    right = densify(with_low_flight(from_parallaxes, **both))
    assert sg.corrections_that_spoil(right) is None


def test_images_that_nobody_measured_are_said(from_images):
    models = from_images.low_flight.models.assign(right_image="nope")
    with pytest.raises(BlockError, match="right_image 'nope' has no image points"):
        with_low_flight(from_images, models=models)
