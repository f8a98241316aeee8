"""Points in the files of geographic information systems, with their system.

GeoPackage, shapefile and GeoJSON; a Parquet table with geometries passes here as well.
The geometry gives easting and northing (x is the east in all of these formats), and the
height where it has one; the attributes give the rest.
"""

import sqlite3
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import shapely

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import (
    FileError,
    ProjectionError,
    TableError,
    name_some,
)
from einschalt.foundations.near_words import nearest
from einschalt.foundations.projections import read_source_crs
from einschalt.foundations.typesetting import count
from einschalt.interfaces.files.gdal_files import opened
from einschalt.interfaces.files.input_files import read_once
from einschalt.interfaces.files.json_text import parsed_json
from einschalt.interfaces.files.understood_tables import (
    NOTHING_SAID,
    ReadTable,
    meant_header,
    understood,
)

SUFFIXES = (".gpkg", ".shp", ".geojson")
SIGNATURES = {".gpkg": b"SQLite format 3\0", ".shp": b"\0\0\x27\x0a"}
WGS_84 = "OGC:CRS84"
PLANE, GEOGRAPHIC = ("easting", "northing"), ("longitude", "latitude")
COORDINATES = PLANE + GEOGRAPHIC
SAME = 1e-3  # metres: attributes are rounded, the geometry is not
SAME_DEGREES = 1e-8
MOST_ANGLES = 400.0, 100.0  # longitudes and latitudes, also in gon
MOST_VALUES = 2**26


@dataclass(frozen=True, eq=False)
class PointLayer:
    """Points as they stand in a layer."""

    attributes: pd.DataFrame
    geometry: np.ndarray | None  # shapely points, (n_points,)
    crs: str | None
    notes: tuple[str, ...] = ()


def understand_layer(
    path, schema, said=NOTHING_SAID, *, source=None, beside=()
) -> ReadTable:
    """Read the points of a layer; the index is its row, counted from 1.

    ``beside``: the files that belong to a shapefile, read before.
    """
    source = source or Path(path).name
    return points_of(read_layer(path, said, source, beside), schema, said, source)


def read_layer(path, said, source, beside=()) -> PointLayer:
    """Read a layer: ``said.layer``, or the only one of the file."""
    file = read_once(path, source)
    suffix = file.path.suffix.lower()
    if suffix == ".geojson":
        return _geojson(file.data, source)
    require_kind(file)
    parts = {suffix: file.data}
    parts |= {one.path.suffix.lower(): one.data for one in beside}
    if suffix == ".shp" and not {".shx", ".dbf"} <= set(parts):
        raise FileError(
            "the files .shx and .dbf are not beside it",
            expected="all files of a shapefile",
            remedy="Copy them as well",
            file=source,
        )
    with opened(parts, source) as (pyogrio, copy):
        name = choose_layer(copy, said.layer, source)
        # one row more than is allowed, which is then refused; none takes no byte
        n_columns = len(pyogrio.read_info(copy, layer=name)["fields"]) + 1
        most = min(len(file.data), MOST_VALUES // n_columns + 1)
        meta, table = pyogrio.read_arrow(copy, layer=name, max_features=most)
        return _of_table(meta, table, source)


def require_kind(file):
    """Refuse a GeoPackage or shapefile that is none, before GDAL looks at it."""
    suffix = file.path.suffix.lower()
    if not file.data.startswith(SIGNATURES[suffix]):
        raise FileError(
            f"is no {suffix} file, whatever its name says",
            expected=f"a file that begins as {suffix} files do",
            remedy="Export it again",
            file=file.source,
        )


def choose_layer(copy, layer, source, option='layer = "{}" in block.toml'):
    """Name the layer that is meant; refused where it is a view, or one of several."""
    # imported when a file is read: GDAL takes its time
    import pyogrio  # noqa: PLC0415

    names = [str(name) for name, _ in pyogrio.list_layers(copy)]
    name = _chosen(names, layer, source, option)
    if Path(copy).suffix == ".gpkg":
        _refuse_view(copy, name, source)
    return name


def _chosen(names, layer, source, option):
    if layer is None and len(names) == 1:
        return names[0]
    if layer in names:
        return layer
    found = f"holds no layer '{shortened(layer)}'" if layer else "holds several layers"
    raise FileError(
        found,
        expected=name_some(names, 8),
        remedy=f"Say which: {option.format(_meant_of(names, layer))}" if names else "",
        file=source,
    )


def _meant_of(names, layer):
    """The layer that may be meant by another name; the first one where none is like."""
    return (nearest(layer, names) if layer else None) or names[0]


def _refuse_view(copy, name, source):
    """Refuse what is computed when it is read: nobody knows for how long."""
    connection = sqlite3.connect(f"file:{copy}?mode=ro", uri=True)
    try:
        query = "SELECT type, sql FROM sqlite_master WHERE lower(name) = lower(?)"
        found = list(connection.execute(query, (name,)))
        query = "SELECT count(*) FROM pragma_table_xinfo(?) WHERE hidden > 0"
        (n_computed,) = connection.execute(query, (name,)).fetchone()
    except sqlite3.Error as error:
        raise FileError(
            f"cannot be read: {error}", remedy="Export it again", file=source
        ) from error
    finally:
        connection.close()
    is_virtual = any("virtual" in str(sql).lower().split()[:2] for _, sql in found)
    if is_virtual or n_computed or "view" in [kind for kind, _ in found]:
        name = shortened(name)
        raise FileError(
            f"layer '{name}' has columns that are computed when it is read"
            if n_computed
            else f"layer '{name}' is a view, computed when it is read",
            expected="a layer that is stored",
            remedy="Export it as a layer of its own",
            file=source,
        )


def _of_table(meta, table, source):
    _refuse_size(table.num_rows, table.num_columns, source)
    try:
        table.validate(full=True)  # GDAL believes what a file says of its encoding
    except pa.ArrowInvalid as error:
        raise FileError(
            "holds text in another encoding than it says",
            expected="UTF-8, or the encoding that the .cpg beside a shapefile names",
            remedy="Export the points again as UTF-8",
            file=source,
        ) from error
    name = meta["geometry_name"] or "wkb_geometry"
    geometry = None
    if name in table.column_names:
        geometry = points_of_wkb(table[name].to_pylist(), source)
        table = table.drop_columns([name])
    frame = table.to_pandas()
    frame.index = pd.RangeIndex(1, len(frame) + 1, name="row")
    return PointLayer(frame, geometry, meta["crs"])


def _refuse_size(n_rows, n_columns, source):
    if n_rows * n_columns > MOST_VALUES:
        raise FileError(
            f"the layer has {n_rows} rows or more of {n_columns} columns",
            expected=f"at most {MOST_VALUES} values",
            remedy="Leave out what is no part of the table, or give it as Parquet",
            file=source,
        )


def points_of_wkb(values, source):
    """Points of well-known binary; an only point of a multipoint is one."""
    try:
        shapes = shapely.from_wkb(np.array(values, dtype=object))
    except (shapely.errors.ShapelyError, TypeError) as error:
        raise FileError(
            "a geometry is damaged", remedy="Export the points again", file=source
        ) from error
    return _points(shapes, source)


def _points(shapes, source):
    kind = shapely.get_type_id(shapes)
    is_alone = (kind == 4) & (shapely.get_num_geometries(shapes) == 1)
    shapes = np.where(is_alone, shapely.get_geometry(shapes, 0), shapes)
    is_point = (shapely.get_type_id(shapes) == 0) & ~shapely.is_empty(shapes)
    if not is_point.all():
        place = int(np.flatnonzero(~is_point)[0])
        shape = shapes[place]
        raise TableError(
            f"the geometry is {'missing' if shape is None else shape.geom_type}",
            expected="a point in every row",
            remedy="Export the points alone",
            file=source,
            row=place + 1,
        )
    return shapes


def _geojson(data, source):
    """Read GeoJSON; GDAL would take JSON of other kinds, which lead elsewhere."""
    try:
        given = parsed_json(data.decode("utf-8-sig"))
        features = given["features"]
        rows = [feature.get("properties") or {} for feature in features]
        # each feature may have names of its own
        _refuse_size(len(rows), len(set().union(*rows)), source)
        shapes = [_json_point(feature, k) for k, feature in enumerate(features)]
        frame = pd.DataFrame.from_records([dict(row) for row in rows])
        shapes = np.array(shapes, dtype=object)
        crs, notes = _json_crs(given.get("crs"), shapes, source)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise FileError(
            f"is no GeoJSON of points: {shortened(str(error), 80)}",
            expected="a FeatureCollection of points",
            remedy="Export the points again",
            file=source,
        ) from error
    frame.index = pd.RangeIndex(1, len(frame) + 1, name="row")
    return PointLayer(frame, shapes if rows else None, crs, notes)


def _json_point(feature, place):
    geometry = feature["geometry"]
    kind = "missing" if geometry is None else str(geometry["type"])
    is_alone = kind == "MultiPoint" and len(geometry["coordinates"]) == 1
    if kind != "Point" and not is_alone:
        raise ValueError(f"the geometry of feature {place + 1} is {kind}")
    values = geometry["coordinates"][0] if is_alone else geometry["coordinates"]
    return shapely.Point([float(value) for value in values[:3]])


def _json_crs(given, shapes, source):
    """System of the standard of 2008; that of 2016 knows longitude and latitude.

    Many programs write metres and no system all the same, which the numbers tell.
    """
    if given is not None:
        return str(given["properties"]["name"]), ()
    if _are_angles(shapely.get_coordinates(shapes)):
        return WGS_84, ()
    note = (
        f"{source}: names no system (crs), and its coordinates are no degrees: taken "
        "as metres"
    )
    return None, (note,)


def _are_angles(xy):
    """Whether coordinates can be longitudes and latitudes, but for some wrong ones."""
    return not len(xy) or bool((np.median(np.abs(xy), axis=0) <= MOST_ANGLES).all())


def points_of(layer, schema, said, source) -> ReadTable:
    """Make a table of the points of a layer, of their attributes and geometry."""
    frame, notes = layer.attributes, list(layer.notes)
    meant = meant_header([str(n) for n in frame.columns], schema, said, source)
    frame = frame.set_axis(list(meant.names), axis=1)
    crs = _known(layer.crs)
    if layer.geometry is not None and not said.columns.keys().isdisjoint(COORDINATES):
        crs = None  # the layer states that of its geometry: columns may have another
        notes.append(f"{source}: coordinates of the columns, not the geometry")
    elif layer.geometry is not None:
        frame, meant, note = _with_geometry(frame, layer, meant, schema, source)
        notes.append(note)
    is_placed = layer.geometry is not None and said.columns.keys().isdisjoint(
        COORDINATES
    )
    table = understood(frame, schema, said, meant, source, is_placed=is_placed)
    return ReadTable(table.frame, (*notes, *table.notes), crs)


def _known(crs):
    """System that a layer states; None where it is none that is understood."""
    try:
        return None if crs is None or not read_source_crs(crs) else crs
    except ProjectionError:  # such as that of a local system: nothing to compare
        return None


def _with_geometry(frame, layer, meant, schema, source):
    """The frame with the coordinates of the geometry, and what is said of them."""
    xyz = shapely.get_coordinates(layer.geometry, include_z=True)
    crs = _known(layer.crs)
    is_geographic = crs is not None and read_source_crs(crs).is_geographic
    if is_geographic and not _are_angles(xyz[:, :2]):
        raise TableError(
            f"the layer has longitudes and latitudes ({shortened(crs)}), but x = "
            f"{xyz[0, 0]:.10g}, y = {xyz[0, 1]:.10g}",
            expected="degrees, or the system of these coordinates",
            remedy="Give the layer its system in a GIS, and export it again",
            file=source,
            row=1,
        )
    names = GEOGRAPHIC if is_geographic else PLANE
    has_both = all(list(frame.columns).count(name) == 1 for name in names)
    if has_both and meant.letters is None:
        _refuse_others(frame[list(names)], xyz, names, source)
    others = {n: meant.translated[n] for n in PLANE if n in meant.translated}
    if meant.letters is not None:  # the geometry knows which axis is which
        others = dict(zip(PLANE, meant.letters[::-1], strict=True))
    if others and (is_geographic or meant.letters is not None):
        frame = frame.rename(columns=others)
        frame = frame.set_axis([str(n) for n in frame.columns], axis=1)
        meant = replace(
            meant,
            names=tuple(frame.columns),
            translated={n: s for n, s in meant.translated.items() if n not in PLANE},
            units={n: u for n, u in meant.units.items() if n not in PLANE},
            letters=None,
        )
    frame = frame.drop(columns=[n for n in names if n in frame])
    frame = frame.assign(**dict(zip(names, xyz.T, strict=False)))
    note = f"{source}: coordinates of the geometry"
    lacks_height = "height" in schema.names and "height" not in frame
    if lacks_height and np.isfinite(xyz[:, 2]).any():
        frame = frame.assign(height=xyz[:, 2])
        note = f"{source}: coordinates and heights of the geometry"
    return frame, meant, note


def _refuse_others(frame, xyz, names, source):
    """Refuse attributes that say other coordinates than the geometry."""
    values = [pd.to_numeric(frame[n], errors="coerce").to_numpy(float) for n in names]
    apart = np.abs(np.column_stack(values) - xyz[:, :2]).max(axis=1)
    same = SAME_DEGREES if names == GEOGRAPHIC else SAME
    is_other = ~(apart <= same)
    if is_other.any():
        place = int(np.flatnonzero(is_other)[0])
        raise TableError(
            f"the columns {' and '.join(names)} and the geometry say different places "
            f"in {count(is_other.sum(), 'row')}",
            expected="the same place",
            remedy=f"Say columns = {{{names[0]} = …, {names[1]} = …}} in block.toml to "
            "take the columns, or leave them out to take the geometry",
            file=source,
            row=place + 1,
        )
