"""Which figure of precision to believe, and why.

In two steps there are three: the propagated one takes the sizes of all errors as given,
so nothing in the measurements can enlarge it; that of the budget and the internal one
see less, but they see the measurements.
"""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
import pandas as pd

from einschalt.pipeline.assessment.evidence.claim import (
    KNOWN,
    NEIGHBOURS,
    OF_INDEPENDENCE,
    REGIONS,
    RESIDUALS,
)
from einschalt.pipeline.assessment.evidence.control.displacements import (
    LARGEST_S_0,
    LEAST_ENLARGEMENT,
    control_contradicts,
    where_it_matters,
)
from einschalt.pipeline.assessment.evidence.control.larger_errors import (
    larger_control_errors,
)
from einschalt.pipeline.assessment.evidence.fits.film_affinity import FilmAxes
from einschalt.pipeline.assessment.evidence.ground.frame import Doubt
from einschalt.stages.error_propagation.error_model import LOW
from einschalt.stages.error_propagation.given_points import APPROXIMATE_POINTS
from einschalt.stages.stage4_error_propagation import propagate_model
from einschalt.theory.adjustment.global_tests import ratio_limits
from einschalt.theory.adjustment.significance import (
    CLAIM_SIGNIFICANCE,
    MIN_REPORTED_RATIO,
)

# tests of how large errors are, whatever they have in common
OF_SIZES = (*OF_INDEPENDENCE, RESIDUALS, *KNOWN.values())
LEAST_OF_CLAIM = 10.0  # what is nearer than so many times the claim may be the block
TOTAL = "standard_error_total"
PAPER = "standard_error_paper"


class Reason(StrEnum):
    """Why a figure is the one to believe."""

    PROPAGATED = "propagated"  # it counts what points share, and nothing contradicts it
    CONTRADICTED = "contradicted"  # measurements contradict the propagated figure
    BUDGET = "budget"  # nothing else is known, and nothing contradicts it
    # given approximate points taken for independent, which nothing contradicts
    ASSUMED = "assumed"
    BUDGET_CONTRADICTED = "budget_contradicted"
    # models have taken up what residuals do not show of the errors that were stated
    STATED = "stated"
    ADJUSTED = "adjusted"  # that of the simultaneous adjustment
    ADJUSTED_UNKNOWN = "adjusted_unknown"
    ADJUSTED_ENLARGED = "adjusted_enlarged"  # its residuals show larger errors
    ADJUSTED_CONTRADICTED = "adjusted_contradicted"  # known points or residuals do
    UNKNOWN = "unknown"
    # a region of given points is displaced, and what that does is added to the rest
    DISPLACED = "displaced"
    # so are single given points
    WRONG_POINTS = "wrong_points"
    # control points under each other's name, which moves the points by so much
    EXCHANGED_CONTROL = "exchanged_control"
    # measurements of a model are
    EXCHANGED_NAMES = "exchanged_names"


# figures that are at least as large
LEAST = (Reason.CONTRADICTED, Reason.BUDGET_CONTRADICTED)


@dataclass(frozen=True)
class CredibleFigure:
    """The figure of the new points to believe."""

    value: float  # TOTAL, root mean square [m]; NaN where none is known
    # whether the points are as good as that or worse, by an unknown amount
    is_lower_bound: bool
    column: str  # of ``points``: the standard error that is claimed for single points
    # by which that column is enlarged for single points: as the figure is, or s_0 of an
    # adjustment where that is larger; never below 1
    factor: float
    reason: Reason
    doubt: Doubt = Doubt.NONE  # of the whole frame, which no figure can hold
    # that of the points that nothing displaced has moved; NaN where none is known
    elsewhere: float = np.nan
    # names of known points that took no part and are far off, as the others are not,
    # and the largest difference [m]: the figure leaves them aside
    left_aside: tuple[str, ...] = ()
    left_aside_by: float = np.nan

    @property
    def is_bound_by_names(self) -> bool:
        """Whether it is a bound for new points under names of those left aside alone.

        What these do is known of each.
        """
        is_of_names = self.reason is Reason.EXCHANGED_NAMES
        return is_of_names and bool(self.left_aside) and np.isfinite(self.elsewhere)


def figure_of_two_steps(examined) -> CredibleFigure:
    """Choose the figure of the two steps to believe.

    The propagated figure where nothing contradicts it, otherwise the largest that is
    known, as a lower bound.
    """
    return _beside_wrong_points(examined, _without_wrong_points)


def _beside_wrong_points(examined, figure_of):
    """The figure that ``figure_of`` chooses, if neither names nor points are wrong."""
    if examined.names_put_right is not None:
        return _beside_wrong_names(examined)
    if examined.is_put_off:
        return _beside_points_put_off(examined)
    return _beside_lone_points(examined, figure_of(examined))


def _without_wrong_points(examined):
    """The figure of two steps whose given points and names are right."""
    figures, claim = examined.figures, examined.claim
    # no measurement sees what all points share: it is added to whichever figure
    total, paper = figures.mean_within, figures.mean_paper
    if np.isnan(total) and np.isnan(paper):
        value, reason = np.nan, Reason.UNKNOWN
    elif has_credible_propagation(examined):
        value, reason = total, Reason.PROPAGATED
    elif np.isnan(total) and claim.is_supported and not _ratios_beyond(examined):
        value, reason = paper, Reason.BUDGET
        assumed = _by_independent_errors(examined)
        if assumed > paper:
            value = assumed
            is_told = not examined.has_untold_groups
            reason = Reason.ASSUMED if is_told else Reason.BUDGET
    else:
        value, reason = _where_contradicted(examined)
    least = paper if np.isnan(total) else total
    is_refuted = control_contradicts(examined)
    moved = _moved(examined, least, is_refuted=is_refuted or not claim.is_supported)
    copied = examined.copies.enlargement
    # tests and displacements see the same errors: the larger of the two
    shown = copied * max(value, np.hypot(least, moved))
    if shown > value or (is_refuted and np.isfinite(value)):
        value = shown
        reason = Reason.CONTRADICTED if total > 0.0 else Reason.BUDGET_CONTRADICTED
    is_incomplete = examined.has_untold_groups or examined.lacks_control_errors
    is_least = reason in LEAST or is_incomplete
    column, doubt = examined.claimed_column, examined.frame.doubt
    is_enlarged = is_least or reason in (Reason.STATED, Reason.ASSUMED)
    return CredibleFigure(
        value=float(np.hypot(value, figures.shared_error)),
        is_lower_bound=is_least or bool(doubt),
        column=column,
        factor=_of_single_points(examined, value if is_enlarged else np.nan),
        reason=reason,
        doubt=doubt,
    )


def _beside_points_put_off(examined):
    """The figure without displaced points, and how far these move the new points.

    A lower bound, since the others may be off instead.
    """
    rest = examined.corrected.credible
    has_regions = bool(examined.displaced_regions)
    return replace(
        rest,
        value=float(np.hypot(rest.value, examined.moved_at_once)),
        is_lower_bound=True,
        reason=Reason.DISPLACED if has_regions else Reason.WRONG_POINTS,
        elsewhere=float(np.hypot(rest.value, examined.moved_outside)),
    )


def _beside_wrong_names(examined):
    """The figure with names put right, and how far that moves points.

    A lower bound where it moves them; where no model is fitted onto control, they are
    as good as that figure. Where the pair is in no model that they hang on, they are
    known no better than this block knows them.
    """
    right, figures = examined.names_put_right, examined.figures
    rest, moved = right.corrected.credible, right.moved.plan
    is_control = right is examined.exchanged_control
    own = figures.mean_within if moved < rest.value else np.nan
    value = float(np.hypot(np.fmax(rest.value, own), moved))
    column = examined.claimed_column
    claimed = figures.mean_total if column == TOTAL else figures.mean_paper
    return replace(
        rest,
        value=value,
        is_lower_bound=rest.is_lower_bound or moved > 0.0,
        column=column,
        factor=float(np.nanmax([1.0, value / claimed if claimed > 0.0 else np.nan])),
        reason=Reason.EXCHANGED_CONTROL if is_control else Reason.EXCHANGED_NAMES,
        elsewhere=np.nan,
    )


def _beside_lone_points(examined, rest):
    """The figure, which leaves lone points aside, with what that does to new points.

    Where a new point lies where a lone one is given, either may stand under the name of
    the other, and the new one is as far off: a lower bound.
    """
    lone = examined.lone_points
    if not lone:
        return rest
    is_doubted = rest.is_lower_bound or not examined.claim.is_supported
    if is_doubted and not _are_beyond_any_size(examined, rest, lone):
        # more than those points contradicts it: they may be right
        known = (examined.known_check, examined.known_control)
        shown = max(rest.value, *(part.rms for part in known if part.count))
        return replace(rest, value=shown, is_lower_bound=True)
    names, largest = tuple(each.point_id for each in lone), lone[0].miss
    rest = replace(rest, left_aside=names, left_aside_by=largest)
    squares = sum(each.miss**2 for each in lone if each.found_there)
    if not squares:
        return rest
    value = np.hypot(rest.value, np.sqrt(squares / examined.figures.n_new))
    bound = {"is_lower_bound": True, "reason": Reason.EXCHANGED_NAMES}
    return replace(rest, value=float(value), elsewhere=rest.value, **bound)


def _are_beyond_any_size(examined, rest, lone):
    """Whether lone points lie far beyond a figure that only sizes of errors contradict.

    Coverages, residuals or the other known points, larger than stated errors make them.
    What neighbours share, a region or wrong control may move the points as far.
    """
    if rest.doubt or control_contradicts(examined):
        return False
    if any(test.name not in OF_SIZES for test in examined.claim.rejected):
        return False
    is_adjusted = examined.two_step is not examined
    if is_adjusted and (examined.keeps_wrong_control or examined.is_deformed):
        return False
    return all(each.miss >= LEAST_OF_CLAIM * rest.value for each in lone)


def _where_contradicted(examined):
    """The largest figure that is known, and whether stated errors make it."""
    figures = examined.figures
    paper, is_budget = figures.mean_paper, bool(np.isnan(figures.mean_within))
    claimed = paper if is_budget else figures.mean_within
    # what the measurements exceed the claim by is the least that it is too small by
    enlarged = _enlarged_by_tests(examined)
    if is_budget:  # its tests have not looked at known points
        enlarged = max(enlarged, paper * max([1.0, *_ratios_beyond(examined)]))
    value = np.nanmax([enlarged, paper, examined.internal_of_good])
    reason = Reason.BUDGET_CONTRADICTED if is_budget else Reason.CONTRADICTED
    stated = taken_up_by_models(examined)
    # shifts of groups are propagated already
    if is_budget or not examined.block.group_errors_m.get(APPROXIMATE_POINTS):
        stated = np.hypot(claimed, stated)
    if stated > value:
        value = stated
        reason = reason if beyond_stated(examined) > 1.0 else Reason.STATED
    return value, reason


def _enlarged_by_tests(examined):
    """What was predicted for the new points, enlarged as tests exceed it [m].

    The budget has seen the residuals itself: it is the prediction behind the tests that
    they exceed, and not the budget. 0 where nothing was predicted.
    """
    total, claim = examined.figures.mean_within, examined.claim
    predicted = _of_error_model(examined) if np.isnan(total) else total
    predicted = float(np.nan_to_num(predicted))
    return predicted * claim.enlargement


def _ratios_beyond(examined):
    """Ratios of differences at known points to those claimed, beyond chance."""
    known = (examined.confirmed_check, examined.unexplained_control)
    return [part.ratio for part in known if part.are_beyond]


def _of_single_points(examined, enlarged):
    """Enlarge single points as their RMS is, or as the test of their column shows."""
    figures, column = examined.figures, examined.claimed_column
    total, paper = figures.mean_within, figures.mean_paper
    claimed = total if column == TOTAL else paper
    factors = [1.0]
    if enlarged > 0.0 and claimed > 0.0:
        factors.append(enlarged / claimed)
    is_tested = (column == TOTAL) == np.isfinite(total)  # it is this column
    if is_tested and claimed > 0.0 and not examined.claim.is_supported:
        factors.append(_enlarged_by_tests(examined) / claimed)
    return float(max(factors))


def _by_independent_errors(examined) -> float:
    """What the known sources make of the new points, TOTAL, RMS [m].

    Beside shifts of groups that nothing tells, and beside whatever given approximate
    points share otherwise. NaN where not even that is known.
    """
    is_asked = examined.claim.is_assumed or examined.has_untold_groups
    return _of_error_model(examined) if is_asked else np.nan


def _of_error_model(examined) -> float:
    """Error of the new points by the model that claims are tested by, TOTAL, RMS [m].

    NaN without one.
    """
    model, points = examined.error_model, examined.points
    if model is None:
        return np.nan
    errors = propagate_model(model, examined.means)
    total = np.trace(errors.covariance[:, :2, :2], axis1=1, axis2=2)
    new = points.loc[points["role"] == "new", "point_id"]
    total = pd.Series(total, errors.point_ids).reindex(new)
    return float(np.sqrt(total.mean()))


def taken_up_by_models(examined) -> float:
    """Part of the stated error of approximate points that models follow, TOTAL [m].

    Where residuals are smaller than independent errors of that size would make them,
    neighbouring points share the rest, and each model lies as they do. Where only the
    residuals of neighbours are alike, nothing tells which part that is: all of it, as
    large as it was stated, or larger if residuals are. 0 where the residuals show
    everything, or nothing was stated.
    """
    block, claim = examined.block, examined.claim
    stated = block.approximate_m_0_m or 0.0
    of_groups = block.group_errors_m.get(APPROXIMATE_POINTS) or 0.0
    residuals = claim.of(RESIDUALS)
    if residuals is None:
        return 0.0
    seen = residuals.observed / residuals.predicted
    if residuals in claim.rejected and seen < 1.0:
        return float(stated * np.sqrt(1.0 - seen**2))
    alike = {claim.of(NEIGHBOURS), claim.of(REGIONS)} - {None}
    if not alike & set(claim.rejected):
        return 0.0
    return float(np.hypot(stated * max(seen, 1.0), of_groups))


def beyond_stated(examined) -> float:
    """By how much residuals of neighbours that are alike exceed what was stated.

    1 where chance explains it, or approximate points have no stated error.
    """
    claim, residuals = examined.claim, examined.claim.of(RESIDUALS)
    if residuals not in claim.rejected or claim.of(NEIGHBOURS) not in claim.rejected:
        return 1.0
    if taken_up_by_models(examined) == 0.0:
        return 1.0
    return float(max(residuals.observed / residuals.predicted, 1.0))


def figure_of_adjustment(examined) -> CredibleFigure:
    """Choose the figure of one adjustment to believe.

    Its own figure, enlarged by s_0 or by the differences at known points where chance
    does not explain them; as a lower bound where more than the size of the random
    errors must be wrong, deformed models among it.
    """
    return _beside_wrong_points(examined, _of_adjustment)


def _of_adjustment(examined):
    """The figure of one adjustment whose given points and names are right."""
    total, s_0 = examined.figures.mean_within, float(examined.adjustment.s_0)
    ratios = _ratios_beyond(examined)
    is_refuted = (
        bool(ratios)
        or (is_large_s_0(examined.adjustment) and s_0 > LARGEST_S_0)
        or examined.keeps_wrong_control
        or examined.is_deformed
        or control_contradicts(examined)
        or bool(examined.frame.doubt)
    )
    if is_large_s_0(examined.adjustment, LEAST_ENLARGEMENT):
        ratios.append(s_0)
    larger = larger_control_errors(examined)
    if larger is not None:
        # what they do to points may be more: neighbours may share them
        is_refuted = True
        ratios.append(larger.factor)
    copied = examined.copies.enlargement
    moved = _moved(examined, total, is_refuted=is_refuted)
    is_refuted = is_refuted or moved > 0.0 or copied > 1.0
    # tests and displacements see the same errors: the larger of the two
    value = copied * max(total * max([1.0, *ratios]), np.hypot(total, moved))
    enlargement = value / total if total > 0.0 else 1.0
    return CredibleFigure(
        value=float(np.hypot(value, examined.figures.shared_error)),
        is_lower_bound=is_refuted,
        column=examined.claimed_column,
        # s_0 never makes a figure smaller
        factor=float(np.nanmax([enlargement, s_0])),
        reason=_reason(total, is_refuted=is_refuted, is_enlarged=enlargement > 1.0),
        doubt=examined.frame.doubt,
    )


def _moved(examined, claimed, *, is_refuted):
    """What is wrong moves the new points by so much, TOTAL, RMS [m]; 0 without."""
    both = (examined.displaced, examined.displaced_together)
    sizes = (where_it_matters(d.plan, claimed, is_refuted=is_refuted) for d in both)
    moved, together = (
        max(
            size,
            _moved_by_strain(examined),
            _moved_by_film(examined),
            examined.moved_by_shown_heights,
        )
        for size in sizes
    )
    # the other way may be right; single wrong points say nothing of it
    if is_refuted or together > 0.0:
        moved = max(moved, examined.apart_from_two_steps.plan)
    return float(np.hypot(moved, examined.frame.could_be_off.plan))


def _moved_by_strain(examined):
    """What a strain of control moves points by, as it does control, TOTAL [m].

    0 where chance explains it. What is found refutes the errors that are stated, also
    where these are only larger for single points.
    """
    strain = examined.strain
    return strain.size if strain is not None and strain.is_significant else 0.0


def _moved_by_film(examined):
    """What film leaves in models of the low flight of two steps, TOTAL, RMS [m].

    Where it stands beside a strain of control, which refutes the claim as well. One
    adjustment joins models across the block, so that it suffers less. 0 without.
    """
    if examined.two_step is not examined:
        return 0.0
    return max(
        (
            part.bias
            for part in examined.patterns.affinities
            if part.axes is FilmAxes.GROUND and part.flight == LOW
        ),
        default=0.0,
    )


def _reason(total, *, is_refuted, is_enlarged):
    if not np.isfinite(total):
        return Reason.ADJUSTED_UNKNOWN
    if is_refuted:
        return Reason.ADJUSTED_CONTRADICTED
    return Reason.ADJUSTED_ENLARGED if is_enlarged else Reason.ADJUSTED


def is_large_s_0(adjustment, least=MIN_REPORTED_RATIO) -> bool:
    """Whether s_0 of an adjustment exceeds ``least``, and what chance explains."""
    if adjustment.redundancy <= 0:
        return False
    limits = ratio_limits(adjustment.redundancy, CLAIM_SIGNIFICANCE, least)
    return bool(adjustment.s_0 > limits[1])


def claimed_column(examined) -> str:
    """Column that two steps claim: the propagated one, unless the budget is larger.

    The budget is one of plain means: those of least variance may well be better, where
    nothing contradicts them.
    """
    is_better = examined.means.is_rigorous and has_credible_propagation(examined)
    return TOTAL if is_better else larger_column(examined)


def larger_column(examined) -> str:
    """Column of the larger figure of two steps, whatever the measurements say of it."""
    figures = examined.figures
    return TOTAL if figures.mean_total >= figures.mean_paper else PAPER


def has_credible_propagation(examined) -> bool:
    """Whether two steps have a propagated figure that no measurement contradicts."""
    total = examined.figures.mean_within
    is_explained = largest_measured(examined) <= MIN_REPORTED_RATIO * total
    has_fit = examined.misfit is None or not examined.misfit.is_large
    return bool(is_explained and has_fit and examined.claim.is_supported)


def largest_measured(examined) -> float:
    """The larger figure of the two that see the measurements, TOTAL [m]; 0 without.

    The paper's is one of plain means: those of least variance may well be better. The
    internal one is that without points whose coverages differ: they are named.
    """
    paper = np.nan if examined.means.is_rigorous else examined.figures.mean_paper
    return float(np.nanmax([paper, examined.internal_of_good, 0.0]))
