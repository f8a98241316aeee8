"""Projects of Inpho (Match-AT), after descriptions of their format: ``.prj``."""

import numpy as np

from einschalt.foundations.rotations import angles_from_rotation, are_rotations
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.programs.foreign import (
    Foreign,
    lines_of,
    numbers_of,
    orientations,
    photo_points,
    points_on_ground,
    unseen,
)

EXPECTED = "blocks $PHOTO … $END, with $PHOTO_NUM, $EXT_ORI and $PHOTO_POINTS"
POINTS = "point x y in each line up to $END_POINTS"
CONTROL = "point X Y Z in each line up to $END"
ORIENTATION = "c X Y Z, then three rows of the rotation"
PHOTO, CONTROL_BLOCK = "$PHOTO", "$CONTROL_POINTS"


def is_project(head):
    """Whether the first bytes of a file look so."""
    return b"$PROJECT" in head


def read_project(file) -> Foreign:
    """Read photos with their points and orientations, and control points."""
    lines = lines_of(file)
    photos, control, unit = _blocks(lines, file.source)
    tables = {}
    oriented = [(p["name"], p["orientation"]) for p in photos if p["orientation"]]
    if oriented:
        tables["orientations"] = _orientations(oriented, file.source)
    rows = [(p["name"], line) for p in photos for line in p["points"]]
    if rows:
        tables["image_points"] = photo_points(rows, file.source, POINTS)
    if control:
        names = [line.words[0] for line in control]
        values = numbers_of(control, file.source, 1, 4, CONTROL)
        tables["control_points"] = points_on_ground(names, values)
    if not tables:
        raise damaged(file.source, "holds no photos and no control points", EXPECTED)
    notes = [unseen(file.source)]
    if unit:
        notes.append(f"{file.source}: image coordinates in {unit}")
    return Foreign(tables, None, tuple(notes))


def _blocks(lines, source):
    """Photos (name, orientation, points), lines of control, unit of the images."""
    photos, control, unit, photo, inside = [], [], "", None, None
    for line in lines:
        word, value = line.words[0].upper(), line.text.partition(":")[2].strip()
        if word == PHOTO:
            photo = {"name": "", "orientation": [], "points": [], "row": line.row}
        elif word == "$LINEAR_UNITS_OF_IMAGE":
            unit = value
        elif word == "$PHOTO_NUM" and photo is not None:
            photo["name"] = value
        elif word == "$EXT_ORI" and photo is not None:
            inside = photo["orientation"]
        elif word == "$PHOTO_POINTS" and photo is not None:
            inside = photo["points"]
        elif word == CONTROL_BLOCK:
            inside = control
        elif word == "$END" and photo is not None:
            photos.append(photo)
            photo = inside = None
        elif word.startswith("$"):
            inside = None
        elif inside is not None:
            inside.append(line)
    if photo is not None:
        found = f"photo {photo['name']} has no $END: the file is cut off"
        raise damaged(source, found, EXPECTED, lines[-1].row)
    return photos, control, unit


def _orientations(oriented, source):
    names, centres, matrices = [], [], []
    for name, lines in oriented:
        if len(lines) < 4:
            found = f"the orientation of photo {name} has {len(lines)} of 4 lines"
            raise damaged(source, found, ORIENTATION, lines[-1].row)
        centres.append(numbers_of(lines[:1], source, 1, 4, ORIENTATION)[0])
        matrices.append(numbers_of(lines[1:4], source, 0, 3, ORIENTATION))
        names.append(name)
    turn = np.array(matrices)
    if not are_rotations(turn, 1e-4).all():
        raise damaged(source, "a matrix is no rotation", ORIENTATION)
    angles = angles_from_rotation(np.swapaxes(turn, 1, 2))
    return orientations(names, np.array(centres), angles)
