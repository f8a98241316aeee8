"""Names of given points put right at once, against as many adjustments."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.exchanged_points import (
    NOWHERE,
    names_of_given_points,
    put_right,
    slipped_names,
)


def renamed(block, order):
    """The coordinates of the k-th given point under the name of the order[k]-th."""
    places = np.flatnonzero(block.is_control)
    control = block.control.copy()
    control[places[order]] = control[places]
    return replace(block, control=control)


def exchanged(block, one, other):
    order = np.arange(np.count_nonzero(block.is_control))
    order[[one, other]] = order[[other, one]]
    return renamed(block, order)


def without_control_errors(block):
    """Sum of squares that is left where given coordinates may be anything."""
    free = replace(block, control_covariance=block.control_covariance * 1e12)
    return adjust(free).sum_of_squares


@pytest.mark.parametrize("kind", ["affine", "helmert", "mixed"])
def test_pairs_are_those_of_as_many_adjustments(make_block, kind):
    bad = exchanged(make_block("grid", kind), 1, 4)
    names = names_of_given_points(adjust(bad))
    np.testing.assert_array_equal(names.places, np.flatnonzero(bad.is_control))
    least = without_control_errors(bad)
    before = adjust(bad).sum_of_squares - least
    pairs = names.left_with_another_pair(names.as_given)
    for one, other in [(0, 1), (1, 4), (2, 5), (4, 0)]:
        again = adjust(exchanged(bad, one, other))
        left = (again.sum_of_squares - least) / before
        assert pairs[one, other] == pytest.approx(left, rel=1e-5, abs=1e-7)
        assert pairs[other, one] == pytest.approx(pairs[one, other])
    best = np.unravel_index(np.argmin(pairs), pairs.shape)
    assert set(best) == {1, 4}
    (found, *_) = put_right(names)
    np.testing.assert_array_equal(
        np.flatnonzero(found.orders[0] != names.as_given), best
    )
    assert found.left[0] == pairs[1, 4]


def test_further_pairs_are_those_of_as_many_adjustments(make_block):
    order = np.array([2, 0, 1, 4, 3, *range(5, 9)])
    block = make_block("grid", "affine", every=5)
    bad = renamed(block, np.resize(order, np.count_nonzero(block.is_control)))
    names = names_of_given_points(adjust(bad))
    least = without_control_errors(bad)
    before = adjust(bad).sum_of_squares - least
    first = exchanged(bad, 0, 2)
    order = names.as_given
    order[[0, 2]] = [2, 0]
    further = names.left_with_another_pair(order)
    for one, other in [(3, 4), (0, 1), (1, 2)]:
        left = (adjust(exchanged(first, one, other)).sum_of_squares - least) / before
        assert further[one, other] == pytest.approx(left, rel=1e-5, abs=1e-7)
        again = order.copy()
        again[[one, other]] = order[[other, one]]
        assert names.left(again[None])[0] == pytest.approx(left, rel=1e-5, abs=1e-7)


MIXED = {
    "two pairs": [(0, 5), (3, 1)],
    "three that went round": [(2, 6), (6, 8)],
    "five that went round": [(0, 3), (3, 5), (5, 7), (7, 8)],
}


@pytest.mark.parametrize("kind", ["affine", "helmert"])
@pytest.mark.parametrize("mixed", MIXED)
def test_names_that_were_mixed_are_put_right(make_block, kind, mixed):
    block = make_block("grid", kind)
    n = np.count_nonzero(block.is_control)
    order = np.arange(n)
    for one, other in MIXED[mixed]:
        order[[one, other]] = order[[other, one]]
    names = names_of_given_points(adjust(renamed(block, order)))
    found = put_right(names)[len(MIXED[mixed]) - 1]
    np.testing.assert_array_equal(found.orders[0], order)
    assert found.left[0] < 1e-4
    assert found.log_chance[0] < np.log(1e-6)
    assert found.left[0] < 0.04 * put_right(names)[0].left[0]


def slipped_block(make_block, rows):
    """A list in another order than its points, of which all but two have slipped."""
    block = make_block("dense grid", "affine", every=5)
    n = np.count_nonzero(block.is_control)
    listed = np.random.default_rng(2).permutation(n)
    order = np.arange(n)
    order[listed[2:]] = np.roll(listed[2:], rows)
    return renamed(block, order), order, listed


@pytest.mark.parametrize("rows", [1, -2])
def test_names_that_slipped_are_one_mistake(make_block, rows):
    """Of a part of the list, in the order of the list."""
    bad, order, listed = slipped_block(make_block, rows)
    names = names_of_given_points(adjust(bad))
    found = put_right(names, slipped_names(listed, len(listed)))[0]
    assert found.n_mistakes == 1
    np.testing.assert_array_equal(found.orders[0], order)
    assert (found.rows[0], found.free[0]) == (abs(rows), NOWHERE)
    assert found.left[0] < 1e-4
    assert found.log_chance[0] < np.log(1e-6)


@pytest.mark.parametrize("rows", [1, -1])
def test_lists_that_lost_a_name_leave_a_point_free(make_block, rows):
    bad, order, listed = slipped_block(make_block, rows)
    lost = listed[2] if rows == 1 else listed[-1]
    places = np.flatnonzero(bad.is_control)
    control = bad.control.copy()
    # what stands at the other end is of no point of the list
    control[places[order[lost]]] += [700.0, -400.0]
    bad = replace(bad, control=control)
    names = names_of_given_points(adjust(bad))
    found = put_right(names, slipped_names(listed, len(listed)))[0]
    np.testing.assert_array_equal(found.orders[0], order)
    assert (found.rows[0], found.free[0]) == (1, lost)
    assert found.left[0] < 1e-4
    assert found.log_chance[0] < np.log(1e-6)
    # as an adjustment in which the point is no control has it
    given = control[places][order]
    right = control.copy()
    right[places] = given
    covariance = bad.control_covariance.copy()
    covariance[places[lost]] = 1e12 * np.eye(2)
    least = without_control_errors(bad)
    again = replace(bad, control=right, control_covariance=covariance)
    alone = []  # where another point is none
    for place in places:
        covariance = bad.control_covariance.copy()
        covariance[place] = 1e12 * np.eye(2)
        alone.append(adjust(replace(bad, control_covariance=covariance)).sum_of_squares)
    beside = min(alone) - least
    left = (adjust(again).sum_of_squares - least) / beside
    assert found.left[0] == pytest.approx(left, rel=1e-4, abs=1e-7)


def test_a_pair_beside_names_that_slipped_is_a_second_mistake(make_block):
    bad, order, listed = slipped_block(make_block, 1)
    again = np.arange(len(order))
    again[[0, 3]] = [3, 0]
    names = names_of_given_points(adjust(renamed(bad, again)))
    found = put_right(names, slipped_names(listed, len(listed)))[1]
    np.testing.assert_array_equal(found.orders[0], again[order])
    assert found.left[0] < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("n_wrong", [1, 2, 4])
@pytest.mark.parametrize("size", [500.0, 20_000.0])
def test_wrong_points_are_no_mixed_names(make_block, n_wrong, size):
    """Errors as large as points lie apart, which exchanges take a part of, and larger.

    A list that lost a name has a free point, which may be the one that is wrong.
    """
    block = make_block("dense grid", "affine", every=5)
    places = np.flatnonzero(block.is_control)
    rng = np.random.default_rng(n_wrong)
    for _ in range(40):
        control = block.control.copy()
        wrong = rng.choice(places, n_wrong, replace=False)
        control[wrong] += rng.normal(0.0, size, (n_wrong, 2))
        names = names_of_given_points(adjust(replace(block, control=control)))
        found = put_right(names, slipped_names(np.arange(len(places)), len(places)))
        is_likely = [np.exp(f.log_chance) < 1e-3 for f in found]
        assert all(
            (f.left[likely] > 1 / 25).all()
            for f, likely in zip(found, is_likely, strict=True)
        )


@pytest.mark.slow
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
        names = names_of_given_points(adjust(replace(block, control=control)))
        found.append(np.exp(put_right(names)[0].log_chance.min()))
    assert np.mean(np.array(found) <= 0.1) <= 0.1
    assert min(found) < 0.5


def test_of_many_points_those_that_contradict_most_are_tried(make_block):
    block = make_block("dense grid", "affine", every=3)
    places = np.flatnonzero(block.is_control)
    solution = adjust(exchanged(block, 3, 7))
    names = names_of_given_points(solution, most=8)
    assert len(names.places) == 8 < len(places)
    (found, *_) = put_right(names)
    moved = found.orders[0] != names.as_given
    assert set(names.places[moved]) == {places[3], places[7]}
    assert found.log_chance[0] < np.log(1e-6)


def test_held_control_is_not_exchanged(make_block):
    block = make_block("grid", "affine")
    covariance = block.control_covariance.copy()
    covariance[block.is_control] = 0.0
    names = names_of_given_points(adjust(replace(block, control_covariance=covariance)))
    assert len(names.places) == 0
    assert put_right(names) == []
