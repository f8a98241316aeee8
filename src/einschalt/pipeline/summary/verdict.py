"""The first line: how many new points, and how good they are."""

import math
from functools import singledispatch

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import count, length
from einschalt.pipeline.assessment.credibility import Reason
from einschalt.pipeline.assessment.evidence.ground.frame import Doubt
from einschalt.pipeline.assessment.facts.precision import (
    SimultaneousPrecision,
    TwoStepPrecision,
)
from einschalt.pipeline.summary.wording import mean_of

# what makes every figure worthless
DOUBTS = {
    Doubt.NONE: "",
    Doubt.MIRRORED: "; all models are mirrored: easting and northing exchanged?",
    Doubt.STRETCHED: "; one axis has another scale: a wrong unit or decimal point?",
    Doubt.UPSIDE_DOWN: "; models are upside down: easting and northing exchanged?",
    Doubt.OUT_OF_SCALE: "; photographs of another scale: control not in metres?",
    Doubt.LARGER_THAN_FILM: "; models larger than film: control not in metres?",
}


SPREAD = "; a few points dominate: median {}, 95 % below {}"
BETTER = "; the two steps are better: {} (--method two_step)"
CAUSES = {
    "exchanged_names": "; first mend the exchanged names",
    "measurements_given_twice": "; first mend the measurements that are given twice",
}


def verdict(assessment) -> str:
    """Say in one line how many points the block has and how good they are."""
    return f"{printable(assessment.block.name)}: {verdict_on(assessment)}"


def verdict_on(assessment) -> str:
    """Say the verdict without the name of the block."""
    n_new, block = assessment.precision.n_new, assessment.block
    new = count(n_new, "new point") if n_new else "no new points"
    credible = assessment.credible
    said = f"{new}{_how_good(assessment.precision, credible)}"
    said += f"{_spread(assessment)}{_better(assessment.better)}"
    said += f"{_heights(assessment.credible_heights)}{DOUBTS[credible.doubt]}"
    said += _cause(assessment)
    if not block.n_failed_models:
        return said
    n_all = count(block.n_models, "model")
    return f"{said}; {block.n_failed_models} of {n_all} failed"


def _spread(assessment):
    """Say what most points have where a few make the figure, unless that is a bound."""
    spread = assessment.spread
    if spread is None or assessment.credible.is_lower_bound:
        return ""
    return SPREAD.format(length(spread.median), length(spread.most))


def _better(choice):
    """Say the figure of the other way where that is known to be the better one."""
    if choice is None:
        return ""
    figure = choice.two_step
    bound = " or worse" if figure.is_lower_bound else ""
    return BETTER.format(f"{length(figure.value)}{bound}")


def _cause(assessment):
    """Say what to mend first where something contradicts the figure."""
    if not assessment.causes or not assessment.credible.is_lower_bound:
        return ""
    return CAUSES[assessment.causes[0]]


def _heights(credible):
    """Heights are told where they are not as good as stated."""
    if credible is None or not credible.is_lower_bound:
        return ""
    return f"; heights {length(credible.value)} or worse"


@singledispatch
def _how_good(facts: TwoStepPrecision, credible):
    """The figure to believe, and another one beside it; or a bound."""
    if math.isnan(facts.mean.paper):
        return ""
    mean, value = mean_of(facts.n_coverages), length(credible.value)
    if credible.is_lower_bound:
        return f", {value} or worse (total, {mean})"
    if credible.reason is Reason.STATED:
        return f", {value} (total, {mean}; with the stated errors that models took up)"
    paper = f"{length(facts.mean.paper)} after Kovarik's budget"
    if credible.reason is Reason.PROPAGATED:
        return f", {value} (total, {mean}; {paper})"
    return f", {paper} (total, {mean})"


@_how_good.register
def _(facts: SimultaneousPrecision, credible):
    if math.isnan(facts.total):
        return " from the simultaneous adjustment"
    other = facts.two_steps
    is_known = other is not None and math.isfinite(other.total)
    beside = f"; {length(other.total)} in two steps" if is_known else ""
    value = length(credible.value)
    stated = length(facts.total)
    if credible.is_lower_bound:
        beside = f"; stated {stated}" if stated != value else ""
        value = f"{value} or worse"
    elif credible.reason is Reason.ADJUSTED_ENLARGED:
        beside = f", enlarged by s_0; stated {stated}"
    return f", {value} (total, simultaneous adjustment{beside})"
