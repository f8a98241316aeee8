"""Screening of stage 5: points whose coverages differ by more than they may.

The approximate coordinates are common to all coverages, so that the difference of two
coverages has a smaller error than the values themselves would let one expect. Its
covariance is L Σ Lᵀ with the difference as the last operator, correlations included.

See docs/theory/double_coverage.md.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations import typesetting
from einschalt.foundations.arguments import require_choice
from einschalt.foundations.batches import numbered, segment_sum, segments
from einschalt.foundations.frame_columns import columns_of, values_of, with_columns
from einschalt.foundations.names import encode
from einschalt.stages.results import Result
from einschalt.theory.adjustment.correlated_mean import squared_sizes, times
from einschalt.theory.adjustment.point_operator import GROUND_NAMES, sums
from einschalt.theory.double_coverage import (
    apportioned_covariance,
    difference_p_values,
    exceeds_practice,
)

SCREENINGS = ("propagated", "practice_1968", "off")
DIFFERENCES = ["difference_easting", "difference_northing"]
COLUMNS = [
    *("point_id", "coverage", "easting", "northing", *DIFFERENCES),
    *("standard_error_difference", "p_value", "is_suspect"),
]
IN_HEIGHT = "difference_height"


@dataclass(frozen=True, eq=False)
class CoverageDifferences:
    """What each coverage gives for a point, against the mean of its other coverages."""

    # point_id, coverage, easting, northing (mean of the values of that coverage),
    # difference_easting, difference_northing [, difference_height] (less the mean of
    # the other coverages), standard_error_paper (TOTAL, of the difference, were all
    # values independent) [m]. One row for each coverage of a point that has several
    table: pd.DataFrame
    # rows, start: of each row, the values behind it: ``rows[start[k]:start[k + 1]]``
    rows: np.ndarray
    start: np.ndarray
    # (len(rows),) or (len(rows), n_coordinates, n_coordinates): with which the values
    # enter the difference, numbers or matrices; they add up to zero
    shares: np.ndarray

    def operator(self, n_values, axes):
        """Differences of the table as an operator on all values of the flight."""
        return sums(self.shares, self.rows, self.start, n_values, axes)

    @property
    def is_needed(self):
        """Rows without the first of two coverages, which says what the second says."""
        point = self.table["point_id"].to_numpy()
        if not len(point):
            return np.zeros(0, dtype=bool)
        first = np.flatnonzero(np.append(True, point[1:] != point[:-1]))
        size = np.diff(np.append(first, len(point)))
        is_needed = np.ones(len(point), dtype=bool)
        is_needed[first[size == 2]] = False
        return is_needed

    def needed(self):
        """Leave the rows that are needed: of two coverages the later one."""
        is_needed = self.is_needed
        kept = np.repeat(is_needed, np.diff(self.start))
        count = np.diff(self.start)[is_needed]
        return CoverageDifferences(
            self.table[is_needed].reset_index(drop=True),
            self.rows[kept],
            np.concatenate([[0], np.cumsum(count)]),
            self.shares[kept],
        )

    def with_others(self, of_needed):
        """Bring an array over the rows that are needed to all rows.

        (n_needed, ...) to (n_rows, ...): it is the same for either of two coverages.
        """
        is_needed = self.is_needed
        place = np.cumsum(is_needed) - 1
        # the first of two stands right before the row that says the same
        return of_needed[np.where(is_needed, place, place + 1)]


@dataclass(frozen=True, eq=False, repr=False)
class CoverageScreening(Result):
    """Which points have coverages that differ by more than they may."""

    # point_id, coverage, easting, northing, difference_easting, difference_northing
    # [, difference_height], standard_error_difference (TOTAL) [m], p_value, is_suspect.
    # The values of all coverages, so that those of a suspect are kept beside their mean
    table: pd.DataFrame
    practice: str  # "propagated", "practice_1968", "off"
    # whether the limits follow from the propagated precision; otherwise they are those
    # of the differences themselves
    is_propagated: bool
    # probability with which a point without gross errors is a suspect; NaN where the
    # practice has none
    significance: float

    @property
    def suspects(self) -> np.ndarray:
        """point_id of the suspects, ndarray of object."""
        return self.table.loc[self.table["is_suspect"], "point_id"].unique()

    @property
    def n_tested(self) -> int:
        """Number of points that could be tested."""
        tested = self.table.loc[self.table[DIFFERENCES[0]].notna(), "point_id"]
        return int(tested.nunique())

    def summary(self) -> str:
        """Say how many points were screened, and how many failed."""
        n_points = typesetting.count(self.n_tested, "point")
        return f"{n_points} in several coverages, {len(self.suspects)} suspects"


def coverage_differences(means) -> CoverageDifferences:
    """Compare what each coverage gives for a point with its other coverages."""
    used = means.used
    points, coverages = encode(used["point_id"]), encode(used["coverage"])
    # coverages in the order of their names: "1" before "2"
    rank = np.argsort(np.argsort(coverages.names.astype(str), kind="stable"))
    key = points.codes * len(coverages) + rank[coverages.codes]
    distinct, group = numbered(key)
    by_group = segments(group, len(distinct))
    of_point = distinct // len(coverages)
    n_groups = np.bincount(of_point, minlength=len(points))
    several = np.flatnonzero(n_groups[of_point] > 1)
    weights = means.coverage_weights
    if weights.ndim == 1:
        weight_sum = segment_sum(weights[by_group.order], by_group.start)
        weights = weights / weight_sum[group]
    by_point = segments(points.codes, len(points))
    place, start = by_point.rows_of(of_point[several])
    row = np.repeat(several, np.diff(start))
    is_own = group[place] == row
    share, others = weights[place], n_groups[of_point[row]] - 1
    own = share * _fitting(is_own, share)
    shares = own - (share - own) / _fitting(others, share)
    coordinates = values_of(used, [n for n in GROUND_NAMES if n in used])
    error = used["standard_error_paper"].to_numpy(dtype=float)
    names = np.sort(coverages.names.astype(str)).astype(object)
    mean = _sums(coordinates, place, start, own)
    differences = _sums(coordinates, place, start, shares)
    axes = [*DIFFERENCES, IN_HEIGHT][: differences.shape[1]]
    variance = segment_sum(squared_sizes(shares) * error[place] ** 2, start)
    table = with_columns(
        pd.DataFrame({"point_id": points.names[of_point[several]]}),
        coverage=names[distinct[several] % len(coverages)],
        easting=mean[:, 0],
        northing=mean[:, 1],
        **dict(zip(axes, differences.T, strict=True)),
        standard_error_paper=np.sqrt(variance),
    )
    rows = means.row_numbers[place]
    return CoverageDifferences(table, rows, start, shares)


def _sums(coordinates, place, start, shares):
    """Weighted sums over differences to each row's first value, which keep digits."""
    origin = coordinates[place[start[:-1]]]
    offset = coordinates[place] - np.repeat(origin, np.diff(start), axis=0)
    total = segment_sum(shares, start)
    return segment_sum(times(shares, offset), start) + times(total, origin)


def _fitting(numbers, shares):
    """Numbers as an array that multiplies shares."""
    return numbers.reshape((-1,) + (1,) * (shares.ndim - 1))


def screen_coverages(differences, covariance, practice, significance):
    """Find the points whose coverages differ by more than they may.

    ``covariance`` (n_rows, n_axes, n_axes) is that of the differences [m²], of two axes
    or of three; None where it could not be propagated. "propagated" tests all of these
    jointly against it;
    "practice_1968" holds each coordinate against three standard errors of a difference,
    taken from the differences themselves; "off" tests nothing. ``significance`` is the
    probability with which a point without gross errors is a suspect; the practice of
    1968 has no other level than its own.

    Notes
    -----
    Without a propagated covariance, heights are not tested, and that of the budget M of
    the values is taken for its shape, and the median of the differences for its size:
    the internal figure, which gross errors do not enlarge. The significance then holds
    by approximation.
    """
    require_choice("screening", practice, SCREENINGS)
    table = differences.table
    d = tested = values_of(table, DIFFERENCES)
    is_propagated = practice == "propagated" and covariance is not None
    p_value = np.full(len(d), np.nan)
    is_suspect, total = np.zeros(len(d), dtype=bool), np.full(len(d), np.nan)
    if practice == "propagated":
        if covariance is None:
            paper = differences.table["standard_error_paper"].to_numpy()
            covariance = apportioned_covariance(d, paper)
        total = np.sqrt(covariance[:, 0, 0] + covariance[:, 1, 1])
        if covariance.shape[1] > d.shape[1]:
            tested = values_of(table, [*DIFFERENCES, IN_HEIGHT])
        p_value = _of_points(difference_p_values(tested, covariance), table["point_id"])
        is_suspect = p_value < significance
    elif practice == "practice_1968":
        n_coverages = table.groupby("point_id")["coverage"].transform("size")
        found = exceeds_practice(d, n_coverages.to_numpy())
        is_suspect, total = found.exceeds, found.standard_error
        is_suspect = pd.Series(is_suspect).groupby(table["point_id"]).transform("any")
    table = with_columns(
        table,
        standard_error_difference=total,
        p_value=p_value,
        is_suspect=np.asarray(is_suspect, dtype=bool),
    )
    level = significance if practice == "propagated" else np.nan
    columns = [*COLUMNS]
    if IN_HEIGHT in table:
        columns.insert(columns.index(DIFFERENCES[1]) + 1, IN_HEIGHT)
    return CoverageScreening(columns_of(table, columns), practice, is_propagated, level)


def _of_points(p_values, point_id):
    """Probability of a point: of several coverages the worst, after Bonferroni."""
    of_point = pd.Series(p_values).groupby(point_id.to_numpy(), sort=False)
    size = of_point.transform("size").to_numpy()
    # two coverages have one difference, which stands in both rows
    n_tests = np.where(size == 2, 1, size)
    return np.minimum(of_point.transform("min").to_numpy() * n_tests, 1.0)
