"""Cameras of OpenSfM and OpenDroneMap as JSON: calibrations, orientations of images.

``camera_models.json`` and ODM's ``cameras.json`` have calibrations by name,
``reconstruction.json`` also the images that were oriented with them. OpenSfM counts
from the middle of the image in units of its longer side; as its own program makes
pixels of them, the centre of the first pixel is (0, 0).
"""

import numpy as np
from scipy.spatial.transform import Rotation

from einschalt.foundations.errors import FileError
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.rotations import angles_from_rotation
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.opensfm_images import NO_RECONSTRUCTION, json_of
from einschalt.interfaces.programs.foreign import (
    TURNED,
    Foreign,
    is_finite,
    orientations,
)
from einschalt.interfaces.programs.pixel_cameras import centre_keys, without_pitch

EXPECTED = "cameras as OpenSfM writes them"
# what each kind of camera has: focal lengths, then the names of the coefficients in the
# order of OpenCV; empty where it has none of that name
KINDS = {
    "perspective": (("focal", "focal"), ("k1", "k2", "", "", "")),
    "simple_radial": (("focal_x", "focal_y"), ("k1", "", "", "", "")),
    "radial": (("focal_x", "focal_y"), ("k1", "k2", "", "", "")),
    "brown": (("focal_x", "focal_y"), ("k1", "k2", "p1", "p2", "k3")),
}
# what a camera may have that is no part of its kind: all of them distort
TERMS = (
    *("k1", "k2", "k3", "k4", "k5", "k6"),
    *("p1", "p2", "p3", "p4", "s0", "s1", "s2", "s3"),
)


def is_cameras(head):
    """Whether the first bytes of a file look so."""
    return b'"projection_type"' in head


def read_cameras(file) -> Foreign:
    """Read the calibrations, and the orientations where there are such."""
    given = json_of(file, file.source)
    parts = given if isinstance(given, list) else [{"cameras": given}]
    keys, unusable, oriented = {}, {}, []
    try:
        for part in parts:
            _add_cameras(part["cameras"], keys, unusable, file.source)
            oriented += part.get("shots", {}).items()
        table = _orientations(oriented, file.source)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise damaged(file.source, NO_RECONSTRUCTION, EXPECTED) from error
    notes = []
    if table is not None:
        notes.append(f"{file.source}: orientations in the reconstruction's own frame")
    if len(parts) > 1:
        said = kept("{n:reconstruction|reconstructions}", n=len(parts))
        notes.append(f"{file.source}: {said}, each with a frame of its own")
    notes += [*unusable.values(), *without_pitch(keys, file.source)]
    tables = {} if table is None else {"orientations": table}
    if not (keys or tables):
        raise FileError(
            next(iter(unusable.values()), "holds no camera"),
            expected=EXPECTED,
            remedy="Name the file that has them",
            file=file.source,
        )
    return Foreign(tables, None, tuple(notes), keys, unusable)


def _add_cameras(cameras, keys, unusable, source):
    """Add the keys of camera.toml by name, and what keeps others from being used."""
    for name, camera in cameras.items():
        kind = camera["projection_type"]
        if kind not in KINDS:
            unusable[name] = (
                f"camera {name} is of the kind {kind}: its calibration is left out"
            )
            continue
        known = KINDS[kind][1]
        more = [t for t in TERMS if t not in known and camera.get(t, 0.0) != 0.0]
        if more:
            unusable[name] = (
                f"camera {name} of the kind {kind} has a term {' and '.join(more)}: "
                "its calibration is left out"
            )
            continue
        keys[name] = _keys(camera, KINDS[kind], f"camera {name}", source)


def _keys(camera, kind, said, source):
    """Keys of a camera, whose lengths are multiples of the longer side of the image."""
    focal, coefficients = kind
    needed = dict.fromkeys(("width", "height", *focal))
    optional = dict.fromkeys(("c_x", "c_y", *filter(None, coefficients)), 0.0)
    numbers = {}
    for name, otherwise in (needed | optional).items():
        value = camera.get(name, otherwise)
        if isinstance(value, bool) or not is_finite(str(value)):
            raise damaged(source, f"the {name} of {said} is no number", EXPECTED)
        numbers[name] = float(value)
    width, height = numbers["width"], numbers["height"]
    if not min(width, height) >= 1.0:
        raise damaged(source, f"the size of {said} is {width:g} x {height:g}", EXPECTED)
    side = max(width, height)
    fx, fy = (side * numbers[name] for name in focal)
    cx = side * numbers["c_x"] + 0.5 * (width - 1.0)
    cy = side * numbers["c_y"] + 0.5 * (height - 1.0)
    distortion = [numbers[name] if name else 0.0 for name in coefficients]
    return centre_keys(fx, fy, cx, cy, distortion)


def _orientations(shots, source):
    """Table of images and their shots; None where there is none."""
    if not shots:
        return None
    values = [[*shot["translation"], *shot["rotation"]] for _, shot in shots]
    numbers = np.array(values, dtype=float)
    if numbers.shape != (len(shots), 6) or not np.isfinite(numbers).all():
        raise damaged(source, "an orientation of an image is not six numbers", EXPECTED)
    turn = Rotation.from_rotvec(numbers[:, 3:]).as_matrix()
    centres = -np.einsum("nji,nj->ni", turn, numbers[:, :3])
    angles = angles_from_rotation(TURNED @ turn)
    return orientations([name for name, _ in shots], centres, angles)
