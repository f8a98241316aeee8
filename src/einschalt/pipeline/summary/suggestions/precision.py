"""What to say of points that are worse than the others, and of a block that shrinks."""

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import count, factor, length
from einschalt.pipeline.summary.suggestion import Suggestion
from einschalt.pipeline.summary.wording import some_of

REMEDIES = {
    "measure_more_control_there": (
        "Measure more control there, spread over the model, or do without these points"
    ),
    "believe_the_two_steps": (
        'Believe the two steps, or set model_deformation = "modelled"'
    ),
    "look_for_names_control_and_units": (
        "Look for exchanged names, wrong control and wrong units"
    ),
    "give_larger_errors": (
        "Look for gross errors and deformed models, or give larger m_g_um and "
        "standard_error_m"
    ),
    "give_control_on_the_far_side": "Give control on the far side of the block too",
}


def imprecise_points(finding):
    """Which points, the figure without them, and the models that they lie in."""
    facts = finding.facts
    n_points, n_models = facts["n_points"], facts["n_models"]
    problem = (
        f"{count(n_points, 'new point')} with standard errors of more than "
        f"{facts['times_usual']:g} times the median of {length(facts['median'])}, up "
        f"to {length(facts['largest'])} ({some_of(finding.names, n_points)}); the "
        f"others have {length(facts['rms_of_others'])} (total, RMS)"
    )
    if n_models:
        models = "models" if n_models > 1 else "model"
        shown = some_of(facts["models"], n_models)
        problem += f". They are most points of low-flight {models} {shown}"
    return Suggestion(problem, REMEDIES[finding.remedy])


def block_that_shrinks(finding):
    """How far the points are moved."""
    facts = finding.facts
    return Suggestion(
        "Control does not hold the block against its own pull: errors of the model "
        f"coordinates move the new points by about {length(facts['moved'])} (total, "
        f"RMS), up to {length(facts['largest'])} at {printable(facts['worst'])}, "
        f"{factor(facts['ratio_to_claimed'])} the standard errors, which do not hold "
        "that",
        REMEDIES[finding.remedy],
    )


def adjustment_that_misfits(finding):
    """How much larger the residuals are than the given errors explain."""
    facts = finding.facts
    return Suggestion(
        f"The residuals of the simultaneous adjustment are {factor(facts['s_0'])} as "
        f"large as the given errors explain (s_0, redundancy {facts['redundancy']})",
        REMEDIES[finding.remedy],
    )


DEFORMED = {
    "check_points_two_steps": (
        "The check points agree better with the two steps ({two_steps}, simultaneous "
        "{simultaneous}; total, RMS)"
    ),
    "deformation_left": (
        "The models of a flight share a deformation that is not modelled: the "
        "simultaneous adjustment accumulates it"
    ),
    "models_differ": (
        "Models are deformed, each in its own way: the simultaneous adjustment "
        "accumulates that"
    ),
}


def deformed_models(finding):
    """Why the two steps are to be believed."""
    facts = finding.facts
    problem = DEFORMED[facts["belief"]].format(
        two_steps=length(facts["check_rms_two_steps"]),
        simultaneous=length(facts["check_rms_simultaneous"]),
    )
    return Suggestion(problem, REMEDIES[finding.remedy])


WORDS = {
    "deformed_models": deformed_models,
    "adjustment_that_misfits": adjustment_that_misfits,
    "imprecise_points": imprecise_points,
    "block_that_shrinks": block_that_shrinks,
}
