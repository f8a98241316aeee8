"""Descents, and the choice between the minima they lead to."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from einschalt.foundations.rotations import rotation_by_vector
from einschalt.theory.relative_orientation.coplanarity_condition import (
    FIRST_ORDER,
    GAUSS_HELMERT,
    SQUARES,
    descent_step,
)
from einschalt.theory.relative_orientation.coplanarity_solution import (
    FINE,
    MOST_FINE_STEPS,
    MOST_ROUGH_STEPS,
    ROUGH,
    choose,
    cost,
    descend,
    misfit,
)
from einschalt.theory.relative_orientation.starting_orientations import facing

RIGHT_Z = -1.0
NOISE = 3e-5


def simulate(seed, n_points=15, relief=0.1, noise=NOISE, side=(-0.1, 0.7)):
    """Image coordinates, shape (4, n), of a nearly vertical pair, and its truth."""
    rng = np.random.default_rng(seed)
    plan = rng.uniform([side[0], -0.6], [side[1], 0.6], (n_points, 2))
    height = -1.0 + relief * rng.uniform(-1.0, 1.0, n_points)
    ground = np.column_stack([plan, height])
    base = np.array([0.6, 0.02, -0.03])
    rotation = rotation_by_vector(0.05 * rng.normal(size=3))
    right = (ground - base) @ rotation.T
    image = np.hstack(
        [-ground[:, :2] / ground[:, 2:], -right[:, :2] / right[:, 2:]]
    ) + rng.normal(scale=noise, size=(n_points, 4))
    return np.ascontiguousarray(image.T), base / np.linalg.norm(base), rotation


def pose_of(base, rotation):
    return tuple(map(float, base)), tuple(rotation.T.ravel())


def turned(pose, rotation):
    return Rotation.from_matrix(np.reshape(pose[1], (3, 3)) @ rotation).magnitude()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_rough_descents_find_back_from_far_away(seed):
    image, base, rotation = simulate(seed)
    rng = np.random.default_rng(seed)
    far = rng.normal(size=3)
    far *= 0.2 / np.linalg.norm(far)
    start = pose_of(base, rotation @ rotation_by_vector(far))
    limits = (MOST_ROUGH_STEPS, ROUGH)
    pose, sums, is_converged = descend(
        image, np.zeros_like(image), RIGHT_Z, start, FIRST_ORDER, limits
    )
    assert is_converged
    assert turned(pose, rotation) < 20 * NOISE
    assert sums[SQUARES] < 4 * 15 * NOISE**2


@pytest.mark.parametrize("n_points", [6, 8, 40])
def test_fine_descents_end_where_no_step_is_left(n_points):
    image, base, rotation = simulate(3, n_points)
    limits = (MOST_FINE_STEPS, FINE)
    corrections = np.zeros_like(image)
    pose, sums, is_converged = descend(
        image, corrections, RIGHT_Z, pose_of(base, rotation), GAUSS_HELMERT, limits
    )
    assert is_converged
    _, gain = descent_step(sums, 0.0)
    assert gain < 1e-12 * sums[SQUARES]
    again, _, _ = descend(image, corrections, RIGHT_Z, pose, GAUSS_HELMERT, limits)
    np.testing.assert_allclose(again[1], pose[1], atol=1e-12)


def test_too_few_steps_are_not_called_converged():
    image, base, rotation = simulate(3)
    start = pose_of(base, rotation @ rotation_by_vector([0.1, 0.1, 0.1]))
    limits = (2, FINE)
    assert not descend(
        image, np.zeros_like(image), RIGHT_Z, start, GAUSS_HELMERT, limits
    )[2]


def test_numbers_that_are_none_are_not_called_converged():
    image, base, rotation = simulate(3)
    image[0, 0] = np.nan
    limits = (MOST_FINE_STEPS, FINE)
    start = pose_of(base, rotation)
    assert not descend(
        image, np.zeros_like(image), RIGHT_Z, start, GAUSS_HELMERT, limits
    )[2]


def test_points_in_front_weigh_more_than_any_fit():
    _, base, rotation = simulate(3)
    pose = pose_of(base, rotation)
    assert cost(pose, 1.0, 15, 15) < cost(pose, 1e-12, 15, 14)


def test_of_equal_fits_the_nearer_to_the_normal_case_is_taken():
    upright = pose_of([1.0, 0.0, 0.0], np.eye(3))
    tilted = pose_of([0.8, 0.0, 0.6], rotation_by_vector([0.0, 0.5, 0.0]))
    assert cost(upright, 1e-9, 12, 12) < cost(tilted, 1e-9, 12, 12)
    # but not where the fit is clearly worse
    assert cost(upright, 1e-6, 12, 12) > cost(tilted, 1e-9, 12, 12)


def test_misfit_does_not_tell_sizes_below_a_hundred_thousandth_apart():
    assert misfit(1e-14, 12) == pytest.approx(misfit(1e-20, 12), abs=1e-3)
    assert misfit(1e-7, 12) > misfit(1e-8, 12) + 7.0
    # five points: only errors that nobody would believe count
    assert misfit(1e-12, 5) == pytest.approx(0.0, abs=1e-3)
    assert misfit(1e-5, 5) > 100.0


@pytest.mark.slow
@pytest.mark.parametrize("relief", [0.0, 0.1])
def test_the_second_solution_of_a_plane_is_told(relief):
    # all points on one side of the middle, so that both solutions see them in front
    image, _, rotation = simulate(
        2, n_points=12, relief=relief, noise=0.0, side=(-0.2, 0.2)
    )
    pose, is_ambiguous = choose(image, RIGHT_Z)
    assert turned(pose, rotation) < 1e-6
    assert is_ambiguous == (relief == 0.0)


@pytest.mark.parametrize("angle", np.radians([0.0, 90.0, 180.0, 250.0]))
def test_the_cheap_start_and_the_search_agree(angle):
    for n_points in (7, 8):  # seven points are searched for, eight are not
        image, base, rotation = simulate(11, n_points)
        swing = rotation_by_vector([0.0, 0.0, angle])
        image[2:] = swing[:2, :2] @ image[2:]
        pose, _ = choose(image, RIGHT_Z)
        assert turned(pose, swing @ rotation) < 30 * NOISE
        assert np.dot(pose[0], base) > 0.999
        assert facing(image, RIGHT_Z, pose)[1] == n_points
