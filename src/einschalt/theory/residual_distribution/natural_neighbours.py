"""Natural-neighbour weights (Sibson 1981) of many points among scattered ones.

A point that were added to the Voronoi diagram would take a part of its cell from each
of its natural neighbours; the shares of its area are their weights. They reproduce
linear functions, depend on the near points alone, and need no parameter.

Beyond the convex hull the weights are undefined: there the nearest place of the hull
stands for the point, so that nothing is extrapolated.

See docs/theory/residual_distribution.md.
"""

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.spatial import ConvexHull, Delaunay, QhullError

from einschalt.foundations.kernels import compiled

# share of the size of a triangle below which a point lies on its corner or side
NEAR = 1e-9


class Mesh(NamedTuple):
    """Delaunay triangles of the known points, in units of their extent."""

    xy: np.ndarray  # (n_known, 2)
    corners: np.ndarray  # of int, (n_triangles, 3): anticlockwise
    # of int, (n_triangles, 3): triangle beyond the side opposite each corner, or -1
    beyond: np.ndarray
    centres: np.ndarray  # (n_triangles, 2): centres of the circumscribed circles


def natural_neighbour_weights(known_xy, point_xy):
    """Weights (n_points, n_known) of the known points; each row adds up to 1.

    No two known points are at the same place. Where all lie on one line, the weights
    are linear along it, and constant beyond its ends.

    Examples
    --------
    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> natural_neighbour_weights(square, np.array([[1.0, 1.0]])).toarray().round(12)
    array([[0.25, 0.25, 0.25, 0.25]])
    """
    middle = known_xy.mean(axis=0)
    extent = np.abs(known_xy - middle).max(initial=0.0) or 1.0
    known, points = (known_xy - middle) / extent, (point_xy - middle) / extent
    triangles = _triangles(known)
    if triangles is None:
        return _weights_along_line(known, points)
    mesh = Mesh(
        known,
        triangles.simplices.astype(np.int64),
        triangles.neighbors.astype(np.int64),
        _circumcentres(*(known[triangles.simplices[:, k]] for k in range(3))),
    )
    home = _home(triangles, points)
    is_outside = home < 0
    entries = _sibson_weights(mesh, points[~is_outside], home[~is_outside])
    inside = _as_rows(entries, np.flatnonzero(~is_outside), (len(points), len(known)))
    outside = np.flatnonzero(is_outside)
    entries = _weights_on_hull(known, triangles.convex_hull, points[outside])
    return inside + _as_rows(entries, outside, inside.shape)


def _triangles(known):
    if len(known) < 3:
        return None
    try:
        return Delaunay(known)
    except QhullError:  # all on one line
        return None


def _home(triangles, points):
    """Triangle of each point, -1 outside, where a search would look at all of them."""
    hull = ConvexHull(triangles.points)
    is_outside = np.zeros(len(points), dtype=bool)
    for east, north, offset in hull.equations:
        is_outside |= points[:, 0] * east + points[:, 1] * north + offset > NEAR
    home = np.full(len(points), -1, dtype=np.intp)
    home[~is_outside] = triangles.find_simplex(points[~is_outside])
    return home


def _as_rows(entries, places, shape):
    rows, columns, weights = entries
    return sparse.csr_array((weights, (places[rows], columns)), shape=shape)


def _weights_along_line(known, points):
    direction = np.linalg.svd(known - known.mean(axis=0))[2][0]
    along = known @ direction
    order = np.argsort(along, kind="stable")
    ends = np.stack([order[:-1], order[1:]], axis=1)
    if len(known) == 1:
        ends = np.array([[0, 0]])
    rows = np.arange(len(points))
    entries = _weights_on_hull(known, ends, points)
    return _as_rows(entries, rows, (len(points), len(known)))


def _weights_on_hull(known, sides, points):
    """Linear weights at the place of the nearest side that is nearest to each point."""
    start, step = known[sides[:, 0]], known[sides[:, 1]] - known[sides[:, 0]]
    square = np.maximum((step**2).sum(axis=1), np.finfo(float).tiny)
    share = np.empty(len(points))
    nearest = np.empty(len(points), dtype=np.int64)
    for place in np.array_split(np.arange(len(points)), 1 + len(points) // 4096):
        away = points[place, None] - start
        along = np.clip((away * step).sum(axis=2) / square, 0.0, 1.0)
        distance = ((away - along[..., None] * step) ** 2).sum(axis=2)
        nearest[place] = distance.argmin(axis=1)
        share[place] = along[np.arange(len(place)), nearest[place]]
    rows = np.repeat(np.arange(len(points)), 2)
    weights = np.stack([1.0 - share, share], axis=1)
    return rows, sides[nearest].ravel(), weights.ravel()


def _circumcentres(a, b, c):
    """Centres of the circles through three points each."""
    ab, ac = b - a, c - a
    double = 2.0 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
    ab2, ac2 = (ab**2).sum(axis=1), (ac**2).sum(axis=1)
    east = (ac[:, 1] * ab2 - ab[:, 1] * ac2) / double
    north = (ab[:, 0] * ac2 - ac[:, 0] * ab2) / double
    return a + np.stack([east, north], axis=1)


@compiled
def _sibson_weights(mesh, points, home):
    """Rows, columns and weights of all points that lie within the hull."""
    capacity = 8 * points.shape[0] + 16
    rows = np.empty(capacity, dtype=np.int64)
    columns = np.empty(capacity, dtype=np.int64)
    weights = np.empty(capacity)
    n_known, n_triangles = mesh.xy.shape[0], mesh.corners.shape[0]
    seen = np.full(n_triangles, -1, dtype=np.int64)
    cavity = np.empty(n_triangles, dtype=np.int64)
    is_near = np.zeros(n_known, dtype=np.bool_)
    near = np.empty(n_known, dtype=np.int64)
    area = np.zeros(n_known)
    first, last = np.empty((n_known, 2)), np.empty((n_known, 2))
    filled = 0
    for row in range(points.shape[0]):
        n_near = _at_corner_or_side(mesh, points[row], home[row], near, area)
        if n_near == 0:
            n_cavity = _find_cavity(mesh, points[row], home[row], seen, row, cavity)
            n_near = _steal(mesh, points[row], cavity[:n_cavity], (seen, row), first,
                            last, is_near, near, area)  # fmt: skip
        if filled + n_near > rows.size:
            rows, columns = _doubled(rows, n_near), _doubled(columns, n_near)
            weights = _doubled(weights, n_near)
        total = 0.0
        for place in range(n_near):
            total += area[near[place]]
        for place in range(n_near):
            rows[filled], columns[filled] = row, near[place]
            weights[filled] = area[near[place]] / total
            area[near[place]] = 0.0
            filled += 1
    return rows[:filled], columns[:filled], weights[:filled]


@compiled
def _doubled(array, more):
    longer = np.empty(2 * array.size + more, dtype=array.dtype)
    longer[: array.size] = array
    return longer


@compiled
def _at_corner_or_side(mesh, point, triangle, near, area):
    """Weights of a point on a corner or on the hull; 0 where it lies on neither."""
    corners = mesh.corners[triangle]
    size = 0.0
    for k in range(3):
        a, b = mesh.xy[corners[k]], mesh.xy[corners[(k + 1) % 3]]
        size = max(size, np.hypot(b[0] - a[0], b[1] - a[1]))
    for k in range(3):
        a = mesh.xy[corners[k]]
        if np.hypot(point[0] - a[0], point[1] - a[1]) <= NEAR * size:
            near[0] = corners[k]
            area[corners[k]] = 1.0
            return 1
    for k in range(3):
        if mesh.beyond[triangle, k] >= 0:
            continue
        one, two = corners[(k + 1) % 3], corners[(k + 2) % 3]
        a, step = mesh.xy[one], mesh.xy[two] - mesh.xy[one]
        length = np.hypot(step[0], step[1])
        away = point - a
        if abs(step[0] * away[1] - step[1] * away[0]) <= NEAR * size * length:
            share = (step[0] * away[0] + step[1] * away[1]) / length**2
            near[0], near[1] = one, two
            area[one], area[two] = 1.0 - share, share
            return 2
    return 0


@compiled
def _find_cavity(mesh, point, triangle, seen, mark, cavity):
    """Triangles whose circumscribed circle holds the point, from its own outwards."""
    cavity[0] = triangle
    seen[triangle] = mark
    n_cavity, place = 1, 0
    while place < n_cavity:
        for k in range(3):
            beyond = mesh.beyond[cavity[place], k]
            if beyond < 0 or seen[beyond] == mark:
                continue
            centre, corner = mesh.centres[beyond], mesh.xy[mesh.corners[beyond, 0]]
            radius = np.hypot(corner[0] - centre[0], corner[1] - centre[1])
            if np.hypot(point[0] - centre[0], point[1] - centre[1]) < radius:
                seen[beyond] = mark
                cavity[n_cavity] = beyond
                n_cavity += 1
        place += 1
    return n_cavity


@compiled
def _steal(mesh, point, cavity, marks, first, last, is_near, near, area):
    """Twice the areas that the point takes from its natural neighbours.

    The part of a neighbour is a polygon: the centres of the cavity's triangles around
    it, then the two centres that the point itself makes with the cavity's outline.
    Summed side by side, in any order.
    """
    seen, mark = marks
    n_near = 0
    for triangle in cavity:
        for k in range(3):
            one = mesh.corners[triangle, (k + 1) % 3]
            two = mesh.corners[triangle, (k + 2) % 3]
            centre = mesh.centres[triangle] - point
            beyond = mesh.beyond[triangle, k]
            if beyond >= 0 and seen[beyond] == mark:
                other = mesh.centres[beyond] - point
                area[two] += centre[0] * other[1] - centre[1] * other[0]
                continue
            other = _centre_with(point, mesh.xy[one], mesh.xy[two])
            first[one], last[two] = other, other
            area[one] += other[0] * centre[1] - other[1] * centre[0]
            area[two] += centre[0] * other[1] - centre[1] * other[0]
            if not is_near[one]:
                is_near[one] = True
                near[n_near] = one
                n_near += 1
    for place in range(n_near):
        name = near[place]
        is_near[name] = False
        area[name] += last[name, 0] * first[name, 1] - last[name, 1] * first[name, 0]
    return n_near


@compiled
def _centre_with(point, one, two):
    """Centre, from the point, of the circle through it and two others."""
    a, b = one - point, two - point
    double = 2.0 * (a[0] * b[1] - a[1] * b[0])
    a2, b2 = a[0] ** 2 + a[1] ** 2, b[0] ** 2 + b[1] ** 2
    return np.array(
        [(b[1] * a2 - a[1] * b2) / double, (a[0] * b2 - b[0] * a2) / double]
    )
