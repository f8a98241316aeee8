"""Correction of machine coordinates, against two cameras and their real rays."""

import numpy as np
import pytest

from einschalt.foundations.rotations import rotation_by_vector, rotation_from_angles
from einschalt.theory.relative_orientation.hallert import adjust_parallaxes
from einschalt.theory.relative_orientation.model_correction import (
    correct_model,
    disturb_model,
    parallaxes_to_clear,
)
from einschalt.theory.relative_orientation.parallax_equations import (
    CASES,
    DEPENDENT_LEFT,
    DEPENDENT_RIGHT,
    INDEPENDENT,
    design_matrix,
)

BASE = 92.0
DIRECTION = np.array([0.4, -0.7, 0.5, 0.3, -0.6])
SIGN = {INDEPENDENT: 1.0, DEPENDENT_LEFT: 1.0, DEPENDENT_RIGHT: -1.0}


@pytest.fixture
def hilly_points():
    rng = np.random.default_rng(1971)
    return rng.uniform([-5, -95, -190], [97, 95, -110], size=(30, 3))


def elements_of(case, angle):
    lengths = np.ones(5) if case == INDEPENDENT else np.array([1, 1, 1, 150.0, 150.0])
    return angle * DIRECTION * lengths


def through_cameras(xyz_world, cameras, principal_distance=152.0):
    """Photograph the points, and form the model as if both cameras stood upright.

    Returns the machine coordinates and y_left - y_right.
    """
    rays = []
    for centre, angles in cameras:
        r = (xyz_world - centre) @ rotation_from_angles(*angles).T
        image = -principal_distance * r[:, :2] / r[:, 2:]
        rays.append(np.column_stack([image, np.full(len(r), -principal_distance)]))
    left, right = (ray / ray[:, 2:] for ray in rays)
    z = BASE / (left[:, 0] - right[:, 0])
    y_left, y_right = z * left[:, 1], z * right[:, 1]
    return np.column_stack(
        [z * left[:, 0], (y_left + y_right) / 2, z]
    ), y_left - y_right


def similarity_residuals(xyz, target):
    """Residuals of the best similarity onto the target, by singular values."""
    one, two = xyz - xyz.mean(axis=0), target - target.mean(axis=0)
    u, s, vt = np.linalg.svd(two.T @ one)
    sense = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    scale = np.trace(np.diag(s) @ sense) / np.sum(one**2)
    return scale * one @ (u @ sense @ vt).T - two


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("angle", [1e-4, 1e-2, 0.2])
def test_correction_undoes_the_disturbance(case, angle, hilly_points):
    elements = elements_of(case, angle)
    machine, parallax = disturb_model(hilly_points, BASE, elements, case)
    np.testing.assert_allclose(
        correct_model(machine, BASE, elements, case), hilly_points, atol=1e-10
    )
    np.testing.assert_allclose(
        parallaxes_to_clear(machine, BASE, elements, case), parallax, atol=1e-10
    )


@pytest.mark.parametrize("case", CASES)
def test_nothing_to_correct(case, hilly_points):
    machine, parallax = disturb_model(hilly_points, BASE, np.zeros(5), case)
    np.testing.assert_allclose(machine, hilly_points, atol=1e-12)
    np.testing.assert_allclose(parallax, 0.0, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_disturbed_model_is_what_two_cameras_show(case, hilly_points):
    # the elements are the angles of the cameras, and the place of the moved one
    e = elements_of(case, 0.02)
    left, right = np.zeros(3), np.array([BASE, 0.0, 0.0])
    upright = (0.0, 0.0, 0.0)
    shift = np.array([0.0, e[3], e[4]])
    cameras = {
        INDEPENDENT: [(left, (e[0], e[1], e[3])), (right, (0.0, e[2], e[4]))],
        DEPENDENT_LEFT: [(left + shift, e[:3]), (right, upright)],
        DEPENDENT_RIGHT: [(left, upright), (right + shift, e[:3])],
    }[case]
    machine, parallax = disturb_model(hilly_points, BASE, e, case)
    seen, y_left_less_right = through_cameras(hilly_points, cameras)
    np.testing.assert_allclose(machine, seen, atol=1e-11)
    np.testing.assert_allclose(parallax, SIGN[case] * y_left_less_right, atol=1e-11)


def photographs(xyz_truth, angle):
    """Two cameras somewhere in the world, nearly upright over their own base."""
    rng = np.random.default_rng(5)
    to_world = rotation_by_vector(np.array([0.3, -0.2, 1.1]))
    world = 80.0 * xyz_truth @ to_world.T + np.array([4e3, -2e3, 900.0])
    base = BASE * np.array([1.0, 0.6 * angle, -0.4 * angle])
    tilts = angle * rng.normal(size=(2, 3))
    in_model = (world - np.array([4e3, -2e3, 900.0])) @ to_world / 80.0
    return world, through_cameras(in_model, [(np.zeros(3), tilts[0]), (base, tilts[1])])


@pytest.mark.parametrize("case", CASES)
def test_what_remains_falls_with_the_square_of_the_angles(case, hilly_points):
    remaining, before = [], []
    for angle in (4e-3, 2e-3, 1e-3):
        world, (machine, y_left_less_right) = photographs(hilly_points, angle)
        oriented = adjust_parallaxes(
            machine,
            SIGN[case] * y_left_less_right,
            np.array([BASE]),
            np.array([0, len(machine)]),
            case=case,
        )
        corrected = correct_model(machine, BASE, oriented.elements[0], case)
        before.append(np.abs(similarity_residuals(machine, world / 80.0)).max())
        remaining.append(np.abs(similarity_residuals(corrected, world / 80.0)).max())
    remaining, before = np.array(remaining), np.array(before)
    # uncorrected of the first order, corrected of the second
    np.testing.assert_allclose(before[:-1] / before[1:], 2.0, rtol=0.05)
    np.testing.assert_allclose(remaining[:-1] / remaining[1:], 4.0, rtol=0.05)
    assert (remaining < 0.05 * before).all()


@pytest.mark.parametrize("case", CASES)
def test_orienting_and_correcting_twice_leaves_nothing(case, hilly_points):
    world, (machine, y_left_less_right) = photographs(hilly_points, 2e-3)
    total = np.zeros(5)
    for _ in range(4):
        # what the elements found so far leave of the measured parallaxes
        left = SIGN[case] * y_left_less_right
        left = left - parallaxes_to_clear(machine, BASE, total, case)
        step = adjust_parallaxes(
            machine, left, np.array([BASE]), np.array([0, len(machine)]), case=case
        )
        total = total + step.elements[0]
    corrected = correct_model(machine, BASE, total, case)
    assert np.abs(similarity_residuals(corrected, world / 80.0)).max() < 1e-9


def linear_change(xyz, elements, case):
    """First-order change of x, y, z, with the mark midway between the rays."""
    x, y, z = xyz.T
    left, right = np.zeros(5), np.zeros(5)
    if case == INDEPENDENT:
        left[:3], right[:3] = elements[[0, 1, 3]], [0.0, elements[2], elements[4]]
    else:
        (left if case == DEPENDENT_LEFT else right)[:] = elements

    def at_fixed_height(distance, moves):
        omega, phi, kappa, by, bz = moves
        dx = -distance * y / z * omega + (z + distance**2 / z) * phi - y * kappa
        dx -= distance / z * bz
        dy = -(y**2 + z**2) / z * omega + distance * y / z * phi + distance * kappa
        return dx, dy + by - y / z * bz

    dx_left, dy_left = at_fixed_height(x, left)
    dx_right, dy_right = at_fixed_height(x - BASE, right)
    dz = -z / BASE * (dx_left - dx_right)
    return np.column_stack(
        [dx_left + x / z * dz, (dy_left + dy_right) / 2 + y / z * dz, dz]
    )


@pytest.mark.parametrize("case", CASES)
def test_linear_formula_is_the_first_order_of_the_correction(case, hilly_points):
    elements = elements_of(case, 1e-5)
    change = correct_model(hilly_points, BASE, elements, case)
    change -= correct_model(hilly_points, BASE, -elements, case)
    linear = linear_change(hilly_points, elements, case)
    np.testing.assert_allclose(
        change / 2, linear, atol=1e-8 * np.abs(linear).max() + 1e-12
    )


@pytest.mark.parametrize("case", CASES)
def test_exact_parallax_begins_with_the_linear_one(case, hilly_points):
    wrong = []
    for angle in (2e-3, 1e-3):
        elements = elements_of(case, angle)
        exact = parallaxes_to_clear(hilly_points, BASE, elements, case)
        linear = design_matrix(hilly_points, BASE, case) @ elements
        wrong.append(np.abs(exact - linear).max())
    np.testing.assert_allclose(wrong[0] / wrong[1], 4.0, rtol=0.03)


def test_points_of_many_models_at_once(hilly_points):
    rng = np.random.default_rng(6)
    n_points = len(hilly_points)
    base, elements = rng.uniform(80, 100, n_points), rng.normal(0, 1e-3, (n_points, 5))
    together, parallax = disturb_model(hilly_points, base, elements, DEPENDENT_LEFT)
    for k in range(n_points):
        alone, p = disturb_model(
            hilly_points[[k]], base[[k]], elements[[k]], DEPENDENT_LEFT
        )
        np.testing.assert_array_equal(alone[0], together[k])
        assert p[0] == parallax[k]


def test_model_without_elements_has_no_coordinates(hilly_points):
    corrected = correct_model(hilly_points, BASE, np.full(5, np.nan), INDEPENDENT)
    assert np.isnan(corrected).all()
