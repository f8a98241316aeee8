"""Points for geographic information systems: GeoParquet and Shapefile."""

import json
import struct

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from einschalt.foundations.errors import FileError
from einschalt.foundations.projections import read_crs
from einschalt.interfaces.files import map_shapes
from einschalt.interfaces.files.arrow_columns import column_as_arrow
from einschalt.interfaces.files.gdal_files import NO_ROOM, written
from einschalt.interfaces.files.geopackage import distinct_names

GEOMETRY = "geometry"
MOST_NAME = 10  # characters of a column of a shapefile
MOST_TEXT = 254  # bytes of a text in it
ATTRIBUTES = ".dbf"
PARTS_OF_SHAPEFILE = (".shp", ".shx", ATTRIBUTES)
HEAD_OF_PART = 32  # bytes that each of them begins with, and more
SHORT = {
    "standard_error_easting": "se_east",
    "standard_error_northing": "se_north",
    "standard_error_height": "se_height",
    "standard_error_total": "se_total",
    "standard_error_paper": "se_paper",
    "standard_error_internal": "se_intern",
    "standard_error_checked": "se_checked",
    "standard_error_height_checked": "se_h_check",
    "covariance_en": "cov_en",
    "covariance_eh": "cov_eh",
    "covariance_nh": "cov_nh",
    "is_within_tolerance": "within_tol",
    "n_coverages": "n_cover",
    "spread_total": "spread",
    "difference_easting": "diff_east",
    "difference_northing": "diff_north",
    "difference_height": "diff_h",
    "distributed_easting": "dist_east",
    "distributed_northing": "dist_north",
    "two_step_easting": "two_east",
    "two_step_northing": "two_north",
    "two_step_height": "two_height",
}


def _shapes(handed):
    """Points as well-known binary, and what kind they are."""
    has_heights = np.isfinite(handed.heights).all()
    xy = handed.coordinates[:, :2]
    if not has_heights:
        return map_shapes.points(xy), "Point"
    return map_shapes.points(np.column_stack([xy, handed.heights])), "Point Z"


def write_geoparquet(handed, path):
    """Write the points as GeoParquet 1.1, every column as it is."""
    shapes, kind = _shapes(handed)
    points = handed.points
    columns = [column_as_arrow(points[name]) for name in points]
    xy = handed.coordinates[:, :2]
    about = {
        "encoding": "WKB",
        "geometry_types": [kind],
        "bbox": [*xy.min(axis=0), *xy.max(axis=0)],
        "crs": None if handed.crs is None else read_crs(handed.crs).to_json_dict(),
    }
    if kind == "Point Z":
        low, high = handed.heights.min(), handed.heights.max()
        about["bbox"] = [*xy.min(axis=0), low, *xy.max(axis=0), high]
    geo = {"version": "1.1.0", "primary_column": GEOMETRY, "columns": {GEOMETRY: about}}
    table = pa.table([*columns, shapes], names=[*points, GEOMETRY])
    table = table.replace_schema_metadata({"geo": json.dumps(geo)})
    pq.write_table(table, path, compression="zstd")


def write_shapefile(handed, path):
    """Write the points as a shapefile, with short names of columns; gives a note."""
    # imported when a file is written: GDAL takes its time
    import pyogrio  # noqa: PLC0415

    shapes, kind = _shapes(handed)
    points = handed.points
    names = short_names(points.columns)
    columns = [_fitting(column_as_arrow(points[n]), n, path) for n in points]
    crs = None if handed.crs is None else read_crs(handed.crs).to_wkt("WKT1_ESRI")
    options = {"ENCODING": "UTF-8", "DBF_DATE_LAST_UPDATE": "1970-01-01"}
    with written(path):
        pyogrio.write_arrow(
            pa.table([*columns, shapes], names=[*names, GEOMETRY]),
            path,
            driver="ESRI Shapefile",
            geometry_name=GEOMETRY,
            geometry_type=kind,
            crs=crs,
            layer_options=options,
        )
    _require_whole(path)
    changed = [f"{n} = {s}" for n, s in zip(points, names, strict=True) if n != s]
    return [f"names of columns cut to {MOST_NAME} characters: {', '.join(changed)}"]


def _require_whole(path):
    """Refuse a shapefile whose parts are shorter than they say.

    GDAL writes what is left when it closes them, and nobody hears that there was no
    room.
    """
    for suffix in PARTS_OF_SHAPEFILE:
        part = path.with_suffix(suffix)
        size = part.stat().st_size if part.is_file() else 0
        if size < HEAD_OF_PART or size < _stated_size(part):
            raise FileError(
                "cannot be written: the disk took a part of it only",
                remedy=NO_ROOM,
                file=path,
            )


def _stated_size(part):
    """Bytes that a part of a shapefile is to have, by its head."""
    with part.open("rb") as opened:
        head = opened.read(HEAD_OF_PART)
    if part.suffix == ATTRIBUTES:
        n_rows, of_head, of_row = struct.unpack("<4xIHH", head[:12])
        return of_head + n_rows * of_row
    return 2 * int.from_bytes(head[24:28], "big")  # counted in words of 16 bits


def short_names(names):
    """Names of columns that a shapefile can hold, each another one.

    >>> short_names(["standard_error_total", "point_id", "a_rather_long_name"])
    ['se_total', 'point_id', 'a_rather_l']
    """
    short = []
    for name in map(str, names):
        free, number = SHORT.get(name, name)[:MOST_NAME], 2
        while free in short:
            free = f"{SHORT.get(name, name)[: MOST_NAME - 2]}_{number}"
            number += 1
        short.append(free)
    return distinct_names(short)


def _fitting(values, name, path):
    """Column as a shapefile holds it; truth as 0 and 1."""
    if pa.types.is_boolean(values.type):
        return values.cast(pa.int32())
    if pa.types.is_string(values.type) or pa.types.is_large_string(values.type):
        sizes = [len(one.encode()) for one in values.to_pylist() if one is not None]
        if max(sizes, default=0) > MOST_TEXT:
            raise FileError(
                f"a text of {name} has {max(sizes)} bytes",
                expected=f"at most {MOST_TEXT}, as a shapefile holds",
                remedy="Choose GeoParquet or GeoPackage",
                file=path.name,
            )
    return values
