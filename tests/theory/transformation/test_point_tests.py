"""Tests of points for every kind of transformation, against fits without the point."""

import numpy as np
import pytest
from scipy import stats

from einschalt.theory.transformation.affine import fit_affine
from einschalt.theory.transformation.helmert import fit_helmert
from einschalt.theory.transformation.helmert_3d import fit_helmert_3d
from einschalt.theory.transformation.point_tests import (
    CommonPoints,
    fitted_point_tests,
    other_point_tests,
    plan_sums,
)
from einschalt.theory.transformation.rigid import fit_rigid

PLANE = {"affine": fit_affine, "helmert": fit_helmert, "rigid": fit_rigid}


def points_with(n_axes, n_points=9, seed=2):
    rng = np.random.default_rng(seed)
    source = rng.uniform(-100, 100, (2 * n_points, n_axes))
    target = source + rng.normal(0.0, 0.01, source.shape) + 5e6
    weights = rng.uniform(0.5, 2.0, len(source))
    return CommonPoints(source, target, weights, np.array([0, n_points, 2 * n_points]))


def fitted(fit_of, points):
    return fit_of(points.source, points.target, points.weights, points.start)


@pytest.mark.parametrize("kind", PLANE)
def test_point_in_and_out_of_the_fit_have_one_probability(kind):
    points = points_with(2)
    tests = fitted_point_tests(fitted(PLANE[kind], points), points)
    for place in (0, 5, 11):
        is_out = np.arange(18) == place
        kept, out = points.chosen(~is_out), points.chosen(is_out)
        fit = fitted(PLANE[kind], kept)
        sums = plan_sums(fit, kept.weights, kept.start)
        _, other = other_point_tests(fit, sums, out.model, out)
        # rigid is linear up to the square of the residuals over the distances
        assert other.p_value[0] == pytest.approx(tests.p_value[place], rel=2e-3)


def test_rigid_axes_are_correlated_and_that_is_counted():
    points = points_with(2)
    fit = fitted(fit_rigid, points)
    tests = fitted_point_tests(fit, points)
    place = 4
    is_out = np.arange(18) == place
    less = fitted(fit_rigid, points.chosen(~is_out))
    gain = fit.sum_of_squares[0] - less.sum_of_squares[0]
    ratio = gain / 2 / (less.sum_of_squares[0] / less.redundancy[0])
    expected = stats.f.sf(ratio, 2, int(less.redundancy[0]))
    assert tests.p_value[place] == pytest.approx(expected, rel=2e-3)


def test_heights_do_not_enter():
    points = points_with(3)
    high = points.target.copy()
    high[3, 2] += 0.5  # fifty standard errors of a height
    spoilt = CommonPoints(points.source, high, points.weights, points.start)
    tests = fitted_point_tests(fitted(fit_helmert_3d, spoilt), spoilt)
    assert tests.p_value[3] > 0.001


def test_choosing_rows_and_models_keeps_them_together():
    points = points_with(2)
    rows, second = points.of_models(np.array([1]))
    assert rows.tolist() == list(range(9, 18))
    assert second.start.tolist() == [0, 9]
    few = points.chosen(np.arange(18) < 2)
    assert few.start.tolist() == [0, 2, 2]
    assert few.model.tolist() == [0, 0]
