"""Dangerous surfaces before the flight, from terrain heights in the standard points.

The six standard points of a model lie below the two projection centres (1 and 2) and
in the wings beside them: 3 and 5 on either side of 1, 4 and 6 on either side of 2. The
wings are seen under tan(beta) = wing / principal distance, so that they lie at the
ground distance tan(beta) times their own depth. Where they stand higher than the
middle, as the sides of a valley do, the centre and its three points come near a circle.

With ``delta`` = (height of the wings - height of the middle) / flying height above the
middle, the relative depth of the valley, and ``critical`` = sin²(beta):

==================== ==============================================
inflation            1 / |1 - delta / critical|
over-correction n    (1 - delta) / (2 (critical - delta))
gap                  (critical - delta) / (1 - delta) = 1 / (2 n)
==================== ==============================================

Ridges (delta < 0) make the orientation better. Beyond the critical depth it gets better
again, but n and k = n - 1 are negative: the bundle must be turned the other way.

Source: P. Waldhäusl 1971; the formulas are our own derivation.
"""

import numpy as np

POINTS = ("1", "2", "3", "4", "5", "6")
AT_RIGHT_CENTRE = np.array([0.0, 1.0, 0.0, 1.0, 0.0, 1.0])
SIDE = np.array([0.0, 0.0, 1.0, 1.0, -1.0, -1.0])
MIDDLE = slice(0, 2)


def critical_depth(wing, principal_distance):
    """Relative depth at which a symmetrical valley is dangerous: sin²(beta).

    In parts of the flying height above the middle of the valley, from the distance of
    the wings from the base in the image and the principal distance, in one unit.

    Examples
    --------
    Wide-angle, narrow-angle and super-wide cameras:

    >>> critical_depth(100.0, np.array([152.0, 300.0, 88.0])).round(2).tolist()
    [0.3, 0.1, 0.56]
    """
    return wing**2 / (wing**2 + principal_distance**2)


def standard_points(heights, altitude, principal_distance, wing, image_base):
    """Model coordinates (n_models, 6, 3) of the standard points, and bases [m].

    From the heights (n_models, 6) of the terrain in the points 1 to 6 and the altitude
    (n_models,) of the flight in the same system; principal distance, and wings and base
    as they appear in the image [m]. The origin is the left projection centre; z >= 0
    where the terrain reaches the altitude. The mean of points 1 and 2 has the forward
    overlap.
    """
    z = heights - altitude[:, np.newaxis]
    base = image_base / principal_distance * -z[:, MIDDLE].mean(axis=1)
    x = base[:, np.newaxis] * AT_RIGHT_CENTRE
    y = -z * SIDE * (wing / principal_distance)
    return np.stack([x, y, z], axis=-1), base


def valley_depths(heights):
    """Mean height of the wings less that of the middle in both base-normal planes.

    Of the left and of the right centre, (n_models, 2); negative on ridges. ``heights``
    (n_models, 6) are those of the terrain in the points 1 to 6.
    """
    wings = (heights[:, 2:4] + heights[:, 4:6]) / 2.0
    return wings - heights[:, MIDDLE]
