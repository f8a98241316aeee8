"""Mean of a point's values from several models, and what their differences say."""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from einschalt.foundations.batches import segment_min_max, segment_sum
from einschalt.theory.adjustment.correlated_mean import squared_sizes, times

PLAN_AXES = 2
# limit of a coordinate's difference in its standard errors, and how often these are
# taken anew from the differences within it
PRACTICE_FACTOR = 3.0
MOST_REPETITIONS = 50


def position_in_extent(xy, start):
    """Position u, v of each point in the extent of its model, (n_points, 2).

    ``xy`` (n_points, 2) is sorted by model. From −½ to ½ between the edges of the box
    around the model's points; 0 where the box has no width.
    """
    low, high = segment_min_max(xy, start)
    count = np.diff(start)
    middle = np.repeat(0.5 * (low + high), count, axis=0)
    width = np.repeat(high - low, count, axis=0)
    return np.divide(xy - middle, width, out=np.zeros_like(middle), where=width > 0.0)


def most_central_rows(point, coverage, position, model):
    """Per point and coverage the row that lies most central in its model.

    Practice of 1971: max(abs u, abs v) smallest (docs/theory/double_coverage.md),
    ``position`` (n_rows, 2) from :func:`position_in_extent`. The rows chosen ascend. Of
    equal ones the one of the first ``model`` (n_rows,) is taken: numbers that do not
    hang on the order of the rows.
    """
    eccentricity = np.abs(position).max(axis=1)
    order = np.lexsort((model, eccentricity, coverage, point))
    is_first = np.ones(len(order), dtype=bool)
    is_first[1:] = (np.diff(point[order]) != 0) | (np.diff(coverage[order]) != 0)
    return np.sort(order[is_first])


@dataclass(frozen=True, eq=False)
class PointMeans:
    """Means of the values of each point."""

    mean: np.ndarray  # (n_points, n_coordinates)
    # (n_points,): √(Σ w² M²) / Σ w: of the mean if the M were independent, as the paper
    # takes them, and alike in easting and northing
    standard_error: np.ndarray
    n_values: np.ndarray  # of int, (n_points,)
    # (n_points,): total standard deviation of one value, √(Σ |x − mean|² / (n − 1)) in
    # plan; NaN where there is one value only
    spread_total: np.ndarray


def mean_of_values(coordinates, standard_error, weights, start):
    """Weighted mean of the values of each point, none of which is without values.

    ``coordinates`` (n_values, n_coordinates) are easting, northing [, height] [m],
    sorted by point, ``standard_error`` (n_values,) their TOTAL errors M [m].
    ``weights`` are 1 for the plain mean, or matrices whose sum is the unit matrix at
    every point.
    """
    count = np.diff(start)
    # sums over differences to each point's first value keep all digits
    first = coordinates[start[:-1]]
    offset = coordinates - np.repeat(first, count, axis=0)
    is_number = weights.ndim == 1
    weight_sum = segment_sum(weights, start) if is_number else np.ones(len(count))
    shift = segment_sum(times(weights, offset), start) / weight_sum[:, None]
    variance = segment_sum(squared_sizes(weights) * standard_error**2, start)
    deviation = (offset - np.repeat(shift, count, axis=0))[:, :2]
    squares = np.einsum("na,na->n", deviation, deviation)
    sum_of_squares = segment_sum(squares, start)
    spread = np.sqrt(
        np.divide(
            sum_of_squares, count - 1, out=np.full(len(count), np.nan), where=count > 1
        )
    )
    return PointMeans(first + shift, np.sqrt(variance) / weight_sum, count, spread)


def internal_standard_error(coordinates, start):
    """Total error of one coverage's value [m], from the differences of the coverages.

    For two coverages it is √(Σ |d|² / 2n) over n differences d. It sees only what the
    coverages do not share. ``coordinates`` (n_values, 2) has one value per point and
    coverage [m], sorted by point; NaN where no point has two coverages.
    """
    count = np.diff(start)
    ones = np.ones(len(coordinates))
    spread = mean_of_values(coordinates, ones, ones, start).spread_total
    redundancy = int(np.sum(count - 1))
    if redundancy == 0:
        return np.nan
    return float(np.sqrt(np.nansum(spread**2 * (count - 1)) / redundancy))


def difference_p_values(differences, covariance):
    """Probability of differences as large as these without a gross error, (n,).

    Joint test of all coordinates of each difference (n, 2) or (n, 3) [m] with its
    covariance (n, n_axes, n_axes) [m²]: the tail of χ² beyond T = dᵀ C⁻¹ d, in plan
    exp(−T/2). NaN where the covariance has no inverse.
    """
    if differences.shape[1] > PLAN_AXES:
        return _p_values_in_space(differences, covariance)
    (ee, en), (_, nn) = np.moveaxis(covariance, 0, -1)
    e, n = differences.T
    determinant = ee * nn - en**2
    form = nn * e**2 + ee * n**2 - 2.0 * en * e * n
    is_known = determinant > 0.0
    squares = np.divide(form, determinant, out=np.full(len(e), np.nan), where=is_known)
    return np.exp(-0.5 * squares)


def _p_values_in_space(differences, covariance):
    is_known = np.linalg.det(covariance) > 0.0
    squares = np.full(len(differences), np.nan)
    d = differences[is_known]
    solved = np.linalg.solve(covariance[is_known], d[:, :, None])[:, :, 0]
    squares[is_known] = np.sum(d * solved, axis=1)
    return chdtrc(d.shape[1], squares)


def apportioned_covariance(differences, standard_error):
    """Covariance (n, 2, 2) of differences whose size only they themselves tell [m²].

    Multiples of the unit matrix, shared out in proportion to the squares of the TOTAL
    errors ``standard_error`` (n,), or equally where one is not known. The median of
    |d|²/σ² is 2 ln 2 where σ is that of a coordinate: half of the differences may have
    gross errors.
    """
    shape = np.asarray(standard_error, dtype=float) ** 2
    if not (np.isfinite(shape) & (shape > 0.0)).all():
        shape = np.ones(len(differences))
    squares = np.sum(differences**2, axis=1) / shape
    size = np.median(squares) / (2.0 * np.log(2.0)) if len(squares) else np.nan
    return (size * shape)[:, None, None] * np.eye(2)


@dataclass(frozen=True, eq=False)
class PracticeLimits:
    """Differences against the limits of the double coverages of 1968."""

    exceeds: np.ndarray  # of bool, (n,): one coordinate at least lies beyond its limit
    standard_error: np.ndarray  # (n,): TOTAL, of each difference [m]


def exceeds_practice(differences, n_coverages):
    """Find differences beyond three standard errors in a coordinate.

    In the cadastral flights of North Rhine-Westphalia the limit of a coordinate's
    difference was 24 cm at 1:5000, three times √2 · 5.5 cm, the standard error of one
    determination coming from the differences themselves.

    ``differences`` (n, 2) [m] are those of a coverage and the mean of the others,
    ``n_coverages`` (n,) counts those of each point. The standard error is that of the
    differences that are within the limits, found by repetition: gross errors do not
    widen the limits that are to find them.
    """
    # variance of one value less the mean of k − 1 others: 1 + 1/(k − 1)
    widening = n_coverages / np.maximum(n_coverages - 1.0, 1.0)
    reduced = differences / np.sqrt(widening)[:, None]
    exceeds = np.zeros(len(differences), dtype=bool)
    for _ in range(MOST_REPETITIONS):
        within = reduced[~exceeds]
        single = np.sqrt(np.mean(within**2)) if len(within) else np.nan
        before = exceeds
        exceeds = (np.abs(reduced) > PRACTICE_FACTOR * single).any(axis=1)
        if np.array_equal(before, exceeds):
            break
    return PracticeLimits(exceeds, single * np.sqrt(2.0 * widening))
