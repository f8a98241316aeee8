"""Whether two photographs were taken from one place, so that nothing can be oriented.

Without a base the rays of the right photograph are those of the left one, turned. The
best turn of unit vectors is found by a singular value decomposition (Kabsch 1976,
Wahba's problem), for all pairs at once.
"""

import numpy as np

from einschalt.foundations.batches import segment_sum

MOST_PARALLAX = 1e-3
"""Rays that a turn brings nearer than this [rad, root mean square] show no base."""
LEAST_SPREAD = 0.02
"""Rays that spread less than this [rad] would fit after a turn with any base."""


def have_no_base(image, model_start, distance):
    """Tell which pairs a turn alone explains (Kabsch, Acta Cryst. A32, 1976, 922).

    ``image`` (n_points, 4) is x', y', x", y" [mm], origin in the principal point,
    sorted by pair; ``distance`` (n_pairs, 2) has the principal distances of the left
    and the right photograph [mm]. False for points in one place, which a turn explains
    as well.

    Examples
    --------
    The same photograph twice:

    >>> xy = np.array([[0.0, 0.0], [90.0, 5.0], [-4.0, 95.0], [80.0, -90.0]])
    >>> have_no_base(np.hstack([xy, xy]), np.array([0, 4]), np.array([[153.0, 153.0]]))
    array([ True])
    """
    n_points = np.diff(model_start)
    rows = np.repeat(distance, n_points, axis=0)
    left, right = (_unit_rays(image[:, 2 * k : 2 * k + 2], rows[:, k]) for k in (0, 1))
    products = segment_sum(right[:, :, np.newaxis] * left[:, np.newaxis], model_start)
    per_point = 1.0 / np.maximum(n_points, 1)
    u, size, v = np.linalg.svd(products)
    # a turn is no mirror: the smallest one may have to count against
    size[:, 2] *= np.sign(np.linalg.det(u) * np.linalg.det(v))
    apart = 2.0 - 2.0 * size.sum(axis=1) * per_point
    spread = size[:, 1] * per_point
    return (apart < MOST_PARALLAX**2) & (spread > LEAST_SPREAD**2)


def _unit_rays(xy, distance):
    rays = np.column_stack([xy, -distance])
    # squares of gross errors would be too large
    rays = rays / np.abs(rays).max(axis=1, keepdims=True)
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)
