"""Mean of a point's values from several models, and what their differences say."""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import segment_min_max, segment_sum


def position_in_extent(xy, start):
    """Position u, v of each point in the extent of its model.

    Parameters
    ----------
    xy : ndarray, shape (n_points, 2)
        Model coordinates, sorted by model.
    start : ndarray of int, shape (n_models + 1,)

    Returns
    -------
    ndarray, shape (n_points, 2)
        −½ to ½ from edge to edge of the box around the model's points; 0 where the
        box has no width.
    """
    low, high = segment_min_max(xy, start)
    count = np.diff(start)
    middle = np.repeat(0.5 * (low + high), count, axis=0)
    width = np.repeat(high - low, count, axis=0)
    return np.divide(xy - middle, width, out=np.zeros_like(middle), where=width > 0.0)


def most_central_rows(point, coverage, position):
    """Per point and coverage the row that lies most central in its model.

    Source: practice of 1971, max(abs u, abs v) smallest (docs/theory/
    double_coverage.md).

    Parameters
    ----------
    point, coverage : ndarray of int, shape (n_rows,)
    position : ndarray, shape (n_rows, 2)
        From :func:`position_in_extent`.

    Returns
    -------
    ndarray of int
        Chosen rows, ascending; of equal ones the first.
    """
    eccentricity = np.abs(position).max(axis=1)
    order = np.lexsort((eccentricity, coverage, point))
    is_first = np.ones(len(order), dtype=bool)
    is_first[1:] = (np.diff(point[order]) != 0) | (np.diff(coverage[order]) != 0)
    return np.sort(order[is_first])


@dataclass(frozen=True, eq=False)
class PointMeans:
    """Means of the values of each point.

    Attributes
    ----------
    mean : ndarray, shape (n_points, n_coordinates)
    standard_error : ndarray, shape (n_points,)
        √(Σ w² M²) / Σ w: of the mean if the M were independent, as the paper takes
        them.
    n_values : ndarray of int, shape (n_points,)
    spread_total : ndarray, shape (n_points,)
        Total standard deviation of one value, √(Σ |x − mean|² / (n − 1)) in plan;
        NaN where there is one value only.
    """

    mean: np.ndarray
    standard_error: np.ndarray
    n_values: np.ndarray
    spread_total: np.ndarray


def mean_of_values(coordinates, standard_error, weights, start):
    """Weighted mean of the values of each point.

    Parameters
    ----------
    coordinates : ndarray, shape (n_values, n_coordinates)
        Easting, northing [, height] [m], sorted by point.
    standard_error : ndarray, shape (n_values,)
        TOTAL error M of each value [m].
    weights : ndarray, shape (n_values,)
        1 for the plain mean.
    start : ndarray of int, shape (n_points + 1,)
        No point is empty.

    Returns
    -------
    PointMeans
    """
    count = np.diff(start)
    # sums over differences to each point's first value keep all digits
    first = coordinates[start[:-1]]
    offset = coordinates - np.repeat(first, count, axis=0)
    weight_sum = segment_sum(weights, start)
    shift = segment_sum(weights[:, None] * offset, start) / weight_sum[:, None]
    variance = segment_sum((weights * standard_error) ** 2, start)
    deviation = (offset - np.repeat(shift, count, axis=0))[:, :2]
    sum_of_squares = segment_sum(np.sum(deviation**2, axis=1), start)
    spread = np.sqrt(
        np.divide(
            sum_of_squares,
            count - 1,
            out=np.full(len(count), np.nan),
            where=count > 1,
        )
    )
    return PointMeans(first + shift, np.sqrt(variance) / weight_sum, count, spread)


def internal_standard_error(coordinates, start):
    """Total error of one coverage's value, from the differences of the coverages.

    For two coverages it is √(Σ |d|² / 2n) over n differences d. It sees only what the
    coverages do not share.

    Parameters
    ----------
    coordinates : ndarray, shape (n_values, 2)
        One value per point and coverage [m], sorted by point.
    start : ndarray of int, shape (n_points + 1,)

    Returns
    -------
    float
        [m]; NaN where no point has two coverages.
    """
    count = np.diff(start)
    ones = np.ones(len(coordinates))
    spread = mean_of_values(coordinates, ones, ones, start).spread_total
    redundancy = int(np.sum(count - 1))
    if redundancy == 0:
        return np.nan
    return float(np.sqrt(np.nansum(spread**2 * (count - 1)) / redundancy))
