"""Many tests at once: probabilities adjusted so that chance does not add up.

What ``statsmodels.stats.multitest.multipletests`` does for one family of tests, done
for the families of all models at once, without a loop over them in Python. Importing
it takes 1.3 s, most of it scipy.stats, more than whole blocks take to be computed.

Source: Holm 1979; see docs/theory/reliability.md.
"""

import numpy as np

from einschalt.foundations.batches import segment_sum
from einschalt.foundations.kernels import compiled


def is_rejected_by_holm(p_values, significance, start=None):
    """Which tests are rejected, so that a family errs at all with a probability only.

    Parameters
    ----------
    p_values : ndarray, shape (n,)
        Sorted by family; NaN where nothing was tested.
    significance : float
        That probability.
    start : ndarray of int, shape (n_families + 1,), optional
        Family k owns rows ``start[k]:start[k + 1]``; all are one where left out.

    Returns
    -------
    ndarray of bool, shape (n,)

    Examples
    --------
    >>> is_rejected_by_holm([0.01, 0.04, 0.03], 0.05).tolist()
    [True, False, False]
    """
    p_values = np.asarray(p_values, dtype=float)
    if start is None:
        start = np.array([0, len(p_values)])
    # only what could be rejected is sorted: these are the smallest of their families,
    # and their ranks are the same among all
    candidates = np.where(p_values <= significance, p_values, np.nan)
    tests = _Ranked(candidates, start, count_tested(p_values, start))
    adjusted = (tests.n_tests - tests.rank) * tests.p_values
    _run_maximum(adjusted, tests.start)
    return tests.in_old_order(adjusted) <= significance


def bonferroni(p_values, n_tests=None):
    """Adjust the probabilities of one family by the number of its tests: min(n p, 1).

    ``n_tests`` is the size of the family, if ``p_values`` are only a part of it;
    otherwise the number of those that are not NaN. Reject what is at most α.

    >>> bonferroni(np.array([0.01, np.nan, 0.6])).tolist()
    [0.02, nan, 1.0]
    """
    p_values = np.asarray(p_values, dtype=float)
    if n_tests is None:
        n_tests = np.isfinite(p_values).sum()
    return np.minimum(n_tests * p_values, 1.0)


def any_significant(p_values, level, n_tests=None):
    """Whether the smallest probability of a family stands out of all its tests.

    ``level`` is the probability α that it does so by chance.

    >>> any_significant(np.array([0.004, 0.5, 0.7]), 0.01)
    False
    >>> any_significant(np.array([0.003, 0.5, 0.7]), 0.01)
    True
    """
    return bool((bonferroni(p_values, n_tests) <= level).any())


def count_tested(p_values, start):
    """Count the tests of each family, without those that are NaN."""
    return segment_sum(np.isfinite(p_values).astype(np.int64), start)


class _Ranked:
    """Probabilities sorted within their families, those that are NaN left out.

    Attributes
    ----------
    p_values : ndarray, shape (n_ranked,)
    rank, n_tests : ndarray of int, shape (n_ranked,)
        Rank from 0 within the family, and the size of the family.
    start : ndarray of int, shape (n_families + 1,)
    """

    def __init__(self, p_values, start, n_tests):
        self._n_all = len(p_values)
        rows = np.flatnonzero(np.isfinite(p_values))
        family = np.searchsorted(start, rows, side="right") - 1
        self._rows = rows[np.lexsort((p_values[rows], family))]
        self.p_values = np.asarray(p_values, dtype=float)[self._rows]
        self.start = np.searchsorted(family, np.arange(len(start)))
        self.rank = np.arange(len(rows)) - self.start[family]
        self.n_tests = n_tests[family]

    def in_old_order(self, values):
        """Bring values back to their rows, NaN in the others."""
        result = np.full(self._n_all, np.nan)
        result[self._rows] = values
        return result


@compiled
def _run_maximum(values, start):
    for k in range(len(start) - 1):
        for i in range(start[k] + 1, start[k + 1]):
            values[i] = max(values[i], values[i - 1])
