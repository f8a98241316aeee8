"""Errors of y-parallaxes reach the final points as the propagation says."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import (
    PRESETS,
    BlockNoise,
    simulate_block,
)
from einschalt.pipeline.summary.sections.precision import remarks

pytestmark = pytest.mark.slow

PLAN = ["easting", "northing"]
FLIGHTS = ("high_flight", "low_flight")
SIMULTANEOUS = Settings(method="simultaneous")


@cache
def block_of(measurement="parallaxes", seed=0, **noise):
    geometry = replace(PRESETS["demo"].geometry, measurement=measurement)
    return simulate_block(
        "demo", seed=seed, geometry=geometry, noise=BlockNoise(**noise)
    )


def with_other_parallaxes(block, names):
    """The block with parallaxes that differ by some micrometres."""
    rng = np.random.default_rng(3)
    flights = {}
    for name in names:
        flight = getattr(block, name)
        table = flight.y_parallaxes.copy()
        table["y_parallax"] += 1e-3 * rng.standard_normal(len(table))
        flights[name] = replace(flight, y_parallaxes=table)
    return replace(block, **flights)


def errors_behind(before, after):
    """Independent errors that moved the model points from one result to the other."""
    found = []
    for name, errors in before.orientation_errors.items():
        old, new = (
            r.solution.model_points[name][["x", "y"]].to_numpy()
            for r in (before, after)
        )
        for model in range(errors.n_models):
            rows = errors.model == model
            design = errors.factors[rows][:, :2].reshape(-1, 5)
            shift = (new - old)[rows].ravel()
            own = np.linalg.lstsq(design, shift, rcond=None)[0]
            # five elements explain what the parallaxes do to a model
            assert np.abs(design @ own - shift).max() <= 2e-3 * np.abs(shift).max()
            found += [*own, 0.0]
    return np.array(found)


@pytest.fixture(
    scope="module",
    params=[
        # weights of least variance move a little too
        ("affine", Settings(weighting="plain")),
        ("helmert", Settings(weighting="plain")),
        ("affine", Settings(weighting="plain", iterations=3)),
    ],
    ids=["affine", "helmert", "iterated"],
)
def unmoved(request):
    """Settings, and a block of a kind with its result."""
    kind, settings = request.param
    block = block_of(seed=4)
    kinds = {
        name: replace(getattr(block, name), transformation=kind) for name in FLIGHTS
    }
    block = replace(block, **kinds)
    return settings, block, densify(block, settings)


@pytest.mark.parametrize("names", [FLIGHTS, FLIGHTS[:1], FLIGHTS[1:]])
def test_points_move_as_the_operators_say(names, unmoved):
    settings, block, before = unmoved
    after = densify(with_other_parallaxes(block, names), settings)
    carried = before.errors.chains["orientation"].apply(errors_behind(before, after))
    moved = (after.solution.points[PLAN] - before.solution.points[PLAN]).to_numpy()
    largest = np.abs(moved).max()
    assert largest > 1e-3
    # the fit is linear; its matrix changes by 1e-3 with the elements
    np.testing.assert_allclose(carried.reshape(-1, 2), moved, atol=5e-3 * largest)


def test_true_errors_are_those_that_are_claimed():
    """Where most of them come from the orientations."""
    squares, shares = [], []
    for seed in range(12):
        block = block_of(seed=seed, y_parallax_um=20.0)
        result = densify(block, Settings(coverage_mean="most_central"))
        truth = block.truth.set_index("point_id").loc[
            result.solution.points["point_id"], PLAN
        ]
        error = result.solution.points[PLAN].to_numpy() - truth.to_numpy()
        inverse = np.linalg.inv(result.errors.covariance)
        squares.append(np.einsum("ni,nij,nj->n", error, inverse, error).mean() / 2.0)
        table = result.block_error_sources.set_index("source")["share"]
        shares.append(table["orientation"])
    scatter = np.std(squares, ddof=1) / np.sqrt(len(squares))
    assert np.mean(squares) == pytest.approx(1.0, abs=3.0 * scatter)
    assert scatter < 0.15
    # without it the claim would be too small by as much
    assert np.mean(shares) > 0.5


def test_twice_the_error_of_parallaxes_doubles_its_part():
    def parts(size):
        block = block_of(seed=2, y_parallax_um=size)
        # weights of least variance would follow the errors
        table = densify(block, Settings(weighting="plain")).block_error_sources
        return table.set_index("source")["standard_error_total"]

    small = parts(5.0)
    assert small["orientation"] ** 2 > 0.08 * (small**2).sum()
    ratio = parts(10.0) / small
    assert ratio["orientation"] == pytest.approx(2.0, rel=0.01)
    assert ratio.drop("orientation").to_numpy() == pytest.approx(1.0, rel=0.01)


def test_sources_tables_and_tests_hold_together():
    result = densify(block_of(seed=1))
    table = result.error_sources
    parts = [n for n in table if n.startswith("standard_error_") and "total" not in n]
    assert "standard_error_orientation" in parts
    squares = (table[parts] ** 2).sum(axis=1)
    np.testing.assert_allclose(squares, table["standard_error_total"] ** 2)
    assert result.claim.is_supported
    assert not result.claim.is_assumed
    assert result.left_out_control.normalized_square < 3.0
    assert result.patterns.strain is None
    assert "Strain was not tested: errors of the orientations" in result.summary()
    assert "of the orientations from sigma_0" in remarks(result.assessment.precision)[1]
    assert "relative orientation" in result.summary()


def test_parallaxes_without_redundancy_leave_the_size_unknown():
    block = block_of()
    flights = {}
    for name in FLIGHTS:
        flight = getattr(block, name)
        table = flight.y_parallaxes
        five = table.groupby(["coverage", "model_id"]).cumcount() < 5
        flights[name] = replace(flight, y_parallaxes=table[five].reset_index(drop=True))
    result = densify(replace(block, **flights))
    assert result.orientation_errors == dict.fromkeys(FLIGHTS)
    assert result.errors is None
    adjusted = densify(replace(block, **flights), SIMULTANEOUS)
    assert "standard_error_total" not in adjusted.solution.points
    assert "y-parallaxes without redundancy do not show" in one_line(adjusted)


def one_line(result):
    return " ".join(result.summary().split())


def test_points_adjusted_simultaneously_have_the_errors_that_are_claimed():
    squares, ratios = [], []
    for seed in range(8):
        block = block_of(seed=seed, y_parallax_um=20.0)
        result = densify(block, SIMULTANEOUS)
        points = result.solution.points[result.solution.points["role"] == "new"]
        truth = block.truth.set_index("point_id").loc[points["point_id"], PLAN]
        error = points[PLAN].to_numpy() - truth.to_numpy()
        covariance = np.empty((len(points), 2, 2))
        for k, name in enumerate(("easting", "northing")):
            covariance[:, k, k] = points[f"standard_error_{name}"] ** 2
        covariance[:, 0, 1] = covariance[:, 1, 0] = points["covariance_en"]
        inverse = np.linalg.inv(covariance)
        squares.append(np.einsum("ni,nij,nj->n", error, inverse, error).mean() / 2.0)
        two_step = result.two_step.figures.mean_total
        ratios.append(result.figures.mean_total / two_step)
        assert 0.9 < result.simultaneous.s_0 < 1.1
    scatter = np.std(squares, ddof=1) / np.sqrt(len(squares))
    assert np.mean(squares) == pytest.approx(1.0, abs=3.0 * scatter)
    assert scatter < 0.15
    assert np.mean(ratios) < 0.55
    assert "of the orientations from sigma_0 of all models" in one_line(result)


def test_orientations_that_were_adjusted_are_no_larger_than_their_errors():
    block = block_of(seed=4, y_parallax_um=20.0)
    found = densify(block, SIMULTANEOUS).simultaneous.solution
    assert found.orientation.shape == (found.observations.n_models, 5)
    # the models know of some of the elements more than the parallaxes do
    assert 0.3 < np.sqrt(np.mean(found.orientation**2)) < 1.1


def test_images_have_standard_errors_in_the_simultaneous_adjustment_too():
    result = densify(block_of("images"), SIMULTANEOUS)
    assert result.solution.points["standard_error_total"].notna().all()
    assert result.figures.mean_total > 0.0


def test_good_measurements_of_models_with_bad_parallaxes_are_no_gross_errors():
    for seed in range(4):
        block = block_of(seed=seed, y_parallax_um=40.0)
        result = densify(block, Settings(outliers="snoop"))
        # one model in a thousand loses a point
        assert len(result.gross_measurements) <= 1


def test_measuring_errors_are_estimated_beside_those_of_orientations():
    z = []
    for seed in range(6):
        block = block_of(seed=seed, y_parallax_um=15.0)
        given = replace(block.low_flight, m_g_um=7.5)
        found = densify(replace(block, low_flight=given)).components
        for component, true in ((found.high_flight, 7.5), (found.low_flight, 5.0)):
            z.append((component.estimated - true) / component.standard_error)
    assert abs(np.mean(z)) < 3.3 / np.sqrt(len(z))
    assert np.sqrt(np.mean(np.square(z))) < 1.0 + 3.3 / np.sqrt(2 * len(z))
