"""Starts from image coordinates alone."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from einschalt.foundations.rotations import (
    rotation_by_vector,
    rotation_from_angles,
)
from einschalt.theory.relative_orientation.coplanarity_condition import (
    FIRST_ORDER,
    SQUARES,
    form_normals,
    frame_of,
)
from einschalt.theory.relative_orientation.starting_orientations import (
    LATTICE,
    LATTICE_STEP,
    facing,
    next_start,
    normal_case_start,
    planar_twin,
    smallest_eigenvector,
    survey_lattice,
    with_best_base,
)

RIGHT_Z = -1.0


def angle_of(matrix):
    return Rotation.from_matrix(matrix).magnitude()


def seen_from(ground, base, rotation):
    """Image coordinates, shape (4, n), for a principal distance of 1."""
    right = (ground - base) @ rotation.T
    left, right = -ground[:, :2] / ground[:, 2:], -right[:, :2] / right[:, 2:]
    return np.ascontiguousarray(np.hstack([left, right]).T)


def ground_points(seed, n_points=12, relief=0.0):
    rng = np.random.default_rng(seed)
    plan = rng.uniform(-0.7, 0.7, (n_points, 2))
    height = -1.0 + relief * rng.uniform(-1.0, 1.0, n_points)
    return np.column_stack([plan, height])


def pose_of(base, rotation):
    return tuple(np.asarray(base, dtype=float)), tuple(rotation.T.ravel())


def squares_at(image, pose):
    frame = frame_of(pose, False)
    idle = np.zeros_like(image)
    return form_normals(image, idle, RIGHT_Z, frame, FIRST_ORDER)[SQUARES]


@pytest.mark.parametrize("azimuth", np.radians(np.arange(0.0, 360.0, 30.0)))
@pytest.mark.parametrize("kappa", np.radians([0.0, 80.0, 180.0, -100.0]))
def test_normal_case_is_found_exactly_over_level_ground(azimuth, kappa):
    direction = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    rotation = rotation_from_angles(0.0, 0.0, kappa)
    image = seen_from(ground_points(1), 0.6 * direction, rotation)
    base, turned = normal_case_start(image, RIGHT_Z)
    np.testing.assert_allclose(base, direction, atol=1e-14)
    np.testing.assert_allclose(np.reshape(turned, (3, 3)), rotation.T, atol=1e-14)


def test_points_in_one_place_still_give_a_start():
    image = np.tile([[0.1], [0.2], [-0.3], [0.2]], 6)
    base, rotation = normal_case_start(image, RIGHT_Z)
    assert np.isfinite([*base, *rotation]).all()


def test_of_base_and_opposite_the_one_with_points_in_front_is_taken():
    ground = ground_points(2, relief=0.2)
    base, rotation = np.array([0.6, 0.0, 0.8]), rotation_by_vector([0.1, -0.2, 2.0])
    image = seen_from(ground, 0.5 * base, rotation)
    for sign in (1.0, -1.0):
        pose, n_front = facing(image, RIGHT_Z, pose_of(sign * base, rotation))
        np.testing.assert_array_equal(pose[0], base)
        assert n_front == len(ground)


@pytest.mark.parametrize("seed", range(20))
def test_twin_of_a_plane_fits_exactly(seed):
    rng = np.random.default_rng(seed)
    ground = ground_points(seed) @ rotation_by_vector(0.3 * rng.normal(size=3)).T
    base = 0.5 * rng.normal(size=3)
    rotation = rotation_by_vector(0.2 * rng.normal(size=3))
    image = seen_from(ground, base, rotation)
    pose = pose_of(base / np.linalg.norm(base), rotation)
    _, twin = planar_twin(image, RIGHT_Z, pose)
    # the plane is fitted with 1e-9 of the identity
    assert squares_at(image, twin) < 1e-15
    assert angle_of(np.reshape(twin[1], (3, 3)) @ rotation) > 0.01
    # the twin of the twin is the pair itself, up to the sign of the base
    _, back = planar_twin(image, RIGHT_Z, twin)
    np.testing.assert_allclose(back[1], pose[1], atol=1e-6)
    assert abs(np.dot(back[0], pose[0])) == pytest.approx(1.0, abs=1e-8)


def test_points_on_both_sides_of_the_middle_exclude_the_twin():
    rotation = np.eye(3)
    base = np.array([0.6, 0.0, 0.0])
    grid = np.array([[x, y, -1.0] for x in (0.05, 0.55) for y in (-0.5, 0.0, 0.5)])
    pose = pose_of([1.0, 0.0, 0.0], rotation)
    assert not planar_twin(seen_from(grid, base, rotation), RIGHT_Z, pose)[0]
    one_side = grid[grid[:, 0] < 0.3]
    assert planar_twin(seen_from(one_side, base, rotation), RIGHT_Z, pose)[0]


def test_smallest_eigenvector_equals_numpy():
    rng = np.random.default_rng(3)
    for _ in range(200):
        rows = rng.normal(size=(4, 3)) * rng.uniform(0.01, 1.0, 3)
        matrix = rows.T @ rows
        a, b, c, d, e, f = matrix[np.tril_indices(3)]
        found = np.array(smallest_eigenvector(a, b, c, d, e, f))
        wanted = np.linalg.eigh(matrix)[1][:, 0]
        assert abs(found @ wanted) == pytest.approx(1.0, abs=1e-6)


def test_multiples_of_the_identity_have_an_eigenvector():
    found = smallest_eigenvector(2.0, 0.0, 2.0, 0.0, 0.0, 2.0)
    assert np.linalg.norm(found) == 1.0


def test_best_base_lessens_the_sum_of_squares():
    rotation = rotation_by_vector([0.05, -0.1, 1.5])
    image = seen_from(ground_points(4, relief=0.2), [0.2, 0.5, 0.05], rotation)
    start = pose_of([0.6, 0.8, 0.0], rotation)
    base, _ = with_best_base(image, RIGHT_Z, start)
    wanted = np.array([0.2, 0.5, 0.05]) / np.linalg.norm([0.2, 0.5, 0.05])
    assert abs(np.dot(base, wanted)) == pytest.approx(1.0, abs=1e-12)


def test_lattice_leaves_no_gap():
    rng = np.random.default_rng(8)
    lattice = LATTICE.reshape(-1, 3, 3)
    for _ in range(100):
        tilt = np.radians(rng.uniform(0.0, 60.0))
        azimuth, kappa = rng.uniform(0.0, 2.0 * np.pi, 2)
        tip = rotation_by_vector(tilt * np.array([np.cos(azimuth), np.sin(azimuth), 0]))
        rotation = tip @ rotation_by_vector([0.0, 0.0, kappa])
        nearest = angle_of(lattice @ rotation.T).min()
        assert nearest < 0.8 * LATTICE_STEP


def test_search_begins_near_the_truth():
    rotation = rotation_by_vector([0.35, 0.3, 0.0]) @ rotation_by_vector([0, 0, 2.0])
    image = seen_from(ground_points(6, 20, relief=0.2), [0.5, 0.1, 0.2], rotation)
    squares, bases = survey_lattice(image, RIGHT_Z)
    distances = []
    for _ in range(5):
        _, turned = next_start(squares, bases)
        distances.append(angle_of(np.reshape(turned, (3, 3)) @ rotation))
    assert min(distances) < LATTICE_STEP
    assert np.isinf(squares).sum() >= 5
