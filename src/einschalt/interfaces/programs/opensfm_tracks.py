"""Tracks of OpenSfM: points that it found itself in several images.

``tracks.csv`` counts from the middle of an image in units of its longer side; the
sizes stand in ``reconstruction*.json`` beside it.
"""

import numpy as np
import pandas as pd

from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.input_files import companions
from einschalt.interfaces.files.opensfm_images import image_sizes, require_sizes
from einschalt.interfaces.programs.foreign import Foreign, lines_of, numbers_of

VERSION = b"OPENSFM_TRACKS_VERSION_v"
KNOWN = ("1", "2")
EXPECTED = "image, track, feature, x y in units of the longer side, parted by tabs"


def is_tracks(head):
    """Whether the first bytes of a file look so."""
    return head.startswith(VERSION)


def read_tracks(file) -> Foreign:
    """Read image points, in pixels from the upper left corner."""
    first, *lines = lines_of(file, comments=(), separator="\t")
    version = first.text.removeprefix(VERSION.decode())
    if version not in KNOWN:
        found = f"tracks of version {version!r}"
        raise damaged(file.source, found, "version 1 or 2", first.row)
    if not lines:
        raise damaged(file.source, "holds no point of a track", EXPECTED)
    places = numbers_of(lines, file.source, 3, 5, EXPECTED)
    images = [line.words[0] for line in lines]
    sizes = image_sizes(companions(file.path))
    require_sizes(images, sizes, file.source)
    sides = np.array([sizes[image] for image in images])
    pixels = places * sides.max(axis=1)[:, None] + (sides - 1.0) / 2.0
    table = pd.DataFrame({"image_id": images, "point_id": [x.words[1] for x in lines]})
    return Foreign({"image_points": table.assign(x=pixels[:, 0], y=pixels[:, 1])})
