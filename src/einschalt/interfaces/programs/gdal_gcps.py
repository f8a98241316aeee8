"""Ground control points of images: VRT and GeoTIFF of GDAL, ArcGIS, QGIS ``.points``.

Pixels are counted from the upper left corner of the image, x to the right, y down.
"""

import io
import re
import warnings

import numpy as np
import pandas as pd

from einschalt.foundations.areas_of_use import in_extent
from einschalt.foundations.errors import FileError
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.projections import (
    code_on_earth,
    is_northing_first,
    read_source_crs,
)
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.plain_xml import child, each, read_xml
from einschalt.interfaces.programs.foreign import (
    Foreign,
    cells_of,
    is_finite,
    lines_of,
    numbered,
)

VRT = "a VRT with a GCPList"
MAPPING = "dataAxisToSRSAxisMapping"
WITHOUT_AXES = re.compile(r"^\s*(PROJCS|GEOGCS|COMPD_CS)\[", re.IGNORECASE)
TIFF = "a GeoTIFF with tie points"
ARCGIS = "GeodataXform with SourceGCPs and TargetGCPs"
QGIS = "mapX,mapY,sourceX,sourceY,enable and lines of five columns or more"
TIE_POINTS, SCALE, GEO_KEYS = 33922, 33550, 34735
# where strips or tiles of the image begin, and how long they are
PARTS = ((273, 279), (324, 325))
RASTER_KEY, GEOGRAPHIC_KEY, PROJECTED_KEY = 1025, 2048, 3072
PIXEL_IS_POINT = 2
USER_DEFINED = 32767


def _foreign(rows, crs, image, source, expected, notes=()):
    """Tables of rows (name or None, x, y, easting, northing, height, role)."""
    if not rows:
        raise damaged(source, "holds no control points", expected)
    names = numbered([row[0] for row in rows])
    n_unnamed = sum(not row[0] for row in rows)
    if 0 < n_unnamed < len(rows):
        said = kept("{n:point|points}", n=n_unnamed)
        notes = [*notes, f"{source}: {said} without a number, numbered"]
    values = np.array([row[1:6] for row in rows], dtype=float)
    if not np.isfinite(values[:, :4]).all():
        place = int(np.flatnonzero(~np.isfinite(values[:, :4]).all(axis=1))[0])
        found = f"point {names[place]} lacks a coordinate"
        raise damaged(source, found, expected)
    is_geographic = crs is not None and read_source_crs(crs).is_geographic
    plane = ("longitude", "latitude") if is_geographic else ("easting", "northing")
    control = pd.DataFrame({"point_id": names})
    control[list(plane)] = values[:, 2:4]
    if np.nan_to_num(values[:, 4]).any():
        control["height"] = values[:, 4]
    control["role"] = [row[6] for row in rows]
    measured = pd.DataFrame({"image_id": image, "point_id": names})
    measured[["x", "y"]] = values[:, :2]
    tables = {"control_points": control, "image_points": measured}
    return Foreign(tables, crs, tuple(notes))


def read_vrt(file) -> Foreign:
    """Read the GCPList of a VRT."""
    root = read_xml(file.data, file.source, VRT)
    listed = next(each(root, "GCPList"), None)
    if listed is None:
        raise damaged(file.source, "has no GCPList", VRT)
    system = listed.get("Projection")
    crs = code_on_earth(system)
    rows = []
    for one in each(listed, "GCP"):
        said = [one.get(name) for name in ("Pixel", "Line", "X", "Y")]
        if not all(text is not None and is_finite(text) for text in said):
            text = " ".join(str(word) for word in said)
            raise damaged(file.source, f"a GCP says {text!r}", "Pixel, Line, X, Y")
        height = one.get("Z") or one.get("GCPZ") or "nan"
        if height != "nan" and not is_finite(height):
            raise damaged(file.source, f"a GCP has the height {height!r}", "a number")
        rows.append((one.get("Id"), *map(float, said), float(height), "control"))
    notes = []
    if listed.get(MAPPING) and crs is None:
        said = f"{MAPPING} not used: X is taken for the easting, Y for the northing"
        notes.append(f"{file.source}: {said}")
    elif listed.get(MAPPING) and rows:
        middle = np.median([row[3:5] for row in rows], axis=0)
        if _is_northing_first(listed.get(MAPPING), system, middle, file.source):
            rows = [(*row[:3], row[4], row[3], *row[5:]) for row in rows]
    return _foreign(rows, crs, file.path.name, file.source, VRT, notes)


def _is_northing_first(mapping, system, middle, source):
    """Whether X of a GCP is the northing or latitude, as the mapping of axes says.

    ``system`` as the file has it: its code may be one whose axes are exchanged.
    ``middle`` of the points: WKT without axes leaves open whether they are those of its
    code, and the area of the system tells. Without a mapping X is the easting or
    longitude, whatever the system says.
    """
    first = mapping.split(",")[0].strip()
    if first not in ("1", "2"):
        raise damaged(
            source, f"dataAxisToSRSAxisMapping is {mapping[:60]!r}", "1,2 or 2,1"
        )
    if WITHOUT_AXES.search(system) and "AXIS[" not in system.upper():
        is_inside = [
            in_extent(*one, code_on_earth(system)) for one in (middle, middle[::-1])
        ]
        if None not in is_inside and is_inside[0] != is_inside[1]:
            return bool(is_inside[1])
    return (first == "1") == is_northing_first(system)


def read_arcgis(file) -> Foreign:
    """Read the links of an ``.aux.xml`` of ArcGIS."""
    root = read_xml(file.data, file.source, ARCGIS)
    lists = []
    for name in ("SourceGCPs", "TargetGCPs"):
        found = next(each(root, name), None)
        words = [] if found is None else [one.text or "" for one in found]
        if not words or len(words) % 2 or not all(map(is_finite, words)):
            raise damaged(file.source, f"{name} are no pairs of numbers", ARCGIS)
        lists.append(np.array(words, dtype=float).reshape(-1, 2))
    if len(lists[0]) != len(lists[1]):
        found = f"has {len(lists[0])} source and {len(lists[1])} target points"
        raise damaged(file.source, found, ARCGIS)
    system = child(root, "SpatialReference")
    texts = [] if system is None else [*each(system, "WKID"), *each(system, "WKT")]
    crs = None
    for one in texts:
        text = (one.text or "").strip()
        crs = crs or code_on_earth(f"EPSG:{text}" if text.isdigit() else text)
    pairs = zip(*lists, strict=True)
    rows = [(None, *one, *two, np.nan, "control") for one, two in pairs]
    image = file.path.name.removesuffix(".xml").removesuffix(".aux")
    note = f"{file.source}: x and y as ArcGIS has them, in inches of a scan where so"
    return _foreign(rows, crs, image, file.source, ARCGIS, [note])


def read_geotiff(file) -> Foreign:
    """Read the tie points of a GeoTIFF from its tags; its pixels stay unread."""
    from PIL import Image, UnidentifiedImageError  # noqa: PLC0415 - seldom needed

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the size of an image that is not read
        try:
            with Image.open(io.BytesIO(file.data), formats=("TIFF",)) as image:
                tags = dict(image.tag_v2)
        except UnidentifiedImageError as error:  # it names a place in memory
            raise damaged(file.source, "is no TIFF, or not whole", TIFF) from error
        except (OSError, ValueError, SyntaxError) as error:
            found = f"is no whole TIFF: {str(error)[:60]}"
            raise damaged(file.source, found, TIFF) from error
        except (KeyError, TypeError, Image.DecompressionBombError) as error:
            raise damaged(file.source, "its tags are damaged", TIFF) from error
    ends = [_ends(tags, *pair, file.source) for pair in PARTS]
    ties = _finite(tags, TIE_POINTS, file.source)
    keys = _geo_keys(_finite(tags, GEO_KEYS, file.source))
    if max(one.max(initial=0.0) for one in ends) > len(file.data):
        raise damaged(file.source, "ends before its image: it is cut off", TIFF)
    if SCALE in tags or not len(ties) or len(ties) % 6:
        raise damaged(file.source, "has no list of control points", TIFF)
    ties = ties.reshape(-1, 6)
    ties[:, :2] += 0.5 if keys.get(RASTER_KEY) == PIXEL_IS_POINT else 0.0
    rows = [(None, *one[:2], *one[3:6], "control") for one in ties.tolist()]
    code = keys.get(PROJECTED_KEY) or keys.get(GEOGRAPHIC_KEY)
    crs = code_on_earth(f"EPSG:{code}" if code and code != USER_DEFINED else None)
    return _foreign(rows, crs, file.path.name, file.source, TIFF)


def _ends(tags, starts, counts, source):
    """Where the parts of an image end."""
    starts, counts = (_finite(tags, one, source, (0.0,)) for one in (starts, counts))
    if len(starts) != len(counts) != 1:
        raise damaged(source, "its tags are damaged", TIFF)
    return starts + counts


def _finite(tags, number, source, default=()):
    """Numbers of a tag; a FileError where it has a text, or what is not finite."""
    try:
        values = np.array(tags.get(number, default), dtype=float).reshape(-1)
    except (ValueError, TypeError) as error:
        raise damaged(source, "its tags are damaged", TIFF) from error
    if not np.isfinite(values).all():
        raise damaged(source, "its tags are damaged", TIFF)
    return values


def _geo_keys(keys):
    """Values of the keys of a GeoTIFF that are short numbers."""
    keys = keys.astype(int)
    keys = keys[: len(keys) // 4 * 4].reshape(-1, 4)[1:]
    return {int(key): int(value) for key, place, _, value in keys if place == 0}


def read_qgis(file) -> Foreign:
    """Read the points of QGIS's georeferencer; rows count down there with a minus."""
    crs, names, places, switch, rows, n_off = None, [], None, None, [], 0
    for line in lines_of(file, comments=("\0",)):
        if line.text.upper().startswith("#CRS:"):
            crs = code_on_earth(line.text[5:].strip())
        elif line.text.lstrip("#").startswith("mapX"):
            names = line.text.lstrip("#").split(",")
            places = [_place(names, n) for n in ("sourceX", "sourceY", "mapX", "mapY")]
            switch = names.index("enable") if "enable" in names else None
        elif not line.text.startswith("#"):
            cells = cells_of(line.text, file.source, line.row)
            # decimal commas would move every number into a column of its own
            is_longer = places is not None and len(cells) > len(names)
            row = _numbers(cells, None if is_longer else places, file.source, line)
            has_switch = switch is not None and switch < len(cells)
            is_on = not has_switch or cells[switch].strip() not in ("0", "false")
            n_off += not is_on
            x, y, east, north = row
            role = "control" if is_on else "check"
            rows.append((None, x, -y, east, north, np.nan, role))
    _require_pixels([row[2] for row in rows], file.source)
    image = file.path.name.removesuffix(".points")
    said = f"{file.source}: {n_off} points not enabled, taken for check points"
    notes = [said] if n_off else []
    return _foreign(rows, crs, image, file.source, QGIS, notes)


def _require_pixels(rows_down, source):
    """Refuse places above the image: of a raster that had a system already.

    QGIS counts pixels in one without, and in other layers coordinates of their system.
    """
    if rows_down and max(rows_down) < 0.0:
        raise FileError(
            "sourceY is above 0 in every line: these are coordinates, and no pixels",
            expected="sourceX, sourceY in pixels, rows counted down with a minus",
            remedy="Georeference the image without its world file and system",
            file=source,
        )


def _place(names, name):
    """Position of a column; older versions called them pixelX and pixelY."""
    older = name.replace("source", "pixel")
    return next((names.index(n) for n in (name, older) if n in names), None)


def _numbers(cells, places, source, line):
    is_whole = places is not None and None not in places
    is_whole = is_whole and max(places) < len(cells)
    if not is_whole or not all(is_finite(cells[k].strip()) for k in places):
        raise damaged(source, f"{line.text[:60]!r} is no point", QGIS, line.row)
    return [float(cells[k]) for k in places]
