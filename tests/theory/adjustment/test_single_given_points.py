"""Single wrong points among given points that check each other, on a grid."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from einschalt.theory.adjustment.single_given_points import (
    FEWEST_POINTS,
    find_wrong_points,
)

SIGMA = 0.05  # of one coordinate [m]
GRID = np.stack(np.meshgrid(*[np.arange(10) * 300.0] * 2), axis=-1).reshape(-1, 2)
N = len(GRID)
WEIGHTS = np.full(N, SIGMA**-2.0)
# models of neighbours: what is smooth over 1 km, they follow
NEAR = np.exp(-((cdist(GRID, GRID) / 400.0) ** 2))
SMOOTH = NEAR / NEAR.sum(axis=1, keepdims=True)


def information():
    """Points less what models of neighbours follow, as symmetric information."""
    free = np.eye(N) - SMOOTH
    return free.T @ free / SIGMA**2


class Checks:
    """Scores u = W e, of errors whose covariance is that of W."""

    def __init__(self, given, rng):
        values, vectors = np.linalg.eigh(information())
        self.root = vectors * np.sqrt(np.maximum(values, 0.0))
        self.w = self.root @ self.root.T
        self.scores = self.draw(1, rng)[:, 0] + self.w @ given

    def times(self, columns):
        return self.w @ columns

    def draw(self, n_draws, seed):
        rng = np.random.default_rng(seed)
        both = rng.standard_normal((2, N, n_draws))
        return self.root @ (both[0] + 1j * both[1])


def found_in(given, seed, weights=WEIGHTS):
    return find_wrong_points(Checks(given, seed + 1), weights)


def wrong(**points):
    given = np.zeros(N, dtype=complex)
    for name, shift in points.items():
        given[int(name[1:])] = shift
    return given


@pytest.mark.parametrize("size", [0.6, 5.0, 1000.0])
def test_a_single_point_is_found_with_its_shift(size):
    found = found_in(wrong(p37=size * (0.6 - 0.8j)), seed=3)
    assert found.rows.tolist() == [37]
    assert found.standard_error[0] < 2.0 * SIGMA
    miss = found.shift[0] - size * (0.6 - 0.8j)
    assert abs(miss) < 4.0 * found.standard_error[0]
    assert found.p_value[0] <= 0.001


def test_a_gross_point_hides_no_smaller_one_beside_it():
    found = found_in(wrong(p37=1000.0, p38=0.8j), seed=5)
    assert found.rows.tolist() == [37, 38]


def test_nothing_is_found_by_chance():
    """At 0.001 of a block: one of 200 may have a point, three have none."""
    n_found = sum(len(found_in(wrong(), seed).rows) > 0 for seed in range(200))
    assert n_found < 3


def test_errors_that_are_larger_for_all_are_no_wrong_points():
    rng = np.random.default_rng(8)
    larger = 10.0 * SIGMA * (rng.standard_normal((2, N)).T @ [1.0, 1j])
    assert not len(found_in(larger, seed=8).rows)
    # one that stands out of them is
    found = found_in(larger + wrong(p37=100.0), seed=8)
    assert found.rows.tolist() == [37]
    assert found.standard_error[0] > 5.0 * SIGMA


def test_a_part_of_the_points_is_no_matter_of_single_ones():
    corner = (GRID < 800.0).all(axis=1)
    assert corner.sum() == 9
    assert not len(found_in(2.0 * corner.astype(complex), seed=9).rows)


def test_of_few_points_nothing_is_told():
    checks = Checks(wrong(p3=9.0), 1)
    few = FEWEST_POINTS - 1
    checks.scores = checks.scores[:few]
    assert not len(find_wrong_points(checks, WEIGHTS[:few]).rows)
