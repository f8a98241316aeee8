"""The error operators against what the block does when its input is moved."""

import dataclasses
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import sparse

from einschalt.foundations.errors import TableError
from einschalt.foundations.units import METRES_PER_MM
from einschalt.pipeline.block.block import Block, plain_fields
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import (
    PRESETS,
    BlockNoise,
    simulate_block,
)
from einschalt.stages.error_propagation.covariances import NUMBERS_OF_RANGE, n_ranges
from einschalt.stages.stage4_error_propagation import obstacle_to_propagation
from einschalt.theory.adjustment.point_operator import Axes, PointOperator

STEP = 1e-3
TRANSFORMATIONS = [
    ("affine", "affine"),
    ("helmert", "affine"),
    ("affine", "helmert"),
    ("affine", "rigid"),
]


@pytest.fixture(scope="module", params=TRANSFORMATIONS, ids=" ".join)
def block(request):
    high, low = request.param
    return with_kinds(simulate_block("demo", seed=3), high, low)


@pytest.fixture(scope="module", params=TRANSFORMATIONS, ids=" ".join)
def quiet_block(request):
    """A block without errors."""
    high, low = request.param
    noise = BlockNoise(control_standard_error=0.0, high_m_g_um=0.0, low_m_g_um=0.0)
    return with_kinds(simulate_block("demo", seed=3, noise=noise), high, low)


@pytest.fixture(scope="module")
def unmoved():
    """Densify a block as it is, with each of the settings once."""
    found = {}

    def call(block, settings):
        key = id(block), repr(settings)
        if key not in found:
            found[key] = block, densify(block, settings)
        return found[key][1]

    return call


def with_kinds(block, high, low):
    fields = plain_part(block)
    fields["high_flight"] = changed(block.high_flight, transformation=high)
    low_flight = changed(block.low_flight, transformation=low)
    fields["low_flight"] = at_ground_scale(low_flight) if low == "rigid" else low_flight
    return Block(**fields)


def at_ground_scale(flight):
    points = flight.model_points.copy()
    points[["x", "y"]] *= flight.scale_number * METRES_PER_MM
    return changed(flight, model_points=points, model_unit="m")


def plain_part(block):
    """Fields of a simulated block that any block has."""
    return {f.name: getattr(block, f.name) for f in dataclasses.fields(Block)}


def changed(owner, **fields):
    return type(owner)(**{**plain_fields(owner), **fields})


def moved(block, **tables):
    return Block(**{**plain_fields(block), **tables})


def coordinates(block, settings):
    points = densify(block, settings).solution.points
    return points.set_index("point_id")[["easting", "northing"]]


def real_operator(errors, source):
    """Dense operator on easting, northing, easting, …"""
    whole = errors.chains[source].matrix.toarray()
    if errors.axes is Axes.PLANE:
        return whole
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    return np.kron(whole.real, np.eye(2)) + np.kron(whole.imag, turn)


def with_control_moved(block, by):
    control = block.control_points.copy()
    control[["easting", "northing"]] += by
    return moved(block, control_points=control)


def ways_of_control(block):
    """How control points are moved at a time, and how far the operators may be off."""
    shape = (len(block.control_points), 2)
    if block.low_flight.transformation != "rigid":
        # all at once, each its own way and by a step at least: a column that is wrong
        # shows with all that it is wrong by
        rng = np.random.default_rng(1)
        signs = rng.choice([-1.0, 1.0], shape)
        return [signs * rng.uniform(1.0, 1.5, shape)], 1e-6
    # rigid is not linear: residuals of 0.1 m over 1 km change the angle by 1e-4 of its
    # own change. One point to the east at a time, so that these do not add up
    places = range(0, shape[0], 9)
    ways = np.zeros((len(places), *shape))
    ways[range(len(places)), places, 0] = 1.0
    return ways, 1e-5


def assert_operator_of_control(block, settings, result):
    operator = real_operator(result.errors, "control")
    ways, atol = ways_of_control(block)
    for way in ways:
        before, after = (
            coordinates(with_control_moved(block, by * way), settings)
            for by in (-STEP, STEP)
        )
        change = (after - before).to_numpy().ravel() / (2.0 * STEP)
        np.testing.assert_allclose(operator @ way.ravel(), change, atol=atol)


@pytest.mark.slow
@pytest.mark.parametrize(
    "settings",
    [
        {"coverage_mean": "all"},
        {"coverage_mean": "most_central"},
        {"weighting": "rigorous"},
    ],
    ids=str,
)
def test_operator_of_control(block, settings, unmoved):
    settings = Settings(**settings)
    assert_operator_of_control(block, settings, unmoved(block, settings))


@pytest.mark.slow
def test_operator_of_control_with_distributed_residuals(quiet_block, unmoved):
    # weights move with the points, which only residuals could tell; without weights
    # nothing here depends on deformations
    settings = Settings(
        residual_distribution="natural_neighbour",
        weighting="plain",
        model_deformation="ignored",
    )
    result = unmoved(quiet_block, settings)
    assert_operator_of_control(quiet_block, settings, result)


@pytest.mark.parametrize("flight", ["high_flight", "low_flight"])
@pytest.mark.parametrize("distribution", ["none", "natural_neighbour"])
def test_operator_of_a_measured_point(block, flight, distribution, unmoved):
    settings = Settings(residual_distribution=distribution)
    result = unmoved(block, settings)
    operator = real_operator(result.errors, flight)
    of_flight = getattr(block, flight)
    before = result.solution.points.set_index("point_id")[["easting", "northing"]]
    rows = np.random.default_rng(0).choice(len(of_flight.model_points), 4, False)
    table, on_ground = of_flight.model_points.copy(), np.zeros(operator.shape[1])
    # at once and by different steps: a column that is wrong shows with all of that
    for row, share in zip(rows, (1.0, -1.1, 1.2, -1.3), strict=True):
        matrix = linear_part(result, flight, of_flight.model_points.iloc[row])
        # to the east on the ground, in the frame of the model
        step = np.linalg.solve(matrix, [share * STEP, 0.0])
        label = table.index[row]
        table.loc[label, ["x", "y"]] = table.loc[label, ["x", "y"]] + step
        on_ground[2 * row] = share
    after = moved(block, **{flight: changed(of_flight, model_points=table)})
    change = coordinates(after, settings) - before
    np.testing.assert_allclose(
        operator @ on_ground, change.to_numpy().ravel() / STEP, atol=3e-4
    )


def linear_part(result, flight, point):
    models = result.models
    is_it = (
        (models["flight"] == flight)
        & (models["coverage"] == point["coverage"])
        & (models["model_id"] == point["model_id"])
    )
    p = models[is_it].iloc[0]
    if p["transformation"] == "affine":
        return np.array([[p["a1"], p["a2"]], [p["b1"], p["b2"]]])
    if p["transformation"] == "rigid":
        cos, sin = np.cos(p["theta"]), np.sin(p["theta"])
        return np.array([[cos, -sin], [sin, cos]])
    return np.array([[p["a"], -p["b"]], [p["b"], p["a"]]])


def test_parts_add_up_and_name_their_sources(block, unmoved):
    errors = unmoved(block, Settings()).errors
    assert set(errors.parts) == {"control", "high_flight", "low_flight"}
    total = sum(errors.parts.values())
    np.testing.assert_allclose(errors.covariance, total)


def test_covariance_between_points(block, unmoved):
    errors = unmoved(block, Settings()).errors
    first, second = errors.point_ids[:20], errors.point_ids[20:40]
    between = errors.covariance_between(first, second)
    dense = sum(
        real_operator(errors, source)
        @ np.diag(np.repeat(errors.standard_errors[source], 2) ** 2)
        @ real_operator(errors, source).T
        for source in errors.chains
    )
    for k in range(20):
        expected = dense[2 * k : 2 * k + 2, 40 + 2 * k : 42 + 2 * k]
        np.testing.assert_allclose(between[k], expected, atol=1e-12)
    np.testing.assert_allclose(
        errors.covariance_between(first, first), errors.covariance[:20], atol=1e-15
    )


def test_unknown_sizes_are_not_guessed():
    block = simulate_block("demo", seed=3)
    fields = plain_part(block)
    control = block.control_points.drop(columns="standard_error_m")
    without = Block(**{**fields, "control_points": control})
    assert not obstacle_to_propagation(block)
    assert obstacle_to_propagation(without)
    result = densify(without)
    assert result.errors is None
    assert "standard_error_total" not in result.solution.points
    assert np.isnan(result.figures.mean_total)


def test_metres_per_millimetre_of_the_small_block():
    # the operators are in ground units: m_g must reach them as metres on the ground
    block = simulate_block("demo", seed=3)
    sigma = densify(block).errors.standard_errors["low_flight"][0]
    flight = block.low_flight
    on_ground = flight.m_g_um * METRES_PER_MM * 1e-3 * flight.scale_number
    assert sigma == pytest.approx(on_ground / np.sqrt(2))


def test_covariance_of_an_unknown_point(block, unmoved):
    errors = unmoved(block, Settings()).errors
    with pytest.raises(TableError, match=r"point 99x: it is not among the densified"):
        errors.covariance_between(["99x"], errors.point_ids[:1])


def test_ranges_of_points_grow_with_the_block_and_not_with_its_square():
    """A point depends on no more sources because the block goes on elsewhere."""

    def chain(n_points):
        values, high = 4 * n_points, 3 * n_points
        mean = _rows(n_points, values, 4)
        models = _rows(values, n_points, 12)
        factors = (mean, models, _rows(n_points, high, 4))
        return {"high_flight": PointOperator(factors, Axes.COMPLEX)}

    ranges = [n_ranges(chain(n), n) for n in (20_000, 40_000, 80_000)]
    assert ranges[1] == pytest.approx(2 * ranges[0], abs=1)
    assert ranges[2] == pytest.approx(4 * ranges[0], abs=3)
    # as full as rows are, whatever the means of the factors would have them be
    full = PointOperator((sparse.csr_array(np.ones((50, 400))),), Axes.COMPLEX)
    parts = n_ranges({"control": full}, 500_000)
    assert parts == 500_000 * 400 // NUMBERS_OF_RANGE


def _rows(n_rows, n_columns, n_each):
    """Sparse matrix with so many numbers in each row, near its place."""
    first = np.arange(n_rows) * (n_columns - n_each) // n_rows
    columns = first[:, None] + np.arange(n_each)
    pointer = n_each * np.arange(n_rows + 1)
    entries = (np.ones(n_rows * n_each), columns.ravel(), pointer)
    return sparse.csr_array(entries, shape=(n_rows, n_columns))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_errors_of_heights_of_control_say_nothing_in_plan(kind):
    geometry = replace(PRESETS["demo"].geometry, transformation=kind)
    block = simulate_block("demo", seed=3, geometry=geometry)
    control = block.control_points.assign(standard_error_height=0.5)
    found, plain = (densify(b) for b in (replace(block, control_points=control), block))
    pd.testing.assert_frame_equal(found.points, plain.points)
