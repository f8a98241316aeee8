"""Convex hulls of many groups of points, in one sweep."""

import numba
import numpy as np


def convex_hulls(xy, start):
    """Outline each segment of points by its convex hull.

    Andrew's monotone chain: the points of a segment are sorted by x, then y, and the
    lower and the upper chain are walked, dropping every point that does not turn left.

    Parameters
    ----------
    xy : ndarray, shape (n_points, 2)
        Sorted by segment.
    start : ndarray of int64, shape (n_segments + 1,)
        First row of each segment.

    Returns
    -------
    vertices : ndarray of int64, shape (n_vertices,)
        Rows of ``xy``, anticlockwise from the westernmost, the hulls one after another.
    hull_start : ndarray of int64, shape (n_segments + 1,)
        First vertex of each hull. Points on a line, or equal points, leave two.

    Examples
    --------
    >>> square = np.array([[0, 0], [2, 0], [1, 1], [2, 2], [0, 2.0]])
    >>> vertices, hull_start = convex_hulls(square, np.array([0, 5]))
    >>> vertices.tolist(), hull_start.tolist()
    ([0, 1, 3, 4], [0, 4])
    """
    xy = np.ascontiguousarray(xy, dtype=float)
    start = np.ascontiguousarray(start, dtype=np.int64)
    segment = np.repeat(np.arange(len(start) - 1), np.diff(start))
    order = np.lexsort((xy[:, 1], xy[:, 0], segment))
    return _chains(xy, order, start)


@numba.njit(cache=True, nogil=True)
def _chains(xy, order, start):
    n_segments = start.size - 1
    vertices = np.empty(order.size, dtype=np.int64)
    chain = np.empty(2 * order.size + 2, dtype=np.int64)
    hull_start = np.zeros(n_segments + 1, dtype=np.int64)
    n_vertices = 0
    for segment in range(n_segments):
        first, last = start[segment], start[segment + 1]
        size = 0
        for place in range(first, last):  # lower chain, west to east
            size = _extend(chain, size, 0, order[place], xy)
        bottom = size - 1
        for place in range(last - 2, first - 1, -1):  # upper chain, back again
            size = _extend(chain, size, bottom, order[place], xy)
        size = max(size - 1, min(last - first, 1))  # the chain ends where it began
        vertices[n_vertices : n_vertices + size] = chain[:size]
        n_vertices += size
        hull_start[segment + 1] = n_vertices
    return vertices[:n_vertices].copy(), hull_start


@numba.njit(cache=True, nogil=True)
def _extend(chain, size, bottom, row, xy):
    """Put a point on the chain; drop before it what does not turn left."""
    while size - bottom >= 2:
        a, b = chain[size - 2], chain[size - 1]
        turn = (xy[b, 0] - xy[a, 0]) * (xy[row, 1] - xy[a, 1]) - (
            xy[b, 1] - xy[a, 1]
        ) * (xy[row, 0] - xy[a, 0])
        if turn > 0:
            break
        size -= 1
    chain[size] = row
    return size + 1
