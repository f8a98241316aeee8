"""Nets that lead back: no triangle is turned over on its way.

Where one is, points of the target lie in several triangles, and come back from the
wrong one, by metres and without a word. Two identical points that change places do it,
a gross error, or a sliver along the hull.

See docs/theory/triangulation.md.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.theory.adjustment.norms import RAYLEIGH_MEDIAN
from einschalt.theory.triangulation.triangle_net import (
    TriangleNet,
    delaunay_corners,
    doubled_areas,
)

# share of the usual change of area below which a triangle is as good as turned over
SMALLEST = 1e-3
# height over longest side of a triangle at the edge that may be left out for itself
SLENDER = 0.05
LEAST_POINTS = 20  # fewer do not tell how large deviations usually are


@dataclass(frozen=True, eq=False)
class ReversibleNet:
    """A net without triangles that are turned over, and what it cost."""

    net: TriangleNet
    n_turned: int  # triangles that were turned over at first
    # left_out: of int, places of points that are corners of no triangle, ascending
    left_out: np.ndarray
    deviations: np.ndarray  # (n_points,) of their shifts from those of neighbours [m]
    # contradicting: of int, places of those that were taken for gross errors
    contradicting: np.ndarray


def is_turned_over(source, target, corners):
    """Whether each triangle has the other orientation than most, or almost no area.

    Array of bool, (n_triangles,).
    """
    before, after = doubled_areas(source, corners), doubled_areas(target, corners)
    change = after / before
    usual = np.median(change) if len(change) else 1.0
    return ~(change / usual > SMALLEST)


def make_reversible_net(source, target, *, significance=None):
    """Triangulate identical points so that the way back leads back.

    Where a triangle is turned over, the one of its corners goes whose shift differs
    most from those of its neighbours, and the rest is triangulated again; slender
    triangles along the edge go for themselves. ``source``, ``target``: (n_points, 2)
    [m]. ``significance``: probability with which a set without gross errors loses a
    point that contradicts its neighbours; where left out, none goes for that.
    """
    whole = corners = delaunay_corners(source)
    deviations = shift_deviations(source, target, whole)
    rank = np.argsort(np.argsort(deviations, kind="stable"))  # no two are equal
    is_turned = is_turned_over(source, target, whole)
    contradicting = contradicting_points(deviations, significance)
    if len(contradicting):  # some have only wrong neighbours: the others decide
        trusted = np.ones(len(source), dtype=bool)
        trusted[contradicting] = False
        again = shift_deviations(source, target, whole, trusted)
        deviations = np.where(np.isfinite(again), again, deviations)
        contradicting = contradicting_points(deviations, significance)
        rank = np.argsort(np.argsort(deviations, kind="stable"))
    kept = np.setdiff1d(np.arange(len(source)), contradicting)
    if len(contradicting):
        corners = kept[delaunay_corners(source[kept])]
        is_turned = is_turned_over(source, target, corners)
    good = _without_slivers(source, corners, is_turned)
    bad = corners[good & is_turned]
    while len(bad):
        kept = np.setdiff1d(kept, _worst_corners(bad, rank))
        corners = kept[delaunay_corners(source[kept])]
        is_bad = is_turned_over(source, target, corners)
        good = _without_slivers(source, corners, is_bad)
        bad = corners[good & is_bad]
    net = TriangleNet(source, target, corners[good])
    return ReversibleNet(
        net,
        int(is_turned.sum()),
        np.setdiff1d(np.arange(len(source)), net.used),
        deviations,
        contradicting,
    )


def contradicting_points(deviations, significance):
    """Places of the points whose shift contradicts those of their neighbours.

    ``deviations`` as :func:`shift_deviations` gives them. Their size comes from the
    median, which gross errors hardly change; without these the largest of n exceeds
    σ √(2 ln(n / significance)) with the ``significance`` (Rayleigh, Bonferroni).
    """
    known = deviations[np.isfinite(deviations)]
    if significance is None or len(known) < LEAST_POINTS:
        return np.empty(0, dtype=np.intp)
    sigma = np.median(known) / RAYLEIGH_MEDIAN
    limit = sigma * np.sqrt(2.0 * np.log(len(known) / significance))
    return np.flatnonzero(np.isfinite(deviations) & (deviations > limit))


def _without_slivers(xy, corners, bad):
    """Which triangles stay when slender ones that are turned over at the edge go."""
    stays = np.ones(len(corners), dtype=bool)
    sides = xy[corners] - xy[np.roll(corners, 1, axis=1)]
    longest = (sides**2).sum(axis=2).max(axis=1)
    is_slender = bad & (np.abs(doubled_areas(xy, corners)) < SLENDER * longest)
    if not is_slender.any():
        return stays
    while True:
        going = stays & is_slender & _is_at_edge(corners, stays)
        if not going.any():
            return stays
        stays &= ~going


def _is_at_edge(corners, stays):
    """Whether a side of a triangle is a side of no other one."""
    ends = np.sort(np.stack([corners, np.roll(corners, 1, axis=1)], axis=2), axis=2)
    codes = ends[..., 0] * (corners.max(initial=0) + 1) + ends[..., 1]
    _, which, count = np.unique(codes[stays], return_inverse=True, return_counts=True)
    at_edge = np.zeros(len(corners), dtype=bool)
    at_edge[stays] = (count[which].reshape(-1, 3) == 1).any(axis=1)
    return at_edge


def _worst_corners(bad, rank):
    """Of each bad triangle the corner that deviates most, but no two of one."""
    of_worst = rank[bad].argmax(axis=1)[:, None] == np.arange(3)
    return np.setdiff1d(bad[of_worst], bad[~of_worst])


def shift_deviations(source, target, corners, trusted=None):
    """How far each shift is from the median one of the neighbours [m], (n_points,).

    Shifts are those that an affine transformation of all points, or of those that are
    trusted, leaves. Infinite for a
    point that is a corner of no triangle: it lies where another one is. ``trusted``: of
    bool, (n_points,), neighbours that count; infinite where a point has none.
    """
    fitted = np.ones(len(source), dtype=bool) if trusted is None else trusted
    shifts = target - _affine_of(fitted, source, target)
    beside = np.stack([corners, np.roll(corners, 1, axis=1)], axis=2).reshape(-1, 2)
    n_points = len(source)
    sides = np.concatenate([beside, beside[:, ::-1]]) @ np.array([n_points, 1])
    both = np.column_stack(np.divmod(np.unique(sides), max(n_points, 1)))
    if trusted is not None:
        both = both[trusted[both[:, 1]]]
    first = np.searchsorted(both[:, 0], np.arange(n_points))
    count = np.bincount(both[:, 0], minlength=n_points)
    known = np.flatnonzero(count)
    squares = np.zeros(len(known))
    for axis in range(2):
        values = shifts[both[:, 1], axis]
        ordered = values[np.lexsort([values, both[:, 0]])]
        low = first[known] + (count[known] - 1) // 2
        high = first[known] + count[known] // 2
        middle = (ordered[low] + ordered[high]) / 2.0
        squares += (shifts[known, axis] - middle) ** 2
    deviations = np.full(n_points, np.inf)
    deviations[known] = np.sqrt(squares)
    return deviations


def _affine_of(fitted, source, target):
    """Points of the source, brought to the target by one affine transformation.

    ``fitted``: of bool, those onto which it is fitted: a gross error would tilt it, and
    with it the shifts of all others.
    """
    centred = source - source[fitted].mean(axis=0)
    middle = target[fitted].mean(axis=0)
    scale = np.abs(centred).max() or 1.0
    design = centred / scale
    factors = np.linalg.lstsq(design[fitted], target[fitted] - middle, rcond=None)[0]
    return middle + design @ factors
