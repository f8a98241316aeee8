"""What to say of points that are worse than the others, and of a block that shrinks."""

from einschalt.foundations.language import mark, mark_each
from einschalt.pipeline.summary.suggestion import filled

REMEDIES = mark_each(
    {
        "measure_more_control_there": (
            "Measure more control there, spread over the model, or do without these "
            "points"
        ),
        "believe_the_two_steps": (
            'Use the two steps, or set model_deformation = "modelled"'
        ),
        "look_for_names_control_and_units": (
            "Look for exchanged names, wrong control and wrong units"
        ),
        "give_larger_errors": (
            "Look for gross errors and deformed models, or state larger m_g_um and "
            "standard_error_m"
        ),
        "give_that_standard_error": (
            "Give that figure: with a larger one control counts too little, and the "
            "points become worse"
        ),
        "check_unit_of_control_errors": (
            "Give standard_error_m in metres: divide the figures by 100, or 1000"
        ),
        "give_control_on_the_far_side": "Give control on the far side of the block too",
    }
)
IMPRECISE = mark(
    "{n_points:count new point} with standard errors of more than {times_usual:g} "
    "times the median of {median:length}, up to {largest:length} "
    "({names:names of n_points}); the others have {rms_of_others:length} (total, RMS)"
)
IMPRECISE_IN_MODELS = mark(
    "{n_points:count new point} with standard errors of more than {times_usual:g} "
    "times the median of {median:length}, up to {largest:length} "
    "({names:names of n_points}); the others have {rms_of_others:length} (total, "
    "RMS). They are most points of low-flight {n_models:count model}: "
    "{models:names of n_models}"
)
DEFORMED = mark_each(
    {
        "check_points_two_steps": (
            "The check points agree better with the two steps "
            "({check_rms_two_steps:length}, simultaneous "
            "{check_rms_simultaneous:length}; total, RMS)"
        ),
        "deformation_left": (
            "The models of a flight have a common deformation that is not modelled: "
            "the simultaneous adjustment accumulates it"
        ),
        "models_differ": (
            "Each model is deformed in its own way: the simultaneous adjustment "
            "accumulates these deformations"
        ),
    }
)


STATED_TOO_LARGE = mark(
    "The standard errors of control in plan are given as {stated:length}, but the "
    "residuals show {shown:length} (total, RMS; ± {error_of_shown:length})"
)
IN_ANOTHER_UNIT = mark_each(
    {
        "centimetres": (
            "The standard errors of control in plan are given as {stated:length}, but "
            "the residuals show {shown:length} (total, RMS; ± "
            "{error_of_shown:length}), as if they were centimetres"
        ),
        "millimetres": (
            "The standard errors of control in plan are given as {stated:length}, but "
            "the residuals show {shown:length} (total, RMS; ± "
            "{error_of_shown:length}), as if they were millimetres"
        ),
    }
)


def wrong_control_errors(finding):
    """Both figures, and the unit that would explain them."""
    unit = finding.facts["unit"]
    return filled(IN_ANOTHER_UNIT[unit] if unit else STATED_TOO_LARGE, finding)


def imprecise_points(finding):
    """Which points, the figure without them, and the models that they lie in."""
    has_models = finding.facts["n_models"] > 0
    return filled(IMPRECISE_IN_MODELS if has_models else IMPRECISE, finding)


def deformed_models(finding):
    """Why the two steps are to be believed."""
    return filled(DEFORMED[finding.facts["belief"]], finding)


WORDS = mark_each(
    {
        "deformed_models": deformed_models,
        "adjustment_that_misfits": (
            "The residuals of the simultaneous adjustment are {s_0:factor} as large as "
            "the stated errors explain (s_0, redundancy {redundancy})"
        ),
        "imprecise_points": imprecise_points,
        "wrong_control_errors": wrong_control_errors,
        "block_that_shrinks": (
            "Control does not keep the block from shrinking: errors of the model "
            "coordinates move the new points by about {moved:length} (total, RMS), up "
            "to {largest:length} at {worst:name}, {ratio_to_claimed:factor} the "
            "standard errors, which do not include that"
        ),
    }
)
