"""Pairs without a base: against turns and bases that are known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from einschalt.foundations.rotations import rotation_from_angles
from einschalt.theory.relative_orientation.missing_base import have_no_base

C = 153.0


def seen(xyz):
    return -C * xyz[:, :2] / xyz[:, 2:]


def pair(base, angles=(0.0, 0.0, 0.0), n_points=12, seed=0, noise=5e-3):
    """Image coordinates of points over a field of 20 cm; base in mm at image scale."""
    rng = np.random.default_rng(seed)
    xyz = rng.uniform([-100, -100, -165], [100, 100, -140], (n_points, 3))
    right = (xyz - base) @ rotation_from_angles(*angles).T
    image = np.hstack([seen(xyz), seen(right)])
    return image + rng.normal(scale=noise, size=image.shape)


def judge(*images):
    start = np.cumsum([0, *map(len, images)])
    return have_no_base(np.vstack(images), start, np.full((len(images), 2), C)).tolist()


@pytest.mark.parametrize("angles", [(0, 0, 0), (0.1, -0.1, 3.0), (0.0, 0.2, -1.5)])
def test_only_pairs_without_a_base_have_none(angles):
    empty = np.empty((0, 4))
    images = pair([0, 0, 0], angles), pair([92, 0, 0], angles), empty
    assert judge(*images, pair([0, 1e-3, 0], angles)) == [True, False, False, True]
    # a base of 6 % of the depth is one, in any direction
    assert judge(pair([10, 0, 0], angles), pair([0, 0, 10], angles)) == [False, False]


def test_misfit_is_that_of_another_solver():
    # on both sides of the limit, 1e-3 rad root mean square
    for base in ([0.6, 0, 0], [1.2, 0.0, 0.0], [2.4, 0, 0], [4.8, 0, 0]):
        image = pair(base, (0.05, -0.1, 0.4), n_points=40, noise=0.0)
        left, right = (
            np.column_stack([image[:, k : k + 2], np.full(40, -C)]) for k in (0, 2)
        )
        left, right = (
            rays / np.linalg.norm(rays, axis=1)[:, None] for rays in (left, right)
        )
        _, misfit = Rotation.align_vectors(right, left)
        assert judge(image) == [bool(misfit / np.sqrt(40) < 1e-3)]


def test_points_in_one_place_and_mirrored_images_are_something_else():
    place = np.tile([[10.0, 5.0, -80.0, 5.0]], (8, 1))
    image = pair([0, 0, 0])
    mirrored = image * [1.0, 1.0, -1.0, 1.0]
    far = image.copy()
    far[3, 0] = 1e200
    assert judge(place, mirrored, far, image) == [False, False, False, True]
