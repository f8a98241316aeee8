"""Regions displaced in given points that check each other, on a grid."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from einschalt.theory.adjustment.displaced_regions import (
    FEWEST_POINTS,
    find_displaced_region,
    regions_of,
)
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

SIGMA = 0.05  # of one coordinate [m]
GRID = np.stack(np.meshgrid(*[np.arange(9) * 300.0] * 2), axis=-1).reshape(-1, 2)
N = len(GRID)
# each point is checked by the others, all of them together by nothing
INFORMATION = (np.eye(N) - 1.0 / N) / SIGMA**2
WEIGHTS = np.full(N, SIGMA**-2.0)
SHIFT = np.array([0.12, -0.16])
# half of the shift is two standard errors of a point: a few are taken for the others
MOST_POINTS = 0.85


def errors(seed, size=SIGMA):
    return size * np.random.default_rng(seed).standard_normal((N, 2))


class Checks:
    """What the points know of each other."""

    def __init__(self, given, information=INFORMATION):
        self.information = information
        self.scores = information @ (given @ np.array([1.0, 1j]))

    def times(self, columns):
        return self.information @ columns

    def draw(self, n_draws, seed):
        shape = (len(self.scores), n_draws)
        drawn = SIGMA * np.random.default_rng(seed).standard_normal(shape)
        return self.information @ drawn


def found_in(given):
    return find_displaced_region(Checks(given), WEIGHTS, GRID)


def inside(middle, radius):
    return np.hypot(*(GRID - middle).T) <= radius


def overlap(found, is_in):
    rows = set(np.flatnonzero(is_in))
    return len(rows & set(found.rows)) / len(rows | set(found.rows))


@pytest.mark.parametrize(
    ("middle", "radius"), [((1200.0, 1200.0), 650.0), ((0.0, 300.0), 800.0)]
)
def test_a_displaced_region_is_found(middle, radius):
    is_in = inside(middle, radius)
    found = found_in(errors(1) + np.outer(is_in, SHIFT))
    assert overlap(found, is_in) > MOST_POINTS
    assert found.shift == pytest.approx(SHIFT, abs=4.0 * found.standard_error)
    n_in = len(found.rows)
    known = np.sqrt(1.0 / n_in + 1.0 / (N - n_in)) * SIGMA
    assert found.standard_error == pytest.approx(known)
    assert found.p_value < FINDING_SIGNIFICANCE


def test_a_strip_beyond_a_slanting_line():
    is_in = GRID @ [1.0, 1.0] > 3350.0
    found = found_in(errors(2) + np.outer(is_in, SHIFT))
    assert overlap(found, is_in) > MOST_POINTS


def test_the_smaller_part_is_named():
    is_in = inside((1200.0, 1200.0), 1350.0)
    assert is_in.sum() > N / 2
    found = found_in(errors(3) + np.outer(is_in, 2.0 * SHIFT))
    assert overlap(found, ~is_in) > MOST_POINTS
    assert found.shift == pytest.approx(-2.0 * SHIFT, abs=4.0 * found.standard_error)


def test_errors_of_the_stated_size_are_no_region():
    assert not [seed for seed in range(40) if found_in(errors(seed)) is not None]


def test_larger_errors_are_no_region():
    larger = [found_in(errors(seed, 1.5 * SIGMA)) for seed in range(40)]
    assert larger.count(None) == len(larger)


@pytest.mark.parametrize("length", [600.0, 2000.0])
def test_a_smooth_pattern_is_no_region(length):
    root = np.linalg.cholesky(np.exp(-cdist(GRID, GRID) / length) + 1e-9 * np.eye(N))
    rng = np.random.default_rng(4)
    smooth = [4.0 * SIGMA * root @ rng.standard_normal((N, 2)) for _ in range(20)]
    found = [found_in(errors(k) + field) for k, field in enumerate(smooth)]
    assert found.count(None) == len(found)


def test_two_regions_are_not_taken_for_one():
    first, second = inside((300.0, 300.0), 500.0), inside((2100.0, 1800.0), 500.0)
    both = np.outer(first, [0.3, 0.0]) + np.outer(second, [0.0, 0.3])
    assert found_in(errors(5) + both) is None


def test_few_points_have_no_region():
    few = np.arange(2 * FEWEST_POINTS - 1)
    checks = Checks(np.full((len(few), 2), 1.0), np.eye(len(few)))
    assert find_displaced_region(checks, WEIGHTS[few], GRID[few]) is None


def test_regions_are_of_all_sizes_and_not_too_many():
    regions = regions_of(GRID).toarray()
    size = regions.sum(axis=1)
    assert size.min() == FEWEST_POINTS
    assert N // 3 < size.max() <= N // 2
    many = np.random.default_rng(6).uniform(0.0, 1e4, (5000, 2))
    assert 1000 < regions_of(many).shape[0] < 3000
