"""Longitudes and latitudes with minutes and seconds, brought to degrees."""

import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.number_parsing import DEGREES
from einschalt.foundations.sexagesimal import degrees_and_side

SIDES = {"longitude": ("", "E", "W"), "latitude": ("", "N", "S")}


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
