"""Control lists, image coordinates and orientations of PAT-B, after its manual.

No file of the program itself was seen: columns are read freely, parted by blanks. The
control list has the points in plan (number, x, y, class), a line -99, the heights
(number, z, class), a line -99. x is the easting.
"""

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError
from einschalt.foundations.rotations import angles_from_rotation, are_rotations
from einschalt.foundations.units import MM_PER_UM
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.programs.foreign import (
    Foreign,
    is_finite,
    lines_of,
    numbers_of,
    orientations,
    photo_points,
    require_rows,
    unseen,
)

END = "-99"
MOST_DIGITS = 12
CONTROL = "number x y [z] [class] on each line, and -99 at the end of the list"
IMAGES = "a line with the photo, lines of number x y [µm], and -99"
ORIENTATION = "number X Y Z, then nine elements of the rotation in two lines"


def write_control(handed, path):
    """Write the points as control; gives notes. Names get numbers where they have none.

    What each number stands for is written beside it, as ``NAME_names.csv``.
    """
    names = [str(name) for name in handed.points["point_id"]]
    is_plain = all(n.isdigit() and len(n) <= MOST_DIGITS and n[0] != "0" for n in names)
    numbers = names if is_plain else [str(k) for k in range(1, len(names) + 1)]
    xy, heights = handed.coordinates[:, :2], handed.heights
    plan = zip(numbers, xy, strict=True)
    lines = [f"{n:>12} {x:15.4f} {y:15.4f}  1" for n, (x, y) in plan]
    lines.append(f"{END:>12}")
    upright = [(n, h) for n, h in zip(numbers, heights, strict=True) if np.isfinite(h)]
    lines += [f"{n:>12} {height:15.4f}  1" for n, height in upright]
    lines.append(f"{END:>12}")
    path.write_text("\n".join([*lines, ""]), encoding="ascii", newline="\n")
    notes = ["after the manual of PAT-B, not tried with the program"]
    size = handed.errors_in_plan
    if size is not None:
        each = float(np.sqrt(np.mean(np.square(size)) / 2.0))
        notes.append(f"class 1: {each:.3f} m for each coordinate in plan")
    size = handed.errors_in_height
    if upright and size is not None:
        each = float(np.sqrt(np.mean(np.square(size))))
        notes.append(f"class 1 of the list of heights: {each:.3f} m")
    notes += handed.told_enlargement
    if not is_plain:
        listed = pd.DataFrame({"number": numbers, "point_id": names})
        beside = path.with_name(f"{path.stem}_names.csv")
        listed.to_csv(beside, index=False, lineterminator="\n")
        notes.append(f"names are no numbers: {beside.name} has them")
    return notes


def read_control(file) -> Foreign:
    """Read a control list; heights stand in a list of their own, or beside x and y."""
    plan, upright, is_upright = {}, {}, False
    lines = lines_of(file, comments=("#", "!", "*"))
    require_rows(lines, file.source, CONTROL)
    if END not in (line.words[0] for line in lines):
        raise damaged(file.source, f"has no {END}: it is cut off", CONTROL)
    rows = [line for line in lines if line.words[0] != END]
    numbers_of([r for r in rows if len(r.words) > 1], file.source, 1, 2, CONTROL)
    for line in lines:
        if line.words[0] == END:
            is_upright = True
            continue
        is_height = is_upright and len(line.words) <= 3
        n_numbers = 1 if is_height else 2
        values = numbers_of([line], file.source, 1, 1 + n_numbers, CONTROL)[0]
        into = upright if is_height else plan
        if line.words[0] in into:
            raise _twice(line, file.source)
        into[line.words[0]] = values
        # x y z, or x y and a class of one digit
        if not is_height and len(line.words) > 3 and "." in line.words[3]:
            upright[line.words[0]] = numbers_of([line], file.source, 3, 4, CONTROL)[0]
    if not plan:
        raise damaged(file.source, "holds no point in plan", CONTROL)
    table = pd.DataFrame({"point_id": list(plan)})
    table[["easting", "northing"]] = np.array(list(plan.values()))
    if upright:
        height = {name: value[0] for name, value in upright.items()}
        table["height"] = table["point_id"].map(height)
    lost = [name for name in upright if name not in plan]
    notes = [unseen(file.source)]
    if lost:
        notes.append(f"{file.source}: {len(lost)} points with heights alone, left out")
    return Foreign({"control_points": table}, None, tuple(notes))


def _twice(line, source):
    return damaged(source, f"point {line.words[0]} stands twice", CONTROL, line.row)


def read_photos(file, factor=MM_PER_UM, expected=IMAGES) -> Foreign:
    """Read image coordinates, photo by photo; ``factor`` makes millimetres of them."""
    photo, rows, lines = None, [], lines_of(file, comments=("#", "!", "*"))
    require_rows(lines, file.source, expected)
    for line in lines:
        if line.words[0] == END:
            photo = None
        elif photo is None:
            photo = line.words[0]
        else:
            rows.append((photo, line))
    if photo is not None:
        found = f"photo {photo} has no end {END}: the file is cut off"
        raise damaged(file.source, found, expected, lines[-1].row)
    if not rows:
        raise damaged(file.source, "holds no measurement", expected)
    table = photo_points(rows, file.source, expected, factor)
    return Foreign({"image_points": table}, None, (unseen(file.source),))


def read_orientations(file) -> Foreign:
    """Read exterior orientations: three lines for each photo."""
    lines = lines_of(file)
    require_rows(lines, file.source, ORIENTATION)
    whole = [number for line in lines for number in line.words]
    if len(whole) % 13:
        found = f"has {len(whole)} numbers, which is not 13 for each photo"
        raise damaged(file.source, found, ORIENTATION, lines[-1].row)
    heads, names, values = [], [], []
    word_lines = [(w, line.row) for line in lines for w in line.words]
    for start in range(0, len(word_lines), 13):
        part = word_lines[start : start + 13]
        names.append(part[0][0])
        heads.append(part[0][1])
        values.append([w for w, _ in part[1:]])
    for row, words in zip(heads, values, strict=True):
        wrong = [word for word in words if not is_finite(word)]
        if wrong:
            found = f"{shortened(wrong[0])!r} is no number"
            raise damaged(file.source, found, ORIENTATION, row)
    values = np.array(values, dtype=float)
    matrices = values[:, 3:].reshape(-1, 3, 3)
    _require_rotations(matrices, heads, file.source)
    # a11 … a33 turn a vector of the image into the frame of the ground
    angles = angles_from_rotation(np.swapaxes(matrices, 1, 2))
    table = orientations(names, values[:, :3], angles)
    return Foreign({"orientations": table}, None, (unseen(file.source),))


def _require_rotations(matrices, rows, source):
    is_bad = ~are_rotations(matrices, 1e-4)
    if is_bad.any():
        row = rows[int(np.flatnonzero(is_bad)[0])]
        raise FileError(
            "the nine elements of a photo are no rotation",
            expected=ORIENTATION,
            remedy="Export it again",
            file=source,
            row=row,
        )
