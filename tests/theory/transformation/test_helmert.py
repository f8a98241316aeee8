import numpy as np
import pytest

from einschalt.theory.transformation.helmert import fit_helmert, helmert_cofactors


def design(xy):
    """Rows of a, b, te, tn: all eastings, then all northings."""
    x, y = xy.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    east = np.column_stack([x, -y, one, zero])
    north = np.column_stack([y, x, zero, one])
    return np.vstack([east, north])


def test_parameters_are_those_of_the_formula():
    xy = np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 100.0]])
    east = 2.0 * xy[:, 0] - 0.5 * xy[:, 1] + 7.0
    north = 0.5 * xy[:, 0] + 2.0 * xy[:, 1] - 3.0
    fit = fit_helmert(xy, np.column_stack([east, north]), np.ones(3), np.array([0, 3]))
    assert fit.parameter_names == ("a", "b", "te", "tn")
    np.testing.assert_allclose(fit.parameters[0], [2.0, 0.5, 7.0, -3.0], atol=1e-12)


def test_against_the_dense_solution(solver_named, make_models):
    models = make_models(solver_named("helmert"), [20], seed=30)
    centred = models.target - models.target.mean(axis=0)
    fit = fit_helmert(models.source, centred, models.weights, models.start)
    a, weights = design(models.source), np.tile(models.weights, 2)
    root = np.sqrt(weights)
    wanted, *_ = np.linalg.lstsq(a * root[:, None], centred.T.ravel() * root)
    np.testing.assert_allclose(fit.parameters[0], wanted, rtol=1e-10)
    inverse = np.linalg.inv(a.T @ (weights[:, None] * a))
    found = helmert_cofactors(fit)[0]
    size = np.sqrt(inverse.diagonal())
    assert np.abs((found - inverse) / np.outer(size, size)).max() < 1e-9
    hat = np.einsum("ni,ij,nj->n", a, inverse, a) * weights
    np.testing.assert_allclose(fit.leverage, hat.reshape(2, -1).T, rtol=1e-9)


def test_two_points_by_hand():
    # 100 m between the points, 250 m and a right angle on the ground
    xy = np.array([[10.0, 20.0], [110.0, 20.0]])
    en = np.array([[1000.0, 2000.0], [1000.0, 2250.0]])
    fit = fit_helmert(xy, en, np.ones(2), np.array([0, 2]))
    np.testing.assert_allclose(
        fit.parameters[0], [0.0, 2.5, 1050.0, 1975.0], rtol=0, atol=1e-10
    )
    np.testing.assert_allclose(fit.leverage, 1.0, rtol=1e-12)


def test_leverage_of_an_evenly_filled_rectangle(filled_rectangle):
    points, special = filled_rectangle
    n = len(points)
    fit = fit_helmert(points, points, np.ones(n), np.array([0, n]))
    cofactors = fit.point_cofactors(np.zeros(4, dtype=int), special)
    # 1 in the centre, 4 in the corner; 1 + 3 L²/(Lx² + Ly²) in the middle of an edge
    edge = 1 + 3 * np.array([230.0, 160.0]) ** 2 / (230.0**2 + 160.0**2)
    np.testing.assert_allclose(n * cofactors[:, 0, 0], [1, *edge, 4], rtol=0.02)
    assert np.mean(n * fit.leverage[:, 0]) == pytest.approx(2.0, rel=1e-9)


def test_easting_and_northing_are_uncorrelated(solver_named, make_models):
    fit = fit_helmert(*make_models(solver_named("helmert"), [9], seed=31))
    points = np.array([[500.0, -300.0], [0.0, 0.0]])
    cofactors = fit.point_cofactors(np.zeros(2, dtype=int), points)
    assert not cofactors[:, 0, 1].any()
    np.testing.assert_array_equal(cofactors[:, 0, 0], cofactors[:, 1, 1])


def test_coordinates_of_five_million_metres_keep_their_digits():
    # scale 1 + 1e-7 over 1 km: 0.1 mm, which an uncentred solution loses
    rng = np.random.default_rng(32)
    offset = np.array([4.5e6, 5.3e6])
    local = np.round(rng.uniform(-500.0, 500.0, (15, 2)), 3)
    fit = fit_helmert(
        offset + local, offset + local * (1 + 1e-7), np.ones(15), np.array([0, 15])
    )
    # rounding of the coordinates themselves: 1e-9 m over 500 m
    np.testing.assert_allclose(fit.parameters[0, 0], 1 + 1e-7, rtol=0, atol=3e-12)
    assert fit.s_0[0] < 2e-9
