"""How good the good ones are among worse observations."""

from itertools import pairwise

import numpy as np
import pytest

from einschalt.theory.adjustment.heavy_tails import (
    FAR_OUT_BY_CHANCE,
    FEWEST,
    MOST_OBSERVATIONS,
    find_heavy_tails,
    find_tails_of_models,
)


def mixed(n, share, factor, seed):
    rng = np.random.default_rng(seed)
    errors = rng.normal(scale=3.5, size=n)
    errors[rng.random(n) < share] *= factor
    return errors


@pytest.mark.parametrize(("share", "factor"), [(0.07, 4.0), (0.17, 6.0), (0.3, 10.0)])
def test_good_ones_keep_their_standard_error_beside_worse(share, factor):
    found = [find_heavy_tails(mixed(1500, share, factor, seed)) for seed in range(20)]
    sigma = np.array([tails.sigma for tails in found])
    assert sigma.mean() == pytest.approx(3.5, rel=0.015)
    assert sigma.std() < 0.1
    assert np.mean([t.share for t in found]) == pytest.approx(share, rel=0.1)
    assert np.mean([t.factor for t in found]) == pytest.approx(factor, rel=0.1)
    assert max(t.p_value for t in found) < 1e-10
    # by which the median is off
    errors = np.concatenate([mixed(1500, share, factor, seed) for seed in range(20)])
    assert 1.4826 * np.median(np.abs(errors)) > 3.5 * (1.0 + share / 2.0)


@pytest.mark.slow
@pytest.mark.parametrize("n", [60, 400])
def test_normal_errors_have_no_tails(n):
    found = [find_heavy_tails(mixed(n, 0.0, 1.0, seed)) for seed in range(400)]
    alarms = np.mean([tails.p_value < 0.01 for tails in found])
    assert alarms < 0.01 + 3.0 * np.sqrt(0.01 / 400)
    assert np.mean([t.far_out for t in found]) < 5.0 * FAR_OUT_BY_CHANCE


def test_sizes_and_signed_errors_of_any_unit_tell_the_same():
    errors = mixed(500, 0.1, 5.0, 0)
    one, other = find_heavy_tails(errors), find_heavy_tails(1e-6 * np.abs(errors))
    assert other.sigma == pytest.approx(1e-6 * one.sigma)
    assert (other.share, other.factor) == pytest.approx((one.share, one.factor))


def test_many_observations_are_thinned():
    n = 5 * MOST_OBSERVATIONS
    found = find_heavy_tails(mixed(n, 0.1, 5.0, 1))
    assert found.sigma == pytest.approx(3.5, rel=0.03)


def test_too_few_and_exact_observations_tell_nothing():
    assert find_heavy_tails(np.ones(FEWEST - 1)) is None
    assert find_heavy_tails(np.zeros(200)) is None
    assert find_heavy_tails(np.full(200, np.nan)) is None


def of_lines(n_models, n_points, seed, share=0.15, n_unknown=2):
    """Observations of straight lines, some of them worse, with residuals of fits."""
    rng = np.random.default_rng(seed)
    n = n_models * n_points
    rows = np.ones((n, n_unknown))
    rows[:, 1] = rng.uniform(-1.0, 1.0, n)
    errors = rng.normal(scale=3.5, size=n)
    errors[rng.random(n) < share] *= 6.0
    start = n_points * np.arange(n_models + 1)
    parameters = rng.normal(scale=100.0, size=(n_models, n_unknown))
    misfits = np.sum(rows * np.repeat(parameters, n_points, axis=0), axis=1) + errors
    residuals = np.empty(n)
    for first, last in pairwise(start):
        own = rows[first:last, :2]
        hat = own @ np.linalg.pinv(own)
        residual = misfits[first:last] - hat @ misfits[first:last]
        residuals[first:last] = residual / np.sqrt(1.0 - np.diag(hat))
    return rows, misfits, start, find_heavy_tails(residuals)


@pytest.mark.slow
@pytest.mark.parametrize("n_points", [5, 12])
def test_small_models_hide_nothing_of_their_good_ones(n_points):
    data = [of_lines(1200 // n_points, n_points, seed) for seed in range(8)]
    found = [find_tails_of_models(*one) for one in data]
    assert np.mean([t.sigma for t in found]) == pytest.approx(3.5, rel=0.025)
    assert np.mean([t.share for t in found]) == pytest.approx(0.15, rel=0.15)
    assert np.mean([t.factor for t in found]) == pytest.approx(6.0, rel=0.1)
    # what residuals of fits make of it
    assert np.mean([one[3].sigma for one in data]) > 1.08 * 3.5


def test_parameters_that_nothing_determines_are_held():
    # the third is the first once more
    rows, misfits, start, first = of_lines(100, 10, 3, n_unknown=3)
    twice = find_tails_of_models(rows, misfits, start, first)
    once = find_tails_of_models(rows[:, :2], misfits, start, first)
    assert twice.sigma == pytest.approx(once.sigma, rel=0.05)
    assert twice.p_value == first.p_value


def test_many_models_are_thinned():
    rows, misfits, start, first = of_lines(3000, 10, 4)
    found = find_tails_of_models(rows, misfits, start, first)
    assert found.sigma == pytest.approx(3.5, rel=0.05)
