"""Sizes of images, as reconstructions of OpenSfM have them."""

import math
from pathlib import Path

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError, name_some
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.language import mark
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.plain_json import read_json

MOST_NAMED = 4
NO_RECONSTRUCTION = mark("is no reconstruction as OpenSfM writes it")


def json_of(path, source):
    """Read JSON of OpenSfM; a FileError with the line where it is none."""
    return read_json(path, source, "JSON as OpenSfM writes it")


def unsized(images, sizes, source):
    """Images whose size no reconstruction has, and notes on them.

    OpenSfM leaves images out of a reconstruction that it could not orient. A FileError
    where it has none of them: then it is another one, or is missing.
    """
    unknown = set(images) - set(sizes)
    if not unknown:
        return unknown, ()
    if len(unknown) == len(set(images)):
        raise FileError(
            f"the size of image {min(unknown)} is unknown",
            expected="reconstruction.json beside it, with the cameras of its images",
            remedy="Copy it from the project",
            file=source,
        )
    said = kept("{n:image|images}", n=len(unknown))
    named = name_some(sorted(unknown), MOST_NAMED)
    note = f"{source}: {said} that no reconstruction has, left out: {named}"
    return unknown, (note,)


def image_sizes(files):
    """Width and height of images, by name, of all reconstructions."""
    sizes = {}
    for file in files:
        path = Path(file)
        parts = json_of(file, path.name)
        try:
            for part in parts:
                for image, shot in part["shots"].items():
                    camera = part["cameras"][shot["camera"]]
                    sizes[image] = _size(camera, image, path.name)
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise damaged(path.name, NO_RECONSTRUCTION) from error
    return sizes


def _size(camera, image, source):
    """Width and height of an image, as its camera has them."""
    size = float(camera["width"]), float(camera["height"])
    if not all(math.isfinite(side) and side >= 1.0 for side in size):
        said = f"{camera['width']} x {camera['height']}"
        raise damaged(
            source,
            f"the size of image {image} is {shortened(said)}",
            "width and height in pixels, at least 1",
        )
    return size
