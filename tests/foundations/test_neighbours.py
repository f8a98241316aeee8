"""Neighbours of scattered points, against the definition."""

import numpy as np
import pytest

from einschalt.foundations.neighbours import neighbour_pairs


def by_definition(xy):
    """Every pair whose circle of Thales holds no other point."""
    pairs = []
    for i in range(len(xy)):
        for j in range(i + 1, len(xy)):
            middle, radius = (xy[i] + xy[j]) / 2, np.hypot(*(xy[i] - xy[j])) / 2
            others = np.delete(xy, [i, j], axis=0)
            if (np.hypot(*(others - middle).T) > radius).all():
                pairs.append([i, j])
    return pairs


@pytest.mark.parametrize("seed", range(5))
def test_pairs_are_those_of_the_definition(seed):
    xy = 5e6 + 1e4 * np.random.default_rng(seed).random((60, 2))
    assert neighbour_pairs(xy).tolist() == by_definition(xy)


def test_points_on_one_line_follow_each_other():
    xy = np.outer([3.0, 0.0, 2.0, 7.0], [1.0, 2.0])
    assert neighbour_pairs(xy).tolist() == [[0, 2], [0, 3], [1, 2]]


@pytest.mark.parametrize(("n_points", "pairs"), [(0, []), (1, []), (2, [[0, 1]])])
def test_few_points(n_points, pairs):
    xy = np.arange(2.0 * n_points).reshape(n_points, 2)
    assert neighbour_pairs(xy).tolist() == pairs


def test_a_point_that_stands_twice():
    xy = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 1.0]])
    found = neighbour_pairs(xy).tolist()
    assert [0, 1] in found
    assert all(one < two for one, two in found)
