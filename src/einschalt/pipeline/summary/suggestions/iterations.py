"""What to say of a block that drifts while it is repeated on its own coordinates."""

from math import isfinite

from einschalt.foundations.typesetting import count, length
from einschalt.pipeline.summary.suggestion import Suggestion

REMEDIES = {
    "one_pass_or_measure_control": (
        "Set iterations = 1, or measure control in the low flight"
    ),
    "one_pass_or_more_control": (
        "Set iterations = 1, or give the low flight more control"
    ),
}


def drift_without_control(finding):
    """How far it drifted, and what that makes of the figure."""
    facts = finding.facts
    problem = (
        "The low flight was repeated on its own coordinates, and no control point "
        f"holds it: the block drifts, so far by up to {length(facts['moved'])} (RMS)"
    )
    if isfinite(facts["propagated_now"]):
        problem += (
            f"; propagated {length(facts['propagated_once'])} after one pass, "
            f"{length(facts['propagated_now'])} now"
        )
    return Suggestion(problem, REMEDIES[finding.remedy])


def iterations_that_spoil(finding):
    """Both figures."""
    facts = finding.facts
    return Suggestion(
        "The iterations make the points worse, "
        f"{length(facts['propagated_now'])} instead of "
        f"{length(facts['propagated_once'])} after one pass (propagated): "
        f"{_held(facts)}",
        REMEDIES[finding.remedy],
    )


def drift_that_nothing_tells(finding):
    """How far the others may have drifted."""
    facts = finding.facts
    return Suggestion(
        f"{_held(facts)}: the others may have drifted by up to "
        f"{length(facts['moved'])} (RMS), and no propagated figure tells",
        REMEDIES[finding.remedy],
    )


def _held(facts):
    models = count(facts["n_models"], "model")
    return f"{facts['n_models_held']} of {models} of the low flight hold control"


WORDS = {
    "drift_without_control": drift_without_control,
    "iterations_that_spoil": iterations_that_spoil,
    "drift_that_nothing_tells": drift_that_nothing_tells,
}
