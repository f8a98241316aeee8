"""The condition, its derivatives, its normal equations and a step."""

import numpy as np
import pytest

from einschalt.foundations.rotations import rotation_by_vector
from einschalt.theory.relative_orientation.coplanarity_condition import (
    COS_45,
    DETERMINANTS,
    FIRST_ORDER,
    GAUSS_HELMERT,
    coplanarity,
    descent_step,
    factorise,
    form_normals,
    frame_of,
    moved,
    parameter_row,
    solve,
)

RIGHT_Z = -1.1  # the right principal distance is 1.1 times the left one
STEP = 1e-6


@pytest.fixture
def rng():
    """Random numbers with a fixed seed."""
    return np.random.default_rng(17)


def random_pose(rng):
    base = rng.normal(size=3)
    rotation = rotation_by_vector(rng.normal(size=3))
    return tuple(base / np.linalg.norm(base)), tuple(rotation.ravel())


def condition(pose, point, *, fixes_x=False):
    base, rotation = np.array(pose[0]), np.array(pose[1]).reshape(3, 3)
    if fixes_x and base[0] >= COS_45:
        base = base / base[0]
    left = np.array([point[0], point[1], -1.0])
    right = rotation @ [point[2], point[3], RIGHT_Z]
    return base @ np.cross(left, right)


def rows_at(pose, image, corrections, mode):
    """Misclosures, rows, and derivatives by the image, point by point."""
    base, tangents, rotation = frame_of(pose, mode.fixes_x)
    misclosures, rows, by_images = [], [], []
    for point, correction in zip((image + corrections).T, corrections.T, strict=True):
        value, by_base, by_turn, by_image = coplanarity(
            tuple(point), RIGHT_Z, base, rotation
        )
        misclosures.append(value - np.dot(by_image, correction))
        rows.append(parameter_row(by_base, by_turn, tangents))
        by_images.append(by_image)
    return np.array(misclosures), np.array(rows), np.array(by_images)


def unpacked(sums):
    normal = np.zeros((5, 5))
    normal[np.tril_indices(5)] = sums[:15]
    normal = np.tril(normal) + np.tril(normal, -1).T
    return normal, np.array(sums[15:20]), sums[20]


@pytest.mark.parametrize("fixes_x", [False, True])
def test_derivatives_equal_differences(rng, fixes_x):
    for _ in range(50):
        pose, point = random_pose(rng), rng.normal(size=4)
        base, tangents, rotation = frame_of(pose, fixes_x)
        value, by_base, by_turn, by_image = coplanarity(
            tuple(point), RIGHT_Z, base, rotation
        )
        assert value == pytest.approx(
            condition(pose, point, fixes_x=fixes_x), abs=1e-13
        )
        row = parameter_row(by_base, by_turn, tangents)
        for place, shift in enumerate(STEP * np.eye(5)):
            above = condition(moved(pose, tuple(shift)), point, fixes_x=fixes_x)
            below = condition(moved(pose, tuple(-shift)), point, fixes_x=fixes_x)
            difference = (above - below) / (2.0 * STEP)
            assert row[place] == pytest.approx(difference, rel=1e-7, abs=1e-8)
        for place, shift in enumerate(STEP * np.eye(4)):
            above = condition(pose, point + shift, fixes_x=fixes_x)
            below = condition(pose, point - shift, fixes_x=fixes_x)
            difference = (above - below) / (2.0 * STEP)
            assert by_image[place] == pytest.approx(difference, rel=1e-7, abs=1e-8)


@pytest.mark.parametrize(
    "base", [(1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (-0.6, 0, -0.8)]
)
def test_tangents_are_orthonormal(base):
    pose = tuple(map(float, base)), tuple(np.eye(3).ravel())
    found, tangents, _ = frame_of(pose, False)
    frame = np.vstack([found, np.reshape(tangents, (2, 3))])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)


def test_a_long_way_of_steps_stays_on_sphere_and_rotations(rng):
    pose = random_pose(rng)
    for _ in range(200):
        pose = moved(pose, tuple(rng.normal(scale=0.5, size=5)))
    rotation = np.array(pose[1]).reshape(3, 3)
    assert np.linalg.norm(pose[0]) == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-13)
    assert np.linalg.det(rotation) == pytest.approx(1.0, abs=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("mode", [GAUSS_HELMERT, FIRST_ORDER, DETERMINANTS])
@pytest.mark.parametrize("n_points", [1, 7, 8, 33])
def test_sums_equal_matrices(rng, mode, n_points):
    pose, image = random_pose(rng), rng.normal(size=(4, n_points))
    corrections = mode.keep * rng.normal(scale=1e-3, size=image.shape)
    misclosures, rows, by_image = rows_at(pose, image, corrections, mode)
    variance = (by_image**2).sum(axis=1)
    weights = 1.0 / variance if mode.is_weighted else np.ones(n_points)
    frame = frame_of(pose, mode.fixes_x)
    closing = corrections.copy()
    normal, gradient, squares = unpacked(
        form_normals(image, closing, RIGHT_Z, frame, mode)
    )
    scale = np.abs(rows.T * weights) @ np.abs(rows)
    assert np.all(np.abs(normal - (rows.T * weights) @ rows) < 1e-13 * scale + 1e-15)
    np.testing.assert_allclose(gradient, rows.T @ (weights * misclosures), atol=1e-11)
    assert squares == pytest.approx(np.sum(weights * misclosures**2), rel=1e-12)
    wanted = -mode.keep * (by_image.T / variance) * misclosures
    np.testing.assert_allclose(closing, wanted, atol=1e-13)


def test_corrections_close_the_condition(rng):
    pose, image = random_pose(rng), rng.normal(size=(4, 12))
    frame = frame_of(pose, False)
    corrections = np.zeros_like(image)
    # small misclosures: the points are brought near to their epipolar planes first
    for _ in range(30):
        form_normals(image, corrections, RIGHT_Z, frame, GAUSS_HELMERT)
    near = image + corrections + rng.normal(scale=1e-4, size=image.shape)
    corrections[:] = 0.0
    for _ in range(3):
        form_normals(near, corrections, RIGHT_Z, frame, GAUSS_HELMERT)
    left = [condition(pose, point) for point in (near + corrections).T]
    # of a determinant of rays that are longer than the principal distance
    rounding = 8.0 * np.finfo(float).eps * (1.0 + np.abs(near).max() ** 2)
    np.testing.assert_allclose(left, 0.0, atol=rounding)


@pytest.mark.slow
@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_steps_solve_the_normal_equations(rng, damping):
    rows = rng.normal(size=(9, 5))
    normal, gradient = rows.T @ rows, rng.normal(size=5)
    sums = (*normal[np.tril_indices(5)], *gradient, 1.0)
    damped = normal + damping * np.diag(np.diag(normal))
    step, gain = descent_step(sums, damping)
    np.testing.assert_allclose(step, -np.linalg.solve(damped, gradient), rtol=1e-11)
    assert gain == pytest.approx(-gradient @ step, rel=1e-12)
    column = solve(factorise(sums, damping), (0.0, 1.0, 0.0, 0.0, 0.0))
    np.testing.assert_allclose(column, np.linalg.inv(damped)[:, 1], rtol=1e-10)


def test_a_singular_matrix_gives_no_number(rng):
    rows = rng.normal(size=(3, 5))
    normal = rows.T @ rows
    normal[4, 4] -= 1e-6
    sums = (*normal[np.tril_indices(5)], *np.ones(5), 1.0)
    assert np.isnan(descent_step(sums, 0.0)[1])
