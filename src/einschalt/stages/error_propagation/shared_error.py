"""What all ground coordinates share: the error of the operation into their system.

Control that came through one operation between reference systems is displaced as a
whole by what this is wrong by, and every point that hangs on it goes with it, exactly:
each transformation of a model carries a common shift over. So it stands beside the
other sources with weight one in every point. Nothing within the block can see it, check
points least of all, since they came the same way.
"""

from dataclasses import replace

import numpy as np

from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.point_operator import Axes, selection

REFERENCE = "reference_system"
CONTROL, APPROXIMATE = "control_points", "approximate_points"


def shared_error_of(block, method="two_step"):
    """TOTAL error that the points of a block share [m]; 0 where there is none.

    The simultaneous ``method`` hangs on control alone, the two steps without a high
    flight on the approximate points.
    """
    hangs_on_control = block.high_flight is not None or method == "simultaneous"
    return block.shared_errors_m.get(CONTROL if hangs_on_control else APPROXIMATE, 0.0)


def with_shared_error(errors, shared_m):
    """Propagated errors with the one that all points share among their sources.

    ``errors`` may be None, and so is what is returned then. Heights share nothing.
    """
    if errors is None or shared_m == 0.0:
        return errors
    shift = selection(np.zeros(len(errors.point_ids), dtype=np.intp), 1, errors.axes)
    size = np.array([shared_m / SQRT2])
    if errors.axes is Axes.SPACE:
        size = size[:, None] * [1.0, 1.0, 0.0]
    return replace(
        errors,
        parts={**errors.parts, REFERENCE: shift.covariances(size)},
        chains={**errors.chains, REFERENCE: shift},
        standard_errors={**errors.standard_errors, REFERENCE: size},
    )


def with_shared_columns(points, shared_m):
    """Add the shared error, TOTAL [m], to the columns of standard errors of points."""
    each = shared_m / SQRT2
    sizes = {
        "standard_error_easting": each,
        "standard_error_northing": each,
        "standard_error_total": shared_m,
    }
    known = {name: size for name, size in sizes.items() if name in points and size}
    return points.assign(
        **{name: np.hypot(points[name], size) for name, size in known.items()}
    )
