"""Cofactors of an orientation that hardly is determined, or is not."""

import numpy as np
import pytest

from einschalt.theory.relative_orientation.coplanarity import (
    ORIENTED,
    UNDETERMINED,
    orient_pairs,
)
from einschalt.theory.relative_orientation.coplanarity_precision import fill_precision

# base along x: the parameters of its direction are y and z of the vector
TANGENTS = (0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
N_ROWS = 30


def filled(rows, weights, strengths):
    numbers, cofactor = np.empty(len(rows)), np.empty((6, 6))
    fill_precision(rows, weights, strengths, TANGENTS, numbers, cofactor)
    return numbers, cofactor


def rows_that_almost_depend(rng, part):
    """Rows whose last column is the sum of the others but for a part of its length."""
    rows = rng.standard_normal((N_ROWS, 5))
    rows[:, 4] = rows[:, :4].sum(axis=1) + part * rows[:, 4]
    return rows


@pytest.mark.slow
@pytest.mark.parametrize("part", [1.0, 1e-4, 1e-9])
def test_cofactors_are_those_of_an_orthogonal_decomposition(part):
    # for 1e-9 the normal equations have no digit left of what decides
    rng = np.random.default_rng(0)
    rows, weights = rows_that_almost_depend(rng, part), rng.uniform(0.5, 2.0, N_ROWS)
    strengths = weights**2 * rng.uniform(0.5, 2.0, N_ROWS)
    numbers, cofactor = filled(rows, weights, strengths)
    q, r = np.linalg.qr(np.sqrt(weights)[:, None] * rows)
    x = np.sqrt(weights)[:, None] * q @ np.linalg.inv(r).T / weights[:, None]
    wanted = (x * strengths[:, None]).T @ x
    # rounding of 30 rows times the condition, twice: the cofactors are squares
    rounding = 2.0 * N_ROWS * np.finfo(float).eps * np.linalg.cond(rows)
    np.testing.assert_allclose(cofactor[1:, 1:], wanted, rtol=rounding)
    np.testing.assert_allclose(numbers, 1.0 - np.sum(q**2, axis=1), atol=1e-6)
    assert numbers.sum() == pytest.approx(N_ROWS - 5, abs=1e-5)


@pytest.mark.parametrize("part", [0.0, 1e-15, 1e-13])
def test_what_rounding_alone_determines_is_not_determined(part):
    rng = np.random.default_rng(1)
    for _ in range(50):
        rows, ones = rows_that_almost_depend(rng, part), np.ones(N_ROWS)
        numbers, cofactor = filled(rows, ones, ones)
        assert np.isnan(cofactor).all()
        assert np.isnan(numbers).all()


def test_rows_of_nothing_determine_nothing():
    zeros, ones = np.zeros((N_ROWS, 5)), np.ones(N_ROWS)
    assert np.isnan(filled(zeros, ones, ones)[1]).all()


@pytest.mark.parametrize("estimator", ["rigorous", "determinants"])
def test_no_variance_is_negative_however_close_points_are_to_a_line(estimator):
    rng = np.random.default_rng(2)
    n_pairs, n_points = 300, 15
    along = np.linspace(0.0, 1.0, n_points)[:, None] * [90.0, 60.0, -80.0, 55.0]
    off = 10.0 ** rng.uniform(-17.0, 1.0, n_pairs)
    noise = off[:, None, None] * rng.standard_normal((n_pairs, n_points, 4))
    shift = np.array([2.0, 0.0, -60.0, 0.0])
    image = (along + shift + noise).reshape(-1, 4)
    start = n_points * np.arange(n_pairs + 1)
    oriented = orient_pairs(image, start, 152.0, estimator)
    variance = np.diagonal(oriented.cofactor, axis1=1, axis2=2)
    is_oriented = oriented.status == ORIENTED
    assert (variance[is_oriented] >= 0.0).all()
    assert (variance[is_oriented].sum(axis=1) > 0.0).all()
    assert np.isnan(variance[oriented.status == UNDETERMINED]).all()
    # a line but for rounding: nothing that an orientation could hold on to
    assert (oriented.status[off < 1e-9] == UNDETERMINED).all()
    assert not is_oriented[off < 1e-9].any()
