"""Control that is wrong together in plan, by one adjustment of a single flight.

Where no high flight lies between control and models, no control point is predicted
without itself. An adjustment of everything tells what its corrections make of a part of
the network that lies apart, or of one that is bent; also where orientations bend the
models, so that no region is looked for in two steps.

See docs/theory/claim.md.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode, is_among
from einschalt.pipeline.assessment.evidence.control.patterns import (
    NOTHING,
    find_plan_pattern,
)
from einschalt.pipeline.assessment.evidence.control.signatures import PLAN, Kind
from einschalt.stages.simultaneous.image_errors import MOST_IN_PLAN, N_DRAWS
from einschalt.theory.adjustment.displaced_group import find_displaced_group
from einschalt.theory.adjustment.significance import SYSTEMATIC_SIGNIFICANCE
from einschalt.theory.block_adjustment.common_parameters import COMPLEX
from einschalt.theory.block_adjustment.control_in_plan import PlanScores, plan_scores

AXES = ["easting", "northing"]


@dataclass(frozen=True, eq=False)
class AdjustedPlan:
    """What given places do in an adjustment: as of Signatures, of plan alone.

    The corrections of control stand for differences, as independent numbers of variance
    1.
    """

    control: pd.DataFrame  # as of the block
    rows: np.ndarray  # (n,): of ``control``, in the order of the adjustment
    known: PlanScores
    is_new: np.ndarray  # (n_points,): which points of the adjustment are new ones

    def observed(self, _axes=PLAN):
        """The numbers, (n_numbers,)."""
        return self.known.observed

    def covariance(self, _axes=PLAN):
        """Their covariance."""
        return np.eye(len(self.known.observed))

    def of(self, patterns, _axes=PLAN):
        """What patterns of control make of them, (n_patterns, n_numbers, 2)."""
        of_rows = np.stack([pattern.of_control[self.rows] for pattern in patterns])
        return np.einsum("pc,nca->pna", of_rows, self.known.shown)

    def moved(self, pattern, amplitude, axes=PLAN):
        """What a pattern does to the new points, TOTAL, RMS [m]."""
        return self.moved_by(np.outer(pattern.of_control, amplitude), axes)

    def moved_by(self, errors, _axes=PLAN):
        """What errors of control, (n_control, 2) [m], do to new points, TOTAL, RMS."""
        follows = self.known.follows[self.is_new]
        moved = np.einsum("nbca,ca->nb", follows, errors[self.rows])
        return float(np.sqrt(np.mean(np.sum(moved**2, axis=1)))) if len(moved) else 0.0

    @property
    def scores(self):
        """Scores of the control points, complex (n,), and their information (n, n).

        That of either axis, as the mean of both.
        """
        values = np.einsum("nca,n->ca", self.known.shown, self.known.observed)
        products = np.einsum("nca,nda->cd", self.known.shown, self.known.shown)
        return values @ COMPLEX, products / len(AXES)


def pattern_of_adjusted_plan(adjusted, set_aside=frozenset(), known=frozenset()):
    """The clearest pattern in the places of control of an adjustment, as it is known.

    FoundPattern or None, what it does to the new points [m], and its probability.
    Nothing without errors of control, where groups share shifts of a size that nobody
    knows, and of much control. What was ``set_aside``, names, may be as wrong as it
    likes; so may points of ``known`` effect, unless a pattern of many explains more
    than one of them. Single points, and those that lie apart alike but anywhere, have
    no name: those that stand out are told by themselves.
    """
    adjustment = adjusted.adjustment
    # two steps hold what the adjustment beside them has set aside
    held = adjustment.whole or adjustment
    plan = _known_of(adjusted, held.solution, held.drawn)
    if plan is None:
        return NOTHING
    found, is_of_many = _clearest(plan, set_aside)
    if known and not is_of_many:
        found, _ = _clearest(plan, set_aside | known)
    return found


def pattern_before_setting_aside(adjusted):
    """A pattern of many, in all control, where some of it was set aside.

    As of :func:`pattern_of_adjusted_plan`. What was set aside may be the right part:
    what that does is the larger effect of what is left of either part. NOTHING where
    single points, each by itself, explain as much.
    """
    adjustment = adjusted.adjustment
    whole = adjustment.whole
    if whole is None:
        return NOTHING
    plan = _known_of(adjusted, whole.solution, whole.drawn)
    if plan is None:
        return NOTHING
    (found, moved, p_value), is_of_many = _clearest(plan, frozenset())
    if not is_of_many:
        return NOTHING
    kept = _known_of(adjusted, adjustment.solution, adjustment.drawn)
    if found is None or found.kind is not Kind.STEP:
        return found, moved, p_value
    part = is_among(plan.control["point_id"], list(found.point_ids))
    is_kept = np.zeros(len(part), dtype=bool)
    is_kept[kept.rows] = ~adjustment.control["is_set_aside"].to_numpy(dtype=bool)
    both = (np.outer(side & is_kept, found.amplitude) for side in (part, ~part))
    moved = max(kept.moved_by(errors) for errors in both)
    return replace(found, moved=moved), moved, p_value


def _clearest(plan, set_aside):
    """As of :func:`pattern_of_adjusted_plan`, and whether it is a pattern of many."""
    is_free = is_among(plan.control["point_id"], list(set_aside))
    is_held = np.zeros(len(is_free), dtype=bool)
    is_held[plan.rows[np.any(plan.known.shown, axis=(0, 2))]] = True
    found, moved, p_value = find_plan_pattern(plan, is_held & ~is_free, is_free)
    if found is not None and found.kind is Kind.POINT:
        found = None
    group = _group(plan, found, is_free)
    if group is None:
        return (found, moved, p_value), found is not None
    return (None, *group), True


def _known_of(adjusted, solution, drawn):
    """AdjustedPlan of a solution of an adjustment, or None."""
    adjustment = adjusted.adjustment
    tables, table = adjustment.tables, adjustment.control
    is_known = solution.redundancy > 0 and not tables.has_unknown_groups
    if not is_known or solution.observations.is_fixed.any():
        return None
    if len(table) > MOST_IN_PLAN:
        return None
    known = plan_scores(solution, adjustment.s_0, drawn.control_in_plan, N_DRAWS)
    control = adjusted.block.control_points
    names, asked = encode(control["point_id"]), encode(table["point_id"])
    points = adjusted.solution.points
    new = points.loc[points["role"] == "new", "point_id"]
    is_new = is_among(tables.point_id[adjustment.drawn.points], new)
    rows = names.locate(asked)[asked.codes]
    return AdjustedPlan(control, rows, known, is_new)


def _group(plan, found, is_free):
    """What points that lie apart alike, wherever they are, do, and the probability.

    None where they explain no more than what was found.
    """
    rows, known = plan.rows, plan.known
    is_tested = ~is_free[rows] & np.any(known.shown, axis=(0, 2))
    if is_free[rows].any() or not is_tested.any():
        return None
    scores, information = plan.scores
    scores, information = scores[is_tested], information[is_tested][:, is_tested]
    control = plan.control.iloc[rows[is_tested]]
    behind = () if found is None else found.point_ids
    region = np.flatnonzero(is_among(control["point_id"], list(behind)))
    xy = values_of(control, AXES)
    among = scores, information, xy - xy.mean(axis=0)
    group = find_displaced_group(*among, SYSTEMATIC_SIGNIFICANCE, region)
    if group is None or set(group.rows) == set(region):
        return None
    errors = np.zeros((len(is_free), len(AXES)))
    errors[rows[is_tested][group.rows]] = group.shift
    return plan.moved_by(errors), group.p_value


def with_adjusted_plan(adjusted, patterns, set_aside=frozenset(), known=frozenset()):
    """Patterns of heights, with that in plan of an adjustment where it shows one."""
    found = pattern_of_adjusted_plan(adjusted, set_aside, known)
    return _with_plan(adjusted, patterns, *found)


def with_plan_before_setting_aside(adjusted, patterns):
    """The same, of all control, where some of it was set aside."""
    return _with_plan(adjusted, patterns, *pattern_before_setting_aside(adjusted))


def _with_plan(adjusted, patterns, plan, moved, p_value):
    if moved == 0.0:
        return patterns
    n_control = patterns.n_control or len(adjusted.adjustment.control)
    return replace(
        patterns, plan=plan, moved_plan=moved, p_plan=p_value, n_control=n_control
    )
