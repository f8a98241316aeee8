"""Projects of Pix4Dmapper (``.p4d``): ground points, marks in images, cameras.

Cameras are those with which the project began: the optimised ones stand in its report.
Marks are in pixels from the upper left corner of the image; a camera in the middle has
its principal point at half the width. It distorts as OpenCV does, with T1 and T2 for p1
and p2: so Pix4D's own converter to COLMAP takes them.
"""

import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError, name_some
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.projections import code_on_earth, read_source_crs
from einschalt.foundations.units import UM_PER_MM
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.marker_files import markers_of
from einschalt.interfaces.files.metashape_accuracies import (
    ERRORS,
    accuracy,
    in_plan,
    is_on,
    with_errors,
)
from einschalt.interfaces.files.plain_xml import child, each, read_xml, text_of
from einschalt.interfaces.programs.foreign import Foreign, is_finite
from einschalt.interfaces.programs.pixel_cameras import corner_keys

EXPECTED = "a project as Pix4Dmapper saves it"
FRAME = "perspective"
DISTORTION = ("radialK1", "radialK2", "tangentialT1", "tangentialT2", "radialK3")
ROLES = {"3dgcp": "control", "checkpoint": "check"}
FOLDERS = re.compile(r"[\\/]")  # of either system


def is_project(head):
    """Whether the first bytes of a file look so."""
    return b"<pix4dmapper" in head


def read_project(file) -> Foreign:
    """Read ground points with roles and accuracies, marks, and calibrations."""
    root = read_xml(file.data, file.source, EXPECTED)
    cameras, unusable = _calibrations(root, file.source)
    notes = [f"{file.source}: {said}" for said in unusable.values()]
    if next(each(root, "GCP"), None) is None:
        if not cameras:
            raise FileError(
                next(iter(unusable.values()), "holds neither points nor cameras"),
                expected="ground points that are marked, or a perspective camera",
                remedy="Name the project that has them",
                file=file.source,
            )
        return Foreign({}, None, tuple(notes), cameras, unusable)
    markers = _markers(root, file.source)
    tables = {name: table for name, table in markers.tables().items() if len(table)}
    notes += markers.notes
    return Foreign(tables, markers.crs, tuple(notes), cameras, unusable)


def _calibrations(root, source):
    """Keys of camera.toml by the names of cameras; why others have none."""
    cameras, unusable = {}, {}
    listed = child(root, "inputs", "cameras")
    for camera in () if listed is None else each(listed, "camera"):
        name = camera.get("name") or str(len(cameras) + len(unusable) + 1)
        kind = text_of(camera, "lensType") or FRAME
        if kind != FRAME:
            unusable[name] = f"{name} is a {kind} camera: its calibration is left out"
            continue
        size = _numbers(camera, ("imageWidth", "imageHeight"), name, source)
        inner = ("focalLengthmm", "principalPointXmm", "principalPointYmm")
        (pitch,) = _numbers(camera, ("pixelSize",), name, source)
        if not (pitch > 0.0 and min(size) >= 1.0):
            raise damaged(source, f"camera {name} has pixels of no size", EXPECTED)
        f, cx, cy = (
            UM_PER_MM * value / pitch for value in _numbers(camera, inner, name, source)
        )
        given = [key if text_of(camera, key) else None for key in DISTORTION]
        outer = [
            _numbers(camera, (key,), name, source)[0] if key else 0.0 for key in given
        ]
        cameras[name] = corner_keys(f, f, cx, cy, size, outer, pitch)
    return cameras, unusable


def _numbers(camera, keys, name, source):
    words = [text_of(camera, key) for key in keys]
    wrong = [key for key, word in zip(keys, words, strict=True) if not is_finite(word)]
    if wrong:
        raise damaged(source, f"the {wrong[0]} of camera {name} is no number", EXPECTED)
    return [float(word) for word in words]


def _markers(root, source):
    """Points and marks, with the system of the points."""
    wkt = text_of(root, "inputs", "coordinateSystems", "gcp", "WKT")
    crs = code_on_earth(wkt)
    notes = []
    if wkt and crs is None:
        notes.append(f"{source}: its system is unknown or local: {shortened(wkt, 60)}")
    is_geographic = crs is not None and read_source_crs(crs).is_geographic
    axes = ("lon", "lat", "alt") if is_geographic else ("x", "y", "z")
    labels, points, errors, n_of_kind = {}, [], [], Counter()
    for one in each(root, "GCP"):
        name, kind = one.get("label"), one.get("type", "")
        labels[one.get("id")] = name
        role = ROLES.get(kind.casefold())
        n_of_kind[kind] += role is None
        if role is not None:
            place = [_number(one.get(axis), name, source) for axis in axes]
            points.append((name, *place, role))
            plan, height = (accuracy(one.get(f"accuracy{ax}")) for ax in ("XY", "Z"))
            errors.append((in_plan(np.nan, plan, plan), height))
    notes += [
        f"{source}: {kept('{n:point|points}', n=n)} of the type {kind!r}, taken for "
        "points without given coordinates"
        for kind, n in n_of_kind.items()
        if n
    ]
    rows, said = _marks(root, labels, source)
    read = markers_of(points, rows, crs, [*notes, *said], source)
    stated = pd.DataFrame(errors, columns=list(ERRORS), dtype=float)
    known, said = with_errors(read.points.join(stated), source)
    return replace(read, points=known, notes=(*read.notes, *said))


def _marks(root, labels, source):
    """Image, point, x and y of each mark in an image that is in use; notes."""
    listed = child(root, "inputs", "images")
    images = [] if listed is None else list(each(listed, "image"))
    used = [one for one in images if is_on(one.get("enabled", "true"))]
    rows = []
    paths = [one.get("path") or "" for one in used]
    for image, name in zip(used, file_names(paths, source), strict=True):
        for mark in each(image, "imageGCP"):
            if mark.get("id") not in labels:
                found = f"image {name} has a mark of point {mark.get('id')}, unknown"
                raise damaged(source, found, EXPECTED)
            point = labels[mark.get("id")]
            xy = (_number(mark.get(axis), point, source) for axis in "xy")
            rows.append((name, point, *xy))
    if len(used) == len(images):
        return rows, []
    said = kept("{n:image|images}", n=len(images) - len(used))
    return rows, [f"{source}: {said} not enabled, left out"]


def file_names(paths, source):
    """Names of the files of images, with their folders where names repeat."""
    paths = [FOLDERS.split(path) for path in paths]
    names = []
    for n_parts in range(1, 1 + max(map(len, paths), default=1)):
        names = ["/".join(path[-n_parts:]) for path in paths]
        if len(set(names)) == len(names):
            return names
    again = name_some([n for n, count in Counter(names).items() if count > 1], 4)
    raise damaged(source, f"has images that are listed twice: {again}", EXPECTED)


def _number(text, name, source):
    if text is None or not is_finite(text):
        found = f"a coordinate of point {name} is no number: {shortened(text or '')!r}"
        raise damaged(source, found, EXPECTED)
    return float(text)
