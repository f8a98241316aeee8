"""Lengths in the units that the header of a table states.

Ground and image coordinates are converted, and that is said. Model coordinates keep the
unit that they have: it is compared with ``model_unit``, and other lengths of the table
are brought to it. What contradicts itself is refused.
"""

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import ProjectionError, TableError
from einschalt.foundations.header_units import METRES_PER_LENGTH, PIXELS, is_length
from einschalt.foundations.projections import METRE, code_of, read_source_crs
from einschalt.foundations.tables import IMAGE_PAIRS, IMAGE_POINTS
from einschalt.foundations.units import METRES_PER_UNIT

# of each of these all columns have one unit
PLACES = (
    ("x", "y", "z"),
    ("x_left", "y_left", "x_right", "y_right"),
    ("easting", "northing"),
)
OF_A_MODEL = ("model_points", "y_parallaxes", "models")
OF_IMAGES = (IMAGE_POINTS.name, IMAGE_PAIRS.name)
MM, M = "mm", "m"
HEIGHT = "height"
# NAVD88 in the feet of a plane system
HEIGHTS_IN_FEET = {"US survey foot": "6360", "foot": "8228"}


def in_expected_units(frame, meant, schema, said, source):
    """The frame in the units that are expected, a note or None, the unit of places.

    ``said.unit`` is that of the flight; None where it is not known yet. A TableError
    where units contradict each other.
    """
    if not meant.units:
        return frame, None, None
    expected = _expected(schema, said)
    unit = None
    for group in PLACES:
        names = [name for name in group if name in frame.columns]
        if any(name in meant.units for name in names):
            unit = _one_unit(names, meant, expected, source)
    if schema.name in OF_A_MODEL and unit is not None:
        if said.unit is not None and unit != said.unit:
            raise _other_model_unit(meant, unit, said.unit, source)
        expected = unit
    elif schema.name in OF_IMAGES and PIXELS in (unit, said.unit):
        _require_kind_of_image(meant, unit, said.unit, source)
        return frame, None, unit
    return *_converted(frame, meant, expected, source), unit


def require_unit_of_heights(frame, meant, crs, source):
    """Refuse heights without a unit beside coordinates in feet: who knows in which.

    ``crs``: system of the points. Heights in a column ``height`` are metres, and those
    that have a system are in its unit.
    """
    name = meant.translated.get(HEIGHT)
    is_open = name is not None and HEIGHT not in meant.units and HEIGHT in frame
    if crs is None or not is_open or not frame[HEIGHT].notna().any():
        return
    try:
        system = read_source_crs(crs)
    except ProjectionError:  # said where the system is read
        return
    unit = system.axis_info[0].unit_name
    if not system.is_projected or len(system.axis_info) > 2 or unit == METRE:
        return
    added = HEIGHTS_IN_FEET.get(unit)
    example = "" if added is None else f", such as {code_of(system)}+{added}"
    shown = shortened(name)
    named = f"call the column '{shown} [m]'"
    if meant.is_by_place:
        named = "write a line of names above the values, with height [m]"
    raise TableError(
        f"the coordinates are in {unit} units: in which are the heights of '{shown}'?",
        expected="heights in metres, or a system of heights in crs",
        remedy=f"Add the system of the heights to that of the points{example}; if they "
        f"are metres, {named}",
        file=source,
    )


def in_written_units(frame, schema, unit, source):
    """A table of models whose header states another unit, in mm, and a note or None.

    ``unit``: that of its places, as :func:`in_expected_units` gives it; a file that is
    written has plain names, which say millimetres. Pixels are told, and stay.
    """
    if unit == PIXELS:
        return frame, (
            f"{source}: the image coordinates are pixels, as they stay: the flight "
            "needs a camera"
        )
    if schema.name not in OF_A_MODEL or unit in (None, MM):
        return frame, None
    names = [c.name for c in schema.columns if is_length(c.unit) and c.name in frame]
    factors = METRES_PER_LENGTH[unit], METRES_PER_LENGTH[MM]
    changed = {name: _times(frame[name], *factors) for name in names}
    return frame.assign(**changed), f"{source}: converted from {unit} to {MM}"


def _expected(schema, said):
    if schema.name in OF_A_MODEL:
        return said.unit or MM
    return MM if schema.name in OF_IMAGES else M


def _one_unit(names, meant, expected, source):
    """The unit that all of some columns have; refused where they differ."""
    stated = {name: meant.units[name] for name in names if name in meant.units}
    (first, unit), *others = stated.items()
    for name, other in others:
        if other != unit:
            raise TableError(
                f"column '{meant.translated[first]}' is in {unit}, column "
                f"'{meant.translated[name]}' in {other}",
                expected="coordinates in one unit",
                remedy="Convert one of them, or correct its name if that is wrong",
                file=source,
            )
    silent = [name for name in names if name not in stated]
    if silent and unit != expected:
        shown = meant.translated.get(silent[0], silent[0])
        raise TableError(
            f"column '{meant.translated[first]}' is in {unit}, column '{shown}' "
            "states no unit",
            expected="coordinates in one unit",
            remedy=f"Write '{shown} [{unit}]' if it has that unit, or convert one of "
            "them",
            file=source,
        )
    return unit


def _other_model_unit(meant, unit, model_unit, source):
    name = next(n for group in PLACES for n in group if n in meant.units)
    shown = meant.translated[name]
    mend = "Correct the name of the column if it is wrong, or convert the table"
    if unit in METRES_PER_UNIT:
        mend = f"Set model_unit = '{unit}', or correct the name of the column"
    return TableError(
        f"column '{shown}' is in {unit}, but model_unit of the flight is {model_unit}",
        expected=f"coordinates in {model_unit}",
        remedy=mend,
        file=source,
    )


def _require_kind_of_image(meant, unit, expected, source):
    """Pixels belong to a camera, and lengths to none."""
    if unit is None or expected is None or (unit == PIXELS) == (expected == PIXELS):
        return
    name = next(n for group in PLACES for n in group if n in meant.units)
    shown = meant.translated[name]
    if unit == PIXELS:
        raise TableError(
            f"column '{shown}' is in pixels, and the flight has no camera",
            expected="millimetres from the principal point",
            remedy="Name its camera, which says how large a pixel is (docs/tables.md)",
            file=source,
        )
    raise TableError(
        f"column '{shown}' is in {unit}, and the flight has a camera",
        expected="pixels of the camera",
        remedy="Take camera out of block.toml, and give principal_distance_mm",
        file=source,
    )


def _converted(frame, meant, expected, source):
    """The frame with lengths in the unit that is expected, and a note or None."""
    others = {n: u for n, u in meant.units.items() if u != expected and n in frame}
    if not others:
        return frame, None
    changed = {
        name: _times(frame[name], METRES_PER_LENGTH[unit], METRES_PER_LENGTH[expected])
        for name, unit in others.items()
    }
    shown = ", ".join(f"'{meant.translated[n]}' ({u})" for n, u in others.items())
    return frame.assign(**changed), f"{source}: converted to {expected}: {shown}"


def _times(series, metres, metres_of_expected):
    """Values in another unit; what is no number stays as it is, to be refused."""
    numbers = pd.to_numeric(series, errors="coerce").astype(float)
    # a quotient of whole numbers is rounded once: 12345.678 km keep their decimals
    ratio = metres / metres_of_expected
    is_smaller = ratio < 1.0
    values = numbers / np.round(1 / ratio) if is_smaller else numbers * np.round(ratio)
    if not (numbers.isna() & series.notna()).any():
        return values
    return values.astype(object).where(numbers.notna(), series)
