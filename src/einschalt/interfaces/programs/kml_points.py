"""Points of KML, as Google Earth, QGIS and receivers write it.

Every placemark with one point: its name, longitude and latitude of WGS 84, and what
its ExtendedData say of height and kind. The altitude of a point is its height only
where the file says that it is absolute; otherwise the point lies on the ground, and the
altitude is one of the program's, mostly 0.
"""

import numpy as np
import pandas as pd

from einschalt.foundations.column_words import COLUMN_WORDS, folded, kind_of
from einschalt.foundations.decimal_commas import is_measure
from einschalt.foundations.kept_texts import kept
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.plain_xml import each, local, read_xml, text_of
from einschalt.interfaces.programs.foreign import Foreign, is_finite, numbered

EXPECTED = "placemarks with points, longitude,latitude[,altitude]"
ABSOLUTE = "absolute"
WGS_84 = "EPSG:4326"


def read_kml(file) -> Foreign:
    """Read the points; lines and areas have none."""
    root = read_xml(file.data, file.source, EXPECTED)
    rows, n_others = [], 0
    for placemark in each(root, "Placemark"):
        points = list(each(placemark, "Point"))
        if len(points) == 1:
            rows.append(_row(placemark, points[0], file.source))
        else:
            n_others += 1
    if not rows:
        raise damaged(file.source, "holds no placemark with a point", EXPECTED)
    names, places, altitudes, heights, roles = zip(*rows, strict=True)
    table = pd.DataFrame({"point_id": numbered(names)})
    table[["longitude", "latitude"]] = np.array(places)
    heights, notes = _heights(np.array(altitudes), np.array(heights), file.source)
    if np.isfinite(heights).any():
        table["height"] = heights
    if any(roles):
        table["role"] = [role or "control" for role in roles]
    if n_others:
        said = kept("{n:placemark|placemarks}", n=n_others)
        notes.append(f"{file.source}: {said} without a single point left out")
    n_unnamed = sum(not name for name in names)
    if n_unnamed:
        said = kept("{n:point|points}", n=n_unnamed)
        notes.append(f"{file.source}: {said} without a name, numbered")
    return Foreign({"control_points": table}, WGS_84, tuple(notes))


def _row(placemark, point, source):
    """Name, place, absolute altitude, height and role of a placemark."""
    data = list(_data_of(placemark))
    name = text_of(placemark, "name") or _said(data, "point_id")
    words = [word.strip() for word in text_of(point, "coordinates").split(",")]
    if len(words) not in (2, 3) or not all(map(is_finite, words)):
        found = f"point {name or '?'}: {','.join(words)[:60]!r} is no place"
        raise damaged(source, found, EXPECTED)
    place = [float(word) for word in words]
    if abs(place[0]) > 180.0 or abs(place[1]) > 90.0:
        said = ",".join(words)[:60]
        found = f"point {name or '?'}: {said!r} is no longitude and latitude"
        raise damaged(source, found, EXPECTED)
    is_absolute = text_of(point, "altitudeMode") == ABSOLUTE
    altitude = place[2] if is_absolute and len(place) == 3 else np.nan
    given = _said(data, "height")
    height = float(given) if is_measure(given) and is_finite(given) else np.nan
    return name, place[:2], altitude, height, kind_of(_said(data, "role"))


def _heights(altitudes, heights, source):
    """Heights of the data, otherwise the altitudes, and notes on them."""
    notes = []
    if np.isfinite(heights).any():
        notes.append(f"{source}: heights are those of its data, not its altitudes")
        return heights, notes
    if np.isfinite(altitudes).any():
        notes.append(f"{source}: heights are its altitudes, above sea level (EGM96)")
    return altitudes, notes


def _data_of(placemark):
    """What the ExtendedData say: pairs of folded name and text."""
    for one in each(placemark, "ExtendedData"):
        for datum in one.iter():
            if local(datum) == "Data":
                yield folded(datum.get("name") or ""), text_of(datum, "value")
            elif local(datum) == "SimpleData":
                yield folded(datum.get("name") or ""), (datum.text or "").strip()


def _said(data, meaning):
    """The first text of the data whose name has a meaning; empty where none has."""
    known = {word for name, word in COLUMN_WORDS if name == meaning}
    known.add(folded(meaning))
    return next((text for name, text in data if name in known and text), "")
