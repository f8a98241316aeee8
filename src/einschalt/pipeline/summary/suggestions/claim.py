"""What to say of a block whose claimed figure does not stand."""

from einschalt.foundations.typesetting import fixed, length
from einschalt.pipeline.assessment.claim import NEIGHBOURS, RESIDUALS
from einschalt.pipeline.summary.suggestion import Suggestion

INDEPENDENT = (
    "Approximate coordinates whose errors are independent would not show this: they "
    "share errors, as those of one orientation do, which no figure here holds. Trust "
    "check points, or densify from a high flight over control"
)
MODEL_OF_ERRORS = (
    "Look for deformed models, gross errors and wrong sizes of errors; trust check "
    "points more than the figures"
)


def claim_that_does_not_stand(result):
    """Measurements that contradict what the claimed figure predicts."""
    claim = result.claim
    if claim.is_supported:
        return None
    return Suggestion(
        f"The claimed figure does not stand: {'; '.join(map(_said, claim.rejected))}",
        INDEPENDENT if result.high is None else MODEL_OF_ERRORS,
    )


def _said(test):
    if test.name == NEIGHBOURS:
        return (
            "residuals of neighbours are alike (correlation "
            f"{fixed(test.observed, 2)}, expected {fixed(test.predicted, 2)})"
        )
    verb = "is" if test.observed > test.predicted else "is only"
    size = f"{verb} {length(test.observed)}, predicted {length(test.predicted)}"
    what = (
        "the size of the residuals" if test.name == RESIDUALS else f"RMS of {test.name}"
    )
    return f"{what} {size}"


def figure_left_out(result):
    """Say what is missing for the propagated figure, where it can be given."""
    block = result.block
    if result.errors is not None or block.high_flight is None:
        return None
    if "standard_error_m" in block.control_points:
        return None
    return Suggestion(
        "standard_error_total is left out: the control points have no "
        "standard_error_m. The figures that remain are too small",
        "Give standard_error_m, TOTAL in metres, in [control_points]",
    )


def no_check_points(result):
    """Nothing from outside confirms the figures."""
    if result.figures.n_check > 0:
        return None
    return Suggestion(
        "No check points: nothing from outside confirms the figures below",
        'Give some known points role = "check"',
    )
