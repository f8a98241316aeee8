"""Places of images in a table that looks like one of points.

Programs list the centres of photographs as they list control: a name, three
coordinates. Taken for control, every model would be laid onto a plane of the flight.
"""

import numpy as np
import pandas as pd

from einschalt.foundations.column_words import folded
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import TableError, name_some
from einschalt.foundations.header_units import parted_unit
from einschalt.foundations.tables import LINE

NAMES, PLACE, OTHERS = "point_id", {"easting", "longitude"}, {"image_id", "model_id"}
IMAGE_SUFFIXES = (
    *(".jpg", ".jpeg", ".tif", ".tiff", ".png", ".jp2", ".dng", ".bmp"),
    ".webp",
)
# of the rotation of a photograph, in the words of programs
ANGLES = (
    {"omega", "phi", "kappa"},
    {"yaw", "pitch", "roll"},
    {"heading", "pitch", "roll"},
)


def refuse_places_of_images(frame, meant, schema, said, source):
    """Refuse rows of photographs that would be taken for points on the ground.

    Parameters
    ----------
    frame : DataFrame
        With the columns of ``schema`` under their names.
    meant : Meant
        What the names of the header mean.
    schema : Schema
    said : Said
        A column that the user names ``point_id`` holds names of points, angles or not.
    source : str
        Name of the file.

    Raises
    ------
    TableError
        A point is called as a file of an image is, or a row has the three angles of a
        photograph.
    """
    is_ground = NAMES in schema.names and not OTHERS & set(schema.names)
    if not (is_ground and PLACE & set(frame.columns) and len(frame)):
        return
    _refuse_names(frame, source)
    if NAMES in said.columns or NAMES not in meant.translated:
        return  # the own name of the column says that points stand in it
    words = {folded(parted_unit(str(name), is_plain=True)[0]): name for name in frame}
    for angles in ANGLES:
        if angles <= set(words):
            found = [name for word, name in words.items() if word in angles]
            raise _has_angles(frame, meant.translated[NAMES], found, source)


def _refuse_names(frame, source):
    """Refuse points that are called as images, or rows that have no other name."""
    are_named = list(frame.columns).count(NAMES) == 1
    for place in range(frame.shape[1]):  # names of columns may stand twice
        names = frame.iloc[:, place]
        is_asked = (
            frame.columns[place] == NAMES
            if are_named
            else not pd.api.types.is_numeric_dtype(names)
        )
        if not is_asked:
            continue
        is_image = _are_images(names)
        if not is_image.any() or not (are_named or is_image.all()):
            continue
        row = int(np.argmax(is_image))
        first = shortened(names.iloc[row])
        found = f"holds places of images, such as {first!r}"
        if not is_image.all():
            n_images, n = int(is_image.sum()), len(names)
            found = (
                f"holds places of images in {n_images} of {n} rows, such as {first!r}"
            )
        raise TableError(
            found,
            expected="points on the ground",
            remedy="Leave the images out: a block needs no places of photographs",
            file=source,
            row=_line(frame, row),
        )


def _are_images(names):
    plain = names.astype(str).str.strip().str.casefold()
    return plain.str.endswith(IMAGE_SUFFIXES).to_numpy()


def _has_angles(frame, column, angles, source):
    return TableError(
        f"has {name_some(map(repr, angles))} beside the coordinates, as programs list "
        f"the places of photographs: does {shortened(column)!r} name points or images?",
        expected="points on the ground",
        remedy="Leave it out if these are images. If they are points, say columns = "
        f'{{point_id = "{shortened(column)}"}} in block.toml',
        file=source,
        row=1 if frame.index.name == LINE else None,
    )


def _line(frame, place):
    return int(frame.index[place]) if frame.index.name == LINE else None
