"""What is asked of a way between two reference systems, and whether heights go along.

The same for control that comes into the system of a block, and for results that leave
it.
"""

import numpy as np

from einschalt.foundations.language import mark
from einschalt.foundations.operation_choice import Demand

PLANE = ["easting", "northing"]
BY_AXIS = ["standard_error_easting", "standard_error_northing"]
HEIGHTS_STAY = mark("heights stay {0}")
SHARE_OF_ERROR = 0.25  # of the standard error: adds 3 per cent to it
ACCURACY_ASKED_M = 0.01  # of the operation, where points have no standard error


def demand_of(settings, standard_errors):
    """How accurate the operation must be, for points of a TOTAL standard error [m]."""
    how = {"operation": settings.crs_operation, "epoch": settings.crs_epoch}
    if settings.crs_accuracy_m is not None:
        said = settings.crs_accuracy_m, "as crs_accuracy_m says"
        return Demand(*said, is_stated=True, **how)
    if standard_errors is None:
        reason = "since the points have no standard error (crs_accuracy_m allows more)"
        return Demand(ACCURACY_ASKED_M, reason, **how)
    size = float(np.median(np.asarray(standard_errors, dtype=float)))
    reason = f"a quarter of the {size:g} m of the points (crs_accuracy_m allows more)"
    return Demand(SHARE_OF_ERROR * size, reason, **how)


def notes_of_unused(settings):
    """Notes on what is asked of ways between systems, where no points take one."""
    asked = ("crs_operation", "crs_epoch", "grids")
    given = {name: getattr(settings, name) for name in asked}
    return [
        f"{name} = {value} is not used: no points come from another reference system, "
        "and no output_crs is given"
        for name, value in given.items()
        if value not in ("", None)
    ]


def standard_errors_of(checked, default):
    """TOTAL standard errors of points, in whichever columns they stand [m].

    ``default`` where they stand in none.
    """
    if "standard_error_m" in checked:
        return checked["standard_error_m"]
    if set(BY_AXIS) <= set(checked):
        return np.hypot(*(checked[name] for name in BY_AXIS))
    return default


def with_one_error(frame, error, checked, source):
    """Points with the error that block.toml states for all; and notes.

    Without it, which a note says, where they have their own: one error of all beside
    those of each axis would count in one way of densification, and these in the other.
    """
    if standard_errors_of(checked, None) is None:
        return frame.assign(standard_error_m=error), []
    note = (
        f"{source} has standard errors of its own: standard_error_m = {error:g} of "
        "block.toml is not used"
    )
    return frame, [note]


def with_total_errors(control):
    """The table with TOTAL standard errors where it has those of the axes alone.

    Programs of adjustment state the latter, the two steps take the former.
    """
    total = standard_errors_of(control, None)
    if total is None or "standard_error_m" in control:
        return control
    return control.assign(standard_error_m=total)


def has_heights(crs):
    """Whether a system says what heights are."""
    return len(crs.axis_info) > len(PLANE)


def in_as_many_axes(own, target, points):
    """Both systems with heights or both without, and what is said of the heights.

    Where only the target has a system of heights, nobody knows what those of the
    ``points`` are in it: that is to be refused before.
    """
    flat = own.to_2d(), target.to_2d()
    if not gives_heights(points):
        return flat, ""
    if has_heights(own) and has_heights(target):
        return (own, target), ""
    kept = f"in {own.sub_crs_list[-1].name}" if own.is_compound else "as they are"
    return flat, f"; {HEIGHTS_STAY.format(kept)}"


def gives_heights(points):
    """Whether any of the points has a height."""
    return "height" in points and bool(points["height"].notna().any())
