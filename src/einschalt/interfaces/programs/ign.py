"""Text files of IGN's TopAero: orientations, control points, image points."""

import numpy as np

from einschalt.foundations.errors import FileError
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.rotations import angles_from_rotation, rotation_from_angles
from einschalt.foundations.units import RADIANS_PER_GON
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.programs.foreign import (
    Foreign,
    Line,
    is_finite,
    lines_of,
    numbers_of,
    orientations,
    points_in_images,
    points_on_ground,
    require_rows,
)

OPK = "image X Y Z omega phi kappa [camera] in each line"
XYZ = "[name] X Y Z in each line"
MES = "point image column row in each line"
APP = "name code X Y Z in each line"
HEADS = {"NOM", "ID"}  # begin the line with the names of the columns
COLUMNS = {"NOM": "N", "OMEGA": "O", "PHI": "P", "KAPPA": "K"}
SYSTEMS = {"LAMBERT93": "EPSG:2154", "LAMBERT-93": "EPSG:2154", "L93": "EPSG:2154"}
UNITS = {"degre": np.pi / 180.0, "degree": np.pi / 180.0, "deg": np.pi / 180.0}
UNITS |= {"grade": RADIANS_PER_GON, "grad": RADIANS_PER_GON, "gon": RADIANS_PER_GON}
UNITS |= {"radian": 1.0, "rad": 1.0}


def read_opk(file) -> Foreign:
    """Read exterior orientations; angles are degrees unless the header says grades."""
    lines, unit, said, crs, head = [], UNITS["degre"], "", None, None
    for line in lines_of(file):
        key, colon, value = line.text.partition(":")
        if colon and not is_number(line.words[-1]):
            key, value = key.strip().upper(), value.strip()
            if key.startswith("UNITE ANGLE"):
                word = value.casefold().replace("é", "e").rstrip("s")
                if word not in UNITS:
                    found = f"the unit of angles {value!r} is unknown"
                    raise damaged(file.source, found, "degre or grade", line.row)
                unit, said = UNITS[word], value
            elif key == "PROJECTION":
                crs = SYSTEMS.get(value.upper().replace(" ", ""))
        elif _is_head(line):
            head = line
        else:
            lines.append(line)
    require_rows(lines, file.source, OPK)
    lines = _arranged(lines, head, "NXYZOPK", file.source, OPK)
    values = numbers_of(lines, file.source, 1, 7, OPK)
    angles = rotation_from_angles(*(unit * values[:, 3:]).T)
    table = orientations(
        [line.words[0] for line in lines], values[:, :3], angles_from_rotation(angles)
    )
    cameras = [line.words[7] if len(line.words) > 7 else "" for line in lines]
    table = table.assign(camera=cameras) if any(cameras) else table
    degrees = f"{file.source}: angles read as degrees"
    note = f"{file.source}: angles read as {said}" if said else degrees
    return Foreign({"orientations": table}, crs, (note,))


def _is_head(line):
    """Whether a line has names of columns."""
    words = [word.upper() for word in line.words]
    return words[0] in HEADS or {"X", "Y", "Z"} <= set(words)


def _arranged(lines, head, order, source, expected):
    """Lines with their words in an order of columns, and after these the camera.

    Programs choose the columns of these files, and name them in the header.
    """
    if head is None:
        return lines
    names = [COLUMNS.get(word.upper(), word.upper()) for word in head.words]
    if "N" not in names:  # beside NOM it is a running number
        names = ["N" if name == "ID" else name for name in names]
    missing = [name for name in order if name not in names]
    if missing:
        found = f"the header names no {' '.join(missing)}"
        raise damaged(source, found, expected, head.row)
    places = [names.index(name) for name in (*order, "CAMERA") if name in names]
    return [
        Line(one.row, [one.words[k] for k in places if k < len(one.words)], one.text)
        for one in lines
    ]


def read_xyz(file) -> Foreign:
    """Read points X Y Z, with a name before them or numbered."""
    given = lines_of(file)
    head = next((line for line in given if _is_head(line)), None)
    lines = [line for line in given if not _is_head(line)]
    require_rows(lines, file.source, XYZ)
    if head is None:
        has_names = len(lines[0].words) > 3
        _require_names(lines if has_names else [], file.source)
    else:
        has_names = bool({"NOM", "ID"} & {word.upper() for word in head.words})
        order = "NXYZ" if has_names else "XYZ"
        lines = _arranged(lines, head, order, file.source, XYZ)
    start = 1 if has_names else 0
    values = numbers_of(lines, file.source, start, start + 3, XYZ)
    numbers = [str(k) for k in range(1, len(lines) + 1)]
    names = [_name(line.words[0]) for line in lines] if has_names else numbers
    return Foreign({"control_points": points_on_ground(names, values)})


def _require_names(lines, source):
    """Refuse X Y Z and more, whose X would be taken for a name."""
    if lines and all(_has_decimals(line.words[0]) for line in lines):
        raise FileError(
            f"{lines[0].text[:60]!r} begins with a number that has decimals, and no "
            "name",
            expected=XYZ,
            remedy="Write names before the coordinates, or a line X Y Z above them",
            file=source,
            row=lines[0].row,
        )


def _has_decimals(word):
    return is_finite(word) and "." in word


def _name(word):
    """Name of a point, which some programs write between quotes."""
    return word.strip('"')


def read_app(file) -> Foreign:
    """Read control points with a code, which is kept."""
    lines = lines_of(file)
    require_rows(lines, file.source, APP)
    values = numbers_of(lines, file.source, 2, 5, APP)
    table = points_on_ground([_name(line.words[0]) for line in lines], values)
    return Foreign({"control_points": table.assign(code=[o.words[1] for o in lines])})


def read_mes(file) -> Foreign:
    """Read image points: point, image, column, row [pixels]."""
    lines = lines_of(file)
    require_rows(lines, file.source, MES)
    values = numbers_of(lines, file.source, 2, 4, MES)
    if all(_has_decimals(line.words[1]) for line in lines):
        raise FileError(
            f"{lines[0].text[:60]!r} names no image: it looks like point X Y Z",
            expected=MES,
            remedy="Name a list of points so that it ends in .xyz",
            file=file.source,
            row=lines[0].row,
        )
    names = [_name(line.words[0]) for line in lines]
    images = [line.words[1] for line in lines]
    return Foreign({"image_points": points_in_images(images, names, values)})
