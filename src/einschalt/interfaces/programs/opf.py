"""Projects of the Open Photogrammetry Format (``project.opf``), as Pix4D writes them.

Ground points with roles and accuracies, manual tie points, their marks in images,
calibrations, and orientations of calibrated images. A mark at (0, 0) lies in the upper
left corner of the first pixel. Coordinates have the axes of their system: latitude
comes first where EPSG says so. Angles are those of docs/conventions.md.
"""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError, name_some
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.projections import code_on_earth, read_source_crs
from einschalt.interfaces.files import opf_parts
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.input_files import read_once
from einschalt.interfaces.files.marker_files import markers_of
from einschalt.interfaces.files.metashape_accuracies import ERRORS, in_plan, with_errors
from einschalt.interfaces.files.plain_json import read_json
from einschalt.interfaces.programs.foreign import Foreign, is_finite, orientations
from einschalt.interfaces.programs.pix4d import file_names
from einschalt.interfaces.programs.pixel_cameras import corner_keys

EXPECTED = "a project as the Open Photogrammetry Format describes it"
KIND, PITCH = "perspective", "pixel_size_um"
MARK = b"application/opf-"
FAULTS = (KeyError, TypeError, ValueError, AttributeError, IndexError)


@dataclass(frozen=True)
class Part:
    """What stands in a file of a project, and how the file is called."""

    given: dict
    source: str


def is_project(head):
    """Whether the first bytes of a file look so, or like a part of a project."""
    return MARK in head


def read_project(file) -> Foreign:
    """Read ground points, marks, calibrations and orientations of a project."""
    parts, notes = _parts(file)
    names = _names_of_images(parts.get(opf_parts.CAMERA_LIST))
    cameras, unusable = _calibrations(parts)
    notes += [f"{file.source}: {said}" for said in unusable.values()]
    crs, tables = _system_of_frame(parts.get(opf_parts.FRAME)), {}
    if opf_parts.CONTROL in parts:
        markers = _markers(parts[opf_parts.CONTROL], names)
        tables |= {name: one for name, one in markers.tables().items() if len(one)}
        crs = markers.crs or crs
        notes += markers.notes
    oriented, said = _orientations(parts, names, file.source)
    tables |= {} if oriented is None else {"orientations": oriented}
    if not (tables or cameras):
        raise FileError(
            next(iter(unusable.values()), "holds neither points nor cameras"),
            expected="ground points that are marked, or a perspective camera",
            remedy="Name the project that has them",
            file=file.source,
        )
    return Foreign(tables, crs, (*notes, *said), cameras, unusable)


def _parts(file):
    """The files of a project that are read, by format; notes."""
    given = read_json(file, file.source, EXPECTED)
    kind = given.get("format") if isinstance(given, dict) else None
    if kind != opf_parts.PROJECT:
        raise FileError(
            f"is no project, but {kind}" if isinstance(kind, str) else "is no project",
            expected="project.opf, which names the other files",
            remedy="Name the project.opf beside it",
            file=file.source,
        )
    try:
        paths = opf_parts.parts_of(given, file.path.parent)
    except ValueError as error:
        raise damaged(file.source, f"is no whole project: {error}", EXPECTED) from error
    except FAULTS as error:
        raise damaged(file.source, "has an item without files", EXPECTED) from error
    notes, parts = [], {}
    for kind, ones in paths.items():
        if len(ones) > 1:
            note = f"{file.source}: the last of {len(ones)} files is read: {kind}"
            notes.append(note)
        for path in ones[-1:]:  # errors say its name in the project
            name = path.relative_to(file.path.parent).as_posix()
            found = read_json(read_once(path, name), name, EXPECTED)
            if not isinstance(found, dict) or found.get("format") != kind:
                raise damaged(name, f"is not of the format {kind}", EXPECTED)
            parts[kind] = Part(found, name)
    return parts, notes


def _names_of_images(part):
    """Names of image files by the numbers of their cameras."""
    if part is None:
        return {}
    try:
        uris = {one["id"]: str(one["uri"]) for one in part.given["cameras"]}
    except FAULTS as error:
        found = "a camera of its list has no id or uri"
        raise damaged(part.source, found, EXPECTED) from error
    return dict(zip(uris, file_names(list(uris.values()), part.source), strict=True))


def _calibrations(parts):
    """Keys of camera.toml by the names of sensors; why others have none.

    Calibrated ones where the project has them, otherwise those with which it began.
    """
    part = parts.get(opf_parts.INPUT_CAMERAS)
    if part is None:
        return {}, {}
    inner = _calibrated(parts.get(opf_parts.CALIBRATED_CAMERAS))
    cameras, unusable = {}, {}
    try:
        n_called = Counter(str(one["name"]) for one in part.given["sensors"])
        for one in part.given["sensors"]:
            name = str(one["name"])
            name = f"{name} ({one['id']})" if n_called[name] > 1 else name
            own, source = inner.get(one["id"], (one["internals"], part.source))
            if own["type"] != KIND:
                said = f"{name} is a {own['type']} camera: its calibration is left out"
                unusable[name] = said
                continue
            pixels = _lengths(one, {"image_size_px": 2, PITCH: 1}, name, part.source)
            cameras[name] = _keys(own, pixels, name, source)
    except FAULTS as error:
        raise damaged(part.source, "a sensor lacks something", EXPECTED) from error
    return cameras, unusable


def _calibrated(part):
    """Calibrations by the numbers of their sensors, and the file in which they are."""
    if part is None:
        return {}
    try:
        found = part.given["sensors"]
        return {one["id"]: (one["internals"], part.source) for one in found}
    except FAULTS as error:
        raise damaged(part.source, "a sensor lacks something", EXPECTED) from error


def _lengths(given, keys, name, source):
    """Values of keys of a camera, all of them positive."""
    values = [v for key, n in keys.items() for v in _read(given, key, n, name, source)]
    if not min(values) > 0.0:
        raise damaged(source, f"camera {name} has a length that is none", EXPECTED)
    return values


def _keys(own, pixels, name, source):
    """Keys of a perspective camera, which distorts as OpenCV does."""
    (f,) = _lengths(own, {"focal_length_px": 1}, name, source)
    cx, cy = _read(own, "principal_point_px", 2, name, source)
    k1, k2, k3 = _read(own, "radial_distortion", 3, name, source)
    p1, p2 = _read(own, "tangential_distortion", 2, name, source)
    distortion = k1, k2, p1, p2, k3
    return corner_keys(f, f, cx, cy, pixels[:2], distortion, pixels[2])


def _read(given, key, n_numbers, name, source):
    """Numbers of a key; refused where they are others, or not as many.

    ``name``: of what has the key. One number may stand without brackets.
    """
    values = given[key] if isinstance(given[key], list) else [given[key]]
    wrong = [v for v in values if isinstance(v, bool) or not is_finite(str(v))]
    if wrong:
        said = shortened(str(wrong[0]))
        found = f"{key} of {name} is no number: {said!r}"
        raise damaged(source, found, EXPECTED)
    if len(values) != n_numbers:
        found = f"{key} of {name} has {len(values)} numbers instead of {n_numbers}"
        raise damaged(source, found, EXPECTED)
    return [float(value) for value in values]


def _system_of_frame(part):
    """Code of the system in which the project was computed; None of a local one."""
    if part is None:
        return None
    try:
        return code_on_earth(str(part.given["crs"]["definition"]))
    except FAULTS as error:
        raise damaged(part.source, "its system has no definition", EXPECTED) from error


def _markers(part, names):
    """Points and marks, with the system of the points."""
    try:
        points, errors, systems = _points(part)
        rows, unlisted = _marks(part, names)
        crs, notes = _one_system(systems, part.source)
    except FAULTS as error:
        found = "a control point lacks something"
        raise damaged(part.source, found, EXPECTED) from error
    if unlisted:
        said = kept("{n:image|images}", n=len(unlisted))
        some = name_some(unlisted, 4)
        notes.append(
            f"{part.source}: {said} of no camera list, called by number: {some}"
        )
    points = _usual_axes(points, crs)
    read = markers_of(points, rows, crs, notes, part.source)
    return _with_accuracies(read, errors, part.source)


def _points(part):
    """Name, coordinates and role of each point; its accuracies; systems by code."""
    points, errors, systems = [], [], {}
    for one in part.given["gcps"]:
        place, name = one["geolocation"], str(one["id"])
        given = place["crs"]
        systems[code_on_earth(str(given["definition"]))] = given
        xyz = _read(place, "coordinates", 3, name, part.source)
        role = "check" if one["is_checkpoint"] else "control"
        points.append((name, *xyz, role))
        errors.append(_read(place, "sigmas", 3, name, part.source))
    return points, errors, systems


def _marks(part, names):
    """Image, point, x and y of each mark; numbers of images that no list has."""
    rows, unlisted = [], {}
    for one in (*part.given["gcps"], *part.given["mtps"]):
        for mark in one["marks"]:
            number, name = mark["camera_id"], str(one["id"])
            image = names.get(number, str(number))
            unlisted |= {} if number in names else {image: None}
            xy = _read(mark, "position_px", 2, name, part.source)
            rows.append((image, name, *xy))
    return rows, list(unlisted)


def _one_system(systems, source):
    """The system of all points, and notes on it and on their heights."""
    if len(systems) > 1:
        said = name_some((one or "a local one" for one in systems), 4)
        raise FileError(
            f"has points in several systems: {said}",
            expected="ground points in one system",
            remedy="Export the project with its points in one system",
            file=source,
        )
    crs, given = next(iter(systems.items()), (None, None))
    if given is None:
        return None, []
    if crs is None:
        return None, [f"{source}: the system of its points is unknown or local"]
    notes = []
    if len(read_source_crs(crs).axis_info) < 3:
        notes.append(f"{source}: heights are above the ellipsoid: {crs} has no others")
    if given.get("geoid_height") is not None:
        (above,) = _read(given, "geoid_height", 1, crs, source)
        notes.append(
            f"{source}: heights are above a surface {above:g} m over the ellipsoid"
        )
    return crs, notes


def _usual_axes(points, crs):
    """The points with their easting or longitude first, whatever their system says."""
    if crs is None or read_source_crs(crs).axis_info[0].direction == "east":
        return points
    return [(name, y, x, z, role) for name, x, y, z, role in points]


def _with_accuracies(read, errors, source):
    """Markers with the standard errors that the project states, positive ones."""
    sigmas = np.array(errors, dtype=float).reshape(-1, 3)
    sigmas = np.where(sigmas > 0.0, sigmas, np.nan)
    rows = [(in_plan(np.nan, east, north), up) for east, north, up in sigmas]
    stated = pd.DataFrame(rows, columns=list(ERRORS), dtype=float)
    known, said = with_errors(read.points.join(stated), source)
    return replace(read, points=known, notes=(*read.notes, *said))


def _orientations(parts, names, source):
    """Table of the calibrated images; None where there is none; notes."""
    part = parts.get(opf_parts.CALIBRATED_CAMERAS)
    if part is None or not part.given.get("cameras"):
        return None, []
    try:
        listed = part.given["cameras"]
        images = [names.get(one["id"], str(one["id"])) for one in listed]
        of_image = list(zip(listed, images, strict=True))
        places, angles = (
            [_read(one, key, 3, image, part.source) for one, image in of_image]
            for key in ("position", "orientation_deg")
        )
    except FAULTS as error:
        found = "an image lacks its orientation"
        raise damaged(part.source, found, EXPECTED) from error
    frame = parts.get(opf_parts.FRAME)
    notes = []
    if frame is None:
        notes.append(f"{source}: orientations in the frame of the calibration")
    else:
        places = _on_the_ground(np.array(places), frame)
    return orientations(images, places, np.radians(angles)), notes


def _on_the_ground(places, frame):
    """Positions (n, 3) without the shift with which the project computes."""
    try:
        way = frame.given["base_to_canonical"]
        shift, scale = (
            np.array(_read(way, key, 3, "base_to_canonical", frame.source))
            for key in ("shift", "scale")
        )
        scale = scale[[1, 0, 2]] if way["swap_xy"] else scale
    except FAULTS as error:
        found = "its base_to_canonical lacks something"
        raise damaged(frame.source, found, EXPECTED) from error
    if (scale == 0.0).any():
        raise damaged(frame.source, "its scale is 0", EXPECTED)
    return (places - shift) / scale
