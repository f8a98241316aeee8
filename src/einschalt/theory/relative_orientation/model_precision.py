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

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from einschalt.foundations.batches import over_segments
from einschalt.foundations.kernels import compiled
from einschalt.foundations.rotations import rotation_by_vector
from einschalt.theory.relative_orientation.coplanarity_condition import COMPILED
from einschalt.theory.relative_orientation.orientation_elements import (
    StereoCameras,
    orientation_elements,
)

# of central differences: the error is its square, and rounding over it
STEP = 1e-5
N_CHANGES = 6
EPS = np.finfo(float).eps


class ModelPrecision(NamedTuple):
    """Cofactors of model points, for image coordinates with the variance 1 mm²."""

    # (n_points, 3, 3): of the intersection alone [unit of the base² / mm²]
    image_part: np.ndarray
    # (n_points, 3, 6): derivatives G by base direction and turn of the right camera
    gain: np.ndarray
    orientation_part: np.ndarray  # (n_points, 3, 3): G C G.T
    # (n_points, 3, 4): derivatives (A.T A)^-1 A.T of the point by its own image
    # coordinates, the orientation held [unit of the base / mm]
    by_image: np.ndarray

    @property
    def cofactor(self):
        """Both parts together, shape (n_points, 3, 3)."""
        return self.image_part + self.orientation_part


@dataclass(frozen=True, eq=False)
class OrientedPairs:
    """What the precision of model points needs to know of their pairs."""

    orientation: object
    base_length: np.ndarray  # (n_pairs,)
    case: str
    distance: np.ndarray  # (n_pairs, 2): principal distances [mm]

    def cameras(self):
        """Centres and rotations in the model system; StereoCameras."""
        return orientation_elements(
            self.orientation, self.base_length, self.case
        ).cameras

    def camera_changes(self):
        """Derivatives of the cameras by base direction (3) and turn (3).

        Centres (n_pairs, 6, 2, 3) and rotations (n_pairs, 6, 2, 3, 3) of left and right
        camera, by central differences of the elements, which are those of every case,
        whichever length is fixed.
        """
        centres, rotations = [], []
        for change in np.eye(N_CHANGES):
            (c_more, r_more), (c_less, r_less) = (
                self._moved(sign * STEP * change).stacked() for sign in (1.0, -1.0)
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


def model_precision(pairs, xyz, model_start) -> ModelPrecision:
    """Cofactors of the points of many models; NaN where a pair is not oriented.

    ``xyz`` (n_points, 3) are model points in the unit of the base, sorted by pair.
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
        pairs.cameras().stacked(),
        pairs.camera_changes(),
        np.ascontiguousarray(pairs.orientation.cofactor),
        found,
    )
    return found


@compiled(**COMPILED)
def _propagate(first, last, start, xyz, distance, cameras, changes, cofactors, out):
    by_place, by_change = np.empty((4, 3)), np.empty((4, N_CHANGES))
    inverse, reduced = np.empty((3, 3)), np.empty(3)
    root, gained = np.empty((N_CHANGES, N_CHANGES)), np.empty((3, N_CHANGES))
    for k in range(first, last):
        centres, rotations = cameras[0][k], cameras[1][k]
        centre_changes, rotation_changes = changes[0][k], changes[1][k]
        _semidefinite_root(cofactors[k], root)
        for i in range(start[k], start[k + 1]):
            for side in range(2):
                for axis in range(3):
                    reduced[axis] = xyz[i, axis] - centres[side, axis]
                _differentiate(
                    reduced,
                    distance[k, side],
                    rotations[side],
                    (centre_changes[:, side], rotation_changes[:, side]),
                    (by_place[2 * side : 2 * side + 2], by_change[2 * side :]),
                )
            _orthogonalise(by_place, inverse)
            _multiply(inverse, by_place.T, 1.0, out.by_image[i])
            _multiply(inverse, inverse.T, 1.0, out.image_part[i])
            _multiply(out.by_image[i], by_change, -1.0, out.gain[i])
            # squares of roots: no rounding makes a variance negative
            _multiply(out.gain[i], root, 1.0, gained)
            _multiply(gained, gained.T, 1.0, out.orientation_part[i])


@compiled(**COMPILED)
def _orthogonalise(a, inverse):
    """Replace A = Q R by Q (Gram and Schmidt, twice), and fill R^-1.

    Without A.T A, which squares the condition where rays are almost parallel.
    """
    r = np.empty((3, 3))
    r[:] = 0.0
    for j in range(3):
        for _ in range(2):
            for m in range(j):
                part = 0.0
                for row in range(4):
                    part += a[row, m] * a[row, j]
                r[m, j] += part
                for row in range(4):
                    a[row, j] -= part * a[row, m]
        square = 0.0
        for row in range(4):
            square += a[row, j] * a[row, j]
        r[j, j] = math.sqrt(square)
        for row in range(4):
            a[row, j] /= r[j, j]
    inverse[:] = 0.0
    for j in range(3):
        inverse[j, j] = 1.0 / r[j, j]
    inverse[0, 1] = -inverse[0, 0] * r[0, 1] * inverse[1, 1]
    inverse[1, 2] = -inverse[1, 1] * r[1, 2] * inverse[2, 2]
    inverse[0, 2] = -inverse[0, 0] * r[0, 2] - inverse[0, 1] * r[1, 2]
    inverse[0, 2] *= inverse[2, 2]


@compiled(**COMPILED)
def _semidefinite_root(matrix, root):
    """Fill L with L L.T = C (Cholesky with pivots); NaN where C is.

    C has the rank 5: what is left below rounding is none of it.
    """
    rest, trace = matrix.copy(), 0.0
    for i in range(len(matrix)):
        trace += matrix[i, i]
    limit = len(matrix) * EPS * trace
    root[:] = 0.0 if math.isfinite(limit) else np.nan
    for k in range(len(matrix)):
        pivot = 0
        for i in range(len(matrix)):
            pivot = i if rest[i, i] > rest[pivot, pivot] else pivot
        if not rest[pivot, pivot] > limit:
            return
        length = math.sqrt(rest[pivot, pivot])
        for i in range(len(matrix)):
            root[i, k] = rest[i, pivot] / length
        for i in range(len(matrix)):
            for j in range(len(matrix)):
                rest[i, j] -= root[i, k] * root[j, k]
        rest[pivot, :], rest[:, pivot] = 0.0, 0.0


@compiled(**COMPILED)
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


@compiled(**COMPILED)
def _multiply(left, right, factor, out):
    for i in range(left.shape[0]):
        for j in range(right.shape[1]):
            total = 0.0
            for k in range(left.shape[1]):
                total += left[i, k] * right[k, j]
            out[i, j] = factor * total
