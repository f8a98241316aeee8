"""Tests of points whose errors have covariances, in one model."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import einschalt as es
from einschalt.theory.adjustment.correlated_point_tests import correlated_point_tests

N_POINTS = 14


@pytest.fixture(scope="module")
def model():
    """Points of a model, and the design of an affine transformation of them."""
    xy = np.random.default_rng(3).uniform(-500.0, 500.0, (N_POINTS, 2))
    design = np.zeros((N_POINTS, 2, 6))
    design[:, 0, 0] = design[:, 1, 1] = 1.0
    design[:, 0, 2:4] = design[:, 1, 4:] = xy
    return xy, design


def shared_by_some(xy):
    """Measuring errors, and a shift that the last two of the points share."""
    term = np.r_[np.zeros(len(xy) - 2), 0.4, 0.4]
    return np.kron(np.eye(len(xy)) * 0.02**2 + np.outer(term, term), np.eye(2))


@pytest.mark.parametrize("weights", [np.ones(N_POINTS), np.linspace(0.2, 3.0, 14)])
def test_without_covariances_it_is_the_test_of_the_fit(model, weights):
    xy, design = model
    rng = np.random.default_rng(5)
    ground = xy + rng.normal(0.0, 0.02, xy.shape)
    ids = [str(k) for k in range(N_POINTS)]
    points = pd.DataFrame({"model_id": "1/2", "point_id": ids, "weight": weights})
    points[["x", "y"]] = xy
    known = pd.DataFrame(ground, columns=["easting", "northing"]).assign(point_id=ids)
    expected = es.transform_models(points, known).residuals
    covariance = np.kron(np.diag(7.0 / weights), np.eye(2))
    found = correlated_point_tests(xy - ground, design, covariance)
    np.testing.assert_allclose(found.w, expected["w"], rtol=1e-7)
    np.testing.assert_allclose(found.p_value, expected["p_value"], rtol=1e-6)


def test_what_points_share_is_no_gross_error(model):
    xy, design = model
    covariance = shared_by_some(xy)
    root = np.linalg.cholesky(covariance)
    rng = np.random.default_rng(6)
    drawn = (root @ rng.normal(size=(2 * N_POINTS, 200))).T.reshape(200, N_POINTS, 2)
    p_value = np.array(
        [correlated_point_tests(each, design, covariance).p_value for each in drawn]
    )
    # each point by itself: binomial limits of 200 draws at one in a million
    below = np.sum(p_value < 0.05, axis=0)
    assert below.max() <= stats.binom.isf(1e-6, 200, 0.05)
    assert stats.kstest(p_value[:, 0], "uniform").pvalue > 1e-6
    # points taken for independent: those that are right stand out of the others
    alone = np.eye(2 * N_POINTS)
    wrong = [correlated_point_tests(each, design, alone).p_value for each in drawn[:50]]
    assert np.mean(np.array(wrong)[:, -2:] < 0.001) > 0.05


def test_a_gross_error_among_points_that_share_errors_is_found(model):
    xy, design = model
    covariance = shared_by_some(xy)
    rng = np.random.default_rng(7)
    residuals = np.linalg.cholesky(covariance) @ rng.normal(size=2 * N_POINTS)
    residuals = residuals.reshape(-1, 2)
    residuals[9, 0] += 0.4
    found = correlated_point_tests(residuals, design, covariance)
    assert np.argmin(found.p_value) == 9
    assert found.p_value[9] < 1e-5
    # what parameters take up makes no difference, nor does the unit
    again = residuals + design @ [3.0, -2.0, 0.1, 0.2, -0.1, 0.3]
    other = correlated_point_tests(again, design, 1e4 * covariance)
    np.testing.assert_allclose(other.p_value, found.p_value, rtol=1e-6)


def test_points_that_nothing_checks_have_no_test(model):
    _, design = model
    residuals = np.random.default_rng(8).normal(size=(N_POINTS, 2))
    few = correlated_point_tests(residuals[:4], design[:4], np.eye(8))
    assert np.isnan(few.p_value).all()
    still = correlated_point_tests(0.0 * residuals, design, np.eye(2 * N_POINTS))
    assert np.isnan(still.w).all()
    lone = np.column_stack([design.reshape(-1, 6), np.eye(2 * N_POINTS)[:, :2]])
    lone = lone.reshape(N_POINTS, 2, 8)
    found = correlated_point_tests(residuals, lone, np.eye(2 * N_POINTS))
    assert np.isnan(found.p_value[0])
    assert np.isfinite(found.p_value[1:]).all()
