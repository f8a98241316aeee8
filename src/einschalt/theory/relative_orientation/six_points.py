"""The six points of the usual layout: which is which, and whether two planes hold them.

Points 1, 3, 5 lie on the side of the left projection centre, 2, 4, 6 on that of the
right one; 1 and 2 in the middle, 3 and 4 towards +y, 5 and 6 towards -y::

    3 · · 4
    1 · · 2
    5 · · 6

Krames and Hallert take them plane by plane, as **1, 3, 5, 2, 4, 6**; an operator goes
from 1 to 6.
"""

import numpy as np

N_SIX = 6
FROM_1_TO_6 = np.array([0, 3, 1, 4, 2, 5])
"""Rows that bring an array in the order 1, 3, 5, 2, 4, 6 into the order 1 to 6."""
PLANE_TOLERANCE = 1e-6
"""Part of the base by which x may differ from its plane: with angles of 0.01 rad the
parallax then changes by 1e-8 of the base, a nanometre in a model of 100 mm."""


def number_six_points(xyz):
    """Rows (..., 6) of ``xyz`` (..., 6, 3) that hold the points 1, 3, 5, 2, 4, 6.

    Examples
    --------
    >>> xyz = np.array([[9.0, -5.0, -8.0], [0.0, 5.0, -8.0], [9.0, 0.0, -8.0],
    ...                 [0.0, -5.0, -8.0], [0.0, 0.0, -8.0], [9.0, 5.0, -8.0]])
    >>> number_six_points(xyz)
    array([4, 1, 3, 2, 5, 0])
    """
    xyz = np.asarray(xyz, dtype=float)
    by_x = np.argsort(xyz[..., 0], axis=-1, kind="stable")
    sides = by_x.reshape(*by_x.shape[:-1], 2, 3)
    y = np.take_along_axis(xyz[..., 1], by_x, axis=-1).reshape(sides.shape)
    low_to_high = np.argsort(y, axis=-1, kind="stable")
    middle_high_low = low_to_high[..., [1, 2, 0]]
    return np.take_along_axis(sides, middle_high_low, axis=-1).reshape(by_x.shape)


def are_on_two_sides(xyz, base):
    """Tell whether points 1, 3, 5 lie left of the middle of the base, the others right.

    ``xyz`` (..., 6, 3) follows the order 1, 3, 5, 2, 4, 6; bool of shape (...).
    """
    x = np.asarray(xyz, dtype=float)[..., 0]
    middle = np.asarray(base, dtype=float) / 2.0
    return (x[..., :3].max(axis=-1) < middle) & (middle < x[..., 3:].min(axis=-1))


def are_in_base_normal_planes(xyz, base):
    """Tell whether points 1, 3, 5 lie in the plane x = 0 and 2, 4, 6 in x = base.

    ``xyz`` (..., 6, 3) follows the order 1, 3, 5, 2, 4, 6; every x must agree with its
    plane within ``PLANE_TOLERANCE`` of the base.
    """
    base = np.asarray(base, dtype=float)[..., np.newaxis]
    plane = base * np.repeat([0.0, 1.0], 3)
    off = np.abs(np.asarray(xyz, dtype=float)[..., 0] - plane)
    return np.all(off <= PLANE_TOLERANCE * base, axis=-1)
