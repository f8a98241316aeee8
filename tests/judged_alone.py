"""Findings of a result as its judges tell them: which there are, and not in whose wake.

An assessment computes a small block again without what is wrong in it, to put what is
gone then under that, which takes as long as all else. It leaves out none of these
findings, which a test of the assessment shows; it adds exchanged names and gross
measurements that take part.
"""

from einschalt.pipeline.assessment.examination import TwoStepExamination
from einschalt.pipeline.assessment.findings.catalogue import (
    SIMULTANEOUS,
    TWO_STEP,
    findings_of,
)


def judged_alone(result):
    """The findings of a result by their codes.

    Parameters
    ----------
    result : DensificationResult
    """
    examined = result.examination
    is_in_two_steps = isinstance(examined, TwoStepExamination)
    found = findings_of(examined, TWO_STEP if is_in_two_steps else SIMULTANEOUS)
    return {each.code: each for each in found}
