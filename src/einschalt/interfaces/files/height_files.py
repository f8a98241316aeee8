"""Heights of the terrain: GeoTIFF, or a table or list of easting, northing, height."""

import io
import re
import warnings
from pathlib import Path

import numpy as np

from einschalt.foundations import tables
from einschalt.foundations.epsg_units import METRE, system_of_heights, unit_label
from einschalt.foundations.errors import (
    FileError,
    ProjectionError,
    TableError,
    raise_problems,
)
from einschalt.foundations.projections import label_of, read_crs
from einschalt.interfaces.files.csv_headers import COMMENT
from einschalt.interfaces.files.csv_tables import understand_csv
from einschalt.interfaces.files.input_files import read_once
from einschalt.interfaces.files.tables_by_suffix import understand_table
from einschalt.interfaces.files.text_encodings import read_table_text
from einschalt.interfaces.files.understood_tables import answered_elsewhere
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights

TIFF_SUFFIXES = (".tif", ".tiff")
XYZ, ASCII_GRID = ".xyz", ".asc"
LIST_SUFFIXES = (XYZ, ".csv", ".txt", ".parquet")
# plans have no block.toml to say it in
ANSWERS = {
    "columns =": "Call the columns easting, northing and height",
    "decimal =": "Write the heights with decimal points",
}
HEIGHTS = tables.Schema(
    "heights",
    tuple(
        tables.Column(name, unit="metres", may_be_missing=name == "height")
        for name in ("easting", "northing", "height")
    ),
    key=(),
)
CELL_SIZE, TIE_POINTS, MATRIX, GEO_KEYS, NODATA = 33550, 33922, 34264, 34735, 42113
MODEL_TYPE, RASTER_TYPE, PROJECTED = 1024, 1025, 3072
IN_DEGREES, PIXEL_IS_POINT, USER_DEFINED = 2, 2, 32767
UNIT_OF_PLANE, SYSTEM_OF_HEIGHTS, UNIT_OF_HEIGHTS = 3076, 4096, 4099
OF_GDAL = 42112
GDAL_ITEM = re.compile(r'role="(scale|offset|unittype)"[^>]*>\s*([^<\s]+)')
AS_THEY_ARE = {"scale": 1.0, "offset": 0.0}
METRES = {"m", "metre", "meter", "metres", "meters"}
MOST_CELLS = 100_000_000
SEPARATORS = re.compile(r"[;,\s]+")


def read_heights(path, crs=None) -> GroundHeights:
    """Read heights [m] in the system of the plan, ``crs``.

    FileError where the file holds none, or has another system.
    """
    source = Path(path).name
    suffix = Path(path).suffix.lower()
    if suffix in TIFF_SUFFIXES:
        return _of_tiff(read_once(path, source), crs)
    if suffix == ASCII_GRID:
        raise FileError(
            f"an ASCII grid ({suffix!r}) is not read",
            expected=", ".join((*TIFF_SUFFIXES, *LIST_SUFFIXES)),
            remedy="Convert it to GeoTIFF, as QGIS and gdal_translate do",
            file=source,
        )
    if suffix not in LIST_SUFFIXES:
        raise FileError(
            f"the suffix {suffix!r} is none of heights",
            expected=", ".join((*TIFF_SUFFIXES, *LIST_SUFFIXES)),
            remedy="Export the terrain as GeoTIFF, or as XYZ",
            file=source,
        )
    if suffix != ".parquet" and (found := _bare_numbers(path, source)) is not None:
        return found
    read = understand_csv if suffix == XYZ else understand_table
    try:
        frame = read(path, HEIGHTS, source=source).frame
    except TableError as error:
        raise answered_elsewhere(error, ANSWERS) from None
    checked = tables.check_table(frame, HEIGHTS, source=source)
    raise_problems(checked.problems)
    values = checked.frame[["easting", "northing", "height"]].to_numpy(dtype=float)
    return GroundHeights(values[:, :2], values[:, 2], source)


def read_heights_over(path, area) -> GroundHeights:
    """Read the heights of an area, in its system; all of it must have some.

    FileError as of :func:`read_heights`, GeometryError where heights are missing.
    """
    heights = read_heights(path, area.crs).over(area)
    heights.require_cover(area)
    return heights


def _bare_numbers(path, source):
    """Heights of a list without a header; None where the first line is one.

    Comments are left out, and the header of an XYZ that says no more than its name.
    """
    text = read_table_text(path, source)[0].decode("utf-8")
    lines = [(n, line.strip()) for n, line in enumerate(text.splitlines(), 1)]
    rows = [
        (number, SEPARATORS.split(line))
        for number, line in lines
        if line and not line.startswith(COMMENT)
    ]
    if Path(path).suffix.lower() == XYZ and len(rows) > 1 and _says_xyz(rows[0][1]):
        rows = rows[1:]
    if not rows:
        return None
    try:
        first = [float(cell) for cell in rows[0][1]]
    except ValueError:
        return None
    for number, cells in rows:
        if len(cells) != len(first) or len(first) != 3:
            raise FileError(
                f"the line has {len(cells)} numbers",
                expected="easting, northing and height, or a header",
                remedy="Export the heights as XYZ",
                file=source,
                row=number,
            )
    try:
        values = np.array([cells for _, cells in rows], float)
    except ValueError as error:
        row, cell = _first_that_is_none(rows)
        raise FileError(
            f"{cell!r} is no number",
            expected="easting, northing and height in every line",
            remedy="Export the heights as XYZ",
            file=source,
            row=row,
        ) from error
    return GroundHeights(values[:, :2], values[:, 2], source)


def _says_xyz(cells):
    return [cell.strip("\"'").casefold() for cell in cells] == ["x", "y", "z"]


def _first_that_is_none(rows):
    """Line, from 1, and text of the first cell that is no number."""
    for row, cells in rows:
        for cell in cells:
            try:
                float(cell)
            except ValueError:
                return row, cell
    raise ValueError(rows)


def _of_tiff(file, crs):
    tags, cells = _cells(file)
    keys = _finite(tags, GEO_KEYS, file.source).astype(int)
    keys = keys[: len(keys) // 4 * 4].reshape(-1, 4)[1:]
    keys = {int(key): int(value) for key, place, _, value in keys if place == 0}
    _require_system(keys, crs, file.source)
    _require_metres(keys, str(tags.get(OF_GDAL, "")), file.source)
    east, north, step_east, step_north = _corner(tags, file.source)
    shift = 0.0 if keys.get(RASTER_TYPE) == PIXEL_IS_POINT else 0.5
    rows, columns = cells.shape
    x = east + (np.arange(columns) + shift) * step_east
    y = north - (np.arange(rows) + shift) * step_north
    height = cells.astype(float)
    height[~np.isfinite(height)] = np.nan
    if NODATA in tags:
        try:
            height[height == float(str(tags[NODATA]).strip("\0 "))] = np.nan
        except ValueError as error:
            raise _damaged("its nodata is no number", file.source) from error
    plane = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return GroundHeights(plane, height.ravel(), file.source)


def _cells(file):
    """Tags and heights of the first band."""
    from PIL import Image, UnidentifiedImageError  # noqa: PLC0415 - seldom needed

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its size, which is asked for below
        try:
            with Image.open(io.BytesIO(file.data), formats=("TIFF",)) as image:
                tags = dict(image.tag_v2)
                if image.width * image.height > MOST_CELLS:
                    raise _damaged(
                        f"has {image.width} x {image.height} cells", file.source
                    )
                if len(image.getbands()) != 1:
                    raise _damaged("has several bands", file.source)
                return tags, np.array(image)
        except UnidentifiedImageError as error:
            raise _damaged(
                "is no TIFF of one band, or ends in its tags", file.source
            ) from error
        except (OSError, ValueError, SyntaxError) as error:
            raise _damaged(f"cannot be read: {str(error)[:60]}", file.source) from error
        except (KeyError, TypeError, Image.DecompressionBombError) as error:
            raise _damaged("its tags are damaged", file.source) from error


def _damaged(found, source):
    return FileError(
        found,
        expected="a GeoTIFF of one band of heights, not compressed or by deflate or "
        "LZW",
        remedy="Export it again for the area, or save the heights as XYZ",
        file=source,
    )


def _finite(tags, number, source):
    """Numbers of a tag, none where it is not there."""
    try:
        values = np.array(tags.get(number, ()), dtype=float).reshape(-1)
    except (ValueError, TypeError) as error:  # a text
        raise _damaged("its tags are damaged", source) from error
    if not np.isfinite(values).all():
        raise _damaged("its tags are damaged", source)
    return values


def _corner(tags, source):
    """North-west corner and size of the cells [m]."""
    size, ties, m = (
        _finite(tags, number, source) for number in (CELL_SIZE, TIE_POINTS, MATRIX)
    )
    if len(m) == 16 and m[1] == m[4] == 0.0:
        return m[3], m[7], m[0], -m[5]
    if len(ties) != 6 or len(size) < 2:
        raise _damaged("says not where it lies, or is turned", source)
    column, row, _, east, north, _ = ties
    return east - column * size[0], north + row * size[1], size[0], size[1]


def _require_metres(keys, written_by_gdal, source):
    """Refuse heights or cells in another unit, or numbers that want scaling."""
    units = {name: keys.get(name, METRE) for name in (UNIT_OF_PLANE, UNIT_OF_HEIGHTS)}
    found, system = None, system_of_heights(keys.get(SYSTEM_OF_HEIGHTS, USER_DEFINED))
    if units[UNIT_OF_PLANE] not in (METRE, USER_DEFINED):
        found = f"its cells are in the unit {unit_label(units[UNIT_OF_PLANE])}"
    elif units[UNIT_OF_HEIGHTS] not in (METRE, USER_DEFINED):
        found = f"its heights are in the unit {unit_label(units[UNIT_OF_HEIGHTS])}"
    elif system is not None and system[-1] != 1.0:
        name, unit, _ = system
        found = f"its heights are in the unit {unit}, that of {name}"
    for name, value in GDAL_ITEM.findall(written_by_gdal):
        if not _is_as_it_stands(name, value):
            found = f"its heights have the {name} {value}"
    if found is not None:
        raise FileError(
            found,
            expected="metres as they stand",
            remedy="Export it in metres, as QGIS does with the raster calculator",
            file=source,
        )


def _is_as_it_stands(name, value):
    """Whether an item that GDAL wrote leaves heights in metres as they are."""
    if name == "unittype":
        return value.lower() in METRES
    try:
        return float(value) == AS_THEY_ARE[name]
    except ValueError:
        return False


def _require_system(keys, crs, source):
    code = keys.get(PROJECTED)
    if keys.get(MODEL_TYPE) == IN_DEGREES:
        raise FileError(
            "its cells are in degrees",
            expected=f"the system of the plan, {label_of(crs) if crs else 'in metres'}",
            remedy="Reproject the raster, as QGIS does with 'Warp'",
            file=source,
        )
    if crs is None or code in (None, USER_DEFINED):
        return
    try:
        found = read_crs(f"EPSG:{code}")
    except ProjectionError as error:
        raise FileError(
            f"its cells are in EPSG:{code}, which is no known system",
            expected=f"the system of the plan, {label_of(crs)}",
            remedy="Reproject the raster, as QGIS does with 'Warp'",
            file=source,
        ) from error
    if found.to_2d() != read_crs(crs).to_2d():
        raise FileError(
            f"its cells are in {label_of(f'EPSG:{code}')}",
            expected=f"the system of the plan, {label_of(crs)}",
            remedy=f"Plan with --crs EPSG:{code}, or reproject the raster",
            file=source,
        )
