"""Pairs of given points exchanged at once, against as many adjustments."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.exchanged_points import pairs_of_given_points


def exchanged(block, one, other):
    control = block.control.copy()
    control[[one, other]] = control[[other, one]]
    return replace(block, control=control)


def without_control_errors(block):
    """Sum of squares that is left where given coordinates may be anything."""
    free = replace(block, control_covariance=block.control_covariance * 1e12)
    return adjust(free).sum_of_squares


@pytest.mark.parametrize("kind", ["affine", "helmert", "mixed"])
def test_pairs_are_those_of_as_many_adjustments(make_block, kind):
    block = make_block("grid", kind)
    places = np.flatnonzero(block.is_control)
    bad = exchanged(block, places[1], places[4])
    pairs = pairs_of_given_points(adjust(bad))
    np.testing.assert_array_equal(pairs.places, places)
    least = without_control_errors(bad)
    before = adjust(bad).sum_of_squares - least
    for one, other in [(0, 1), (1, 4), (2, 5), (4, 0)]:
        again = adjust(exchanged(bad, places[one], places[other]))
        left = (again.sum_of_squares - least) / before
        assert pairs.left[one, other] == pytest.approx(left, rel=1e-5, abs=1e-7)
        assert pairs.left[other, one] == pytest.approx(pairs.left[one, other])
    best = np.unravel_index(np.argmin(pairs.left), pairs.left.shape)
    assert set(best) == {1, 4}


@pytest.mark.parametrize(
    ("kind", "every"), [("affine", 4), ("affine", 8), ("helmert", 8)]
)
@pytest.mark.parametrize("share", [0.3, 1.0])
def test_chance_is_that_of_random_errors(make_block, kind, every, share):
    """Errors of any direction leave so little as often as is said, or less often."""
    block = make_block("grid", kind, every=every)
    places = np.flatnonzero(block.is_control)
    # about as large as the points lie apart, where an exchange fits best
    size = share * np.ptp(block.control[places])
    rng = np.random.default_rng(1)
    found = []
    for _ in range(100):
        control = block.control.copy()
        control[places] += size * rng.normal(size=(len(places), 2))
        pairs = pairs_of_given_points(adjust(replace(block, control=control)))
        found.append(pairs.chance().min())
    assert np.mean(np.array(found) <= 0.1) <= 0.1
    assert min(found) < 0.5


def test_of_many_points_those_that_contradict_most_are_tried(make_block):
    block = make_block("dense grid", "affine", every=3)
    places = np.flatnonzero(block.is_control)
    solution = adjust(exchanged(block, places[3], places[7]))
    pairs = pairs_of_given_points(solution, most=8)
    assert len(pairs.places) == 8 < len(places)
    best = np.unravel_index(np.argmin(pairs.left), pairs.left.shape)
    assert set(pairs.places[list(best)]) == {places[3], places[7]}
    assert pairs.chance().min() < 1e-6


def test_held_control_is_not_exchanged(make_block):
    block = make_block("grid", "affine")
    covariance = block.control_covariance.copy()
    covariance[block.is_control] = 0.0
    pairs = pairs_of_given_points(adjust(replace(block, control_covariance=covariance)))
    assert len(pairs.places) == 0
    assert pairs.left.shape == (0, 0)
