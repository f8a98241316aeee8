"""Gross errors taken out of many pairs."""

import numpy as np
import pytest
from tests.theory.relative_orientation.exchanged_names import with_exchanged_names

from einschalt.theory.relative_orientation.condition_tests import StereoPairs
from einschalt.theory.relative_orientation.gross_errors import find_gross_errors

SIGMA = 5e-3


def simulated(make_pairs, n_pairs, n_points, seed):
    geometry = make_pairs.geometry(n_points=(n_points, n_points), tilt_deg=5.0)
    made = make_pairs(n_pairs, seed, geometry)
    distance = np.full((n_pairs, 2), made.principal_distance)
    return StereoPairs(made.image, made.start, distance)


def spoilt(pairs, share, size, seed):
    """Gross errors of y in a share of the points of each pair."""
    rng = np.random.default_rng(seed)
    n_pairs, n = len(pairs.start) - 1, int(pairs.start[1])
    order = rng.random((n_pairs, n)).argsort(axis=1)
    is_wrong = (order < max(round(share * n), 1)).ravel()
    image = pairs.image.copy()
    error = rng.uniform(*size, is_wrong.sum()) * rng.choice([-1.0, 1.0], is_wrong.sum())
    # across the base: what lies along it no pair can see
    across = np.where(np.abs(_base(pairs)[:, 0]) > np.abs(_base(pairs)[:, 1]), 1, 0)
    image[is_wrong, across[pairs.model][is_wrong]] += error
    return StereoPairs(image, pairs.start, pairs.distance), is_wrong


def _base(pairs):
    return pairs.orient().base


@pytest.mark.slow
@pytest.mark.parametrize(
    ("n_points", "share"), [(30, 0.05), (30, 0.1), (50, 0.2), (100, 0.2)]
)
@pytest.mark.parametrize("size", [(0.1, 1.0), (0.5, 5.0)])
def test_blunders_are_taken_out(make_pairs, n_points, share, size):
    good = simulated(make_pairs, 200, n_points, seed=5)
    pairs, is_wrong = spoilt(good, share, size, seed=6)
    is_out = find_gross_errors(pairs)
    # from twenty sigma on, less where the point alone carries the orientation
    assert is_out[is_wrong].mean() > 0.98
    assert is_out[~is_wrong].mean() < 2e-3
    kept, wanted = pairs.chosen(~is_out).orient(), good.chosen(~is_wrong).orient()
    # the median pair loses nothing; hardly one is spoilt
    is_sound = kept.sigma_0 < 2.0 * SIGMA
    assert is_sound.mean() >= 0.985
    turned = np.abs(kept.rotation - wanted.rotation).max(axis=(1, 2))
    assert np.median(turned) < 1e-12


@pytest.mark.slow
def test_good_pairs_keep_their_points(make_pairs):
    level = 0.01
    for n_points in (8, 12, 20):
        pairs = simulated(make_pairs, 800, n_points, seed=n_points)
        is_out = find_gross_errors(pairs, significance=level)
        alarms = is_out.reshape(-1, n_points).any(axis=1).mean()
        assert alarms <= level + 3.0 * np.sqrt(level / 800)


def test_one_pair_as_among_many(make_pairs):
    pairs, _ = spoilt(simulated(make_pairs, 6, 25, seed=2), 0.12, (0.1, 1.0), seed=3)
    together = find_gross_errors(pairs).reshape(6, 25)
    for place in range(6):
        _, one = pairs.of_models([place])
        np.testing.assert_array_equal(find_gross_errors(one), together[place])


def test_pairs_that_cannot_be_tested_keep_their_points(make_pairs):
    pairs = simulated(make_pairs, 3, 8, seed=4)
    few = pairs.chosen(np.arange(24) % 8 < [6] * 8 + [4] * 8 + [0] * 8)
    assert not find_gross_errors(few).any()
    same = StereoPairs(np.ones((20, 4)), np.array([0, 20]), pairs.distance[:1])
    assert not find_gross_errors(same).any()


@pytest.mark.parametrize("estimator", ["rigorous", "determinants"])
def test_both_estimators_find_the_same(make_pairs, estimator):
    good = simulated(make_pairs, 20, 25, seed=8)
    pairs, is_wrong = spoilt(good, 0.08, (0.5, 1.0), seed=1)
    is_out = find_gross_errors(pairs, estimator)
    assert is_out[is_wrong].mean() > 0.94


@pytest.mark.parametrize(
    ("n_points", "n_exchanged"), [(12, 2), (15, 3), (25, 7), (60, 20)]
)
def test_exchanged_names_do_not_lead_astray(make_pairs, n_points, n_exchanged):
    """Errors of centimetres, which leave the orientation of all points far off."""
    good = simulated(make_pairs, 60, n_points, seed=5)
    pairs, is_wrong = with_exchanged_names(good, n_exchanged, seed=2)
    is_out = find_gross_errors(pairs)
    kept, wanted = pairs.chosen(~is_out).orient(), good.chosen(~is_wrong).orient()
    is_sound = kept.sigma_0 < 2.0 * wanted.sigma_0 + SIGMA
    assert is_sound.mean() > 0.95
    turned = np.abs(kept.rotation - wanted.rotation).max(axis=(1, 2))
    assert np.median(turned) < 1e-3
