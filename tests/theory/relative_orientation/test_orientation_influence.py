"""Derivatives of orientations by single image coordinates against differences."""

import numpy as np
import pytest

from einschalt.theory.relative_orientation.condition_tests import StereoPairs
from einschalt.theory.relative_orientation.orientation_influence import (
    orientation_influence,
)
from einschalt.theory.relative_orientation.robust_orientation import orient_robustly

N_POINTS, STEP = 10, 1e-4
DISTANCE = np.array([[153.0, 140.0]])


@pytest.fixture(scope="module")
def exact(make_pairs):
    geometry = make_pairs.geometry(n_points=(N_POINTS, N_POINTS), tilt_deg=3.0)
    image = make_pairs(1, 21, geometry, noise=0.0).image
    # a right camera of its own principal distance sees the same rays
    return image * [1.0, 1.0, *(2 * [DISTANCE[0, 1] / DISTANCE[0, 0]])]


def stereo(image):
    return StereoPairs(image, np.array([0, len(image)]), DISTANCE)


def turn_between(after, before):
    """Small turn about the axes of the left system that leads to ``after``."""
    # right image axes as columns in the left system
    found = after.rotation[0].T @ before.rotation[0]
    return np.array([found[2, 1], found[0, 2], found[1, 0]])


def test_differences_of_single_coordinates(exact):
    before = stereo(exact).orient()
    adjusted = stereo(exact + before.residuals)
    found = orientation_influence(before, adjusted, np.ones(N_POINTS))
    size = np.abs(found).max()
    for point in range(N_POINTS):
        for axis in range(4):
            moved = exact.copy()
            moved[point, axis] += STEP
            after = stereo(moved).orient()
            change = np.concatenate(
                [(after.base - before.base)[0], turn_between(after, before)]
            )
            # second order in the step over the principal distance
            np.testing.assert_allclose(
                found[point, :, axis], change / STEP, rtol=0.0, atol=1e-4 * size
            )


def test_cofactors_are_the_sum_of_all_influences(exact):
    noisy = exact + np.random.default_rng(3).normal(scale=5e-3, size=exact.shape)
    orientation = stereo(noisy).orient()
    adjusted = stereo(noisy + orientation.residuals)
    found = orientation_influence(orientation, adjusted, np.ones(N_POINTS))
    np.testing.assert_allclose(
        np.einsum("nia,nja->ij", found, found),
        orientation.cofactor[0],
        rtol=0.0,
        atol=1e-9 * np.abs(orientation.cofactor).max(),
    )


def test_points_of_less_weight_move_less(exact):
    noisy = exact + np.random.default_rng(3).normal(scale=5e-3, size=exact.shape)
    noisy[4, 1] += 0.2
    robust = orient_robustly(stereo(noisy), "tukey")
    assert robust.factors[4] == 0.0
    adjusted = stereo(noisy + robust.orientation.residuals)
    found = orientation_influence(robust.orientation, adjusted, robust.factors)
    np.testing.assert_array_equal(found[4], 0.0)
    others = np.delete(np.arange(N_POINTS), 4)
    factors = robust.factors[others]
    rest = orientation_influence(
        robust.orientation, stereo(adjusted.image[others]), factors
    )
    np.testing.assert_allclose(found[others], rest, rtol=1e-9)


def test_no_points_where_nothing_was_oriented(exact):
    pairs = StereoPairs(
        np.concatenate([exact, np.ones((4, 4))]),
        np.array([0, N_POINTS, N_POINTS + 4]),
        np.repeat(DISTANCE, 2, axis=0),
    )
    orientation = pairs.orient()
    used = pairs.chosen(pairs.model == 0)
    found = orientation_influence(orientation, used, np.ones(N_POINTS))
    assert np.isfinite(found).all()
