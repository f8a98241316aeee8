"""Deformations of models, shared or of each alone, and which way to believe."""

from einschalt.foundations.typesetting import fixed, length, lengths
from einschalt.pipeline.assessment.facts.model_deformation import Belief
from einschalt.pipeline.summary.section import NO_SECTION, Section
from einschalt.pipeline.summary.wording import probability

ALIKE = (
    "alike: correlation of the residuals of neighbouring points in a model, after what "
    "was modelled; near 0 where errors are random."
)
OWN_MODELLED = (
    "Tested for all models together: p {p}. The adjustment models it, and the standard "
    "errors hold it."
)
OWN_LEFT = "Tested for all models together: p {p}. It is not modelled."
NO_OWN = "Tested for all models together: p {p}. Chance explains it."
CHECKED = (
    "Believe the {better}: at the check points the simultaneous adjustment has "
    "{simultaneous}, two steps have {two_steps}."
)
BELIEFS = {
    Belief.DEFORMATION_LEFT: (
        "Believe the two steps, or model the deformation: the simultaneous adjustment "
        "accumulates it."
    ),
    Belief.MODELS_DIFFER: (
        "Believe the two steps, where they are possible: models are deformed each in "
        "its own way, and the simultaneous adjustment accumulates that."
    ),
    Belief.DEFORMATION_MODELLED: (
        "Believe the simultaneous adjustment: the deformation is modelled, and what is "
        "left shows no pattern."
    ),
    Belief.OWN_DEFORMATIONS_MODELLED: (
        "Believe the simultaneous adjustment: it models what each model is deformed by "
        "for itself, and its standard errors hold that."
    ),
    Belief.UNTESTED: (
        "Whether models are deformed cannot be tested: their points have too little "
        "redundancy. Neither way is better founded for this block."
    ),
    Belief.NO_DEFORMATION: (
        "Believe the simultaneous adjustment: no deformation shows."
    ),
}
BETTER = {
    Belief.CHECK_POINTS_SIMULTANEOUS: "simultaneous adjustment",
    Belief.CHECK_POINTS_TWO_STEPS: "two steps",
}


def section(facts) -> Section:
    """Set what was tested and modelled of the deformations that models share."""
    if facts is None or _is_spatial(facts):
        return NO_SECTION
    flights = facts.flights
    rows = zip(
        (flight.flight.replace("_", " ") for flight in flights),
        (probability(flight.p_value) for flight in flights),
        lengths([flight.size_middle for flight in flights]),
        lengths([flight.size_edge for flight in flights]),
        ("yes" if flight.is_modelled else "no" for flight in flights),
        (fixed(flight.neighbour_correlation, 2) for flight in flights),
        strict=True,
    )
    title = "Deformation that the models of a flight share (total, RMS)"
    header = ("", "p", "in the middle", "at the edge", "modelled", "alike")
    return Section(title, header, tuple(rows), (ALIKE, belief_text(facts)))


def _is_spatial(facts):
    """Whether shared deformations are not tested at all: those of spatial models."""
    return not facts.is_shared_tested


def own_section(facts) -> Section:
    """Set what each model is deformed by for itself, where that shows."""
    if facts is None or not (facts.is_own_detected or _is_spatial(facts)):
        return NO_SECTION
    in_plan = lengths([flight.own_edge for flight in facts.flights])
    columns = [[name.flight.replace("_", " ") for name in facts.flights], in_plan]
    header = ("", "in plan (total)")
    if _is_spatial(facts):
        columns.append(lengths([flight.own_edge_height for flight in facts.flights]))
        header = (*header, "in height")
    remark = OWN_MODELLED if facts.is_own_modelled else OWN_LEFT
    if not facts.is_own_detected:
        remark = NO_OWN
    remarks = [remark.format(p=probability(facts.own_p_value))]
    if _is_spatial(facts):
        remarks.append(belief_text(facts))
    title = "Deformation that each model has for itself (RMS at its edge)"
    return Section(title, header, tuple(zip(*columns, strict=True)), tuple(remarks))


def belief_text(facts) -> str:
    """Say which of the two ways to believe for this block, and why."""
    if facts.belief in BETTER:
        return CHECKED.format(
            better=BETTER[facts.belief],
            simultaneous=length(facts.check_rms_simultaneous),
            two_steps=length(facts.check_rms_two_steps),
        )
    return BELIEFS[facts.belief]
