"""The area of a flight plan: polygons of GeoPackage, shapefile and GeoJSON.

Areas in degrees, or in another plane system than is asked for, are brought into one in
metres: that of ``--crs``, or else the zone of UTM.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import EinschaltError, FileError, ProjectionError
from einschalt.foundations.language import mark
from einschalt.foundations.operation_choice import Demand
from einschalt.foundations.projections import (
    WGS_84,
    beyond_use,
    degrees_beyond_use,
    label_of,
    read_crs,
    read_source_crs,
    reproject,
    scale_range,
)
from einschalt.interfaces.files.gdal_files import opened
from einschalt.interfaces.files.input_files import companions, read_once
from einschalt.interfaces.files.json_text import parsed_json
from einschalt.interfaces.files.point_layers import SUFFIXES, choose_layer, require_kind
from einschalt.pipeline.planning.area.flight_area import FlightArea

JSON_SUFFIXES = (".geojson", ".json")
KINDS = ("Polygon", "MultiPolygon")
MOST_AREAS = 10_000
GOOD_ENOUGH = 5.0  # metres: of the border of an area
MOST_STRETCHED = 0.02  # of a length: distances between photographs are on the ground
UTM_NORTH, UTM_SOUTH = 32600, 32700
FARTHEST_NORTH, FARTHEST_SOUTH = 84.0, -80.0  # degrees, of UTM
NO_SYSTEM = (
    "The area has no reference system (--crs): the plan is a local one, without KML."
)
FAR_BEYOND = 2.0  # degrees: nearer, systems of neighbours are used as well
WIDEST = 30.0  # degrees of longitude: beyond it the area lies over the antimeridian


@dataclass(frozen=True)
class _Drawn:
    """Polygons as a file has them."""

    shapes: list
    crs: str | None


def read_area(path, *, layer=None, crs=None) -> FlightArea:
    """Read the polygons of a file as one area, in a plane system in metres.

    ``layer`` names that of a GeoPackage with several; ``crs`` the system of the plan.
    FileError, GeometryError or ProjectionError where no flight can be planned over it.
    """
    source = Path(path).name
    suffix = Path(path).suffix.lower()
    if suffix not in (*SUFFIXES, *JSON_SUFFIXES):
        raise FileError(
            f"the suffix {suffix!r} is none of an area",
            expected=", ".join((*SUFFIXES, ".json")),
            remedy="Export the polygon as GeoPackage or GeoJSON",
            file=source,
        )
    read = _of_json if suffix in JSON_SUFFIXES else _of_layer
    drawn = read(path, layer, source)
    try:
        return _as_area(drawn, crs)
    except EinschaltError as error:
        raise error.with_facts(file=source) from None


def area_of_table(table, crs=None) -> FlightArea:
    """Take the polygons of a table of geopandas as one area, as :func:`read_area` does.

    ``table`` has ``geometry`` and ``crs``, as GeoDataFrame and GeoSeries have; ``crs``
    and errors as there.
    """
    source = type(table).__name__
    own = None if table.crs is None else table.crs.to_string()
    drawn = _Drawn(_polygons(list(table.geometry), source), own)
    try:
        return _as_area(drawn, crs)
    except EinschaltError as error:
        raise error.with_facts(file=source) from None


def _of_layer(path, layer, source):
    import shapely  # noqa: PLC0415 - loaded when a file is read

    file = read_once(path, source)
    require_kind(file)
    parts = {file.path.suffix.lower(): file.data}
    if file.path.suffix.lower() == ".shp":
        beside = companions(file.path)
        parts |= {one.suffix.lower(): one.read_bytes() for one in beside}
        if ".shx" not in parts:
            raise FileError(
                "the file .shx is not beside it",
                expected="all files of a shapefile",
                remedy="Copy them as well",
                file=source,
            )
    with opened(parts, source) as (pyogrio, copy):
        name = choose_layer(copy, layer, source, "--area-layer {}")
        meta, table = pyogrio.read_arrow(
            copy, layer=name, columns=[], max_features=MOST_AREAS + 1
        )
    of_geometry = meta["geometry_name"] or "wkb_geometry"
    if of_geometry not in table.column_names:
        raise _no_polygon("no geometry", source)
    try:
        shapes = shapely.from_wkb(table[of_geometry].to_pylist())
    except (shapely.errors.ShapelyError, TypeError) as error:
        raise _no_polygon("a damaged geometry", source) from error
    return _Drawn(_polygons(list(shapes), source), meta["crs"])


def _of_json(path, layer, source):
    """Read GeoJSON: a FeatureCollection, a Feature or a geometry."""
    if layer is not None:
        raise FileError(
            f"is GeoJSON, which has no layers, and none called '{layer}'",
            expected="a layer of a GeoPackage",
            remedy="Leave --area-layer out",
            file=source,
        )
    data = read_once(path, source).data
    try:
        given = parsed_json(data.decode("utf-8-sig"))
        features = given.get("features", [given])
        parts = [one.get("geometry", one) for one in features[: MOST_AREAS + 1]]
        shapes = [_json_shape(one) for one in parts]
        named = given.get("crs")
        crs = WGS_84 if named is None else str(named["properties"]["name"])
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise FileError(
            _fault_of_json(error),
            expected="a polygon, or a FeatureCollection of polygons",
            remedy="Export the area again",
            file=source,
        ) from error
    return _Drawn(_polygons(shapes, source), crs)


def _fault_of_json(error):
    if isinstance(error, json.JSONDecodeError):  # such as of a file that was cut off
        return f"is no JSON from line {error.lineno}, column {error.colno} on"
    return f"is no GeoJSON of polygons: {shortened(str(error), 80)}"


def _json_shape(geometry):
    import shapely  # noqa: PLC0415 - loaded when a file is read

    if geometry is None:
        return None
    try:
        return shapely.from_geojson(json.dumps(geometry, allow_nan=False))
    except (shapely.errors.ShapelyError, ValueError):
        raise ValueError("a geometry is damaged, or none") from None


def _polygons(shapes, source):
    if len(shapes) > MOST_AREAS:
        raise _no_polygon(f"more than {MOST_AREAS} geometries", source)
    shapes = [one for one in shapes if one is not None and not one.is_empty]
    if not shapes:
        raise _no_polygon("no polygon: it is empty", source)
    other = [one.geom_type for one in shapes if one.geom_type not in KINDS]
    if other:
        raise _no_polygon(f"a geometry of type {other[0]}", source)
    return shapes


def _no_polygon(found, source):
    return FileError(
        f"holds {found}",
        expected="the area as a polygon, or several",
        remedy="Draw its border as a polygon, and export that alone",
        file=source,
    )


def _as_area(drawn, crs):
    """Join the polygons, in the system of the plan."""
    import shapely  # noqa: PLC0415 - loaded when a file is read

    target, notes = _target(drawn, crs)
    shapes = [shapely.force_2d(one) for one in drawn.shapes]
    if target is not None and target != drawn.crs:
        shapes = [_moved(one, drawn.crs, target) for one in shapes]
    if target is not None:
        _require_metres(shapes, target)
    for one in shapes:
        FlightArea(one, target)  # each must be sound before they are joined
    if len(shapes) > 1:
        notes.append(f"{len(shapes)} polygons are one area.")
        shapes = [shapely.union_all(shapes)]
    notes += _far_away(shapes[0], target)
    return FlightArea(shapes[0], target, tuple(notes))


def _far_away(shape, crs):
    """Ask about an area that lies where its system is not used."""
    if crs is None:
        return []
    beyond, longitude, latitude = beyond_use(shape.centroid.x, shape.centroid.y, crs)
    if beyond < FAR_BEYOND:
        return []
    place = "at no place on the Earth"
    if np.isfinite(beyond):
        place = f"at {longitude:.1f}° of longitude and {latitude:.1f}° of latitude"
    said = (
        f"In {label_of(crs)} the area lies {place}, far from where this system is "
        "used: are its coordinates exchanged, or of another system?"
    )
    return [said]


def _target(drawn, crs):
    """Name the system of the plan, and say why it is another than the file's."""
    if drawn.crs is None or read_source_crs(drawn.crs).is_engineering:
        if crs is None:
            return None, [NO_SYSTEM]
        read_crs(crs)
        return crs, [f"The area names no system; it is taken as {label_of(crs)}."]
    source = read_source_crs(drawn.crs)
    _require_degrees(drawn, source)
    if crs is not None:
        read_crs(crs)
        said = (
            f"The area was transformed from {label_of(drawn.crs)} to {label_of(crs)}."
        )
        is_same = read_crs(crs) == source
        return (drawn.crs, []) if is_same else (crs, [said])
    try:
        read_crs(drawn.crs)
    except ProjectionError:
        zone = _utm_zone(drawn)
        said = (
            f"The area is in {label_of(drawn.crs)}, which has no metres; the plan is "
            f"in {label_of(zone)} (another one: --crs)."
        )
        return zone, [said]
    stretched = _stretched(drawn.shapes, drawn.crs)
    if abs(stretched - 1.0) > MOST_STRETCHED:
        zone = _utm_zone(drawn)
        said = (
            f"The area is in {label_of(drawn.crs)}, where a metre on the ground is "
            f"{stretched:.2f} m; the plan is in {label_of(zone)} (another one: --crs)."
        )
        return zone, [said]
    return drawn.crs, []


def _require_degrees(drawn, source):
    """Refuse metres in a system of degrees: GeoJSON that does not name its system."""
    import shapely  # noqa: PLC0415 - loaded when a file is read

    xy = np.concatenate([shapely.get_coordinates(one) for one in drawn.shapes])
    if source.is_geographic and (np.abs(xy) > [360.0, 90.0]).any():
        east, north = xy[np.argmax(np.abs(xy).max(axis=1))]
        raise ProjectionError(
            f"a corner is {east:.10g}, {north:.10g} in {label_of(drawn.crs)}",
            expected="longitude and latitude in degrees",
            remedy="Export the area with its system; GeoJSON without one has degrees",
        )


def _stretched(shapes, crs):
    """What becomes of a metre on the ground in a system; 1.0 where nobody knows."""
    import shapely  # noqa: PLC0415 - loaded when a file is read

    xy = np.concatenate([shapely.get_coordinates(one) for one in shapes])
    found = scale_range(*xy.T, crs)
    if found is None:
        return 1.0
    return float(max(found, key=lambda one: abs(one - 1.0)))


def _require_metres(shapes, crs):
    """Refuse a system that was asked for, and stretches the area."""
    stretched = _stretched(shapes, crs)
    if abs(stretched - 1.0) > MOST_STRETCHED:
        raise ProjectionError(
            f"a metre on the ground is {stretched:.2f} m in {label_of(crs)} there",
            expected="a plane system made for the area, such as its zone of UTM",
            remedy="Give its --crs, or leave --crs out",
        )


def _utm_zone(drawn):
    import shapely  # noqa: PLC0415 - loaded when a file is read

    xy = np.concatenate([shapely.get_coordinates(one) for one in drawn.shapes])
    source = read_source_crs(drawn.crs)
    demand = Demand(1e5, "since a zone is looked for")
    return _zone_of(reproject(xy, source, read_source_crs(WGS_84), demand)[0])


def _zone_of(degrees):
    low, high = degrees.min(axis=0), degrees.max(axis=0)
    is_on_earth = np.isfinite(degrees).all() and (np.abs(degrees) <= [180, 90]).all()
    if not is_on_earth or low[1] < FARTHEST_SOUTH or high[1] > FARTHEST_NORTH:
        raise ProjectionError(
            f"the area reaches from {low[1]:g}° to {high[1]:g}° of latitude and from "
            f"{low[0]:g}° to {high[0]:g}° of longitude",
            expected=f"{FARTHEST_SOUTH:g}° to {FARTHEST_NORTH:g}° of latitude, where "
            "UTM is, and -180° to 180° of longitude",
            remedy="Name the plane system of the plan: --crs; or plan parts on both "
            "sides of 180° by themselves",
        )
    if high[0] - low[0] > WIDEST:
        raise ProjectionError(
            f"the area reaches over {high[0] - low[0]:.0f}° of longitude",
            expected="an area that one flight covers",
            remedy="Plan in parts, or name a plane system that holds it: --crs",
        )
    longitude, latitude = (low + high) / 2.0
    zone = min(int((longitude + 180.0) // 6.0) + 1, 60)
    return f"EPSG:{(UTM_NORTH if latitude >= 0.0 else UTM_SOUTH) + zone}"


def _moved(shape, source, target):
    import shapely  # noqa: PLC0415 - loaded when a file is read

    if source is None or read_source_crs(source).is_engineering:
        return shape  # it names none: taken as it is
    systems = read_source_crs(source), read_crs(target)
    reason = mark("since it is the border of an area")
    demand = Demand(GOOD_ENOUGH, reason, is_fixed=True)
    try:
        return shapely.transform(
            shape, lambda xy: reproject(xy, *systems, demand)[0][:, :2]
        )
    except ProjectionError as error:
        east, north = shape.centroid.x, shape.centroid.y
        beyond, *place = beyond_use(east, north, source)
        if max(beyond, degrees_beyond_use(*place, target)) < FAR_BEYOND:
            # both are used there, and no way between them is good enough
            own = f"Name a plane system with the datum of {label_of(source)}: --crs"
            ways = [error.remedy, own] if error.remedy else [own]
            raise error.with_facts(remedy=". Or: ".join(ways)) from error
        raise ProjectionError(
            f"the area, at {east:.7g}, {north:.7g} in {label_of(source)}, cannot be "
            f"brought into {label_of(target)}",
            expected="an area where both systems are used",
            remedy="Are its coordinates exchanged (longitude comes first)? Is --crs "
            "the system of the place?",
        ) from error
