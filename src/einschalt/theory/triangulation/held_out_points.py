"""How well a net of triangles predicts identical points that it does not hold.

Each point is held out once, a tenth of them at a time, and predicted by the net of the
others: what a new point between them may expect. See docs/theory/triangulation.md.
"""

import numpy as np

from einschalt.theory.triangulation.triangle_net import TriangleNet, delaunay_corners

PARTS = 10
# points that are held out of large sets: their RMS is known to two per cent
ENOUGH = 2_000
SEED = 0  # which points are held out together must be the same in every run


def held_out_differences(source, target):
    """Predicted minus given coordinates of held-out points [m], shape (n_points, 2).

    NaN where a point lies outside the net of the others, and for those of a large set
    that were not held out. ``source``, ``target``: (n_points, 2).
    """
    n_points = len(source)
    differences = np.full((n_points, 2), np.nan)
    order = np.random.default_rng(SEED).permutation(n_points)
    parts = np.array_split(order, min(PARTS, max(n_points, 1)))
    n_held = 0
    for part in parts:
        if n_held >= ENOUGH:
            break
        others = np.setdiff1d(np.arange(n_points), part)
        corners = delaunay_corners(source[others])
        if len(corners):
            net = TriangleNet(source[others], target[others], corners)
            differences[part] = net.apply(source[part]) - target[part]
        n_held += len(part)
    return differences
