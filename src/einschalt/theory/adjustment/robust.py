"""Fits that gross errors do not spoil, for all models at once.

Data snooping takes out the worst point of each model that the joint test refuses, fits
again, and goes on until nothing is refused. Robust estimation keeps all points and
gives those with large residuals less weight. In both only the models that still change
are fitted again.

Sources: Baarda 1968; Huber 1981, ch. 7; see docs/theory/robust.md.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri

from einschalt.foundations.batches import segment_min_max, segment_sum
from einschalt.theory.adjustment.multiple_testing import count_tested

MOST_ITERATIONS = 100
TOLERANCE = 1e-6
# a factor of zero would leave fewer points than were counted
LEAST_FACTOR = 1e-9


def snoop(points, tests_of, significance):
    """Find gross errors, one after the other in each model, in all models at once.

    Parameters
    ----------
    points : CommonPoints
    tests_of : callable
        Fits CommonPoints and gives their PointTests.
    significance : float
        Probability with which a model without gross errors loses a point.

    Returns
    -------
    ndarray of bool, shape (n_points,)
        What was taken out.

    Notes
    -----
    The worst of n points is refused where p ≤ significance / n: the first step of
    Holm's procedure, which then goes on with the refitted model.
    """
    is_kept = np.ones(len(points.weights), dtype=bool)
    model = points.model
    active = np.arange(len(points.start) - 1)
    while len(active):
        rows, part = points.of_models(active)
        part = part.chosen(is_kept[rows])
        rows = rows[is_kept[rows]]
        p_values = tests_of(part).p_value
        worst = _worst_rows(p_values, part.start, significance)
        is_kept[rows[worst]] = False
        active = np.unique(model[rows[worst]])
    return ~is_kept


def _worst_rows(p_values, start, significance):
    """The point with the smallest probability in each model that the test refuses."""
    tested = np.where(np.isfinite(p_values), p_values, np.inf)
    smallest = segment_min_max(tested, start)[0]
    n_tested = np.maximum(count_tested(p_values, start), 1)
    is_refused = smallest * n_tested <= significance
    limit = np.where(is_refused, smallest, -np.inf)
    rows = np.flatnonzero(tested <= np.repeat(limit, np.diff(start)))
    # of equal points the first: the other may be good without it
    family = np.searchsorted(start, rows, side="right")
    return rows[np.unique(family, return_index=True)[1]]


@dataclass(frozen=True, eq=False)
class RobustFit:
    """Robust fits of all models.

    Attributes
    ----------
    fit : PlaneFit or SpatialFit
        With the final weights; its ``sum_of_squares`` is such that s_0 is the standard
        error of a good observation.
    weights : ndarray, shape (n_points,)
        The given weights times the factors of the norm.
    is_converged : ndarray of bool, shape (n_models,)
    """

    fit: object
    weights: np.ndarray
    is_converged: np.ndarray


def fit_robustly(points, fit_of, norm, start_weights=None):
    """Iteratively reweighted least squares of all models at once.

    Parameters
    ----------
    points : CommonPoints
    fit_of : callable
        Fits CommonPoints.
    norm : Norm
    start_weights : ndarray, shape (n_points,), optional
        Weights to begin with; a norm that gives the weight 0 needs good ones.

    Returns
    -------
    RobustFit

    Notes
    -----
    The scale of each model is the median length of its residuals over that of a normal
    vector, and over √(redundancy / observations), since residuals are smaller than
    errors.
    """
    given = points.weights
    weights = given.copy() if start_weights is None else start_weights.copy()
    active = np.arange(len(points.start) - 1)
    for _ in range(MOST_ITERATIONS):
        rows, part = points.of_models(active)
        fit = fit_of(replace(part, weights=weights[rows]))
        factors = _factors(fit, given[rows], part, norm)
        change = np.abs(factors - weights[rows] / given[rows])
        largest = segment_min_max(change, part.start)[1]
        weights[rows] = factors * given[rows]
        active = active[largest > TOLERANCE]
        if len(active) == 0:
            break
    is_converged = np.ones(len(points.start) - 1, dtype=bool)
    is_converged[active] = False
    fit = fit_of(replace(points, weights=weights))
    consistent = replace(fit, sum_of_squares=fit.sum_of_squares / norm.consistency)
    return RobustFit(consistent, weights, is_converged)


def _factors(fit, given, part, norm):
    """Factors of the weights that follow from the residuals of a fit."""
    n_axes = fit.residuals.shape[1]
    # models that cannot be fitted have no residuals
    length = np.sqrt(given * np.sum(np.nan_to_num(fit.residuals) ** 2, axis=1))
    n_observations = n_axes * np.diff(part.start)
    share = fit.redundancy / np.maximum(n_observations, 1)
    usual = np.sqrt(chdtri(n_axes, 0.5) * share)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = segment_median(length, part.start) / usual
    # where half of the points fit exactly there is no scale: nothing is changed
    scale = np.where(scale > 0.0, scale, np.inf)[part.model]
    return np.maximum(norm.weights(length / scale), LEAST_FACTOR)


def segment_median(values, start):
    """Median of each segment.

    Parameters
    ----------
    values : ndarray, shape (n_rows,)
        Sorted by segment.
    start : ndarray of int, shape (n_segments + 1,)

    Returns
    -------
    ndarray, shape (n_segments,)
        NaN where a segment is empty or holds NaN.
    """
    count = np.diff(start)
    family = np.repeat(np.arange(len(count)), count)
    ordered = np.append(values[np.lexsort((values, family))], np.nan)
    low = np.where(count > 0, start[:-1] + (count - 1) // 2, -1)
    high = np.where(count > 0, start[:-1] + count // 2, -1)
    median = 0.5 * (ordered[low] + ordered[high])
    is_known = segment_sum(np.isnan(values).astype(np.int64), start) == 0
    return np.where(is_known, median, np.nan)
