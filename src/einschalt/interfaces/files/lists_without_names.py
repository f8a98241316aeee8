"""Lists of points whose columns have no names: whether they are what they look like.

A name, two coordinates, perhaps a height. Where the first number is a coordinate
itself, the others would be taken for what stands before them. So would those behind the
name of an image: programs list the places of images as well, with precisions or
latitudes where a list of marks has names of points.
"""

import numpy as np
import pandas as pd

from einschalt.foundations.decimal_commas import is_measure
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import TableError
from einschalt.foundations.tables import LINE
from einschalt.pipeline.block.given_points import NO_HEIGHT

HIGHEST_M = 9000.0  # no point of the earth's surface is as high
NAMES, HEIGHT, IMAGES = "point_id", "height", "image_id"
NO_NAME = "column "  # by which a column without one is called
REMEDY = (
    "Write a line with the names of the columns above the values, such as "
    "point_id, easting, northing, height"
)


def refuse_other_lists(frame, meant, said, source):
    """Refuse names that are coordinates, and heights that are none."""
    if not len(frame):
        return
    if meant.translated.get(IMAGES, "").startswith(NO_NAME):
        _refuse_places(frame, said, source)
    if not meant.is_by_place:
        return
    if NAMES not in said.columns and frame[NAMES].map(_has_decimals).all():
        first = shortened(str(frame[NAMES].iloc[0]))
        raise TableError(
            f"the columns have no names, and the first begins with {first!r}: is that "
            "a name or a coordinate?",
            expected="name, two coordinates, perhaps the height",
            remedy=REMEDY,
            file=source,
            row=_line(frame, 0),
        )
    if HEIGHT in frame and HEIGHT not in said.columns:
        _refuse_heights(frame, meant.translated[HEIGHT], source)


def _refuse_places(frame, said, source):
    """Refuse places of images that were taken for marks in them."""
    if NAMES not in said.columns and frame[NAMES].map(_has_decimals).all():
        first = shortened(str(frame[NAMES].iloc[0]))
        raise TableError(
            f"the columns have no names, and beside the images stands {first!r}: is "
            "that the name of a point or a number?",
            expected="image, point, x and y",
            remedy="Write a line with the names of the columns above the values, such "
            "as image_id, point_id, x, y; the places of images are no table of a block",
            file=source,
            row=_line(frame, 0),
        )


def _has_decimals(name):
    text = str(name).strip()
    return is_measure(text) and ("." in text or "," in text)


def _refuse_heights(frame, column, source):
    heights = pd.to_numeric(frame[HEIGHT], errors="coerce").to_numpy(float)
    is_none = (np.abs(heights) > HIGHEST_M) & ~np.isin(heights, NO_HEIGHT)
    if is_none.any():
        place = int(np.argmax(is_none))
        raise TableError(
            f"the columns have no names, and '{column}' cannot be the height: "
            f"{heights[place]:.10g} m",
            expected=f"heights up to {HIGHEST_M:.0f} m",
            remedy=REMEDY,
            file=source,
            row=_line(frame, place),
        )


def _line(frame, place):
    return int(frame.index[place]) if frame.index.name == LINE else None
