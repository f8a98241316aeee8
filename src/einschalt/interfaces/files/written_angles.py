"""Longitudes and latitudes with minutes and seconds, brought to degrees.

Written out, or packed as D.MMSS. Packed ones look like decimal degrees: their header
tells them, or the user; where all of many could be either, that is asked.
"""

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import TableError
from einschalt.foundations.header_units import PACKED
from einschalt.foundations.number_parsing import DEGREES
from einschalt.foundations.packed_angles import chance_of_packed, unpacked
from einschalt.foundations.sexagesimal import degrees_and_side
from einschalt.foundations.tables import LINE

IN_DEGREES = "degrees"  # how block.toml calls decimal ones
WAYS = (IN_DEGREES, PACKED)
# of decimal degrees that all look like packed ones by chance: less is asked about
RARE = 0.05
SIDES = {"longitude": ("", "E", "W"), "latitude": ("", "N", "S")}


class AnglesError(TableError):
    """It is open, or contradicted, how the angles of a table are written."""


def in_degrees(frame, schema, source):
    """The frame with degrees for degrees, minutes and seconds, and a note or None.

    Of a column in which all values are such angles, of its own sides of the earth; what
    is mixed stays as it is, to be refused.
    """
    units = {column.name: column.unit for column in schema.columns}
    changed, shown = {}, []
    for name, sides in SIDES.items():
        if units.get(name) != DEGREES or list(frame.columns).count(name) != 1:
            continue
        texts = frame[name]
        if pd.api.types.is_numeric_dtype(texts) or not texts.notna().any():
            continue
        angles = texts.map(_angle, na_action="ignore").dropna()
        if not all(angle is not None and angle[1] in sides for angle in angles):
            continue
        values = angles.map(lambda angle: angle[0]).astype(float)
        changed[name] = values.reindex(frame.index)
        first = shortened(str(texts[values.index[0]]).strip())
        shown.append(f"{name} {first!r} = {values.iloc[0]:.10g}")
    if not changed:
        return frame, None
    note = f"{source}: read as degrees, minutes and seconds: {', '.join(shown)}"
    return frame.assign(**changed), note


def _angle(text):
    # None is a missing value to pandas
    return degrees_and_side(str(text).strip()) or (0.0, "?")


def packed_in_degrees(frame, meant, schema, said, source):
    """The frame with degrees for angles that are packed as D.MMSS, and a note or None.

    A TableError where they are said to be and one cannot be, or where decimal degrees
    would hardly ever look so.
    """
    units = {column.name: column.unit for column in schema.columns}
    names = [
        name
        for name in SIDES
        if units.get(name) == DEGREES and list(frame.columns).count(name) == 1
    ]
    angles = {name: _numbers(frame[name]) for name in names}
    if not any(np.isfinite(one).any() for one in angles.values()):
        return frame, None
    way = said or _stated(meant, names, source)
    if way == PACKED:
        return _unpacked(frame, angles, source)
    if way is not None:
        return frame, None
    chance = np.prod([chance_of_packed(one) for one in angles.values()])
    if not chance:
        return frame, None
    name, first = _first_of(angles)
    if chance < RARE:
        raise _question(frame, meant, name, first, source)
    return frame, (
        f"{source}: {name} {first} read as decimal degrees. All of them could be "
        "degrees, minutes and seconds (D.MMSS) as well: if they are, state it as their "
        "unit"
    )


def _numbers(series):
    return pd.to_numeric(series, errors="coerce").to_numpy(float, na_value=np.nan)


def _stated(meant, names, source):
    """How the header says that angles are written; refused where it contradicts."""
    stated = {meant.angles[name] for name in names if name in meant.angles}
    lacks_one = not {*names} <= {*meant.angles}
    if len(stated) > 1 or (stated == {PACKED} and lacks_one):
        shown = [shortened(meant.translated.get(name, name)) for name in names]
        raise AnglesError(
            f"columns {' and '.join(map(repr, shown))} do not both state {PACKED}",
            expected="longitudes and latitudes in one unit",
            remedy=f"Write [{PACKED}] or [deg] behind both names",
            file=source,
        )
    return (PACKED if stated == {PACKED} else IN_DEGREES) if stated else None


def _unpacked(frame, angles, source):
    changed = {name: unpacked(values) for name, values in angles.items()}
    for name, values in angles.items():
        is_none = np.isfinite(values) & np.isnan(changed[name])
        if is_none.any():
            place = int(np.argmax(is_none))
            raise AnglesError(
                f"{name} {values[place]:.10g} has minutes or seconds of 60 or more",
                expected=f"degrees, minutes and seconds as {PACKED}",
                remedy="Correct it; if they are decimal degrees, write [deg] behind "
                "the name of the column",
                file=source,
                row=_line(frame, place),
            )
    kept = {
        name: pd.Series(changed[name], frame.index).where(
            np.isfinite(values), frame[name]
        )
        for name, values in angles.items()
    }
    name, first = _first_of(angles)
    note = f"{source}: {name} {first} read as degrees, minutes and seconds ({PACKED})"
    return frame.assign(**kept), note


def _first_of(angles):
    """Name and value of the first angle, for a note."""
    name, values = next((n, v) for n, v in angles.items() if np.isfinite(v).any())
    return name, f"{values[np.isfinite(values)][0]:.10g}"


def _question(frame, meant, column, first, source):
    name = shortened(meant.translated.get(column, column))
    return AnglesError(
        f"{column} {first}: are these decimal degrees, or degrees, minutes and seconds "
        f"as {PACKED}? No minutes and no seconds of all rows reach 60",
        expected="a unit, or a word on them",
        remedy=f'Say angles = "{PACKED}" or angles = "{IN_DEGREES}" for the table in '
        f"block.toml, or write '{name} [{PACKED}]' or '{name} [deg]' in its header",
        file=source,
        row=_line(frame, 0),
    )


def _line(frame, place):
    return int(frame.index[place]) if frame.index.name == LINE else None
