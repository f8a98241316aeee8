"""Sources of error, neighbours and ellipses of a result, against its covariances."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations.errors import SettingsError, TableError
from einschalt.pipeline.assessment.evidence.precision_tables import _enlargement
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import (
    BlockGeometry,
    simulate_block,
)
from einschalt.pipeline.summary.sections.error_sources import source_name
from einschalt.pipeline.summary.summary import sections
from einschalt.theory.adjustment.point_operator import Axes

SETTINGS = [
    Settings(),
    Settings(coverage_mean="most_central", weighting="weighted"),
    Settings(residual_distribution="natural_neighbour"),
]


@pytest.fixture(scope="module")
def tilted_result():
    """One adjustment of models that were oriented by y-parallaxes: C has no zeros."""
    geometry = BlockGeometry(width=3_000.0, height=3_000.0, measurement="parallaxes")
    block = simulate_block("demo", seed=1, geometry=geometry)
    return densify(block, Settings(method="simultaneous"))


def dense_covariance(errors):
    """Covariance of all coordinates together, shape (2 n_points, 2 n_points)."""
    total = 0.0
    for source, chain in errors.chains.items():
        whole = chain.matrix.toarray()
        sigma = errors.axes.each(errors.standard_errors[source]).ravel()
        total = total + (whole * sigma**2) @ whole.conj().T
    if errors.axes is Axes.PLANE:
        return total
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    return np.kron(np.real(total), np.eye(2)) + np.kron(np.imag(total), turn)


@pytest.mark.parametrize("settings", SETTINGS, ids=["all", "weighted", "distributed"])
def test_squares_of_the_sources_add_up(demo_block, settings):
    result = densify(demo_block, settings)
    table = result.error_sources
    assert table["point_id"].tolist() == result.points["point_id"].tolist()
    parts = [name for name in table if name.startswith("standard_error_")]
    parts.remove("standard_error_total")
    assert parts == [
        f"standard_error_{name}" for name in ("control", "high_flight", "low_flight")
    ]
    squares = (table[parts] ** 2).sum(axis=1)
    np.testing.assert_allclose(squares, table["standard_error_total"] ** 2, atol=1e-15)
    np.testing.assert_allclose(
        table["standard_error_total"], result.points["standard_error_total"], atol=1e-9
    )


def test_the_block_is_the_mean_over_the_new_points(good_result):
    table = good_result.block_error_sources
    new = good_result.points["role"] == "new"
    variance = (
        good_result.error_sources[new].filter(like="standard_error") ** 2
    ).mean()
    for row in table.itertuples():
        expected = variance[f"standard_error_{row.source}"]
        assert row.standard_error_total**2 == pytest.approx(expected)
        share = expected / variance["standard_error_total"]
        assert row.share == pytest.approx(share)
    assert table["share"].is_monotonic_decreasing
    assert table["share"].sum() == pytest.approx(1.0)
    assert np.hypot.reduce(table["standard_error_total"]) == pytest.approx(
        good_result.figures.mean_total
    )


@pytest.mark.parametrize(
    ("source", "change"),
    [
        ("control", {"control_standard_error": 0.06}),
        ("high_flight", {"high_m_g_um": 15.0}),
        ("low_flight", {"low_m_g_um": 10.0}),
    ],
)
def test_a_source_twice_as_large_doubles_its_part_alone(source, change):
    def parts(**noise):
        block = simulate_block("demo", seed=4, noise=BlockNoise(**noise))
        plain = densify(block, Settings(weighting="plain"))  # others follow the sources
        return plain.block_error_sources.set_index("source")

    before, after = parts()["standard_error_total"], parts(**change)
    ratio = after["standard_error_total"] / before
    for name, value in ratio.items():
        # operators move a little with the measurements
        assert value == pytest.approx(2.0 if name == source else 1.0, rel=0.01)


@pytest.mark.parametrize("settings", SETTINGS, ids=["all", "weighted", "distributed"])
def test_differences_of_neighbours_have_the_dense_covariance(demo_block, settings):
    result = densify(demo_block, settings)
    table = result.neighbours
    dense = dense_covariance(result.errors)
    place = {name: k for k, name in enumerate(result.points["point_id"])}
    xy = result.points[["easting", "northing"]].to_numpy()
    for row in table.iloc[::7].itertuples():
        i, j = place[row.point_id], place[row.neighbour_id]
        pick = np.zeros((2, len(dense)))
        pick[[0, 1], [2 * i, 2 * i + 1]] -= 1.0
        pick[[0, 1], [2 * j, 2 * j + 1]] += 1.0
        expected = pick @ dense @ pick.T
        assert row.distance == pytest.approx(np.hypot(*(xy[j] - xy[i])))
        along = (xy[j] - xy[i]) / row.distance
        across = along[::-1] * [1, -1]
        for name, value in {
            "standard_error_easting": expected[0, 0],
            "standard_error_northing": expected[1, 1],
            "standard_error_total": np.trace(expected),
            "standard_error_distance": along @ expected @ along,
            "standard_error_across": across @ expected @ across,
        }.items():
            assert getattr(row, name) ** 2 == pytest.approx(value, abs=1e-12)
        own = np.diag(dense)[[2 * i, 2 * i + 1, 2 * j, 2 * j + 1]].sum()
        assert row.standard_error_if_independent**2 == pytest.approx(own, abs=1e-12)


def test_covariance_between_named_points(good_result):
    names = good_result.points["point_id"].to_numpy()
    pairs = [(names[0], names[1]), (names[5], names[5])]
    found = good_result.covariance_between(pairs)
    expected = good_result.errors.covariance_between(names[[0, 5]], names[[1, 5]])
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_allclose(found[1], good_result.errors.covariance[5])
    table = pd.DataFrame(pairs, columns=["one", "two"])
    np.testing.assert_array_equal(good_result.covariance_between(table), found)
    chosen = good_result.neighbour_precision(pairs[:1])
    assert chosen[["point_id", "neighbour_id"]].to_numpy().tolist() == [list(pairs[0])]


@pytest.mark.parametrize("none", [[], (), pd.DataFrame({"one": [], "two": []})])
def test_no_pairs(good_result, none):
    assert good_result.covariance_between(none).shape == (0, 2, 2)
    table = good_result.neighbour_precision(none)
    assert len(table) == 0
    assert list(table) == list(good_result.neighbours)


def test_pairs_that_cannot_be(good_result):
    with pytest.raises(TableError, match=r"point 99x: it is not among the densified"):
        good_result.covariance_between([("99x", "99x")])
    with pytest.raises(TableError, match=r"pairs of the shape \(2,\); expected two"):
        good_result.neighbour_precision(["1", "2"])


def test_nothing_is_said_where_errors_are_not_propagated(given_approximations_result):
    result = given_approximations_result
    for table in (result.error_sources, result.block_error_sources, result.ellipses):
        assert table.empty
    assert result.neighbours.empty
    told = sections(result.assessment)
    assert not told["error_sources"].rows
    assert not told["neighbours"].rows
    with pytest.raises(
        SettingsError, match="given approximate coordinates share errors"
    ):
        result.covariance_between([("1", "2")])


def test_ellipses_of_the_level_of_the_settings(demo_block, good_result):
    wide = densify(demo_block, Settings(confidence=0.99)).ellipses
    assert (wide["confidence"] == 0.99).all()
    usual = good_result.ellipses
    ratio = wide["semi_major"] / usual["semi_major"]
    # the roots of the quantiles of χ² with two degrees of freedom, from tables
    np.testing.assert_allclose(ratio, np.sqrt(9.21034 / 5.99146), rtol=1e-5)
    asked = good_result.confidence_ellipses(0.39346934)
    total = np.hypot(asked["semi_major"], asked["semi_minor"])
    np.testing.assert_allclose(total, good_result.points["standard_error_total"])


def test_ellipses_of_one_adjustment(simultaneous_result):
    """They need nothing but the covariance of each point, which the table gives."""
    points = simultaneous_result.points
    # the quantile of χ² with two degrees of freedom, from a table
    for table, squared in (
        (simultaneous_result.ellipses, 5.99146),
        (simultaneous_result.confidence_ellipses(0.99), 9.21034),
    ):
        assert table["point_id"].tolist() == points["point_id"].tolist()
        total = np.hypot(table["semi_major"], table["semi_minor"])
        expected = np.sqrt(squared) * points["standard_error_total"]
        np.testing.assert_allclose(total, expected, rtol=1e-5)


def test_ellipses_are_enlarged_as_the_figure_to_believe(demo_block):
    """Half of the m_g that made the block is stated: only s_0 shows it."""
    half = demo_block.low_flight.m_g_um / 2.0
    flight = replace(demo_block.low_flight, m_g_um=half)
    block = replace(demo_block, low_flight=flight)
    result = densify(block, Settings(method="simultaneous"))
    points, table = result.points, result.confidence_ellipses(0.39346934)
    assert result.assessment.credible.factor > 1.3
    total = np.hypot(table["semi_major"], table["semi_minor"])
    np.testing.assert_allclose(total, points["standard_error_checked"])
    stated = points["standard_error_total"]
    assert (total > 1.3 * stated).all()
    axes = ["standard_error_easting", "standard_error_northing"]
    np.testing.assert_allclose(np.hypot.reduce(points[axes].to_numpy().T), stated)


def test_no_ellipse_is_made_smaller_or_unknown():
    """By a figure that is smaller, or not known, or where nothing was propagated."""
    points = pd.DataFrame(
        {
            "standard_error_checked": [0.02, 0.03, 0.01, np.nan, 0.5],
            "standard_error_total": [0.02, 0.02, 0.02, 0.02, 0.0],
        }
    )
    np.testing.assert_allclose(_enlargement(points), [1.0, 1.5, 1.0, 1.0, 1.0])


def test_axes_of_an_ellipse_are_those_of_the_covariance(tilted_result):
    """As an eigenvalue decomposition has them."""
    table = tilted_result.confidence_ellipses(0.39346934)
    errors = tilted_result.points
    east, north = errors["standard_error_easting"], errors["standard_error_northing"]
    both = errors["covariance_en"]
    assert (both.abs() > 0.01 * east * north).any()
    covariance = np.array([[east**2, both], [both, north**2]]).transpose(2, 0, 1)
    roots, axes = np.linalg.eigh(covariance)
    np.testing.assert_allclose(table["semi_major"] ** 2, roots[:, 1], rtol=1e-6)
    np.testing.assert_allclose(table["semi_minor"] ** 2, roots[:, 0], rtol=1e-6)
    azimuth = table["azimuth_gon"].to_numpy() * np.pi / 200.0
    along = np.abs(axes[:, 0, 1] * np.sin(azimuth) + axes[:, 1, 1] * np.cos(azimuth))
    np.testing.assert_allclose(along, 1.0, atol=1e-9)


@pytest.mark.parametrize("level", [0.0, 1.0, 95.0, float("nan")])
def test_a_level_that_is_no_probability(good_result, level):
    with pytest.raises(SettingsError, match="a probability above 0 and below 1"):
        good_result.confidence_ellipses(level)


def test_summary_says_sources_and_neighbours(good_result):
    told = sections(good_result.assessment)
    text = told["error_sources"].text()
    first = good_result.block_error_sources.iloc[0]
    assert source_name(first["source"]) in text.splitlines()[2]
    assert "were halved, the new points would" in text
    row = told["neighbours"].rows[0]
    assert row[1] == str(len(good_result.neighbours))
    assert row[3] != row[4]
