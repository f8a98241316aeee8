"""Cameras of Metashape as XML: calibrations, and orientations of a chunk.

A calibration becomes a camera.toml of the convention ``metashape``, in which it stands
as it is. Orientations are those of the chunk's own frame, which is of no size and
nowhere on the Earth unless the chunk has a transform. Exported markers come with the
sensors of their images, so that their measurements are read beside the calibrations.
"""

import numpy as np

from einschalt.foundations.rotations import angles_from_rotation, are_rotations
from einschalt.interfaces.files import marker_files
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.plain_xml import child, each, read_xml, text_of
from einschalt.interfaces.programs.foreign import (
    Foreign,
    is_finite,
    orientations,
)

EXPECTED = "cameras as Metashape exports them: sensors with calibrations"
KEYS = ("f", "cx", "cy", "b1", "b2", "k1", "k2", "k3", "k4", "p1", "p2")
# a camera of the project looks along -z with y up, one of Metashape along z
TURNED = np.diag([1.0, -1.0, -1.0])


def is_cameras(head):
    """Whether the first bytes of a file look so."""
    return b"<chunk" in head and b"<calibration" in head


def read_cameras(file) -> Foreign:
    """Read the calibrations of sensors, orientations of cameras, and markers."""
    root = read_xml(file.data, file.source, EXPECTED)
    cameras = {}
    for sensor in each(root, "sensor"):
        found = [one for one in sensor if one.tag == "calibration"]
        if found:
            adjusted = [one for one in found if one.get("class") == "adjusted"]
            name = sensor.get("label") or sensor.get("id") or str(len(cameras))
            cameras[name] = _camera(sensor, (adjusted or found)[0], name, file.source)
    if not cameras:
        raise damaged(file.source, "holds no calibration", EXPECTED)
    oriented = _orientations(root, file.source)
    tables = {"orientations": oriented} if oriented is not None else {}
    said = f"{file.source}: orientations in the chunk's own frame"
    notes = (said,) if tables else ()
    if next(iter(each(root, "marker")), None) is None:
        return Foreign(tables, None, notes, cameras)
    markers = marker_files.read_metashape(file, file.source)
    found = markers.tables()
    tables |= {name: table for name, table in found.items() if len(table)}
    return Foreign(tables, markers.crs, (*notes, *markers.notes), cameras)


def _camera(sensor, calibration, name, source):
    """Keys of camera.toml."""
    if calibration.get("type", "frame") != "frame":
        found = f"sensor {name} is a {calibration.get('type')} camera"
        raise damaged(source, found, "frame cameras")
    size = child(calibration, "resolution")
    size = child(sensor, "resolution") if size is None else size
    pixel = next(
        (p for p in each(sensor, "property") if p.get("name") == "pixel_width"), None
    )
    pixel_mm = "" if pixel is None else pixel.get("value", "")
    words = {key: text_of(calibration, key) for key in KEYS}
    words["f"] = words["f"] or text_of(calibration, "fx")
    given = {key: word for key, word in words.items() if word}
    wide, high = ("", "") if size is None else (size.get("width"), size.get("height"))
    needed = {"f": given.get("f", ""), "width": wide, "height": high, **given}
    wrong = [key for key, word in needed.items() if not (word and is_finite(word))]
    if wrong:
        found = f"the {wrong[0]} of sensor {name} is no number"
        raise damaged(source, found, EXPECTED)
    keys = {key: float(word) for key, word in given.items()}
    keys |= {"width": int(float(wide)), "height": int(float(high))}
    if is_finite(pixel_mm) and float(pixel_mm) > 0.0:
        keys["pixel_size_um"] = 1e3 * float(pixel_mm)
    return {"convention": "metashape", **keys}


def _orientations(root, source):
    """Orientations of the cameras that are aligned; None where there is none."""
    names, matrices = [], []
    for camera in each(root, "camera"):
        words = text_of(camera, "transform").split()
        if not words:
            continue
        name = camera.get("label") or camera.get("id")
        if len(words) != 16 or not all(map(is_finite, words)):
            found = f"the transform of camera {name} is not 16 numbers"
            raise damaged(source, found, EXPECTED)
        names.append(name)
        matrices.append([float(word) for word in words])
    if not names:
        return None
    matrices = np.array(matrices).reshape(-1, 4, 4)
    turn = np.swapaxes(matrices[:, :3, :3], 1, 2)
    if not are_rotations(turn, 1e-6).all():
        raise damaged(source, "the transform of a camera is no rotation", EXPECTED)
    return orientations(names, matrices[:, :3, 3], angles_from_rotation(TURNED @ turn))
