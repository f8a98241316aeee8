"""JobXML of Trimble (.jxl): the reduced points of a job, after its schema.

Its lengths are metres, whatever the job shows. Points of the field book are measured
ones, of which the reductions have the coordinates. Their system is stated where the job
names one that is known.
"""

import numpy as np

from einschalt.foundations.errors import FileError
from einschalt.foundations.kept_texts import kept
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.plain_xml import child, each, read_xml, text_of
from einschalt.interfaces.programs.foreign import (
    METRES,
    Foreign,
    is_finite,
    points_on_ground,
)
from einschalt.interfaces.programs.jobxml_systems import system_of

EXPECTED = "a job as Trimble's programs export it: Reductions with points"
AXES = ("East", "North", "Elevation")


def read_jobxml(file) -> Foreign:
    """Read the points that have coordinates of the grid."""
    root = read_xml(file.data, file.source, EXPECTED)
    points = [one for part in each(root, "Reductions") for one in each(part, "Point")]
    names, places, n_others = [], [], 0
    for point in points:
        name, place = _point(point, file.source)
        if np.isnan(place[:2]).any():
            n_others += 1
        else:
            names.append(name)
            places.append(place)
    if not names:
        raise FileError(
            "holds no point with coordinates of a grid",
            expected=EXPECTED,
            remedy="Choose a coordinate system in the job, and export it again",
            file=file.source,
        )
    table = points_on_ground(names, places)
    crs, notes = system_of(root, file.source)
    if n_others:
        left_out = kept("{n:point|points} without grid left out", n=n_others)
        notes.append(f"{file.source}: {left_out}")
    tables = {"control_points": table.dropna(axis=1, how="all")}
    return Foreign(tables, crs, tuple(notes), unit=METRES, unit_m=1.0)


def _point(point, source):
    """Name and coordinates of a point; NaN where it has none."""
    name, grid = text_of(point, "Name"), child(point, "Grid")
    if not name:
        raise damaged(source, "a point of the reductions has no name", EXPECTED)
    words = ["" if grid is None else text_of(grid, axis) for axis in AXES]
    said = [word for word in words if word and word.casefold() != "nan"]
    wrong = [word for word in said if not is_finite(word)]
    if wrong:
        raise damaged(source, f"{wrong[0]!r} of point {name} is no number", EXPECTED)
    place = [float(word) if is_finite(word) else np.nan for word in words]
    return name, np.array(place)
