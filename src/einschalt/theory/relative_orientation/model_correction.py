"""Correction of machine coordinates by the elements found from their parallaxes.

An operator sets the mark of an uncorrected model to the place where the x-parallax is
cleared: both rays then pass at the height of the mark, the left one p/2 and the right
one -p/2 beside it in y, p = y_left - y_right. Correcting turns and shifts the bundles
by the elements and intersects the two rays again. That parallax is not measured for
every point of the model; it is *the one with which the corrected rays meet*, a
quadratic equation with one small root. So nothing here is linear:
:func:`correct_model` is the exact inverse of :func:`disturb_model`, and what a model
oriented by linear equations keeps as an error is of second order in the angles.

Conventions, cases and order of the elements:
:mod:`einschalt.theory.relative_orientation.parallax_equations`. A bundle is turned
about its centre by kappa, phi, omega in this order, about axes that stay (the matrix
R_x(omega) R_y(phi) R_z(kappa)); an ``independent`` d_omega turns the left bundle. The
corrected model keeps the machine's origin and directions, hence differs from the truth
by a similarity.
"""

import numpy as np

from einschalt.foundations.kernels import compiled
from einschalt.theory.relative_orientation.parallax_equations import (
    DEPENDENT_LEFT,
    DEPENDENT_RIGHT,
    INDEPENDENT,
)

_SIGN_OF_PARALLAX = {INDEPENDENT: 1.0, DEPENDENT_LEFT: 1.0, DEPENDENT_RIGHT: -1.0}


def correct_model(xyz_machine, base, elements, case):
    """Model coordinates after the elements have been applied to the ray bundles.

    Parameters
    ----------
    xyz_machine : ndarray, shape (n_points, 3)
        Coordinates read in the uncorrected model, origin in the left projection
        centre, z < 0.
    base : float or ndarray, shape (n_points,)
        Base of the model of each point, in the unit of the coordinates.
    elements : ndarray, shape (5,) or (n_points, 5)
        Corrections in the order of ``ELEMENTS[case]`` [rad, unit of the coordinates],
        those of the model of each point.
    case : {"independent", "dependent_left", "dependent_right"}

    Returns
    -------
    ndarray, shape (n_points, 3)
        NaN where corrected rays cannot meet (elements beyond all reason) or where an
        element is NaN.
    """
    return _correct(*_bundles(xyz_machine, base, elements, case))[0]


def parallaxes_to_clear(xyz_machine, base, elements, case):
    """Y-parallaxes that the elements clear exactly, as the corrected rays meet.

    ``y(moved) - y(fixed)`` (n_points,) in the unit of the coordinates, from what
    :func:`correct_model` takes. What :func:`~.parallax_equations.design_matrix` times
    the elements gives is the linear part; the difference tells whether they are still
    small enough for it.
    """
    parallax = _correct(*_bundles(xyz_machine, base, elements, case))[1]
    return _SIGN_OF_PARALLAX[case] * parallax


def disturb_model(xyz, base, elements, case):
    """Coordinates and parallaxes that an operator reads before the correction.

    The inverse of :func:`correct_model`, for simulations: from a true model, and from
    the corrections that its bundles still need, to what is measured.

    Parameters
    ----------
    xyz : ndarray, shape (n_points, 3)
        True coordinates in the system of the *corrected* model, whose centres are
        (0, 0, 0) and (base, 0, 0), the moved one of a dependent pair being further
        by (0, d_by, d_bz); z < 0.
    base, elements, case
        As in :func:`correct_model`.

    Returns
    -------
    xyz_machine : ndarray, shape (n_points, 3)
        Where the mark stands with the x-parallax cleared, midway between the rays.
    y_parallax : ndarray, shape (n_points,)
        ``y(moved) - y(fixed)``: y_left - y_right, but y_right - y_left for
        ``dependent_right``. Exact, without errors of measuring.
    """
    machine, parallax = _disturb(*_bundles(xyz, base, elements, case))
    return machine, _SIGN_OF_PARALLAX[case] * parallax


def _bundles(xyz, base, elements, case):
    """Points, bases, turns of the bundles and places of the centres (n, 2, 3)."""
    xyz, n_points = np.ascontiguousarray(xyz, dtype=float), len(xyz)
    elements = np.broadcast_to(np.asarray(elements, dtype=float), (n_points, 5))
    angles = np.zeros((n_points, 2, 3))
    centres = np.zeros((n_points, 2, 3))
    centres[:, 1, 0] = base
    if case == INDEPENDENT:
        angles[:, 0] = elements[:, [0, 1, 3]]
        angles[:, 1, 1:] = elements[:, [2, 4]]
    else:
        moved = 0 if case == DEPENDENT_LEFT else 1
        angles[:, moved] = elements[:, :3]
        centres[:, moved, 1:] = elements[:, 3:]
    # an array of its own: for another layout the kernels would be compiled again
    return xyz, np.full(n_points, base, dtype=float), angles, centres


@compiled(error_model="numpy")
def _correct(xyz, base, angles, centres):
    corrected = np.empty_like(xyz)
    parallax = np.empty(xyz.shape[0])
    for point in range(xyz.shape[0]):
        x, y, z = xyz[point]
        left, right = angles[point]
        centre = centres[point, 0]
        b = _difference(centres[point, 1], centre)
        # the rays through the mark, and what a unit of parallax adds to each
        u, v = _turned((x, y, z), left), _turned((x - base[point], y, z), right)
        f, g = _turned((0.0, 0.5, 0.0), left), _turned((0.0, -0.5, 0.0), right)
        # the corrected rays u + p f and v + p g lie in one plane with the base
        constant = _volume(b, u, v)
        linear = _volume(b, f, v) + _volume(b, u, g)
        square = _volume(b, f, g)
        root = np.sqrt(linear**2 - 4.0 * square * constant)
        p = -2.0 * constant / (linear + np.copysign(root, linear))
        ux, uy, uz = u[0] + p * f[0], u[1] + p * f[1], u[2] + p * f[2]
        vx, vz = v[0] + p * g[0], v[2] + p * g[2]
        share = (b[2] * vx - b[0] * vz) / (uz * vx - ux * vz)
        corrected[point, 0] = centre[0] + share * ux
        corrected[point, 1] = centre[1] + share * uy
        corrected[point, 2] = centre[2] + share * uz
        parallax[point] = p
    return corrected, parallax


@compiled(error_model="numpy")
def _disturb(xyz, base, angles, centres):
    machine = np.empty_like(xyz)
    parallax = np.empty(xyz.shape[0])
    for point in range(xyz.shape[0]):
        left, right = angles[point]
        ray_left = _difference(xyz[point], centres[point, 0])
        ray_right = _difference(xyz[point], centres[point, 1])
        ux, uy, uz = _turned_back(ray_left, left)
        vx, vy, vz = _turned_back(ray_right, right)
        # x-parallax cleared: the height at which both rays have the same x
        z = base[point] / (ux / uz - vx / vz)
        y_left, y_right = z * uy / uz, z * vy / vz
        machine[point, 0] = z * ux / uz
        machine[point, 1] = 0.5 * (y_left + y_right)
        machine[point, 2] = z
        parallax[point] = y_left - y_right
    return machine, parallax


@compiled
def _turned(vector, angles):
    x, y, z = vector
    x, y = _turned_in_plane(x, y, angles[2])
    z, x = _turned_in_plane(z, x, angles[1])
    y, z = _turned_in_plane(y, z, angles[0])
    return x, y, z


@compiled
def _turned_back(vector, angles):
    x, y, z = vector
    y, z = _turned_in_plane(y, z, -angles[0])
    z, x = _turned_in_plane(z, x, -angles[1])
    x, y = _turned_in_plane(x, y, -angles[2])
    return x, y, z


@compiled
def _turned_in_plane(first, second, angle):
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * first - sine * second, sine * first + cosine * second


@compiled
def _difference(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@compiled
def _volume(a, b, c):
    """Volume of the box on three edges, their triple product."""
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
