"""The affinity of models against its definition, and its derivatives against steps."""

import numpy as np
import pytest

from einschalt.theory.transformation.affine import fit_affine
from einschalt.theory.transformation.affinity import (
    affine_matrices,
    affinity_derivatives,
    model_affinities,
)
from einschalt.theory.transformation.helmert import fit_helmert
from einschalt.theory.transformation.point_tests import CommonPoints

P, Q = 3e-4, -1e-4


def models(n_models=4, n_points=9):
    """Models with the affinity P, Q, turned and shifted each in its own way."""
    rng = np.random.default_rng(0)
    start = np.arange(n_models + 1) * n_points
    source = rng.uniform(-0.1, 0.1, (n_models * n_points, 2)) + 0.4
    target = np.empty_like(source)
    for k in range(n_models):
        angle, scale = rng.uniform(0, 6), rng.uniform(7000, 9000)
        turn = np.array(
            [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        )
        matrix = scale * turn @ np.array([[1 + P, Q], [Q, 1 - P]])
        rows = slice(start[k], start[k + 1])
        target[rows] = source[rows] @ matrix.T + rng.uniform(0, 5e5, 2)
    weights = rng.uniform(0.5, 2.0, len(source))
    return CommonPoints(source, target, weights, start)


def fitted(points, fit=fit_affine):
    return fit(points.source, points.target, points.weights, points.start)


@pytest.mark.parametrize("fit", [fit_affine, fit_helmert])
def test_it_is_found_whatever_was_fitted(fit):
    matrix, _ = affine_matrices(fitted(models(), fit).moments)
    found = model_affinities(matrix)
    np.testing.assert_allclose(found, [[P, Q]] * 4, rtol=1e-3)


def test_derivatives_are_those_of_small_steps():
    points = models()
    moments = fitted(points).moments
    derivatives = affinity_derivatives(points, moments)
    matrix, _ = affine_matrices(moments)
    before = model_affinities(matrix)
    step = 1e-3
    for row in (0, 13, 35):
        for axis in range(2):
            target = points.target.copy()
            target[row, axis] += step
            moved = CommonPoints(points.source, target, points.weights, points.start)
            changed, _ = affine_matrices(fitted(moved).moments)
            change = (model_affinities(changed) - before)[points.model[row]] / step
            expected = derivatives[row, :, axis]
            # terms of second order: an affinity of 3e-4 times the derivative
            atol = 1e-3 * np.hypot(*expected)
            np.testing.assert_allclose(change, expected, rtol=0.0, atol=atol)


def test_models_that_show_no_shape():
    points = models()
    source = points.source.copy()
    source[points.model == 1] = np.outer(np.arange(9.0), [0.01, 0.02])
    start = np.array([0, 2, 18, 27, 36])  # two points only in the first
    points = CommonPoints(source, points.target, points.weights, start)
    line = CommonPoints(source, points.target, points.weights, np.arange(5) * 9)
    matrix, _ = affine_matrices(fitted(line).moments)
    assert np.isnan(matrix[1]).all()
    matrix, _ = affine_matrices(fitted(points).moments)
    assert np.isnan(matrix[0]).all()
    assert np.isfinite(matrix[2:]).all()
    # ground on a line: the way to it has no inverse
    target = points.target.copy()
    target[points.model == 1, 1] = target[points.model == 1, 0]
    flat = CommonPoints(points.source, target, points.weights, np.arange(5) * 9)
    derivatives = affinity_derivatives(flat, fitted(flat).moments)
    assert np.isnan(derivatives[flat.model == 1]).all()
    assert np.isfinite(derivatives[flat.model != 1]).all()
