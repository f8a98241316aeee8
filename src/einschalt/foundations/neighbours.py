"""Which scattered points are neighbours."""

import numpy as np
from scipy.spatial import Delaunay, QhullError

MANY = 20_000  # points from which compiled code is worth its start


def neighbour_pairs(xy):
    """Pairs of points without a third one in the circle over their distance.

    The sides of Delaunay triangles at which no obtuse angle looks (Gabriel and Sokal
    1969, Systematic Zoology 18): the long sides along the hull fall out. Of points on
    one line, those that follow each other.

    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.1], [0.0, 2.0], [1.0, 1.0]])
    >>> neighbour_pairs(square).tolist()
    [[0, 1], [0, 3], [0, 4], [1, 4], [2, 3], [2, 4], [3, 4]]
    """
    if len(xy) < 2:
        return np.empty((0, 2), dtype=np.int64)
    reduced = xy - xy.mean(axis=0)
    if len(xy) >= MANY and np.isfinite(reduced).all():
        # compiled code takes its time to load
        from einschalt.foundations import neighbours_by_cells  # noqa: PLC0415

        found = neighbours_by_cells.pairs_by_cells(reduced, triangulated_pairs)
        if found is not None:
            return found
    return triangulated_pairs(reduced)


def triangulated_pairs(reduced):
    """Pairs of neighbours as the sides of triangles, of points reduced to their mean.

    Where other points lie on the circle of a pair, their rounding decides.
    """
    try:
        corners = Delaunay(reduced).simplices.astype(np.int64)
    except (QhullError, ValueError):  # on one line, or fewer than three
        return _along_line(reduced)
    sides, is_obtuse = [], []
    for apex in range(3):
        ends = np.delete(corners, apex, axis=1)
        arms = reduced[ends] - reduced[corners[:, apex], None]
        sides.append(np.sort(ends, axis=1))
        is_obtuse.append(np.sum(arms[:, 0] * arms[:, 1], axis=1) < 0.0)
    first, second = np.concatenate(sides).T
    sides, place = np.unique(first * len(reduced) + second, return_inverse=True)
    n_obtuse = np.bincount(place, np.concatenate(is_obtuse))
    return np.column_stack(np.divmod(sides[n_obtuse == 0], len(reduced)))


def _along_line(xy):
    axis = np.argmax(np.ptp(xy, axis=0))
    order = np.argsort(xy[:, axis], kind="stable")
    pairs = np.sort(np.column_stack([order[:-1], order[1:]]), axis=1)
    return pairs[np.lexsort(pairs.T[::-1])]
