"""m_g of image points, as it was given and as relative orientations show it."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.assessment.evidence.image_precision import (
    common_sigma_0,
    image_component,
)
from einschalt.pipeline.assessment.findings.orientations import (
    image_points_better_than_given,
    image_points_worse_than_given,
)
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block


@pytest.fixture(scope="module")
def images():
    geometry = replace(PRESETS["demo"].geometry, measurement="images")
    return simulate_block("demo", seed=2, geometry=geometry)


def computed(block, *, low_m_g_um=5.0):
    low = replace(block.low_flight, m_g_um=low_m_g_um)
    flights = {"high_flight": block.high_flight, "low_flight": low}
    return densify(Block(control_points=block.control_points, crs=block.crs, **flights))


def rows_of(result, flight="low_flight"):
    return result.orientations[result.orientations["flight"] == flight]


def test_image_points_have_the_m_g_that_was_simulated(images):
    result = computed(images)
    for flight, simulated in (("high_flight", 7.5), ("low_flight", 5.0)):
        shown = image_component(rows_of(result, flight), images.flights[flight])
        assert abs(shown.estimated - simulated) < 3.0 * shown.standard_error
        assert shown.standard_error < 0.15 * simulated
    assert image_points_worse_than_given(result.examination) is None


@pytest.mark.slow
def test_an_m_g_of_image_points_that_is_too_small_is_called_out(images):
    result = computed(images, low_m_g_um=3.3)
    found = image_points_worse_than_given(result.examination)
    assert found.names == ("low_flight",)
    assert found.facts["flights"][0]["given_um"] == 3.3
    assert found.expected == pytest.approx(3.3e-6)
    assert found.observed > 4e-6
    said = " ".join(result.summary().split())
    assert "m_g_um of the low flight is given as 3.3, but the residuals of the" in said
    assert "Give that figure or a larger one" in said


def test_a_larger_m_g_is_not_contradicted_by_y_parallaxes(images):
    result = computed(images, low_m_g_um=9.0)
    assert image_points_worse_than_given(result.examination) is None


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_one_that_the_block_contradicts_as_well_is_called_out(images, method):
    low = replace(images.low_flight, m_g_um=10.0)
    settings = Settings(method=method)
    result = densify(replace(images, low_flight=low), settings)
    found = image_points_better_than_given(result.examination)
    assert found.names == ("low_flight",)
    (part,) = found.facts["flights"]
    assert part["given_um"] == 10.0
    assert abs(part["estimated_um"] - 5.0) < 3.0 * part["standard_error_um"]
    said = " ".join(result.summary().split())
    assert "m_g_um of the low flight is given as 10, but the residuals of the" in said
    assert "Give a figure near that one" in said
    sound = densify(images, settings).examination
    assert image_points_better_than_given(sound) is None


@pytest.mark.slow
def test_y_parallaxes_alone_do_not_call_a_larger_one_out(images):
    """Errors in x, which move points and leave no residual of an orientation.

    They are 12 µm beside y-parallaxes of 5 µm, and m_g is stated as it is then.
    """
    points = images.low_flight.image_points.copy()
    noise = np.random.default_rng(5).normal(scale=12e-3, size=len(points))
    points["x"] += noise
    low = replace(images.low_flight, image_points=points, m_g_um=13.0)
    block = replace(images, low_flight=low)
    for method in ("two_step", "simultaneous"):
        examined = densify(block, Settings(method=method)).examination
        rows = examined.orientations
        shown = image_component(rows[rows["flight"] == "low_flight"], low)
        assert shown.is_contradicted
        assert shown.estimated < shown.given
        assert image_points_better_than_given(examined) is None


def test_models_without_redundancy_say_nothing(images):
    rows = rows_of(computed(images)).assign(redundancy=0, sigma_0=np.nan)
    assert np.isnan(common_sigma_0(rows)[0])
    assert np.isnan(image_component(rows, images.low_flight).estimated)


def spoilt(block, share=0.12, times=12.0):
    """A share of the image points of the low flight measured much worse."""
    points = block.low_flight.image_points.copy()
    rng = np.random.default_rng(4)
    is_bad = rng.random(len(points)) < share
    noise = rng.normal(scale=times * 5e-3 / np.sqrt(2.0), size=(len(points), 2))
    points.loc[is_bad, ["x", "y"]] += noise[is_bad]
    return replace(block.low_flight, image_points=points)


@pytest.fixture(scope="module")
def with_worse_points(images):
    flights = {"high_flight": images.high_flight, "low_flight": spoilt(images)}
    block = Block(control_points=images.control_points, crs=images.crs, **flights)
    return densify(block, Settings(outliers="tukey"))


@pytest.mark.slow
def test_the_good_ones_of_the_image_points_keep_their_sigma_0(with_worse_points):
    examined = with_worse_points.examination
    tails = examined.image_tails
    assert list(tails) == ["low_flight"]
    # m_g is total, and a pair of photographs spoils a condition by either point
    assert tails["low_flight"].sigma == pytest.approx(5e-3 / np.sqrt(2.0), rel=0.1)
    assert tails["low_flight"].share == pytest.approx(1.0 - 0.88**2, abs=0.06)
    # what the models have without that
    assert common_sigma_0(rows_of(with_worse_points))[0] > 5e-3
    low = with_worse_points.assessment.flights[1]
    assert low.orientation.sigma_0 == pytest.approx(1e-3 * tails["low_flight"].sigma)
    said = " ".join(with_worse_points.summary().split())
    assert "of the image points of the low flight lie beyond 3 sigma_0 of the" in said


@pytest.mark.slow
def test_image_points_that_are_alike_have_no_tails(images):
    for outliers in ("keep", "tukey"):
        assert (
            densify(images, Settings(outliers=outliers)).examination.image_tails == {}
        )
