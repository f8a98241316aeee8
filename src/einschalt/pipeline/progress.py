"""The stages through which a computation passes, as they are shown and recorded."""

from enum import StrEnum


class Stage(StrEnum):
    """A stage of the computation of a block; as a str it is the title that is shown.

    ``fraction`` of the computation is done when it begins; ``key`` is its name in
    tables of failures.

    Examples
    --------
    >>> Stage.MODEL_TRANSFORMATION.key
    'stage3_model_transformation'
    >>> f"{Stage.MODEL_TRANSFORMATION.fraction:.0%} {Stage.MODEL_TRANSFORMATION}"
    '50% model transformation'
    """

    READING = "reading", 0.0
    RELATIVE_ORIENTATION = "relative orientation", 0.0, "stage2_relative_orientation"
    APPROXIMATE_COORDINATES = (
        "approximate coordinates",
        0.3,
        "stage1_approximate_coordinates",
    )
    # with the error budget and the means of each pass of the low flight
    MODEL_TRANSFORMATION = "model transformation", 0.5, "stage3_model_transformation"
    ERROR_PROPAGATION = "error propagation", 0.9, "stage4_error_propagation"
    DOUBLE_COVERAGE = "double coverage", 0.95, "stage5_double_coverage"
    SIMULTANEOUS_ADJUSTMENT = "simultaneous adjustment", 0.97
    DONE = "done", 1.0
    # after the computation, while results are made of it
    ASSESSMENT = "assessment", 1.0
    WRITING = "writing", 1.0

    def __new__(cls, title, fraction, key=None):
        """Make a member whose value is its title."""
        stage = str.__new__(cls, title)
        stage._value_ = title
        stage.fraction = fraction
        stage.key = key or title.replace(" ", "_")
        return stage


# of the whole work when results are assessed and written as well
SHARES = {Stage.ASSESSMENT: 0.85, Stage.WRITING: 0.9, Stage.DONE: 1.0}


def share_of_work(stage, fraction):
    """Fraction of the whole work, when a fraction of the computation is done.

    ``stage`` may be any title.

    Examples
    --------
    >>> share_of_work(Stage.MODEL_TRANSFORMATION, 0.5), share_of_work("writing", 1.0)
    (0.425, 0.9)
    """
    return SHARES.get(stage, SHARES[Stage.ASSESSMENT] * fraction)


def stage_reporter(progress):
    """Give what reports a stage to a caller who may not be interested."""

    def report_progress(stage):
        if progress is not None:
            progress(stage, stage.fraction)

    return report_progress
