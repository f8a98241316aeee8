"""A net of triangles between two plane frames, linear in each of them.

Every corner goes exactly where it was measured, and every point within a triangle takes
its share of the three corners: continuous, with as simple an inverse, and what PROJ
calls ``tinshift``. Outside of the net nothing is defined.

See docs/theory/triangulation.md.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import Delaunay, QhullError

# share of the extent of the net within which a point on its edge is still in it
NEAR = 1e-9
FLATTEST = 1e-9  # area of a triangle over the square of its longest side


@dataclass(frozen=True, eq=False)
class TriangleNet:
    """Corners in two frames, and the triangles between them.

    Examples
    --------
    >>> source = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]])
    >>> net = TriangleNet(source, source + [10.0, 20.0], np.array([[0, 1, 2]]))
    >>> net.apply(np.array([[0.5, 0.5], [3.0, 3.0]])).tolist()
    [[10.5, 20.5], [nan, nan]]
    """

    # source, target: (n_points, 2), some of which may be corners of no triangle
    source: np.ndarray
    target: np.ndarray
    corners: np.ndarray  # of int, (n_triangles, 3)

    def apply(self, xy):
        """Target coordinates (n, 2) of points of the source; NaN outside the net."""
        return _interpolated(self._of_source, self.target, self.corners, xy)

    def invert(self, en):
        """Source coordinates (n, 2) of points of the target; NaN outside the net."""
        return _interpolated(self._of_target, self.source, self.corners, en)

    @property
    def used(self):
        """Places of the points that are corners of a triangle, ascending."""
        return np.unique(self.corners)

    @cached_property
    def _of_source(self):
        return _Finder(self.source, self.corners)

    @cached_property
    def _of_target(self):
        return _Finder(self.target, self.corners)


class _Finder:
    """Finds the triangle of each point, and its shares of the corners."""

    def __init__(self, xy, corners):
        # imported where points are to be found: the library takes its time
        import shapely  # noqa: PLC0415

        self.middle = xy[corners[:, 0]].mean(axis=0)
        self.corners = xy[corners] - self.middle
        self.slack = NEAR * np.abs(self.corners).max()
        self.tree = shapely.STRtree(shapely.polygons(self.corners))
        self.as_points = shapely.points

    def find(self, xy):
        """Triangle of each point, -1 outside."""
        places = np.full(len(xy), -1)
        known = np.flatnonzero(np.isfinite(xy).all(axis=1))
        asked = self.as_points(xy[known] - self.middle)
        points, triangles = self.tree.query(asked, predicate="intersects")
        # of two triangles beside an edge always the same one
        places[known[points[::-1]]] = triangles[::-1]
        lost = known[places[known] < 0]
        beside, triangles = self.tree.query_nearest(
            self.as_points(xy[lost] - self.middle),
            max_distance=self.slack,
            all_matches=False,
        )
        places[lost[beside]] = triangles
        return places

    def shares(self, xy, triangle):
        """Barycentric coordinates (n, 3) of points in their triangles."""
        first, second, third = np.moveaxis(self.corners[triangle], 1, 0)
        along, across, away = second - first, third - first, xy - self.middle - first
        area = _cross(along, across)
        of_second, of_third = _cross(away, across) / area, _cross(along, away) / area
        return np.column_stack([1.0 - of_second - of_third, of_second, of_third])


def _interpolated(finder, values, corners, xy):
    xy = np.asarray(xy, dtype=float)
    found = np.full((len(xy), 2), np.nan)
    triangle = finder.find(xy)
    inside = np.flatnonzero(triangle >= 0)
    shares = finder.shares(xy[inside], triangle[inside])
    of_corners = values[corners[triangle[inside]]]
    # about the first corner, so that large coordinates lose no digits
    base = of_corners[:, 0]
    found[inside] = base + np.einsum("nk,nkj->nj", shares, of_corners - base[:, None])
    return found


def _cross(one, two):
    return one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]


def doubled_areas(xy, corners):
    """Twice the area of each triangle, (n_triangles,): negative if clockwise."""
    first, second, third = np.moveaxis(xy[corners], 1, 0)
    return _cross(second - first, third - first)


def delaunay_corners(xy):
    """Corners (n_triangles, 3) of the Delaunay triangles of points.

    Without those that are a line but for the rounding. Points that lie where another
    one is are corners of none; no triangle where all points lie on one line.
    """
    centred = xy - xy.mean(axis=0) if len(xy) else xy
    none = np.empty((0, 3), dtype=np.int64)
    if len(xy) < 3:
        return none
    try:
        corners = Delaunay(centred).simplices.astype(np.int64)
    except QhullError:  # all on one line
        return none
    sides = centred[corners] - centred[np.roll(corners, 1, axis=1)]
    longest = (sides**2).sum(axis=2).max(axis=1)
    return corners[np.abs(doubled_areas(centred, corners)) > FLATTEST * longest]
