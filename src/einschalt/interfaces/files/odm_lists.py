"""Control points and their marks in images as OpenDroneMap lists them: gcp_list.txt.

The system, then ``X Y Z px py image [name]``, parted by blanks or tabs. Pixels are
counted from the upper left corner of the image, x to the right and y down.
"""

import re
from dataclasses import replace
from pathlib import Path

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
from einschalt.foundations.names import free_numbers
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.projections import code_of
from einschalt.foundations.tables import listed
from einschalt.interfaces.files.atomic import write_text
from einschalt.interfaces.files.input_files import read_text_bytes
from einschalt.interfaces.files.marker_files import WGS_84, Markers, markers_of
from einschalt.interfaces.files.places_of_images import IMAGE_SUFFIXES

UTM = re.compile(r"^WGS\s?84\s+UTM\s+(\d{1,2})\s?([NS])$", re.IGNORECASE)
ODM_SYSTEM = re.compile(r"^(EPSG:\d+|\+proj=.*|WGS\s?84)$", re.IGNORECASE)
WITH_HEIGHTS = re.compile(r"^(EPSG:\d+)\+\d+$")  # the list has the plane alone
CHECK_MARK = "CHK-"  # how ODM's users mark check points
N_COLUMNS = 7


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
    numbered, has_more = _numbered_lines(data, source)
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
    if has_more:
        notes.append(f"{source}: columns behind the name of the point are left out")
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
    """Words of all lines that are no comments, with their numbers.

    And whether tabs part more columns than are read.
    """
    lines = data.decode("utf-8").splitlines()
    numbered = [
        (row, _words(line))
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
    torn = [k for k, (_, (words, is_sure)) in enumerate(numbered) if k and not is_sure]

    def problem(place):
        row, (words, _) = numbered[place]
        return TableError(
            f"{shortened(' '.join(words), 60)!r} may have a name with blanks, which "
            "separate its columns, or further columns",
            expected="X Y Z px py image [name]",
            remedy="Part the columns by tabs, or rename the image or the point",
            file=source,
            row=row,
        )

    raise_problems(listed(torn, problem, "so are the lines"))
    has_more = any(len(words) > N_COLUMNS for _, (words, _) in numbered[1:])
    return [(row, words) for row, (words, _) in numbered], has_more


def _words(line):
    """Cells of a line, and whether it is sure where they end.

    Tabs part them where they part enough; then names may have blanks.
    """
    cells = [cell.strip() for cell in line.strip(" \r\n").split("\t")]
    if _begins_as_row(cells):
        return cells, True
    words = line.split()
    if not _is_row(words):
        return words, True  # the system, or what is refused as it stands
    *_, image, last = words
    is_torn = len(words) == N_COLUMNS and _is_image(last) and not _is_image(image)
    return words, len(words) <= N_COLUMNS and not is_torn


def _is_image(name):
    return name.casefold().endswith(IMAGE_SUFFIXES)


def _is_row(words):
    return _begins_as_row(words) and bool(words[5])


def _begins_as_row(words):
    return len(words) >= N_COLUMNS - 1 and all(map(is_number, words[:5]))


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
    """Name of the point of each row; free numbers where the list has none."""
    places, first_at, names = {}, {}, []
    stated = {words[6] for _, words in numbered if len(words) > 6}
    numbers = free_numbers(stated)
    for row, words in numbered:
        place = tuple(words[:3])
        name = words[6] if len(words) > 6 else None
        name = name or first_at.get(place) or next(numbers)
        first_at.setdefault(place, name)
        if places.setdefault(name, place) != place:
            raise TableError(
                f"point {name} has other coordinates than in an earlier line",
                expected="one place for each name",
                remedy="Correct the name or the coordinates",
                file=source,
                row=row,
            )
        plain = name.removeprefix(CHECK_MARK)
        if {plain, CHECK_MARK + plain} <= set(places):
            raise TableError(
                f"point {plain} is marked {CHECK_MARK} in some lines, in others not",
                expected="the mark in all lines of a point, or in none",
                remedy="Mark it in all, or rename one of two points",
                file=source,
                row=row,
            )
        names.append(name)
    return names


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


def as_listed(markers, source) -> Markers:
    """The markers that have a row in a list, and notes on those that have none.

    A row needs coordinates of the point and a place in an image.
    """
    points, measured = markers.points, markers.measurements
    is_seen = points["point_id"].isin(measured["point_id"])
    is_known = measured["point_id"].isin(points["point_id"])
    unseen = points.loc[~is_seen, "point_id"]
    unknown = measured.loc[~is_known, "point_id"].unique()
    notes = []
    if len(unseen):
        said = kept("{n:point|points}", n=len(unseen))
        notes.append(
            f"{source}: {said} measured in no image, left out: {name_some(unseen, 8)}"
        )
    if len(unknown):
        said = kept("{n:point|points}", n=len(unknown))
        notes.append(
            f"{source}: {said} without coordinates, left out: {name_some(unknown, 8)}"
        )
    return replace(
        markers,
        points=points[is_seen].reset_index(drop=True),
        measurements=measured[is_known].reset_index(drop=True),
        notes=(*markers.notes, *notes),
    )


def _table(path, markers):
    """Rows of a list: measurements with the coordinates of their points."""
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
    if table.empty:
        raise FileError(
            "no point has coordinates and was measured in an image as well",
            expected="points with both, which the list consists of",
            remedy="Name a folder instead",
            file=path,
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
    return table


def write_odm(path, markers):
    """Write a ``gcp_list.txt``; points without coordinates have no row in it.

    Check points are marked as ODM's users do. A FileError where a name has blanks,
    which separate the columns, where the system is unknown, or a height.
    """
    table = _table(path, markers)
    is_check = table["role"] == "check"
    _require_unmarked(table.loc[~is_check, "point_id"], path)
    table["point_id"] = table["point_id"].where(
        ~is_check, CHECK_MARK + table["point_id"]
    )
    names = table[["image_id", "point_id"]]
    every = pd.concat([names[name] for name in names]).drop_duplicates()
    odd = every[every.str.contains(r"\s")]
    if len(odd):
        raise FileError(
            f"names with blanks: {name_some(map(repr, odd), 8)}",
            expected="names without blanks, which separate the columns of the list",
            remedy="Rename them, or convert into a folder",
            file=path,
        )
    numbers = table[["x", "y", "z", "x_image", "y_image"]].map("{:.12g}".format)
    rows = pd.concat([numbers, names], axis=1).agg(" ".join, axis=1)
    system = WITH_HEIGHTS.sub(r"\1", markers.crs)
    write_text(path, "\n".join([system, *rows]) + "\n")
