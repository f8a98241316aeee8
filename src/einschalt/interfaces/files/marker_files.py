"""Control points and where images show them, as photogrammetric programs write both.

Metashape (markers as XML), OpenDroneMap (``gcp_list.txt``) and OpenSfM
(``ground_control_points.json``). Pixels are counted from the upper left corner of the
image, x to the right and y down, as these programs do.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import (
    FileError,
    ProjectionError,
    TableError,
    name_some,
    raise_problems,
)
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.projections import code_of, read_source_crs
from einschalt.foundations.tables import listed
from einschalt.interfaces.files.atomic import write_text
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.input_files import (
    companions,
    read_text_bytes,
)
from einschalt.interfaces.files.opensfm_images import (
    image_sizes,
    json_of,
    unsized,
)

WGS_84 = "EPSG:4326"
UTM = re.compile(r"^WGS\s?84\s+UTM\s+(\d{1,2})\s?([NS])$", re.IGNORECASE)
ODM_SYSTEM = re.compile(r"^(EPSG:\d+|\+proj=.*|WGS\s?84)$", re.IGNORECASE)
WITH_HEIGHTS = re.compile(r"^(EPSG:\d+)\+\d+$")  # the list has the plane alone
CHECK_MARK = "CHK-"  # how ODM's users mark check points
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


def is_odm(head):
    """Whether the first bytes are a system, then X Y Z px py and an image."""
    lines = head.decode("utf-8", "replace").lstrip("\ufeff").splitlines()
    said = [x.strip() for x in lines if x.strip() and not x.lstrip().startswith("#")]
    is_system = bool(said) and (UTM.match(said[0]) or ODM_SYSTEM.match(said[0]))
    return bool(is_system) and len(said) > 1 and _is_row(said[1].split())


def read_odm(path, source=None) -> Markers:
    """Read a ``gcp_list.txt``: the system, then X Y Z px py image [name]."""
    source = source or Path(path).name
    data = read_text_bytes(path, source)
    numbered = _numbered_lines(data, source)
    crs = _crs_of_line(numbered[0], source)
    is_bad = [k for k, (_, words) in enumerate(numbered) if k and not _is_row(words)]

    def problem(place):
        row, words = numbered[place]
        return TableError(
            f"{shortened(' '.join(words), 60)!r} is no measurement",
            expected="X Y Z px py image [name]",
            remedy="Correct the line, or delete it",
            file=source,
            row=row,
        )

    raise_problems(listed(is_bad, problem, "so are the lines"))
    names = _names_of(numbered[1:], source)
    points, rows, notes = {}, [], []
    for marked, (_, words) in zip(names, numbered[1:], strict=True):
        name = marked.removeprefix(CHECK_MARK)
        role = "check" if name != marked else "control"
        points.setdefault(marked, (name, *map(float, words[:3]), role))
        rows.append((words[5], name, float(words[3]), float(words[4])))
    n_check = sum(point[-1] == "check" for point in points.values())
    if not data.endswith((b"\n", b"\r")):
        notes.append(f"{source}: ends without a line break: is its last line whole?")
    if n_check:
        said = kept("{n:point|points}", n=n_check)
        notes.append(f"{source}: {said} marked {CHECK_MARK}, taken for check points")
    lines = [row for row, _ in numbered[1:]]
    return markers_of(list(points.values()), rows, crs, notes, source, lines)


def _numbered_lines(data, source):
    """Words of all lines that are no comments, with their numbers."""
    lines = data.decode("utf-8").splitlines()
    numbered = [
        (row, line.split())
        for row, line in enumerate(lines, 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not numbered:
        raise FileError(
            "holds no line but comments",
            expected="the system in the first line, then X Y Z px py image [name]",
            remedy="Export the list again",
            file=source,
        )
    return numbered


def _is_row(words):
    return len(words) >= 6 and all(map(is_number, words[:5]))


def _crs_of_line(first, source):
    row, words = first
    text = " ".join(words)
    utm = UTM.match(text)
    if utm:
        return f"EPSG:{(32600 if utm[2].upper() == 'N' else 32700) + int(utm[1])}"
    try:
        return WGS_84 if text.upper() in {"WGS84", "WGS 84"} else code_of(text)
    except ProjectionError as error:
        raise FileError(
            f"{shortened(text, 60)!r} is no reference system",
            expected="EPSG:…, WGS84, WGS84 UTM 33N or a PROJ string in the first line",
            remedy="Write the system of the points into the first line",
            file=source,
            row=row,
        ) from error


def _names_of(numbered, source):
    """Name of the point of each row; numbers where the list has none."""
    places, first_at, names = {}, {}, []
    for row, words in numbered:
        place = tuple(words[:3])
        name = words[6] if len(words) > 6 else None
        name = name or first_at.get(place) or str(len(places) + 1)
        first_at.setdefault(place, name)
        if places.setdefault(name, place) != place:
            raise TableError(
                f"point {name} has other coordinates than in an earlier line",
                expected="one place for each name",
                remedy="Correct the name or the coordinates",
                file=source,
                row=row,
            )
        names.append(name)
    return names


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


def _require_unmarked(names, path):
    """Refuse control points that would be read as check points."""
    marked = names[names.str.startswith(CHECK_MARK)].unique()
    if len(marked):
        raise FileError(
            f"control points with the mark of check points: {name_some(marked, 8)}",
            expected=f"names that do not begin with {CHECK_MARK}",
            remedy="Rename them, or convert into a folder",
            file=path,
        )


def write_odm(path, markers):
    """Write a ``gcp_list.txt``; points without coordinates have no row in it.

    Check points are marked as ODM's users do. A FileError where a name has blanks,
    which separate the columns, where the system is unknown, or a height.
    """
    if markers.crs is None:
        raise FileError(
            "the system of the points is unknown, and the list begins with it",
            expected="the reference system of their coordinates",
            remedy="Say it by --crs, or convert into a folder",
            file=path,
        )
    table = markers.measurements.merge(
        markers.points, on="point_id", suffixes=("_image", "")
    )
    flat = table.loc[table["z"].isna(), "point_id"].unique()
    if len(flat):
        points = kept("{n:point|points}", n=len(flat))
        raise FileError(
            f"{points} without height: {name_some(flat, 8)}",
            expected="X Y Z of every point",
            remedy="Add the heights, or convert into a folder",
            file=path,
        )
    is_check = table["role"] == "check"
    _require_unmarked(table.loc[~is_check, "point_id"], path)
    table["point_id"] = table["point_id"].where(
        ~is_check, CHECK_MARK + table["point_id"]
    )
    names = table[["image_id", "point_id"]]
    odd = names[names.apply(lambda column: column.str.contains(r"\s")).any(axis=1)]
    if len(odd):
        raise FileError(
            f"the names {' and '.join(map(repr, odd.iloc[0]))} have blanks",
            expected="names without blanks, which separate the columns of the list",
            remedy="Rename them, or convert into a folder",
            file=path,
        )
    numbers = table[["x", "y", "z", "x_image", "y_image"]].map("{:.12g}".format)
    rows = pd.concat([numbers, names], axis=1).agg(" ".join, axis=1)
    system = WITH_HEIGHTS.sub(r"\1", markers.crs)
    write_text(path, "\n".join([system, *rows]) + "\n")
