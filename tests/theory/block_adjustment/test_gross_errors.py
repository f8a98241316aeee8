"""Gross errors in a block are found where they are, and taken out or weighed down."""

from dataclasses import replace

import numpy as np
import pytest
from tests.theory.block_adjustment.independent_errors import (
    judged,
    without_gross_errors,
)

from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.block_tests import judge_observations
from einschalt.theory.block_adjustment.gross_errors import (
    NORMS,
    OutlierFreeBlock,
    downweight,
    examine_control,
    take_out,
    without_far_control,
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
    cleaned = without_gross_errors(adjust(bad))
    assert list(np.flatnonzero(cleaned.is_out)) == list(rows)


def test_snooping_gives_the_block_without_these_observations(spoilt, dense):
    _, bad, rows = spoilt
    cleaned = without_gross_errors(adjust(bad))
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


def test_a_point_does_not_hang_on_the_one_measurement_that_the_others_contradict(
    make_block,
):
    """All others were taken out in its place, and nothing refuses one that is alone."""
    block = make_block("dense grid", "affine", every=3)
    is_free = ~block.is_given.any(axis=1)
    n_models = np.bincount(block.point, minlength=block.n_points)
    point = np.flatnonzero(is_free & (n_models >= 4))[0]
    wrong, *good = np.flatnonzero(block.point == point)
    xy = block.xy.copy()
    xy[wrong] += 100.0
    bad = replace(block, xy=xy)
    is_out = np.zeros(len(block.point), dtype=bool)
    is_out[good] = True
    begun = replace(OutlierFreeBlock.whole(adjust(bad)), is_out=is_out)
    found = take_out(begun.readjusted(bad), bad, 0.001, judged)
    assert list(np.flatnonzero(found.is_out)) == [wrong]
    np.testing.assert_allclose(
        found.solution.points[point], adjust(block).points[point], rtol=0, atol=0.1
    )


def test_nothing_is_taken_out_of_a_good_block(make_block):
    n_out = sum(
        without_gross_errors(adjust(make_block("grid", seed=seed))).is_out.sum()
        for seed in range(12)
    )
    # 108 models that lose a point with a probability of 0.001 each
    assert n_out <= 1


def robust_block(block, norm):
    """Solution with robust weights."""
    return downweight(without_gross_errors(adjust(block)), block, norm).solution


@pytest.mark.parametrize("norm", ["huber", "tukey"])
def test_robust_weights_solve_their_own_equations(spoilt, norm):
    """The weights belong to the residuals that they lead to."""
    good, bad, rows = spoilt
    plain, robust = adjust(bad), robust_block(bad, norm)
    factors = (bad.standard_error / robust.observations.standard_error) ** 2
    assert factors[rows].max() < (0.6 if norm == "huber" else 1e-6)
    truth = adjust(good).points
    worse = np.abs(plain.points - truth).max()
    assert np.abs(robust.points - truth).max() < 0.5 * worse
    length = np.sqrt((robust.residuals**2).sum(axis=1)) / bad.standard_error
    # weighed with all of them; what is reported counts no gross error
    share = plain.redundancy / (2 * len(length))
    scale = np.median(length) / np.sqrt(2.0 * np.log(2.0) * share)
    wanted = np.maximum(NORMS[norm][2].weights(length / scale), 1e-9)
    np.testing.assert_allclose(factors, wanted, atol=5e-3)


@pytest.mark.parametrize("norm", ["huber", "tukey"])
def test_what_was_refused_before_it_weighs_less_remains_known(spoilt, norm):
    """Its residual by the weights of the norm is one that nothing refuses."""
    _, bad, rows = spoilt
    cleaned = downweight(without_gross_errors(adjust(bad)), bad, norm)
    assert not cleaned.is_out.any()
    assert set(np.flatnonzero(cleaned.is_refused)) == set(rows)


def test_of_two_measurements_of_a_point_one_stays(make_block):
    """Both contradict each other alike, and only rounding tells one from the other."""
    for seed in range(12):
        good = make_block("grid", "affine", every=3, seed=seed)
        holders = np.bincount(good.point)
        is_pair = (holders == 2) & ~good.is_control
        row = np.flatnonzero(is_pair[good.point])[seed]
        xy = good.xy.copy()
        xy[row] += (0.2, -0.1)
        found = without_gross_errors(adjust(replace(good, xy=xy))).is_out
        assert np.flatnonzero(found).tolist() != []
        assert found[good.point == good.point[row]].sum() == 1


@pytest.fixture
def make_large_block(make_block, monkeypatch):
    """So many observations that p is 0 for all that a large error has touched."""
    corners = [(480.0 * i, 480.0 * j) for i in range(30) for j in range(30)]
    monkeypatch.setitem(make_block.layouts, "large", corners)
    return lambda every: make_block("large", "affine", every=every)


@pytest.mark.slow
def test_an_exchanged_name_costs_its_own_measurement_only(make_large_block):
    """An error of 400 m makes half of the neighbourhood look wrong."""
    large_block = make_large_block(every=5)
    good = adjust(large_block)
    by_chance = set(np.flatnonzero(without_gross_errors(good).is_out))
    assert len(by_chance) <= 4  # of 900 models, each with a probability of 0.001
    holders = np.bincount(large_block.point)
    is_new = ~large_block.is_control[large_block.point]
    rows = np.flatnonzero(is_new & (holders[large_block.point] >= 3))
    for row in rows[[10, 1000, 2000]]:
        xy = large_block.xy.copy()
        xy[row] += (40.0, -30.0)
        bad = adjust(replace(large_block, xy=xy))
        assert (judge_observations(bad, bad.observations).p_value == 0.0).any()
        found = set(np.flatnonzero(without_gross_errors(bad).is_out))
        assert found == {int(row), *by_chance}


def test_all_wrong_control_is_named_however_much_it_is(make_large_block):
    """One control point in ten."""
    large_block = make_large_block(every=2)
    rng = np.random.default_rng(1)
    given = np.flatnonzero(large_block.is_control)
    wrong = rng.choice(given, 110, replace=False)
    control = large_block.control.copy()
    control[wrong] += (1.0, -0.7)
    found = examine_control(adjust(replace(large_block, control=control)), 0.001)
    assert set(wrong) <= set(np.flatnonzero(found.is_suspect))
    assert found.is_suspect.sum() <= 1.05 * len(wrong)
    np.testing.assert_allclose(
        np.median(found.error[wrong], axis=0), [1.0, -0.7], atol=0.02
    )


def test_control_that_is_far_off_is_left_out_and_no_other(make_block):
    block = make_block("dense grid", "affine", every=3)
    given = np.flatnonzero(block.is_control)
    same = without_far_control(adjust(block), 0.01)
    assert list(np.flatnonzero(same.is_control)) == list(given)
    control = block.control.copy()
    control[given[2]] += [5.0, -3.0]
    left = without_far_control(adjust(replace(block, control=control)), 0.01)
    assert list(np.flatnonzero(left.is_control)) == list(np.delete(given, 2))
    # also of the redundancy
    assert adjust(left).redundancy == adjust(block).redundancy - 2
