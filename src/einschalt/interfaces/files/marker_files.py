"""Control points and where images show them, as photogrammetric programs write both.

Metashape (markers as XML), OpenDroneMap (``gcp_list.txt``, see :mod:`.odm_lists`) and
OpenSfM (``ground_control_points.json``). Pixels are counted from the upper left corner
of the image, x to the right and y down, as these programs do.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import (
    FileError,
    TableError,
)
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.projections import read_source_crs
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.input_files import (
    companions,
)
from einschalt.interfaces.files.opensfm_images import (
    image_sizes,
    json_of,
    unsized,
)

WGS_84 = "EPSG:4326"
CONTROL = ["point_id", "x", "y", "z", "role"]
MEASURED = ["image_id", "point_id", "x", "y"]


@dataclass(frozen=True, eq=False)
class Markers:
    """Points with their coordinates, and where they were measured in images."""

    # point_id, x, y (x the east or longitude), z, role [, standard errors]
    points: pd.DataFrame
    measurements: pd.DataFrame  # image_id, point_id, x, y [pixels]
    crs: str | None
    notes: tuple[str, ...] = ()

    def control_points(self):
        """Points as a table of control: columns as their system calls them."""
        is_geographic = self.crs and read_source_crs(self.crs).is_geographic
        names = ("longitude", "latitude") if is_geographic else ("easting", "northing")
        names = dict(zip("xyz", (*names, "height"), strict=True))
        table = self.points.rename(columns=names)
        return table.drop(columns="height") if table["height"].isna().all() else table

    def tables(self):
        """Tables of a block by name."""
        points = self.control_points()
        return {"control_points": points, "image_points": self.measurements}


def read_opensfm(path, source=None, beside=()) -> Markers:
    """Read ``ground_control_points.json``, with the sizes of reconstruction*.json.

    ``beside``: those files, where they were read before.

    OpenSfM counts from the middle of an image in units of its longer side; pixels need
    that side, which the reconstruction beside it has.
    """
    source = source or Path(path).name
    given = json_of(path, source)
    sizes = image_sizes(beside or companions(path))
    points, rows = [], []
    try:
        for one in given["points"]:
            name, position = str(one["id"]), one.get("position")
            if position is not None:
                place = (position["longitude"], position["latitude"])
                points.append((name, *place, position.get("altitude"), "control"))
            for seen in one.get("observations", ()):
                image, (x, y) = str(seen["shot_id"]), seen["projection"]
                wide, high = sizes.get(image, (1.0, 1.0))  # left out below
                side = max(wide, high)
                pixels = x * side + (wide - 1) / 2, y * side + (high - 1) / 2
                rows.append((image, name, *pixels))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise damaged(source, "holds no points as OpenSfM writes them") from error
    unknown, notes = unsized([row[0] for row in rows], sizes, source)
    rows = [row for row in rows if row[0] not in unknown]
    return markers_of(points, rows, WGS_84, notes, source)


def markers_of(points, rows, crs, notes, source, lines=None) -> Markers:
    """Markers of rows as their columns are; a FileError where one lacks something.

    ``lines``: of the file, one of each measurement, where there are such.
    """
    if not rows:
        raise FileError(
            "holds no measurement in an image",
            expected="control points that were measured",
            remedy="Export the markers with their projections",
            file=source,
        )
    control = pd.DataFrame(points, columns=CONTROL)
    measured = pd.DataFrame(rows, columns=MEASURED)
    try:
        control = control.astype(dict.fromkeys("xyz", float))
        measured = measured.astype({"x": float, "y": float})
    except (ValueError, TypeError) as error:
        raise damaged(source, f"a coordinate is no number: {error}") from error
    for table, names in ((control, ["point_id"]), (measured, MEASURED[:2])):
        is_whole = np.isfinite(table[["x", "y"]]).all(axis=1)
        is_whole &= table[names].notna().all(axis=1)
        if not is_whole.all():
            values = [table[~is_whole].iloc[0][name] for name in (*names, "x", "y")]
            said = " ".join("?" if pd.isna(value) else str(value) for value in values)
            raise damaged(source, f"{shortened(said, 60)!r} lacks a name or a number")
    measured, repeated = _measured_once(measured, source, lines)
    return Markers(control, measured, crs, (*notes, *repeated))


def _measured_once(measured, source, lines):
    """The measurements without those that repeat another, and notes."""
    once = measured.drop_duplicates()
    again = once[once.duplicated(MEASURED[:2])]
    if len(again):
        image, point = again.iloc[0][MEASURED[:2]]
        raise TableError(
            f"point {shortened(point)} is measured in image {shortened(image)} twice, "
            "at different places",
            expected="each point once in an image",
            remedy="Delete the measurement that is wrong",
            file=source,
            row=None if lines is None else lines[again.index[0]],
        )
    n_repeated = len(measured) - len(once)
    once = once.reset_index(drop=True)
    if not n_repeated:
        return once, ()
    said = kept("{n:repeated measurement|repeated measurements}", n=n_repeated)
    return once, (f"{source}: {said} left out",)
