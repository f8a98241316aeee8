"""Control that is worse than it was given, by the corrections of one adjustment.

They tell it where nothing else does: patterns are not looked for in spatial models
whose orientations bend them, and s_0 is made by the models, of which there are many
more observations.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.pipeline.assessment.evidence.control.displacements import (
    LEAST_ENLARGEMENT,
)
from einschalt.pipeline.assessment.evidence.control.signatures import HEIGHT, PLAN
from einschalt.theory.adjustment.global_tests import ratio_limits, ratio_p_value
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE


@dataclass(frozen=True)
class LargerControlErrors:
    """How much larger the errors of control are than they were given."""

    factor: float
    p_value: float  # of a factor as large as this where they are as given


def larger_control_errors(examined) -> LargerControlErrors | None:
    """Compare the errors that control shows in an adjustment with those given.

    By the tests of its points, whose mean square is 1 for each axis, orientations
    counted. None where chance explains the rest, and where nothing tells: errors that
    control shares leave less in corrections, and a point that contradicts the block is
    worse by itself. Beside what was set aside, which leaves smaller ones to the rest.
    """
    control = examined.adjustment.control
    is_held = ~control["is_set_aside"].to_numpy(dtype=bool)
    control = control[is_held & np.isfinite(control["w"])]
    is_single = bool(control["is_suspect"].any())
    if control.empty or is_single or examined.shares_control_errors:
        return None
    n_axes = np.full(len(control), len(PLAN))
    if "strain_height" in control:
        has_height = control["strain_height"].notna().to_numpy(dtype=bool)
        n_axes += len(HEIGHT) * has_height
    factor = float(np.sqrt(np.sum(control["w"] ** 2) / np.sum(n_axes)))
    # corrections depend on each other: by no more than their redundancy tells
    degrees = float((n_axes * control["redundancy_number"]).sum())
    if not factor > ratio_limits(degrees, FINDING_SIGNIFICANCE, LEAST_ENLARGEMENT)[1]:
        return None
    return LargerControlErrors(factor, float(ratio_p_value(factor, degrees)))
