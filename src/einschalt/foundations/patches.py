"""Some square patches of a large block, over the whole of it.

What is a mean over a block is known well enough from a part of it. Neighbours stay
together in a patch, so that what happens between them is as in the whole.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Patches:
    """Cells of a square grid, some of which are kept."""

    corners: np.ndarray  # (2, 2): the lower left one and the upper right one of all
    side: float
    is_kept: np.ndarray  # (n_columns, n_rows)

    @classmethod
    def over(cls, xy, of_patch, every):
        """Lay patches of about ``of_patch`` points over some; keep one of ``every``.

        >>> across, along = np.divmod(np.arange(100), 10)
        >>> xy = np.column_stack([across, along]).astype(float)
        >>> patches = Patches.over(xy, of_patch=25, every=2)
        >>> int(patches.hold(xy).sum())
        50
        """
        corners = np.array([xy.min(axis=0), xy.max(axis=0)])
        extent, share = corners[1] - corners[0], of_patch / len(xy)
        # points on one line have no area
        side = max(np.sqrt(np.prod(extent) * share), extent.max() * share) or 1.0
        is_kept = np.zeros(np.maximum(np.ceil(extent / side), 1).astype(int), bool)
        every_cell = cls(corners, side, is_kept)
        is_kept[tuple(every_cell._cells(xy).T)] = True
        left_out = np.delete(np.argwhere(is_kept), np.s_[::every], axis=0)
        is_kept[tuple(left_out.T)] = False
        return every_cell

    def hold(self, xy):
        """Whether each point (n, 2) lies in a patch that is kept, ndarray of bool."""
        low, high = self.corners
        is_inside = ((xy >= low) & (xy <= high)).all(axis=1)
        cells = self._cells(np.where(is_inside[:, None], xy, low))
        return is_inside & self.is_kept[tuple(cells.T)]

    def _cells(self, xy):
        """Column and row of points; those at the far ends belong to the last ones."""
        cells = np.floor((xy - self.corners[0]) / self.side).astype(np.int64)
        return np.minimum(cells, np.array(self.is_kept.shape) - 1)
