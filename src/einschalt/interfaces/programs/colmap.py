"""Models of COLMAP as text: cameras.txt, images.txt and points3D.txt of a folder.

Pixels are counted as COLMAP does, the middle of the first one being (0.5, 0.5). Ground
coordinates are those of the model, which is of no size unless it was aligned.
"""

import re
from pathlib import Path

import numpy as np
import pandas as pd

from einschalt.foundations.rotations import angles_from_rotation
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.input_files import read_once
from einschalt.interfaces.files.text_encodings import read_table_text
from einschalt.interfaces.programs.foreign import (
    TURNED,
    Foreign,
    Line,
    is_finite,
    numbers_of,
    orientations,
    points_in_images,
)
from einschalt.interfaces.programs.pixel_cameras import corner_keys, without_pitch

FILES = ("cameras.txt", "images.txt", "points3D.txt")
COUNT = re.compile(r"#\s*Number of (\w+):\s*(\d+)")
CAMERA = "CAMERA_ID MODEL WIDTH HEIGHT PARAMS"
IMAGE = "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then X Y POINT3D_ID …"
POINT = "POINT3D_ID X Y Z R G B ERROR, then IMAGE_ID POINT2D_IDX …"
PARAMETERS = {
    "SIMPLE_PINHOLE": 3,
    "PINHOLE": 4,
    "SIMPLE_RADIAL": 4,
    "RADIAL": 5,
    "OPENCV": 8,
    "OPENCV_FISHEYE": 8,
    "FULL_OPENCV": 12,
    "FOV": 5,
    "SIMPLE_RADIAL_FISHEYE": 4,
    "RADIAL_FISHEYE": 5,
    "THIN_PRISM_FISHEYE": 12,
}
# places of fx, fy, cx, cy among the parameters, and of k1, k2, p1, p2, k3
FRAMES = {
    "SIMPLE_PINHOLE": ((0, 0, 1, 2), ()),
    "PINHOLE": ((0, 1, 2, 3), ()),
    "SIMPLE_RADIAL": ((0, 0, 1, 2), (3,)),
    "RADIAL": ((0, 0, 1, 2), (3, 4)),
    "OPENCV": ((0, 1, 2, 3), (4, 5, 6, 7)),
    "FULL_OPENCV": ((0, 1, 2, 3), (4, 5, 6, 7, 8)),
}
LARGEST_SIDE = 1e6  # pixels
RATIONAL = slice(9, 12)  # k4 to k6 of FULL_OPENCV, of no camera of the project


def is_model(folder):
    """Whether a folder holds a model as text."""
    return all((Path(folder) / name).is_file() for name in FILES[:2])


def read_model(folder) -> Foreign:
    """Read cameras, orientations, image points that belong to points, and points."""
    folder = Path(folder)
    files = [folder / name for name in FILES if (folder / name).is_file()]
    parts = {path.name: _lines(read_once(path, path.name)) for path in files}
    cameras = _cameras(*parts["cameras.txt"])
    oriented, measured, notes = _images(*parts["images.txt"], set(cameras["camera"]))
    tables = {"cameras": cameras, "orientations": oriented, "image_points": measured}
    keys, unusable = _keys(cameras)
    notes += list(unusable.values()) + without_pitch(keys, "cameras.txt")
    if "points3D.txt" in parts:
        tables["object_points"] = _points(*parts["points3D.txt"])
    notes.append("coordinates of COLMAP's own model, pixels from its corner")
    return Foreign(tables, None, tuple(notes), keys, unusable)


def _keys(cameras):
    """Keys of camera.toml by camera; what keeps others from being used."""
    keys, unusable = {}, {}
    columns = ("camera", "model", "width", "height", "parameters")
    for name, model, width, height, said in cameras[list(columns)].itertuples(
        index=False
    ):
        values = [float(word) for word in said.split()]
        if model not in FRAMES or any(values[RATIONAL]):
            unusable[name] = (
                f"cameras.txt: camera {name} is of the model {model}, its calibration "
                "is left out"
            )
            continue
        inner, outer = FRAMES[model]
        fx, fy, cx, cy = (values[k] for k in inner)
        distortion = [values[k] for k in outer]
        keys[name] = corner_keys(fx, fy, cx, cy, (width, height), distortion)
    return keys, unusable


def _lines(file):
    """Lines that are no comments, empty ones too, and how many things are announced."""
    text = read_table_text(file, file.source)[0].decode("utf-8")
    lines, announced = [], None
    for row, line in enumerate(text.splitlines(), 1):
        if not line.startswith("#"):
            lines.append(Line(row, line.split(), line))
        elif announced is None and COUNT.search(line):
            announced = int(COUNT.search(line)[2])
    while lines and not lines[-1].words and len(lines) % 2:
        lines.pop()
    return lines, announced, file.source


def _require_count(found, announced, what, source, last):
    if announced is not None and found != announced:
        text = f"holds {found} {what}, and announces {announced}: it is cut off"
        raise damaged(source, text, row=last)


def _cameras(lines, announced, source):
    lines = [line for line in lines if line.words]
    _require_count(len(lines), announced, "cameras", source, _last(lines))
    size = numbers_of(lines, source, 2, 4, CAMERA)
    for line, (width, height) in zip(lines, size, strict=True):
        if not (min(width, height) >= 1.0 and max(width, height) <= LARGEST_SIDE):
            name = f"camera {line.words[0]}"
            found = f"the size of {name} is {width:g} x {height:g}"
            raise damaged(source, found, CAMERA, line.row)
        count = PARAMETERS.get(line.words[1], len(line.words) - 4)
        if len(line.words) != 4 + count or not all(map(is_finite, line.words[4:])):
            found = f"camera {line.words[0]} has {len(line.words) - 4} parameters"
            said = f"{count} numbers, as {line.words[1]} has"
            raise damaged(source, found, said, line.row)
    columns = {
        "camera": [line.words[0] for line in lines],
        "model": [line.words[1] for line in lines],
        "width": size[:, 0],
        "height": size[:, 1],
        "parameters": [" ".join(line.words[4:]) for line in lines],
    }
    return pd.DataFrame(columns)


def _last(lines):
    return lines[-1].row if lines else None


def _images(lines, announced, source, cameras):
    heads, bodies = lines[::2], lines[1::2]
    if len(heads) == len(bodies) + 1:  # the last image has no points
        bodies = [*bodies, Line(heads[-1].row, [], "")]
    pose = numbers_of(heads, source, 1, 8, IMAGE)
    _require_count(len(heads), announced, "images", source, _last(lines))
    names = []
    for line in heads:
        if len(line.words) < 10 or line.words[8] not in cameras:
            found = f"{line.text[:60]!r} names no camera of cameras.txt, or no image"
            raise damaged(source, found, IMAGE, line.row)
        names.append(" ".join(line.words[9:]))
    turn = _rotations(pose[:, :4])
    centres = -np.einsum("nji,nj->ni", turn, pose[:, 4:])
    angles = angles_from_rotation(TURNED @ turn)
    camera = [line.words[8] for line in heads]
    oriented = orientations(names, centres, angles, camera=camera)
    measured, n_alone = _measured(names, bodies, source)
    notes = [f"{n_alone} image points without a point left out"] if n_alone else []
    return oriented, measured, notes


def _rotations(quaternions):
    """Matrices of quaternions w, x, y, z, from the world to the camera."""
    w, x, y, z = (quaternions / np.linalg.norm(quaternions, axis=1)[:, None]).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def _measured(names, bodies, source):
    """Image points that belong to a point, and how many do not."""
    images, points, places, n_alone = [], [], [], 0
    for name, line in zip(names, bodies, strict=True):
        words = line.words
        if len(words) % 3 or not all(map(is_finite, words)):
            found = f"the points of image {name} are no triples X Y POINT3D_ID"
            raise damaged(source, found, IMAGE, line.row)
        ids = words[2::3]
        xy = np.array(words, dtype=float).reshape(-1, 3)[:, :2]
        is_known = np.array([one != "-1" for one in ids], dtype=bool)
        n_alone += int((~is_known).sum())
        kept = [one for one in ids if one != "-1"]
        images += [name] * len(kept)
        points += kept
        places.append(xy[is_known])
    xy = np.concatenate(places) if places else np.empty((0, 2))
    return points_in_images(images, points, xy), n_alone


def _points(lines, announced, source):
    lines = [line for line in lines if line.words]
    _require_count(len(lines), announced, "points", source, _last(lines))
    values = numbers_of(lines, source, 1, 8, POINT)
    table = pd.DataFrame({"point_id": [line.words[0] for line in lines]})
    table[["x", "y", "z"]] = values[:, :3]
    n_seen = [(len(line.words) - 8) // 2 for line in lines]
    return table.assign(reprojection_error_px=values[:, 6], n_measurements=n_seen)
