"""Fits with gross errors: many models at once as each alone, and as statsmodels."""

from dataclasses import replace

import numpy as np
import pytest
import statsmodels.api as sm

from einschalt.theory.adjustment.norms import HUBER, TUKEY, Norm, huber_factors
from einschalt.theory.adjustment.robust import fit_robustly, segment_median, snoop
from einschalt.theory.transformation.affine import fit_affine
from einschalt.theory.transformation.point_tests import (
    CommonPoints,
    fitted_point_tests,
)

SIGMA = 0.02


def fit_of(points):
    return fit_affine(points.source, points.target, points.weights, points.start)


def joint_tests_of(points):
    return fitted_point_tests(fit_of(points), points)


def models_with(gross, seed=0, n_models=40, n_points=15):
    """Models of an identity, one point of each moved by ``gross``."""
    rng = np.random.default_rng(seed)
    xy = rng.uniform(-100, 100, (n_models * n_points, 2))
    en = xy + rng.normal(0.0, SIGMA, xy.shape)
    start = np.arange(n_models + 1) * n_points
    bad = start[:-1] + rng.integers(0, n_points, n_models)
    en[bad] += gross
    return CommonPoints(xy, en, np.ones(len(xy)), start), bad


def test_snooping_finds_the_moved_points_and_no_others():
    points, bad = models_with([1.0, -0.5])
    found = np.flatnonzero(snoop(points, joint_tests_of, 0.001))
    np.testing.assert_array_equal(found, bad)


def test_snooping_leaves_clean_models_alone():
    points, _ = models_with([0.0, 0.0], n_models=2000)
    # each model loses a point with the probability 0.001: 2 of 2000, at most 8
    assert snoop(points, joint_tests_of, 0.001).sum() <= 8


def test_snooping_takes_several_out_of_one_model():
    points, _ = models_with([0.0, 0.0], n_models=3, n_points=30)
    target = points.target.copy()
    target[[31, 35, 40]] += [[0.5, 0.0], [0.0, -0.6], [-0.4, 0.4]]
    found = snoop(replace(points, target=target), joint_tests_of, 0.001)
    assert np.flatnonzero(found).tolist() == [31, 35, 40]


def test_snooping_one_model_is_as_snooping_many():
    points, _ = models_with([0.10, 0.05], seed=3)
    found = snoop(points, joint_tests_of, 0.001)
    for k in range(len(points.start) - 1):
        rows, part = points.of_models(np.array([k]))
        np.testing.assert_array_equal(snoop(part, joint_tests_of, 0.001), found[rows])


def test_models_that_cannot_be_fitted_are_passed_over():
    points, _ = models_with([1.0, 0.0], n_models=2, n_points=6)
    start = np.array([0, 2, 2, 6, 12])  # two points, none, four, six
    points = replace(points, start=start)
    assert not snoop(points, joint_tests_of, 0.001)[:6].any()
    robust = fit_robustly(points, fit_of, HUBER[2])
    assert np.isnan(robust.fit.parameters[:2]).all()
    assert np.isfinite(robust.fit.parameters[2:]).all()
    assert np.isfinite(robust.weights).all()


@pytest.mark.parametrize("norms", [HUBER, TUKEY], ids=["huber", "tukey"])
def test_robust_fits_hardly_feel_a_gross_error(norms):
    points, bad = models_with([1.0, -0.5])
    begun = fit_robustly(points, fit_of, HUBER[2]).weights
    robust = fit_robustly(points, fit_of, norms[2], begun)
    plain = fit_of(points)
    assert robust.is_converged.all()
    good = np.setdiff1d(np.arange(len(points.weights)), bad)

    def rms(fit):
        fitted = fit.apply(points.model, points.source) - points.source
        return np.sqrt(np.mean(fitted[good] ** 2))

    # of n = 15 points and three parameters: σ √(3/15) = 0.009
    assert rms(plain) > 0.05
    assert rms(robust.fit) < 0.014
    assert robust.weights[bad].max() < 0.2


@pytest.mark.parametrize("norms", [HUBER, TUKEY], ids=["huber", "tukey"])
def test_s_0_of_clean_models_is_that_of_least_squares(norms):
    points, _ = models_with([0.0, 0.0], n_models=1000)
    begun = fit_robustly(points, fit_of, HUBER[2]).weights
    fit = fit_robustly(points, fit_of, norms[2], begun).fit
    pooled = np.sqrt(fit.sum_of_squares.sum() / fit.redundancy.sum())
    # 24 000 redundant coordinates; the scale of single models biases it by some 2 %
    assert pooled == pytest.approx(SIGMA, rel=0.03)


@pytest.mark.parametrize("place", [0, 3])
def test_huber_is_rlm_of_statsmodels(place):
    """Northings without residuals: then lengths are those of the eastings alone."""
    points, _ = models_with([0.3, 0.0], seed=5, n_models=4, n_points=12)
    target = np.column_stack([points.target[:, 0], points.source[:, 1]])
    points = replace(points, target=target)
    robust = fit_robustly(points, fit_of, HUBER[2])
    rows, part = points.of_models(np.array([place]))
    design = sm.add_constant(part.source)
    # our scale: median / (√(2 ln 2) √(f / 2n)); that of RLM: median / 0.67449
    ours = np.sqrt(2.0 * np.log(2.0)) * np.sqrt(18 / 24)
    limit = 1.501 * 0.6744897501960817 / ours
    rlm = sm.RLM(part.target[:, 0], design, M=sm.robust.norms.HuberT(limit))
    expected = rlm.fit(tol=1e-12, maxiter=300, conv="coefs")
    np.testing.assert_allclose(
        robust.fit.parameters[place, :3], expected.params, atol=1e-6
    )
    np.testing.assert_allclose(robust.weights[rows], expected.weights, atol=1e-5)


def test_norms_of_statsmodels_can_be_given():
    points, _ = models_with([0.5, 0.0], n_models=5)
    andrew = sm.robust.norms.AndrewWave(1.6)
    robust = fit_robustly(points, fit_of, Norm(andrew.weights, 0.7))
    assert np.isfinite(robust.fit.parameters).all()


def test_exact_models_stay_as_they_are():
    points, _ = models_with([0.0, 0.0], n_models=2)
    exact = replace(points, target=2.0 * points.source)
    robust = fit_robustly(exact, fit_of, Norm(huber_factors, 1.0))
    np.testing.assert_allclose(
        robust.fit.solution.linear, 2.0 * np.eye(2)[None].repeat(2, 0), atol=1e-12
    )


def test_median_of_segments():
    values = np.array([3.0, 1.0, 2.0, 5.0, 4.0, np.nan, 1.0])
    median = segment_median(values, np.array([0, 3, 3, 5, 7]))
    np.testing.assert_array_equal(median, [2.0, np.nan, 4.5, np.nan])
