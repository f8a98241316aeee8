"""What to say of a block that drifts while it is repeated on its own coordinates."""

from math import isfinite

from einschalt.pipeline.summary.suggestion import filled

REMEDIES = {
    "one_pass_or_measure_control": (
        "Set iterations = 1, or measure control in the low flight"
    ),
    "one_pass_or_more_control": (
        "Set iterations = 1, or give the low flight more control"
    ),
}
HELD = "{n_models_held} of {n_models:count model} of the low flight hold control"
DRIFTS = (
    "The low flight was repeated on its own coordinates, and no control point holds "
    "it: the block drifts, so far by up to {moved:length} (RMS)"
)
FIGURES = (
    "; propagated {propagated_once:length} after one pass, {propagated_now:length} now"
)


def drift_without_control(finding):
    """How far it drifted, and what that makes of the figure."""
    is_known = isfinite(finding.facts["propagated_now"])
    return filled(DRIFTS + FIGURES if is_known else DRIFTS, finding)


WORDS = {
    "drift_without_control": drift_without_control,
    "iterations_that_spoil": (
        "The iterations make the points worse, {propagated_now:length} instead of "
        f"{{propagated_once:length}} after one pass (propagated): {HELD}"
    ),
    "drift_that_nothing_tells": (
        f"{HELD}: the others may have drifted by up to "
        "{moved:length} (RMS), and no propagated figure tells"
    ),
}
