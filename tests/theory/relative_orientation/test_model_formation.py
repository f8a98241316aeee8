"""Model points by the four rules."""

import numpy as np
import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.rotations import rotation_from_angles
from einschalt.theory.relative_orientation.coplanarity import orient_pairs
from einschalt.theory.relative_orientation.model_formation import RULES, form_model
from einschalt.theory.relative_orientation.orientation_elements import (
    StereoCameras,
    orientation_elements,
)

C = np.array([153.0, 210.0])


def one_pair_of_cameras(base, left=(0.0, 0.0, 0.0)):
    left_rotation = rotation_from_angles(0.03, -0.02, 0.4)
    right_rotation = rotation_from_angles(-0.05, 0.06, 2.0)
    left = np.array([left])
    return StereoCameras(left, left + base, left_rotation[None], right_rotation[None])


def seen(ground, centre, rotation, distance):
    ray = (ground - centre) @ rotation.T
    return -distance * ray[:, :2] / ray[:, 2:]


def images(ground, cameras):
    return np.hstack(
        [
            seen(ground, cameras.left_centre[0], cameras.left_rotation[0], C[0]),
            seen(ground, cameras.right_centre[0], cameras.right_rotation[0], C[1]),
        ]
    )


@pytest.fixture
def ground():
    """Points below both cameras, wherever the base goes."""
    rng = np.random.default_rng(20)
    return rng.uniform([-60, -60, -170], [60, 60, -130], (15, 3))


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("base", [(92, 5, 2), (-92, 5, 2), (5, 92, -3), (-9, -80, 3)])
def test_rays_without_errors_give_the_point(ground, rule, base):
    cameras = one_pair_of_cameras(np.array(base, dtype=float), left=(3.0, -4.0, 5.0))
    image = images(ground, cameras)
    model = form_model(image, [0, 15], C, cameras, rule, np.zeros_like(image))
    np.testing.assert_allclose(model.xyz, ground, atol=1e-10)
    np.testing.assert_allclose(model.y_parallax, 0.0, atol=1e-10)


def rays(image, cameras):
    down = np.ones((len(image), 1))
    left = np.hstack([image[:, :2], -C[0] * down]) @ cameras.left_rotation[0]
    right = np.hstack([image[:, 2:], -C[1] * down]) @ cameras.right_rotation[0]
    return left, right


@pytest.mark.parametrize("base", [(92.0, 5.0, 2.0), (5.0, 92.0, -3.0)])
def test_rules_with_errors(ground, base):
    cameras = one_pair_of_cameras(np.array(base))
    rng = np.random.default_rng(3)
    image = images(ground, cameras) + rng.normal(scale=0.05, size=(15, 4))
    left, right = rays(image, cameras)
    across, along = (1, 0) if base[0] > base[1] else (0, 1)
    by_rule = {
        rule: form_model(image, [0, 15], C, cameras, rule)
        for rule in ("midpoint", "mean_y", "left_ray")
    }
    for k in range(15):
        # the axis along the base and z from both rays, one by one
        level = np.array([left[k, [along, 2]], -right[k, [along, 2]]]).T
        on_left, on_right = np.linalg.solve(level, np.array(base)[[along, 2]])
        from_left = on_left * left[k]
        from_right = base + on_right * right[k]
        np.testing.assert_allclose(by_rule["left_ray"].xyz[k], from_left, atol=1e-10)
        mean = from_left.copy()
        mean[across] = 0.5 * (from_left[across] + from_right[across])
        np.testing.assert_allclose(by_rule["mean_y"].xyz[k], mean, atol=1e-10)
        parallax = from_right[across] - from_left[across]
        assert by_rule["mean_y"].y_parallax[k] == pytest.approx(parallax, abs=1e-10)
        # the middle of the shortest distance
        both = np.column_stack([left[k], -right[k]])
        places = np.linalg.lstsq(both, np.array(base))[0]
        middle = 0.5 * (places[0] * left[k] + base + places[1] * right[k])
        np.testing.assert_allclose(by_rule["midpoint"].xyz[k], middle, atol=1e-10)


def test_adjusted_rays_meet(make_pairs):
    pairs = make_pairs(30, 2)
    found = orient_pairs(pairs.image, pairs.start, 153.0)
    cameras = orientation_elements(found).cameras
    whole = (pairs.image, pairs.start, 153.0, cameras)
    adjusted = form_model(*whole, "adjusted_rays", found.residuals)
    for rule in ("left_ray", "mean_y"):
        same = form_model(
            pairs.image + found.residuals, pairs.start, 153.0, cameras, rule
        )
        np.testing.assert_allclose(same.xyz, adjusted.xyz, rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose(same.y_parallax, 0.0, atol=1e-10)
    # the y-parallax is always that of the measured coordinates
    assert np.abs(adjusted.y_parallax).max() > 1e-6


def test_pairs_keep_to_themselves(ground):
    cameras = one_pair_of_cameras(np.array([92.0, 5.0, 2.0]))
    image = images(ground, cameras)
    twice = StereoCameras(
        *(
            np.concatenate([a, 2.0 * a])
            for a in (cameras.left_centre, cameras.right_centre)
        ),
        *(
            np.concatenate([a, a])
            for a in (cameras.left_rotation, cameras.right_rotation)
        ),
    )
    model = form_model(np.vstack([image, image]), [0, 15, 30], C, twice, "midpoint")
    np.testing.assert_allclose(model.xyz[15:], 2.0 * model.xyz[:15], rtol=1e-13)


def test_unknown_rule(ground):
    cameras = one_pair_of_cameras(np.array([92.0, 0.0, 0.0]))
    with pytest.raises(SettingsError, match="rule = 'mean' is unknown; expected"):
        form_model(images(ground, cameras), [0, 15], C, cameras, "mean")


def test_adjusted_rays_need_corrections(ground):
    cameras = one_pair_of_cameras(np.array([92.0, 0.0, 0.0]))
    with pytest.raises(SettingsError, match="without corrections; expected the resid"):
        form_model(images(ground, cameras), [0, 15], C, cameras, "adjusted_rays")
