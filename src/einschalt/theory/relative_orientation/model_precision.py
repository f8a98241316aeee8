"""Precision of model coordinates: what comes from the rays, what from the orientation.

A model point is the intersection of its two rays. With the derivatives A of its four
image coordinates by its place and B of them by the orientation, least squares gives

    Q_xx = (A.T A)^-1 + G C G.T,     G = -(A.T A)^-1 A.T B,

C being the cofactor matrix of the orientation. The first part is the point's own, the
second makes the points of a model err together. Both are those of the bundle adjustment
of the pair with free model points, in the coordinate system that the case of the
orientation fixes; the parts are not correlated. For the estimator "determinants" and
coordinates with the mean of both y they are approximations.

Source: partitioned normal equations, any text-book on bundle adjustment.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numba
import numpy as np

from einschalt.foundations.batches import over_segments
from einschalt.foundations.rotations import rotation_by_vector
from einschalt.theory.relative_orientation.coplanarity_condition import COMPILED
from einschalt.theory.relative_orientation.orientation_elements import (
    StereoCameras,
    orientation_elements,
)

# of central differences: the error is its square, and rounding over it
STEP = 1e-5
N_CHANGES = 6


class ModelPrecision(NamedTuple):
    """Cofactors of model points, for image coordinates with the variance 1 mm².

    Attributes
    ----------
    image_part : ndarray, shape (n_points, 3, 3)
        Of the intersection alone [unit of the base² / mm²].
    gain : ndarray, shape (n_points, 3, 6)
        Derivatives G of the point by base direction and turn of the right camera.
    orientation_part : ndarray, shape (n_points, 3, 3)
        G C G.T.
    by_image : ndarray, shape (n_points, 3, 4)
        Derivatives (A.T A)^-1 A.T of the point by its own image coordinates, the
        orientation held [unit of the base / mm].
    """

    image_part: np.ndarray
    gain: np.ndarray
    orientation_part: np.ndarray
    by_image: np.ndarray

    @property
    def cofactor(self):
        """Both parts together, shape (n_points, 3, 3)."""
        return self.image_part + self.orientation_part


@dataclass(frozen=True, eq=False)
class OrientedPairs:
    """What the precision of model points needs to know of their pairs.

    Attributes
    ----------
    orientation : PairOrientation
    base_length : ndarray, shape (n_pairs,)
    case : str
    distance : ndarray, shape (n_pairs, 2)
        Principal distances [mm].
    """

    orientation: object
    base_length: np.ndarray
    case: str
    distance: np.ndarray

    def cameras(self):
        """Centres and rotations in the model system; StereoCameras."""
        return orientation_elements(
            self.orientation, self.base_length, self.case
        ).cameras

    def camera_changes(self):
        """Derivatives of the cameras by base direction (3) and turn (3).

        Returns
        -------
        centres : ndarray, shape (n_pairs, 6, 2, 3)
        rotations : ndarray, shape (n_pairs, 6, 2, 3, 3)
            Of left and right camera.

        Notes
        -----
        By central differences of the elements, which are those of every case, whichever
        length is fixed.
        """
        centres, rotations = [], []
        for change in np.eye(N_CHANGES):
            (c_more, r_more), (c_less, r_less) = (
                _stacked(self._moved(sign * STEP * change)) for sign in (1.0, -1.0)
            )
            centres.append((c_more - c_less) / (2.0 * STEP))
            rotations.append((r_more - r_less) / (2.0 * STEP))
        return np.stack(centres, axis=1), np.stack(rotations, axis=1)

    def _moved(self, change) -> StereoCameras:
        base, rotation = self.orientation.base, self.orientation.rotation
        # along itself a direction does not change
        shift = change[:3] - (base @ change[:3])[:, None] * base
        moved = base + shift
        moved = moved / np.linalg.norm(moved, axis=1, keepdims=True)
        turned = rotation @ rotation_by_vector(change[3:]).T
        orientation = replace(self.orientation, base=moved, rotation=turned)
        return replace(self, orientation=orientation).cameras()


def _stacked(cameras):
    """Centres and rotations of left and right camera as two arrays."""
    centres = np.stack([cameras.left_centre, cameras.right_centre], axis=1)
    rotations = np.stack([cameras.left_rotation, cameras.right_rotation], axis=1)
    return centres, rotations


def model_precision(pairs, xyz, model_start) -> ModelPrecision:
    """Cofactors of the points of many models.

    Parameters
    ----------
    pairs : OrientedPairs
    xyz : ndarray, shape (n_points, 3)
        Model points in the unit of the base, sorted by pair.
    model_start : ndarray of int, shape (n_pairs + 1,)

    Returns
    -------
    ModelPrecision
        NaN where a pair is not oriented.
    """
    xyz = np.ascontiguousarray(xyz, dtype=float)
    found = ModelPrecision(
        np.empty((len(xyz), 3, 3)),
        np.empty((len(xyz), 3, N_CHANGES)),
        np.empty((len(xyz), 3, 3)),
        np.empty((len(xyz), 3, 4)),
    )
    over_segments(
        _propagate,
        np.ascontiguousarray(model_start, dtype=np.int64),
        xyz,
        np.ascontiguousarray(pairs.distance, dtype=float),
        _stacked(pairs.cameras()),
        pairs.camera_changes(),
        np.ascontiguousarray(pairs.orientation.cofactor),
        found,
    )
    return found


@numba.njit(**COMPILED)
def _propagate(first, last, start, xyz, distance, cameras, changes, cofactors, out):
    by_place, by_change = np.empty((4, 3)), np.empty((4, N_CHANGES))
    normals, right_sides = np.empty((3, 3)), np.empty((3, N_CHANGES))
    for k in range(first, last):
        centres, rotations = cameras[0][k], cameras[1][k]
        centre_changes, rotation_changes = changes[0][k], changes[1][k]
        for i in range(start[k], start[k + 1]):
            for side in range(2):
                _differentiate(
                    xyz[i] - centres[side],
                    distance[k, side],
                    rotations[side],
                    (centre_changes[:, side], rotation_changes[:, side]),
                    (by_place[2 * side : 2 * side + 2], by_change[2 * side :]),
                )
            _multiply(by_place.T, by_place, 1.0, normals)
            _multiply(by_place.T, by_change, -1.0, right_sides)
            _invert(normals, out.image_part[i])
            _multiply(out.image_part[i], by_place.T, 1.0, out.by_image[i])
            _multiply(out.image_part[i], right_sides, 1.0, out.gain[i])
            _multiply(out.gain[i], cofactors[k], 1.0, right_sides)
            _multiply(right_sides, out.gain[i].T, 1.0, out.orientation_part[i])


@numba.njit(**COMPILED)
def _differentiate(reduced, c, rotation, changes, out):
    """Rows of A and B of one photograph; ``reduced`` is the place from its centre."""
    by_place, by_change = out
    centre_changes, rotation_changes = changes
    r = np.empty(3)
    for a in range(3):
        r[a] = (
            rotation[a, 0] * reduced[0]
            + rotation[a, 1] * reduced[1]
            + rotation[a, 2] * reduced[2]
        )
    for axis in range(2):
        # x = -c r_0 / r_2, and the same for y
        by_r, by_r_2 = -c / r[2], c * r[axis] / (r[2] * r[2])
        for b in range(3):
            by_place[axis, b] = by_r * rotation[axis, b] + by_r_2 * rotation[2, b]
        for j in range(N_CHANGES):
            total = 0.0
            for b in range(3):
                total += (
                    by_r * rotation_changes[j, axis, b]
                    + by_r_2 * rotation_changes[j, 2, b]
                ) * reduced[b] - by_place[axis, b] * centre_changes[j, b]
            by_change[axis, j] = total


@numba.njit(**COMPILED)
def _multiply(left, right, factor, out):
    for i in range(left.shape[0]):
        for j in range(right.shape[1]):
            total = 0.0
            for k in range(left.shape[1]):
                total += left[i, k] * right[k, j]
            out[i, j] = factor * total


@numba.njit(**COMPILED)
def _invert(m, out):
    """Inverse of a symmetric 3 x 3 matrix."""
    a, b, c, d, e, f = m[0, 0], m[0, 1], m[0, 2], m[1, 1], m[1, 2], m[2, 2]
    det = a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d)
    out[0, 0], out[1, 1] = (d * f - e * e) / det, (a * f - c * c) / det
    out[2, 2], out[0, 1] = (a * d - b * b) / det, (c * e - b * f) / det
    out[0, 2], out[1, 2] = (b * e - c * d) / det, (b * c - a * e) / det
    out[1, 0], out[2, 0], out[2, 1] = out[0, 1], out[0, 2], out[1, 2]
