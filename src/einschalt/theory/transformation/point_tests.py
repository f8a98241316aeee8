"""Tests of the points that were fitted, and of points that were kept out of the fit.

Both coordinates of a point are tested together in plan. Heights from a narrow base
are several times worse, and would spoil that test: they have one of their own.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import segment_sum
from einschalt.foundations.sorted_points import SortedPoints
from einschalt.theory.adjustment.reliability import (
    FittedPoints,
    PointTests,
    joint_point_tests,
    joint_prediction_tests,
)
from einschalt.theory.transformation.height_tests import (
    HEIGHT,
    fitted_height_tests,
    other_height_tests,
)


@dataclass(frozen=True, eq=False)
class CommonPoints(SortedPoints):
    """Points that are known in both frames, sorted by model."""

    source: np.ndarray  # both (n, n_coordinates)
    target: np.ndarray
    weights: np.ndarray  # (n,)
    # of int, (n_models + 1,): model k owns rows ``start[k]:start[k + 1]``
    start: np.ndarray

    def _taken(self, rows, start, *_):
        taken = (array[rows] for array in (self.source, self.target, self.weights))
        return CommonPoints(*taken, start)


@dataclass(frozen=True, eq=False)
class PlanSums:
    """Squares and redundancy of easting and northing alone, of each model."""

    sum_of_squares: np.ndarray  # (n_models,): Σ w (v_E² + v_N²) [m²]
    # (n_models,): not a whole number where heights were fitted with the plan
    redundancy: np.ndarray


def plan_sums(fit, weights, start):
    """Squares and redundancy of easting and northing alone.

    Heights from a narrow base are several times worse than positions: in a common s_0
    they would spoil the figure for the plan.
    """
    if fit.residuals.shape[1] == 2:
        return PlanSums(fit.sum_of_squares, fit.redundancy)
    squares = weights * np.sum(fit.residuals[:, :2] ** 2, axis=1)
    share = np.sum(1.0 - fit.leverage[:, :2], axis=1)
    redundancy = segment_sum(share, start)
    return PlanSums(
        segment_sum(squares, start), np.where(fit.redundancy > 0, redundancy, 0.0)
    )


def fitted_tests(fit, points):
    """Test of every point that was fitted: in plan, and in height if it has one.

    Of plan and height the less probable one counts, after Bonferroni; ``w`` is that of
    the plan.
    """
    plan = fitted_point_tests(fit, points)
    if fit.residuals.shape[1] == HEIGHT:
        return plan
    return PointTests(plan.w, _either(plan.p_value, fitted_height_tests(fit, points)))


def _either(plan, height):
    """Probability of the less probable of both tests, where both are made twice it."""
    n_tests = np.isfinite(plan).astype(int) + np.isfinite(height)
    return np.minimum(np.fmin(plan, height) * n_tests, 1.0)


def fitted_point_tests(fit, points):
    """Joint test in plan of every point that was fitted."""
    sums = plan_sums(fit, points.weights, points.start)
    tested = FittedPoints(
        residuals=fit.residuals[:, :2],
        weights=points.weights,
        leverage=fit.leverage[:, :2],
        cross_leverage=_cross_leverage(fit, points),
        start=points.start,
    )
    return joint_point_tests(tested, sums.sum_of_squares, sums.redundancy)


def other_tests(fit, in_fit, model, points):
    """Test of points that took no part in the fit, in plan and in height: PointTests.

    ``in_fit`` are the points that did, ``model`` (n,) is that of each row.
    """
    sums = plan_sums(fit, in_fit.weights, in_fit.start)
    residuals, plan = other_point_tests(fit, sums, model, points)
    if residuals.shape[1] == HEIGHT:
        return plan
    height = other_height_tests(fit, in_fit, model, points)
    return PointTests(plan.w, _either(plan.p_value, height))


def other_point_tests(fit, sums, model, points):
    """Joint test in plan of points that took no part in the fit.

    Residuals [m], and PointTests. ``sums`` are those of the fit, ``model`` (n,) is that
    of each row; residuals are transformed minus given, (n, n_coordinates).
    """
    residuals = fit.apply(model, points.source) - points.target
    cofactors = fit.point_cofactors(model, points.source)[:, :2, :2].copy()
    cofactors[:, [0, 1], [0, 1]] += 1.0 / points.weights[:, None]
    plan = residuals[:, :2]
    squares = np.sum(plan * np.linalg.solve(cofactors, plan[:, :, None])[:, :, 0], 1)
    tests = joint_prediction_tests(
        squares, sums.sum_of_squares[model], sums.redundancy[model]
    )
    return residuals, tests


def _cross_leverage(fit, points):
    """Off-diagonal of each point's block of the hat matrix, easting with northing."""
    if fit.kind in {"affine", "helmert"}:
        return np.zeros(len(points.weights))
    cofactors = fit.point_cofactors(points.model, points.source)
    return points.weights * cofactors[:, 0, 1]
