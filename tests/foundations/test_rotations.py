"""The rotation matrix, and its angles."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from einschalt.foundations.rotations import (
    angle_rates,
    angles_from_rotation,
    cross_matrix,
    rotation_by_vector,
    rotation_from_angles,
)


@pytest.fixture
def angles():
    """Omega, phi, kappa anywhere, phi not near to a right angle."""
    rng = np.random.default_rng(11)
    return rng.uniform([-np.pi, -1.4, -np.pi], [np.pi, 1.4, np.pi], (200, 3))


def test_is_a_rotation(angles):
    matrix = rotation_from_angles(*angles.T)
    np.testing.assert_allclose(
        matrix @ np.swapaxes(matrix, 1, 2), np.tile(np.eye(3), (200, 1, 1)), atol=1e-15
    )
    np.testing.assert_allclose(np.linalg.det(matrix), 1.0, atol=1e-14)


def test_is_the_textbook_matrix():
    omega, phi, kappa = 0.3, -0.2, 2.5
    so, co, sp, cp = np.sin(omega), np.cos(omega), np.sin(phi), np.cos(phi)
    sk, ck = np.sin(kappa), np.cos(kappa)
    printed = [
        [cp * ck, co * sk + so * sp * ck, so * sk - co * sp * ck],
        [-cp * sk, co * ck - so * sp * sk, so * ck + co * sp * sk],
        [sp, -so * cp, co * cp],
    ]
    np.testing.assert_allclose(
        rotation_from_angles(omega, phi, kappa), printed, atol=1e-15
    )


def test_small_angles_turn_the_camera_right_handed():
    small = np.array([2e-6, -3e-6, 5e-6])
    turned = rotation_from_angles(*small).T
    np.testing.assert_allclose(turned, rotation_by_vector(small), atol=1e-10)


def test_angles_come_back(angles):
    found = angles_from_rotation(rotation_from_angles(*angles.T))
    np.testing.assert_allclose(found, angles, atol=1e-14)


@pytest.mark.parametrize("phi", [0.5 * np.pi, -0.5 * np.pi])
def test_at_a_right_angle_omega_is_zero_and_the_matrix_comes_back(phi):
    matrix = rotation_from_angles(0.4, phi, 0.7)
    found = angles_from_rotation(matrix)
    assert found[0] == 0.0
    np.testing.assert_allclose(rotation_from_angles(*found), matrix, atol=1e-15)


def test_angles_near_a_right_angle_give_the_matrix_back():
    phi = 0.5 * np.pi - 10.0 ** -np.arange(1.0, 16.0)
    matrix = rotation_from_angles(0.4, phi, 0.7)
    found = angles_from_rotation(matrix)
    # in the gimbal's width (1e-10) the angle itself is left out
    np.testing.assert_allclose(rotation_from_angles(*found.T), matrix, atol=3e-10)


def test_rates_equal_differences(angles):
    step = 1e-6
    found = angle_rates(angles[:, 0], angles[:, 1])
    matrix = rotation_from_angles(*angles.T)
    for axis in range(3):
        turn = rotation_by_vector(step * np.eye(3)[axis])
        # M.T becomes turn @ M.T
        change = angles_from_rotation(matrix @ turn.T) - angles_from_rotation(
            matrix @ turn
        )
        differences = (change + np.pi) % (2.0 * np.pi) - np.pi
        scale = 1.0 / np.cos(angles[:, 1:2])
        np.testing.assert_allclose(
            found[:, :, axis] / scale, differences / (2.0 * step) / scale, atol=1e-8
        )


def test_rotation_by_vector_keeps_its_axis_and_turns_by_its_length():
    rng = np.random.default_rng(2)
    vector = rng.normal(size=(50, 3))
    matrix = rotation_by_vector(vector)
    np.testing.assert_allclose(
        np.einsum("nij,nj->ni", matrix, vector), vector, atol=1e-14
    )
    lengths = np.linalg.norm(vector, axis=1)
    folded = np.abs((lengths + np.pi) % (2.0 * np.pi) - np.pi)
    turned = Rotation.from_matrix(matrix).magnitude()
    np.testing.assert_allclose(turned, folded, atol=1e-14)


def test_no_rotation_by_no_vector():
    np.testing.assert_array_equal(rotation_by_vector(np.zeros(3)), np.eye(3))


def test_cross_matrix_forms_the_product():
    rng = np.random.default_rng(5)
    a, b = rng.normal(size=(2, 20, 3))
    found = np.einsum("nij,nj->ni", cross_matrix(a), b)
    np.testing.assert_allclose(found, np.cross(a, b), atol=1e-15)


def test_one_equals_many(angles):
    many = rotation_from_angles(*angles.T)
    for place in (0, 57, 199):
        one = rotation_from_angles(*angles[place])
        np.testing.assert_array_equal(one, many[place])
        np.testing.assert_array_equal(
            angles_from_rotation(one), angles_from_rotation(many)[place]
        )
