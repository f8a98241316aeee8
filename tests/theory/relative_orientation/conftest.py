"""Simulated stereo pairs of any base direction, kappa, tilt and convergence."""

from dataclasses import dataclass

import numpy as np
import pytest

from einschalt.foundations.rotations import rotation_by_vector

PRINCIPAL_DISTANCE = 153.0  # mm
FORMAT = 230.0  # mm


@dataclass(frozen=True)
class Geometry:
    """Of the pairs; lengths in mm in the image, heights in flying heights."""

    n_points: tuple = (8, 40)
    tilt_deg: float = 15.0  # of each photograph, in any direction
    convergence_deg: float = 0.0  # between the two axes, along the base
    relief: float = 0.1
    overlap: tuple = (0.5, 0.8)
    principal_distance: float = PRINCIPAL_DISTANCE


@dataclass(frozen=True, eq=False)
class StereoPairs:
    """Observations sorted by pair, and what is true of them."""

    image: np.ndarray
    start: np.ndarray
    base: np.ndarray
    rotation: np.ndarray
    principal_distance: float


def _camera(rng, geometry, along_base, side):
    """Rotation of a photograph from the ground into the image system."""
    azimuth = rng.uniform(0.0, 2.0 * np.pi)
    tilt = np.radians(rng.uniform(0.0, geometry.tilt_deg))
    tip = rotation_by_vector(tilt * np.array([np.cos(azimuth), np.sin(azimuth), 0.0]))
    across = np.array([-along_base[1], along_base[0], 0.0])
    half = 0.5 * np.radians(geometry.convergence_deg)
    swing = rotation_by_vector([0.0, 0.0, rng.uniform(0.0, 2.0 * np.pi)])
    return (rotation_by_vector(side * half * across) @ tip @ swing).T


def _seen(ground, centre, camera, geometry):
    ray = (ground - centre) @ camera.T
    with np.errstate(divide="ignore", invalid="ignore"):
        image = -geometry.principal_distance * ray[:, :2] / ray[:, 2:]
    is_in = (np.abs(image) < 0.5 * FORMAT).all(axis=1) & (ray[:, 2] < -0.1)
    return image, is_in


def _one_pair(rng, geometry):
    azimuth = rng.uniform(0.0, 2.0 * np.pi)
    along = np.array([np.cos(azimuth), np.sin(azimuth), rng.uniform(-0.05, 0.05)])
    photo_base = (1.0 - rng.uniform(*geometry.overlap)) * FORMAT
    base = photo_base / geometry.principal_distance * along
    cameras = [_camera(rng, geometry, along, side) for side in (-1.0, 1.0)]
    plan = rng.uniform(-2.5, 2.5, (4000, 2))
    height = -1.0 + geometry.relief * rng.uniform(-1.0, 1.0, 4000)
    ground = np.column_stack([plan, height])
    left, in_left = _seen(ground, np.zeros(3), cameras[0], geometry)
    right, in_right = _seen(ground, base, cameras[1], geometry)
    n_points = rng.integers(geometry.n_points[0], geometry.n_points[1] + 1)
    rows = np.flatnonzero(in_left & in_right)[:n_points]
    if len(rows) < n_points:
        return None
    direction = cameras[0] @ base / np.linalg.norm(base)
    return np.hstack([left, right])[rows], direction, cameras[1] @ cameras[0].T


@pytest.fixture(scope="session")
def make_pairs():
    """Maker of many simulated pairs with normal errors of the image coordinates."""

    def make(count, seed, geometry=None, *, noise=5e-3):
        rng = np.random.default_rng(seed)
        geometry = geometry or Geometry()
        found = []
        while len(found) < count:
            pair = _one_pair(rng, geometry)
            found += [pair] if pair else []
        images, bases, rotations = zip(*found, strict=True)
        image = np.concatenate(images)
        return StereoPairs(
            image=image + rng.normal(scale=noise, size=image.shape),
            start=np.append(0, np.cumsum([len(one) for one in images])),
            base=np.array(bases),
            rotation=np.array(rotations),
            principal_distance=geometry.principal_distance,
        )

    make.geometry = Geometry
    return make
