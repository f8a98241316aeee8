"""Planes through the points of each model, by least squares."""

import numpy as np

from einschalt.foundations.batches import segment_centred, segment_sum


def off_planes(plan, values, start):
    """What a plane through the points of each segment leaves of their values.

    Parameters
    ----------
    plan : ndarray, shape (n_points, 2)
        Coordinates in which the plane is tilted.
    values : ndarray, shape (n_points,)
        Such as heights.
    start : ndarray, shape (n_segments + 1,)
        First point of each segment, and the number of points.

    Returns
    -------
    ndarray, shape (n_points,)
        In the unit of the values. Points on a line, or a single one, leave nothing
        that a tilt along the line takes up.

    Examples
    --------
    >>> start = np.array([0, 4])
    >>> plan = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0], [2.0, 2.0]])
    >>> off_planes(plan, np.array([5.0, 6.0, 6.0, 11.0]), start).tolist()
    [1.0, -1.0, -1.0, 1.0]
    """
    away = segment_centred(plan, start)
    high = segment_centred(values, start)
    normal = segment_sum(away[:, :, None] * away[:, None, :], start)
    tilt = np.einsum(
        "mij,mj->mi",
        np.linalg.pinv(normal, hermitian=True),
        segment_sum(away * high[:, None], start),
    )
    return high - (away * np.repeat(tilt, np.diff(start), axis=0)).sum(axis=1)
