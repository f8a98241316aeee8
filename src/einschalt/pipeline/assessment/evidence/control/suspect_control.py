"""Control that contradicts an adjustment: what it does, and whether it is alike.

Errors of single control points have nothing in common. If a part of the control is
shifted, the block bends between both parts, and data snooping refuses whichever points
are fewer or weaker, right or wrong: their strains are parallel, if not equal. No
residual is left then that tells which part is wrong. Nor does any where hardly more is
kept than was set aside, as where heights of two systems are given.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.special import stdtr

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.frame_columns import values_of
from einschalt.pipeline.assessment.credibility import TOTAL
from einschalt.pipeline.assessment.evidence.control.displacements import (
    NOTHING,
    Displacement,
    moved_between_ways,
    moved_by_suspect_control,
)
from einschalt.pipeline.assessment.evidence.control.heights import HEIGHT_OF_CHECK
from einschalt.pipeline.assessment.evidence.control.patterns import (
    NO_PATTERNS,
    find_control_patterns,
    wrong_control,
)
from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.pipeline.assessment.evidence.fits.adjusted_heights import (
    follows_control,
    with_adjusted_heights,
    with_scale_of_heights,
)
from einschalt.pipeline.assessment.evidence.fits.adjusted_plan import (
    with_adjusted_plan,
    with_plan_before_setting_aside,
)
from einschalt.pipeline.assessment.evidence.fits.control_beside_given import (
    with_contradiction_beside_given,
)
from einschalt.pipeline.assessment.evidence.ground.wrong_given_points import (
    without_given,
)
from einschalt.pipeline.assessment.evidence.leave_one_out import heights_left_out
from einschalt.pipeline.assessment.evidence.systematic_errors import strain_without
from einschalt.pipeline.assessment.known_points import (
    DIFFERENCES,
    KnownPoints,
    given_errors,
)
from einschalt.pipeline.densification.one_adjustment import with_two_steps
from einschalt.stages.error_propagation.given_points import PLAN

# that single errors lie as close to one direction, or to one line, as those found
SIGNIFICANCE = 0.1
FEWEST = 2
# heights of a part of control that are off alike, wherever its points lie
PARTS = (Kind.GROUP, Kind.STEP)
# share of control: data snooping is made for single errors, and where more is refused
# the others need not be the right ones
MOST_SET_ASIDE = 0.4
# the same of points with heights that stand out: several wrong ones are rather those of
# another list, of which snooping takes out whatever hangs on least
MOST_IN_HEIGHT, FEWEST_IN_HEIGHT = 0.25, 3
FEWEST_CONFIRMING = 4  # check points
STRAINS = ["strain_easting", "strain_northing", "strain_height"]
STANDS_OUT = 2.0  # times the heights of control that is kept, RMS


def may_hold_wrong_control(examined) -> bool:
    """Tell whether control that contradicts an adjustment takes part, or may do so."""
    control = examined.adjustment.control
    is_kept = bool((control["is_suspect"] & ~control["is_set_aside"]).any())
    return is_kept or examined.set_aside_may_be_right


def set_aside_may_be_right(examined) -> bool:
    """Tell whether control that was set aside is off in one direction, or is much.

    Not where check points agree with the adjustment without it, in plan for what is
    wrong in plan, and in height for what is wrong there.
    """
    control, known = examined.adjustment.control, examined.known_check
    is_confirmed = known.count >= FEWEST_CONFIRMING and not known.are_beyond
    in_plan = are_set_aside_alike(control) or are_many_set_aside(control)
    in_height = are_alike_in_height(control) or are_many_in_height(control)
    return (in_plan and not is_confirmed) or (
        in_height and not _is_confirmed_in_height(examined)
    )


def check_points_confirm(examined) -> bool:
    """Tell whether check points agree in plan with an adjustment, each for itself.

    By the errors of the adjusted points and of the given coordinates alone: whatever
    two steps stand beside it.
    """
    points = examined.solution.points
    rows = points[points["role"] == "check"]
    names = rows["point_id"].to_numpy(dtype=object)
    if len(names) < FEWEST_CONFIRMING or TOTAL not in rows:
        return False
    variance = rows[TOTAL].to_numpy(dtype=float) ** 2
    claimed = np.sqrt(np.mean(variance + given_errors(examined, names) ** 2))
    known = KnownPoints(names, values_of(rows, DIFFERENCES), claimed, 2.0 * len(names))
    return bool(np.isfinite(known.ratio)) and not known.are_beyond


def _is_confirmed_in_height(examined):
    """Whether check points agree with the heights of an adjustment."""
    test = examined.height_claim.of(HEIGHT_OF_CHECK)
    is_tested = test is not None and test.n_points >= FEWEST_CONFIRMING
    return is_tested and test.p_value > SIGNIFICANCE


def stand_out_in_height(control) -> bool:
    """Tell whether heights of what was set aside are off, and others are not.

    Parameters
    ----------
    control : DataFrame
        Of an adjustment: is_set_aside [, strain_height [m]].
    """
    if "strain_height" not in control:
        return False
    is_out = control["is_set_aside"].to_numpy(dtype=bool)
    squares = control["strain_height"].to_numpy(dtype=float) ** 2
    out, kept = squares[is_out], squares[~is_out]
    if not np.isfinite(out).any():
        return False
    usual = np.nanmean(kept) if np.isfinite(kept).any() else 0.0
    return bool(np.nanmean(out) > STANDS_OUT**2 * usual)


def are_alike_in_height(control) -> bool:
    """Tell whether heights of what was set aside stand out, and all in one direction.

    Student's t of their mean: independent errors are about zero.
    """
    if not stand_out_in_height(control):
        return False
    is_out = control["is_set_aside"].to_numpy(dtype=bool)
    strain = control["strain_height"].to_numpy(dtype=float)[is_out]
    strain = strain[np.isfinite(strain)]
    if len(strain) < FEWEST:
        return False
    mean, spread = strain.mean(), strain.std(ddof=1)
    if not spread > 0.0:
        return True
    t = mean / (spread / np.sqrt(len(strain)))
    return bool(2.0 * stdtr(len(strain) - 1, -abs(t)) <= SIGNIFICANCE)


def are_many_set_aside(control) -> bool:
    """Tell whether so much was set aside that the rest need not be right."""
    is_out = control["is_set_aside"].to_numpy(dtype=bool)
    return bool(np.count_nonzero(is_out) > MOST_SET_ASIDE * len(is_out))


def are_many_in_height(control) -> bool:
    """Tell whether heights of what was set aside stand out, and those are not few."""
    n_out = np.count_nonzero(control["is_set_aside"])
    is_more = n_out >= FEWEST_IN_HEIGHT and n_out > MOST_IN_HEIGHT * len(control)
    return (is_more or are_many_set_aside(control)) and stand_out_in_height(control)


def are_set_aside_alike(control) -> bool:
    """Tell whether strains are more parallel than independent errors would be.

    Parameters
    ----------
    control : DataFrame
        Of an adjustment: strain_easting, strain_northing [m], is_set_aside.
    """
    is_out = control["is_set_aside"].to_numpy(dtype=bool)
    strain = values_of(control, ["strain_easting", "strain_northing"])[is_out]
    if len(strain) < FEWEST:
        return False
    direction = np.arctan2(strain[:, 1], strain[:, 0])
    # in one direction, or along one line: two looks at the same points (Bonferroni)
    p_values = [_chance_of_arc(direction, period) for period in (2.0 * np.pi, np.pi)]
    return bool(2.0 * min(p_values) <= SIGNIFICANCE)


def _chance_of_arc(direction, period):
    """Probability that random directions lie in an arc as short as these do.

    n (arc/period)^(n - 1) while the arc is at most half of the period, where no two of
    the points can both be its beginning; Stevens (1939). 1 beyond.
    """
    ordered = np.sort(np.mod(direction, period))
    gaps = np.diff(ordered, append=ordered[0] + period)
    share = 1.0 - gaps.max() / period
    n = len(ordered)
    return min(n * share ** (n - 1), 1.0) if share <= 0.5 else 1.0


def _is_explained_by(told, size):
    """Whether a figure that is told is as large as a distance of the points."""
    return told is not None and told.value >= size > 0.0


class SuspectControl:
    """What an adjustment makes of control that contradicts it, taking part or not."""

    @cached_property
    def apart_from_two_steps(self):
        """How far it lies from the two steps, beyond the errors of both.

        Nothing where one control point contradicts it, which the two steps hold as
        well; where several do, they may be right, and the heights as far off as
        theirs are. Two steps that are told to be as far off as that say nothing of it:
        then the points may be so in plan as those that were set aside are.
        """
        if len(self._suspect_control) == 1:
            return NOTHING
        moved = moved_between_ways(self, self.two_step)
        if not self.set_aside_may_be_right:
            return moved
        in_plan, in_height = self._set_aside_off_by
        plan, height = moved.plan, moved.height
        if _is_explained_by(self.two_step.credible, plan):
            plan = min(plan, in_plan)
        if _is_explained_by(self.two_step.credible_heights, height):
            height = 0.0
        return Displacement(plan, max(height, self._share_in_doubt * in_height))

    moved_by_suspect_control = cached_property(moved_by_suspect_control)

    @property
    def knows_wrong_control(self):
        """Whether one control point alone contradicts it and takes part."""
        without = self.adjustment.without_suspects
        return len(self._suspect_control) == 1 and not without.empty

    def is_effect_known(self, pattern):
        """Whether a pattern is of points that take no part, or whose part is known."""
        names = set() if pattern is None else set(pattern.point_ids)
        known = self._suspect_control if self.knows_wrong_control else self._set_aside
        return bool(names) and names <= known

    @cached_property
    def unexplained_control(self):
        """Control without the one point whose error, and what it does, are known."""
        known, suspects = self.known_control, self._suspect_control
        return known.without(suspects) if len(suspects) == 1 else known

    @cached_property
    def _suspect_control(self):
        control = self.adjustment.control
        return frozenset(control.loc[control["is_suspect"], "point_id"])

    @property
    def left_out_differences(self):
        """Control points as all others predict them less as given, (easting, northing).

        DataFrame by point_id, of those that are no suspects: less the error of given
        coordinates that explains a point.
        """
        control = self.adjustment.control
        is_suspect = control["is_suspect"].to_numpy(dtype=bool)
        control = control[~is_suspect].set_index("point_id")
        return -control[["strain_easting", "strain_northing"]].set_axis(PLAN, axis=1)

    @property
    def left_out_heights(self):
        """As ``left_out_differences``, in height; without rows in the plane."""
        return -heights_left_out(self.adjustment.control, "strain_height")

    @property
    def moved_by_left_out(self):
        """That of the two steps, unless control was set aside."""
        return NOTHING if self._disputed else self.two_step.moved_by_left_out

    @cached_property
    def points(self):
        """Adjusted points, beside those of the two steps that hold the same control."""
        points, again = self.solution.points, self._without_set_aside
        return points if again is None else with_two_steps(points, again.solution)

    @property
    def held_control(self):
        """Control points without those that were set aside, rows of ``points``."""
        points = self.solution.points
        control = points[points["role"] == "control"]
        return control[~control["point_id"].isin(self._set_aside)]

    @cached_property
    def control_patterns(self):
        """Those of the two steps, and of the heights in the adjustment.

        Of these only where all control takes part: what is left beside control that
        was set aside is chosen to agree. One point that contradicts the adjustment may
        be as wrong as it likes, as others lean on it, unless it stands at the edge of a
        part; if it is off in plan it tilts what is around it, and heights tell nothing
        then. Of plan as well, where there is no high flight beside which control is
        left out, and no region is displaced; there approximate points that agree among
        themselves count, too.
        """
        scales = self.adjustment.height_scales
        patterns = with_scale_of_heights(scales, self._patterns_in_two_steps)
        is_single = len(self._suspect_control) == 1
        known = self._suspect_control if is_single else frozenset()
        if not (self._set_aside or self._is_single_in_plan):
            patterns = with_adjusted_heights(self, patterns, known=known)
        if self.block.high_flight is not None or self.displaced_regions:
            return patterns
        if self._set_aside:  # what is left is chosen to agree, and may be the wrong one
            if check_points_confirm(self):
                return patterns
            return with_plan_before_setting_aside(self, patterns)
        patterns = with_adjusted_plan(self, patterns, known=known)
        return with_contradiction_beside_given(self, patterns)

    @property
    def _is_single_in_plan(self):
        """Whether one point alone contradicts it, in plan more than in height."""
        control = self.adjustment.control
        suspects = control[control["is_suspect"]]
        if len(suspects) != 1 or "strain_height" not in control:
            return False
        ((east, north, up),) = suspects[STRAINS].to_numpy(dtype=float)
        return bool(np.hypot(east, north) > abs(up))

    @property
    def _patterns_in_two_steps(self):
        """Patterns of the two steps, but for what was set aside.

        Without a high flight heights of single models show them, unless these go onto
        approximate points that are no control: the adjustment goes on without such
        points, and has tests of its own for control. Where one point
        contradicts the adjustment these lean on it, and say nothing of the adjustment,
        in which what it does is known; unless they have another scale, which is no
        matter of one point.
        """
        two_step = self.two_step
        if not two_step.is_possible:
            return two_step.control_patterns
        if not follows_control(self.block):  # what is told is of approximate points
            return NO_PATTERNS
        height = two_step.control_patterns.height
        is_scale = height is not None and height.kind is Kind.SCALE
        is_of_one = len(self._suspect_control) == 1 and not is_scale
        if two_step.left_out_control is None and is_of_one:
            return NO_PATTERNS
        if not self._disputed:
            return self._with_shared_heights(two_step.control_patterns)
        set_aside = self._disputed | two_step.excluded_control
        return find_control_patterns(two_step, set_aside)

    def _with_shared_heights(self, patterns):
        """Patterns, and what all control heights tell that is no matter of single ones.

        Another scale; or a group of them, where some of it and of the others are left:
        they still contradict each other, though too few may be left to tell it.
        """
        if self._without_set_aside is None:
            return patterns
        of_all = self._with_all_control.control_patterns
        found, names = of_all.height, set(self.adjustment.control["point_id"])
        if found is None or found.kind not in (Kind.SCALE, *PARTS):
            return patterns
        parts = set(found.point_ids), names - set(found.point_ids)
        is_out = any(part <= self._set_aside for part in parts)
        if found.kind in PARTS and is_out and not self.set_aside_may_be_right:
            return patterns
        height = {"height": found, "moved_height": of_all.moved_height}
        return replace(patterns, **height, p_height=of_all.p_height)

    @cached_property
    def strain(self):
        """Strain of control beside what was set aside, or is wrong by itself."""
        return strain_without(self.two_step, self.wrong_control)

    @cached_property
    def wrong_control(self):
        """Names of what was set aside, and of control that is wrong by itself."""
        return self._set_aside | frozenset(wrong_control(self.control_patterns))

    @cached_property
    def _without_set_aside(self):
        """Examination in two steps without the control that was set aside, or None.

        None where none was, where it is alike, and may be right, and of large blocks.
        """
        beside = self._with_all_control
        is_alike = are_set_aside_alike(self.adjustment.control)
        if not self._set_aside or (is_alike and not check_points_confirm(self)):
            return None
        if not (beside.is_possible and beside.is_small):
            return None
        try:
            return beside.computed_again(without_given(beside.block, self._set_aside))
        except EinschaltError:  # the rest does not determine the block
            return None

    @property
    def _disputed(self):
        """Names of control that was set aside, and that the two steps hold."""
        return frozenset() if self._without_set_aside else self._set_aside

    @property
    def two_steps_keep_set_aside(self):
        """Whether the two steps beside it hold control that it set aside."""
        return self.two_step.is_possible and bool(self._disputed)

    @property
    def _set_aside_off_by(self):
        """How far control that was set aside is off, TOTAL and in height, RMS [m]."""
        control = self.adjustment.control
        out = control[control["is_set_aside"]]
        in_plan = values_of(out, ["strain_easting", "strain_northing"])
        plan = np.nanmean((in_plan**2).sum(axis=1))
        height = 0.0
        if "strain_height" in out and out["strain_height"].notna().any():
            height = np.nanmean(out["strain_height"] ** 2)
        return float(np.sqrt(plan)), float(np.sqrt(height))

    @property
    def _share_in_doubt(self):
        """Share of what was set aside that the points may be off by, in height.

        All of it where the wrong part may have been kept; the share of that control
        where some of it may have been mistaken for the wrong one.
        """
        control = self.adjustment.control
        if are_alike_in_height(control) or are_many_set_aside(control):
            return 1.0
        return len(self._set_aside) / len(control)

    @cached_property
    def _set_aside(self):
        control = self.adjustment.control
        return frozenset(control.loc[control["is_set_aside"], "point_id"])

    set_aside_may_be_right = cached_property(set_aside_may_be_right)
    keeps_wrong_control = property(may_hold_wrong_control)
