"""What was read from a file of another program: plain tables, a system, notes."""

import csv
import math
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import (
    ProjectionError,
    TableError,
    name_some,
    raise_problems,
)
from einschalt.foundations.names import free_numbers
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.projections import METRE, read_source_crs
from einschalt.foundations.tables import listed
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.text_encodings import read_table_text

PLACE = ("easting", "northing", "height")
METRES = "metres"
# cameras of photogrammetry look along -z with y up, those of other programs along z
TURNED = np.diag([1.0, -1.0, -1.0])
# coordinates whose full covariance is read or written: 18 million numbers
MOST_FULL = 6000


@dataclass(frozen=True, eq=False)
class Foreign:
    """Tables that another program has written, with the columns of the project.

    ``tables`` by name: ``control_points``, ``image_points``, ``image_pairs``,
    ``orientations``, ``cameras`` …; each becomes a file of its own. ``cameras``: keys
    of a camera.toml by the name of the camera. ``unusable``: why there are no such keys
    of another, by its name. ``unit``: of the ground coordinates, as the file states it,
    and its length ``unit_m``; :func:`in_unit_of_system` brings them into that of their
    system.
    """

    tables: dict = field(default_factory=dict)
    crs: str | None = None
    notes: tuple[str, ...] = ()
    cameras: dict = field(default_factory=dict)
    unusable: dict = field(default_factory=dict)
    unit: str = ""
    unit_m: float | None = None


def in_unit_of_system(foreign, source, crs=None) -> Foreign:
    """The tables with ground coordinates in the unit of their system, and a note.

    Of the file's own system, or else ``crs``; metres where there is none, and for
    heights that have none.
    """
    control = foreign.tables.get("control_points")
    if foreign.unit_m is None or control is None:
        return foreign
    columns, notes = {}, {}
    for name, (unit, metres) in zip(PLACE, _units(foreign.crs or crs), strict=True):
        # what is in the unit already keeps its digits
        if name in control and not math.isclose(metres, foreign.unit_m, rel_tol=1e-9):
            columns[name] = control[name] * (foreign.unit_m / metres)
            notes.setdefault(unit, []).append(name)
    notes = [
        f"{source}: {name_some(names)} converted from {foreign.unit} to {unit}"
        for unit, names in notes.items()
    ]
    tables = {**foreign.tables, "control_points": control.assign(**columns)}
    notes = (*foreign.notes, *notes)
    return replace(foreign, tables=tables, notes=notes, unit="", unit_m=None)


def _units(crs):
    """Name and length [m] of the units of easting, northing and height in a system."""
    usual = [(METRES, 1.0)] * 3
    try:
        system = None if crs is None else read_source_crs(crs)
    except ProjectionError:  # said where it is used
        return usual
    if system is None or system.is_geographic:
        return usual
    own = [
        (
            METRES if axis.unit_name == METRE else axis.unit_name,
            axis.unit_conversion_factor,
        )
        for axis in system.axis_info
    ]
    return own + usual[len(own) :]


@dataclass(frozen=True)
class Line:
    """A line of a text file that is neither empty nor a comment."""

    row: int
    words: list
    text: str


def unseen(source):
    """Note on a file whose format comes from the manual alone."""
    return f"{source}: read after the manual; no file of the program itself was seen"


def lines_of(file, *, comments=("#",), edges=None):
    """Lines of a text file with their numbers, parted into words.

    ``edges``: characters that are taken off a line's ends; all blanks, where none are
    said. Tabs between columns are none.
    """
    text = read_table_text(file, file.source)[0].decode("utf-8")
    lines = []
    for row, raw in enumerate(text.splitlines(), 1):
        line = raw.strip(edges)
        if line.strip() and not line.startswith(comments):
            lines.append(Line(row, line.split(), line))
    return lines


def numbers_of(lines, source, start, stop, expected):
    """Words ``start`` to ``stop`` of every line as numbers, (n_lines, n_numbers).

    Lines that have too few, or something else, are named all at once.
    """
    is_bad = [
        k
        for k, line in enumerate(lines)
        if len(line.words) < stop or not all(map(is_finite, line.words[start:stop]))
    ]

    def problem(place):
        line = lines[place]
        return TableError(
            f"{shortened(' '.join(line.words), 60)!r} cannot be read",
            expected=expected,
            remedy="Correct the line, or export the file again",
            file=source,
            row=line.row,
        )

    raise_problems(listed(is_bad, problem, "so are the lines"))
    values = [[float(word) for word in line.words[start:stop]] for line in lines]
    return np.array(values, dtype=float).reshape(len(lines), stop - start)


def cells_of(text, source, row, separator=","):
    """Cells of a line that commas or others part, with quotes around texts.

    >>> cells_of('"P, 1",2', "a.csv", 1)
    ['P, 1', '2']
    """
    try:
        return next(csv.reader([text], delimiter=separator))
    except csv.Error as error:
        raise damaged(source, f"cannot be parted: {error}", "cells", row) from error


def is_finite(word):
    """Whether a word is a number, and neither NaN nor infinite.

    >>> is_finite("1e3"), is_finite("nan"), is_finite("1e999")
    (True, False, False)
    """
    return is_number(word) and math.isfinite(float(word))


def numbered(names):
    """Names of points, where those that have none are numbered by free numbers.

    >>> numbered(["2", None, "a", None])
    ['2', '1', 'a', '3']
    """
    free = free_numbers(set(names))
    return [name or next(free) for name in names]


def require_rows(lines, source, expected):
    """Refuse a file without a line that says anything."""
    if not lines:
        raise damaged(source, "holds nothing but comments", expected)


def points_on_ground(names, places):
    """Table of points; ``places`` (n, 3) easting, northing, height."""
    table = pd.DataFrame({"point_id": names})
    table[["easting", "northing", "height"]] = np.asarray(places)
    return table


def points_in_images(images, names, xy):
    """Table of measured points; ``xy`` (n, 2) in the unit of the file."""
    table = pd.DataFrame({"image_id": images, "point_id": names})
    return table.assign(x=xy[:, 0], y=xy[:, 1])


def photo_points(rows, source, expected, factor=1.0):
    """Table of measured points of pairs: photo, and line of point x y."""
    lines = [line for _, line in rows]
    xy = factor * numbers_of(lines, source, 1, 3, expected)
    photos, names = [photo for photo, _ in rows], [line.words[0] for line in lines]
    return points_in_images(photos, names, xy)


def orientations(names, centres, angles, **more):
    """Table of exterior orientations.

    ``centres`` (n, 3) on the ground; ``angles`` omega, phi, kappa (n, 3) of the
    rotation that turns a vector of the camera into the frame of the ground
    (docs/conventions.md) [rad].
    """
    table = pd.DataFrame({"image_id": [str(name) for name in names]})
    centres = np.asarray(centres, dtype=float).reshape(-1, 3)
    table[["easting", "northing", "height"]] = centres
    table[["omega", "phi", "kappa"]] = np.asarray(angles, dtype=float).reshape(-1, 3)
    return table.assign(**more)
