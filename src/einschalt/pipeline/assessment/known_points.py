"""What points with given coordinates say of the claimed figure."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import is_among, rows_of_names
from einschalt.pipeline.assessment.credibility import (
    LEAST_OF_CLAIM,
    TOTAL,
    larger_column,
)
from einschalt.pipeline.assessment.evidence.control.signatures import PLAN
from einschalt.pipeline.assessment.evidence.known_differences import (
    Densified,
    covariance_of_differences,
    shared_differences,
)
from einschalt.stages.error_propagation.error_model import LOW
from einschalt.stages.error_propagation.given_points import (
    control_among_approximations,
    group_members,
)
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
from einschalt.theory.adjustment.significance import (
    FINDING_SIGNIFICANCE,
    MIN_REPORTED_RATIO,
)
from einschalt.theory.block_adjustment.gross_errors import NORMS

DIFFERENCES = ["difference_easting", "difference_northing"]
ERRORS = ["standard_error_easting", "standard_error_northing", "covariance_en"]
# how near a new point lies to where another one is given, if it is that one: by what is
# claimed, and by how far the other one is off
WITHIN_CLAIM, MOST_OF_MISS = 10.0, 0.1
FEWEST_CONFIRMING = 2  # measurements of a point
FEWEST_TO_SHOW = 5  # known points, of what errors they have
MOST_LONE = 0.25  # of the known points, where several are far off
ALIKE = 0.5  # cosine of the angle between differences


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


@dataclass(frozen=True)
class LonePoint:
    """A known point that took no part and is far off, as hardly another one is."""

    point_id: str
    miss: float  # its difference, TOTAL [m]
    # name of the new point that lies where this one is given, and how far from it [m]:
    # either stands under the name of the other; empty and NaN without
    found_there: str
    away: float


def total_rms(differences):
    """Root mean square of differences (n, 2), TOTAL [m]; NaN where none is known."""
    squares = np.sum(differences**2, axis=1)
    squares = squares[np.isfinite(squares)]
    return float(np.sqrt(squares.mean())) if len(squares) else np.nan


def check_points(examined) -> KnownPoints:
    """Check points, which entered no fit."""
    points = examined.points
    column = examined.claimed_column
    return _compared(examined, points[points["role"] == "check"], column)


def confirmed_check_points(examined) -> KnownPoints:
    """Check points that tell what a solution is worth: all but lone ones."""
    return _without_lone_points(examined.known_check, examined)


def confirmed_control_points(two_step) -> KnownPoints:
    """Control points that tell what two steps are worth: all but lone ones."""
    return _without_lone_points(two_step.known_control, two_step)


def _without_lone_points(known, examined):
    lone = [each.point_id for each in examined.lone_points]
    return known.without(lone) if lone else known


def check_points_confirmed_by_two(adjusted) -> KnownPoints:
    """Check points that tell what an adjustment is worth.

    Not lone ones, nor those of which a robust norm has left one measurement with its
    weight, or none: nothing confirms that. They tell how far such points are off, which
    are suspects and are counted by their own values; where they are taken out, the
    standard error of the point tells it.
    """
    known = confirmed_check_points(adjusted)
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
    return _compared(examined, examined.held_control, examined.claimed_column)


def _compared(examined, rows, column):
    differences = values_of(rows, DIFFERENCES)
    names = rows["point_id"].to_numpy(dtype=object)
    claimed = _claimed(examined, rows, column)
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
    points = examined.points
    rows = points[points["role"] == "check"]
    names = rows["point_id"].to_numpy(dtype=object)
    if rows.empty or not set(ERRORS) <= set(rows):
        return names[:0]
    east, north, both = values_of(rows, ERRORS).T
    given = given_errors(examined, rows["point_id"]) ** 2 / 2.0
    shared = examined.figures.shared_error**2 / 2.0
    east, north = (v**2 + given - shared for v in (east, north))
    d_east, d_north = values_of(rows, DIFFERENCES).T
    determinant = east * north - both**2
    squares = north * d_east**2 - 2.0 * both * d_east * d_north + east * d_north**2
    p_value = np.exp(-squares / determinant / 2.0)
    return names[is_rejected_by_holm(p_value, FINDING_SIGNIFICANCE)]


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
    return _few(examined.known_control, _far_points(examined.known_control))


def _far_points(known):
    """Names of known points that contradict the figure claimed for all of them."""
    if not known.are_beyond:
        return known.point_ids[:0]
    p_value = np.exp(-np.sum(known.differences**2, axis=1) / known.claimed**2)
    return known.point_ids[is_rejected_by_holm(p_value, FINDING_SIGNIFICANCE)]


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
        degrees=known.degrees * np.mean(is_picked) if known.count else 0.0,
        covariance_of_mean=None,
    )


def find_lone_points(examined) -> tuple[LonePoint, ...]:
    """Known points that took no part and make the differences too large, worst first.

    None unless each of them contradicts the claim by itself and is off by ten times as
    much, the others agree with it, or with what most of them show, and these are so
    much nearer that chance would not make them so if all points were as far off as the
    root mean square with them; nor where control that may be wrong moves the block
    there, or nothing confirms the measurement of a point: a gross error in it tells of
    those that new points have. Nor are several, unless they are few, a model of each
    holds another known point that agrees, and no two neighbours are off alike. What
    they are compared with, or their names, are wrong otherwise, which is no matter of
    the other points, unless one of these lies where one of them is given.
    """
    known = _known_and_far(examined)
    if not all(_agree_without(*each) for each in known):
        shown = [_as_most_show(of_role) for of_role, _ in known]
        known = [(of_role, _far_points(of_role)) for of_role in shown]
    far = np.concatenate([names for _, names in known])
    if not len(far) or not all(_agree_without(*each) for each in known):
        return ()
    others = np.setdiff1d(np.concatenate([of.point_ids for of, _ in known]), far)
    is_few = len(far) <= MOST_LONE * (len(far) + len(others))
    if len(far) > 1 and not (is_few and _are_beside(examined, far, others)):
        return ()
    if _have_neighbours_alike(examined, known, far):
        return ()
    miss = {
        name: float(np.hypot(*difference))
        for of_role, _ in known
        for name, difference in zip(of_role.point_ids, of_role.differences, strict=True)
    }
    if not all(_is_confirmed(examined, name, miss[name]) for name in far):
        return ()
    if any(_is_near_doubt(examined, name) for name in far):
        return ()
    worst = sorted(far, key=lambda name: -miss[name])
    claimed = max(of_role.claimed for of_role, _ in known if of_role.count)
    if miss[worst[-1]] < LEAST_OF_CLAIM * claimed:
        return ()
    return tuple(
        LonePoint(name, miss[name], *_found_there(examined, name, miss[name]))
        for name in worst
    )


def _known_and_far(examined):
    """Known points that took no part, of each role, and names of those that are off."""
    # the claim is tested without them: they are found by what no test has judged
    column, points = larger_column(examined), examined.points
    check = _compared(examined, points[points["role"] == "check"], column)
    known = [(check, _far_check_points(examined, check))]
    if not examined.control_takes_part:
        control = examined.held_control
        took_part = control_among_approximations(examined.block)
        is_out = ~is_among(control["point_id"], took_part)
        control = _compared(examined, control[is_out], column)
        known.append((control, _far_points(control)))
    return known


def _as_most_show(known):
    """Known points against what most of them show, where that is more than claimed.

    Their median, which a wrong one does not move. Two coordinates of equal errors are
    taken, whose square has the median ln 2 of its mean.
    """
    if known.count < FEWEST_TO_SHOW:
        return known
    squares = np.sum(known.differences**2, axis=1)
    shown = float(np.sqrt(np.median(squares) / np.log(2.0)))
    return replace(known, claimed=max(known.claimed, shown), covariance_of_mean=None)


def _agree_without(known, far):
    """Whether known points agree with a claim without some, and are so much nearer."""
    others = picked(known, ~is_among(known.point_ids, far))
    is_nearer = not len(far) or replace(others, claimed=known.rms).are_too_small
    return is_nearer and not others.are_beyond


def _have_neighbours_alike(examined, known, far):
    """Whether one of some points is off in the direction of its nearest, if far too."""
    from scipy.spatial import KDTree  # noqa: PLC0415 - loaded when points are far off

    names = np.concatenate([of_role.point_ids for of_role, _ in known])
    differences = np.concatenate([of_role.differences for of_role, _ in known])
    given = examined.block.control_points.set_index("point_id")
    places = given.loc[names, ["easting", "northing"]].to_numpy(dtype=float)
    rows = np.flatnonzero(is_among(names, far))
    _, two_nearest = KDTree(places).query(places[rows], k=2)
    itself, other = two_nearest.T
    nearest = np.where(itself == rows, other, itself)  # as of two at one place
    own, beside = differences[rows], differences[nearest]
    sizes = np.linalg.norm(own, axis=1) * np.linalg.norm(beside, axis=1)
    is_alike = np.sum(own * beside, axis=1) > ALIKE * sizes
    return bool(np.any(is_among(names[nearest], far) & is_alike))


def _are_beside(examined, names, others):
    """Whether a model of the low flight of each of some points holds one of others."""
    two_step = examined.two_step
    if not two_step.is_possible:
        return False
    rows = two_step.model_points[LOW]
    model = pd.MultiIndex.from_frame(rows[["coverage", "model_id"]])
    is_tied = model.isin(model[is_among(rows["point_id"], others)])
    return bool(np.isin(names, rows.loc[is_tied, "point_id"]).all())


def _far_check_points(examined, known):
    """Names of check points that contradict the claim each by itself, if all do."""
    if not known.are_beyond:
        return known.point_ids[:0]
    has_errors = set(ERRORS) <= set(examined.points)
    return contradicting_points(examined) if has_errors else _far_points(known)


def _found_there(examined, name, miss):
    """Name of the new point where a known one is given, and its distance from there."""
    points = examined.points
    new = points[points["role"] == "new"]
    given = examined.block.control_points.set_index("point_id")
    place = given.loc[name, ["easting", "northing"]].to_numpy(dtype=float)
    away = np.hypot(*(values_of(new, ["easting", "northing"]) - place).T)
    figures = examined.figures
    claimed = np.nan_to_num(np.fmax(figures.mean_total, figures.mean_paper))
    within = min(WITHIN_CLAIM * float(claimed), MOST_OF_MISS * miss)
    if not np.any(away <= within):
        return "", np.nan
    nearest = int(np.nanargmin(away))
    return new["point_id"].iloc[nearest], float(away[nearest])


def _is_confirmed(examined, name, miss):
    """Whether a point was measured where it is, as far as it is off.

    Two models of the low flight have it at the same place; or one that is fitted onto
    its approximate coordinates, in which so large an error would have been found.
    """
    residuals, points = examined.residuals, examined.points
    is_of_point = (residuals["flight"] == LOW) & (residuals["point_id"] == name)
    if not is_of_point.any():  # no model of two steps is fitted onto it
        (point,) = np.flatnonzero(points["point_id"] == name)
        n_models, is_suspect = points[["n_models", "is_suspect"]].iloc[point]
        return bool(n_models >= FEWEST_CONFIRMING and not is_suspect)
    is_good = is_of_point & ~residuals["is_suspect"].astype(bool)
    if int(is_good.sum()) >= FEWEST_CONFIRMING:
        return True
    if examined.two_step is not examined:  # residuals against the point itself
        return False
    fitted = examined.low.reliability
    detectable = fitted.loc[fitted["point_id"] == name, "minimal_detectable_bias"]
    return bool(is_good.any() and (detectable < miss).all())


def _is_near_doubt(examined, name):
    """Whether a point shares a model with control that others do not confirm.

    A model that is fitted onto control: of the high flight, or in one adjustment of the
    low flight alone any.
    """
    control = examined.block.control_points
    control = control.loc[control["role"] != "check", "point_id"]
    doubtful = set(control) - set(examined.left_out_differences.index)
    if not (doubtful and examined.control_takes_part):
        return False
    models = examined.oriented_on_control
    if models is None:
        return True
    model = pd.MultiIndex.from_frame(models[["coverage", "model_id"]])
    is_there = model.isin(model[models["point_id"] == name])
    if not is_there.any():  # models that hold it hang on any of these
        return True
    return not doubtful.isdisjoint(models.loc[is_there, "point_id"])


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
    rows = rows_of_names(point_ids, given["point_id"])  # -1, the last, if it is not
    errors = given["standard_error_m"].to_numpy(dtype=float)
    own = np.nan_to_num(np.append(errors, np.nan)[rows])
    members = group_members(given)
    if members is None:
        return own
    is_in_group = np.append(members.sum(axis=1), np.nan)[rows]
    return np.hypot(own, examined.group_error * is_in_group)


def _claimed(examined, rows, column):
    """Total figure claimed for densified - given: both have an error."""
    variance = rows[column].to_numpy(dtype=float) ** 2
    if column == TOTAL:
        # given and densified share it, so that their difference is without
        variance = np.maximum(variance - examined.figures.shared_error**2, 0.0)
    variance = variance + given_errors(examined, rows["point_id"]) ** 2
    variance = variance[np.isfinite(variance)]
    return float(np.sqrt(variance.mean())) if len(variance) else np.nan
