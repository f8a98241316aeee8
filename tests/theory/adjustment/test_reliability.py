"""Tests of residuals: against adjustments without a point, statsmodels, and chance."""

import numpy as np
import pytest
import statsmodels.api as sm
from scipy import stats

from einschalt.theory.adjustment.reliability import (
    FittedPoints,
    external_reliability,
    external_t,
    joint_point_tests,
    joint_prediction_tests,
    minimal_detectable_bias,
    noncentrality,
    redundancy_numbers,
    standardized_residuals,
    tau_p_value,
)
from einschalt.theory.transformation.affine import fit_affine
from einschalt.theory.transformation.helmert import fit_helmert

FITS = {"affine": fit_affine, "helmert": fit_helmert}


@pytest.fixture(params=FITS)
def weighted_model(request):
    """One model of nine points with weights: the fit function, and its arguments."""
    rng = np.random.default_rng(7)
    xy = rng.uniform(-100, 100, (9, 2))
    en = 3.0 * xy + rng.normal(0, 0.1, (9, 2)) + [4.5e6, 5.3e6]
    return FITS[request.param], xy, en, rng.uniform(0.5, 2.0, 9)


def points_of(fit, weights, start):
    cross = np.zeros(len(weights))
    return FittedPoints(fit.residuals, weights, fit.leverage, cross, np.asarray(start))


def without(place, *arrays):
    return [np.delete(array, place, axis=0) for array in arrays]


def test_one_less_leverage():
    np.testing.assert_array_equal(redundancy_numbers([0.25, 1.0]), [0.75, 0.0])


def test_never_below_zero_through_rounding():
    assert redundancy_numbers([1.0 + 1e-15])[0] == 0.0
    assert np.isnan(redundancy_numbers([np.nan])[0])


def test_error_of_an_observation_shows_with_minus_its_redundancy_number():
    rng = np.random.default_rng(1)
    xy = rng.uniform(-100, 100, (8, 2))
    en = 3.0 * xy
    clean = fit_affine(xy, en, np.ones(8), np.array([0, 8]))
    wrong = en.copy()
    wrong[5, 0] += 1.0
    fit = fit_affine(xy, wrong, np.ones(8), np.array([0, 8]))
    # residuals are transformed − given
    change = fit.residuals[5, 0] - clean.residuals[5, 0]
    np.testing.assert_allclose(change, -redundancy_numbers(fit.leverage)[5, 0])


def test_standardized_residuals_are_those_of_statsmodels():
    rng = np.random.default_rng(3)
    design = np.column_stack([np.ones(12), rng.normal(size=(12, 2))])
    observed = rng.normal(size=12)
    fit = sm.OLS(observed, design).fit()
    influence = fit.get_influence()
    s_0, r = np.sqrt(fit.mse_resid), 1.0 - influence.hat_matrix_diag
    tau = standardized_residuals(fit.resid, r, s_0)
    np.testing.assert_allclose(tau, influence.resid_studentized_internal)
    t = external_t(tau, 9)
    np.testing.assert_allclose(t, influence.resid_studentized_external)
    p_value = fit.outlier_test()[:, 1]
    np.testing.assert_allclose(tau_p_value(tau, 9), p_value)


def test_unchecked_observations_have_no_statistic():
    assert np.isnan(standardized_residuals(0.1, 0.0, 1.0))
    assert np.isnan(external_t(1.0, 1))
    assert np.isnan(tau_p_value(0.5, 1))
    assert np.isinf(minimal_detectable_bias(0.1, 0.0))


def test_joint_test_is_the_f_test_without_the_point(weighted_model):
    fit_of, xy, en, weights = weighted_model
    fit = fit_of(xy, en, weights, np.array([0, 9]))
    tests = joint_point_tests(
        points_of(fit, weights, [0, 9]), fit.sum_of_squares, fit.redundancy
    )
    for place in range(9):
        less = fit_of(*without(place, xy, en, weights), np.array([0, 8]))
        gain = fit.sum_of_squares[0] - less.sum_of_squares[0]
        f = int(less.redundancy[0])
        ratio = (gain / 2) / (less.sum_of_squares[0] / f)
        assert tests.p_value[place] == pytest.approx(stats.f.sf(ratio, 2, f), rel=1e-6)
        assert tests.w[place] == pytest.approx(np.sqrt(gain) / fit.s_0[0], rel=1e-6)


def test_prediction_test_is_the_same_test(weighted_model):
    fit_of, xy, en, weights = weighted_model
    fit = fit_of(xy, en, weights, np.array([0, 9]))
    tests = joint_point_tests(
        points_of(fit, weights, [0, 9]), fit.sum_of_squares, fit.redundancy
    )
    less = fit_of(*without(4, xy, en, weights), np.array([0, 8]))
    miss = less.apply(np.array([0]), xy[4:5]) - en[4:5]
    cofactor = less.point_cofactors(np.array([0]), xy[4:5])[0, 0, 0] + 1 / weights[4]
    squares = np.sum(miss**2, axis=1) / cofactor
    predicted = joint_prediction_tests(squares, less.sum_of_squares, less.redundancy)
    assert predicted.p_value[0] == pytest.approx(tests.p_value[4], rel=1e-6)


@pytest.mark.parametrize("f", [3, 4, 7, 150, 9_999, 10_001, 10_002, 50_000, 41.3])
def test_probability_for_any_redundancy(f):
    """Whole numbers of not too many factors are multiplied, others are powers."""
    share = np.array([0.0, 1e-4, 0.2, 0.9, 1.0])
    residuals = np.column_stack([np.sqrt(share), np.zeros(5)])
    points = FittedPoints(
        *(residuals, np.ones(5), np.zeros((5, 2)), np.zeros(5), np.array([0, 5]))
    )
    tests = joint_point_tests(points, np.array([1.0]), np.array([f]))
    np.testing.assert_allclose(tests.w, np.sqrt(share * f), rtol=1e-14)
    expected = stats.beta.sf(share, 1.0, 0.5 * (f - 2))
    np.testing.assert_allclose(tests.p_value, expected, rtol=1e-11, atol=1e-300)


def test_too_little_redundancy_is_not_tested():
    xy = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.1]])
    en = xy + np.array([[0.1, 0.0], [0.0, 0.0], [0.0, 0.1], [0.0, 0.0]])
    fit = fit_affine(xy, en, np.ones(4), np.array([0, 4]))  # redundancy 2
    tests = joint_point_tests(
        points_of(fit, np.ones(4), [0, 4]), fit.sum_of_squares, fit.redundancy
    )
    assert np.isnan(tests.w).all()
    assert np.isnan(tests.p_value).all()
    assert np.isnan(joint_prediction_tests([1.0], [0.0], [0]).p_value).all()


def test_p_values_are_uniform_over_a_hundred_thousand_points():
    rng = np.random.default_rng(11)
    n_models, n_points = 10_000, 10
    start = np.arange(n_models + 1) * n_points
    xy = rng.uniform(-1, 1, (n_models * n_points, 2))
    en = xy + rng.normal(0.0, 0.01, xy.shape)
    fit = fit_affine(xy, en, np.ones(len(xy)), start)
    tests = joint_point_tests(
        points_of(fit, np.ones(len(xy)), start), fit.sum_of_squares, fit.redundancy
    )
    for alpha in (0.05, 0.01, 0.001):
        # points of one model are nearly independent: three standard errors, and a tenth
        bound = 3.3 * np.sqrt(alpha * (1 - alpha) / len(xy))
        assert np.mean(tests.p_value < alpha) == pytest.approx(alpha, abs=bound)
    # E[T] = 2 σ² for both coordinates, and s_0² is in the mean σ²
    assert np.mean(tests.w**2) == pytest.approx(2.0, rel=0.01)


def test_noncentrality_finds_what_it_promises():
    assert noncentrality() == pytest.approx(4.1319, abs=3e-4)
    assert noncentrality(0.05, 0.80) == pytest.approx(2.80, abs=5e-3)
    # both coordinates together: the χ² of two degrees
    delta = noncentrality(0.001, 0.80, degrees=2)
    limit = stats.chi2.isf(0.001, 2)
    assert stats.ncx2.sf(limit, 2, delta**2) == pytest.approx(0.80, abs=1e-6)


def test_bias_of_the_minimal_size_is_found_with_its_power():
    r, sigma, n_tests = 0.36, 0.02, 200_000
    bias = minimal_detectable_bias(sigma, r)
    rng = np.random.default_rng(5)
    # the residual of an observation has the standard error σ √r and the bias −r ∇
    residual = rng.normal(-r * bias, sigma * np.sqrt(r), n_tests)
    w = standardized_residuals(residual, r, sigma)
    found = np.mean(np.abs(w) > stats.norm.isf(0.0005))
    assert found == pytest.approx(0.80, abs=3 * np.sqrt(0.8 * 0.2 / n_tests))


def test_external_reliability_of_a_corner():
    bias = minimal_detectable_bias(1.0, 0.30)
    assert bias == pytest.approx(7.54, abs=0.01)
    assert external_reliability(bias, 0.30) == pytest.approx(5.28, abs=0.01)
