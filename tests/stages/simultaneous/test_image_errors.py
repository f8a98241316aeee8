"""Models from images in the simultaneous adjustment: errors of the image points."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import binom

import einschalt as es
from einschalt.foundations.units import METRES_PER_MM
from einschalt.pipeline.simulation.simulate_block import BlockGeometry, simulate_block
from einschalt.stages.simultaneous.image_drawings import ImageSizes, image_chains
from einschalt.stages.simultaneous.image_errors import _expected_fits
from einschalt.theory.block_adjustment.observations import Part

AXES = ["easting", "northing", "height"]
GEOMETRY = BlockGeometry(
    width=2_200.0,
    height=2_200.0,
    point_spacing=275.0,
    measurement="images",
    transformation="helmert_3d",
    control_per_model=9,
)


@pytest.fixture(scope="module")
def block():
    return simulate_block("demo", seed=1, geometry=GEOMETRY)


@pytest.mark.slow
def test_points_and_centres_move_as_when_the_images_are_measured_otherwise(block):
    """Projection centres too: they move with the orientations alone."""
    rng = np.random.default_rng(5)
    images = block.low_flight.image_points
    moves = 1e-5 * rng.standard_normal((len(images), 2))
    moved = images.assign(x=images["x"] + moves[:, 0], y=images["y"] + moves[:, 1])
    other = replace(block, low_flight=replace(block.low_flight, image_points=moved))
    asked = {"kind": "helmert_3d", "flights": "low"}
    before, after = (es.adjust_block(b, **asked) for b in (block, other))
    solution, tables = before.solution, before.tables
    n_rows, n_points = len(tables.row), solution.observations.n_points
    everything = np.arange(n_rows), before.kept, np.arange(n_points)
    part = Part(solution.observations, *everything)
    ((_, start, measured, chain),) = image_chains(tables, part, solution)
    assert start == 0
    on_ground = moves * METRES_PER_MM * measured.scale_number
    sources = np.column_stack([on_ground, np.zeros(len(moves))])
    errors = chain.of_vectors(sources)[tables.row][:, :, None]
    points, _ = solution.answer_to(errors, np.zeros((n_points, 3, 1)))
    # with the weights of before: heights have errors that their residuals show
    xyz = after.tables.observations.xyz
    same_weights = replace(solution.observations, xyz=xyz)
    expected = solution.readjusted(same_weights).points - solution.points
    assert tables.is_centre.any()
    largest = np.abs(expected).max()
    assert largest > 1e-4
    np.testing.assert_allclose(points[:, :, 0], expected, rtol=0, atol=2e-3 * largest)


@pytest.fixture(scope="module")
def eight():
    """Clean blocks, and what one adjustment makes of each."""
    blocks = [simulate_block("demo", seed=k, geometry=GEOMETRY) for k in range(8)]
    settings = es.Settings(method="simultaneous")
    return [(own, es.densify(own, settings).solution) for own in blocks]


@pytest.mark.slow
def test_claimed_and_true_errors(eight):
    """Of eight blocks; points of a block share errors."""
    figures = []
    for own, solution in eight:
        points = solution.points
        new = points[points["role"] == "new"]
        true = own.truth.set_index("point_id").loc[new["point_id"], AXES]
        error = new[AXES].to_numpy() - true.to_numpy()
        claimed = new[[f"standard_error_{axis}" for axis in AXES]].to_numpy()
        figures.append(((error / claimed) ** 2).mean(axis=0))
    square = np.array(figures)
    scatter = square.std(axis=0, ddof=1) / np.sqrt(len(square))
    assert (np.abs(square.mean(axis=0) - 1.0) < 3.0 * scatter).all()
    assert (scatter < 0.2).all()


def test_s_0_is_1_where_errors_are_as_large_as_stated(eight):
    """Weights alone, of model points taken for independent, give 1.11."""
    adjusted = [solution.adjustment for _, solution in eight]
    square = np.array([one.s_0**2 for one in adjusted])
    scatter = square.std(ddof=1) / np.sqrt(len(square))
    assert abs(square.mean() - 1.0) < 3.0 * scatter
    assert scatter < 0.05
    by_weights = np.mean([one.solution.s_0**2 for one in adjusted])
    assert by_weights - 1.0 > 3.0 * scatter


@pytest.mark.slow
def test_image_errors_that_show_are_counted_and_s_0_stays_1(block):
    """Half of the true m_g: residuals of the images tell the other half."""
    low = block.low_flight
    other = replace(block, low_flight=replace(low, m_g_um=0.5 * low.m_g_um))
    asked = {"kind": "helmert_3d", "flights": "low"}
    one, two = (es.adjust_block(b, **asked) for b in (block, other))
    assert two.s_0 == pytest.approx(one.s_0, rel=0.02)
    errors = [f"standard_error_{axis}" for axis in AXES]
    claimed, counted = (np.sqrt((a.points[errors] ** 2).mean()) for a in (one, two))
    np.testing.assert_allclose(counted, claimed, rtol=0.1)


@pytest.mark.parametrize("level", [0.1, 0.01, 0.001])
def test_clean_residuals_are_rejected_as_often_as_the_level_says(eight, level):
    """At the edge of models from images they are larger, and yet no gross errors."""
    p_value = np.concatenate([s.residuals["p_value"].dropna() for _, s in eight])
    most = binom.isf(0.001, len(p_value), level)
    least = binom.ppf(0.001, len(p_value), level)
    assert least <= np.count_nonzero(p_value < level) <= most
    assert sum(s.residuals["is_suspect"].sum() for _, s in eight) <= 1


@pytest.mark.slow
@pytest.mark.parametrize("outliers", ["keep", "snoop"])
def test_a_point_measured_wrongly_in_one_image_is_the_suspect(block, outliers):
    """Along the base: no orientation, but its neighbours tell."""
    images = block.low_flight.image_points
    middle = np.hypot(images["x"], images["y"]).idxmin()
    moved = images.assign(x=images["x"] + 0.08 * (images.index == middle))
    spoilt = replace(block, low_flight=replace(block.low_flight, image_points=moved))
    settings = es.Settings(method="simultaneous", outliers=outliers)
    residuals = es.densify(spoilt, settings).solution.residuals
    suspects = residuals.loc[residuals["is_suspect"], "point_id"]
    assert set(suspects) == {images["point_id"][middle]}


def with_m_g(block, factor):
    names = ("high_flight", "low_flight")
    flights = {name: getattr(block, name) for name in names}
    return replace(
        block,
        **{k: replace(f, m_g_um=factor * f.m_g_um) for k, f in flights.items()},
    )


def estimated(block):
    return es.adjust_block(block, kind="helmert_3d", variance_components="estimated")


@pytest.mark.slow
def test_the_size_of_image_errors_is_not_that_of_model_points(eight):
    """Rays make the model points worse, which the drawn errors have already."""
    factors, sizes = {"image points": [], "plan": []}, []
    for own, _ in eight:
        found = estimated(own)
        table = found.components.set_index("group")["factor"]
        for kind, values in factors.items():
            values.append([table[f"{f}_flight, {kind}"] for f in ("high", "low")])
        sizes.append(found.s_0)
    for kind, is_one in (("image points", True), ("plan", False)):
        of_kind = np.array(factors[kind])
        scatter = of_kind.std(axis=0, ddof=1) / np.sqrt(len(of_kind))
        away = (of_kind.mean(axis=0) - 1.0) / scatter
        assert (np.abs(away) < 3.0).all() if is_one else (away > 3.0).all()
    np.testing.assert_allclose(sizes, 1.0, atol=0.01)


def test_image_errors_are_estimated_whatever_was_given(block):
    """The claim is that of errors given truly, and model points are in another row."""
    claimed, factors = [], []
    for factor in (1.0, 2.0):
        found = estimated(with_m_g(block, factor))
        new = found.points[found.points["role"] == "new"]
        claimed.append(np.sqrt((new["standard_error_total"] ** 2).mean()))
        table = found.components.set_index("group")
        factors.append(table.loc["low_flight, image points", "factor"])
        assert found.s_0 == pytest.approx(1.0, abs=0.01)
    assert claimed[1] == pytest.approx(claimed[0], rel=0.02)
    assert factors[1] == pytest.approx(0.5 * factors[0], rel=0.02)
    given = es.adjust_block(block, kind="helmert_3d").points
    given = given[given["role"] == "new"]["standard_error_total"]
    assert claimed[0] == pytest.approx(np.sqrt((given**2).mean()), rel=0.05)


def test_each_flight_has_the_factor_of_its_own_images():
    """With estimated sizes every flight was divided by the factor of the first."""
    tables = SimpleNamespace(flights=("high", "low"), images=(object(), object()))
    squares = np.full((2, 8), 4.0) + np.arange(8) / 100.0
    found = _expected_fits(
        tables, ImageSizes(np.array([1.0, 0.5]), np.zeros(2)), squares
    )
    assert found["low"].m_0 == pytest.approx(2.0 * found["high"].m_0)
