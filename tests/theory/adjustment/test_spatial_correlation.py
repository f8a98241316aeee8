"""Likeness of neighbours against loops over all pairs, and against known fields."""

import numpy as np
import pytest

from einschalt.theory.adjustment.spatial_correlation import (
    correlogram,
    morans_i,
    nearest_neighbours,
    pairs_within,
)


def lattice(n=12):
    return np.stack(np.meshgrid(np.arange(n), np.arange(n)), -1).reshape(-1, 2) * 1.0


def by_loops(vectors, neighbours):
    """Moran 1950, with a weight of one for each pair, both ways."""
    z = vectors - vectors.mean(axis=0)
    products, weights = 0.0, 0
    for one, two in zip(neighbours.first, neighbours.second, strict=True):
        products += 2 * float(z[one] @ z[two])
        weights += 2
    return products / weights * len(z) / float(np.sum(z**2))


def test_moran_by_loops():
    rng = np.random.default_rng(0)
    xy = rng.uniform(0, 1000, (60, 2)) + np.array([4.5e6, 5.3e6])
    vectors = rng.normal(size=(60, 2, 5))
    near = nearest_neighbours(xy)
    found = morans_i(vectors, near)
    for draw in range(5):
        assert found[draw] == pytest.approx(by_loops(vectors[:, :, draw], near))
    assert morans_i(vectors[:, :, 0], near) == pytest.approx(found[0])


def test_each_pair_of_nearest_neighbours_stands_once():
    rng = np.random.default_rng(1)
    xy = rng.uniform(0, 100, (40, 2))
    near = nearest_neighbours(xy, 3)
    distance = np.hypot(*(xy[:, None] - xy[None]).transpose(2, 0, 1))
    np.fill_diagonal(distance, np.inf)
    expected = set()
    for point, row in enumerate(np.argsort(distance, axis=1)[:, :3]):
        expected |= {tuple(sorted((point, int(other)))) for other in row}
    assert set(zip(near.first.tolist(), near.second.tolist(), strict=True)) == expected
    np.testing.assert_allclose(near.distance, distance[near.first, near.second])


def test_a_chessboard_has_neighbours_that_are_all_unlike():
    xy = lattice()
    sign = np.where(xy.sum(axis=1) % 2 == 0, 1.0, -1.0)
    near = pairs_within(xy, 1.1)
    assert morans_i(np.column_stack([sign, sign]), near) == pytest.approx(-1.0)


def test_on_the_average_of_all_orders_it_is_slightly_negative():
    rng = np.random.default_rng(2)
    xy, z = lattice(6), rng.normal(size=(36, 2))
    orders = np.stack([z[rng.permutation(36)] for _ in range(4000)], axis=-1)
    found = morans_i(orders, nearest_neighbours(xy, 4))
    standard_error = found.std() / np.sqrt(4000)
    # E[I] = −1/(n − 1), Moran 1950
    assert abs(found.mean() + 1 / 35) < 4 * standard_error


def test_correlogram_finds_the_reach_of_a_smooth_field():
    rng = np.random.default_rng(3)
    xy = lattice(30)
    # moving averages over 5 x 5 lattice points: correlation 1 − d/5 along the axes
    white = rng.normal(size=(34, 34, 2, 40))
    smooth = sum(white[i : i + 30, j : j + 30] for i in range(5) for j in range(5))
    found = correlogram(smooth.reshape(900, 2, 40), xy)
    mean = found.correlation.mean(axis=1)
    assert found.distance[0] < 1.5
    assert mean[0] > 0.65
    assert np.all(np.diff(mean) < 0.0)
    is_far = found.distance > 5.0
    assert np.all(np.abs(mean[is_far]) < 0.1)


def test_points_in_one_place_have_no_neighbours():
    near = nearest_neighbours(np.zeros((5, 2)))
    assert len(near.first) == 0
    assert np.isnan(morans_i(np.ones((5, 2)), near))
    assert len(correlogram(np.ones((5, 2)), np.zeros((5, 2))).distance) == 0
    assert len(nearest_neighbours(np.zeros((1, 2))).first) == 0
