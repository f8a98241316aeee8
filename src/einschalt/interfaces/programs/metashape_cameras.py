"""Cameras of Metashape and PhotoScan as XML: calibrations, orientations of a chunk.

A calibration becomes a camera.toml of the convention ``metashape``, in which it stands
as it is. PhotoScan before 1.2 had fx and fy, a principal point from the corner of the
image and p1 and p2 the other way round; these are brought into it. Orientations are
those of the chunk's own frame, which is of no size and nowhere on the Earth unless the
chunk has a transform. Exported markers come with the sensors of their images, so that
their measurements are read beside the calibrations.
"""

from collections import Counter

import numpy as np

from einschalt.foundations.errors import FileError, name_some
from einschalt.foundations.rotations import angles_from_rotation, are_rotations
from einschalt.interfaces.files import metashape_markers
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.plain_xml import child, each, local, read_xml, text_of
from einschalt.interfaces.programs.foreign import (
    TURNED,
    Foreign,
    is_finite,
    orientations,
)

EXPECTED = "cameras as Metashape exports them: sensors with calibrations"
KEYS = ("f", "cx", "cy", "b1", "b2", "k1", "k2", "k3", "k4", "p1", "p2")
OLDER = ("fx", "fy", "skew")
UNKNOWN = ("k5", "k6", "p3", "p4")  # of no camera of the project


def is_cameras(head):
    """Whether the first bytes of a file look so."""
    # the calibrations may stand behind many bands and properties of their sensors
    is_chunk = b"<chunk" in head and (b"<sensors" in head or b"<calibration" in head)
    is_oldest = b"<collection" in head and b"<cameras" in head
    return (
        is_chunk or is_oldest or (b"<calibration>" in head and b"<projection>" in head)
    )


def read_cameras(file) -> Foreign:
    """Read the calibrations of sensors, orientations of cameras, and markers."""
    root = read_xml(file.data, file.source, EXPECTED)
    if local(root) == "collection":
        raise FileError(
            "is a list of cameras of the first versions of PhotoScan (<collection>), "
            "whose axes and signs are described nowhere",
            expected=EXPECTED,
            remedy="Open the project in a later version of PhotoScan or Metashape, and "
            "export its cameras and its markers again, each as XML",
            file=file.source,
        )
    cameras, unusable = _calibrations(root, file)
    oriented, notes = _orientations(root, file.source)
    notes = [f"{file.source}: {said}" for said in unusable.values()] + notes
    tables = {"orientations": oriented} if oriented is not None else {}
    if next(iter(each(root, "marker")), None) is None:
        if not (cameras or tables):
            raise no_camera(unusable, file.source)
        return Foreign(tables, None, tuple(notes), cameras, unusable)
    markers = metashape_markers.read_metashape(file, file.source)
    found = markers.tables()
    tables |= {name: table for name, table in found.items() if len(table)}
    notes = tuple(dict.fromkeys((*notes, *markers.notes)))
    return Foreign(tables, markers.crs, notes, cameras, unusable)


def no_camera(unusable, source):
    """FileError of a file none of whose calibrations can be used."""
    if not unusable:
        return damaged(source, "holds no calibration", EXPECTED)
    return FileError(
        next(iter(unusable.values())),
        expected="a frame camera with k1 to k4, p1, p2, b1 and b2 at most",
        remedy="Optimise it so, or export undistorted images with their calibration",
        file=source,
    )


def _calibrations(root, file):
    """Keys of camera.toml by the names of sensors; what keeps others from being used.

    Two sensors may have one name, as two flights with one camera have.
    """
    if local(root) == "calibration":  # saved alone
        sensors = [(root, [root], file.path.stem)]
    else:
        sensors = [
            (one, found, one.get("label") or one.get("id") or str(k))
            for k, one in enumerate(each(root, "sensor"))
            if (found := [part for part in one if part.tag == "calibration"])
        ]
    n_called = Counter(name for *_, name in sensors)
    cameras, unusable = {}, {}
    for sensor, found, label in sensors:
        is_shared = n_called[label] > 1
        name = f"{label} ({sensor.get('id')})" if is_shared else label
        adjusted = [one for one in found if one.get("class") == "adjusted"]
        calibration = (adjusted or found)[0]
        said = _unusable(calibration, name)
        if said:
            unusable[name] = said
        else:
            cameras[name] = _camera(sensor, calibration, name, file.source)
    return cameras, unusable


def _unusable(calibration, name):
    """What keeps a calibration from being used; empty where nothing does."""
    kind = calibration.get("type") or text_of(calibration, "projection") or "frame"
    if kind != "frame":
        return f"sensor {name} is a {kind} camera: its calibration is left out"
    words = {key: text_of(calibration, key) for key in UNKNOWN}
    more = [k for k, w in words.items() if w and (not is_finite(w) or float(w))]
    if more:
        terms = " and ".join(more)
        return f"sensor {name} has a term {terms}: its calibration is left out"
    return ""


def _camera(sensor, calibration, name, source):
    """Keys of camera.toml."""
    size = child(calibration, "resolution")
    size = child(sensor, "resolution") if size is None else size
    if size is None:  # calibrations saved alone, and the oldest, have elements for it
        wide, high = text_of(calibration, "width"), text_of(calibration, "height")
    else:
        wide, high = size.get("width"), size.get("height")
    pixel = next(
        (p for p in each(sensor, "property") if p.get("name") == "pixel_width"), None
    )
    pixel_mm = "" if pixel is None else pixel.get("value", "")
    words = {key: text_of(calibration, key) for key in (*KEYS, *OLDER)}
    given = {key: word for key, word in words.items() if word}
    needed = {"f": given.get("f") or given.get("fy", "")}
    needed |= {"width": wide, "height": high, **given}
    wrong = [key for key, word in needed.items() if not (word and is_finite(word))]
    if wrong:
        found = f"the {wrong[0]} of sensor {name} is no number"
        raise damaged(source, found, EXPECTED)
    size = {"width": int(float(wide)), "height": int(float(high))}
    keys = {key: float(word) for key, word in given.items()}
    keys = (keys if "f" in keys else _as_of_today(keys, **size)) | size
    if is_finite(pixel_mm) and float(pixel_mm) > 0.0:
        keys["pixel_size_um"] = 1e3 * float(pixel_mm)
    return {"convention": "metashape", **keys}


def _as_of_today(old, width, height):
    """Constants of PhotoScan before 1.2 in the names and signs of later versions.

    F = fy, B1 = fx - fy and B2 = skew are Agisoft's own answer to the question
    (forum, topic 6437); the older formula there has P2 beside r² + 2x².
    """
    keys = {key: value for key, value in old.items() if key not in OLDER}
    keys["f"] = old["fy"]
    keys["b1"] = old.get("fx", old["fy"]) - old["fy"]
    keys["b2"] = old.get("skew", 0.0)
    keys["cx"] = old.get("cx", width / 2) - width / 2
    keys["cy"] = old.get("cy", height / 2) - height / 2
    keys["p1"], keys["p2"] = old.get("p2", 0.0), old.get("p1", 0.0)
    return keys


def _orientations(root, source):
    """Orientations of the cameras that are aligned, None where there is none; notes."""
    cameras = list(each(root, "camera"))
    called, notes = metashape_markers.images_of(cameras, source)
    notes += _note_on_slaves(cameras, source)
    names, matrices, components = [], [], set()
    for camera, label in zip(cameras, called, strict=True):
        name = label or camera.get("id")
        words = text_of(camera, "transform").split()
        if not words:
            continue
        if len(words) != 16 or not all(map(is_finite, words)):
            found = f"the transform of camera {name} is not 16 numbers"
            raise damaged(source, found, EXPECTED)
        names.append(name)
        matrices.append([float(word) for word in words])
        components.add(camera.get("component_id"))
    if not names:
        return None, []
    matrices = np.array(matrices).reshape(-1, 4, 4)
    turn = np.swapaxes(matrices[:, :3, :3], 1, 2)
    if not are_rotations(turn, 1e-6).all():
        raise damaged(source, "the transform of a camera is no rotation", EXPECTED)
    notes.append(f"{source}: orientations in the chunk's own frame")
    if len(components) > 1:
        n = len(components)
        notes.append(f"{source}: {n} components, each with a frame of its own")
    angles = angles_from_rotation(TURNED @ turn)
    return orientations(names, matrices[:, :3, 3], angles), notes


def _note_on_slaves(cameras, source):
    """Name the cameras of a rig that are placed by their master alone."""
    slaves = [c for c in cameras if c.get("master_id") and not text_of(c, "transform")]
    if not slaves:
        return []
    named = name_some([c.get("label") or c.get("id") for c in slaves])
    note = (
        f"{source}: cameras of a rig have the orientation of their master, and none of "
        f"their own; left out: {named}"
    )
    return [note]
