"""How good the good image points of many small pairs are beside worse ones."""

from itertools import pairwise

import numpy as np
import pytest

from einschalt.theory.adjustment.heavy_tails import find_heavy_tails
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE
from einschalt.theory.relative_orientation.condition_tests import (
    StereoPairs,
    linear_conditions,
    misclosures,
)
from einschalt.theory.relative_orientation.robust_orientation import orient_robustly
from einschalt.theory.relative_orientation.tails_of_pairs import find_tails_of_pairs

SIGMA = 5e-3


def simulated(make_pairs, n_pairs, n_points, seed, share):
    """Pairs of which a share of the points is three to ten times as bad."""
    geometry = make_pairs.geometry(n_points=(n_points, n_points), tilt_deg=3.0)
    made = make_pairs(n_pairs, seed, geometry, noise=0.0)
    rng = np.random.default_rng(seed + 1000)
    n = len(made.image)
    times = np.where(rng.random(n) < share, rng.uniform(3.0, 10.0, n), 1.0)
    errors = SIGMA * times[:, None] * rng.standard_normal((n, 4))
    distance = np.full((n_pairs, 2), made.principal_distance)
    return StereoPairs(made.image + errors, made.start, distance)


def tails_by_residuals(orientation):
    length = np.sqrt((orientation.residuals**2).sum(axis=1))
    return find_heavy_tails(length / np.sqrt(orientation.redundancy_numbers))


@pytest.mark.slow
@pytest.mark.parametrize(("n_points", "n_pairs"), [(8, 100), (15, 60), (30, 30)])
def test_the_good_ones_of_small_pairs_keep_their_sigma_0(make_pairs, n_points, n_pairs):
    found, by_residuals = [], []
    for seed in range(6):
        pairs = simulated(make_pairs, n_pairs, n_points, seed, share=0.12)
        ordinary = pairs.orient("rigorous")
        found.append(find_tails_of_pairs(pairs, ordinary))
        by_residuals.append(tails_by_residuals(ordinary).sigma)
    sigma = np.array([tails.sigma for tails in found])
    error = sigma.std() / np.sqrt(len(sigma))
    # factors of all sizes are not quite one: two per cent
    assert abs(sigma.mean() - 1.02 * SIGMA) < 0.01 * SIGMA + 3.0 * error
    assert np.mean([t.share for t in found]) == pytest.approx(0.11, abs=0.02)
    assert np.mean(by_residuals) > 1.15 * SIGMA


@pytest.mark.slow
def test_weights_of_small_pairs_make_no_tails(make_pairs):
    alarms = by_robust = 0
    for seed in range(10):
        pairs = simulated(make_pairs, 60, 10, seed, share=0.0)
        ordinary = pairs.orient("rigorous")
        tails = find_tails_of_pairs(pairs, ordinary)
        alarms += tails.p_value < FINDING_SIGNIFICANCE
        assert tails.sigma == pytest.approx(SIGMA, rel=0.15)
        robust = tails_by_residuals(orient_robustly(pairs, "tukey").orientation)
        by_robust += robust.p_value < FINDING_SIGNIFICANCE
    assert alarms == 0
    # by chance three of ten flights are below 0.01 once in nine thousand times
    assert by_robust >= 3


def test_conditions_are_linear_in_small_changes(make_pairs):
    pairs = simulated(make_pairs, 3, 12, 5, share=0.0)
    ordinary = pairs.orient("rigorous")
    rows, lengths = linear_conditions(ordinary, pairs)
    size = misclosures(ordinary, pairs).size
    assert np.abs(lengths) == pytest.approx(size, rel=1e-9, abs=1e-15)
    # what the orientation could still do is nothing: normal equations are solved
    for first, last in pairwise(pairs.start):
        own = rows[first:last]
        step = np.linalg.lstsq(own, lengths[first:last], rcond=None)[0]
        assert np.abs(own @ step).max() < 1e-2 * SIGMA
