"""Whether given points of a region are displaced together, all by the same vector.

In an adjustment of everything with the given points as observations the scores u
(weight times correction) have the covariance W, and W p d more where the points of a
region p lie off by d. So d is estimated by pᵀu / pᵀWp, and T = |pᵀu|² / pᵀWp is χ² with
two degrees of freedom without a displacement. Round regions everywhere and of all sizes
are tried (a scan); the probability of the clearest is that of all together
(Bonferroni). What the scan finds is no region where errors are only larger than stated,
nor where neighbours are alike everywhere:

- T against the scatter of the scores around, once the region is taken out;
- what is left must show neither a further region nor any smooth pattern.

Sources: Kulldorff 1997, A spatial scan statistic; Teunissen 2006, Testing theory. See
docs/theory/claim.md.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from einschalt.theory.adjustment.significance import (
    FINDING_SIGNIFICANCE,
    SYSTEMATIC_SIGNIFICANCE,
)
from einschalt.theory.adjustment.smooth_pattern import smooth_pattern

FEWEST_POINTS = 5  # of a region, and outside it
SIZE_STEP = 1.25  # from one size of regions to the next
PLACES_PER_SIZE = 8  # regions of a size that hold the same point, on the average
N_DIRECTIONS = 8  # of lines that part the points
AT_ONCE = 256
# that tell what is known of a region: half of it, or twice as much, at the worst
N_DRAWS = 64
# χ² from which a region is looked at: by draws it may be twice as large
LOOKED_AT = 11.0
MOST_TRIED = 2000  # regions in all
MOST_AROUND = 250  # points in and around a region that are looked at together
MOST_ROUNDS = 6  # in which a region grows or shrinks by a row of points
LEAST_RANK = 1e-6
# of the weights of a region: what is known less of it is rounding
LEAST_INFORMATION = 1e-6
# χ² that a point must add, so that it is taken into a region or out of it
LEAST_GAIN = 3.0
# regions to begin with, and what two of them share at most
MOST_STARTS, MOST_SHARED = 8, 0.7


@dataclass(frozen=True, eq=False)
class DisplacedRegion:
    """Points that are displaced against all others."""

    rows: np.ndarray  # of the given points, ascending
    shift: np.ndarray  # (2,): how far they are off [m]
    standard_error: float  # of each coordinate of the shift [m]
    p_value: float  # of all regions that were tried together


def find_displaced_region(checks, weights, xy) -> DisplacedRegion | None:
    """Find a region whose points are displaced, all by the same vector.

    Parameters
    ----------
    checks
        ``scores``, complex (n,): weight times correction of each given point in an
        adjustment of everything, east + i north [1/m]; ``times(columns)``, the
        information W times columns, (n, n_columns), sparse or dense [1/m²];
        ``draw(n_draws, seed)``, scores of errors as they are stated, (n, n_draws).
    weights : ndarray, shape (n,)
        Of the given points [1/m²].
    xy : ndarray, shape (n, 2)
        Easting, northing [m].

    Returns
    -------
    DisplacedRegion or None
        The smaller part: nothing tells it from a displacement of all others. None where
        chance, larger errors, a smooth pattern or several regions explain the scores.
    """
    if len(xy) < 2 * FEWEST_POINTS:
        return None
    scan = _Scan(checks, weights, xy)
    worst = scan.worst()
    if worst.p_value > FINDING_SIGNIFICANCE:
        return None
    found = [scan.refined(start) for start in scan.starts()]
    region = max(found, key=lambda each: each.worth)
    region = replace(region, certain=max(each.certain for each in found))
    around = _Around(scan, region)
    scan.take_out(region)
    if (
        around.tail() > SYSTEMATIC_SIGNIFICANCE
        or scan.worst().p_value <= SYSTEMATIC_SIGNIFICANCE
        or around.smoothness() <= SYSTEMATIC_SIGNIFICANCE
    ):
        return None
    return region.told(worst.p_value)


@dataclass(frozen=True, eq=False)
class _Tried:
    """One of the regions that were tried."""

    members: np.ndarray  # rows
    square: float  # χ²
    p_value: float  # of all together


@dataclass(frozen=True, eq=False)
class _Region:
    """A region with the points that belong to it, and what the scores say of it."""

    rows: np.ndarray
    shown: np.ndarray  # complex (n,): W p
    information: float  # pᵀ W p
    amplitude: complex
    # χ² of it, and what of that is beyond the choice of single points
    square: float
    certain: float
    worth: float  # χ² less what its single points had to add at least

    def told(self, p_value):
        """What is known of it."""
        shift = np.array([self.amplitude.real, self.amplitude.imag])
        error = float(self.information**-0.5)
        return DisplacedRegion(self.rows, shift, error, float(p_value))


class _Scan:
    """Scores, and what is known of regions by them."""

    def __init__(self, checks, weights, xy):
        self.scores, self.times, self.xy = checks.scores, checks.times, xy
        self.regions = regions_of(xy)
        drawn = self.regions @ checks.draw(N_DRAWS, seed=0)
        n_parts = 2 if np.iscomplexobj(drawn) else 1
        # as much as it is known of by draws, until it looks as if it were displaced
        self.information = (np.abs(drawn) ** 2).sum(axis=1) / (n_parts * N_DRAWS)
        self.is_exact = np.zeros(len(self.information), dtype=bool)
        self.least = LEAST_INFORMATION * (self.regions @ weights)
        self.lost = np.zeros(len(self.information))

    @property
    def n_tried(self):
        """Number of regions that were tried."""
        return self.regions.shape[0]

    def worst(self):
        """The clearest region of all."""
        squares = self._squares()
        while (is_open := (squares > LOOKED_AT) & ~self.is_exact).any():
            self._look_at(np.flatnonzero(is_open))
            squares = self._squares()
        return self._tried(squares, int(np.argmax(squares)))

    def _look_at(self, places):
        """Compute the information of some regions, a few at a time."""
        for first in range(0, len(places), AT_ONCE):
            some = places[first : first + AT_ONCE]
            regions = self.regions[some]
            shown = np.real(self.times(regions.T.tocsc()))
            self.information[some] = regions.multiply(shown.T).sum(axis=1)
        self.is_exact[places] = True

    def _squares(self):
        left = self.information - self.lost
        # of parts of a region that was taken out nothing is left
        is_known = left > np.maximum(self.least, LEAST_RANK * self.information)
        left = np.where(is_known, left, np.inf)
        return np.abs(self.regions @ self.scores) ** 2 / left

    def _tried(self, squares, place):
        square = float(squares[place])
        p_value = min(self.n_tried * np.exp(-square / 2.0), 1.0)
        return _Tried(np.sort(self.regions[[place]].indices), square, p_value)

    def starts(self):
        """The clearest regions that have not too much in common."""
        squares, found = self._squares(), []
        squares[~self.is_exact] = 0.0
        size = self.regions.sum(axis=1)
        is_open = np.ones(len(squares), dtype=bool)
        for place in np.argsort(-squares, kind="stable"):
            if len(found) == MOST_STARTS:
                break
            if is_open[place]:
                found.append(self._tried(squares, place))
                shared = (self.regions @ self.regions[[place]].T).toarray()[:, 0]
                is_open &= shared <= MOST_SHARED * np.maximum(size, size[place])
        return found

    def block(self, rows):
        """Information of some points before anything is taken out, (n_rows, n_rows)."""
        n, ones = len(self.xy), np.ones(len(rows))
        picked = sparse.csc_array((ones, (rows, np.arange(len(rows)))), (n, len(rows)))
        return self.times(picked)[rows]

    def refined(self, tried):
        """A region with the points that belong to it, one by one."""
        rows, certain = tried.members, tried.square
        for _ in range(MOST_ROUNDS):
            near = np.unique(np.append(rows, _neighbours(self.xy, rows)))
            if len(near) > MOST_AROUND:
                break
            before = rows
            is_in, square = self._refined_among(near, rows, tried.members)
            rows, certain = near[is_in], max(certain, square)
            if np.array_equal(rows, before):
                break
        one = np.zeros((len(self.xy), 1))
        one[rows] = 1.0
        shown = self.times(one)[:, 0]
        information = float(np.real(shown[rows].sum()))
        amplitude = self.scores[rows].sum() / information
        square = abs(amplitude) ** 2 * information
        n_changed = len(np.setxor1d(rows, tried.members))
        worth = square - LEAST_GAIN * n_changed
        return _Region(rows, shown, information, amplitude, square, certain, worth)

    def _refined_among(self, near, rows, first):
        """As ``_refine``, of points ``near``, those that were in it at ``first``."""
        n_lost = np.count_nonzero(~np.isin(first, near))
        was_in, is_in = np.isin(near, first), np.isin(near, rows)
        return _refine(self.scores[near], self.block(near), is_in, was_in, n_lost)

    def take_out(self, region):
        """Go on with what a region does not explain."""
        self.scores = self.scores - region.shown * region.amplitude
        self.lost = np.abs(self.regions @ region.shown) ** 2 / region.information


class _Around:
    """Points in and around a region, thinned where they are many, without it."""

    def __init__(self, scan, region):
        middle = scan.xy[region.rows].mean(axis=0)
        apart = np.sum((scan.xy - middle) ** 2, axis=1)
        n_near = max(3 * len(region.rows), MOST_AROUND)
        near = np.argsort(apart, kind="stable")[:n_near]
        rows = np.sort(near[:: -(-len(near) // MOST_AROUND)])
        shown = region.shown[rows]
        taken_out = np.outer(shown, shown.conj()) / region.information
        self.information = scan.block(rows) - taken_out
        self.scores = (scan.scores - region.shown * region.amplitude)[rows]
        self.xy, self.region, self.n_tried = scan.xy[rows], region, scan.n_tried

    def smoothness(self):
        """Probability that chance makes a smooth pattern as clear as this one."""
        both = np.column_stack([self.scores.real, self.scores.imag])
        return smooth_pattern(both, np.real(self.information), self.xy).p_value

    def tail(self):
        """Probability of the region by the scatter of the scores without it.

        F with the degrees of freedom of the points around, of all regions together.
        """
        own = (self.information + self.information.conj().T) / 2.0
        values, vectors = np.linalg.eigh(own)
        is_known = values > LEAST_RANK * max(values.max(), 0.0)
        white = vectors[:, is_known].conj().T @ self.scores
        rest = np.sum(np.abs(white) ** 2 / values[is_known])
        # what single points were chosen by is scatter as well
        rest += self.region.square - self.region.certain
        if not rest > 0.0:
            return 0.0
        degrees = np.count_nonzero(is_known)  # of each coordinate
        return float(self.n_tried * (1.0 + self.region.certain / rest) ** -degrees)


def _refine(scores, information, is_in, was_in, n_lost):
    """Take points into a region, or out of it, as long as it becomes clearer.

    Gives which belong to it, and its χ² less what chance gains by every choice against
    what it was; ``n_lost`` of that are not among the points.
    """
    is_in = is_in.copy()
    diagonal = np.real(np.diag(information))
    price, certain = 2.0 * np.log(len(scores)), 0.0
    for _ in range(len(scores)):
        shown = np.real(information @ is_in)
        known, right = shown[is_in].sum(), scores[is_in].sum()
        square = abs(right) ** 2 / known
        n_changed = n_lost + np.count_nonzero(is_in != was_in)
        certain = max(certain, square - price * n_changed)
        sign = np.where(is_in, -1.0, 1.0)
        others = known + 2.0 * sign * shown + diagonal
        n_in = is_in.sum() + sign
        is_allowed = (others > 0.1 * known) & (n_in >= FEWEST_POINTS)
        squares = np.abs(right + sign * scores) ** 2
        squares = np.where(is_allowed, squares / np.where(is_allowed, others, 1.0), 0.0)
        best = int(np.argmax(squares))
        if squares[best] <= square + LEAST_GAIN:
            break
        is_in[best] = not is_in[best]
    return is_in, certain


def _neighbours(xy, rows, n_neighbours=8):
    n_nearest = min(n_neighbours, len(xy))
    return cKDTree(xy).query(xy[rows], n_nearest)[1].ravel()


def regions_of(xy):
    """Round regions all over some points, and all on one side of straight lines.

    Of all sizes; sparse, (n_regions, n): 1 where a point is in it. Where that is more
    than half of them the others are. So that there are not too many the smallest are
    left out in a large block, and large ones are tried in fewer places.
    """
    n = len(xy)
    sizes, n_places = _sizes(n)
    centres = _spread(xy, max(n_places))
    tree = cKDTree(xy)
    found = [
        _smaller_parts(tree.query(xy[centres[:n_here]], size)[1], n)
        for size, n_here in zip(sizes, n_places, strict=True)
    ]
    return sparse.vstack([*found, *_sides(xy, sizes)], format="csr")


def _smaller_parts(inside, n):
    """Regions of points ``inside``, (n_regions, size), or of the others: sparse."""
    n_regions, size = inside.shape
    if 2 * size <= n:
        pointer = np.arange(n_regions + 1) * size
        entries = np.ones(inside.size), inside.ravel(), pointer
        return sparse.csr_array(entries, shape=(n_regions, n))
    others = np.ones((n_regions, n))
    np.put_along_axis(others, inside, 0.0, axis=1)
    return sparse.csr_array(others)


def _sides(xy, sizes):
    """Points on one side of lines in many directions, of all sizes, as regions."""
    offset = xy - xy.mean(axis=0)
    angle = np.arange(N_DIRECTIONS) * np.pi / N_DIRECTIONS
    along = offset @ np.stack([np.cos(angle), np.sin(angle)])
    order = np.argsort(along, axis=0, kind="stable").T
    return [_smaller_parts(order[:, :size], len(xy)) for size in sizes]


def _sizes(n):
    """Numbers of points of regions, and in how many places each is tried."""
    sizes = [FEWEST_POINTS]
    while (size := max(int(SIZE_STEP * sizes[-1]), sizes[-1] + 1)) <= n - FEWEST_POINTS:
        sizes.append(size)
    smaller = np.minimum(sizes, n - np.array(sizes))
    n_places = np.minimum(-(-PLACES_PER_SIZE * n // smaller), n)
    # the smallest are the most
    order = np.argsort(-smaller, kind="stable")
    is_tried = np.zeros(len(sizes), dtype=bool)
    is_tried[order[np.cumsum(n_places[order]) <= MOST_TRIED]] = True
    return np.array(sizes)[is_tried], n_places[is_tried]


def _spread(xy, n_wanted):
    """Points that are spread over all, the first of them as evenly as can be."""
    chosen = np.empty(n_wanted, dtype=np.int64)
    apart = np.sum((xy - xy.mean(axis=0)) ** 2, axis=1)
    place = int(np.argmin(apart))
    apart = np.full(len(xy), np.inf)
    for k in range(n_wanted):
        chosen[k] = place
        apart = np.minimum(apart, np.sum((xy - xy[place]) ** 2, axis=1))
        place = int(np.argmax(apart))
    return chosen
