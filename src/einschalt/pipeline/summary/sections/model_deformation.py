"""Deformations that all models of a flight share, and which way to believe."""

from einschalt.foundations.typesetting import fixed, length, lengths
from einschalt.pipeline.assessment.facts.model_deformation import Belief
from einschalt.pipeline.summary.section import NO_SECTION, Section
from einschalt.pipeline.summary.wording import probability

ALIKE = (
    "alike: correlation of the residuals of neighbouring points in a model, after what "
    "was modelled; near 0 where errors are random."
)
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
    """Set what was tested and modelled."""
    if facts is None:
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


def belief_text(facts) -> str:
    """Say which of the two ways to believe for this block, and why."""
    if facts.belief in BETTER:
        return CHECKED.format(
            better=BETTER[facts.belief],
            simultaneous=length(facts.check_rms_simultaneous),
            two_steps=length(facts.check_rms_two_steps),
        )
    return BELIEFS[facts.belief]
