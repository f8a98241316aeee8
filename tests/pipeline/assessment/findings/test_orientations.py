"""Mistakes of stage 2 that only the ground can show, each with a block that has it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from tests.changed_results import changed

from einschalt.foundations.errors import BlockError
from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings import orientations as judges
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import (
    PRESETS,
    BlockGeometry,
    simulate_block,
)
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


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["x", "y"])
def test_mirrored_images_turn_flat_terrain_over(from_images, axis):
    def mirror(points):
        points[axis] *= -1.0

    result = with_image_points(from_images, mirror)
    # every pair can be oriented: nothing but the ground knows left from right
    assert result.failures.empty
    found = judges.models_upside_down(result.examination)
    assert found.facts["n_models"] == len(found.names) == 23
    assert found.facts["models"][:2] == (("low_flight", "1/1"), ("low_flight", "1/2"))
    assert found.remedy == "turn_sign_of_x_or_y"
    assert found.gravity is Gravity.GRAVE


@pytest.mark.slow
def test_upright_models_are_not_named(from_images, from_parallaxes, good_result):
    for result in (densify(from_images), densify(from_parallaxes), good_result):
        assert judges.models_upside_down(result.examination) is None
        assert judges.corrections_that_spoil(result.examination) is None
        assert judges.orientations_with_large_sigma_0(result.examination) is None


def test_bad_image_coordinates_stand_out(from_images):
    def spoil(points):
        first = points["image_id"] == points["image_id"].iloc[100]
        rng = np.random.default_rng(1)
        points.loc[first, "y"] += rng.normal(scale=0.05, size=first.sum())

    result = with_image_points(from_images, spoil)
    found = judges.orientations_with_large_sigma_0(result.examination)
    assert found.facts["times_usual"] == 3.0
    assert found.observed == found.facts["largest_sigma_0"] > 3.0 * found.expected
    assert found.probability < 0.001
    image = from_images.low_flight.image_points["image_id"].iloc[100]
    models = from_images.low_flight.models
    is_in = (models["left_image"] == image) | (models["right_image"] == image)
    for model_id in models.loc[is_in, "model_id"]:
        assert ("low_flight", model_id) in found.facts["models"]


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
    doubted = changed(result, orientations=rows).examination
    found = judges.ambiguous_orientations(doubted)
    assert found.facts["n_models"] == n_twice
    rows = rows.assign(is_ambiguous=False)
    sure = changed(result, orientations=rows).examination
    assert judges.ambiguous_orientations(sure) is None
    assert "is_ambiguous" in result.orientations


@pytest.mark.slow
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
    found = judges.corrections_that_spoil(result.examination)
    assert found.names == (found.facts["flight"],) == ("low_flight",)
    assert found.facts["m_0_corrected"] == result.solution.low.m_0_plan
    assert found.facts["m_0_corrected"] > 1.2 * found.facts["m_0_uncorrected"] > 0.0
    assert found.remedy == "turn_sign_of_y_parallax"
    both = {"y_parallaxes": turned, "orientation_case": "dependent_right"}
    right = densify(with_low_flight(from_parallaxes, **both))
    assert judges.corrections_that_spoil(right.examination) is None


def test_images_that_nobody_measured_are_said(from_images):
    models = from_images.low_flight.models.assign(right_image="nope")
    with pytest.raises(BlockError, match="right_image 'nope' has no image points"):
        with_low_flight(from_images, models=models)


@pytest.fixture(scope="module")
def oriented_result():
    """A block whose models are oriented from y-parallaxes."""
    geometry = BlockGeometry(width=3_000.0, height=3_000.0, measurement="parallaxes")
    return densify(simulate_block("demo", seed=1, geometry=geometry))


def test_orientations_that_did_not_converge_are_named(oriented_result):
    assert judges.orientations_without_convergence(oriented_result.examination) is None
    rows = oriented_result.orientations.copy()
    rows["is_converged"] = rows.index != rows.index[-1]
    doubted = changed(oriented_result, orientations=rows).examination
    found = judges.orientations_without_convergence(doubted)
    last = ("low_flight", rows["model_id"].iloc[-1])
    assert found.facts == {"n_models": 1, "models": (last,)}


def test_models_near_a_dangerous_surface_are_named(oriented_result):
    assert judges.models_near_a_dangerous_surface(oriented_result.examination) is None
    rows = oriented_result.orientations.copy()
    rows.loc[:2, "verdict"] = ["weak", "critical", "weak"]
    rows.loc[:2, "inflation"] = [2.5, 12.34, 3.0]
    names = rows["model_id"].to_numpy()
    doubted = changed(oriented_result, orientations=rows).examination
    found = judges.models_near_a_dangerous_surface(doubted)
    # critical ones first
    assert found.names == (names[1], names[0], names[2])
    assert found.facts["critical"]["models"] == (("high_flight", names[1]),)
    assert found.facts["weak"]["n_models"] == 2
    assert found.facts["inflation"] == 12.34
    rows.loc[1, "inflation"] = np.inf
    found = judges.models_near_a_dangerous_surface(doubted)
    assert found.facts["inflation"] == np.inf
    # models that did not converge are named as such
    rows["is_converged"] = False
    assert judges.models_near_a_dangerous_surface(doubted) is None


def residuals_of_image_points(p_values):
    """Suspects with such probabilities among a hundred image points."""
    n = len(p_values)
    return pd.DataFrame(
        {
            "flight": "low_flight",
            "model_id": "7/8",
            "point_id": [f"P{k}" for k in range(100)],
            "p_value": [*p_values, *[0.5] * (100 - n)],
            "is_suspect": [True] * n + [False] * (100 - n),
        }
    )


@pytest.mark.parametrize(
    ("outliers", "remedy"),
    [
        ("keep", "measure_again_or_snoop"),
        ("snoop", "taken_out"),
        ("tukey", "weighted_down"),
    ],
)
def test_image_points_that_contradict_come_worst_first(outliers, remedy):
    rows = residuals_of_image_points([1e-6, 1e-9])
    settings = SimpleNamespace(outliers=outliers)
    examined = SimpleNamespace(orientation_residuals=rows, settings=settings)
    found = judges.image_points_that_contradict(examined)
    assert found.names == ("P1", "P0")
    assert found.facts["image_points"][0] == ("low_flight", "7/8", "P1")
    assert found.probability == pytest.approx(1e-7)
    assert found.remedy == remedy


def test_one_suspect_image_point_in_a_thousand_is_chance():
    rows = residuals_of_image_points([2e-5])
    settings = SimpleNamespace(outliers="keep")
    examined = SimpleNamespace(orientation_residuals=rows, settings=settings)
    assert judges.image_points_that_contradict(examined) is None
