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

from einschalt.foundations.batches import over_segments, segment_min_max
from einschalt.foundations.kernels import compiled
from einschalt.theory.adjustment.multiple_testing import count_tested

MOST_ITERATIONS = 100
TOLERANCE = 1e-5
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
    is_out = np.zeros(len(points.weights), dtype=bool)
    rows, part = np.arange(len(is_out)), points
    while len(rows):
        worst = _worst_rows(tests_of(part).p_value, part.start, significance)
        is_out[rows[worst]] = True
        changed = np.unique(part.model[worst])
        kept, part = part.of_models(changed)
        rows = rows[kept]
        part = part.chosen(~is_out[rows])
        rows = rows[~is_out[rows]]
    return is_out


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
    """Robust fits of all models."""

    # with the final weights; its sum of squares makes s_0 that of a good observation
    fit: object
    weights: np.ndarray  # (n_points,): the given weights times the factors of the norm
    is_converged: np.ndarray  # (n_models,)


def fit_robustly(points, fit_of, norm, start_weights=None) -> RobustFit:
    """Iteratively reweighted least squares of all models at once.

    Parameters
    ----------
    points : CommonPoints
    fit_of : callable
        Fits CommonPoints.
    norm : Norm
    start_weights : ndarray, shape (n_points,), optional
        Weights to begin with; a norm that gives the weight 0 needs good ones.

    Notes
    -----
    The scale of each model is the median length of its residuals over that of a normal
    vector, and over √(redundancy / observations), since residuals are smaller than
    errors.
    """
    given = points.weights
    weights = given.copy() if start_weights is None else start_weights.copy()
    rows, part, active = np.arange(len(given)), points, np.arange(len(points.start) - 1)
    for _ in range(MOST_ITERATIONS):
        fit = fit_of(replace(part, weights=weights[rows]))
        factors = _factors(fit, part, norm)
        change = np.abs(factors - weights[rows] / part.weights)
        largest = segment_min_max(change, part.start)[1]
        weights[rows] = factors * part.weights
        moving = np.flatnonzero(largest > TOLERANCE)
        kept, part = part.of_models(moving)
        rows, active = rows[kept], active[moving]
        if len(active) == 0:
            break
    is_converged = np.ones(len(points.start) - 1, dtype=bool)
    is_converged[active] = False
    fit = fit_of(replace(points, weights=weights))
    consistent = replace(fit, sum_of_squares=fit.sum_of_squares / norm.consistency)
    return RobustFit(consistent, weights, is_converged)


def _factors(fit, part, norm):
    """Factors of the weights that follow from the residuals of a fit."""
    # models that cannot be fitted have no residuals
    squares = np.sum(np.nan_to_num(fit.residuals) ** 2, axis=1)
    length = np.sqrt(part.weights * squares)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = segment_median(length, part.start) / usual_length(fit, part)
    # where half of the points fit exactly there is no scale: nothing is changed
    scale = np.where(scale > 0.0, scale, np.inf)[part.model]
    return np.maximum(norm.weights(length / scale), LEAST_FACTOR)


def usual_length(fit, points):
    """Median length of the residuals of each model where the standard error is 1.

    √(χ²_k(½) f / (k n)) with the redundancy f of n points with k coordinates.
    """
    n_coordinates = fit.residuals.shape[1]
    n_observations = n_coordinates * np.diff(points.start)
    share = fit.redundancy / np.maximum(n_observations, 1)
    return np.sqrt(chdtri(n_coordinates, 0.5) * share)


def segment_median(values, start):
    """Median of each segment; NaN where one is empty or holds NaN."""
    median = np.full(len(start) - 1, np.nan)
    over_segments(_medians, np.asarray(start), np.asarray(values, float), median)
    return median


@compiled
def _medians(first, last, start, values, median):
    for k in range(first, last):
        count = start[k + 1] - start[k]
        if count == 0:
            continue
        ordered = np.sort(values[start[k] : start[k + 1]])
        # NaN stand last
        if not np.isnan(ordered[-1]):
            median[k] = 0.5 * (ordered[(count - 1) // 2] + ordered[count // 2])
