"""Points of KML, as GDAL, and QGIS with it, write it; of Google Earth after its manual.

Every placemark with one point: its name, longitude and latitude of WGS 84, and what
its ExtendedData say of height and kind, in the words that columns of tables have. The
altitude of a point is its height only where the file says that it is absolute;
otherwise the point lies on the ground, and the altitude is one of the program's, mostly
0.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pandas as pd

from einschalt.foundations.column_words import Meant, columns_meant
from einschalt.foundations.errors import FileError, TableError, name_some
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.tables import CONTROL_POINTS, ROLES
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.lists_without_names import HIGHEST_M
from einschalt.interfaces.files.plain_xml import each, local, read_xml, text_of
from einschalt.interfaces.files.understood_tables import (
    NOTHING_SAID,
    answered_elsewhere,
    understood,
)
from einschalt.interfaces.programs.foreign import Foreign, is_finite, numbered
from einschalt.pipeline.block.given_points import NO_HEIGHT

EXPECTED = "placemarks with points, longitude,latitude[,altitude]"
ABSOLUTE = "absolute"
WGS_84 = "EPSG:4326"
METRES = "m"
PRECISE = ("standard_error", "covariance")  # how names of precision begin
# a file of another program has no key in block.toml
ANSWERS = {
    "Say decimal": "Write decimal points for decimal commas, and take other commas out",
    "Say which": "Rename the one that is not meant",
}


@dataclass(frozen=True)
class Placemark:
    """What a placemark with one point says."""

    name: str
    place: list
    has_altitude: bool  # that a program or a hand gave, and not the 0 of the ground
    altitude: float  # absolute; NaN otherwise
    data: dict  # texts of its data, by the names of the schema
    meant: Meant


def read_kml(file) -> Foreign:
    """Read the points; lines and areas have none."""
    root = read_xml(file.data, file.source, EXPECTED)
    placemarks, n_others = [], 0
    for one in each(root, "Placemark"):
        points = list(each(one, "Point"))
        if len(points) == 1:
            placemarks.append(_placemark(one, points[0], file.source))
        else:
            n_others += 1
    if not placemarks:
        raise damaged(file.source, "holds no placemark with a point", EXPECTED)
    table = pd.DataFrame({"point_id": numbered([one.name for one in placemarks])})
    table[["longitude", "latitude"]] = np.array([one.place for one in placemarks])
    table, notes = _with_data(table, placemarks, file.source)
    if n_others:
        said = kept("{n:placemark|placemarks}", n=n_others)
        notes.append(f"{file.source}: {said} without exactly one point left out")
    n_unnamed = sum(not one.name for one in placemarks)
    if n_unnamed:
        said = kept("{n:point|points}", n=n_unnamed)
        notes.append(f"{file.source}: {said} without a name, numbered")
    return Foreign({"control_points": table}, WGS_84, tuple(notes))


def _placemark(placemark, point, source):
    data = _data_of(placemark)
    name = text_of(placemark, "name")
    meant = _meant(tuple(data), bool(name), source)
    data = dict(zip(meant.names, data.values(), strict=True))
    name = name or data.get("point_id", "")
    words = [word.strip() for word in text_of(point, "coordinates").split(",")]
    if len(words) not in (2, 3) or not all(map(is_finite, words)):
        found = f"point {name or '?'}: {','.join(words)[:60]!r} is no place"
        raise damaged(source, found, EXPECTED)
    place = [float(word) for word in words]
    if abs(place[0]) > 180.0 or abs(place[1]) > 90.0:
        said = ",".join(words)[:60]
        found = f"point {name or '?'}: {said!r} is no longitude and latitude"
        raise damaged(source, found, EXPECTED)
    is_absolute = text_of(point, "altitudeMode") == ABSOLUTE and len(place) == 3
    altitude = place[2] if is_absolute else np.nan
    has_altitude = is_absolute or any(place[2:])
    return Placemark(name, place[:2], has_altitude, altitude, data, meant)


@lru_cache(maxsize=64)  # most placemarks of a file have the same data
def _meant(names, is_named, source):
    """Understand the names of data; a point with a name needs none of them for it."""
    needed = [n for n in CONTROL_POINTS.names if not (is_named and n == "point_id")]
    try:
        return columns_meant(names, CONTROL_POINTS.only(*needed), source=source)
    except TableError as error:
        raise answered_elsewhere(error, ANSWERS) from error


def _data_of(placemark):
    """What the ExtendedData say: texts by their names, of several the first."""
    data = {}
    for one in each(placemark, "ExtendedData"):
        for datum in one.iter():
            name = datum.get("name") or ""
            if local(datum) == "Data":
                data[name] = data.get(name) or text_of(datum, "value")
            elif local(datum) == "SimpleData":
                data[name] = data.get(name) or (datum.text or "").strip()
    return data


def _with_data(table, placemarks, source):
    """The points with heights and roles, without new ones, and notes."""
    names = ("height", "role")
    frame = pd.DataFrame(
        {n: [one.data.get(n) or None for one in placemarks] for n in names}
    )
    frame = frame.dropna(axis=1, how="all")
    # data of a kind that is none, such as that of the monument, are told
    words = frame["role"].dropna().unique() if "role" in frame else ()
    try:
        meant = _meant_as_columns(frame, placemarks, source)
        read = understood(frame, CONTROL_POINTS, NOTHING_SAID, meant, source)
    except TableError as error:
        point = None if error.row is None else table["point_id"].iloc[error.row]
        error = error.with_facts(row=None, point=point)
        raise answered_elsewhere(error, ANSWERS) from error
    frame, notes = read.frame, list(read.notes)
    table = table.loc[frame.index]
    placemarks = [placemarks[k] for k in frame.index]
    heights, more = _heights(frame, placemarks, table["point_id"], source)
    if np.isfinite(heights).any():
        table = table.assign(height=heights)
    if "role" in frame:
        table = table.assign(role=_roles(frame["role"], table["point_id"], source))
    elif len(words):
        more.append(
            f"{source}: kinds not understood, taken for control: {name_some(words)}"
        )
    known = {name: None for one in placemarks for name in one.data}
    unused = [name for name in known if name.startswith(PRECISE)]
    if unused:
        more.append(f"{source}: data of precision not used: {name_some(unused)}")
    return table.reset_index(drop=True), [*notes, *more]


def _meant_as_columns(frame, placemarks, source):
    """What the names of the data mean, as if they were those of one table."""
    translated, own, units = {}, set(), set()
    for one in placemarks:
        for name in frame.columns:
            if name not in one.data:
                continue
            if name in one.meant.translated:
                translated.setdefault(name, one.meant.translated[name])
            else:
                own.add(name)
        if "height" in one.data:
            units.add(one.meant.units.get("height", METRES))
    if len(units) > 1:
        raise FileError(
            f"heights of its data are in {name_some(sorted(units))}",
            expected="heights in one unit",
            remedy="Convert them to metres",
            file=source,
        )
    return Meant(
        tuple(frame.columns),
        {name: said for name, said in translated.items() if name not in own},
        units={"height": units.pop()} if units and "height" in frame else {},
    )


def _heights(frame, placemarks, names, source):
    """Heights of the data, otherwise the altitudes, and notes on them."""
    altitudes = np.array([one.altitude for one in placemarks])
    if "height" not in frame:
        is_said = np.isfinite(altitudes).any()
        note = f"{source}: heights are its altitudes, above sea level (EGM96)"
        _require_heights(altitudes, names, source)
        return altitudes, [note] if is_said else []
    heights = pd.to_numeric(frame["height"], errors="coerce").to_numpy(float)
    is_wrong = frame["height"].notna().to_numpy() & ~np.isfinite(heights)
    if is_wrong.any():
        place = int(np.argmax(is_wrong))
        raise FileError(
            f"height {frame['height'].iloc[place]!r} of point {names.iloc[place]} is "
            "no number",
            expected="metres, without their unit",
            remedy="Correct it, or leave it empty",
            file=source,
        )
    _require_heights(heights, names, source)
    notes = []
    if any(one.has_altitude for one in placemarks):
        notes.append(f"{source}: heights are those of its data, not its altitudes")
    lost = names[np.isnan(heights) & np.isfinite(altitudes)]
    if len(lost):
        notes.append(
            f"{source}: without heights, since their data have none: {name_some(lost)}"
        )
    return heights, notes


def _require_heights(heights, names, source):
    """Refuse heights that no point on the ground has: they are something else."""
    is_none = (np.abs(heights) > HIGHEST_M) & ~np.isin(heights, NO_HEIGHT)
    if is_none.any():
        place = int(np.argmax(is_none))
        raise FileError(
            f"height {heights[place]:.10g} of point {names.iloc[place]} is none",
            expected=f"heights up to {HIGHEST_M:.0f} m",
            remedy="Correct it, or leave it empty",
            file=source,
        )


def _roles(roles, names, source):
    """Roles of the points; those that say none are control."""
    roles = roles.where(roles.notna() & (roles != ""), "control")
    is_wrong = ~roles.isin(ROLES).to_numpy()
    if is_wrong.any():
        place = int(np.argmax(is_wrong))
        raise FileError(
            f"role {roles.iloc[place]!r} of point {names.iloc[place]} is unknown",
            expected="control or check points",
            remedy="Say control, check or new",
            file=source,
        )
    return roles.to_numpy(dtype=object)
