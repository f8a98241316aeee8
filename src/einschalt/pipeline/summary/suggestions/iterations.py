"""What to say of a block that drifts while it is repeated on its own coordinates."""

from math import isfinite

from einschalt.foundations.language import mark, mark_each
from einschalt.pipeline.summary.suggestion import filled

REMEDIES = mark_each(
    {
        "one_pass_or_measure_control": (
            "Set iterations = 1, or measure control in the low flight"
        ),
        "one_pass_or_more_control": (
            "Set iterations = 1, or give the low flight more control"
        ),
    }
)
DRIFTS = mark(
    "The low flight was repeated on its own coordinates without a control point to "
    "hold it: the block drifts, so far by up to {moved:length} (RMS)"
)
DRIFTS_BY = mark(
    "The low flight was repeated on its own coordinates without a control point to "
    "hold it: the block drifts, so far by up to {moved:length} (RMS); propagated "
    "{propagated_once:length} after one pass, {propagated_now:length} now"
)


def drift_without_control(finding):
    """How far it drifted, and what that makes of the figure."""
    is_known = isfinite(finding.facts["propagated_now"])
    return filled(DRIFTS_BY if is_known else DRIFTS, finding)


WORDS = mark_each(
    {
        "drift_without_control": drift_without_control,
        "iterations_that_spoil": (
            "The iterations make the points worse, {propagated_now:length} instead of "
            "{propagated_once:length} after one pass (propagated): only "
            "{n_models_held} of {n_models:count model} of the low flight contain "
            "control"
        ),
        "drift_that_nothing_tells": (
            "Only {n_models_held} of {n_models:count model} of the low flight contain "
            "control: the others may have drifted by up to {moved:length} (RMS), which "
            "no propagated figure shows"
        ),
    }
)
