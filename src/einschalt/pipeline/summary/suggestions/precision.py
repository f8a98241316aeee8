"""What to say of points that are worse than the others, and of a block that shrinks."""

from einschalt.pipeline.summary.suggestion import filled

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
IMPRECISE = (
    "{n_points:count new point} with standard errors of more than {times_usual:g} "
    "times the median of {median:length}, up to {largest:length} "
    "({names:names of n_points}); the others have {rms_of_others:length} (total, RMS)"
)
THEIR_MODELS = ". They are most points of low-flight {} {{models:names of n_models}}"
DEFORMED = {
    "check_points_two_steps": (
        "The check points agree better with the two steps "
        "({check_rms_two_steps:length}, simultaneous {check_rms_simultaneous:length}; "
        "total, RMS)"
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


def imprecise_points(finding):
    """Which points, the figure without them, and the models that they lie in."""
    n_models = finding.facts["n_models"]
    models = THEIR_MODELS.format("models" if n_models > 1 else "model")
    return filled(IMPRECISE + models if n_models else IMPRECISE, finding)


def deformed_models(finding):
    """Why the two steps are to be believed."""
    return filled(DEFORMED[finding.facts["belief"]], finding)


WORDS = {
    "deformed_models": deformed_models,
    "adjustment_that_misfits": (
        "The residuals of the simultaneous adjustment are {s_0:factor} as large as the "
        "given errors explain (s_0, redundancy {redundancy})"
    ),
    "imprecise_points": imprecise_points,
    "block_that_shrinks": (
        "Control does not hold the block against its own pull: errors of the model "
        "coordinates move the new points by about {moved:length} (total, RMS), up to "
        "{largest:length} at {worst:name}, {ratio_to_claimed:factor} the standard "
        "errors, which do not hold that"
    ),
}
