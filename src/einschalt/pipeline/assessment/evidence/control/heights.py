"""Do the claimed heights stand? What was measured, against what they predict.

The same question as of the plan, asked of heights by themselves: control points that
are predicted without themselves, residuals at given points where no high flight lies
between, and check points. Their covariances are known from the operators of the
propagation, so that nothing has to be drawn. What none of them would show is told.

See docs/theory/claim.md.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.names import encode, is_among
from einschalt.pipeline.assessment.evidence.claim import (
    LEFT_OUT,
    RESIDUALS,
    UNTESTED,
    Claim,
    ClaimTest,
)
from einschalt.pipeline.assessment.evidence.control.patterns import signatures_of_scale
from einschalt.pipeline.assessment.evidence.control.signatures import (
    HEIGHT,
    covariance_of,
)
from einschalt.pipeline.assessment.evidence.known_differences import (
    Densified,
    covariance_of_differences,
)
from einschalt.theory.adjustment.monte_carlo import tail_of_correlated_squares
from einschalt.theory.adjustment.point_operator import Axes, sums
from einschalt.theory.adjustment.reliability import noncentrality
from einschalt.theory.adjustment.significance import SYSTEMATIC_SIGNIFICANCE

HEIGHT_OF_CHECK = "check points"
# of more points the covariance would be too large: the first of them stand for all
MOST_POINTS = 2000
# to which principal distances are known where a camera is named, but not calibrated
LEAST_OF_SCALE = 0.02


def examine_height_claim(examined) -> Claim:
    """Test heights of known points against what the claimed heights predict."""
    if examined.errors is None or examined.errors.axes is not Axes.SPACE:
        return UNTESTED
    tests = (
        _left_out(examined),
        _given(examined),
        _check(examined, examined.solution.points),
    )
    return Claim(tuple(test for test in tests if test is not None), None)


def examine_adjusted_heights(two_step, points, *, is_without_control) -> Claim:
    """The same of one adjustment, which gives the ``points``.

    What they share is known of the two steps only. ``is_without_control``: some control
    was set aside, and what the two steps make of it says nothing of the adjustment.
    """
    if two_step.errors is None or two_step.errors.axes is not Axes.SPACE:
        return UNTESTED
    left_out = None if is_without_control else _left_out(two_step)
    tests = (left_out, _check(two_step, points))
    return Claim(tuple(test for test in tests if test is not None), None)


@dataclass(frozen=True)
class UnseenScale:
    """A scale of model heights that is wrong by much, and passes unseen."""

    detectable: float  # ratio from which on it is found in 80 of 100 cases
    moved_per_cent: float  # new points' heights by a per cent of it, RMS [m]


def unseen_scale(examined) -> UnseenScale | None:
    """How wrong the scale of heights may be and pass unseen; None if that is nothing.

    Nothing beside the stated error of the heights.
    """
    two_step = examined.two_step
    if not two_step.is_possible or two_step.error_model is None:
        return None
    shown, moved_by_one = signatures_of_scale(two_step)
    information = float(shown @ shown)
    if not information > 0.0:
        return None
    found = noncentrality(SYSTEMATIC_SIGNIFICANCE) / np.sqrt(information)
    if found < LEAST_OF_SCALE or not found * moved_by_one > examined.stated_height:
        return None
    return UnseenScale(float(found), 0.01 * moved_by_one)


def _given(examined):
    """Residuals at given points, the mean of their models."""
    given = examined.given_heights
    if given is None:
        return None
    return _test(RESIDUALS, given.residuals, given.variances)


def _left_out(examined):
    left_out = examined.left_out_control
    if left_out is None or len(left_out.point_ids) > MOST_POINTS:
        return None
    sizes = examined.error_model.standard_errors
    covariance = covariance_of(left_out.chains, sizes, HEIGHT)
    return _test(LEFT_OUT, left_out.of_heights[0], covariance)


def _check(examined, points):
    """Check points: densified minus given, both with errors."""
    errors = examined.errors
    missed = points["difference_height"].notna() & (points["role"] == "check")
    # of a point that the two steps do not have nothing is propagated
    missed &= is_among(points["point_id"], errors.point_ids)
    rows = points[missed].head(MOST_POINTS)
    if rows.empty:
        return None
    ids = rows["point_id"].to_numpy(dtype=object)
    chains = _chains_of(errors, ids)
    if points is not examined.solution.points:  # as alike, but not of that size
        found = covariance_of(chains, errors.standard_errors, HEIGHT)
        sizes = rows["standard_error_height"].to_numpy(dtype=float)
        factors = sizes / np.sqrt(np.diag(found))
        if not np.isfinite(factors).all():
            return None
        chains = _chains_of(errors, ids, factors)
    densified = Densified(
        chains,
        errors.standard_errors,
        examined.group_error,
        is_group_error_known=False,
    )
    covariance = covariance_of_differences(
        examined.block, ids, Axes.SPACE, HEIGHT, densified
    )
    if covariance is None:
        return None
    differences = rows["difference_height"].to_numpy(dtype=float)
    return _test(HEIGHT_OF_CHECK, differences, covariance)


def _chains_of(errors, point_ids, factors=None):
    """From each source of errors to some points; ``factors`` enlarge their errors."""
    places = encode(errors.point_ids).locate(encode(point_ids))
    n = len(places)
    factors = np.ones(n) if factors is None else factors
    pick = sums(factors, places, np.arange(n + 1), len(errors.point_ids), errors.axes)
    return {name: (pick @ chain).formed() for name, chain in errors.chains.items()}


def _test(name, differences, covariance):
    if not len(differences):
        return None
    predicted = float(np.sqrt(np.trace(covariance) / len(differences)))
    p_value = tail_of_correlated_squares(float(np.sum(differences**2)), covariance)
    observed = float(np.sqrt(np.mean(differences**2)))
    return ClaimTest(name, len(differences), observed, predicted, p_value)
