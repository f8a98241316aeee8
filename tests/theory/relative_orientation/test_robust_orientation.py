"""Robust relative orientation: against SciPy and statsmodels, and with gross errors."""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.stats import norm as norm_of_errors
from statsmodels.robust import norms
from tests.theory.relative_orientation.exchanged_names import with_exchanged_names

from einschalt.foundations.rotations import rotation_by_vector
from einschalt.theory.relative_orientation.condition_tests import StereoPairs
from einschalt.theory.relative_orientation.coplanarity import ORIENTED
from einschalt.theory.relative_orientation.robust_orientation import orient_robustly

SIGMA = 5e-3
OF_STATSMODELS = {"huber": norms.HuberT(1.345), "tukey": norms.TukeyBiweight(4.685)}


def simulated(make_pairs, n_pairs, n_points, seed):
    geometry = make_pairs.geometry(n_points=(n_points, n_points), tilt_deg=5.0)
    made = make_pairs(n_pairs, seed, geometry)
    distance = np.full((n_pairs, 2), made.principal_distance)
    return made, StereoPairs(made.image, made.start, distance)


def spoilt(made, pairs, share, seed):
    """Gross errors of a tenth of a millimetre to one, across the base."""
    rng = np.random.default_rng(seed)
    n_pairs, n = len(pairs.start) - 1, int(pairs.start[1])
    order = rng.random((n_pairs, n)).argsort(axis=1)
    is_wrong = (order < round(share * n)).ravel()
    image = pairs.image.copy()
    across = np.where(np.abs(made.base[:, 0]) > np.abs(made.base[:, 1]), 1, 0)
    size = rng.uniform(0.1, 1.0, is_wrong.sum())
    image[is_wrong, across[pairs.model][is_wrong]] += size
    return StereoPairs(image, pairs.start, pairs.distance), is_wrong


def turn_errors(rotation, true):
    """Angle between two rotations of each pair [rad]."""
    trace = np.einsum("nij,nij->n", rotation, true)
    return np.arccos(np.clip((trace - 1.0) / 2.0, -1.0, 1.0))


def conditions(image, distance, base, rotation):
    """Misclosures F and their variances q, written independently of the kernels."""
    left = np.column_stack([image[:, :2], np.full(len(image), -distance)])
    right = np.column_stack([image[:, 2:], np.full(len(image), -distance)])
    essential = np.cross(np.eye(3), base) @ rotation.T
    f = np.einsum("ni,ij,nj->n", left, essential, right)
    by_left, by_right = right @ essential.T, left @ essential
    q = (by_left[:, :2] ** 2).sum(axis=1) + (by_right[:, :2] ** 2).sum(axis=1)
    return f, q


@pytest.mark.parametrize("norm", ["huber", "tukey"])
def test_solves_the_weighted_equations(make_pairs, norm):
    made, pairs = simulated(make_pairs, 12, 30, seed=3)
    pairs, _ = spoilt(made, pairs, 0.1, seed=4)
    robust = orient_robustly(pairs, norm)
    found = robust.orientation
    assert (found.status == ORIENTED).all()
    for k in range(12):
        rows = slice(pairs.start[k], pairs.start[k + 1])
        image, c = pairs.image[rows], made.principal_distance
        base, rotation = found.base[k], found.rotation[k]
        # the factors are those of statsmodels for the residuals at the solution
        f, q = conditions(image, c, base, rotation)
        size = np.abs(f) / np.sqrt(q)
        # what 18 of 30 do not exceed; 5 are met in any case
        scale = np.sort(size)[17] / norm_of_errors.ppf((1 + 17.5 / 30) / 2)
        scale *= np.sqrt(30 / 25)
        factors = OF_STATSMODELS[norm].weights(size / scale)
        np.testing.assert_allclose(robust.factors[rows], factors, atol=1e-6)
        weights = np.sqrt(factors / q)

        def weighted(step, image=image, at=(base, rotation), c=c, weights=weights):
            moved = at[0] + step[:3]
            turned = at[1] @ rotation_by_vector(step[3:])
            f, _ = conditions(image, c, moved / np.linalg.norm(moved), turned)
            return np.append(weights * f, 1e3 * (np.linalg.norm(moved) - 1.0))

        # and with these weights SciPy has nothing left to improve
        exact = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15}
        better = least_squares(weighted, np.zeros(6), x_scale=1e-3, **exact)
        assert np.abs(better.x).max() < 5e-9


# 5 % in the limit; with 30 points the scale by the median costs some more
@pytest.mark.parametrize(("norm", "loss"), [("huber", 0.10), ("tukey", 0.15)])
def test_good_pairs_lose_little(make_pairs, norm, loss):
    made, pairs = simulated(make_pairs, 400, 30, seed=5)
    plain, robust = pairs.orient(), orient_robustly(pairs, norm).orientation
    errors = [turn_errors(one.rotation, made.rotation) for one in (plain, robust)]
    ratio = np.mean(errors[1] ** 2) / np.mean(errors[0] ** 2)
    assert 1.0 < ratio < 1.0 + loss
    assert np.median(robust.sigma_0) == pytest.approx(SIGMA, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(("norm", "worst"), [("huber", 1.6), ("tukey", 1.2)])
def test_gross_errors_do_little_harm(make_pairs, norm, worst):
    made, good = simulated(make_pairs, 200, 40, seed=6)
    pairs, is_wrong = spoilt(made, good, 0.1, seed=7)
    robust = orient_robustly(pairs, norm)
    wanted = good.chosen(~is_wrong).orient()
    rms = [
        np.sqrt(np.mean(turn_errors(one.rotation, made.rotation) ** 2))
        for one in (wanted, robust.orientation, pairs.orient())
    ]
    assert rms[1] < worst * rms[0]
    assert rms[2] > 5.0 * rms[0]
    assert robust.factors[is_wrong].mean() < 0.1
    assert robust.factors[~is_wrong].mean() > 0.85


def test_small_and_failed_pairs_stay_what_they_were(make_pairs):
    _, pairs = simulated(make_pairs, 3, 8, seed=8)
    few = pairs.chosen(np.arange(24) % 8 < [8] * 8 + [7] * 8 + [4] * 8)
    robust, plain = orient_robustly(few, "tukey"), few.orient()
    np.testing.assert_array_equal(robust.orientation.status, plain.status)
    np.testing.assert_array_equal(robust.orientation.base[1:], plain.base[1:])
    assert (robust.factors[8:] == 1.0).all()


def test_pairs_that_fit_exactly(make_pairs):
    geometry = make_pairs.geometry(n_points=(12, 12), tilt_deg=5.0)
    made = make_pairs(5, 9, geometry, noise=0.0)
    distance = np.full((5, 2), made.principal_distance)
    robust = orient_robustly(StereoPairs(made.image, made.start, distance), "huber")
    assert (robust.orientation.status == ORIENTED).all()
    np.testing.assert_allclose(robust.orientation.rotation, made.rotation, atol=1e-9)


def test_one_pair_as_among_many(make_pairs):
    made, pairs = simulated(make_pairs, 6, 25, seed=2)
    pairs, _ = spoilt(made, pairs, 0.12, seed=3)
    together = orient_robustly(pairs, "tukey")
    for k in range(6):
        _, one = pairs.of_models([k])
        alone = orient_robustly(one, "tukey").orientation
        np.testing.assert_array_equal(alone.base[0], together.orientation.base[k])


def test_exchanged_names_do_not_lead_astray(make_pairs):
    made, good = simulated(make_pairs, 60, 25, seed=6)
    pairs, is_wrong = with_exchanged_names(good, 5, seed=2)
    robust = orient_robustly(pairs, "tukey")
    errors = turn_errors(robust.orientation.rotation, made.rotation)
    assert np.mean(errors < 0.01) > 0.95
    assert np.median(robust.factors[is_wrong]) == 0.0
    assert np.median(robust.factors[~is_wrong]) > 0.8
