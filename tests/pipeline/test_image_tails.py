"""Claims of blocks from images of which a share of the points is much worse."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.judged_alone import judged_alone

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

pytestmark = pytest.mark.slow

PLANE = ["easting", "northing"]
SHARE, WORSE = 0.1, 4.0
SEEDS = (810, 811, 812)
METRES_OF_FEW = 0.06


def image_block(seed, noise=None, **changed):
    geometry = replace(PRESETS["demo"].geometry, measurement="images", **changed)
    return simulate_block("demo", seed=seed, geometry=geometry, noise=noise)


@cache
def block_with_tails(seed):
    """A tenth of the image points with errors four times as large as stated."""
    block, rng = image_block(seed), np.random.default_rng(seed)
    flights = {}
    for name, flight in block.flights.items():
        points = flight.image_points
        more = np.sqrt(WORSE**2 - 1.0) * flight.m_g_um * 1e-3 / np.sqrt(2.0)
        is_worse = rng.random(len(points)) < SHARE
        moved = more * rng.standard_normal((len(points), 2)) * is_worse[:, None]
        points = points.assign(x=points.x + moved[:, 0], y=points.y + moved[:, 1])
        flights[name] = replace(flight, image_points=points)
    return replace(block, **flights)


def claimed_and_true(result, truth):
    """Root mean squares of the new points in plan [m]."""
    new = result.points[result.points["role"] == "new"].set_index("point_id")
    error = new[PLANE] - truth.set_index("point_id").loc[new.index, PLANE]
    true = np.sqrt(np.mean(np.sum(error.to_numpy() ** 2, axis=1)))
    return np.sqrt(np.mean(new["standard_error_total"] ** 2)), true


@pytest.mark.parametrize(
    ("method", "outliers"),
    [
        ("two_step", "keep"),
        ("simultaneous", "keep"),
        ("simultaneous", "snoop"),
        ("simultaneous", "tukey"),
    ],
)
def test_claims_count_the_errors_that_image_points_show(method, outliers):
    """With stated errors they were 0.5 to 0.8 of the true ones."""
    squares = np.zeros(2)
    for seed in SEEDS:
        block = block_with_tails(seed)
        result = densify(block, Settings(method=method, outliers=outliers))
        squares += np.square(claimed_and_true(result, block.truth))
        assert "heavy_tails_of_image_points" in judged_alone(result)
    # a few points decide what is true: three blocks know the ratio to 15 %
    assert np.sqrt(squares[0] / squares[1]) == pytest.approx(1.0, abs=0.3)


def test_stated_errors_remain_what_was_given():
    """What is counted with is told beside it, and not in its place."""
    block = block_with_tails(SEEDS[0])
    result = densify(block, Settings(method="two_step"))
    given = result.examination.block.low_flight
    assert given.m_g_um == block.low_flight.m_g_um
    assert given.m_g_counted_um > 1.2 * given.m_g_um


def test_models_that_contradict_the_block_are_named_and_left_out():
    """Of three per cent of gross errors in images; the block was refused for them."""
    noise = BlockNoise(
        high_gross_error_share=0.03,
        low_gross_error_share=0.03,
        high_gross_error_um=300.0,
        low_gross_error_um=3800.0,
    )
    block = image_block(202, noise)
    result = densify(block, Settings(method="simultaneous", outliers="snoop"))
    assert len(result.failures) > 0
    reasons = set(result.failures["reason"])
    assert any("contradict the rest of the block" in reason for reason in reasons)
    claimed, true = claimed_and_true(result, block.truth)
    assert true < METRES_OF_FEW
    assert claimed == pytest.approx(true, rel=0.3)
    # what they would do in the two steps counts for nothing: 2.9 m were told
    assert result.examination.credible.value == pytest.approx(true, rel=0.3)
    codes = set(judged_alone(result))
    assert not codes & {"wrong_control_height", "coverages_that_differ"}


# of 3 % of the image points [µm], high and low, of blocks with six check points; what
# was told was 17 and 39 times what is true
ROBUST = [(934, "huber", (3081.3, 114.1)), (932, "tukey", (67.6, 2024.6))]


@pytest.mark.parametrize(("seed", "outliers", "sizes"), ROBUST)
def test_what_weighs_less_is_not_what_the_rest_is_tested_by(seed, outliers, sizes):
    """Two steps that hold gross errors, and a check point that hangs on them."""
    noise = BlockNoise(
        high_gross_error_share=0.03,
        low_gross_error_share=0.03,
        high_gross_error_um=sizes[0],
        low_gross_error_um=sizes[1],
    )
    block = image_block(seed, noise, n_check=6)
    result = densify(block, Settings(method="simultaneous", outliers=outliers))
    _, true = claimed_and_true(result, block.truth)
    assert true < METRES_OF_FEW
    told = result.examination.credible.value
    assert 0.8 * true < told < 1.6 * true
    # the two steps beside hold what the adjustment would hold without gross errors
    held = result.solution.two_step
    assert held is not result.solution.all_in_two_steps
    assert held.settings.outliers == "snoop"
