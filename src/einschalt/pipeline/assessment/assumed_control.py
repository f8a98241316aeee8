"""Both ways of densification by the same evidence, where errors are not stated.

Control without standard errors is held as it is given: no figure of an adjustment is
known then, and the budget of the two steps lacks the same errors. What is not known of
one way says nothing for the other. Points that took no part tell them apart: check
points, and control points that all others predict, for which control must have errors.
"""

from dataclasses import replace

import numpy as np
import pandas as pd

from einschalt.foundations.errors import GeometryError, TableError
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.examination import examine
from einschalt.pipeline.densification.one_adjustment import adjust_beside
from einschalt.stages.error_propagation.given_points import PLAN

STATED = "standard_error_m"
# of the differences of the two steps at control, which are theirs for the most part: an
# adjustment holds control with errors as small as that nearly as it does without any
OF_DIFFERENCES = 1.0 / 3.0


def with_assumed_errors(two_step, adjusted) -> tuple:
    """Both examinations, of control with errors that follow from its differences.

    As they are where control has stated errors or nothing is predicted by the other
    points, and of large blocks. How large the errors are hardly matters for what all
    other points predict: see docs/theory/claim.md.
    """
    block = adjusted.block
    as_it_is = two_step, adjusted
    if STATED in block.control_points or block.high_flight is None:
        return as_it_is
    size = OF_DIFFERENCES * two_step.known_control.rms
    if not (two_step.is_small and size > 0.0):
        return as_it_is
    control = block.control_points.assign(**{STATED: size})
    block = replace(block, control_points=control)
    try:
        again = two_step.computed_again(block)
        what = again.solution, block, adjusted.settings, again.solution.flights
        return again, examine(adjust_beside(*what), again)
    except (GeometryError, TableError):  # what control without errors does not need
        return as_it_is


def differences_without_part(examined) -> pd.DataFrame:
    """Known points that took no part: predicted less given, (easting, northing).

    DataFrame by point_id, of control points that were left out, and of check points
    but for those that are far off as no other one is. Check points that share errors
    with control are missed less where it is followed, and tell nothing.
    """
    left_out = examined.left_out_differences
    if examined.shares_control_errors:
        return left_out
    points = examined.points
    lone = [each.point_id for each in examined.lone_points]
    is_check = (points["role"] == "check").to_numpy(dtype=bool)
    check = points[is_check & ~is_among(points["point_id"], lone)]
    columns = [f"difference_{axis}" for axis in PLAN]
    if check.empty:  # such columns need not be there
        return left_out
    check = check.set_index("point_id")[columns].set_axis(PLAN, axis=1)
    parts = [part.astype(np.float64) for part in (left_out, check) if len(part)]
    return pd.concat(parts)
