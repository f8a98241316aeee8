"""Means by the joint covariance of a point's values, in whole blocks."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from tests.given_approximations import onto_given_approximations
from tests.theory.adjustment.best_shares import best_shares

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import (
    PRESETS,
    BlockGeometry,
    simulate_block,
)

PLAN = ["easting", "northing"]
RIGOROUS = Settings(weighting="rigorous")
PLAIN = Settings(weighting="plain")
SEEDS = range(6)


def claimed_and_true(block, settings):
    """Mean squares over the new points, TOTAL [m²]."""
    result = densify(block, settings)
    points = result.solution.points[result.solution.points["role"] == "new"]
    true = block.truth.set_index("point_id").loc[points["point_id"], PLAN]
    error = points[PLAN].to_numpy() - true.to_numpy()
    claimed = np.mean(points["standard_error_total"] ** 2)
    return claimed, np.mean(np.sum(error**2, axis=1))


def with_a_weak_model(block):
    """One high model keeps only three of its control points, nearly in a line."""
    points, control = block.high_flight.model_points, block.control_points
    used = control.loc[control["role"] != "check", "point_id"]
    first = points["coverage"].eq("1") & points["model_id"].eq(points["model_id"][0])
    on_control = points[first & points["point_id"].isin(used)]
    line = on_control["y"].to_numpy()
    kept = on_control.iloc[np.argsort(np.abs(line - np.median(line)))[:3]]
    is_out = points.index.isin(on_control.index.difference(kept.index))
    left = points[~is_out].reset_index(drop=True)
    is_left = control["point_id"].isin(left["point_id"])
    return replace(
        block,
        control_points=control[is_left].reset_index(drop=True),
        high_flight=replace(block.high_flight, model_points=left),
    )


@pytest.mark.slow
@pytest.mark.parametrize("spoil", [lambda block: block, with_a_weak_model])
def test_it_claims_less_and_is_better(spoil):
    blocks = [spoil(simulate_block("demo", seed=seed)) for seed in SEEDS]
    plain, rigorous = (
        np.array([claimed_and_true(block, settings) for block in blocks])
        for settings in (PLAIN, RIGOROUS)
    )
    assert (rigorous[:, 0] < plain[:, 0]).all()
    assert rigorous[:, 1].mean() < plain[:, 1].mean()
    assert rigorous[:, 1].mean() / rigorous[:, 0].mean() == pytest.approx(1, abs=0.4)


@pytest.mark.parametrize("transformation", ["affine", "helmert"])
@pytest.mark.parametrize("measurement", ["machine", "parallaxes", "images"])
def test_the_claim_is_that_of_the_weights_that_were_used(measurement, transformation):
    geometry = replace(
        PRESETS["demo"].geometry,
        measurement=measurement,
        transformation=transformation,
    )
    result = densify(simulate_block("demo", seed=2, geometry=geometry), RIGOROUS)
    solution = result.solution
    means, covariance = solution.means, solution.errors.covariance
    for place in range(0, len(means.points), 9):
        name = means.points["point_id"].iloc[place]
        own = means.used["point_id"].to_numpy() == name
        rows, shares = means.row_numbers[own], means.weights[own]
        k = len(rows)
        pairs = np.array([(i, j) for i in rows for j in rows])
        blocks = solution.propagation.covariances_of_values(pairs)
        blocks = blocks.reshape(k, k, 2, 2)
        np.testing.assert_allclose(shares, best_shares(blocks[None])[0], atol=1e-6)
        found = np.einsum("iab,ijbc,jdc->ad", shares, blocks, shares)
        np.testing.assert_allclose(found, covariance[place], rtol=1e-6, atol=1e-12)


def test_heights_have_their_part_in_it():
    geometry = BlockGeometry(
        width=2_200.0,
        height=2_200.0,
        point_spacing=275.0,
        measurement="machine",
        transformation="helmert_3d",
        control_per_model=9,
    )
    block = simulate_block("demo", seed=1, geometry=geometry)
    plain, rigorous = (densify(block, s) for s in (PLAIN, RIGOROUS))
    assert rigorous.solution.means.weights.shape[1:] == (3, 3)
    for column in ("standard_error_total", "standard_error_height"):
        less = rigorous.solution.points[column] - plain.solution.points[column]
        assert less.mean() < 0.0


def test_further_passes_keep_the_weights_of_the_first():
    block = simulate_block("demo", seed=4)
    result = densify(block, Settings(weighting="rigorous", iterations=4))
    passes = result.solution.iteration.passes
    assert len(passes) > 2
    for before, after in pairwise(passes):
        np.testing.assert_allclose(
            after.means.weights, before.means.weights, atol=1e-12
        )
    claimed = np.mean(result.solution.points["standard_error_total"] ** 2)
    plain = densify(block, Settings(weighting="plain", iterations=4))
    plain = plain.solution.points["standard_error_total"]
    assert claimed < 1.05 * np.mean(plain**2)


def test_a_block_with_gross_errors_is_averaged_without_them():
    block = simulate_block("demo", seed=1)
    points = block.low_flight.model_points.copy()
    points.loc[7, "x"] += 0.3
    low = replace(block.low_flight, model_points=points)
    settings = Settings(weighting="rigorous", outliers="snoop")
    means = densify(replace(block, low_flight=low), settings).solution.means
    assert 7 not in means.row_numbers
    name = points.loc[7, "point_id"]
    total = means.weights[(means.used["point_id"] == name).to_numpy()].sum(axis=0)
    np.testing.assert_allclose(total, np.eye(2), atol=1e-12)


def without_errors_of_control(block):
    control = block.control_points.drop(columns="standard_error_m")
    return replace(block, control_points=control)


def with_a_length_alone(block):
    given = onto_given_approximations(block, photograph_error=0.1)
    lengths = {"approximate_points": 500.0}
    return replace(given, correlation_lengths_m=lengths, approximate_m_0_m=None)


@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (without_errors_of_control, "control points have no standard_error_m"),
        (
            lambda block: onto_given_approximations(block, photograph_error=0.1),
            "given approximate coordinates share errors of unknown size",
        ),
        (with_a_length_alone, "correlation_length_m have no m_0_m.*Give m_0_m in"),
    ],
)
def test_without_the_size_of_an_error_it_is_refused_before_the_work(
    spoil, words, method
):
    block, stages = spoil(simulate_block("demo", seed=1)), []
    settings = Settings(weighting="rigorous", method=method)
    with pytest.raises(SettingsError, match=f'weighting = "rigorous", but.*{words}'):
        densify(block, settings, progress=lambda *stage: stages.append(stage))
    assert stages == []
