"""Both ways of densification, and the one that the measurements support best."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from einschalt.foundations.errors import GeometryError, SettingsError, TableError
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.assumed_control import (
    STATED,
    differences_without_part,
    with_assumed_errors,
)
from einschalt.pipeline.assessment.credibility import CredibleFigure
from einschalt.pipeline.assessment.examination import Examination, examine
from einschalt.pipeline.densification.one_adjustment import (
    adjust_beside,
    solve_in_one_adjustment,
)
from einschalt.pipeline.densification.simultaneous import require_adjustable
from einschalt.pipeline.densification.two_steps import solve_in_two_steps
from einschalt.stages.simultaneous.failed_models import LOOK_FOR_ERRORS

AUTO, TWO_STEP, SIMULTANEOUS = "auto", "two_step", "simultaneous"
# figures of precision are no better known than that
ALIKE = 1.03
# fewer points that were left out tell nothing of a way
FEWEST_LEFT_OUT = 8
# a way that gives fewer of the other one's points than that leaves a part of the block
# without coordinates, which no figure of the rest outweighs
NEARLY_ALL = 0.9
# unless the figure of all is so much larger that something else must be wrong
WORSE = 2.0
# they lie so much nearer to a way (RMS) that what contradicts its figure does not
# count: where it is the smaller one, and where it is not
NEARER, MUCH_NEARER = 0.9, 0.8
# and in height, of which two ways of a sound block may differ by more than in plan
MUCH_NEARER_IN_HEIGHT = 0.5


class ChoiceReason(StrEnum):
    """Why a way was taken."""

    ONLY_WAY = "only_way"  # the other one is not possible
    SUPPORTED = "supported"  # measurements contradict the other one's figure
    SMALLER = "smaller"  # its figure is the smaller one
    MORE_MODELS = "more_models"  # figures are alike, and it determines more models
    # the other one leaves a part of the block without coordinates
    MORE_POINTS = "more_points"
    # one control point is wrong, which two steps do not see: what it does is known in
    # one adjustment
    WRONG_CONTROL = "wrong_control"
    # heights of the other one are known to be worse by more than its plan is better
    HEIGHTS = "heights"
    # measurements contradict its figure, but control points that were left out lie
    # nearer to it
    LEFT_OUT = "left_out"
    CONTRADICTED = "contradicted"  # measurements contradict both figures: the default
    # no figure of both is known in full, but points that took no part lie nearer to it
    KNOWN_POINTS = "known_points"
    ONLY_FIGURE = "only_figure"  # the other one has no figure at all
    NO_FIGURE = "no_figure"  # neither has, or both lack the same error


@dataclass(frozen=True)
class MethodChoice:
    """Which way was taken, and why."""

    method: str  # "two_step" or "simultaneous"
    reason: ChoiceReason
    two_step: CredibleFigure | None  # None where it is not possible
    simultaneous: CredibleFigure | None
    obstacle: str  # what makes the other way impossible, or empty
    n_two_step: int | None = None  # new points of each, where both are possible
    n_simultaneous: int | None = None


def solve_the_better_way(
    block, settings, flights, report_progress
) -> tuple[Examination, MethodChoice]:
    """Densify a block in both ways, and keep the one that is better supported.

    By the figure to believe of each, which the tests of each enlarge; a figure that is
    a lower bound only gives way to one that is not, unless control points that were
    left out lie nearer to its points: much nearer where its figure is not smaller.
    """
    arguments = block, settings, flights, report_progress
    obstacle, failed = _obstacle(block, settings), None
    if not obstacle:
        try:
            examined = examine(solve_in_one_adjustment(*arguments))
        except (GeometryError, TableError) as error:  # what two steps do not need
            obstacle, failed = str(error), error
    if obstacle:
        try:
            examined = examine(solve_in_two_steps(*arguments))
        except GeometryError as error:
            if failed is None:
                raise
            # its own remedy may be the two steps
            raise failed.with_facts(remedy=LOOK_FOR_ERRORS) from error
        only = TWO_STEP, ChoiceReason.ONLY_WAY
        return examined, MethodChoice(*only, examined.credible, None, obstacle)
    beside = examined.solution.all_in_two_steps
    if not beside.is_possible:
        only = SIMULTANEOUS, ChoiceReason.ONLY_WAY
        return examined, MethodChoice(*only, None, examined.credible, beside.reason)
    two_step = examined.all_in_two_steps
    # as a cached property keeps it
    vars(two_step)["adjusted_beside"] = examined.adjustment
    better = better_of(two_step, examined)
    choice = _choice_of_both(better, two_step, examined)
    if choice.method == SIMULTANEOUS:
        return examined, choice
    if settings.residual_distribution != "none":  # what stands beside is without it
        return examine(solve_in_two_steps(*arguments)), choice
    return two_step, choice


def _obstacle(block, settings):
    """What forbids one adjustment of all models, or empty."""
    if settings.iterations > 1:
        return "iterations are those of two steps"
    try:
        require_adjustable(block)
    except SettingsError as error:
        return error.found
    return ""


def better_of(two_step, simultaneous) -> tuple[str, ChoiceReason]:
    """Method whose figure to believe is the better one, and the reason.

    Of two examinations, or what has their ``credible``, ``credible_heights``,
    ``figures``, ``models``, ``left_out_differences`` and ``left_out_heights``,
    ``left_out_control`` of the first, and of the second ``keeps_wrong_control`` and
    ``knows_wrong_control``. Figures of different points are not compared where one way
    leaves many without coordinates.
    """
    both = {TWO_STEP: two_step, SIMULTANEOUS: simultaneous}
    value = {name: found.credible.value for name, found in both.items()}
    known = [name for name in both if np.isfinite(value[name])]
    if len(known) < len(both):
        return _without_both_figures(both, known)
    # in blocks of one flight two steps test no control point by the others
    is_blind = two_step.left_out_control is None and simultaneous.knows_wrong_control
    # where control takes no part, two steps are compared with it
    is_told = two_step.credible.left_aside and not two_step.control_takes_part
    if is_blind and not is_told:
        return SIMULTANEOUS, ChoiceReason.WRONG_CONTROL
    fuller = _way_of_more_points(both)
    if fuller and value[fuller] <= WORSE * min(value.values()):
        return fuller, ChoiceReason.MORE_POINTS
    in_plan = _better_in_plan(both, value)
    in_height = _way_of_better_heights(both)
    is_of_plan = in_height is None or in_plan[0] == in_height
    return in_plan if is_of_plan else (in_height, ChoiceReason.HEIGHTS)


def _better_in_plan(both, value):
    """Method, and the reason, by both figures in plan and control that was left out."""
    sound = [name for name in both if not both[name].credible.is_lower_bound]
    smaller = min(both, key=value.get)
    nearer, ratio = _nearer_to_left_out(both)
    limit = NEARER if nearer == smaller else MUCH_NEARER
    if nearer not in sound and ratio <= limit:
        return nearer, ChoiceReason.LEFT_OUT
    if not sound:
        # wrong control that both ways keep spoils both
        if smaller == SIMULTANEOUS and _is_much_nearer(both):
            return SIMULTANEOUS, ChoiceReason.LEFT_OUT
        return TWO_STEP, ChoiceReason.CONTRADICTED
    if len(sound) == 1:
        return sound[0], ChoiceReason.SUPPORTED
    n_models = {
        name: int(found.models["is_usable"].sum()) for name, found in both.items()
    }
    are_alike = max(value.values()) <= ALIKE * min(value.values())
    if are_alike and len(set(n_models.values())) > 1:
        return max(both, key=n_models.get), ChoiceReason.MORE_MODELS
    return smaller, ChoiceReason.SMALLER


def _way_of_better_heights(both):
    """Way beside which heights of the other one are known to be wrong by much, or None.

    By measurements that contradict only the other one's, or by control that was left
    out; where that is more than what its plan is worse by.
    """
    heights = {name: found.credible_heights for name, found in both.items()}
    if any(each is None or not np.isfinite(each.value) for each in heights.values()):
        return None
    better, other = sorted(both, key=lambda name: heights[name].value)
    plan = {name: found.credible for name, found in both.items()}
    if heights[better].is_lower_bound or _is_only_bound(plan[better], plan[other]):
        return None
    if better == SIMULTANEOUS and both[better].keeps_wrong_control:
        return None
    gained = heights[other].value - heights[better].value
    if not gained > plan[better].value - plan[other].value:
        return None
    if heights[other].is_lower_bound:
        return better if heights[other].value > WORSE * heights[better].value else None
    tables = {name: found.left_out_heights for name, found in both.items()}
    nearer, ratio = _nearer(tables)
    return better if nearer == better and ratio <= MUCH_NEARER_IN_HEIGHT else None


def _is_only_bound(figure, other):
    return figure.is_lower_bound and not other.is_lower_bound


def _is_much_nearer(both):
    """Whether control that was left out lies much nearer to an adjustment.

    Also beside wrong control that it keeps, where two steps keep it as well.
    """
    if both[TWO_STEP].left_out_control is None:
        return False
    tables = {name: found.left_out_differences for name, found in both.items()}
    nearer, ratio = _nearer(tables)
    return nearer == SIMULTANEOUS and ratio <= MUCH_NEARER


def _without_both_figures(both, known):
    """The way that known points lie nearer to, where a figure is not known.

    What is not known of one way is nothing that the other is better by. Where no point
    tells, the way of the only figure, or the default where that lacks an error, too.
    """
    fuller = _way_of_more_points(both)
    if fuller:
        return fuller, ChoiceReason.MORE_POINTS
    alike = dict(zip(both, with_assumed_errors(*both.values()), strict=True))
    tables = {name: differences_without_part(way) for name, way in alike.items()}
    nearer, ratio = _nearer(tables)
    if ratio <= MUCH_NEARER and not alike[SIMULTANEOUS].keeps_wrong_control:
        return nearer, ChoiceReason.KNOWN_POINTS
    if not known:
        return TWO_STEP, ChoiceReason.NO_FIGURE
    is_whole = known != [TWO_STEP] or np.isfinite(both[TWO_STEP].figures.mean_total)
    return known[0], ChoiceReason.ONLY_FIGURE if is_whole else ChoiceReason.NO_FIGURE


def _way_of_more_points(both):
    """Way beside which the other one leaves many points out; None if neither does."""
    n_new = {name: found.figures.n_new for name, found in both.items()}
    fuller = max(both, key=n_new.get)
    return fuller if min(n_new.values()) < NEARLY_ALL * n_new[fuller] else None


# with these nothing speaks for the figure of the way that better_of gives
UNDECIDED = (
    ChoiceReason.MORE_MODELS,
    ChoiceReason.CONTRADICTED,
    ChoiceReason.ONLY_FIGURE,
    ChoiceReason.NO_FIGURE,
)


def better_beside(adjusted) -> MethodChoice | None:
    """The two steps, where they stand beside one adjustment and are known to be better.

    Of the examination of a simultaneous adjustment; None where it is as good, or where
    nothing tells.
    """
    if not adjusted.solution.all_in_two_steps.is_possible:
        return None
    return _if_better(TWO_STEP, adjusted.all_in_two_steps, adjusted)


def adjustment_beside(two_step) -> MethodChoice | None:
    """One adjustment of all models, where it is computed and better than two steps.

    Of the examination of two steps, of whose block it is made as ``method = "auto"``
    would, if it may gain and the block is small; None otherwise, or where it is no
    better.
    """
    if not is_tried(two_step):
        return None
    solution = two_step.solution
    what = solution, solution.block, solution.settings, solution.flights
    try:
        known = solution.searched, two_step.adjusted_beside
        adjusted = examine(adjust_beside(*what, *known), two_step)
    except (GeometryError, TableError):  # what the two steps do not need
        return None
    return _if_better(SIMULTANEOUS, two_step, adjusted)


def is_tried(two_step) -> bool:
    """Whether one adjustment is made as well, to tell what it would give."""
    return two_step.is_small and is_untried(two_step)


def _if_better(asked, two_step, adjusted):
    """The choice between both, if it falls on the method that is asked for."""
    method, reason = better_of(two_step, adjusted)
    if method != asked or reason in UNDECIDED:
        return None
    return _choice_of_both((method, reason), two_step, adjusted)


def _choice_of_both(better, two_step, adjusted):
    figures = two_step.credible, adjusted.credible
    n_new = two_step.figures.n_new, adjusted.figures.n_new
    return MethodChoice(*better, *figures, "", *n_new)


def is_untried(examined) -> bool:
    """Whether one adjustment of all models may gain, and nobody has asked for it.

    Where errors are as random and as large as given, it is the estimate of least
    variance: so where nothing contradicts the figure of the two steps. And where each
    model is deformed for itself, which an adjustment models as errors that the points
    of a model share, and two steps only propagate. And where it uses what these leave:
    control beside given approximate points, or models with too few points of known
    coordinates, whose neighbours tie them there.
    """
    settings = examined.settings
    if settings.method != TWO_STEP or _obstacle(examined.block, settings):
        return False
    if not np.isfinite(examined.figures.mean_total):
        return _leaves_points_out(examined) or _leaves_control(examined)
    is_supported = examined.claim.is_supported and not examined.credible.is_lower_bound
    is_deformed = examined.own_deformation is not None
    return bool(is_supported) or is_deformed or _leaves_points_out(examined)


def _leaves_points_out(examined):
    """Whether many measured points of the low flight have no coordinates."""
    measured = examined.model_points["low_flight"]["point_id"].unique()
    return bool(is_among(measured, examined.points["point_id"]).mean() < NEARLY_ALL)


def _leaves_control(examined):
    """Whether control is given, with its errors, and has no part in the two steps.

    Not where given points are known to be wrong: these are to be put right.
    """
    control = examined.block.control_points
    if examined.is_put_off:
        return False
    if control is None or examined.control_takes_part or STATED not in control:
        return False
    return bool((control["role"] != "check").any())


def _nearer_to_left_out(both):
    """Which way control that was left out lies nearer to, and how near.

    Name, and RMS of its differences over that of the other way, infinite where nothing
    tells; of control points that both ways can predict and neither suspects. Wrong
    control that an adjustment keeps spoils its points, but not these differences.
    """
    if both[SIMULTANEOUS].keeps_wrong_control:
        return TWO_STEP, np.inf
    return _nearer({name: found.left_out_differences for name, found in both.items()})


def _nearer(tables):
    """Which way points that took no part lie nearer to, and the ratio of their RMS."""
    tables = {name: table.dropna() for name, table in tables.items()}
    shared = tables[TWO_STEP].index.intersection(tables[SIMULTANEOUS].index)
    squares = {
        k: float(np.sum(table.loc[shared].to_numpy(dtype=float) ** 2))
        for k, table in tables.items()
    }
    nearer, other = sorted(squares, key=squares.get)
    if len(shared) < FEWEST_LEFT_OUT or not squares[other] > 0.0:
        return TWO_STEP, np.inf
    return nearer, float(np.sqrt(squares[nearer] / squares[other]))
