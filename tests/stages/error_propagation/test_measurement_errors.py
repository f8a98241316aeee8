"""Errors of image points reach the final points as the propagation says."""

from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest
from tests.flat_site import FLAT_SITE

from einschalt.pipeline.block.block import Block
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import (
    BlockGeometry,
    BlockNoise,
    simulate_block,
)
from einschalt.pipeline.summary.sections.precision import remarks
from einschalt.stages.error_propagation.given_points import approximations_are_control
from einschalt.stages.stage4_error_propagation import obstacle_to_propagation

pytestmark = pytest.mark.slow

GROUND = ["easting", "northing", "height"]
FLIGHTS = ("high_flight", "low_flight")
GEOMETRY = BlockGeometry(
    width=2_200.0,
    height=2_200.0,
    point_spacing=275.0,
    measurement="images",
    control_per_model=9,
    n_check=6,
    crs=FLAT_SITE,  # operators are of straight lines
)
NO_NOISE = BlockNoise(control_standard_error=0.0, high_m_g_um=0.0, low_m_g_um=0.0)
M_G_UM = {"high_flight": 7.5, "low_flight": 5.0}


def image_block(seed=1, noise=None, **geometry):
    shape = replace(GEOMETRY, **geometry)
    return simulate_block("demo", seed=seed, geometry=shape, noise=noise)


@cache
def exact_block(**geometry):
    """Tables without errors that claim the usual ones."""
    block = plain(image_block(noise=NO_NOISE, **geometry))
    flights = {
        name: replace(getattr(block, name), m_g_um=size)
        for name, size in M_G_UM.items()
        if getattr(block, name) is not None
    }
    control = block.control_points.assign(standard_error_m=0.03)
    return replace(block, control_points=control, **flights)


@cache
def exact_result(**geometry):
    return densify(exact_block(**geometry))


def plain(block):
    return Block(**{f.name: getattr(block, f.name) for f in fields(Block)})


def without_high_flight(block):
    """The low flight straight onto control, which is every second of its points."""
    held = block.low_flight.image_points["point_id"].unique()
    points = block.truth[["point_id", *GROUND]]
    given = points[points["point_id"].isin(held)].iloc[::2]
    control = given.assign(standard_error_m=0.03, role="control")
    return replace(
        plain(block),
        high_flight=None,
        control_points=control.reset_index(drop=True),
        approximate_points=given.reset_index(drop=True),
    )


def with_noise(block, rng, size):
    """The block with a share of its noise, and the noise as the sources have it."""
    control = block.control_points.copy()
    noise = {"control": size * 0.03 / np.sqrt(2.0) * rng.normal(size=(len(control), 3))}
    control[GROUND] += noise["control"]
    changes = {"control_points": control}
    if block.approximate_points is not None:
        given = control.set_index("point_id")[GROUND]
        known = block.approximate_points.copy()
        known[GROUND] = given.loc[known["point_id"]].to_numpy()
        changes["approximate_points"] = known
    for name, flight in block.flights.items():
        table = flight.image_points.copy()
        in_image = size * 1e-3 * flight.m_g_um / np.sqrt(2.0)
        moved = in_image * rng.normal(size=(len(table), 2))
        table[["x", "y"]] += moved
        on_ground = 1e-3 * flight.scale_number * moved
        noise[name] = np.column_stack([on_ground, np.zeros(len(table))])
        changes[name] = replace(flight, image_points=table)
    return replace(block, **changes), noise


def carried(errors, noise):
    n_coordinates = len(errors.axes.names)
    return sum(
        chain.of_vectors(noise[source][:, :n_coordinates])
        for source, chain in errors.chains.items()
    )


CASES = {
    "all": (exact_block, Settings()),
    "most central, weighted": (
        exact_block,
        Settings(coverage_mean="most_central", weighting="weighted"),
    ),
    "huber": (exact_block, Settings(outliers="huber")),
    "snoop": (exact_block, Settings(outliers="snoop")),
    "one coverage": (lambda: exact_block(n_coverages=1), Settings()),
    "photographs of both coverages": (
        lambda: exact_block(coverage_shift=0.0),
        Settings(),
    ),
}


def shared_photographs(block):
    """Both coverages of the low flight made of the photographs of the first."""
    flight = block.low_flight
    models = flight.models.copy()
    for side in ("left_image", "right_image"):
        models[side] = "1/" + models[side].str.split("/", n=1).str[1]
    return replace(block, low_flight=replace(flight, models=models))


@pytest.mark.parametrize("name", CASES)
def test_errors_are_what_the_operators_make_of_the_noise(name):
    build, settings = CASES[name]
    block = build()
    if name == "photographs of both coverages":
        block = shared_photographs(block)
    # so little noise that what is of second order in it vanishes
    noisy, noise = with_noise(block, np.random.default_rng(5), 1e-3)
    exact, result = densify(block), densify(noisy, settings)
    true = exact.solution.points.set_index("point_id").loc[
        result.solution.points["point_id"], GROUND
    ]
    error = result.solution.points[GROUND].to_numpy() - true.to_numpy()
    # weights are those of the noisy block
    found = carried(result.errors, noise)
    assert np.abs(error).max() > 1e-5
    np.testing.assert_allclose(found, error, rtol=0.0, atol=1e-4 * np.abs(error).max())


@pytest.mark.parametrize("flight", FLIGHTS)
def test_differences_of_image_coordinates(flight):
    """A few of them, x and y of each at once, and each its own way."""
    block = exact_block()
    errors = exact_result().errors
    of_flight = getattr(block, flight)
    rng = np.random.default_rng(0)
    for _ in range(2):
        rows = rng.choice(len(of_flight.image_points), 1)
        way = np.zeros((len(of_flight.image_points), 3))
        way[rows, :2] = rng.choice([-1.0, 1.0], (len(rows), 2))
        found = []
        for step in (1e-3, -1e-3):
            table = of_flight.image_points.copy()
            table[["x", "y"]] += step * way[:, :2]
            changed = replace(of_flight, image_points=table)
            points = densify(replace(block, **{flight: changed})).solution.points
            found.append(points[GROUND].to_numpy())
        noise = {s: np.zeros((len(e), 3)) for s, e in errors.standard_errors.items()}
        on_ground = 1e-3 * of_flight.scale_number * way
        expected = carried(errors, {**noise, flight: on_ground})
        numeric = (found[0] - found[1]) / 2e-3
        np.testing.assert_allclose(
            expected, numeric, rtol=0.0, atol=1e-6 * np.abs(numeric).max()
        )


def test_a_flight_straight_onto_control():
    block = without_high_flight(image_block(noise=NO_NOISE))
    block = replace(block, low_flight=replace(block.low_flight, m_g_um=5.0))
    assert approximations_are_control(block)
    assert obstacle_to_propagation(block) == ""
    noisy, noise = with_noise(block, np.random.default_rng(6), 1e-3)
    exact, result = densify(block), densify(noisy)
    assert set(exact.errors.parts) == {"control", "low_flight"}
    error = (result.solution.points[GROUND] - exact.solution.points[GROUND]).to_numpy()
    np.testing.assert_allclose(
        carried(exact.errors, noise), error, rtol=0, atol=1e-4 * np.abs(error).max()
    )
    assert exact.claim.is_supported
    assert not exact.claim.is_assumed
    assert exact.components is None


@pytest.mark.parametrize("change", ["moved", "unknown", "without errors"])
def test_other_approximate_points_have_errors_that_nobody_knows(change):
    block = without_high_flight(image_block(noise=NO_NOISE))
    known, control = block.approximate_points.copy(), block.control_points
    if change == "moved":
        known.loc[0, "height"] += 0.001
    elif change == "unknown":
        control = control.iloc[1:].reset_index(drop=True)
    else:
        control = control.drop(columns="standard_error_m")
    block = replace(block, approximate_points=known, control_points=control)
    assert obstacle_to_propagation(block) != ""
    assert densify(block).errors is None


def test_tables_and_tests_hold_together():
    result = densify(image_block(seed=2))
    points = result.solution.points
    height = points["standard_error_height"].to_numpy()
    np.testing.assert_allclose(height**2, result.errors.covariance[:, 2, 2])
    table = result.error_sources
    parts = [n for n in table if n.startswith("standard_error_") and "total" not in n]
    assert parts == [f"standard_error_{n}" for n in ("control", *FLIGHTS)]
    squares = (table[parts] ** 2).sum(axis=1)
    np.testing.assert_allclose(squares, points["standard_error_total"] ** 2)
    neighbours = result.neighbours
    assert (
        neighbours["standard_error_total"].mean()
        < neighbours["standard_error_if_independent"].mean()
    )
    assert result.left_out_control.normalized_square == pytest.approx(1.0, abs=0.4)
    assert result.claim.of("control points, each left out").n_points > 20
    assert not result.claim.is_assumed
    assert result.components is None
    assert result.patterns.strain is None
    assert len(result.ellipses) == len(points)
    said = " ".join(remarks(result.assessment.precision))
    assert "image points" in said
    assert "Heights of the new points" in said


def test_models_that_share_a_photograph_share_its_errors():
    """Values of a point in two models of three photographs, 1/2 and 2/3."""
    block = exact_block()
    result = densify(block)
    flight, errors = block.low_flight, result.orientation_errors["low_flight"]
    points = result.solution.model_points["low_flight"]
    names = flight.image_points[["image_id", "point_id"]]
    models = flight.models.set_index(["coverage", "model_id"])
    for row in range(0, len(points), 17):
        point = points.iloc[row]
        images = models.loc[(point["coverage"], point["model_id"])]
        for place, side in enumerate(("left_image", "right_image")):
            source = tuple(names.iloc[errors.sources[row, place]])
            assert source == (images[side], point["point_id"])
    n_uses = np.bincount(errors.sources.ravel(), minlength=errors.n_sources)
    assert n_uses.max() == 2
