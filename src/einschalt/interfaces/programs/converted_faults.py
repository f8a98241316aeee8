"""What is wrong in tables that come of other programs, before a block has them.

That check would refuse them later is told where they are made.
"""

import numpy as np
import pandas as pd

from einschalt.foundations.errors import TableError
from einschalt.foundations.projections import WGS_84, read_source_crs
from einschalt.foundations.tables import (
    CONTROL_POINTS,
    IMAGE_POINTS,
    LINE,
    check_table,
    listed,
    row_location,
)
from einschalt.interfaces.files.points_of_systems import GEOGRAPHIC, schema_in
from einschalt.pipeline.block.given_points import heights_that_are_none

PLACES = ("point_id", "easting", "northing", *GEOGRAPHIC, "height")
# what is looked at: errors that some points lack are left out where they are read
CHECKED = {
    "control_points": (CONTROL_POINTS, PLACES),
    "image_points": (IMAGE_POINTS, ("image_id", "point_id", "x", "y")),
}
LIMITS = {"longitude": 2.0 * np.pi, "latitude": 0.5 * np.pi}
FIRST_LINE = 2  # of a table with a header


def faults_of(name, frame, source, crs=None):
    """Faults of names, places and heights in a table as it is written to a CSV."""
    if name not in CHECKED or not len(frame):
        return []
    schema, columns = CHECKED[name]
    lines = pd.RangeIndex(FIRST_LINE, FIRST_LINE + len(frame), name=LINE)
    frame = frame[[column for column in columns if column in frame]].set_axis(lines)
    system = _geographic(frame, crs)
    schema = schema if system is None else schema_in(schema, system)
    checked = check_table(frame, schema, source=source)
    if name != "control_points" or checked.problems:
        return list(checked.problems)
    return faults_of_places(checked.frame, source, crs)


def faults_of_places(frame, source, crs=None):
    """Faults of the places of ground points: angles beyond a circle, heights of none.

    ``frame``: as checked.
    """
    system = _geographic(frame, crs)
    faults = []
    for name in GEOGRAPHIC if system is not None else ():
        axis = system.axis_info[0]
        largest = round(LIMITS[name] / axis.unit_conversion_factor, 6)
        values = frame[name].to_numpy(dtype=float)

        def problem(place, name=name, values=values, largest=largest):
            return TableError(
                f"{name} = {values[place]:g}",
                expected=f"{-largest:g} to {largest:g}",
                remedy="Correct it, or the order of the coordinates",
                file=source,
                **row_location(frame, place),
            )

        beyond = np.flatnonzero(np.abs(values) > largest)
        faults += listed(beyond, problem, "so it is")
    return faults + heights_that_are_none(frame, source)[0]


def _geographic(frame, crs):
    """System of the longitudes of a table; None where it has none."""
    if not set(GEOGRAPHIC) <= set(frame):
        return None
    system = read_source_crs(crs or WGS_84)
    return system if system.is_geographic else read_source_crs(WGS_84)
