"""Covariance of model points against simulation and against a bundle adjustment."""

import numpy as np
import pytest

from einschalt.theory.relative_orientation.condition_tests import StereoPairs
from einschalt.theory.relative_orientation.model_formation import form_model
from einschalt.theory.relative_orientation.model_precision import (
    OrientedPairs,
    model_precision,
)
from einschalt.theory.relative_orientation.orientation_elements import CASES

SIGMA = 5e-3
N_RUNS, N_POINTS = 8000, 10


@pytest.fixture(scope="module")
def one_pair(make_pairs):
    """True image coordinates of a pair, its base about along x."""
    geometry = make_pairs.geometry(n_points=(N_POINTS, N_POINTS), tilt_deg=3.0)
    made = make_pairs(1, 21, geometry, noise=0.0)
    angle = -np.arctan2(made.base[0, 1], made.base[0, 0])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    image = made.image.copy()
    image[:, :2] = image[:, :2] @ turn.T
    return image


def formed(image, case, n_pairs):
    """Model points of repeated measurements, and their cofactors."""
    start = N_POINTS * np.arange(n_pairs + 1)
    stereo = StereoPairs(image, start, np.full((n_pairs, 2), 153.0))
    orientation = stereo.orient()
    pairs = OrientedPairs(orientation, np.full(n_pairs, 92.0), case, stereo.distance)
    xyz = form_model(
        image,
        start,
        stereo.distance,
        pairs.cameras(),
        "adjusted_rays",
        orientation.residuals,
    ).xyz
    return xyz.reshape(n_pairs, N_POINTS, 3), model_precision(pairs, xyz, start), pairs


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("is_along_x", [True, False])
def test_simulated_standard_errors(one_pair, case, is_along_x):
    image = one_pair if is_along_x else one_pair[:, [1, 0, 3, 2]] * [-1, 1, -1, 1]
    rng = np.random.default_rng(7)
    noise = rng.normal(scale=SIGMA, size=(N_RUNS, *image.shape))
    measured = (image + noise).reshape(-1, 4)
    xyz, precision, _ = formed(measured, case, N_RUNS)
    cofactor = precision.cofactor.reshape(N_RUNS, N_POINTS, 3, 3).mean(axis=0)
    claimed = SIGMA * np.sqrt(np.diagonal(cofactor, axis1=1, axis2=2))
    found = xyz.std(axis=0)
    # 0.8 % is the standard error of a standard deviation from 8000 runs
    np.testing.assert_allclose(found, claimed, rtol=0.03)
    centred = xyz - xyz.mean(axis=0)
    covariance = np.einsum("rpi,rpj->pij", centred, centred) / N_RUNS
    scale = claimed[:, :, None] * claimed[:, None, :]
    np.testing.assert_allclose(
        covariance / scale, SIGMA**2 * cofactor / scale, rtol=0.0, atol=0.04
    )


def test_it_is_the_bundle_adjustment(one_pair):
    """Normal equations of all points and the orientation, inverted as a whole."""
    _, precision, pairs = formed(one_pair, "dependent_right", 1)
    xyz = formed(one_pair, "dependent_right", 1)[0][0]
    cameras = pairs.cameras()
    base, rotation = cameras.right_centre[0], cameras.right_rotation[0]
    flat = np.concatenate([base[1:], np.zeros(3), xyz.ravel()])

    def project(unknowns):
        by, bz, *turn = unknowns[:5]
        a, b, c = turn
        small = np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]])
        points = unknowns[5:].reshape(-1, 3)
        left = points
        right = (points - [base[0], by, bz]) @ (rotation @ (np.eye(3) - small)).T
        images = [-153.0 * r[:, :2] / r[:, 2:] for r in (left, right)]
        return np.hstack(images).ravel()

    step = 1e-5
    design = np.column_stack(
        [
            (project(flat + step * e) - project(flat - step * e)) / (2.0 * step)
            for e in np.eye(len(flat))
        ]
    )
    whole = np.linalg.inv(design.T @ design)[5:, 5:]
    gain = precision.gain.reshape(-1, 6)
    mine = gain @ pairs.orientation.cofactor[0] @ gain.T
    for place in range(N_POINTS):
        block = slice(3 * place, 3 * place + 3)
        mine[block, block] += precision.image_part[place]
    # the numeric differences have about six digits, conditioned by some hundreds
    np.testing.assert_allclose(mine, whole, rtol=1e-3, atol=1e-4 * np.abs(whole).max())


def test_height_of_the_intersection_error():
    """In the normal case sigma_z is h/b h/c sigma √2 of the intersection alone."""
    x, y = np.meshgrid([0.0, 46.0, 92.0], [-90.0, -45.0, 0.0, 45.0, 90.0])
    left = np.column_stack([x.ravel(), y.ravel()])
    image = np.hstack([left, left - [92.0, 0.0]])
    start = np.array([0, 15])
    stereo = StereoPairs(image, start, np.full((1, 2), 153.0))
    pairs = OrientedPairs(
        stereo.orient(), np.array([92.0]), "dependent_right", stereo.distance
    )
    xyz = np.column_stack([left, np.full(15, -153.0)])
    found = model_precision(pairs, xyz, start)
    # here h/c = 1: model points have the scale of the image
    wanted = np.sqrt(2.0) * 153.0 / 92.0
    # y of both images adds what its own parallax does not: nothing to z
    np.testing.assert_allclose(np.sqrt(found.image_part[:, 2, 2]), wanted, rtol=1e-6)
    assert (found.orientation_part[:, 2, 2] > 0.0).all()


def test_pairs_that_were_not_oriented_have_no_precision(one_pair):
    image = np.concatenate([one_pair, np.ones_like(one_pair)])
    _, precision, _ = formed(image, "independent", 2)
    assert np.isfinite(precision.cofactor[:N_POINTS]).all()
    assert np.isnan(precision.cofactor[N_POINTS:]).all()
