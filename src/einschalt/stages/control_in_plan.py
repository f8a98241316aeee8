"""Control of spatial models that is known in plan alone, or in height alone.

Points without a height take part in plan where all models are adjusted together. No
spatial model is fitted onto them in two steps, which compare them as check points.
"""

import numpy as np

from einschalt.foundations.errors import name_some
from einschalt.foundations.names import is_among
from einschalt.stages.transformation_kinds import is_spatial

LACKING = ("easting is missing", "northing is missing")
ROUGH_PLAN = (
    "Give a value or delete the row. If only the height is known, method = "
    '"simultaneous" can use it: give rough coordinates with their standard_error_m (up '
    "to 10 m), and standard_error_height"
)


def known_in_plan_alone(control, flight):
    """Names of control without heights, if the models of a flight are spatial."""
    if not (is_spatial(flight) and {"height", "role"} <= set(control)):
        return np.empty(0, dtype=object)
    is_flat = (control["role"] != "check") & control["height"].isna()
    return control["point_id"].to_numpy(dtype=object)[is_flat.to_numpy(dtype=bool)]


def note_of_plan_alone(block, given, file):
    """Say what becomes of control without heights; a note, or none.

    ``given``: the control points of a block; other given points, without roles, get no
    note.
    """
    flight = block.high_flight
    if flight is None and _are_among(block.approximate_points, given):
        flight = block.low_flight  # which is fitted onto control
    names = known_in_plan_alone(given, flight)
    if not len(names):
        return []
    n_all = np.count_nonzero(given["role"] != "check")
    note = (
        f"{file}: {len(names)} of {n_all} control points have no height; they take "
        "part in plan where all models are adjusted together, but in two steps no "
        "spatial model is fitted onto them, and they are compared as check points: "
        f"{name_some(names)}"
    )
    return [note]


def _are_among(points, given):
    """Whether all points of a table, if there is one, are given in another as well."""
    if points is None:
        return True
    names = points["point_id"].astype(str) if "point_id" in points else ["?"]
    return bool(is_among(names, given["point_id"].astype(str)).all())


def with_rough_plan(block, problems):
    """Errors of a block, with another remedy where spatial control misses coordinates.

    The height of a point may be all that is known of it.
    """
    if not is_spatial(block.high_flight or block.low_flight):
        return problems
    file = block.sources.get("control_points", "control_points")
    return [
        each.with_facts(remedy=ROUGH_PLAN)
        if each.file == file and each.found.startswith(LACKING)
        else each
        for each in problems
    ]
