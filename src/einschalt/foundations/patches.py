"""Some patches of a large block, over the whole of it.

What is a mean over a block is known well enough from a part of it. Neighbours stay
together in a patch, so that what happens between them is as in the whole.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Patches:
    """Columns of as many points each, parted into cells of as many points each.

    By counting: a few points that lie far off, by a gross error, change no patch.
    """

    between_columns: np.ndarray  # (n - 1,): eastings that part them
    between_rows: np.ndarray  # (n, n - 1): northings that part each column
    every: int  # of that many cells one is kept

    @classmethod
    def over(cls, xy, of_patch, every):
        """Lay patches of at most ``of_patch`` points over some; keep one of ``every``.

        >>> across, along = np.divmod(np.arange(100), 10)
        >>> xy = np.column_stack([across, along]).astype(float)
        >>> patches = Patches.over(xy, of_patch=25, every=2)
        >>> int(patches.hold(xy).sum())
        50
        """
        # a multiple, so that exactly such a share of the cells is kept
        n = every * int(np.ceil(np.sqrt(len(xy) / of_patch) / every))
        shares = np.arange(1, n) / n
        between = np.quantile(xy[:, 0], shares)
        column = np.searchsorted(between, xy[:, 0])
        rows = np.zeros((n, n - 1))  # a column that has no point is none
        for one in np.unique(column):
            rows[one] = np.quantile(xy[column == one, 1], shares)
        return cls(between, rows, every)

    def hold(self, xy):
        """Whether each point (n, 2) lies in a patch that is kept, ndarray of bool."""
        column = np.searchsorted(self.between_columns, xy[:, 0])
        row = np.sum(self.between_rows[column] < xy[:, 1, None], axis=1)
        return (column + row) % self.every == 0
