"""The linear equation between y-parallax and the elements of relative orientation.

System of a model: origin in the left projection centre, x along the base to the right
centre (b, 0, 0), y across, z up, right-handed; the points lie below, z < 0. Rotations
are right-handed about +x (omega), +y (phi), +z (kappa) [rad]. All lengths of a model
have any one unit.

The unknowns are *corrections*: what the bundles have yet to be turned and shifted for
the parallaxes to vanish. At fixed height the y of a ray then changes by::

    dy = (y² + z²)/(-z) dω + X (y/z) dφ + X dκ + dby - (y/z) dbz,   X = x - x_centre

and ``p + change of p = 0``, where ``p = y(moved bundle) - y(fixed bundle)``:

================== ========================================= ====================
case               elements, in this order                   p
================== ========================================= ====================
independent        d_omega, d_phi_1, d_phi_2, d_kappa_1,     y_left - y_right
                   d_kappa_2 (both bundles turn;
                   d_omega = d_omega_1 - d_omega_2)
dependent_left     d_omega, d_phi, d_kappa, d_by, d_bz       y_left - y_right
dependent_right    d_omega, d_phi, d_kappa, d_by, d_bz       **y_right - y_left**
================== ========================================= ====================

The sign of the last row is the one trap: parallaxes measured as ``y_left - y_right``
give every element of ``dependent_right`` with the wrong sign.

Source: J. Krames 1951, (1) and a)-k); B. Hallert's numerical method.
"""

import numpy as np

INDEPENDENT = "independent"
DEPENDENT_LEFT = "dependent_left"
DEPENDENT_RIGHT = "dependent_right"
CASES = (INDEPENDENT, DEPENDENT_LEFT, DEPENDENT_RIGHT)

_DEPENDENT_ELEMENTS = ("d_omega", "d_phi", "d_kappa", "d_by", "d_bz")
ELEMENTS = {
    INDEPENDENT: ("d_omega", "d_phi_1", "d_phi_2", "d_kappa_1", "d_kappa_2"),
    DEPENDENT_LEFT: _DEPENDENT_ELEMENTS,
    DEPENDENT_RIGHT: _DEPENDENT_ELEMENTS,
}
N_ELEMENTS = 5
_N_ANGLES = {INDEPENDENT: 5, DEPENDENT_LEFT: 3, DEPENDENT_RIGHT: 3}


def design_matrix(xyz, base, case):
    """Coefficients of the parallax equation ``p = A x`` at any points.

    Parameters
    ----------
    xyz : ndarray, shape (n_points, 3)
        Model coordinates, origin in the left projection centre, z < 0.
    base : float or ndarray, shape (n_points,)
        Base of the model of each point, in the unit of the coordinates.
    case : {"independent", "dependent_left", "dependent_right"}

    Returns
    -------
    ndarray, shape (n_points, 5)
        In the order of ``ELEMENTS[case]``: per radian for angles, and without unit
        for ``d_by`` and ``d_bz``.

    Notes
    -----
    Clearing the x-parallax by moving the mark in z does not change p to first order,
    since both rays have the slope y/z at the point.

    Examples
    --------
    >>> design_matrix(np.array([[0.0, 3.0, -1.0]]), 2.0, "dependent_right")
    array([[-10.,  -6.,   2.,  -1.,  -3.]])
    """
    x, y, z = np.moveaxis(np.asarray(xyz, dtype=float), -1, 0)
    slope = y / z
    tilt = y * slope + z
    from_right = x - base
    if case == INDEPENDENT:
        columns = (tilt, -x * slope, from_right * slope, -x, from_right)
    else:
        from_moved = x if case == DEPENDENT_LEFT else from_right
        columns = (tilt, -from_moved * slope, -from_moved, -np.ones_like(z), slope)
    return np.stack(columns, axis=-1)


def element_scale(height, case):
    """Length of the unit vector of each element: the height for angles, 1 for shifts.

    A column of the design matrix divided by its length is of the order of 1 whatever
    the unit of the model, so that singular values of different models compare.
    ``height`` (n_models,) is the mean distance of the points below the projection
    centres.
    """
    is_angle = np.arange(N_ELEMENTS) < _N_ANGLES[case]
    return np.where(is_angle, np.asarray(height, dtype=float)[..., np.newaxis], 1.0)


def independent_from_dependent(base, case):
    """Matrix T (..., 5, 5) from dependent elements to the independent ones of a model.

    ``independent = T @ dependent`` and ``Q_independent = T @ Q @ T.T``; the case says
    which bundle moves. The model is the same up to a rotation, shift and change of
    scale of the whole, hence has the same parallaxes, up to the sign of p of
    ``dependent_right``.
    """
    base = np.asarray(base, dtype=float)
    matrix = np.zeros((*base.shape, N_ELEMENTS, N_ELEMENTS))
    is_left = case == DEPENDENT_LEFT
    moved, fixed = (0, 1) if is_left else (1, 0)
    sign = 1.0 if is_left else -1.0
    matrix[..., 0, 0] = sign
    for element, first_row, shift, sense in ((1, 1, 4, -sign), (2, 3, 3, sign)):
        matrix[..., first_row + moved, element] = 1.0
        matrix[..., first_row + moved, shift] = sense / base
        matrix[..., first_row + fixed, shift] = sense / base
    return matrix
