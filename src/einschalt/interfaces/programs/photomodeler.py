"""Exports of PhotoModeler, as DBAT reads them: points, marks, and whole projects.

A project has the calibration of every photo: principal distance and point, format,
k1 to k3, p1, p2 in millimetres from the upper left corner, y down for the principal
point and up for the polynomial, which corrects. Numbers of the pixels of a photo are
only in projects that DBAT has extended by them. Of both signs of k1 and p1 these fit
the marks of its examples with the published orientations: to 0.3 pixels in a camera
calibration of 2016.
"""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np

from einschalt.foundations.errors import FileError
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.rotations import angles_from_rotation, rotation_from_angles
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.text_encodings import read_table_text
from einschalt.interfaces.programs.foreign import (
    Foreign,
    Line,
    cells_of,
    is_finite,
    lines_of,
    numbers_of,
    orientations,
    points_in_images,
    points_on_ground,
)

MARKS = "Object Point ID,Photo #"
POINTS = "Id,Name,"
UNIT = "X (project units)"
SOLUTION = b"Bundle Soln"
UNITS = re.compile(rb"Project Units: ([a-z]+)")
METRES = (b"meters", b"metres")
HEAD_BYTES = 4096
EXPECTED = "a table of points or of marks, or a project, as PhotoModeler exports it"
PHOTO = "number and file of a photo, X Y Z kappa phi omega, their standard errors"
POINT = "number, X Y Z and their standard errors"
MARK = "photo, point, x y and their standard errors"
CAMERA = "number of a photo, c, principal point, format, K1 K2 K3 P1 P2"
N_CAMERA = 11


def is_export(head):
    """Whether the first bytes of a file look so."""
    is_table = MARKS.encode() in head or POINTS.encode() in head
    is_table &= MARKS.encode() in head or UNIT.encode() in head
    return head.lstrip().startswith(SOLUTION) or is_table


def read_export(file) -> Foreign:
    """Read an export of whatever kind."""
    if file.data.lstrip().startswith(SOLUTION):
        return _project(file)
    head, rows = _table(file)
    if "Photo #" in head:
        return _marks(head, rows, file)
    found = _points(head, rows, file)
    unit = UNITS.search(file.data[:HEAD_BYTES])
    if unit is None or unit[1] in METRES:
        return found
    said = f"{file.source}: lengths in {unit[1].decode('ascii')}, as they stand"
    return replace(found, notes=(said,))


def _table(file):
    """Names of the columns, and lines with their cells."""
    text = read_table_text(file, file.source)[0].decode("utf-8")
    head, rows = None, []
    for row, line in enumerate(text.splitlines(), 1):
        if head is None:
            is_head = line.startswith((MARKS, POINTS))
            head = cells_of(line, file.source, row) if is_head else None
        elif line.startswith((MARKS, POINTS)):
            raise FileError(
                "the names of columns stand here once more: another table begins",
                expected="one table of points or of marks",
                remedy="Put the rows from here on into a file of their own",
                file=file.source,
                row=row,
            )
        elif line.strip():
            words = [word.strip() for word in cells_of(line, file.source, row)]
            rows.append(Line(row, words, line))
    if not head or not rows:
        raise damaged(file.source, "holds no rows", EXPECTED)
    for line in rows:
        if len(line.words) != len(head):
            found = f"has {len(line.words)} of {len(head)} columns"
            raise damaged(file.source, found, "a whole line", line.row)
    return head, rows


def _columns(head, rows, names, file):
    """Columns by the beginnings of their names, (n_rows, n_columns)."""
    places = []
    for name in names:
        found = [k for k, one in enumerate(head) if one.startswith(name)]
        if not found:
            raise damaged(file.source, f"has no column {name!r}", EXPECTED)
        places.append(found[0])
    chosen = [Line(r.row, [r.words[k] for k in places], r.text) for r in rows]
    return numbers_of(chosen, file.source, 0, len(places), ", ".join(names))


def _marks(head, rows, file):
    xy = _columns(head, rows, ("X (pixels)", "Y (pixels)"), file)
    photo = head.index("Photo #")
    images, names = ([r.words[place] for r in rows] for place in (photo, 0))
    return Foreign({"image_points": points_in_images(images, names, xy)})


def _points(head, rows, file):
    names = [f"{axis} (project units)" for axis in "XYZ"]
    places = _columns(head, rows, names, file)
    table = points_on_ground([r.words[0] for r in rows], places)
    errors = [f"standard_error_{axis}" for axis in ("easting", "northing", "height")]
    for name, axis in zip(errors, "XYZ", strict=True):
        if f"{axis} Precision" not in head:
            continue
        said = [r.words[head.index(f"{axis} Precision")] for r in rows]
        table[name] = [float(one) if is_finite(one) else np.nan for one in said]
    if "Type" in head:
        kinds = [r.words[head.index("Type")].casefold() for r in rows]
        table["role"] = ["control" if kind == "control" else "new" for kind in kinds]
    return Foreign({"control_points": table.dropna(axis=1, how="all")})


def _project(file):
    """Read a whole project: photos, points, marks, parted by empty lines."""
    text = read_table_text(file, file.source)[0].decode("utf-8")
    numbered = {line.row: line for line in lines_of(file, comments=("\0",))}
    blocks, block = [], []
    for row in range(1, len(text.splitlines()) + 2):
        if row in numbered:
            block.append(numbered[row])
        elif block:
            blocks.append(block)
            block = []
    names, photos = _photos(blocks, file)
    rest = [b for b in blocks[len(photos) :] if len(b[0].words) in (5, 6, 7)]
    points = [b for b in rest if len(b[0].words) == 7]
    marks = [b for b in rest if len(b[0].words) == 6]
    if not points or not marks:
        last = blocks[-1][-1].row if blocks else None
        raise damaged(file.source, "ends before its points and marks", EXPECTED, last)
    notes = _compared_with_end(blocks, marks[0], file)
    values = numbers_of(photos, file.source, 1, 7, PHOTO)
    # kappa first, then phi and omega [degrees]
    angles = np.radians(values[:, :2:-1])
    turned = angles_from_rotation(rotation_from_angles(*angles.T))
    tables = {"orientations": orientations(names, values[:, :3], turned)}
    found = _object_points(points[-1], file)
    # the points that were control stand before all points, and once more among them
    control = {line.words[0] for block in points[:-1] for line in block}
    is_control = found["point_id"].isin(control)
    found["role"] = np.where(is_control, "control", "new")
    tables["control_points"] = found
    tables["image_points"] = _marked(marks[0], names, file)
    note = f"{file.source}: coordinates and standard errors are those of its adjustment"
    cameras, said = _cameras(blocks, names, file)
    return Foreign(tables, None, (note, *said, *notes), cameras)


def _cameras(blocks, names, file):
    """Keys of a camera.toml, one for each calibration that differs; notes."""
    lines = [
        one
        for block in blocks
        for one, two in pairwise(block)
        if len(one.words) == len(two.words) == N_CAMERA
        and one.words[0] == two.words[0]  # its standard errors
    ]
    if len(lines) != len(names):
        return {}, []
    values = numbers_of(lines, file.source, 1, N_CAMERA, CAMERA)
    _, first = np.unique(values, axis=0, return_index=True)
    size = _size(blocks[0], file)
    if size is None:
        c, _, _, wide, high, *_ = values[0]
        said = f"{file.source}: no camera, as it has not the number of pixels: "
        return {}, [f"{said}c = {c:g} mm, {wide:g} mm by {high:g} mm"]
    called = {"camera": 0} if len(first) == 1 else {names[k]: k for k in sorted(first)}
    return {name: _camera(values[k], size) for name, k in called.items()}, []


def _size(head, file):
    """Width and height of the photos [pixels]; None where they are not there."""
    words = head[1].words if len(head) > 1 else []
    if len(words) != 4:
        return None
    size = numbers_of([head[1]], file.source, 2, 4, "width and height in pixels")[0]
    return size.astype(int) if (size >= 1).all() else None


def _camera(calibration, size):
    """Keys of camera.toml; the centre of the format is that of the image."""
    c, x, y, wide, high, *lens = calibration.tolist()
    pitch = 1e3 * np.array([wide, high]) / size
    keys = {"convention": "mm", "c": c, "x0": x - 0.5 * wide, "y0": 0.5 * high - y}
    keys |= dict(zip(("k1", "k2", "k3", "p1", "p2"), lens, strict=True))
    keys |= {"width": int(size[0]), "height": int(size[1])}
    return keys | {
        "pixel_size_um": float(pitch[0]),
        "pixel_height_um": float(pitch[1]),
    }


def _compared_with_end(blocks, marks, file):
    """Notes on the list at the end: photo and point of every mark.

    It also has marks of points that were not exported, and so may be longer.
    """
    listed = blocks[-1] if all(len(line.words) == 2 for line in blocks[-1]) else []
    if len(listed) < len(marks):
        found = f"lists {len(listed)} of its {len(marks)} marks at its end: it is cut"
        raise damaged(file.source, found, EXPECTED, blocks[-1][-1].row)
    n_more = len(listed) - len(marks)
    said = kept("{n:mark|marks}", n=n_more)
    return [f"{file.source}: lists {said} more than it has"] if n_more else []


def _photos(blocks, file):
    """Names of the photos, and the line with the orientation of each."""
    names, lines = [], []
    for block in blocks:
        for one, two in pairwise(block):
            is_name = len(one.words) > 1 and not is_number(one.words[1])
            if is_name and one.words[0] == two.words[0] and len(two.words) == 7:
                path = one.text.partition(one.words[1])[1:]
                names.append("".join(path).replace("\\", "/").rpartition("/")[2])
                lines.append(two)
    if not names:
        raise damaged(file.source, "holds no photos", EXPECTED)
    return names, lines


def _object_points(block, file):
    values = numbers_of(block, file.source, 1, 7, POINT)
    table = points_on_ground([line.words[0] for line in block], values[:, :3])
    for place, axis in enumerate(("easting", "northing", "height"), 3):
        if (values[:, place] > 0).all():  # negative where none was computed
            table[f"standard_error_{axis}"] = values[:, place]
    return table


def _marked(block, names, file):
    values = numbers_of(block, file.source, 2, 4, MARK)
    photos = []
    for line in block:
        word = line.words[0]
        if not (word.isascii() and word.isdigit()) or int(word) >= len(names):
            found = f"photo {word[:20]} is not among the {len(names)} photos"
            raise damaged(file.source, found, MARK, line.row)
        photos.append(names[int(word)])
    return points_in_images(photos, [line.words[1] for line in block], values)
