"""Neighbours of scattered points, against the definition."""

import numpy as np
import pytest

from einschalt.foundations import neighbours
from einschalt.foundations.neighbours import neighbour_pairs, triangulated_pairs
from einschalt.foundations.neighbours_by_cells import pairs_by_cells


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


def scattered(n_points, seed, size=(92_000.0, 61_000.0)):
    """Points all over a rectangle, reduced to their mean."""
    xy = np.random.default_rng(seed).uniform(0.0, size, (n_points, 2))
    return xy - xy.mean(axis=0)


@pytest.mark.parametrize("size", [(9e4, 6e4), (9e4, 2e4)])
@pytest.mark.parametrize("seed", range(5))
def test_pairs_by_cells_are_the_sides_of_triangles(seed, size):
    xy = scattered(1000 * (seed + 2), seed, size)
    found = pairs_by_cells(xy, triangulated_pairs)
    assert found.tolist() == triangulated_pairs(xy).tolist()


def test_pairs_by_cells_of_uneven_points():
    xy = scattered(6000, 1)
    xy *= 1.0 + np.abs(xy) / 2e4  # up to ten times as far apart
    found = pairs_by_cells(xy, triangulated_pairs)
    assert found.tolist() == triangulated_pairs(xy).tolist()


def test_of_a_grid_whose_circles_hold_points_the_cells_tell_nothing():
    grid = np.stack(np.meshgrid(np.arange(50.0), np.arange(50.0)), -1).reshape(-1, 2)
    assert pairs_by_cells(grid, triangulated_pairs) is None


@pytest.mark.parametrize("distance", [0.0, 1e-3])
def test_of_points_that_are_nearly_one_the_cells_tell_nothing(distance):
    xy = scattered(2000, 3)
    for place in (700, int(np.argmax(xy.sum(axis=1)))):  # within, and at the hull
        twice = np.concatenate([xy, xy[place, None] + [distance, 0.0]])
        assert pairs_by_cells(twice, triangulated_pairs) is None


def test_many_points_on_one_line_follow_each_other():
    xy = np.outer(np.arange(float(neighbours.MANY)), [1.0, 2.0])
    pairs = neighbour_pairs(xy)
    assert (np.diff(pairs, axis=1) == 1).all()
    assert len(pairs) == len(xy) - 1


def test_many_points_are_looked_at_by_cells(monkeypatch):
    xy = scattered(neighbours.MANY, 4)
    expected = triangulated_pairs(xy)
    sizes = []

    def noting(points):
        sizes.append(len(points))
        return triangulated_pairs(points)

    monkeypatch.setattr(neighbours, "triangulated_pairs", noting)
    assert neighbour_pairs(xy).tolist() == expected.tolist()
    assert max(sizes) < len(xy) // 10
