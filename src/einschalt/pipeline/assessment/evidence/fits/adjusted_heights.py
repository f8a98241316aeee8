"""Heights of control that are wrong together, by one adjustment of spatial models.

Two steps see them in what the models around a control point make of its height without
it; an adjustment of everything ties all of them, and shows a step of half of that.

See docs/theory/claim.md.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode, is_among
from einschalt.pipeline.assessment.evidence.control.patterns import (
    MOST_CONTROL,
    NOTHING,
    FoundPattern,
    find_control_patterns,
    find_height_pattern,
)
from einschalt.pipeline.assessment.evidence.control.signatures import (
    HEIGHT,
    Kind,
    Scores,
)
from einschalt.pipeline.assessment.evidence.fits.adjusted_plan import (
    with_adjusted_plan,
)
from einschalt.pipeline.assessment.evidence.systematic_errors import ControlScores
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.densification.simultaneous import (
    adjust_flights,
    require_adjustable,
)
from einschalt.pipeline.densification.solution import Solution
from einschalt.stages.error_propagation.given_points import approximations_are_control
from einschalt.stages.simultaneous.adjustment import BlockAdjustment
from einschalt.stages.simultaneous.image_errors import N_DRAWS
from einschalt.stages.transformation_kinds import SPATIAL
from einschalt.theory.adjustment.significance import SYSTEMATIC_SIGNIFICANCE
from einschalt.theory.block_adjustment.control_heights import height_scores

# left-out control is another test of the same heights: both share the probability
SIGNIFICANCE = SYSTEMATIC_SIGNIFICANCE / 2.0


@dataclass(frozen=True, eq=False)
class AdjustedHeights:
    """What given heights do in an adjustment: as of Signatures, of heights alone."""

    control: pd.DataFrame  # as of the block
    rows: np.ndarray  # (n,): of ``control``, in the order of the adjustment
    # (n_new, n): what the heights of the new points follow of those of control
    follows: np.ndarray

    def moved(self, pattern, amplitude, axes=HEIGHT):
        """What a pattern does to the heights of the new points, RMS [m]."""
        return self.moved_by(np.outer(pattern.of_control, amplitude), axes)

    def moved_by(self, errors, _axes=HEIGHT):
        """What errors of heights, (n_control, 1) [m], do to the new points, RMS [m]."""
        moved = self.follows @ errors[self.rows, 0]
        return float(np.sqrt(np.mean(moved**2))) if len(moved) else np.nan


@dataclass(frozen=True, eq=False)
class Beside:
    """An adjustment of all models beside a solution in two steps."""

    adjustment: BlockAdjustment
    solution: Solution
    block: Block


def adjusted_beside(two_step) -> BlockAdjustment | None:
    """One adjustment of the spatial models of a small block in two steps.

    Of the block that was asked for, and of none that is tried; None where there is no
    such adjustment, or where given points take the place of control.
    """
    block, solution = two_step.block, two_step.solution
    if not follows_control(block):
        return None
    kinds = {flight.transformation for flight in block.flights.values()}
    is_made = two_step.is_of_result and two_step.is_small and kinds == {SPATIAL}
    if not is_made or two_step.settings.iterations > 1:
        return None
    try:
        require_adjustable(block)
        what = block, two_step.settings, solution.flights, solution.searched
        return adjust_flights(*what)
    except EinschaltError:  # what the two steps do not need
        return None


def follows_control(block) -> bool:
    """Whether models go onto control in two steps, by a high flight or themselves."""
    return block.high_flight is not None or approximations_are_control(block)


def patterns_of_two_steps(two_step):
    """Control that is wrong together, by two steps, and by one adjustment beside them.

    ControlPatterns. Both follow control alike, but the adjustment shows smaller ones.
    Without a high flight two steps have the residuals of given heights, and what these
    show does more in them than in the adjustment: it shows what they do not; and alone
    patterns in plan, where no given point is told.
    """
    set_aside = two_step.excluded_control
    patterns = find_control_patterns(two_step, set_aside)
    bends = two_step.solution.shared_bends
    if bends is not None:
        patterns = with_scale_of_heights(bends.height_scales, patterns)
    adjustment = two_step.adjusted_beside
    if adjustment is None or not follows_control(two_step.block):
        return patterns
    beside = Beside(adjustment, two_step.solution, two_step.block)
    if two_step.block.high_flight is not None:
        return with_adjusted_heights(beside, patterns, set_aside)
    given = two_step.given_heights
    is_silent = given is None or given.p_value > SIGNIFICANCE
    if patterns.height is None and is_silent:
        patterns = with_adjusted_heights(beside, patterns, set_aside)
    if two_step.is_put_off:
        return patterns
    return with_adjusted_plan(beside, patterns, set_aside)


def pattern_of_adjusted_heights(adjusted, set_aside=frozenset()):
    """The clearest pattern in the heights of control of an adjustment, as it is known.

    As of :func:`find_height_pattern`; nothing without heights and their errors, and
    where groups share shifts of a size that nobody knows. Control that was set aside
    takes no part, and what was ``set_aside`` elsewhere, names, may be as wrong as it
    likes.
    """
    adjustment = adjusted.adjustment
    tables, solution = adjustment.tables, adjustment.solution
    table, control = adjustment.control, adjusted.block.control_points
    is_known = tables.is_spatial and not tables.has_unknown_groups
    if not is_known or len(table) > MOST_CONTROL or not solution.redundancy > 0:
        return NOTHING
    drawn = adjustment.drawn.control_heights
    found = height_scores(solution, adjustment.s_0, drawn, N_DRAWS)
    names = encode(control["point_id"])
    asked = encode(table["point_id"])
    rows = names.locate(asked)[asked.codes]
    heights = values_of(control, ["height"])[rows, 0]
    is_held = np.isfinite(heights) & ~table["is_set_aside"].to_numpy(dtype=bool)
    is_held &= np.diag(found.information) > 0.0
    scores, information = found.scores[is_held], found.information[is_held][:, is_held]
    known = ControlScores(rows[is_held], scores[:, None], information)
    is_free = is_among(table["point_id"][is_held], list(set_aside))
    shown = Scores(known.without(is_free) if is_free.any() else known)
    points = adjusted.solution.points
    new = points.loc[points["role"] == "new", "point_id"]
    is_new = is_among(tables.point_id[adjustment.drawn.points], new)
    own = AdjustedHeights(control, rows, found.follows[is_new])
    pattern = find_height_pattern(own, shown)
    return pattern if pattern[2] <= SIGNIFICANCE else NOTHING


def with_adjusted_heights(adjusted, patterns, set_aside=frozenset(), known=frozenset()):
    """Patterns of two steps, with that in heights of an adjustment where it shows one.

    It knows control better, and what that does to its own points. Another scale of
    heights is no matter of control. Points of ``known`` effect may be as wrong as they
    like, unless a pattern of many explains more than one of them.
    """
    height, moved, p_value = pattern_of_adjusted_heights(adjusted, set_aside)
    is_of_many = height is not None and height.kind is not Kind.POINT
    if known and not is_of_many:
        is_free = set_aside | known
        height, moved, p_value = pattern_of_adjusted_heights(adjusted, is_free)
    if moved == 0.0:
        return patterns
    if patterns.height is not None and patterns.height.flights:
        return patterns
    n_control = patterns.n_control if height is None else height.n_control
    return replace(
        patterns,
        height=height,
        moved_height=moved,
        p_height=p_value,
        n_control=n_control,
    )


def with_scale_of_heights(scales, patterns):
    """Patterns of two steps, with heights of models that are out of scale, if any are.

    ``scales`` as of a BlockAdjustment. The residuals of all points show it, where
    left-out control may not. Where it shows in both, two steps tell it.
    """
    if len(scales) == 0 or (patterns.height is not None and patterns.height.flights):
        return patterns
    scale = scales.iloc[0]
    found = FoundPattern(
        kind=Kind.SCALE,
        flights=(scale["flight"],),
        point_ids=(),
        n_control=patterns.n_control,
        amplitude=(float(scale["ratio"]),),
        p_value=float(scale["p_value"]),
        moved=float(scale["moved_height"]),
        is_of_adjustment=True,
    )
    return replace(
        patterns,
        height=found,
        moved_height=found.moved,
        p_height=found.p_value,
    )
