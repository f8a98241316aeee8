"""Shifts at the nodes of a grid, linear along both axes of each cell between them.

What PROJ and all that is built on it reads as a GTG file: ``gridshift`` interpolates in
the same way. So the grid is the transformation, and not a likeness of it.

See docs/theory/collocation.md.
"""

from dataclasses import dataclass

import numpy as np

N_STEPS = 60
MARGIN = 3.0  # cells: points beside the known ones, and shifts on the way back
CLOSE = 1e-7  # metres: a way back that moves less has arrived
# share by which a cell may be strained: the way back of PROJ takes ten steps at most
MOST_STRAIN = 0.2


@dataclass(frozen=True, eq=False)
class ShiftGrid:
    """An affine transformation, and shifts on top of it.

    Row 0 is the northern one, as in an image.
    """

    # matrix, shift: the affine part, target = matrix · xy + shift
    matrix: np.ndarray
    shift: np.ndarray
    corner: np.ndarray  # (2,): easting and northing of the north-western node [m]
    cell: float  # metres
    # shifts: (n_rows, n_columns, 2), of single precision: easting, northing [m];
    # variances: (n_rows, n_columns), of each coordinate of a point there [m²]
    shifts: np.ndarray
    variances: np.ndarray
    # (2, 2): by which variances are multiplied to be those of easting and northing
    shape: np.ndarray

    @property
    def bounds(self):
        """West, south, east, north of the nodes [m]."""
        rows, columns = self.variances.shape
        west, north = self.corner
        far = west + (columns - 1) * self.cell, north - (rows - 1) * self.cell
        return west, far[1], far[0], north

    @property
    def nodes(self):
        """Places of all nodes, row by row, (n_rows · n_columns, 2)."""
        return node_places(self.corner, self.cell, self.variances.shape)

    def base(self, xy):
        """Points brought over by the affine part, (n, 2)."""
        return xy @ self.matrix.T + self.shift

    def apply(self, xy):
        """Target coordinates (n, 2) of points of the source; NaN outside the grid."""
        base = self.base(np.asarray(xy, dtype=float))
        return base + self.between(self.shifts, base)

    def invert(self, en):
        """Source coordinates (n, 2) of points of the target; NaN outside the grid."""
        en = np.asarray(en, dtype=float)
        base = en - self._near(en)
        for _ in range(N_STEPS):
            after = en - self.between(self.shifts, base)
            moved = np.abs(after - base)
            base = after
            if not np.any(moved > CLOSE):
                break
        return np.linalg.solve(self.matrix, (base - self.shift).T).T

    def _near(self, en):
        """Shift near a point of the target, which may lie just outside the grid."""
        west, south, east, north = self.bounds
        reach = np.abs(self.shifts).max(initial=0.0) + self.cell
        inside = np.clip(en, [west, south], [east, north])
        is_far = (np.abs(en - inside) > reach).any(axis=1)
        near = self.between(self.shifts, inside)
        near[is_far] = np.nan
        return near

    def covariances(self, xy):
        """Covariances (n, 2, 2) of new points [m²]; NaN outside the grid."""
        base = self.base(np.asarray(xy, dtype=float))
        return self.between(self.variances, base)[:, None, None] * self.shape

    def between(self, values, base):
        """Values of nodes, interpolated at places (n, 2); NaN outside the grid."""
        n_rows, n_columns = self.variances.shape
        place = (base - self.corner) / self.cell * [1.0, -1.0]
        with np.errstate(invalid="ignore"):
            inside = ((place >= 0.0) & (place <= [n_columns - 1, n_rows - 1])).all(1)
        place = np.where(inside[:, None], place, 0.0)
        cell = np.minimum(place.astype(np.int64), [n_columns - 2, n_rows - 2])
        (column, row), (east, south) = cell.T, (place - cell).T
        if values.ndim == 3:
            east, south = east[:, None], south[:, None]
        values = values.astype(float, copy=False)
        upper = (1.0 - east) * values[row, column] + east * values[row, column + 1]
        row = row + 1
        lower = (1.0 - east) * values[row, column] + east * values[row, column + 1]
        found = (1.0 - south) * upper + south * lower
        found[~inside] = np.nan
        return found

    def strained_cells(self):
        """Centres (n, 2) of cells in which shifts change too much to be undone [m]."""
        shifts = self.shifts.astype(float)
        along, across = np.diff(shifts, axis=1), np.diff(shifts, axis=0)
        too_much = MOST_STRAIN * self.cell
        along, across = (
            (np.hypot(*np.moveaxis(part, 2, 0)) > too_much) for part in (along, across)
        )
        is_bad = along[:-1] | along[1:] | across[:, :-1] | across[:, 1:]
        row, column = np.nonzero(is_bad)
        half = np.column_stack([column + 0.5, -(row + 0.5)])
        return self.corner + half * self.cell


def node_places(corner, cell, shape):
    """Places of the nodes of a grid, row by row, (n_rows · n_columns, 2) [m].

    >>> node_places(np.array([10.0, 50.0]), 5.0, (2, 2)).tolist()
    [[10.0, 50.0], [15.0, 50.0], [10.0, 45.0], [15.0, 45.0]]
    """
    row, column = np.indices(shape)
    return corner + cell * np.column_stack([column.ravel(), -row.ravel()])


def grid_layout(points, cell):
    """Corner and shape of a grid that holds points (n, 2), with MARGIN cells around.

    Its nodes lie at multiples of the cell.
    """
    low = np.floor(points.min(axis=0) / cell) - MARGIN
    high = np.ceil(points.max(axis=0) / cell) + MARGIN
    n_columns, n_rows = (high - low).astype(int) + 1
    return np.array([low[0], high[1]]) * cell, (int(n_rows), int(n_columns))
