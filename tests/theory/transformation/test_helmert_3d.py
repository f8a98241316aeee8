import numpy as np
import pytest
from scipy.optimize import least_squares

from einschalt.foundations.rotations import rotation_from_angles
from einschalt.theory.transformation.helmert import fit_helmert
from einschalt.theory.transformation.helmert_3d import (
    fit_helmert_3d,
    helmert_3d_cofactors,
)
from einschalt.theory.transformation.plane_fit import SAME_GROUND, UNDETERMINED, USABLE

FIVE = np.array([[0.0, 0, 0], [100, 0, 5], [0, 100, -5], [100, 100, 20], [50, 30, 10]])


def turned(points, angles, scale=1.0, shift=(0.0, 0.0, 0.0)):
    """Points turned right-handed by ω, φ, κ: R_x R_y R_z."""
    return scale * points @ rotation_from_angles(*angles) + np.array(shift)


def fit_one(source, target, weights=None):
    n = len(source)
    weights = np.ones(n) if weights is None else weights
    return fit_helmert_3d(source, target, weights, np.array([0, n]))


def test_parameters_are_those_of_the_formula():
    angles, shift = (0.1, -0.2, 3.0), (7.0, -3.0, 11.0)
    fit = fit_one(FIVE, turned(FIVE, angles, 2.5, shift))
    names = ("te", "tn", "th", "scale", "omega", "phi", "kappa")
    assert fit.parameter_names == names
    np.testing.assert_allclose(
        fit.parameters[0], [*shift, 2.5, *angles], rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_quarter_turn_is_right_handed(axis):
    angles = np.zeros(3)
    angles[axis] = np.pi / 2
    unit = np.roll([1.0, 0.0, 0.0], axis + 1)
    fit = fit_one(FIVE, turned(FIVE, angles))
    # a right-handed quarter turn about x takes y to z, and so on
    np.testing.assert_allclose(
        fit.rotation[0] @ unit, np.roll(unit, 1), rtol=0, atol=1e-12
    )


def test_against_an_iterated_solution(solver_named, make_models):
    solver = solver_named("helmert_3d")
    models = make_models(solver, [12], seed=50, noise=0.5)
    target = models.target - models.target.mean(axis=0)
    fit = fit_helmert_3d(models.source, target, models.weights, models.start)
    root = np.sqrt(models.weights)[:, None]

    def misclosure(parameters):
        return (root * (solver.formula(parameters, models.source) - target)).ravel()

    start = fit.parameters[0] + [1.0, -1.0, 2.0, 0.01, 0.01, -0.01, 0.02]
    found = least_squares(
        misclosure, start, x_scale=[10, 10, 10, 0.01, 0.01, 0.01, 0.01], xtol=1e-15
    )
    np.testing.assert_allclose(fit.parameters[0], found.x, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(fit.sum_of_squares[0], 2 * found.cost, rtol=1e-10)
    inverse = np.linalg.inv(found.jac.T @ found.jac)
    size = np.sqrt(inverse.diagonal())
    wrong = (helmert_3d_cofactors(fit)[0] - inverse) / np.outer(size, size)
    assert np.abs(wrong).max() < 1e-4


def test_points_in_a_plane_are_turned_and_not_mirrored():
    flat = FIVE * [1, 1, 0]
    fit = fit_one(flat, turned(flat, (0.3, 0.2, -1.0), 3.0))
    assert fit.status[0] == USABLE
    np.testing.assert_allclose(np.linalg.det(fit.rotation[0]), 1.0, rtol=1e-12)
    np.testing.assert_allclose(fit.parameters[0, 3:], [3.0, 0.3, 0.2, -1.0], rtol=1e-9)
    assert not fit.is_mirrored.any()


def test_flat_points_are_a_plane_helmert_in_plan():
    rng = np.random.default_rng(51)
    xy = rng.uniform(-400, 400, (14, 2))
    c, s = 2.0 * np.cos(0.7), 2.0 * np.sin(0.7)
    en = xy @ np.array([[c, s], [-s, c]]) + rng.normal(0, 0.05, (14, 2))
    flat = np.column_stack([xy, np.zeros(14)])
    space = fit_one(flat, np.column_stack([en, np.zeros(14)]))
    plane = fit_helmert(xy, en, np.ones(14), np.array([0, 14]))
    np.testing.assert_allclose(space.residuals[:, :2], plane.residuals, atol=1e-9)
    np.testing.assert_allclose(space.leverage[:, :2], plane.leverage, rtol=1e-9)


def test_heights_of_flat_points_are_an_inclined_plane(filled_rectangle):
    points, special = filled_rectangle
    n = len(points)
    flat = np.column_stack([points, np.zeros(n)])
    fit = fit_one(flat, flat)
    corners = np.column_stack([special, np.zeros(4)])
    cofactors = n * fit.point_cofactors(np.zeros(4, dtype=int), corners)
    # in plan as helmert, in height as affine
    np.testing.assert_allclose(cofactors[[0, 3], 0, 0], [1, 4], rtol=0.02)
    np.testing.assert_allclose(cofactors[:, 2, 2], [1, 4, 4, 7], rtol=0.02)


def test_precision_of_angles_is_unknown_at_a_right_angle_of_phi():
    fit = fit_one(FIVE, turned(FIVE, (0.0, np.pi / 2, 0.3)))
    cofactors = helmert_3d_cofactors(fit)[0]
    # ω and κ turn about the same axis there; shift and scale do not care
    assert np.isnan(cofactors[4:, 4:]).all()
    assert np.isfinite(fit.point_cofactors(np.zeros(5, dtype=int), FIVE)).all()


def test_ground_points_on_a_line_determine_no_rotation():
    line = np.column_stack([np.linspace(0, 900, 5), np.zeros(5), np.zeros(5)])
    for ground, status in (
        (line, UNDETERMINED),
        (np.zeros((5, 3)), SAME_GROUND),
        (line + np.array([4.5e6, 5.3e6, 500]), UNDETERMINED),
    ):
        # a good model beside it must not suffer
        fit = fit_helmert_3d(
            np.vstack([FIVE, FIVE]),
            np.vstack([ground, FIVE]),
            np.ones(10),
            np.array([0, 5, 10]),
        )
        assert fit.status.tolist() == [status, USABLE]
        np.testing.assert_allclose(fit.scale[1], 1.0, rtol=1e-12)


def test_large_coordinates_keep_their_digits():
    offset = np.array([4.5e6, 5.3e6, 4.8e6])
    angles = (1e-6, -2e-6, 3e-6)
    near = turned(FIVE * 10.0, angles, 1 + 1e-6)
    fit = fit_one(offset + FIVE * 10.0, offset + near)
    np.testing.assert_allclose(
        fit.parameters[0, 3:], [1 + 1e-6, *angles], rtol=0, atol=5e-12
    )
