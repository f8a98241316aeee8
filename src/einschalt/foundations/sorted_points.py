"""Points of many models, or of many pairs, that are sorted by them."""

import numpy as np

from einschalt.foundations.batches import segment_sum


class SortedPoints:
    """Rows of which model (or pair) k owns ``start[k]:start[k + 1]``.

    A class of its own says in ``_taken(rows, start, models)`` what its rows are.
    """

    @property
    def model(self):
        """Model of each row, ndarray of int, shape (n,)."""
        return np.repeat(np.arange(len(self.start) - 1), np.diff(self.start))

    def chosen(self, is_chosen):
        """Some of the rows, with all models, of which some may be left empty."""
        count = segment_sum(np.asarray(is_chosen).astype(np.int64), self.start)
        return self._taken(is_chosen, np.concatenate([[0], np.cumsum(count)]))

    def of_models(self, models):
        """Rows of some models (numbers ascending), and their points, numbered anew."""
        is_wanted = np.zeros(len(self.start) - 1, dtype=bool)
        is_wanted[models] = True
        rows = np.flatnonzero(is_wanted[self.model])
        start = np.concatenate([[0], np.cumsum(np.diff(self.start)[is_wanted])])
        return rows, self._taken(rows, start, is_wanted)
