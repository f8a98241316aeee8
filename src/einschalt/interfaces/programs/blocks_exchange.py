"""BlocksExchange of ContextCapture and iTwin Capture: points, marks, cameras.

Marks are in pixels from the centre of the upper left one, as Bentley describes the
format. So is the radial distortion Brown's; the order of P1 and P2 is not said, and a
calibration that has them is left out, as are those of fisheye cameras. Tie points that
the program found itself are left out.
"""

from dataclasses import replace

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError, name_some
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.projections import code_on_earth
from einschalt.foundations.units import UM_PER_MM
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.marker_files import (
    CONTROL,
    MEASURED,
    Markers,
    markers_of,
)
from einschalt.interfaces.files.metashape_accuracies import (
    ERRORS,
    accuracy,
    in_plan,
    with_errors,
)
from einschalt.interfaces.files.plain_xml import child, each, read_xml, text_of
from einschalt.interfaces.programs.foreign import Foreign, is_finite, unseen
from einschalt.interfaces.programs.pix4d import file_names
from einschalt.interfaces.programs.pixel_cameras import corner_keys

EXPECTED = "BlocksExchange with control points or photogroups"
GEOCENTRIC = ("4978", "GEOCCS", "geocent", "CARTESIAN")
FULL, VERTICAL = "Full", "Vertical"
TO_CORNER = 0.5  # pixels, from the centre of the first one to its corner


def is_blocks(head):
    """Whether the first bytes of a file look so."""
    return b"<BlocksExchange" in head


def read_blocks(file) -> Foreign:
    """Read control points with roles and accuracies, marks in photographs, cameras."""
    root = read_xml(file.data, file.source, EXPECTED)
    source = file.source
    cameras, unusable = _cameras(root, source)
    crs, notes = _system(root, source)
    photos = _photos(root, source)
    points, errors, rows, n_vertical = _control(root, photos, source)
    rows += _tie_points(root, photos, source)
    if not (points or rows or cameras or unusable):
        raise FileError(
            "holds neither points nor cameras",
            expected=EXPECTED,
            remedy="Export the block with its control points",
            file=source,
        )
    notes += [unseen(source), *(f"{source}: {said}" for said in unusable.values())]
    if n_vertical:
        said = kept("{n:point|points} of heights alone left out", n=n_vertical)
        notes.append(f"{source}: {said}")
    tables, notes = _tables(points, errors, rows, crs, notes, source)
    return Foreign(tables, crs, tuple(notes), cameras, unusable)


def _tables(points, errors, rows, crs, notes, source):
    """Tables that have rows, and all notes."""
    if rows:
        read = markers_of(points, rows, crs, notes, source)
    else:
        control = pd.DataFrame(points, columns=CONTROL)
        read = Markers(control, pd.DataFrame(columns=MEASURED), crs, tuple(notes))
    stated = pd.DataFrame(errors, columns=list(ERRORS), dtype=float)
    known, said = with_errors(read.points.join(stated), source)
    read = replace(read, points=known, notes=(*read.notes, *said))
    tables = {name: table for name, table in read.tables().items() if len(table)}
    return tables, read.notes


def _system(root, source):
    """System of the control points by its code, or None; notes."""
    known = {
        text_of(one, "Id"): text_of(one, "Definition") or text_of(one, "Name")
        for one in each(root, "SRS")
    }
    listed = child(root, "Block", "ControlPoints")
    of_block = text_of(root, "Block", "SRSId")
    of_all = of_block if listed is None else text_of(listed, "SRSId") or of_block
    points = [] if listed is None else list(each(listed, "ControlPoint"))
    given = {text_of(one, "SRSId") or of_all for one in points} or {of_all}
    if len(given) > 1:
        raise FileError(
            f"has control points of {len(given)} systems",
            expected="one system of all of them",
            remedy="Export them in one system",
            file=source,
        )
    said = known.get(given.pop()) or ""
    if points and any(word.casefold() in said.casefold() for word in GEOCENTRIC):
        raise FileError(
            "has geocentric control points",
            expected="coordinates of a plane system, or longitudes and latitudes",
            remedy="Export them in one of these systems",
            file=source,
        )
    crs = code_on_earth(said)
    is_open = bool(said) and crs is None
    unknown = f"{source}: its system is unknown or local: {shortened(said, 60)}"
    return crs, [unknown] if is_open else []


def _photos(root, source):
    """Names of the photographs by their numbers."""
    photos = list(each(root, "Photo"))
    paths = [text_of(one, "ImagePath") or text_of(one, "Id") for one in photos]
    numbers = [text_of(one, "Id") for one in photos]
    return dict(zip(numbers, file_names(paths, source), strict=True))


def _control(root, photos, source):
    """Control points, their errors, their marks, and how many have no place in plan."""
    points, errors, rows, n_vertical = [], [], [], 0
    for one in each(root, "ControlPoint"):
        name = text_of(one, "Name")
        rows += _marks(one, name, photos, source)
        kind = text_of(one, "Category") or FULL
        if kind == VERTICAL:
            n_vertical += 1
            continue
        axes = "xyz" if kind == FULL else "xy"
        place = [_number(text_of(one, "Position", axis), name, source) for axis in axes]
        place += [np.nan] * (len("xyz") - len(place))
        is_check = (text_of(one, "CheckPoint") or "").casefold() == "true"
        points.append((name, *place, "check" if is_check else "control"))
        plan, height = (
            accuracy(text_of(one, f"{way}Accuracy"))
            for way in ("Horizontal", "Vertical")
        )
        errors.append((in_plan(np.nan, plan, plan), height))
    return points, errors, rows, n_vertical


def _tie_points(root, photos, source):
    """Marks of tie points that a person has measured and named."""
    rows = []
    for one in each(root, "TiePoint"):
        name = text_of(one, "Name")
        if name and text_of(one, "Measurement", "Type") == "User":
            rows += _marks(one, name, photos, source)
    return rows


def _marks(point, name, photos, source):
    """Image, point, x and y of the marks of a point, from the corner of the image."""
    rows = []
    for mark in each(point, "Measurement"):
        number = text_of(mark, "PhotoId")
        if number not in photos:
            found = f"point {name} has a mark in photograph {number}, unknown"
            raise damaged(source, found, EXPECTED)
        xy = (_number(text_of(mark, axis), name, source) for axis in "xy")
        rows.append((photos[number], name, *(value + TO_CORNER for value in xy)))
    return rows


def _number(text, name, source):
    if not text or not is_finite(text):
        found = f"a coordinate of point {name} is no number: {shortened(text or '')!r}"
        raise damaged(source, found, EXPECTED)
    return float(text)


def _cameras(root, source):
    """Keys of camera.toml by the names of photogroups; why others have none."""
    cameras, unusable = {}, {}
    for place, group in enumerate(each(root, "Photogroup"), 1):
        name = text_of(group, "Name") or str(place)
        name = name if name not in {*cameras, *unusable} else f"{name} {place}"
        why = _why_unusable(group, name)
        if why is None:
            cameras[name] = _keys(group, name, source)
        else:
            unusable[name] = why
    return cameras, unusable


def _why_unusable(group, name):
    kind = text_of(group, "CameraModelType") or "Perspective"
    if kind != "Perspective":
        return f"{name} is a {kind} camera: its calibration is left out"
    wanted = ("Width", "Height")
    sizes = [text_of(group, "ImageDimensions", side) for side in wanted]
    has_focal = text_of(group, "FocalLength") and text_of(group, "SensorSize")
    if not all(sizes) or not has_focal:
        return (
            f"{name} states no focal length with the size of its sensor: its "
            "calibration is left out"
        )
    neutral = {("Distortion", one): 0.0 for one in ("P1", "P2")}
    neutral |= {("Skew",): 0.0, ("AspectRatio",): 1.0}
    given = [
        path[-1] for path, value in neutral.items() if _is_used(group, path, value)
    ]
    if not given:
        return None
    return f"{name} has {name_some(given)}: its calibration is left out"


def _is_used(group, path, neutral):
    text = text_of(group, *path)
    return bool(text) and not (is_finite(text) and float(text) == neutral)


def _keys(group, name, source):
    width, height, focal, sensor = (
        _number_of(group, path, name, source)
        for path in (
            ("ImageDimensions", "Width"),
            ("ImageDimensions", "Height"),
            ("FocalLength",),
            ("SensorSize",),
        )
    )
    if min(width, height) < 1.0 or not min(focal, sensor) > 0.0:
        raise damaged(source, f"camera {name} has pixels of no size", EXPECTED)
    pitch_mm = sensor / max(width, height)
    centre = [0.5 * width, 0.5 * height]
    if child(group, "PrincipalPoint") is not None:
        centre = [
            _number_of(group, ("PrincipalPoint", axis), name, source) + TO_CORNER
            for axis in "xy"
        ]
    k1, k2, k3 = (
        _number_of(group, ("Distortion", key), name, source)
        if text_of(group, "Distortion", key)
        else 0.0
        for key in ("K1", "K2", "K3")
    )
    f = focal / pitch_mm
    outer = (k1, k2, 0.0, 0.0, k3)
    return corner_keys(f, f, *centre, (width, height), outer, UM_PER_MM * pitch_mm)


def _number_of(group, path, name, source):
    text = text_of(group, *path)
    if not text or not is_finite(text):
        raise damaged(source, f"the {path[-1]} of camera {name} is no number", EXPECTED)
    return float(text)
