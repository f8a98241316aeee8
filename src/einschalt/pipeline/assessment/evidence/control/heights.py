"""Do the claimed heights stand? What was measured, against what they predict.

The same question as of the plan, asked of heights by themselves: control points that
are predicted without themselves, residuals at given points where no high flight lies
between, and check points. Their covariances are known from the operators of the
propagation, so that nothing has to be drawn. What none of them would show is told.

See docs/theory/claim.md.
"""

from dataclasses import dataclass, fields

import numpy as np
from scipy.special import chdtrc

from einschalt.foundations.names import encode, is_among
from einschalt.pipeline.assessment.evidence.claim import (
    KNOWN,
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
from einschalt.stages.error_propagation.given_points import (
    control_among_approximations,
)
from einschalt.theory.adjustment.global_tests import ratio_limits
from einschalt.theory.adjustment.monte_carlo import tail_of_correlated_squares
from einschalt.theory.adjustment.multiple_testing import is_rejected_by_holm
from einschalt.theory.adjustment.point_operator import Axes, sums
from einschalt.theory.adjustment.reliability import noncentrality
from einschalt.theory.adjustment.significance import (
    CLAIM_SIGNIFICANCE,
    FINDING_SIGNIFICANCE,
    MIN_REPORTED_RATIO,
    SYSTEMATIC_SIGNIFICANCE,
)

HEIGHT_OF_CHECK = KNOWN["check"]
STATED = "standard_error_height"
# where errors are only assumed, measured heights have those of plan; heights of
# photographs are worse by the angle of their rays. In 40 simulated blocks of spatial
# models errors of the points' heights were 1.16 times as large as assumed
OF_ASSUMED = 1.25
# of more points the covariance would be too large: the first of them stand for all
MOST_POINTS = 2000
# to which principal distances are known where a camera is named, but not calibrated
LEAST_OF_SCALE = 0.02


@dataclass(frozen=True, eq=False)
class KnownHeights:
    """Densified minus given heights of known points that took no part."""

    point_ids: np.ndarray  # shape (n_points,)
    roles: np.ndarray  # of each, "check" or "control"
    differences: np.ndarray  # shape (n_points,) [m]
    standard_errors: np.ndarray  # of the differences, shape (n_points,) [m]

    @property
    def count(self) -> int:
        """Number of points."""
        return len(self.point_ids)

    @property
    def rms(self) -> float:
        """Root mean square of the differences [m]."""
        return float(np.sqrt(np.mean(self.differences**2)))

    @property
    def p_values(self) -> np.ndarray:
        """Probability of a difference as large as each, shape (n_points,)."""
        return chdtrc(1, (self.differences / self.standard_errors) ** 2)

    @property
    def far(self) -> np.ndarray:
        """Names of those that contradict the claim each by itself, farthest first."""
        is_far = is_rejected_by_holm(self.p_values, FINDING_SIGNIFICANCE)
        by_size = np.argsort(-np.abs(self.differences), kind="stable")
        return self.point_ids[by_size][is_far[by_size]]

    def picked(self, is_picked):
        """Some of the points."""
        return KnownHeights(*(getattr(self, f.name)[is_picked] for f in fields(self)))


@dataclass(frozen=True)
class LoneHeight:
    """The height of a known point that took no part and is far off, as no other is."""

    point_id: str
    role: str
    size: float  # its difference [m]
    expected: float  # standard error of that [m]
    n_others: int
    rms_of_others: float  # of their differences [m]


def known_heights(examined) -> KnownHeights:
    """Heights of check points, and of control that took no part, against the given.

    Of those whose standard errors are known, or assumed.
    """
    rows = _known_rows(examined)
    if rows.empty:
        return KnownHeights(*np.empty((2, 0), dtype=object), *np.empty((2, 0)))
    errors = _errors_of_differences(examined, rows)
    known = KnownHeights(
        *(rows[name].to_numpy(dtype=object) for name in ("point_id", "role")),
        rows["difference_height"].to_numpy(dtype=float),
        errors,
    )
    return known.picked(np.isfinite(known.differences) & (errors > 0.0))


def _known_rows(examined):
    """Rows of known points that have heights and took no part, the first of many."""
    points = examined.solution.points
    if not {"height", "difference_height"} <= set(points):
        return points.iloc[:0]
    is_known = points["role"] == "check"
    if not examined.control_takes_part:
        took_part = control_among_approximations(examined.block)
        is_out = ~is_among(points["point_id"], took_part)
        is_known |= (points["role"] == "control") & is_out
    return points[is_known].head(MOST_POINTS)


def _errors_of_differences(examined, rows):
    """Standard errors of densified minus given heights; NaN where nothing is known."""
    two_step, block = examined.two_step, examined.block
    of_points = np.full(len(rows), np.nan)
    if STATED in rows:
        of_points = rows[STATED].to_numpy(dtype=float)
    elif two_step.is_possible and two_step.given_heights is not None:
        assumed = two_step.given_heights.predicted_at(rows["point_id"])
        of_points = OF_ASSUMED * assumed
    if "standard_error_m" not in block.control_points:
        return of_points
    nothing = Densified({}, {}, examined.group_error, is_group_error_known=False)
    ids = rows["point_id"].to_numpy(dtype=object)
    of_given = covariance_of_differences(block, ids, Axes.SPACE, HEIGHT, nothing)
    if of_given is None:  # shifts of groups whose size nobody states
        return np.full(len(rows), np.nan)
    return np.sqrt(of_points**2 + np.nan_to_num(np.diag(of_given)))


def find_lone_height(examined, *, is_without_control=False) -> LoneHeight | None:
    """The height of a known point that took no part and alone contradicts the claim.

    None unless the others agree with it and are so much nearer that chance would not
    make them so if all were as far off as the root mean square with it; nor where
    control that was left out contradicts its heights, unless some of it was set aside
    (``is_without_control``).
    """
    known = examined.known_heights
    if known.count < 2 or len(known.far) != 1:
        return None
    (name,) = known.far
    is_it = known.point_ids == name
    others = known.picked(~is_it)
    nearest, _ = ratio_limits(others.count, FINDING_SIGNIFICANCE, MIN_REPORTED_RATIO)
    if len(others.far) or not others.rms < nearest * known.rms:
        return None
    is_asked = examined.two_step.is_possible and not is_without_control
    left_out = _left_out(examined.two_step) if is_asked else None
    if left_out is not None and left_out.p_value <= CLAIM_SIGNIFICANCE:
        return None
    ((row,),) = np.nonzero(is_it)
    return LoneHeight(
        name,
        known.roles[row],
        float(abs(known.differences[row])),
        float(known.standard_errors[row]),
        others.count,
        others.rms,
    )


def examine_height_claim(examined) -> Claim:
    """Test heights of known points against what the claimed heights predict."""
    if examined.errors is None or examined.errors.axes is not Axes.SPACE:
        return _by_single_points(examined)
    tests = (
        _left_out(examined),
        _given(examined),
        _check(examined, examined),
        _check(examined, examined, role="control"),
    )
    return Claim(tuple(test for test in tests if test is not None), None)


def examine_adjusted_heights(adjusted, *, is_without_control) -> Claim:
    """The same of one adjustment.

    What its points share is known of the two steps only. ``is_without_control``: some
    control was set aside, and what the two steps make of it says nothing of it.
    """
    two_step = adjusted.two_step
    is_known = two_step.is_possible and two_step.errors is not None
    if not is_known or two_step.errors.axes is not Axes.SPACE:
        return _by_single_points(adjusted)
    left_out = None if is_without_control else _left_out(two_step)
    check = _check(two_step, adjusted)
    return Claim(tuple(test for test in (left_out, check) if test is not None), None)


def _by_single_points(examined):
    """The test of the farthest point (Bonferroni), whatever points have in common."""
    known, lone = examined.known_heights, examined.lone_height
    if lone is not None:
        known = known.picked(known.point_ids != lone.point_id)
    tests = []
    for role in np.unique(known.roles):
        of_role = known.picked(known.roles == role)
        predicted = float(np.sqrt(np.mean(of_role.standard_errors**2)))
        p_value = min(float(of_role.count * of_role.p_values.min()), 1.0)
        sizes = of_role.count, of_role.rms, predicted
        tests.append(ClaimTest(KNOWN[role], *sizes, p_value))
    return Claim(tuple(tests), None) if tests else UNTESTED


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


def _check(two_step, asked, role="check"):
    """Known points but for a lone one: densified minus given, both with errors.

    Those that ``asked`` compares, the two steps or an adjustment beside them.
    """
    errors, lone, points = two_step.errors, asked.lone_height, asked.solution.points
    names = asked.known_heights.point_ids[asked.known_heights.roles == role]
    missed = points["difference_height"].notna() & is_among(points["point_id"], names)
    # of a point that the two steps do not have nothing is propagated
    missed &= is_among(points["point_id"], errors.point_ids)
    if lone is not None:
        missed &= points["point_id"] != lone.point_id
    rows = points[missed].head(MOST_POINTS)
    if rows.empty:
        return None
    ids = rows["point_id"].to_numpy(dtype=object)
    chains = _chains_of(errors, ids)
    if asked is not two_step:  # as alike, but not of that size
        found = covariance_of(chains, errors.standard_errors, HEIGHT)
        sizes = rows[STATED].to_numpy(dtype=float)
        factors = sizes / np.sqrt(np.diag(found))
        if not np.isfinite(factors).all():
            return None
        chains = _chains_of(errors, ids, factors)
    densified = Densified(
        chains,
        errors.standard_errors,
        two_step.group_error,
        is_group_error_known=False,
    )
    covariance = covariance_of_differences(
        two_step.block, ids, Axes.SPACE, HEIGHT, densified
    )
    if covariance is None:
        return None
    differences = rows["difference_height"].to_numpy(dtype=float)
    return _test(KNOWN[role], differences, covariance)


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
