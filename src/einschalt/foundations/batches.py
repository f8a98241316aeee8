"""Long tables as segments per model: sorted once by code, summed without loops.

Rows that belong to one model form a *segment*; ``start`` holds the first row of each
segment and, at its end, the number of rows, so that segment k owns rows
``start[k]:start[k + 1]``.
"""

import os
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from einschalt.foundations.kernels import compiled

ROWS_WORTH_A_THREAD = 50_000
_of_thread = threading.local()


@dataclass(frozen=True, eq=False)
class Segments:
    """Rows sorted by group."""

    # (n_rows,): row numbers sorted by group, in their old order within a group
    order: np.ndarray
    start: np.ndarray  # (n_groups + 1,): where each group begins in the sorted order

    @property
    def count(self):
        """Number of rows of each group, ndarray of int64, shape (n_groups,)."""
        return np.diff(self.start)

    @property
    def group(self):
        """Group of each sorted row, ndarray of int64, shape (n_rows,)."""
        return np.repeat(np.arange(len(self.start) - 1), self.count)

    def rows_of(self, groups):
        """Rows of some groups one after the other, and where those of each begin.

        ``groups`` may stand several times; arrays of int64, shapes (n_rows,) and
        (n_groups + 1,).

        >>> rows, start = segments(np.array([1, 0, 1]), 2).rows_of([1, 0, 1])
        >>> rows.tolist(), start.tolist()
        ([0, 2, 1, 0, 2], [0, 2, 3, 5])
        """
        first, count = self.start[groups], self.count[groups]
        start = np.concatenate([[0], np.cumsum(count)])
        within = np.arange(start[-1]) - np.repeat(start[:-1], count)
        return self.order[np.repeat(first, count) + within], start


def segments(codes, n_groups) -> Segments:
    """Sort rows by their group code, 0 to ``n_groups - 1``, by counting.

    Groups without rows have an empty segment.

    >>> parts = segments(np.array([1, 0, 1]), 3)
    >>> parts.order.tolist(), parts.start.tolist()
    ([1, 0, 2], [0, 1, 3, 3])
    """
    codes = np.ascontiguousarray(codes, dtype=np.int64)
    start = np.zeros(n_groups + 1, dtype=np.int64)
    np.cumsum(np.bincount(codes, minlength=n_groups), out=start[1:])
    return Segments(_counting_sort(codes, start), start)


def segments_present(codes) -> Segments:
    """Sort rows by a code, 0 or any larger; codes that no row has make no segment.

    >>> parts = segments_present(np.array([7, 2, 7]))
    >>> parts.order.tolist(), parts.start.tolist()
    ([1, 0, 2], [0, 1, 3])
    """
    order = np.argsort(codes, kind="stable")
    is_last = np.diff(codes[order], append=-1) != 0
    return Segments(order, np.append(0, np.flatnonzero(is_last) + 1))


@compiled
def _counting_sort(codes, start):
    order = np.empty(codes.size, dtype=np.int64)
    place = start[:-1].copy()
    for row in range(codes.size):
        code = codes[row]
        order[place[code]] = row
        place[code] += 1
    return order


def segment_sum(values, start):
    """Sum of each segment, (n_segments, ...); 0 where a segment is empty.

    ``np.add.reduceat`` gives the value at the start, not 0, for an empty segment, and
    fails for a start beyond the last row; both are taken care of.
    """
    values = np.asarray(values)
    filled = np.diff(start) > 0
    if len(filled) and filled.all():
        return np.add.reduceat(values, start[:-1], axis=0, dtype=values.dtype)
    total = np.zeros((len(start) - 1, *values.shape[1:]), dtype=values.dtype)
    if filled.any():
        total[filled] = np.add.reduceat(values, start[:-1][filled], axis=0)
    return total


def segment_centred(values, start):
    """Values (n_rows, ...) less the mean of their segment."""
    count = np.diff(start)
    # an empty segment has no rows to take its mean from
    per_row = 1.0 * np.maximum(count, 1).reshape(-1, *[1] * (np.ndim(values) - 1))
    mean = segment_sum(values, start) / per_row
    return values - np.repeat(mean, count, axis=0)


def segment_min_max(values, start):
    """Smallest and largest value of each segment; NaN where a segment is empty."""
    values = np.asarray(values, dtype=float)
    smallest = np.full((len(start) - 1, *values.shape[1:]), np.nan)
    largest = smallest.copy()
    filled = np.diff(start) > 0
    if filled.any():
        first = start[:-1][filled]
        smallest[filled] = np.minimum.reduceat(values, first, axis=0)
        largest[filled] = np.maximum.reduceat(values, first, axis=0)
    return smallest, largest


def sum_by_group(group, values):
    """Sum of the complex rows of each group, 0 to its largest number.

    ``values`` has the shape (n_rows,) or (n_rows, n_columns).

    >>> sum_by_group(np.array([1, 0, 1]), np.array([1.0, 5.0, 2j])).tolist()
    [(5+0j), (1+2j)]
    """
    columns = values.reshape(len(values), -1).T
    sums = [
        np.bincount(group, c.real) + 1j * np.bincount(group, c.imag) for c in columns
    ]
    return np.stack(sums, axis=-1).reshape(-1, *values.shape[1:])


def numbered(places):
    """The places that are used, ascending, and where each stands among them.

    ``places`` are whole numbers of any shape, which the second array has as well. By
    counting, which is quicker than sorting unless few places lie far apart.

    >>> used, among = numbered(np.array([[7, 5], [9, 7]]))
    >>> used.tolist(), among.tolist()
    ([5, 7, 9], [[1, 0], [2, 1]])
    """
    if not places.size:
        return np.empty(0, dtype=np.int64), places
    first = places.min()
    n_between = places.max() - first + 1
    if n_between > places.size:
        used, among = np.unique(places, return_inverse=True)
        return used, among.reshape(places.shape)
    is_used = np.zeros(n_between, dtype=bool)
    is_used[places - first] = True
    return np.flatnonzero(is_used) + first, (np.cumsum(is_used) - 1)[places - first]


def used_places(places, n):
    """The places below ``n`` that are used, ascending.

    Of numbers about as many as ``n`` this takes a hundredth of ``np.unique``.

    >>> used_places(np.array([7, 5, 7]), 9).tolist()
    [5, 7]
    """
    is_used = np.zeros(n, dtype=bool)
    is_used[places] = True
    return np.flatnonzero(is_used)


def n_cores():
    """Count the processor cores that this process may use.

    At most ``EINSCHALT_CORES`` of the environment, where that is set: one of several
    processes then does not take the cores of the others. A thread of :func:`over_parts`
    has its share of them.
    """
    if (share := getattr(_of_thread, "n_cores", None)) is not None:
        return share
    granted = os.environ.get("EINSCHALT_CORES", "")
    if granted.isdecimal():
        return min(max(int(granted), 1), _n_own_cores())
    return _n_own_cores()


def _n_own_cores():
    if hasattr(os, "sched_getaffinity"):  # a scheduler may have left us only some
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def over_segments(kernel, start, *arrays, work_of_row=1.0):
    """Run a compiled kernel over all segments, on all cores where it pays.

    The kernel is called as ``kernel(first, last, start, *arrays)`` for ranges of
    segments and writes its results into the arrays. It must release the GIL
    (``nogil=True``). Each segment is computed whole by one thread, so the result does
    not depend on their number. ``work_of_row``: what a row takes, in numbers that are
    fetched and added, about; few rows that take long are worth a thread as well.

    Threads instead of numba's own parallel loops: those abort the process when it
    forks afterwards, or when two Python threads call them at once.
    """
    n_segments = len(start) - 1
    n_rows = int(start[-1]) if n_segments else 0
    # to ask for the cores takes longer than many a small kernel
    is_small = n_rows * work_of_row < ROWS_WORTH_A_THREAD
    if is_small or (n_workers := n_cores()) == 1:
        kernel(0, n_segments, start, *arrays)
        return
    # four ranges per worker even out models of different size
    edges = np.searchsorted(start, np.linspace(0, n_rows, 4 * n_workers + 1))
    edges[0], edges[-1] = 0, n_segments
    with ThreadPoolExecutor(n_workers) as pool:
        runs = [
            pool.submit(kernel, first, last, start, *arrays)
            for first, last in pairwise(edges.tolist())
            if last > first
        ]
        for run in runs:
            run.result()


def over_parts(work, parts, *, most_at_once=None):
    """Results of some work on each part, in their order, on all cores.

    For work that releases the GIL mostly, as products of sparse matrices do; it must
    not matter to a part which others there are. ``most_at_once``: where each part takes
    memory of its own.
    """
    with working_on_parts(min(len(parts), most_at_once or len(parts))) as results:
        return results(work, parts)


@contextmanager
def working_on_parts(most_at_once):
    """Give what does as :func:`over_parts`, again and again by the same threads.

    What is made for each thread anew, as transformations of PROJ, takes long.
    """
    n_workers = min(n_cores(), most_at_once)
    if n_workers <= 1:
        yield _one_by_one
        return
    share = n_cores() // n_workers
    with ThreadPoolExecutor(n_workers, initializer=_take, initargs=(share,)) as pool:

        def results(work, parts):
            if len(parts) == 1:  # here, with all cores
                return _one_by_one(work, parts)
            return list(pool.map(work, parts))

        yield results


def _one_by_one(work, parts):
    return [work(part) for part in parts]


def _take(share):
    """Let this thread have so many cores: more threads in it would wait for others."""
    _of_thread.n_cores = share
