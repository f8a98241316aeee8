"""Surfaces between heights: at the nodes of a lattice, as rasters have them, or not.

In a lattice they are interpolated in its cells: a mesh of triangles over the places
would take seconds, and tell no more. Where a corner of a cell has no height, in gaps
and between rows that are staggered, they are interpolated in triangles.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from einschalt.foundations.blas_threads import one_blas_thread

SAME_ROW = 3  # decimals of metres, of rasters that were written as lists
# of the distance to the next: so far places are shifted before triangles are spanned.
# Four on a circle, as turned rasters have everywhere, take Qhull ten times as long
SHIFT = 0.01
BEYOND = 0.5  # of its range a height lies at most, where a place is just outside
FLAT = 1e-6  # sine of an angle of a triangle without an extent
FLATTEST = 1e-6  # extent of places across over along a line: less is a line
SPARSEST = 0.25  # of the nodes have a height at least: else the places are scattered


@dataclass(frozen=True, eq=False)
class HeightLattice:
    """Heights by rows and columns."""

    east: np.ndarray  # (n_columns,): ascending [m]
    north: np.ndarray  # (n_rows,): ascending [m]
    height: np.ndarray  # (n_rows, n_columns): NaN where a node has none [m]

    @classmethod
    def of(cls, plane, height) -> "HeightLattice | None":
        """The lattice of places (n, 2), the lower height where one stands twice.

        None where they stand on none: in one line, scattered, or in turned rows.
        """
        plane = np.round(plane, SAME_ROW)
        east, column = np.unique(plane[:, 0], return_inverse=True)
        north, row = np.unique(plane[:, 1], return_inverse=True)
        n_nodes = len(east) * len(north)
        if min(len(east), len(north)) < 2 or len(plane) < SPARSEST * n_nodes:
            return None
        node = np.full((len(north), len(east)), np.inf)
        np.minimum.at(node, (row, column), height)
        node[np.isinf(node)] = np.nan
        return cls(east, north, node)

    def at(self, ground):
        """Height at places (n, 2), bilinear in whole cells; NaN beside all heights.

        In other cells on the planes of triangles between the heights around them.
        """
        found = self._in_cells(ground)
        is_open = np.isnan(found)
        if is_open.any() and self._around_gaps is not None:
            found[is_open] = self._around_gaps.at(ground[is_open])
        return found

    @cached_property
    def _around_gaps(self):
        """Triangles between the nodes at cells that are not whole; None of no such."""
        is_known = np.isfinite(self.height)
        is_whole = is_known[1:, 1:] & is_known[1:, :-1]
        is_whole &= is_known[:-1, 1:] & is_known[:-1, :-1]
        if is_whole.all():
            return None
        # beside the outer nodes no cell could be spanned
        at_whole = np.pad(is_whole, 1, constant_values=True)
        is_inner = at_whole[1:, 1:] & at_whole[1:, :-1]
        is_inner &= at_whole[:-1, 1:] & at_whole[:-1, :-1]
        row, column = np.nonzero(is_known & ~is_inner)
        plane = np.column_stack([self.east[column], self.north[row]])
        if not spans_a_surface(plane):
            return None
        spacing = float(min(np.diff(self.east).min(), np.diff(self.north).min()))
        return HeightTriangles.of(plane, self.height[row, column], spacing)

    def _in_cells(self, ground):
        column, right = _between(self.east, ground[:, 0])
        row, upper = _between(self.north, ground[:, 1])
        found = np.zeros(len(ground))
        for k, share_north in ((0, 1.0 - upper), (1, upper)):
            for i, share_east in ((0, 1.0 - right), (1, right)):
                share = share_north * share_east
                # a gap that has no part in a place leaves it known
                node = self.height[row + k, column + i]
                found += np.where(share == 0.0, 0.0, share * node)
        return found


@dataclass(frozen=True, eq=False)
class HeightTriangles:
    """Heights of scattered places, or of turned rows."""

    plane: np.ndarray  # (n, 2) [m]
    height: np.ndarray  # (n,) [m]
    mesh: object  # scipy's Delaunay, of the places nearly

    @classmethod
    def of(cls, plane, height, spacing) -> "HeightTriangles":
        """Span triangles between places (n, 2), ``spacing`` [m] apart."""
        from scipy.spatial import Delaunay  # noqa: PLC0415 - loaded when asked for

        shift = np.random.default_rng(0).uniform(-SHIFT, SHIFT, plane.shape)
        # of every triangle a small system is solved: threads of LAPACK that wait for a
        # core take a hundred times as long as one
        with one_blas_thread():
            mesh = Delaunay(plane + spacing * shift)
            _ = mesh.transform  # it is kept
        return cls(plane, height, mesh)

    def at(self, ground):
        """Height at places (n, 2) [m], on the plane of each triangle; NaN beside all.

        Hardly beyond the heights of its corners: at the border, triangles of shifted
        places may have corners in one line.
        """
        triangle = self.mesh.find_simplex(ground)
        corner, height = self._corners_of(triangle)
        shares = self._shares_in(triangle, ground)
        # where the same shares of the corners, as they were given, lie
        away = ground - (shares[..., None] * corner).sum(axis=1)
        first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
        doubled = _cross(first, second)
        is_flat = np.abs(doubled) <= FLAT * np.abs(first).max(1) * np.abs(second).max(1)
        doubled = np.where(is_flat, np.inf, doubled)
        found = (shares * height).sum(axis=1)
        found += _cross(away, second) / doubled * (height[:, 1] - height[:, 0])
        found += _cross(first, away) / doubled * (height[:, 2] - height[:, 0])
        low, high = height.min(axis=1), height.max(axis=1)
        beyond = BEYOND * (high - low)
        found = np.clip(found, low - beyond, high + beyond)
        return np.where(triangle >= 0, found, np.nan)

    def _corners_of(self, triangle):
        """Places (n, 3, 2) and heights (n, 3) of the corners of triangles [m]."""
        corner = self.mesh.simplices[triangle]
        return self.plane[corner], self.height[corner]

    def _shares_in(self, triangle, ground):
        """Shares (n, 3) of the corners of the shifted triangles in places (n, 2)."""
        turn = self.mesh.transform[triangle]
        shares = np.einsum("nij,nj->ni", turn[:, :2], ground - turn[:, 2])
        return np.column_stack([shares, 1.0 - shares.sum(axis=1)])


def spans_a_surface(plane) -> bool:
    """Whether places (n, 2) lie neither in one line nor in one point."""
    along, across = np.linalg.svd(plane - plane.mean(axis=0), compute_uv=False)
    return bool(across > FLATTEST * along)


def _cross(one, other):
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]


def _between(ticks, values):
    """The tick before each value, and how far it is from there to the next one.

    NaN where a value lies before the first tick or behind the last one.
    """
    before = np.searchsorted(ticks, values, side="right") - 1
    before = np.clip(before, 0, len(ticks) - 2)
    part = (values - ticks[before]) / (ticks[before + 1] - ticks[before])
    return before, np.where((part >= 0.0) & (part <= 1.0), part, np.nan)
