"""What points with given coordinates say of the claimed figure."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.credibility import MIN_REPORTED_RATIO, TOTAL
from einschalt.pipeline.assessment.evidence.control.signatures import PLAN
from einschalt.pipeline.assessment.evidence.known_differences import (
    Densified,
    covariance_of_differences,
    shared_differences,
)
from einschalt.stages.error_propagation.given_points import group_members
from einschalt.theory.adjustment.global_tests import (
    mean_p_values,
    ratio_limits,
    ratio_p_value,
)
from einschalt.theory.adjustment.multiple_testing import (
    bonferroni,
    is_rejected_by_holm,
)
from einschalt.theory.adjustment.point_operator import Axes
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE
from einschalt.theory.block_adjustment.gross_errors import NORMS

DIFFERENCES = ["difference_easting", "difference_northing"]
ERRORS = ["standard_error_easting", "standard_error_northing", "covariance_en"]


@dataclass(frozen=True, eq=False)
class KnownPoints:
    """Densified minus given coordinates of known points, against what is claimed."""

    point_ids: np.ndarray  # shape (n_points,)
    differences: np.ndarray  # shape (n_points, 2) [m]
    # of the differences, since both coordinates have errors: TOTAL, root mean square
    # [m]; NaN where it is not known
    claimed: float
    degrees: float  # of freedom; fewer than coordinates where points share errors
    # of the mean difference if the claim holds, shape (2, 2) [m²]; None where it is not
    # known
    covariance_of_mean: np.ndarray | None = None

    @property
    def count(self) -> int:
        """Number of points."""
        return len(self.point_ids)

    @property
    def rms(self) -> float:
        """Root mean square of the differences, TOTAL [m]; NaN without points."""
        return total_rms(self.differences)

    @property
    def ratio(self) -> float:
        """Root mean square by the claimed one."""
        return self.rms / self.claimed

    @property
    def are_beyond(self) -> bool:
        """Whether the differences are larger than chance explains."""
        return bool(self.ratio > self._limits()[1])

    @property
    def are_too_small(self) -> bool:
        """Whether the differences are smaller than chance explains."""
        return bool(self.ratio < self._limits()[0])

    @property
    def p_value(self) -> float:
        """Probability of differences this large if the claim holds."""
        return float(ratio_p_value(self.ratio, self.degrees))

    @property
    def shift_p_value(self) -> float:
        """Probability of a mean difference this far from zero, if there is no shift.

        That of both coordinates: of normal errors as the points share them, and of
        independent ones of the size that the differences show (Student's t,
        Bonferroni): the larger one. NaN for fewer than two points.
        """
        by_spread = np.nanmin(bonferroni(mean_p_values(self.differences)))
        if self.covariance_of_mean is None:
            return float(by_spread)
        shift = self.differences.mean(axis=0)
        square = shift @ np.linalg.solve(self.covariance_of_mean, shift)
        return float(max(by_spread, np.exp(-square / 2.0)))

    def without(self, names):
        """The known points but for some, against the same claim."""
        return picked(self, ~is_among(self.point_ids, names))

    def _limits(self):
        return ratio_limits(self.degrees, FINDING_SIGNIFICANCE, MIN_REPORTED_RATIO)


def total_rms(differences):
    """Root mean square of differences (n, 2), TOTAL [m]; NaN where none is known."""
    squares = np.sum(differences**2, axis=1)
    squares = squares[np.isfinite(squares)]
    return float(np.sqrt(squares.mean())) if len(squares) else np.nan


def check_points(examined) -> KnownPoints:
    """Check points, which entered no fit."""
    points = examined.points
    return _compared(examined, points[points["role"] == "check"])


def confirmed_check_points(adjusted) -> KnownPoints:
    """Check points that tell what an adjustment is worth.

    Not those of which a robust norm has left one measurement with its weight, or none:
    nothing confirms that. They tell how far such points are off, which are suspects and
    are counted by their own values; where they are taken out, the standard error of the
    point tells it.
    """
    known = adjusted.known_check
    if adjusted.settings.outliers not in NORMS:
        return known
    is_alone = is_among(known.point_ids, unconfirmed_points(adjusted.residuals))
    return picked(known, ~is_alone) if is_alone.any() else known


def unconfirmed_points(residuals) -> np.ndarray:
    """Names of points with refused measurements, and no two that confirm each other."""
    is_suspect = residuals["is_suspect"].astype(bool)
    n_good = (~is_suspect).groupby(residuals["point_id"]).sum()
    has_refused = is_suspect.groupby(residuals["point_id"]).any()
    return n_good.index[(n_good < 2) & has_refused].to_numpy(dtype=object)


def control_points(examined) -> KnownPoints:
    """Control points that the result holds."""
    return _compared(examined, examined.held_control)


def _compared(examined, rows):
    differences = values_of(rows, DIFFERENCES)
    names = rows["point_id"].to_numpy(dtype=object)
    claimed = _claimed(examined, rows)
    shared = shared_differences(examined, names) if claimed > 0.0 else None
    if shared is None:
        degrees = _degrees(examined, names, claimed)
        return KnownPoints(names, differences, claimed, degrees)
    of_mean = claimed**2 * shared.covariance_of_mean
    return KnownPoints(names, differences, claimed, shared.degrees, of_mean)


def contradicting_points(examined) -> np.ndarray:
    """Names of check points that contradict the claim, each by itself.

    Normal errors of the covariances that are claimed for the points, and of those of
    the given coordinates: χ² with 2 degrees of freedom, Holm over all check points.
    """
    known = examined.known_check
    points = examined.points
    rows = points[points["role"] == "check"]
    if not known.count or not set(ERRORS) <= set(rows):
        return known.point_ids[:0]
    east, north, both = values_of(rows, ERRORS).T
    given = given_errors(examined, rows["point_id"]) ** 2 / 2.0
    shared = examined.figures.shared_error**2 / 2.0
    east, north = (v**2 + given - shared for v in (east, north))
    d_east, d_north = known.differences.T
    determinant = east * north - both**2
    squares = north * d_east**2 - 2.0 * both * d_east * d_north + east * d_north**2
    p_value = np.exp(-squares / determinant / 2.0)
    family = np.array([0, len(p_value)])
    return known.point_ids[is_rejected_by_holm(p_value, family, FINDING_SIGNIFICANCE)]


def few_contradicting_points(examined) -> np.ndarray:
    """Names of the check points that contradict the claim, if the others agree with it.

    None unless these are the majority.
    """
    return _few(examined.known_check, contradicting_points(examined))


def far_control(examined) -> np.ndarray:
    """Names of the few control points that contradict the claim, as others do not.

    Each by itself: normal errors of the root mean square that is claimed for all, Holm
    over all control points.
    """
    known = examined.known_control
    if not known.are_beyond:
        return known.point_ids[:0]
    p_value = np.exp(-np.sum(known.differences**2, axis=1) / known.claimed**2)
    family = np.array([0, known.count])
    is_far = is_rejected_by_holm(p_value, family, FINDING_SIGNIFICANCE)
    return _few(known, known.point_ids[is_far])


def _few(known, names):
    """Some known points, if they are the minority and the others agree with a claim."""
    is_other = ~np.isin(known.point_ids, names)
    is_few = 2 * len(names) < known.count and not picked(known, is_other).are_beyond
    return names if is_few else names[:0]


def picked(known, is_picked):
    """Some of the known points, against the same claim."""
    return replace(
        known,
        point_ids=known.point_ids[is_picked],
        differences=known.differences[is_picked],
        degrees=known.degrees * np.mean(is_picked),
        covariance_of_mean=None,
    )


def lone_contradiction(examined) -> KnownPoints | None:
    """The other check points, where a single one makes their differences too large.

    None unless one point alone contradicts the claim, the others do not, and they are
    so much nearer that chance would not make them so if all points were as far off as
    the root mean square with it; nor where control that may be wrong moves the block
    there. It may be wrong there all the same: no figure gets smaller by this.
    """
    known, names = examined.known_check, contradicting_points(examined)
    if not known.are_beyond or len(names) != 1 or _is_near_doubt(examined, names[0]):
        return None
    others = picked(known, known.point_ids != names[0])
    beside = replace(others, claimed=known.rms)
    return others if beside.are_too_small and not others.are_beyond else None


def _is_near_doubt(examined, name):
    """Whether a point shares a high model with control that others do not confirm."""
    high = examined.oriented_high_points
    if high is None:
        return False
    model = pd.MultiIndex.from_frame(high[["coverage", "model_id"]])
    is_there = model.isin(model[high["point_id"] == name])
    control = examined.block.control_points
    control = control.loc[control["role"] != "check", "point_id"]
    doubtful = set(control) - set(examined.left_out_differences.index)
    return not doubtful.isdisjoint(high.loc[is_there, "point_id"])


def _degrees(examined, point_ids, claimed):
    """Degrees of freedom of the squares of differences, by Satterthwaite.

    As if densified points shared nothing, where no model tells what they share.
    """
    block, n = examined.block, len(point_ids)
    if not (n and claimed > 0.0 and examined.shares_control_errors):
        return 2.0 * n
    nothing = Densified({}, {}, examined.group_error)
    shared = covariance_of_differences(block, point_ids, Axes.COMPLEX, PLAN, nothing)
    shared = shared[:n, :n]  # both coordinates are alike
    rest = max(claimed**2 / 2.0 - np.trace(shared) / n, 0.0)
    covariance = shared + rest * np.eye(n)
    return float(2.0 * np.trace(covariance) ** 2 / np.sum(covariance**2))


def given_errors(examined, point_ids):
    """TOTAL errors of given coordinates [m]; 0 where none is stated."""
    given = examined.block.control_points
    if given is None or "standard_error_m" not in given:
        return np.zeros(len(point_ids))
    errors = given.set_index("point_id")["standard_error_m"].astype(float)
    own = np.nan_to_num(errors.reindex(point_ids).to_numpy())
    members = group_members(given)
    if members is None:
        return own
    is_in_group = pd.Series(members.sum(axis=1), index=given["point_id"].to_numpy())
    return np.hypot(own, examined.group_error * is_in_group.reindex(point_ids))


def _claimed(examined, rows):
    """Total figure claimed for densified - given: both have an error."""
    variance = rows[examined.claimed_column].to_numpy(dtype=float) ** 2
    if examined.claimed_column == TOTAL:
        # given and densified share it, so that their difference is without
        variance = np.maximum(variance - examined.figures.shared_error**2, 0.0)
    variance = variance + given_errors(examined, rows["point_id"]) ** 2
    variance = variance[np.isfinite(variance)]
    return float(np.sqrt(variance.mean())) if len(variance) else np.nan
