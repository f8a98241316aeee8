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

A further region that is as clear is taken out with it, and each of them is looked for
once more beside the others.

Sources: Kulldorff 1997, A spatial scan statistic; Teunissen 2006, Testing theory. See
docs/theory/claim.md.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from einschalt.theory.adjustment.around_region import (
    LEAST_RANK,
    MOST_AROUND,
    Around,
)
from einschalt.theory.adjustment.detectable_shift import (
    DetectableShift,
    detectable_shift,
)
from einschalt.theory.adjustment.refined_region import LEAST_GAIN, refine
from einschalt.theory.adjustment.significance import (
    FINDING_SIGNIFICANCE,
    SYSTEMATIC_SIGNIFICANCE,
)
from einschalt.theory.adjustment.tried_regions import FEWEST_POINTS, regions_of

AT_ONCE = 256
# that tell what is known of a region: half of it, or twice as much, at the worst
N_DRAWS = 64
# χ² from which a region is looked at: by draws it may be twice as large
LOOKED_AT = 11.0
# of a larger one those at its rim are
MOST_AT_RIM = 1000
MOST_KEPT = 20_000_000  # numbers of W, not to be computed again
MOST_ROUNDS = 6  # in which a region grows or shrinks by a row of points
N_NEIGHBOURS = 8
# of the weights of a region: what is known less of it is rounding
LEAST_INFORMATION = 1e-6
# regions to begin with, and what two of them share at most
MOST_STARTS, MOST_SHARED = 8, 0.7
# of χ² with two degrees of freedom; and by how much chance may exceed it
MEDIAN_OF_SQUARES, LARGEST_SCATTER = 2.0 * np.log(2.0), 1.5
MOST_TURNS, NEARLY = 6, 0.9  # until it is nearly the same
MOST_REGIONS = 3  # of a block that are displaced
MOST_FIRST = 4  # of them that are tried as the one to be taken out first


@dataclass(frozen=True, eq=False)
class DisplacedRegion:
    """Points that are displaced against all others."""

    rows: np.ndarray  # of the given points, ascending
    shift: np.ndarray  # (2,): how far they are off [m]
    standard_error: float  # of each coordinate of the shift [m]
    p_value: float  # of all regions that were tried together


@dataclass(frozen=True, eq=False)
class RegionScan:
    """What a scan finds, and how clear the clearest of its regions is."""

    # the clearest first. A single one is the smaller part: nothing tells it from a
    # displacement of all others. None where chance, larger errors, a smooth pattern or
    # too many regions explain the scores
    regions: tuple[DisplacedRegion, ...]
    n_tried: int
    square: float  # χ², of two degrees of freedom, of the clearest that was tried
    p_value: float  # of all together; NaN where points are too few
    # by how much all errors were taken to be larger than stated
    enlargement: float = 1.0
    # where nothing is seen: how far regions may be displaced all the same
    detectable: DetectableShift | None = None


def find_displaced_regions(checks, weights, xy) -> RegionScan:
    """Find regions whose points are displaced, all of each by the same vector.

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
    """
    if len(xy) < 2 * FEWEST_POINTS:
        return RegionScan((), 0, 0.0, np.nan)
    scan = _Scan(checks, weights, xy)
    clearest = scan.worst()
    told = scan.n_tried, clearest.square, clearest.p_value
    if clearest.p_value > FINDING_SIGNIFICANCE:
        return RegionScan((), *told, detectable=scan.detectable())
    ratio, regions = scan.scatter(), _named(scan)
    if regions or ratio <= LARGEST_SCATTER:
        return RegionScan(regions, *told)
    regions, enlargement = _named_among_larger(checks, weights, xy, ratio)
    return RegionScan(regions, *told, enlargement)


def _named_among_larger(checks, weights, xy, ratio):
    """Regions where all errors are larger than stated, and by how much they are.

    ``ratio`` is that of the variances, as all scores have it; without the regions they
    scatter less, which is the ratio of the next turn.
    """
    found, enlargement = (), 1.0
    for _ in range(MOST_TURNS):
        scan = _Scan(_Larger(checks, ratio), weights / ratio, xy, is_scaled=True)
        regions = _named(scan)
        if not regions:
            break
        found, enlargement = regions, ratio**0.5
        left = scan.scatter()
        if left > NEARLY:
            break
        ratio = max(left * ratio, 1.0)
    return found, enlargement


@dataclass(frozen=True)
class _Larger:
    """Checks of points whose variances are larger than stated, all by a ratio."""

    checks: object
    ratio: float

    @property
    def scores(self):
        return self.checks.scores / self.ratio

    def times(self, columns):
        return self.checks.times(columns) / self.ratio

    def draw(self, n_draws, seed):
        return self.checks.draw(n_draws, seed) / self.ratio**0.5


def _named(scan):
    """Regions that explain all that is clear; none where that may be something else."""
    p_value = scan.worst().p_value
    if p_value > FINDING_SIGNIFICANCE:
        return ()
    # regions that touch may look like one: then another one is taken out first
    for first in scan.clearest()[:MOST_FIRST]:
        found, p_values, left = _with_further(scan, first)
        if left > SYSTEMATIC_SIGNIFICANCE:
            if _are_regions(scan, found):
                parts = zip(found, [p_value, *p_values], strict=True)
                return tuple(scan.told(*one, at) for at, one in enumerate(parts))
            if len(found) == 1:
                break
    return ()


def _with_further(scan, first):
    """Take out a region and all further ones.

    Gives these regions, probabilities of the further ones, and that of what is left.
    """
    found, p_values = [first], []
    scan.take_out(found)
    while (p_value := scan.worst().p_value) <= FINDING_SIGNIFICANCE:
        further = scan.clearest() if len(found) < MOST_REGIONS else []
        if not further:
            break
        found = scan.beside_each_other([*found, further[0]])
        if _n_others(scan, found) < FEWEST_POINTS:  # all points moved are no region
            break
        p_values.append(p_value)
        scan.take_out(found)
    return found, p_values, p_value


def _are_regions(scan, found):
    """Whether regions that were taken out are neither chance nor a smooth pattern."""
    around = [Around(scan, region) for region in found]
    return _n_others(scan, found) >= FEWEST_POINTS and all(
        each.tail() <= SYSTEMATIC_SIGNIFICANCE
        and each.smoothness() > SYSTEMATIC_SIGNIFICANCE
        for each in around
    )


def _n_others(scan, found):
    """Number of points in none of the regions."""
    return len(scan.xy) - sum(len(region.rows) for region in found)


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
    tried: _Tried
    shown: np.ndarray  # complex (n,): W p
    # χ² of it, and what of that is beyond the choice of single points
    square: float
    certain: float
    worth: float  # χ² less what its single points had to add at least


class _Scan:
    """Scores, and what is known of regions by them."""

    def __init__(self, checks, weights, xy, *, is_scaled=False):
        self.given, self.times, self.xy = checks.scores, checks.times, xy
        self.is_scaled = is_scaled  # whether the size of the errors is not known
        n_nearest = min(N_NEIGHBOURS, len(xy))
        self.neighbours = cKDTree(xy).query(xy, n_nearest)[1]
        self.regions = regions_of(xy)
        drawn = self.regions @ checks.draw(N_DRAWS, seed=0)
        n_parts = 2 if np.iscomplexobj(drawn) else 1
        # as much as it is known of by draws, until it looks as if it were displaced
        self.information = (np.abs(drawn) ** 2).sum(axis=1) / (n_parts * N_DRAWS)
        self.is_exact = np.zeros(len(self.information), dtype=bool)
        self.least = LEAST_INFORMATION * (self.regions @ weights)
        # columns of W, and where that of each point is
        self.known, self.place = np.zeros((len(xy), 0)), np.full(len(xy), -1)
        self.take_out(())

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

    def detectable(self):
        """How far regions must be displaced, so that the clearest is one of them."""
        size = self.regions.sum(axis=1)
        return detectable_shift(self._known(), size, len(self.xy), self._exactly)

    def _known(self):
        """Information of all regions; 0 where it is rounding."""
        return np.where(self.information > self.least, self.information, 0.0)

    def _exactly(self, places):
        self._look_at(places[~self.is_exact[places]])
        return self._known()[places]

    def scatter(self):
        """Variance of the scores over what is stated, by the median small region."""
        size = self.regions.sum(axis=1)
        squares = self._squares()[size == size.min()]
        return float(np.median(squares) / MEDIAN_OF_SQUARES)

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
        """Information of some points beside what was taken out, (n_rows, n_rows)."""
        shown = self.shown[rows]
        return self._among(rows) - shown @ self.cofactor @ shown.conj().T

    def _among(self, rows):
        """W between some points; rims that follow each other have most in common."""
        n = len(self.xy)
        new = rows[self.place[rows] < 0]
        if len(self.known) and self.known.shape[1] + len(new) > MOST_KEPT / n:
            self.place[:], self.known, new = -1, np.zeros((n, 0)), rows
        if len(new):
            picked = np.ones(len(new)), (new, np.arange(len(new)))
            shown = self.times(sparse.csc_array(picked, (n, len(new))))
            self.place[new] = self.known.shape[1] + np.arange(len(new))
            self.known = np.hstack([self.known, shown])
        return self.known[np.ix_(rows, self.place[rows])]

    def refined(self, tried):
        """A region with the points that belong to it, one by one, and to no other."""
        members = tried.members[~self.is_taken[tried.members]]
        (shown, square), rows = self._of_rows(members), members
        certain = square
        for _ in range(MOST_ROUNDS):
            near = self._at_rim(rows)
            if len(near) > MOST_AT_RIM:
                break
            before = rows
            rows, gained = self._refined_at(near, rows, members)
            certain = max(certain, gained)
            if np.array_equal(rows, before):
                break
        shown, square = self._of_rows(rows)
        n_changed = len(np.setxor1d(rows, members))
        worth = square - LEAST_GAIN * n_changed
        return _Region(rows, tried, shown, square, certain, worth)

    def _at_rim(self, rows):
        """Points that a region may lose or gain next: of a small one all in it."""
        near = np.union1d(rows, self.neighbours[rows])
        near = near[~self.is_taken[near]]
        if len(near) <= MOST_AROUND:
            return near
        is_in = np.zeros(len(self.xy), dtype=bool)
        is_in[rows] = True
        is_outside = ~is_in[near]
        return near[is_outside | ~is_in[self.neighbours[near]].all(axis=1)]

    def _is_free(self, tried):
        """Whether enough points of a region are in no region that was taken out."""
        return np.count_nonzero(~self.is_taken[tried.members]) >= FEWEST_POINTS

    def _of_rows(self, rows):
        """W p of some points, and their χ² beside what was taken out."""
        region = np.zeros(len(self.xy))
        region[rows] = 1.0
        shown = self.times(region[:, None])[:, 0]
        lost = self.shown.T @ region
        information = float(
            np.real(shown @ region - lost @ self.cofactor @ lost.conj())
        )
        if not information > 0.0:  # nothing is known of them
            return shown, 0.0
        return shown, abs(self.scores[rows].sum()) ** 2 / information

    def _beside_taken(self, region):
        """W p of a region (n,) beside what was taken out."""
        lost = self.shown.T @ region
        shown = self.times(region[:, None])[:, 0]
        return shown - self.shown @ (self.cofactor @ lost.conj())

    def _refined_at(self, near, rows, first):
        """A region whose points ``near`` were taken in or out, and what is certain.

        As ``refine`` has it; ``first`` are the rows that it began with.
        """
        region = np.zeros(len(self.xy))
        region[rows] = 1.0
        shown = np.real(self._beside_taken(region))
        n_changed = len(np.setdiff1d(np.setxor1d(rows, first), near))
        whole = shown[near], shown[rows].sum(), self.scores[rows].sum(), len(rows)
        was_in, is_in = np.isin(near, first), np.isin(near, rows)
        choice = is_in, was_in, n_changed
        is_in, certain = refine(self.scores[near], self.block(near), *whole, *choice)
        return np.union1d(np.setdiff1d(rows, near), near[is_in]), certain

    def clearest(self):
        """The clearest regions with the points that belong to them, best first."""
        starts = self.starts()
        found = [self.refined(start) for start in starts if self._is_free(start)]
        found.sort(key=lambda each: -each.worth)
        certain = max((each.certain for each in found), default=0.0)
        return [replace(each, certain=certain) for each in found[:1]] + found[1:]

    def beside_each_other(self, regions):
        """Each region once more, beside all others."""
        regions = list(regions)
        for place in range(len(regions)):
            self.take_out(regions[:place] + regions[place + 1 :])
            if self._is_free(regions[place].tried):
                regions[place] = self.refined(regions[place].tried)
        return regions

    def take_out(self, regions):
        """Go on with what regions, all together, do not explain."""
        n = len(self.given)
        columns = [region.shown for region in regions]
        self.shown = np.column_stack(columns) if columns else np.zeros((n, 0))
        members = np.zeros((len(regions), n))
        for row, region in zip(members, regions, strict=True):
            row[region.rows] = 1.0
        self.is_taken = members.any(axis=0)
        self.cofactor = np.linalg.inv(members @ self.shown)
        self.shifts = self.cofactor @ (members @ self.given)
        self.scores = self.given - self.shown @ self.shifts
        shown = self.regions @ self.shown
        self.lost = np.real(np.sum((shown @ self.cofactor) * shown.conj(), axis=1))

    def told(self, region, p_value, place):
        """What is known of a region that was taken out with others."""
        shift, variance = self.shifts[place], np.real(self.cofactor[place, place])
        shift = np.array([shift.real, shift.imag])
        return DisplacedRegion(region.rows, shift, float(variance**0.5), float(p_value))
