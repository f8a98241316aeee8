"""What to say of a block whose claimed figure does not stand."""

from einschalt.foundations.typesetting import fixed, length
from einschalt.pipeline.claim_tests import NEIGHBOURS, RESIDUALS
from einschalt.pipeline.suggestion import Suggestion

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
    if claim.stands:
        return None
    return Suggestion(
        f"The claimed figure does not stand: {'; '.join(map(_said, claim.refused))}",
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
