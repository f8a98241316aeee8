"""Regions of given points that a scan for displaced ones tries.

Source: Kulldorff 1997, A spatial scan statistic.
"""

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

FEWEST_POINTS = 5  # of a region, and outside it
SIZE_STEP = 1.25  # from one size of regions to the next
PLACES_PER_SIZE = 8  # regions of a size that hold the same point, on the average
N_DIRECTIONS = 8  # of lines that part the points
# in each: a line that leaves out a row of points hides a part whose edge is a seam
MOST_LINES = 200
MOST_TRIED = 2000  # round regions in all
# bands between two lines, in blocks where they are more than a few rows of points wide
BANDS_FROM, NARROWEST_BAND = 300, 1.0 / 12.0


def regions_of(xy):
    """Round regions all over some points, all on one side of lines, and bands.

    Of all sizes; sparse, (n_regions, n): 1 where a point is in it. Where that is more
    than half of them the others are. So that there are not too many the smallest are
    left out in a large block, and large ones are tried in fewer places.
    """
    n = len(xy)
    sizes, n_places = _sizes(n)
    centres = _spread(xy, max(n_places))
    tree = cKDTree(xy)
    found = [
        _smaller_parts(tree.query(xy[centres[:n_here]], size)[1], n)
        for size, n_here in zip(sizes, n_places, strict=True)
    ]
    return sparse.vstack([*found, *_sides(xy, sizes)], format="csr")


def _smaller_parts(inside, n):
    """Regions of points ``inside``, (n_regions, size), or of the others: sparse."""
    n_regions, size = inside.shape
    if 2 * size <= n:
        pointer = np.arange(n_regions + 1) * size
        entries = np.ones(inside.size), inside.ravel(), pointer
        return sparse.csr_array(entries, shape=(n_regions, n))
    others = np.ones((n_regions, n))
    np.put_along_axis(others, inside, 0.0, axis=1)
    return sparse.csr_array(others)


def _sides(xy, sizes):
    """Points on one side of lines in many directions, or between two of them.

    ``sizes`` are those of bands; lines are everywhere.
    """
    offset = xy - xy.mean(axis=0)
    angle = np.arange(N_DIRECTIONS) * np.pi / N_DIRECTIONS
    along = offset @ np.stack([np.cos(angle), np.sin(angle)])
    order = np.argsort(along, axis=0, kind="stable").T
    n = len(xy)
    parts = range(FEWEST_POINTS, n - FEWEST_POINTS + 1, -(-n // MOST_LINES))
    sides = [_smaller_parts(order[:, :size], n) for size in parts]
    return [*sides, *_bands(order, sizes)]


def _bands(order, sizes):
    """Points between two parallel lines, half a band apart from one to the next."""
    n = order.shape[1]
    if n < BANDS_FROM:
        return []
    return [
        _smaller_parts(order[:, first : first + size], n)
        for size in sizes
        if NARROWEST_BAND * n <= size <= n / 2
        for first in range(size // 2, n - size, size // 2)
    ]


def _sizes(n):
    """Numbers of points of regions, and in how many places each is tried."""
    sizes = [FEWEST_POINTS]
    while (size := max(int(SIZE_STEP * sizes[-1]), sizes[-1] + 1)) <= n - FEWEST_POINTS:
        sizes.append(size)
    smaller = np.minimum(sizes, n - np.array(sizes))
    n_places = np.minimum(-(-PLACES_PER_SIZE * n // smaller), n)
    # the smallest are the most
    order = np.argsort(-smaller, kind="stable")
    is_tried = np.zeros(len(sizes), dtype=bool)
    is_tried[order[np.cumsum(n_places[order]) <= MOST_TRIED]] = True
    return np.array(sizes)[is_tried], n_places[is_tried]


def _spread(xy, n_wanted):
    """Points that are spread over all, the first of them as evenly as can be."""
    chosen = np.empty(n_wanted, dtype=np.int64)
    apart = np.sum((xy - xy.mean(axis=0)) ** 2, axis=1)
    place = int(np.argmin(apart))
    apart = np.full(len(xy), np.inf)
    for k in range(n_wanted):
        chosen[k] = place
        apart = np.minimum(apart, np.sum((xy - xy[place]) ** 2, axis=1))
        place = int(np.argmax(apart))
    return chosen
