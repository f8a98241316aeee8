"""Some square patches of a large block, over the whole of it.

What is a mean over a block is known well enough from a part of it. Neighbours stay
together in a patch, so that what happens between them is as in the whole.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Patches:
    """Cells of a square grid, some of which are kept."""

    corner: np.ndarray  # (2,)
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
        corner, extent = xy.min(axis=0), np.ptp(xy, axis=0)
        share = of_patch / len(xy)
        # points on one line have no area
        side = max(np.sqrt(np.prod(extent) * share), extent.max() * share)
        cells = _cells(xy, corner, side)
        is_kept = np.zeros(cells.max(axis=0) + 1, dtype=bool)
        is_kept[tuple(cells.T)] = True
        filled = np.argwhere(is_kept)
        left_out = np.delete(filled, np.s_[::every], axis=0)
        is_kept[tuple(left_out.T)] = False
        return cls(corner, side, is_kept)

    def hold(self, xy):
        """Whether each point (n, 2) lies in a patch that is kept, ndarray of bool."""
        cells = _cells(xy, self.corner, self.side)
        is_inside = ((cells >= 0) & (cells < self.is_kept.shape)).all(axis=1)
        cells = np.where(is_inside[:, None], cells, 0)
        return is_inside & self.is_kept[tuple(cells.T)]


def _cells(xy, corner, side):
    return np.floor((xy - corner) / side).astype(np.int64)
