"""Deformations of models, shared or of each alone, and which way to believe."""

import math

from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.typesetting import fixed, length, lengths
from einschalt.pipeline.assessment.choice import TWO_STEP
from einschalt.pipeline.assessment.facts.model_deformation import Belief
from einschalt.pipeline.summary.section import NO_SECTION, Section
from einschalt.pipeline.summary.wording import flight_name, probability

MODELLED = mark_each({True: "modelled", False: "not modelled"})
ALIKE = mark(
    "correlation: of the residuals of neighbouring points in a model, after what was "
    "modelled; near 0 if errors are random."
)
OWN_MODELLED = mark(
    "Tested for all models together: p {p}. The adjustment models it, and the standard "
    "errors include it."
)
OWN_LEFT = mark("Tested for all models together: p {p}. It is not modelled.")
PHOTOGRAPHS_IN_ERRORS = mark(
    "Tested for all photographs together: p {p}. The coordinates are as without it, "
    "and the standard errors include it."
)
PHOTOGRAPHS_LEFT = mark(
    "Tested for all photographs together: p {p}. The standard errors are without it."
)
NO_PHOTOGRAPHS = mark(
    "Tested for all photographs together: p {p}. It is not significant."
)
NO_OWN = mark("Tested for all models together: p {p}. It is not significant.")
CHECKED = mark_each(
    {
        Belief.CHECK_POINTS_SIMULTANEOUS: (
            "Use the simultaneous adjustment: at the check points it has "
            "{simultaneous}, the two steps have {two_steps}."
        ),
        Belief.CHECK_POINTS_TWO_STEPS: (
            "Use the two steps: at the check points they have {two_steps}, the "
            "simultaneous adjustment has {simultaneous}."
        ),
    }
)
BELIEFS = mark_each(
    {
        Belief.DEFORMATION_LEFT: (
            "Use the two steps, or model the deformation: the simultaneous adjustment "
            "accumulates it."
        ),
        Belief.MODELS_DIFFER: (
            "Use the two steps if they are possible: each model is deformed in its own "
            "way, and the simultaneous adjustment accumulates these deformations."
        ),
        Belief.DEFORMATION_MODELLED: (
            "Use the simultaneous adjustment: the deformation is modelled, and the "
            "remaining residuals show no pattern."
        ),
        Belief.OWN_DEFORMATIONS_MODELLED: (
            "Use the simultaneous adjustment: it models the deformation of each model, "
            "and its standard errors include it."
        ),
        Belief.PHOTOGRAPHS_BENT: (
            "Photographs are bent, each in its own way: no adjustment corrects that, "
            "and the standard errors of the simultaneous one include it."
        ),
        Belief.UNTESTED: (
            "Deformation of models cannot be tested: their points have too little "
            "redundancy. Neither method is better founded for this block."
        ),
        Belief.NO_DEFORMATION: (
            "Use the simultaneous adjustment: no deformation was found."
        ),
    }
)
OF_SPACE = mark(
    "Use the simultaneous adjustment: the bend is modelled, and its standard errors "
    "include it."
)
# where something else than deformation speaks for the two steps, as the verdict says
BESIDE_BETTER_TWO_STEPS = mark_each(
    {
        Belief.DEFORMATION_MODELLED: (
            "The deformation is modelled, and the remaining residuals show no pattern; "
            "the two steps are better for another reason."
        ),
        Belief.OWN_DEFORMATIONS_MODELLED: (
            "The adjustment models the deformation of each model, and its standard "
            "errors include it; the two steps are better for another reason."
        ),
        Belief.NO_DEFORMATION: (
            "No deformation was found; the two steps are better for another reason."
        ),
    }
)


def section(facts, better=None) -> Section:
    """Set what was tested and modelled of the deformations that models share.

    ``better``: the choice of the method that the verdict names as the better one.
    """
    if facts is None or not facts.is_shared_tested:
        return NO_SECTION
    flights = facts.flights
    columns = [
        [flight_name(flight.flight) for flight in flights],
        [probability(flight.p_value) for flight in flights],
        lengths([flight.size_middle for flight in flights]),
        lengths([flight.size_edge for flight in flights]),
        [translated(MODELLED[flight.is_modelled]) for flight in flights],
    ]
    header = (
        *("", "p", translated("in the middle"), translated("at the edge")),
        translated("in the adjustment"),
    )
    remarks = [belief_text(facts, better)]
    title = translated("Deformation common to the models of a flight (total, RMS)")
    if facts.is_spatial:
        title = translated("Bend in height common to the models of a flight (RMS)")
    else:
        columns.append([fixed(f.neighbour_correlation, 2) for f in flights])
        header = (*header, translated("correlation"))
        remarks.insert(0, translated(ALIKE))
    return Section(title, header, tuple(zip(*columns, strict=True)), tuple(remarks))


def own_section(facts, better=None) -> Section:
    """Set what each model is deformed by for itself, where that shows.

    Of spatial models whether it does or not.
    """
    if facts is None or not (facts.is_own_detected or _is_own_tested_in_space(facts)):
        return NO_SECTION
    in_plan = lengths([flight.own_edge for flight in facts.flights])
    columns = [[flight_name(flight.flight) for flight in facts.flights], in_plan]
    header = ("", translated("in plan (total)"))
    if facts.is_spatial and not facts.are_photographs:
        columns.append(lengths([flight.own_edge_height for flight in facts.flights]))
        header = (*header, translated("in height"))
    remarks = [translated(_remark_of_own(facts), p=probability(facts.own_p_value))]
    if not facts.is_shared_tested:
        remarks.append(belief_text(facts, better))
    title = translated("Deformation of each single model (RMS at its edge)")
    if facts.are_photographs:
        title = translated("Deformation of each single photograph (RMS at its edge)")
    return Section(title, header, tuple(zip(*columns, strict=True)), tuple(remarks))


def _remark_of_own(facts):
    of_models = OWN_MODELLED, OWN_LEFT, NO_OWN
    of_photographs = PHOTOGRAPHS_IN_ERRORS, PHOTOGRAPHS_LEFT, NO_PHOTOGRAPHS
    modelled, left, none = of_photographs if facts.are_photographs else of_models
    if not facts.is_own_detected:
        return none
    return modelled if facts.is_own_modelled else left


def _is_own_tested_in_space(facts):
    return facts.is_spatial and math.isfinite(facts.own_p_value)


def belief_text(facts, better=None) -> str:
    """Say which of the two methods to use for this block, and why.

    Not against the verdict, which may know another one to be ``better``.
    """
    if facts.belief in CHECKED:
        return translated(
            CHECKED[facts.belief],
            simultaneous=length(facts.check_rms_simultaneous),
            two_steps=length(facts.check_rms_two_steps),
        )
    if facts.is_spatial and facts.belief is Belief.DEFORMATION_MODELLED and not better:
        return translated(OF_SPACE)
    words = BELIEFS
    if better is not None and better.method == TWO_STEP:
        words = BELIEFS | BESIDE_BETTER_TWO_STEPS
    return translated(words[facts.belief])
