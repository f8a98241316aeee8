"""Residuals against those of their neighbours in the model."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import binom, chi2

from einschalt.theory.block_adjustment.block_tests import BlockTests
from einschalt.theory.block_adjustment.neighbouring_errors import (
    LEAST_POINTS,
    N_NEIGHBOURS,
    judge_among_neighbours,
    neighbours_of,
)

N_MODELS, N_POINTS = 6, 80
GIVEN = SimpleNamespace(standard_error=np.ones((N_MODELS * N_POINTS, 3)))


def residuals_of(seed, *, differ, n_points=N_POINTS):
    """Residuals that grow along their rays with their place, or are alike."""
    rng = np.random.default_rng(seed)
    n = N_MODELS * n_points
    places = rng.uniform(0.0, 100.0, (n, 3))
    errors = rng.normal(size=(n, 3))
    if differ:
        depth = 0.3 + (places[:, 0] / 50.0) ** 2
        errors = (
            0.3 * errors
            + rng.normal(size=n)[:, None] * [2.0, 1.0, 1.0] * (depth[:, None])
        )
    observations = SimpleNamespace(
        model=np.repeat(np.arange(N_MODELS), n_points),
        n_models=N_MODELS,
        point=np.arange(n),
    )
    return SimpleNamespace(
        observations=observations,
        points=places,
        residuals=errors,
        leverage=np.zeros((n, 3)),
    )


def with_one_error(solution):
    """Tests that take the errors of all points for alike."""
    square = np.sum(solution.residuals**2, axis=1)
    square *= 3.0 / square.mean()
    return BlockTests(np.sqrt(square), chi2.sf(square, 3), solution.residuals)


def judged(solution, is_in=None):
    known = with_one_error(solution)
    is_in = np.ones(len(known.w), dtype=bool) if is_in is None else is_in
    near = neighbours_of(solution)
    return known, judge_among_neighbours(solution, known, GIVEN, near, is_in)


def test_neighbours_are_the_nearest_others_of_the_model():
    solution = residuals_of(1, differ=True)
    near, places = neighbours_of(solution), solution.points
    assert len(near.rows) == N_MODELS * N_POINTS
    model = solution.observations.model
    assert (model[near.others] == model[near.rows][:, None]).all()
    row = 200
    own = np.flatnonzero((model == model[row]) & (np.arange(len(model)) != row))
    distance = np.linalg.norm(places[own] - places[row], axis=1)
    assert set(near.others[row]) == set(own[distance.argsort()[:N_NEIGHBOURS]])


def test_points_in_one_place_are_each_others_neighbours():
    solution = residuals_of(1, differ=True)
    solution.points[:60] = solution.points[0]
    near = neighbours_of(solution)
    assert near.others.shape == (len(near.rows), N_NEIGHBOURS)
    assert (near.others != near.rows[:, None])[60:].all()


def test_small_models_have_no_neighbours():
    solution = residuals_of(1, differ=True, n_points=LEAST_POINTS - 1)
    assert len(neighbours_of(solution).rows) == 0


def test_errors_that_are_alike_are_judged_as_before():
    for seed in range(20):
        known, found = judged(residuals_of(seed, differ=False))
        assert found is known


def test_errors_that_differ_by_place_are_rejected_as_often_as_chance():
    level, found, before, n = 1e-3, 0, 0, 0
    for seed in range(20):
        known, tests = judged(residuals_of(seed, differ=True))
        before += np.count_nonzero(known.p_value < level)
        found += np.count_nonzero(tests.p_value < level)
        n += len(tests.w)
    assert before > 5 * binom.isf(0.001, n, level)
    # neighbours lie apart as well, and differ
    assert found <= binom.isf(0.001, n, 2.0 * level)


@pytest.mark.parametrize("n_wrong", [1, 2])
def test_gross_errors_are_found_beside_each_other(n_wrong):
    """Two neighbours whose names were exchanged are wrong by the same, both ways."""
    for seed in range(10):
        solution = residuals_of(seed, differ=True)
        small = solution.points[:, 0] < 25.0
        first = np.flatnonzero(small)[0]
        wrong = [first, neighbours_of(solution).others[first, 0]][:n_wrong]
        size = np.array([0.0, 30.0, -30.0])
        for row, sign in zip(wrong, (1.0, -1.0), strict=False):
            solution.residuals[row] += sign * size
        _, tests = judged(solution)
        assert (tests.p_value[wrong] < 1e-6).all()


def test_what_is_out_is_no_neighbour():
    solution = residuals_of(3, differ=True)
    row = int(np.argmin(solution.points[:, 0]))
    near = neighbours_of(solution).others[row, :8]
    solution.residuals[[row, *near]] += [0.0, 12.0, -12.0]
    is_in = np.ones(len(solution.residuals), dtype=bool)
    _, masked = judged(solution, is_in)
    is_in[near] = False
    _, tests = judged(solution, is_in)
    assert masked.p_value[row] > 1e-4
    assert tests.p_value[row] < 1e-5
