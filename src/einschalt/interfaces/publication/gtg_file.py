"""Shifts of a grid as GeoTIFF with PROJ's metadata (GTG), for ``+proj=gridshift``.

Four bands: easting_offset, northing_offset, and the accuracy of each [m]. The nodes are
the middles of pixels. Grids in plane systems are read by PROJ 9.4 and later. Source:
PROJ, "Geodetic TIFF grids", and the sample files of its tests.
"""

import io

import numpy as np

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.extras import imported
from einschalt.interfaces.files.atomic import write_bytes

BANDS = ("easting_offset", "northing_offset")
ACCURACIES = tuple(f"{band}_accuracy" for band in BANDS)
WAYS = dict(zip(BANDS, ("east", "north"), strict=True))
SCALE, TIE_POINTS, GEO_KEYS, GDAL_METADATA = 33550, 33922, 34735, 42112
MODEL_KEY, RASTER_KEY, PROJECTED_KEY, UNIT_KEY = 1024, 1025, 3072, 3076
PROJECTED, PIXEL_IS_POINT, USER_DEFINED, METRE = 1, 2, 32767, 9001
ROWS_PER_STRIP = 64


def gridshift_step(path):
    """PROJ's step for a file of shifts."""
    text = str(path)
    if "," in text:
        raise SettingsError(
            f"the folder of a publication is {text!r}",
            expected="a path without commas: they part the grids of a PROJ string",
            remedy="Name another folder, or where it will stand with installed_at",
        )
    # spaces part the words of a PROJ string
    return f'+proj=gridshift +grids="{text}"' if " " in text else _plain(text)


def _plain(text):
    return f"+proj=gridshift +grids={text}"


def write_gtg(path, grid, *, name, area, target):
    """Write a ShiftGrid; ``target``: the plane system of its shifts, or None."""
    tifffile = imported("tifffile", "GTG")
    size = np.sqrt(grid.variances[..., None] * np.diag(grid.shape))
    bands = np.concatenate([grid.shifts, size], axis=2).astype(np.float32)
    west, _, _, north = grid.bounds
    code = _epsg(target)
    keys = {
        MODEL_KEY: PROJECTED,
        RASTER_KEY: PIXEL_IS_POINT,
        PROJECTED_KEY: code or USER_DEFINED,
        UNIT_KEY: METRE,
    }
    directory = [1, 1, 0, len(keys)]
    for key, value in keys.items():
        directory += [key, 0, 1, value]
    tags = [
        (SCALE, "d", 3, (grid.cell, grid.cell, 0.0), True),
        (TIE_POINTS, "d", 6, (0.0, 0.0, 0.0, west, north, 0.0), True),
        (GEO_KEYS, "H", len(directory), directory, True),
        (GDAL_METADATA, "s", 0, _metadata(name, area, code), True),
    ]
    made = io.BytesIO()
    tifffile.imwrite(
        made,
        np.moveaxis(bands, 2, 0),
        planarconfig="separate",
        photometric="minisblack",
        compression="zlib",
        rowsperstrip=ROWS_PER_STRIP,
        metadata=None,
        software="",
        extratags=tags,
    )
    write_bytes(path, made.getvalue())


def _epsg(target):
    """Code of a system of EPSG, or None."""
    known = None if target is None else target.to_authority(min_confidence=100)
    if known is None or known[0] != "EPSG" or int(known[1]) >= USER_DEFINED:
        return None
    return int(known[1])


def _metadata(name, area, code):
    """What PROJ and GDAL read of the bands, as GDAL writes it."""
    # imported where a grid is written: no command waits for it
    from xml.etree import ElementTree as ET  # noqa: PLC0415

    root = ET.Element("GDALMetadata")

    def say(name, text, **more):
        ET.SubElement(root, "Item", name=name, **more).text = text

    say("TYPE", "HORIZONTAL_OFFSET")
    say("interpolation_method", "bilinear")
    say("grid_name", name)
    say("area_of_use", area)
    if code is not None:
        say("target_crs_epsg_code", str(code))
    for sample, band in enumerate(BANDS + ACCURACIES):
        of_band = {"sample": str(sample)}
        say("DESCRIPTION", band, role="description", **of_band)
        say("UNITTYPE", "metre", role="unittype", **of_band)
        if band in WAYS:
            say("positive_value", WAYS[band], **of_band)
    return ET.tostring(root).decode("ascii")  # TIFF knows no other letters
