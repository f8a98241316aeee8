"""References of markers as Metashape imports and exports them: CSV with accuracies."""

import re

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.projections import code_on_earth, read_source_crs
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.metashape_accuracies import (
    ERRORS,
    accuracy,
    in_plan,
    is_on,
    with_errors,
)
from einschalt.interfaces.files.places_of_images import IMAGE_SUFFIXES
from einschalt.interfaces.programs.foreign import (
    Foreign,
    cells_of,
    is_finite,
    lines_of,
)

HEAD = "#Label,X/Easting,Y/Northing,Z/Altitude,Accuracy_X/Y_(m),Accuracy_Z_(m),Enable"
SYSTEM = "# CoordinateSystem: "
# the sign between columns is chosen where the table is exported; X/ is of Metashape
HEADER = re.compile(r"^(?:#\s*Label([,;\t ])X|Label([,;\t ])X/)", re.MULTILINE)
ERROR_CELLS = ("error_x/y", "error_x", "error_y", "error_z")
EXPECTED = "#Label,X/Easting,Y/Northing,Z/Altitude, then a line for each point"


def write_reference(handed, path):
    """Write the points; check points are not enabled.

    The accuracy in plan is that of one coordinate, as Metashape takes it.
    """
    points = handed.points
    total = handed.errors_in_plan
    unknown = pd.Series(np.nan, points.index)
    plan = unknown if total is None else total / np.sqrt(2.0)
    upright = handed.errors_in_height
    upright = unknown if upright is None else upright
    columns = (
        *(points[name] for name in ("point_id", "easting", "northing")),
        *(handed.heights, plan, upright, points["role"]),
    )
    rows = []
    for name, *numbers, role in zip(*columns, strict=True):
        said = [f"{v:.5f}" if np.isfinite(v) else "" for v in numbers]
        rows.append(",".join([_quoted(name), *said, "0" if role == "check" else "1"]))
    system = [] if handed.crs is None else [f"{SYSTEM}{handed.crs}"]
    lines = "\n".join([*system, HEAD, *rows, ""])
    path.write_text(lines, encoding="utf-8", newline="\n")
    said = "accuracy in plan is that of one coordinate; check points are not enabled"
    return [said, *handed.told_enlargement]


def _quoted(name):
    """A name in quotes where it would not come back without: # begins a comment."""
    text = str(name)
    is_special = text.startswith("#") or any(sign in text for sign in ',"')
    return '"{}"'.format(text.replace('"', '""')) if is_special else text


def is_reference(head):
    """Whether the first bytes of a file look so."""
    return HEADER.search(head.decode("utf-8", "replace")) is not None


def read_reference(file) -> Foreign:
    """Read a reference table, its columns by their names."""
    crs, places, rows, images = None, None, [], []
    for line in lines_of(file, comments=("\0",), edges=" "):
        header = HEADER.match(line.text)
        if line.text.startswith(SYSTEM):
            crs = code_on_earth(line.text.removeprefix(SYSTEM))
        elif header:
            places = _places(line, header[1] or header[2], file.source)
        elif not line.text.startswith("#"):
            if places is None:
                raise damaged(file.source, "has no line #Label,…", EXPECTED, line.row)
            cells = _cells(line, places, file.source)
            name = cells["label"]
            # a camera without a place has no coordinates, and is no fault
            if name.casefold().endswith(IMAGE_SUFFIXES):
                images.append(name)
            else:
                rows.append(_row(cells, line, file.source))
    told = _told_images(images, rows, file.source)
    if not rows:
        raise damaged(file.source, "holds no points", EXPECTED)
    is_geographic = _are_degrees(rows, places) if crs is None else _is_geographic(crs)
    plane = ("longitude", "latitude") if is_geographic else ("easting", "northing")
    columns = ["point_id", *plane, "height", "role", *ERRORS]
    table, notes = with_errors(pd.DataFrame(rows, columns=columns), file.source)
    table = table.dropna(axis=1, how="all")
    return Foreign({"control_points": table}, crs, (*told, *notes))


def _is_geographic(crs):
    return read_source_crs(crs).is_geographic


def _are_degrees(rows, places):
    """Whether coordinates without a system are what the line of the names says."""
    if not places["is_longitude"]:
        return False
    xy = np.abs([row[1:3] for row in rows])
    return bool((xy[:, 0] <= 360.0).all() and (xy[:, 1] <= 90.0).all())


def _told_images(names, rows, source):
    """Note on the rows of cameras, which are no points; refused without others."""
    if not names:
        return ()
    if not rows:
        raise FileError(
            f"holds places of images, such as {shortened(names[0])!r}, and no points",
            expected="the reference of markers",
            remedy="Export the markers, not the cameras",
            file=source,
        )
    said = kept("{n:image|images}", n=len(names))
    return (f"{source}: places of {said} left out: they are no points",)


def _places(line, separator, source):
    """Where label, x, y, z and the switch stand; the next rows are parted by csv."""
    words = line.text.lstrip("#").strip().casefold().split(separator)
    words = [word.strip() for word in words]
    names = {"label": "label", "x": "x", "y": "y", "z": "z"}
    found = {"count": len(words), "separator": separator}
    # an axis stands alone, or with what it is: X/Easting; Yaw begins with y as well
    axes = [word.split("/")[0] for word in words]
    found |= {k: axes.index(w) if w in axes else None for k, w in names.items()}
    # programs write so above metres as well: only the values tell
    found["is_longitude"] = any(word.startswith("x/lon") for word in words)
    switches = (k for k, word in enumerate(words) if word.startswith("enable"))
    found["is_on"] = next(switches, None)
    for axis in ("x/y", "x", "y", "z"):
        name = f"accuracy_{axis}_(m)"
        found[f"error_{axis}"] = words.index(name) if name in words else None
    if None in (found["x"], found["y"]):
        raise damaged(
            source, f"{line.text[:60]!r} names no x and y", EXPECTED, line.row
        )
    return found


def _cells(line, places, source):
    """What stands in a row, by the names of :func:`_places`."""
    cells = cells_of(line.text, source, line.row, places["separator"])
    if len(cells) < places["count"]:
        said = f"{line.text[:60]!r} has {len(cells)} of {places['count']} columns"
        raise damaged(source, said, EXPECTED, line.row)

    def cell(name):
        place = places[name]
        is_there = place is not None and place < len(cells)
        return cells[place].strip() if is_there else ""

    return {name: cell(name) for name in ("label", *"xyz", "is_on", *ERROR_CELLS)}


def _row(cells, line, source):
    x, y, z = (cells[name] for name in "xyz")
    is_place = is_finite(x) and is_finite(y) and (not z or is_finite(z))
    if not (cells["label"] and is_place):
        raise damaged(source, f"{line.text[:60]!r} is no point", EXPECTED, line.row)
    height = float(z) if z else np.nan
    role = "control" if is_on(cells["is_on"]) else "check"
    *plan, upright = (accuracy(cells[name]) for name in ERROR_CELLS)
    return cells["label"], float(x), float(y), height, role, in_plan(*plan), upright
