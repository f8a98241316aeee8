"""The first line: how many new points, and how good they are."""

import math
from functools import singledispatch

from einschalt.foundations.display_names import printable
from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.foundations.typesetting import length, names
from einschalt.pipeline.assessment.choice import (
    SIMULTANEOUS,
    TWO_STEP,
    ChoiceReason,
)
from einschalt.pipeline.assessment.credibility import Reason
from einschalt.pipeline.assessment.evidence.claim import KNOWN, LEFT_OUT
from einschalt.pipeline.assessment.evidence.ground.frame import Doubt
from einschalt.pipeline.assessment.facts.precision import (
    SimultaneousPrecision,
    TwoStepPrecision,
)
from einschalt.pipeline.summary.wording import length_or_worse, mean_of

# what makes every figure worthless
DOUBTS = mark_each(
    {
        Doubt.MIRRORED: "all models are mirrored: easting and northing exchanged?",
        Doubt.STRETCHED: "one axis has another scale: a wrong unit or decimal point?",
        Doubt.UPSIDE_DOWN: "models are upside down: easting and northing exchanged?",
        Doubt.OUT_OF_SCALE: "photographs of another scale: control not in metres?",
        Doubt.LARGER_THAN_FILM: "models larger than film: control not in metres?",
    }
)
SPREAD = mark("a few points dominate: median {median}, 95th percentile {most}")
BETTER = mark_each(
    {
        TWO_STEP: "the two steps are better: {figure} (--method two_step)",
        SIMULTANEOUS: (
            "a simultaneous adjustment is better: {figure} (--method simultaneous)"
        ),
    }
)
# whose figure is the larger one: what makes it the better way is said
SUPPORTED = mark_each(
    {
        TWO_STEP: (
            "the measurements support the figure of the two steps: {figure} "
            "(--method two_step)"
        ),
        SIMULTANEOUS: (
            "the measurements support the figure of a simultaneous adjustment: "
            "{figure} (--method simultaneous)"
        ),
    }
)
WRONG_CONTROL = mark(
    "a simultaneous adjustment shows what a wrong control point does: {figure} "
    "(--method simultaneous)"
)
# whose figure may be the larger one
BETTER_BY_LEFT_OUT = mark_each(
    {
        TWO_STEP: (
            "control that was left out agrees better with the two steps: {figure} "
            "(--method two_step)"
        ),
        SIMULTANEOUS: (
            "control that was left out agrees better with a simultaneous adjustment: "
            "{figure} (--method simultaneous)"
        ),
    }
)
# whose figure in plan may be the larger one
BETTER_HEIGHTS = mark_each(
    {
        TWO_STEP: (
            "the two steps have much better heights, and {figure} in plan "
            "(--method two_step)"
        ),
        SIMULTANEOUS: (
            "a simultaneous adjustment has much better heights, and {figure} in plan "
            "(--method simultaneous)"
        ),
    }
)
# whose figures lack an error, or are not known at all
BETTER_BY_KNOWN = mark_each(
    {
        TWO_STEP: (
            "known points without a part agree better with the two steps "
            "(--method two_step)"
        ),
        SIMULTANEOUS: (
            "known points without a part agree better with a simultaneous adjustment "
            "(--method simultaneous)"
        ),
    }
)
BETTER_OF_POINTS = mark_each(
    {
        TWO_STEP: (
            "the two steps give {n:new point|new points}: {figure} (--method two_step)"
        ),
        SIMULTANEOUS: (
            "a simultaneous adjustment gives {n:new point|new points}: {figure} "
            "(--method simultaneous)"
        ),
    }
)
MORE_POINTS = mark_each(  # without a figure
    {
        TWO_STEP: "the two steps give {n:new point|new points} (--method two_step)",
        SIMULTANEOUS: (
            "a simultaneous adjustment gives {n:new point|new points} "
            "(--method simultaneous)"
        ),
    }
)
CAUSES = mark_each(
    {
        "exchanged_names": "correct the exchanged names first",
        "exchanged_image_names": "correct the exchanged names first",
        "exchanged_control": "put the names of control right first",
        "models_upside_down": "correct the mirrored models first",
        "lone_wrong_check_point": "check the one check point that is far off first",
        "other_targets": "compare the targets of both flights first",
        "wrong_control_height": "check the wrong control height first",
        "broken_heights": "compare the heights of control first",
        "wrong_approximate_points": "check approximate point {name} first",
        "displaced_region": "check the displaced points first",
        "kept_gross_measurements": "gross errors take part: --outliers snoop",
        "strained_network": "check the control network for strain first",
        "film_affinity": "make models affine first",
        "models_in_another_unit": "convert the models in another unit first",
        "measurements_given_twice": "remove the measurements given twice first",
        **dict.fromkeys(
            ("control_that_contradicts", "control_against_block", "control_set_aside"),
            "check the wrong control first",
        ),
    }
)
# where there are several of them, the worst is named
CAUSE_OF_SEVERAL = mark_each(
    {
        "wrong_approximate_points": (
            "check approximate points first, {name} above all ({n} are wrong)"
        ),
    }
)
# where a region of control is displaced
CONTROL_IN = mark_each(
    {
        "north": "check the control points in the north first",
        "north_east": "check the control points in the north-east first",
        "east": "check the control points in the east first",
        "south_east": "check the control points in the south-east first",
        "south": "check the control points in the south first",
        "south_west": "check the control points in the south-west first",
        "west": "check the control points in the west first",
        "north_west": "check the control points in the north-west first",
        "middle": "check the control points in the middle first",
        "scattered": "check the displaced control points first",
    }
)
# what is told first, also beside a figure that it does not touch
BESIDE_ANY_FIGURE = ("exchanged_control",)
# what a computation without it has shown to move the points
MAKES_THE_BOUND = ("broken_network", "displaced_region", "wrong_approximate_points")
STRAINED = "strained_network"
LONE = "lone_wrong_check_point"
CONTROL_IN_SEVERAL = mark("check the control points of {n} displaced regions first")
CONTROL_IN_PARTS = mark("compare both parts of the control network first")
ELSEWHERE = mark("{figure} outside displaced regions")
ELSEWHERE_OF_BOTH = mark(
    "{figure} outside displaced regions and models with wrong approximate points"
)
ELSEWHERE_OF_POINTS = mark("{figure} outside models with wrong approximate points")
# with what a new point has of standing under the name of a known one, and without
ELSEWHERE_OF_NAMES = mark("{figure} with its name put right")
HEIGHT_ASIDE = mark("the height of point {name} is {length} off: check it first")
LEFT_ASIDE = mark("without point {name}, which is {length} off: check it first")
SEVERAL_LEFT_ASIDE = mark(
    "without points {names}, which are up to {length} off: check them first"
)
HEIGHTS = mark("heights {figure}")
FAILED = mark("{n} of {n_all:model|models} failed")
# what stands behind the number of points
BOUND = mark("{figure} (total, {mean})")
STATED = mark("{figure} (total, {mean}; including stated errors that models absorbed)")
PROPAGATED = mark("{figure} (total, {mean}; {paper} by Kovarik's budget)")
ASSUMED = mark(
    "{figure} (total, {mean}; errors of approximate points taken for independent)"
)
BUDGET = mark("{paper} by Kovarik's budget (total, {mean})")
ADJUSTED = mark("{figure} (total, simultaneous adjustment)")
ADJUSTED_BESIDE = mark(
    "{figure} (total, simultaneous adjustment; {two_steps} in two steps)"
)
ADJUSTED_BOUND = mark("{figure} (total, simultaneous adjustment; stated {stated})")
ADJUSTED_ENLARGED = mark(
    "{figure} (total, simultaneous adjustment, enlarged by s_0; stated {stated})"
)
NO_NEW = mark(
    "{n:known point|known points}, no new ones; {quantity}: {rms} (total, RMS)"
)
# differences at known points, those first that a fit has not made smaller
SAYS_MOST = (KNOWN["check"], LEFT_OUT, KNOWN["control"])


def verdict(assessment) -> str:
    """Say in one line how many points the block has and how good they are."""
    return f"{printable(assessment.block.name)}: {verdict_on(assessment)}"


def verdict_on(assessment) -> str:
    """Say the verdict without the name of the block."""
    precision, credible = assessment.precision, assessment.credible
    parts = [
        _new_points(precision, credible, assessment.known_points.differences),
        _left_aside(credible),
        _height_aside(assessment.findings),
        _elsewhere(credible, assessment.findings),
        _spread(assessment),
        _better(assessment.better),
        _heights(assessment.credible_heights),
        translated(DOUBTS[credible.doubt]) if credible.doubt in DOUBTS else "",
        _cause(assessment),
        _failed(assessment.block),
    ]
    return "; ".join(filter(None, parts))


def _new_points(precision, credible, known):
    """How many there are, and how good they are; without any, how good known ones."""
    if precision.n_new:
        new = translated("{n:new point|new points}", n=precision.n_new)
    elif known:
        quantity, _, rms = min(known, key=lambda row: SAYS_MOST.index(row[0]))
        said = {"quantity": translated(quantity), "rms": length(rms)}
        return translated(NO_NEW, n=_n_known(known), **said)
    else:
        new = translated("no new points")
    return f"{new}{_how_good(precision, credible)}"


def _n_known(known):
    return sum(n for quantity, n, _ in known if quantity != LEFT_OUT)


def _left_aside(credible):
    """Which known points the figure leaves aside, if there are any."""
    aside, off = credible.left_aside, length(credible.left_aside_by)
    if len(aside) > 1:
        return translated(SEVERAL_LEFT_ASIDE, names=names(aside), length=off)
    return translated(LEFT_ASIDE, name=names(aside), length=off) if aside else ""


def _height_aside(findings):
    """Which known height is far off, as no other is, if there is one."""
    found = next((f for f in findings if f.code == "lone_wrong_height"), None)
    if found is None:
        return ""
    off = length(found.facts["largest"])
    return translated(HEIGHT_ASIDE, name=printable(found.names[0]), length=off)


def _elsewhere(credible, findings):
    """The figure of the points that nothing displaced has moved, if there is one."""
    if not math.isfinite(credible.elsewhere):
        return ""
    codes = {found.code for found in findings}
    words = ELSEWHERE
    if credible.reason is Reason.EXCHANGED_NAMES:
        words = ELSEWHERE_OF_NAMES
    if "wrong_approximate_points" in codes:
        has_regions = "displaced_region" in codes
        words = ELSEWHERE_OF_BOTH if has_regions else ELSEWHERE_OF_POINTS
    return translated(words, figure=length(credible.elsewhere))


def _spread(assessment):
    """Say what most points have where a few make the figure, unless that is a bound."""
    spread = assessment.spread
    if spread is None or assessment.credible.is_lower_bound:
        return ""
    return translated(SPREAD, median=length(spread.median), most=length(spread.most))


def _better(choice):
    """Say the figure of the other way where that is known to be the better one."""
    if choice is None:
        return ""
    credible = getattr(choice, choice.method)
    said = {"figure": length_or_worse(credible)}
    if choice.reason is ChoiceReason.MORE_POINTS:
        n_new = getattr(choice, f"n_{choice.method}")
        words = BETTER_OF_POINTS if math.isfinite(credible.value) else MORE_POINTS
        return translated(words[choice.method], n=n_new, **said)
    return translated(_why_better(choice), **said)


def _why_better(choice):
    """Sentence of the figure of the better way: it may be the larger one."""
    if choice.reason is ChoiceReason.LEFT_OUT:
        return BETTER_BY_LEFT_OUT[choice.method]
    if choice.reason is ChoiceReason.HEIGHTS:
        return BETTER_HEIGHTS[choice.method]
    if choice.reason is ChoiceReason.KNOWN_POINTS:
        return BETTER_BY_KNOWN[choice.method]
    other = SIMULTANEOUS if choice.method == TWO_STEP else TWO_STEP
    if getattr(choice, choice.method).value > getattr(choice, other).value:
        if choice.reason is ChoiceReason.SUPPORTED:
            return SUPPORTED[choice.method]
        if choice.reason is ChoiceReason.WRONG_CONTROL:
            return WRONG_CONTROL
    return BETTER[choice.method]


def _cause(assessment):
    """Say what to mend first where something contradicts the figure."""
    code = _first(assessment)
    if not code:
        return ""
    cause = next(found for found in assessment.findings if found.code == code)
    if cause.facts.get("given") == "control_points":
        return _where_control_is_off(cause.facts)
    names = cause.names
    if code not in CAUSE_OF_SEVERAL:  # which name no point
        return translated(CAUSES[code])
    words = CAUSES[code] if len(names) == 1 else CAUSE_OF_SEVERAL[code]
    n = figure(len(names), "d")
    return translated(words, name=printable(names[0]), n=n)


def _first(assessment):
    """Code of the cause to mend first; empty without one."""
    findings = assessment.findings
    beside = next((f.code for f in findings if f.code in BESIDE_ANY_FIGURE), "")
    if beside or not assessment.credible.is_lower_bound:
        return beside
    # a claim that explains the budget is nothing to mend, and the point that was left
    # aside is named already
    told = {LONE} if assessment.credible.left_aside else set()
    causes = (code for code in assessment.causes if code in CAUSES.keys() - told)
    return next(causes, None) or _alone(findings)


def _alone(findings):
    """What makes the bound by itself, though no other finding follows from it.

    A strain of control, or film that stands beside one, where nothing else was shown
    to: no computation is without it.
    """
    proven = (f.code for f in findings if "explains" in f.facts)
    strained = (f.code for f in findings if _may_strain(f) and not f.explained_by)
    shown = next((code for code in proven if code in MAKES_THE_BOUND), "")
    return shown or next(strained, "")


def _may_strain(found):
    """Whether control is strained, or film is such that it looks so."""
    is_film = found.code == "film_affinity"
    return found.code == STRAINED or (
        is_film and any(part["axes"] == "ground" for part in found.facts["flights"])
    )


def _where_control_is_off(facts):
    """Say which control points to check: where one region is off, of several how many.

    Where nothing tells which part of the network is off, both.
    """
    if not facts["part_is_told"]:
        return translated(CONTROL_IN_PARTS)
    others = facts["further_regions"]
    if others:
        return translated(CONTROL_IN_SEVERAL, n=figure(1 + len(others), "d"))
    return translated(CONTROL_IN[facts["where"]])


def _heights(credible):
    """Heights are told where they are not as good as stated."""
    if credible is None or not credible.is_lower_bound:
        return ""
    return translated(HEIGHTS, figure=length_or_worse(credible))


def _failed(block):
    if not block.n_failed_models:
        return ""
    return translated(FAILED, n=block.n_failed_models, n_all=block.n_models)


# the figure includes what is propagated
OF_PROPAGATION = (
    Reason.PROPAGATED,
    Reason.EXCHANGED_CONTROL,
    Reason.EXCHANGED_NAMES,
)


@singledispatch
def _how_good(facts: TwoStepPrecision, credible):
    """The figure to believe, and another one beside it; or a bound."""
    if math.isnan(facts.mean.paper):
        return ""
    said = {
        "figure": length_or_worse(credible),
        "mean": mean_of(facts.n_coverages),
        "paper": length(facts.mean.paper),
    }
    if credible.is_lower_bound:
        message = BOUND
    elif credible.reason is Reason.STATED:
        message = STATED
    elif credible.reason is Reason.ASSUMED:
        message = ASSUMED
    else:
        message = PROPAGATED if credible.reason in OF_PROPAGATION else BUDGET
    return f", {translated(message, **said)}"


@_how_good.register
def _(facts: SimultaneousPrecision, credible):
    if math.isnan(facts.total):
        return f" {translated('from the simultaneous adjustment')}"
    # what control that was set aside does to the two steps is not in their figure
    other = None if facts.two_steps_keep_set_aside else facts.two_steps
    said = {"figure": length_or_worse(credible), "stated": length(facts.total)}
    if credible.is_lower_bound:
        is_other = said["stated"] != length(credible.value)
        message = ADJUSTED_BOUND if is_other else ADJUSTED
    elif credible.reason is Reason.ADJUSTED_ENLARGED:
        message = ADJUSTED_ENLARGED
    elif other is not None and math.isfinite(other.total):
        message, said["two_steps"] = ADJUSTED_BESIDE, length(other.total)
    else:
        message = ADJUSTED
    return f", {translated(message, **said)}"
