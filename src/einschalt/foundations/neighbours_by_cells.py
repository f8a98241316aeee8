"""Neighbours of many scattered points, looked for in the cells around each.

Two points are neighbours if no third one lies in the circle over their distance. A
point r shuts off from p all that lies beyond the line through r at right angles to pr:
where points are in every direction, a few rings of cells around p hold all of its
neighbours. The others, along the hull, are few; pairs of them are looked for in their
triangulation, and held against all points.
"""

import numpy as np
from scipy.spatial import cKDTree

from einschalt.foundations.batches import over_segments, segments
from einschalt.foundations.kernels import compiled

POINTS_PER_CELL = 1.0
MOST_RINGS, MOST_NEAR = 10, 640
N_SECTORS = 8  # of 45°: what lies in one reaches at most √2 times as far as its nearest
MOST_NEIGHBOURS = 24
# of the distances: a point that lies on a circle but for that decides by its rounding
ON_CIRCLE = 1e-9
# of the extent: nearer to each other points are one in a triangulation
TOO_NEAR = 1e-7
ENCLOSED, AT_HULL, UNTOLD = 1, 2, 3  # what is known of a point and its neighbours


def pairs_by_cells(xy, among_few):
    """Pairs of neighbours, (n_pairs, 2) in their order; None where rounding decides.

    ``xy`` (n_points, 2) are reduced to their mean; ``among_few`` gives the pairs of a
    few points that are neighbours but for the other points.
    """
    found = _near_pairs(xy)
    if found is None:
        return None
    pairs, at_hull = found
    if len(at_hull) > len(xy) // 4:  # a strip, or clusters: nothing is gained
        return None
    if len(at_hull) > 1:
        beside = at_hull[among_few(xy[at_hull])]
        is_free = _are_free(xy, beside)
        if is_free is None:
            return None
        pairs = np.concatenate([pairs, beside[is_free]])
    keys = np.sort(pairs[:, 0] * len(xy) + pairs[:, 1])
    return np.column_stack(np.divmod(keys, len(xy)))


def _near_pairs(xy):
    """Pairs of which one point is enclosed by others, and the points that are not."""
    least, extent = xy.min(axis=0), np.ptp(xy, axis=0)
    size = np.sqrt(np.prod(extent) * POINTS_PER_CELL / len(xy))
    if not size > 0.0 or (extent / size).max() > len(xy):
        return None
    n_cells = (extent // size).astype(np.int64) + 1
    cell = np.minimum(((xy - least) // size).astype(np.int64), n_cells - 1)
    by_cell = segments(cell[:, 1] * n_cells[0] + cell[:, 0], int(n_cells.prod()))
    places = np.ascontiguousarray(xy[by_cell.order])
    held = np.zeros((len(xy), MOST_NEIGHBOURS), dtype=np.int64)
    count, state = np.zeros(len(xy), dtype=np.int64), np.zeros(len(xy), dtype=np.int64)
    too_near = TOO_NEAR * extent.max()
    over_segments(
        *(_look_around, by_cell.start, places, cell[by_cell.order], n_cells),
        *(size, too_near**2, held, count, state),
        work_of_row=1000.0,
    )
    if (state == UNTOLD).any():
        return None
    rows = np.repeat(np.arange(len(xy)), count)
    others = held[np.arange(MOST_NEIGHBOURS) < count[:, None]]
    # a pair of two enclosed points is found from both: from the first one it counts
    counts = (rows < others) | (state[others] == AT_HULL)
    ends = by_cell.order[np.column_stack([rows, others])[counts]]
    return np.sort(ends, axis=1), np.sort(by_cell.order[state == AT_HULL])


def _are_free(xy, pairs):
    """Whether no point lies in the circle of each pair; None where one is on it."""
    middle = xy[pairs].mean(axis=1)
    radius = 0.5 * np.hypot(*(xy[pairs[:, 1]] - xy[pairs[:, 0]]).T)
    near = cKDTree(xy).query(middle, k=3)[0]
    # where none is inside, the ends are the first two
    is_free = near[:, 0] > (1.0 - ON_CIRCLE) * radius
    is_on_circle = near[:, 2] < (1.0 + ON_CIRCLE) * radius
    return None if (is_free & is_on_circle).any() else is_free


@compiled
def _look_around(
    first, last, start, xy, cell, n_cells, size, least, held, count, state
):
    near = np.empty(MOST_NEAR, dtype=np.int64)
    at = np.empty((3, MOST_NEAR))  # from p to those: x, y, square of the distance
    nearest = np.empty(N_SECTORS)
    for p in range(start[first], start[last]):
        nearest[:] = np.inf
        n_near, n_seen, state[p] = 0, 0, AT_HULL
        for ring in range(MOST_RINGS + 1):
            n_near = _see_ring(p, ring, start, xy, cell, n_cells, near, at, n_near)
            if n_near > MOST_NEAR:
                state[p] = UNTOLD
                break
            for k in range(n_seen, n_near):
                x, y = at[0, k], at[1, k]
                sector = 4 * (x > 0.0) + 2 * (y > 0.0) + (abs(x) > abs(y))
                nearest[sector] = min(nearest[sector], at[2, k])
            n_seen = n_near
            if nearest.min() <= least:
                state[p] = UNTOLD
                break
            # all that is nearer than the side of a cell for each ring has been seen
            if 2.0 * nearest.max() <= (ring * size) ** 2:
                state[p] = _choose(p, near, at, n_near, nearest.max(), held, count)
                break


@compiled
def _see_ring(p, ring, start, xy, cell, n_cells, near, at, n_near):
    for row in range(cell[p, 1] - ring, cell[p, 1] + ring + 1):
        if row < 0 or row >= n_cells[1]:
            continue
        is_side = row == cell[p, 1] - ring or row == cell[p, 1] + ring
        step = 1 if is_side else max(2 * ring, 1)
        for column in range(cell[p, 0] - ring, cell[p, 0] + ring + 1, step):
            if column < 0 or column >= n_cells[0]:
                continue
            place = row * n_cells[0] + column
            for q in range(start[place], start[place + 1]):
                if q == p:
                    continue
                if n_near == MOST_NEAR:
                    return n_near + 1
                x, y = xy[q, 0] - xy[p, 0], xy[q, 1] - xy[p, 1]
                near[n_near] = q
                at[0, n_near], at[1, n_near], at[2, n_near] = x, y, x * x + y * y
                n_near += 1
    return n_near


@compiled
def _choose(p, near, at, n_near, farthest, held, count):
    reach = 2.0 * farthest * (1.0 + ON_CIRCLE)
    n_in_reach = 0
    for k in range(n_near):  # what shuts a point off is nearer than it
        if at[2, k] <= reach:
            near[n_in_reach] = near[k]
            for axis in range(3):
                at[axis, n_in_reach] = at[axis, k]
            n_in_reach += 1
    for q in range(n_in_reach):
        x, y, limit = at[0, q], at[1, q], ON_CIRCLE * at[2, q]
        is_free, is_on_circle = True, False
        for r in range(n_in_reach):
            # of the sides from r to p and q: negative inside of the circle
            product = at[2, r] - at[0, r] * x - at[1, r] * y
            if product < -limit:
                is_free = False
                break
            if product <= limit and r != q:
                is_on_circle = True
        if not is_free:
            continue
        if is_on_circle or count[p] == MOST_NEIGHBOURS:
            return UNTOLD
        held[p, count[p]] = near[q]
        count[p] += 1
    return ENCLOSED
