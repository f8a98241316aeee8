"""Gross errors in a block are found where they are, and taken out or weighed down."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.gross_errors import (
    NORMS,
    downweight,
    snoop_block,
)


@pytest.fixture
def spoilt(make_block):
    """A block with four gross errors of 0.4 m in points that four models hold."""
    block = make_block("dense grid", "affine", every=3)
    holders = np.bincount(block.point)
    rng = np.random.default_rng(7)
    rows = rng.choice(np.flatnonzero(holders[block.point] >= 4), 4, replace=False)
    xy = block.xy.copy()
    xy[rows] += np.array([0.04, -0.03])
    return block, replace(block, xy=xy), np.sort(rows)


def test_snooping_finds_exactly_the_gross_errors(spoilt):
    _, bad, rows = spoilt
    cleaned = snoop_block(adjust(bad), (), 0.001)
    assert list(np.flatnonzero(cleaned.is_out)) == list(rows)


def test_snooping_gives_the_block_without_these_observations(spoilt, dense):
    _, bad, rows = spoilt
    cleaned = snoop_block(adjust(bad), (), 0.001)
    keep = np.ones(len(bad.model), dtype=bool)
    keep[rows] = False
    part = bad.of_rows(np.flatnonzero(keep), np.arange(bad.n_models))
    expected = dense(part.observations)
    np.testing.assert_allclose(
        cleaned.solution.points[part.points], expected.points, rtol=0, atol=1e-8
    )
    assert cleaned.solution.redundancy == expected.redundancy
    assert cleaned.solution.s_0 == pytest.approx(
        np.sqrt(expected.sum_of_squares / expected.redundancy), rel=1e-6
    )


def test_nothing_is_taken_out_of_a_good_block(make_block):
    n_out = sum(
        snoop_block(adjust(make_block("grid", seed=seed)), (), 0.001).is_out.sum()
        for seed in range(12)
    )
    # 108 models that lose a point with a probability of 0.001 each
    assert n_out <= 1


@pytest.mark.parametrize("norm", ["huber", "tukey"])
def test_robust_weights_solve_their_own_equations(spoilt, norm):
    """The weights belong to the residuals that they lead to."""
    good, bad, rows = spoilt
    plain, robust = adjust(bad), downweight(adjust(bad), (), norm, 0.001).solution
    factors = (bad.standard_error / robust.observations.standard_error) ** 2
    assert factors[rows].max() < (0.6 if norm == "huber" else 1e-6)
    truth = adjust(good).points
    worse = np.abs(plain.points - truth).max()
    assert np.abs(robust.points - truth).max() < 0.5 * worse
    length = np.sqrt((robust.residuals**2).sum(axis=1)) / bad.standard_error
    share = robust.redundancy / (2 * len(length))
    scale = np.median(length) / np.sqrt(2.0 * np.log(2.0) * share)
    wanted = np.maximum(NORMS[norm][2].weights(length / scale), 1e-9)
    np.testing.assert_allclose(factors, wanted, atol=5e-3)


def test_of_two_measurements_of_a_point_one_stays(make_block):
    """Both contradict each other alike, and only rounding tells one from the other."""
    for seed in range(12):
        good = make_block("grid", "affine", every=3, seed=seed)
        holders = np.bincount(good.point)
        is_pair = (holders == 2) & ~good.is_control
        row = np.flatnonzero(is_pair[good.point])[seed]
        xy = good.xy.copy()
        xy[row] += (0.2, -0.1)
        found = snoop_block(adjust(replace(good, xy=xy)), (), 0.001).is_out
        assert np.flatnonzero(found).tolist() != []
        assert found[good.point == good.point[row]].sum() == 1
