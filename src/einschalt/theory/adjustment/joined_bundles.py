"""Bundles of numbers of several kinds, put together where the same points use them.

A spatial model that was formed from images has parameters of its transformation and
changes of its relative orientation, each a handful: its points use both. What such
points share is the covariance of one bundle that holds all of them.

See docs/theory/propagation.md.
"""

import numpy as np
from scipy import sparse

from einschalt.theory.adjustment.point_operator import Axes, PointOperator, sums

LEAST_SHARE = 0.5  # of the bundles of a kind that stand beside those of the first one


def joined_bundles(
    kinds: list[PointOperator], n_each: list[int]
) -> list[PointOperator | None]:
    """Put bundles of each kind beside those of the first kind that the same rows use.

    Which bundles stand together changes no covariance, only the time that it takes.

    Parameters
    ----------
    kinds : list of PointOperator
        One factor each, from bundles to rows of points.
    n_each : list of int
        How many points stand in a bundle of each kind.

    Returns
    -------
    list of PointOperator or None
        Of each kind, from its numbers to those of bundles that hold one of each kind;
        None where fewer than half of its bundles have one of the first kind beside
        them.
    """
    (first, *others), axes = kinds, kinds[0].axes
    known = _marks(first, n_each[0])
    places, n_bundles, is_joined = [np.arange(len(known))], len(known), [True]
    for one, n_of_one in zip(others, n_each[1:], strict=True):
        place = np.full(axes.count(one.shape[1]) // n_of_one, -1)
        if one.shape[0] == first.shape[0]:
            place = _beside(known, _marks(one, n_of_one))
        is_alone = place < 0
        is_joined.append(bool(np.mean(~is_alone) >= LEAST_SHARE))
        if is_joined[-1]:
            place[is_alone] = n_bundles + np.arange(np.count_nonzero(is_alone))
            n_bundles += np.count_nonzero(is_alone)
        places.append(place)
    widths = np.where(is_joined, n_each, 0)
    starts = np.cumsum(widths) - widths
    return [
        _onto(place, n, start, (n_bundles, int(widths.sum())), axes) if joins else None
        for place, n, start, joins in zip(
            places, n_each, starts, is_joined, strict=True
        )
    ]


def _marks(kind, n_together):
    """What tells bundles apart: a sum of numbers drawn for the rows that use them."""
    axes = kind.axes
    size = axes.value, axes.size(n_together)
    blocks = sparse.bsr_array(sparse.csr_array(kind.matrix), blocksize=size)
    blocks.sort_indices()
    drawn = np.random.default_rng(0).random(kind.n_points)
    of_entries = np.repeat(drawn, np.diff(blocks.indptr))
    n_bundles = blocks.shape[1] // size[1]
    return np.bincount(blocks.indices, of_entries, n_bundles)


def _beside(known, marks):
    """Place among known marks of each mark, -1 where there is none; each once."""
    both = np.concatenate([known, marks])
    alike = np.unique(both, return_inverse=True)[1].ravel()
    turn = np.concatenate([_turns(one) for one in np.split(alike, [len(known)])])
    alike = alike * (turn.max(initial=0) + 1) + turn
    of_known = np.full(alike.max(initial=-1) + 1, -1)
    of_known[alike[: len(known)]] = np.arange(len(known))
    return of_known[alike[len(known) :]]


def _turns(numbers):
    """How many equal ones stand before each number."""
    order = np.argsort(numbers, kind="stable")
    count = np.bincount(numbers)
    start = np.cumsum(count) - count
    turn = np.empty(len(numbers), dtype=np.int64)
    turn[order] = np.arange(len(numbers)) - start[numbers[order]]
    return turn


def _onto(places, n_together, start, shape, axes: Axes):
    """Operator that puts bundles in their places, from ``start`` on in each of them."""
    n_bundles, width = shape
    rows = width * places[:, None] + start + np.arange(n_together)
    order = np.argsort(rows, axis=None)
    is_used = np.bincount(rows.ravel(), minlength=n_bundles * width)
    pointer = np.append(0, np.cumsum(is_used))
    return sums(np.ones(rows.size), order, pointer, rows.size, axes)
