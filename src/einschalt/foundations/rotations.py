"""Rotations in space: one convention, batched.

``M = R3(kappa) R2(phi) R1(omega)`` turns coordinates of the object into those of the
image: ``in_image = M @ (in_object - centre)``. Its transpose is the right-handed
rotation of the camera, first by kappa about z, then by phi about y, then by omega
about x; so for small angles ``M.T`` is 1 plus the right-handed rotation by
(omega, phi, kappa). Every function takes any leading axes.

Source: the usual matrix of the English-language textbooks; Chinese texts take phi
first and left-handed about y, and their angles do not fit here.
"""

import numpy as np

# sine of the angle within which phi counts as a right angle
GIMBAL_COSINE = 1e-10


def rotation_from_angles(omega, phi, kappa):
    """Matrix that turns object coordinates into image coordinates.

    Parameters
    ----------
    omega, phi, kappa : float or ndarray, shape (...)
        Right-handed rotations of the camera about x, y, z [rad].

    Returns
    -------
    ndarray, shape (..., 3, 3)
        ``R3(kappa) @ R2(phi) @ R1(omega)``.

    Examples
    --------
    >>> quarter_turn = rotation_from_angles(0.0, 0.0, np.pi / 2)
    >>> (quarter_turn @ [1.0, 0.0, 0.0]).round(12) + 0.0
    array([ 0., -1.,  0.])
    """
    about_x, about_y, about_z = _elementary(omega, phi, kappa)
    return about_z @ about_y @ about_x


def angles_from_rotation(matrix):
    """Angles of a rotation matrix.

    Parameters
    ----------
    matrix : ndarray, shape (..., 3, 3)
        ``R3(kappa) @ R2(phi) @ R1(omega)``.

    Returns
    -------
    ndarray, shape (..., 3)
        omega, phi, kappa [rad]; phi from -pi/2 to pi/2, the others from -pi to pi.
        Where phi is a right angle only the sum or the difference of the other two is
        determined; omega is then 0.

    Examples
    --------
    >>> angles_from_rotation(rotation_from_angles(0.1, -0.2, 3.0)).round(12)
    array([ 0.1, -0.2,  3. ])
    """
    m = np.asarray(matrix, dtype=float)
    cos_phi = np.hypot(m[..., 0, 0], m[..., 1, 0])
    is_gimbal = cos_phi < GIMBAL_COSINE
    omega = np.arctan2(-m[..., 2, 1], m[..., 2, 2])
    phi = np.arctan2(m[..., 2, 0], cos_phi)
    kappa = np.arctan2(-m[..., 1, 0], m[..., 0, 0])
    kappa_alone = np.arctan2(m[..., 0, 1], m[..., 1, 1])
    return np.stack(
        [np.where(is_gimbal, 0.0, omega), phi, np.where(is_gimbal, kappa_alone, kappa)],
        axis=-1,
    )


def are_rotations(matrices, tolerance):
    """Tell which matrices turn vectors, and neither stretch nor mirror them.

    Parameters
    ----------
    matrices : ndarray, shape (n, 3, 3)
    tolerance : float
        What products of two rows may be off by, as they were rounded.

    Returns
    -------
    ndarray of bool, shape (n,)

    Examples
    --------
    >>> are_rotations(np.array([np.eye(3), -np.eye(3)]), 1e-6).tolist()
    [True, False]
    """
    # no element of a rotation is beyond 1, and squares of huge ones overflow
    bounded = np.clip(matrices, -2.0, 2.0)
    gram = bounded @ np.swapaxes(bounded, 1, 2)
    is_orthogonal = np.abs(gram - np.eye(3)).max(axis=(1, 2)) < tolerance
    return is_orthogonal & (np.linalg.det(bounded) > 0.0)


def angle_rates(omega, phi):
    """Change of the angles when the camera turns a little about the object axes.

    A turn by the small vector w changes ``M.T`` to ``rotation_by_vector(w) @ M.T`` and
    the angles by ``angle_rates(omega, phi) @ w`` (rows omega, phi, kappa) [rad]. Not
    finite where phi is a right angle.
    """
    omega, phi = np.broadcast_arrays(
        np.asarray(omega, dtype=float), np.asarray(phi, dtype=float)
    )
    sin_o, cos_o = np.sin(omega), np.cos(omega)
    with np.errstate(divide="ignore", invalid="ignore"):
        sec, tan = 1.0 / np.cos(phi), np.tan(phi)
    one, zero = np.ones_like(omega), np.zeros_like(omega)
    return _stack(
        (one, tan * sin_o, -tan * cos_o),
        (zero, cos_o, sin_o),
        (zero, -sec * sin_o, sec * cos_o),
    )


def rotation_by_vector(vector):
    """Right-handed rotation about a vector, by its length [rad], small or zero too.

    >>> (rotation_by_vector([0.0, 0.0, np.pi / 2]) @ [1.0, 0.0, 0.0]).round(12) + 0.0
    array([0., 1., 0.])
    """
    vector = np.asarray(vector, dtype=float)
    angle = np.linalg.norm(vector, axis=-1)[..., None, None]
    cross = cross_matrix(vector)
    # np.sinc keeps all digits down to the angle 0
    return (
        np.eye(3)
        + np.sinc(angle / np.pi) * cross
        + 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * (cross @ cross)
    )


def cross_matrix(vector):
    """Matrix that forms the cross product: ``cross_matrix(a) @ b = a x b``."""
    x, y, z = np.moveaxis(np.asarray(vector, dtype=float), -1, 0)
    zero = np.zeros_like(x)
    return _stack((zero, -z, y), (z, zero, -x), (-y, x, zero))


def _elementary(omega, phi, kappa):
    angles = np.broadcast_arrays(omega, phi, kappa)
    (so, co), (sp, cp), (sk, ck) = ((np.sin(a), np.cos(a)) for a in angles)
    one, zero = np.ones_like(so), np.zeros_like(so)
    return (
        _stack((one, zero, zero), (zero, co, so), (zero, -so, co)),
        _stack((cp, zero, -sp), (zero, one, zero), (sp, zero, cp)),
        _stack((ck, sk, zero), (-sk, ck, zero), (zero, zero, one)),
    )


def _stack(*rows):
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
