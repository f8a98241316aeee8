"""Files of MicMac: control and its image points, orientations, cameras, tie points.

Of MicMac and of MMVII. Pixels are counted from the upper left corner, y down.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from einschalt.foundations.errors import FileError
from einschalt.foundations.rotations import angles_from_rotation, are_rotations
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.input_files import read_once
from einschalt.interfaces.files.plain_xml import each, read_xml, text_of
from einschalt.interfaces.programs.foreign import (
    TURNED,
    Foreign,
    is_finite,
    lines_of,
    numbers_of,
    orientations,
    require_rows,
)
from einschalt.interfaces.programs.micmac_cameras import cameras_of
from einschalt.interfaces.programs.pixel_cameras import without_pitch

EXPECTED = "control, measurements, orientations or a camera as MicMac writes them"
PAIR = "x y of the first image, x y of the second [, weight] in each line"
PASTIS = "Pastis"
MARKS = (b"DicoAppuisFlottant", b"MesureAppuiFlottant", b"OrientationConique")
MARKS += (b"CalibrationInternConique",)
MARKS += (b"MMVII_Serialization", b"SetOfMesureAppuisFlottants")
SIGMA = ("Sigma2", "OptSigma2", "__Opt__Sigma2")  # of older and newer versions
COVARIANCE = {  # place in Sigma2: xx xy xz yy yz zz
    "covariance_en": 1,
    "covariance_eh": 2,
    "covariance_nh": 4,
}


def is_xml(head):
    """Whether the first bytes of a file look so."""
    return any(mark in head for mark in MARKS)


def read_file(file) -> Foreign:
    """Read control, measurements, orientations, cameras: whatever stands in a file."""
    root = read_xml(file.data, file.source, EXPECTED)
    found = {
        "control_points": _control(root, file.source),
        "image_points": _measurements(root, file.source),
        "orientations": _orientations(root, file),
    }
    tables = {name: table for name, table in found.items() if len(table)}
    cameras, unusable = cameras_of(root, file)
    if not (tables or cameras):  # but settings, say
        raise FileError(
            next(iter(unusable.values()), "holds nothing that is known"),
            expected=EXPECTED,
            remedy="Name the file that has them",
            file=file.source,
        )
    notes = (*unusable.values(), *without_pitch(cameras, file.source))
    return Foreign(tables, None, notes, cameras, unusable)


def _numbers(text, count, source, what):
    words = text.split()
    if len(words) != count or not all(map(is_finite, words)):
        raise damaged(source, f"{what}: {text[:60]!r} is not {count} numbers", EXPECTED)
    return [float(word) for word in words]


def _named(text, source):
    name = text.strip().strip('"')
    if not name:
        raise damaged(source, "a point or an image has no name", EXPECTED)
    return name


def _control(root, source):
    rows = []
    for one in each(root, "OneAppuisDAF"):
        name = _named(text_of(one, "NamePt"), source)
        place = _numbers(text_of(one, "Pt"), 3, source, f"point {name}")
        said = text_of(one, "Incertitude")
        error = _numbers(said, 3, source, f"point {name}") if said else [np.nan] * 3
        rows.append((name, *place, *error, 0.0, 0.0, 0.0))
    for group in each(root, "SetGCP"):
        for one in _members(group, source):
            name = _named(text_of(one, "Name"), source)
            place = _numbers(text_of(one, "Pt"), 3, source, f"point {name}")
            said = next(filter(None, (text_of(one, tag) for tag in SIGMA)), "")
            sigma = _numbers(said, 6, source, f"point {name}") if said else [np.nan] * 6
            error = [np.sqrt(sigma[k]) if sigma[k] >= 0 else np.nan for k in (0, 3, 5)]
            between = [sigma[k] for k in COVARIANCE.values()]
            rows.append((name, *place, *error, *between))
    axes = ["easting", "northing", "height"]
    errors = [f"standard_error_{axis}" for axis in axes]
    table = pd.DataFrame(rows, columns=["point_id", *axes, *errors, *COVARIANCE])
    return _without_unknown(table, [*errors, *COVARIANCE])


def _without_unknown(table, columns):
    """The table without precisions that no point has."""
    empty = [c for c in columns if not len(table) or not table[c].fillna(0).any()]
    return table.drop(columns=empty)


def _members(group, source):
    """Members of a list, as many as MMVII announces before it."""
    listed = next(each(group, "Measures"), None)
    if listed is None:
        return []
    members = [one for one in listed if one.tag == "el"]
    said = text_of(listed, "Nb")
    if said.isdigit() and int(said) != len(members):
        found = f"holds {len(members)} of {said} members of a list"
        raise damaged(source, found, EXPECTED)
    return members


def _measurements(root, source):
    rows = []
    for image in each(root, "MesureAppuiFlottant1Im"):
        name = _named(text_of(image, "NameIm"), source)
        for one in each(image, "OneMesureAF1I"):
            point = _named(text_of(one, "NamePt"), source)
            xy = _numbers(text_of(one, "PtIm"), 2, source, f"{point} in {name}")
            rows.append((name, point, *xy))
    # an older and a newer name of the same list in MMVII
    for image in (*each(root, "SetMesPtOf1Im"), *each(root, "SetMesIm")):
        name = _named(text_of(image, "NameIm"), source)
        for one in _members(image, source):
            point = text_of(one, "NamePt") or text_of(one, "Name")
            point = _named(point, source)
            xy = _numbers(text_of(one, "Pt"), 2, source, f"{point} in {name}")
            rows.append((name, point, *xy))
    return pd.DataFrame(rows, columns=["image_id", "point_id", "x", "y"])


def _orientations(root, file):
    """Orientation of an image, whose name is that of the file."""
    image = file.path.name.removesuffix(".xml").removeprefix("Orientation-")
    image = image.removeprefix("Ori-PerspCentral-")
    names, centres, matrices = [], [], []
    for one in each(root, "Externe"):
        said = f"image {image}"
        centre = _numbers(text_of(one, "Centre"), 3, file.source, said)
        matrix = next(each(one, "CodageMatr"), None)
        if matrix is None:
            raise damaged(file.source, "has no rotation matrix", EXPECTED)
        rows = [text_of(matrix, name) for name in ("L1", "L2", "L3")]
        matrices.append([_numbers(row, 3, file.source, said) for row in rows])
        names.append(image)
        centres.append(centre)
    # from the camera (x right, y down, z ahead) to the ground
    turn = [np.transpose(matrix) for matrix in matrices]
    for one in each(root, "CameraPose"):  # of MMVII
        image = _named(text_of(one, "NameImage"), file.source)
        said = f"image {image}"
        centres.append(_numbers(text_of(one, "Center"), 3, file.source, said))
        axes = [text_of(one, "RotMatrix", f"Axe{letter}") for letter in "IJK"]
        turn.append([_numbers(axis, 3, file.source, said) for axis in axes])
        names.append(image)
    if not names:
        return pd.DataFrame()
    turn = np.array(turn)
    if not are_rotations(turn, 1e-6).all():
        raise damaged(file.source, "its matrix is no rotation", EXPECTED)
    return orientations(names, centres, angles_from_rotation(TURNED @ turn))


def is_homologous(path):
    """Whether a file or folder has homologous points, by its name."""
    path = Path(path)
    if path.is_dir():
        return any(path.glob(f"{PASTIS}*/*.txt"))
    return path.suffix.lower() == ".txt" and path.parent.name.startswith(PASTIS)


def read_homologous(path) -> Foreign:
    """Read the homologous points of a pair of images, or of all pairs of a folder."""
    path = Path(path)
    files = sorted(path.glob(f"{PASTIS}*/*.txt")) if path.is_dir() else [path]
    pairs, models = [], []
    for one in files:
        left = one.parent.name.removeprefix(PASTIS)
        right = one.name.removesuffix(".txt")
        lines = lines_of(read_once(one, one.name))
        require_rows(lines, one.name, PAIR)
        values = numbers_of(lines, one.name, 0, 4, PAIR)
        model = f"{left}/{right}"
        models.append((model, left, right))
        pairs.append(_pairs(model, values))
    columns = ["model_id", "left_image", "right_image"]
    tables = {"image_pairs": pd.concat(pairs, ignore_index=True)}
    return Foreign({**tables, "models": pd.DataFrame(models, columns=columns)})


def _pairs(model, values):
    names = [str(k) for k in range(1, len(values) + 1)]
    table = pd.DataFrame({"model_id": model, "point_id": names})
    table[["x_left", "y_left", "x_right", "y_right"]] = values
    return table
