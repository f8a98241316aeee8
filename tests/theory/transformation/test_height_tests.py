"""Tests of single heights: exact, of points in a fit and of others."""

import numpy as np
import pytest
from scipy import stats
from tests.theory.transformation.test_point_tests import fitted, points_with

from einschalt.theory.transformation.height_tests import (
    fitted_height_tests,
    other_height_tests,
)
from einschalt.theory.transformation.helmert_3d import fit_helmert_3d
from einschalt.theory.transformation.point_tests import (
    CommonPoints,
    fitted_tests,
    other_tests,
)

ALL = np.arange(18)


def with_wrong_height(points, place, size):
    target = points.target.copy()
    target[place, 2] += size
    return CommonPoints(points.source, target, points.weights, points.start)


def test_probability_is_that_of_a_linear_adjustment():
    points = points_with(3)
    fit = fitted(fit_helmert_3d, points)
    found = fitted_height_tests(fit, points)
    rows = slice(9, 18)
    root = np.sqrt(points.weights[rows])
    ground = points.target[rows] - points.target[rows].mean(axis=0)
    design = np.column_stack([np.ones(9), ground]) * root[:, None]
    left = fit.residuals[rows, 2] * root
    left = left - design @ np.linalg.lstsq(design, left, rcond=None)[0]
    hat = np.einsum("ij,ji->i", design, np.linalg.pinv(design))
    f = 9 - 4
    tau = left / np.sqrt(1.0 - hat) / np.sqrt(np.sum(left**2) / f)
    t = tau * np.sqrt((f - 1) / (f - tau**2))
    np.testing.assert_allclose(found[rows], 2.0 * stats.t.sf(np.abs(t), f - 1))


def test_height_in_and_out_of_the_fit_has_one_probability():
    points = points_with(3)
    found = fitted_height_tests(fitted(fit_helmert_3d, points), points)
    for place in (0, 5, 11):
        kept, out = points.chosen(place != ALL), points.chosen(place == ALL)
        fit = fitted(fit_helmert_3d, kept)
        other = other_height_tests(fit, kept, out.model, out)
        # linear up to the square of the residuals over the distances
        assert other[0] == pytest.approx(found[place], rel=2e-3)


def test_a_wrong_height_is_refused_and_no_other():
    points = with_wrong_height(points_with(3, n_points=12), 3, 0.5)
    p_value = fitted_height_tests(fitted(fit_helmert_3d, points), points)
    assert p_value.argmin() == 3
    assert p_value[3] < 1e-6


def test_plan_and_height_count_together():
    points = with_wrong_height(points_with(3, n_points=12), 3, 0.5)
    fit = fitted(fit_helmert_3d, points)
    assert fitted_tests(fit, points).p_value[3] == pytest.approx(
        2.0 * fitted_height_tests(fit, points)[3]
    )
    is_out = np.arange(24) == 3
    kept, out = points.chosen(~is_out), points.chosen(is_out)
    again = fitted(fit_helmert_3d, kept)
    assert other_tests(again, kept, out.model, out).p_value[0] < 1e-6


def test_few_heights_tell_nothing():
    points = points_with(3, n_points=5)  # f = 1
    p_value = fitted_height_tests(fitted(fit_helmert_3d, points), points)
    assert np.isnan(p_value).all()


def test_heights_on_a_plane_tell_no_scale():
    points = points_with(3)
    source, target = points.source.copy(), points.target.copy()
    noise = target[:, 2] - source[:, 2] - 5e6
    source[:, 2], target[:, 2] = 0.0, 5e6
    source[:, 2] += noise
    flat = CommonPoints(source, target, points.weights, points.start)
    p_value = fitted_height_tests(fitted(fit_helmert_3d, flat), flat)
    assert np.isfinite(p_value).all()


def test_clean_heights_are_refused_as_often_as_the_level_says():
    points = points_with(3, n_points=20_000)
    n = len(points.weights) // 10
    start = np.arange(n + 1) * 10
    rng = np.random.default_rng(5)
    source = rng.uniform(-100, 100, points.source.shape)
    scale = 1.0 / np.sqrt(points.weights)[:, None]
    target = source + 0.01 * scale * rng.standard_normal(source.shape)
    clean = CommonPoints(source, target, points.weights, start)
    p_value = fitted_height_tests(fitted(fit_helmert_3d, clean), clean)
    for level in (0.05, 0.01, 0.001):
        low, high = stats.binom.ppf([0.001, 0.999], len(p_value), level)
        assert low <= np.count_nonzero(p_value < level) <= high
