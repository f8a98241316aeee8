"""``…_calibrated_camera_parameters.txt`` of Pix4D: cameras as they were optimised.

Ten lines for each image: its name and size, K (3 x 3), three radial and two tangential
coefficients, the position t, the rotation R (3 x 3), with m = K R (X - t). Positions
are relative to ``…_offset.xyz`` beside it. Images of one camera have the same numbers.
"""

import numpy as np

from einschalt.foundations.display_names import shortened
from einschalt.foundations.rotations import angles_from_rotation, are_rotations
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.input_files import is_there, read_once
from einschalt.interfaces.programs.foreign import (
    TURNED,
    Foreign,
    is_finite,
    lines_of,
    numbers_of,
    orientations,
    require_rows,
)
from einschalt.interfaces.programs.pixel_cameras import corner_keys, without_pitch

MARK = "camera matrix K [3x3]"
N_HEADINGS = 7
EXPECTED = "ten lines for each image, as Pix4Dmapper writes them"
LARGEST_SKEW = 1e-9  # of the focal length
# how many numbers stand in each of the lines of an image
WIDTHS = (2, 3, 3, 3, 3, 2, 3, 3, 3, 3)
PARAMETERS, OFFSET = "_calibrated_camera_parameters.txt", "_offset.xyz"


def is_parameters(head):
    """Whether the first bytes of a file look so."""
    return MARK.encode() in head


def read_parameters(file) -> Foreign:
    """Read the calibrations, and the orientation of each image."""
    lines = lines_of(file)[N_HEADINGS:]
    require_rows(lines, file.source, EXPECTED)
    n_images, rest = divmod(len(lines), len(WIDTHS))
    if rest:
        found = f"holds {len(lines)} lines after its headings: it is cut off"
        raise damaged(file.source, found, EXPECTED, lines[-1].row)
    names = [" ".join(line.words[:-2]) for line in lines[:: len(WIDTHS)]]
    unnamed = [k for k, name in enumerate(names) if not name]
    if unnamed:
        line = lines[len(WIDTHS) * unnamed[0]]
        found = f"{shortened(line.text)!r} is no name and size of an image"
        raise damaged(file.source, found, EXPECTED, line.row)
    size, k_matrix, outer, place, turn = _numbers(lines, n_images, file.source)
    _require_right_angles(k_matrix, lines, file.source)
    own = np.column_stack([size, k_matrix[:, 0], k_matrix[:, 1], outer])
    distinct, number = np.unique(own, axis=0, return_inverse=True)
    keys = {str(k): _keys(one) for k, one in enumerate(distinct, 1)}
    offset, notes = _offset(file)
    notes += without_pitch(keys, file.source)
    if not are_rotations(turn, 1e-6).all():
        raise damaged(file.source, "the R of an image is no rotation", EXPECTED)
    oriented = orientations(
        names,
        place + offset,
        angles_from_rotation(TURNED @ turn),
        camera=[str(1 + k) for k in number.ravel()],
    )
    return Foreign({"orientations": oriented}, None, tuple(notes), keys)


def _numbers(lines, n_images, source):
    """Sizes (n, 2), K (n, 3, 3), coefficients (n, 5), positions (n, 3), R (n, 3, 3)."""
    for k, line in enumerate(lines):
        width, words = WIDTHS[k % len(WIDTHS)], line.words
        is_named = k % len(WIDTHS) == 0
        is_whole = len(words) > width if is_named else len(words) == width
        if not is_whole or not all(map(is_finite, words[-width:])):
            found = f"{shortened(line.text, 60)!r} cannot be read"
            raise damaged(source, found, EXPECTED, line.row)
    parts = [
        [float(word) for word in line.words[-WIDTHS[k % len(WIDTHS)] :]]
        for k, line in enumerate(lines)
    ]
    flat = np.array([value for part in parts for value in part])
    of_image = flat.reshape(n_images, sum(WIDTHS))
    size, k_matrix, radial, tangential, place, turn = np.split(
        of_image, [2, 11, 14, 16, 19], axis=1
    )
    outer = np.column_stack([radial[:, :2], tangential, radial[:, 2]])
    matrices = [one.reshape(-1, 3, 3) for one in (k_matrix, turn)]
    return size, matrices[0], outer, place, matrices[1]


def _keys(numbers):
    """Keys of a camera: its size, two rows of K, coefficients as OpenCV has them."""
    size, (fx, _, cx, _, fy, cy), outer = np.split(numbers, [2, 8])
    return corner_keys(fx, fy, cx, cy, size, [float(value) for value in outer])


def _require_right_angles(k_matrix, lines, source):
    """Refuse pixels that are no rectangles: no camera here has a skew."""
    skew = np.abs(k_matrix[:, 0, 1]) / np.abs(k_matrix[:, 0, 0])
    if (skew > LARGEST_SKEW).any():
        image = int(np.argmax(skew > LARGEST_SKEW))
        found = f"K has a skew of {k_matrix[image, 0, 1]:g}"
        line = lines[len(WIDTHS) * image + 1]
        raise damaged(source, found, "0, as Pix4Dmapper writes it", line.row)


def _offset(file):
    """What positions are relative to, (3,), from the file beside; notes."""
    stem = file.path.name.removesuffix(PARAMETERS)
    beside = file.path.with_name(f"{stem}{OFFSET}")
    if stem == file.path.name or not is_there(beside):
        return np.zeros(3), [f"{file.source}: orientations relative to …{OFFSET}"]
    lines = lines_of(read_once(beside, beside.name))
    require_rows(lines, beside.name, "x y z")
    return numbers_of(lines[:1], beside.name, 0, 3, "x y z")[0], []
