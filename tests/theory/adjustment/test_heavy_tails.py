"""How good the good ones are among worse observations."""

import numpy as np
import pytest

from einschalt.theory.adjustment.heavy_tails import (
    FAR_OUT_BY_CHANCE,
    FEWEST,
    MOST_OBSERVATIONS,
    find_heavy_tails,
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
