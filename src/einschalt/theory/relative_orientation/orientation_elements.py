"""Elements of relative orientation in the three usual forms, with their cofactors.

Which photograph is moved, in which system, is the *case*:

dependent_right
    The left photograph is the reference: its centre is the origin and its image system
    the model system. bx, by, bz are the centre of the right photograph, omega, phi,
    kappa its rotation.
dependent_left
    The right photograph is the reference: its image system is parallel to the model
    system, its centre is (bx, 0, 0). The left photograph is moved: its centre is
    (0, by, bz), and omega, phi, kappa are its rotation.
independent
    The base is the x axis of the model system, the left centre its origin. The left
    photograph is rotated by phi_1 and kappa_1, the right one by omega_2, phi_2 and
    kappa_2.

A rotation is ``M = R3(kappa) R2(phi) R1(omega)``, from model into image system.
The length of the base is free. In the dependent cases bx has the given length where the
base, seen from left to right, lies within 45 degrees of the x axis of the reference
photograph, and the base vector has it otherwise; then the covariance of by and bz is
that of two components of a vector of fixed length, and can be singular.

Small changes of these elements are the unknowns of the linear theory: those of the
dependent cases d_by, d_bz, d_omega, d_phi, d_kappa of the moved photograph, in the
independent case d_omega_2 = -d_omega, since omega_1 is held at 0.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.arguments import require_choice
from einschalt.foundations.rotations import (
    angle_rates,
    angles_from_rotation,
    cross_matrix,
    rotation_from_angles,
)
from einschalt.theory.relative_orientation.coplanarity_condition import COS_45

DEPENDENT = ("bx", "by", "bz", "omega", "phi", "kappa")
INDEPENDENT = ("base", "phi_1", "kappa_1", "omega_2", "phi_2", "kappa_2")


@dataclass(frozen=True, eq=False)
class StereoCameras:
    """Centres and rotations of both photographs of many pairs in the model system."""

    left_centre: np.ndarray  # both (n_pairs, 3): in the unit of the base
    right_centre: np.ndarray
    # both (n_pairs, 3, 3): from the model into the image system
    left_rotation: np.ndarray
    right_rotation: np.ndarray

    def stacked(self):
        """Centres (n_pairs, 2, 3) and rotations (n_pairs, 2, 3, 3)."""
        centres = np.stack([self.left_centre, self.right_centre], axis=1)
        return centres, np.stack([self.left_rotation, self.right_rotation], axis=1)


@dataclass(frozen=True, eq=False)
class OrientationElements:
    """Elements of many pairs in one case."""

    names: tuple[str, ...]  # of the six columns of ``values``
    values: np.ndarray  # (n_pairs, 6): lengths in the unit of the base, angles [rad]
    # the five that were estimated, in the order of ``cofactor``
    estimated: tuple[str, ...]
    cofactor: np.ndarray  # (n_pairs, 5, 5)
    cameras: StereoCameras


def orientation_elements(orientation, base_length=1.0, case="dependent_right"):
    """Elements of pairs that were oriented by the coplanarity condition.

    ``base_length`` is that of bx or of the base vector, in any unit. NaN where a pair
    was not oriented; cofactors are not finite where an angle phi is a right angle. An
    unknown case is a SettingsError.
    """
    require_choice("case", case, CASES)
    length = np.broadcast_to(
        np.asarray(base_length, dtype=float), len(orientation.base)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return CASES[case](orientation, length)


def _dependent_right(orientation, length):
    base, rotation = orientation.base, orientation.rotation
    centre, by_direction = _scaled_base(base, length)
    angles = angles_from_rotation(rotation)
    change = np.zeros((len(base), 5, 6))
    change[:, :2, :3] = by_direction[:, 1:]
    change[:, 2:, 3:] = angle_rates(angles[:, 0], angles[:, 1])
    origin, same = np.zeros_like(base), np.broadcast_to(np.eye(3), rotation.shape)
    return OrientationElements(
        names=DEPENDENT,
        values=np.concatenate([centre, angles], axis=1),
        estimated=DEPENDENT[1:],
        cofactor=_propagate(change, orientation.cofactor),
        cameras=StereoCameras(origin, centre, same, rotation),
    )


def _dependent_left(orientation, length):
    base, rotation = orientation.base, orientation.rotation
    # the base in the right system changes with the turn of the right camera, too
    turned = np.einsum("nij,nj->ni", rotation, base)
    by_turn = rotation @ cross_matrix(base)
    vector, by_direction = _scaled_base(turned, length)
    left_rotation = np.swapaxes(rotation, 1, 2)
    angles = angles_from_rotation(left_rotation)
    change = np.zeros((len(base), 5, 6))
    change[:, :2, :3] = -(by_direction @ rotation)[:, 1:]
    change[:, :2, 3:] = -(by_direction @ by_turn)[:, 1:]
    change[:, 2:, 3:] = -angle_rates(angles[:, 0], angles[:, 1]) @ rotation
    left = -vector * [0.0, 1.0, 1.0]
    right = vector * [1.0, 0.0, 0.0]
    same = np.broadcast_to(np.eye(3), rotation.shape)
    return OrientationElements(
        names=DEPENDENT,
        values=np.concatenate([vector[:, :1], left[:, 1:], angles], axis=1),
        estimated=DEPENDENT[1:],
        cofactor=_propagate(change, orientation.cofactor),
        cameras=StereoCameras(left, right, left_rotation, same),
    )


def _independent(orientation, length):
    base, rotation = orientation.base, orientation.rotation
    (x, y, z), level = base.T, np.hypot(base[:, 0], base[:, 1])
    phi, kappa = np.arctan2(z, level), np.arctan2(-y, x)
    left_rotation = rotation_from_angles(np.zeros_like(phi), phi, kappa)
    right_rotation = rotation @ left_rotation
    angles = angles_from_rotation(right_rotation)
    zero = np.zeros_like(x)
    by_base = np.stack(
        [
            np.stack([-z * x / level, -z * y / level, level], axis=-1),
            np.stack([y / level**2, -x / level**2, zero], axis=-1),
        ],
        axis=1,
    )
    # turns of both cameras in the model system, by phi_1 and kappa_1
    frame = np.zeros((len(base), 3, 2))
    frame[:, 0, 1], frame[:, 1, 0], frame[:, 2, 1] = np.sin(phi), 1.0, np.cos(phi)
    rates = angle_rates(angles[:, 0], angles[:, 1])
    change = np.zeros((len(base), 5, 6))
    change[:, :2, :3] = by_base
    change[:, 2:, :3] = rates @ frame @ by_base
    change[:, 2:, 3:] = rates @ np.swapaxes(left_rotation, 1, 2)
    right = length[:, None] * [1.0, 0.0, 0.0]
    right[np.isnan(x)] = np.nan
    return OrientationElements(
        names=INDEPENDENT,
        values=np.column_stack([right[:, 0], phi, kappa, angles]),
        estimated=INDEPENDENT[1:],
        cofactor=_propagate(change, orientation.cofactor),
        cameras=StereoCameras(
            np.zeros_like(base), right, left_rotation, right_rotation
        ),
    )


CASES = {
    "dependent_right": _dependent_right,
    "dependent_left": _dependent_left,
    "independent": _independent,
}


def _scaled_base(direction, length):
    """Base vector, and its derivatives by its direction, shape (n_pairs, 3, 3)."""
    x = direction[:, 0]
    is_along_x = x >= COS_45
    factor = np.where(is_along_x, length / x, length)[:, None]
    vector = factor * direction
    vector[:, 0] = np.where(is_along_x, length, vector[:, 0])  # without rounding
    along = np.where(is_along_x, 1.0 / x, 0.0)[:, None, None]
    first = along * vector[:, :, None] * [1.0, 0.0, 0.0]
    return vector, factor[:, :, None] * np.eye(3) - first


def _propagate(change, cofactor):
    return change @ cofactor @ np.swapaxes(change, 1, 2)
