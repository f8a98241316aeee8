import numpy as np
import pytest
from scipy.optimize import least_squares

from einschalt.theory.transformation.helmert import fit_helmert
from einschalt.theory.transformation.rigid import fit_rigid, rigid_cofactors


def test_parameters_are_those_of_the_formula():
    xy = np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 100.0]])
    theta = np.radians(150.0)
    c, s = np.cos(theta), np.sin(theta)
    en = np.column_stack(
        [xy[:, 0] * c - xy[:, 1] * s + 7.0, xy[:, 0] * s + xy[:, 1] * c - 3.0]
    )
    fit = fit_rigid(xy, en, np.ones(3), np.array([0, 3]))
    assert fit.parameter_names == ("theta", "te", "tn")
    np.testing.assert_allclose(fit.parameters[0], [theta, 7.0, -3.0], atol=1e-12)


def test_against_an_iterated_solution(solver_named, make_models):
    solver = solver_named("rigid")
    models = make_models(solver, [12], seed=40, noise=3.0)
    target = models.target - models.target.mean(axis=0)
    fit = fit_rigid(models.source, target, models.weights, models.start)
    root = np.sqrt(models.weights)[:, None]

    def misclosure(parameters):
        return (root * (solver.formula(parameters, models.source) - target)).ravel()

    start = fit.parameters[0] + [0.1, 5.0, -5.0]
    found = least_squares(misclosure, start, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    np.testing.assert_allclose(fit.parameters[0], found.x, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(fit.sum_of_squares[0], 2 * found.cost, rtol=1e-10)
    # the iterated solution linearises as the cofactors do
    inverse = np.linalg.inv(found.jac.T @ found.jac)
    np.testing.assert_allclose(rigid_cofactors(fit)[0], inverse, rtol=1e-4, atol=1e-8)


def test_scale_is_held(solver_named, make_models):
    models = make_models(solver_named("rigid"), [12], seed=41, noise=0.0)
    longer = models.target.mean(axis=0) + 1.001 * (
        models.target - models.target.mean(axis=0)
    )
    fit = fit_rigid(models.source, longer, models.weights, models.start)
    matrix, _ = fit.homogeneous(0)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(2), rtol=0, atol=1e-12)
    # what the scale does not take up is in the residuals: 1 ‰ of the arm
    assert 0.1 < fit.s_0[0] < 0.5


def test_rotation_is_that_of_helmert(solver_named, make_models):
    models = make_models(solver_named("rigid"), [12], seed=42, noise=0.5)
    a, b, _, _ = fit_helmert(*models).parameters[0]
    theta = fit_rigid(*models).parameters[0, 0]
    np.testing.assert_allclose(theta, np.arctan2(b, a), rtol=1e-12)


def test_leverage_of_an_evenly_filled_rectangle(filled_rectangle):
    points, special = filled_rectangle
    n = len(points)
    fit = fit_rigid(points, points, np.ones(n), np.array([0, n]))
    cofactors = fit.point_cofactors(np.zeros(4, dtype=int), special)
    mean = n * np.trace(cofactors, axis1=1, axis2=2) / 2
    assert mean[0] == pytest.approx(1.0, rel=0.02)
    assert mean[3] == pytest.approx(2.5, rel=0.02)
    assert np.mean(n * fit.leverage) == pytest.approx(1.5, rel=1e-9)


def test_point_moves_across_its_arm():
    # an uncertain rotation moves a point on the x axis only in the northing
    xy = np.array([[-100.0, 0.0], [100.0, 0.0]])
    fit = fit_rigid(xy, xy, np.ones(2), np.array([0, 2]))
    cofactors = fit.point_cofactors(np.zeros(1, dtype=int), np.array([[300.0, 0.0]]))
    np.testing.assert_allclose(cofactors[0], [[0.5, 0.0], [0.0, 0.5 + 4.5]], rtol=1e-12)


def test_angle_lies_between_half_turns(solver_named, make_models):
    solver = solver_named("rigid")
    fit = fit_rigid(*make_models(solver, np.full(50, 4), seed=43))
    theta = fit.parameters[:, 0]
    assert (np.abs(theta) <= np.pi).all()
    assert theta.min() < -2.0
    assert theta.max() > 2.0
