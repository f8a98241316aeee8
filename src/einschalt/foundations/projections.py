"""Coordinate reference systems, at the edge (pyproj).

Ground coordinates are easting, northing everywhere, whatever the axis order of the
authority: Austrian systems list the northing first.
"""

from functools import lru_cache

import numpy as np
import pyproj

from einschalt.foundations.arguments import described
from einschalt.foundations.errors import ProjectionError

NAMES = str | int | pyproj.CRS  # what may name a system
CODE_BITS = 32
MARGIN = 0.1  # of the area's width: surveys reach a little over the border


def read_crs(text):
    """Understand the name of a projected coordinate reference system.

    Parameters
    ----------
    text : str
        ``EPSG:31255``, a PROJ string or WKT.

    Returns
    -------
    pyproj.CRS

    Raises
    ------
    ProjectionError
        It is unknown, or it is not a plane system in metres.
    """
    try:
        crs = pyproj.CRS.from_user_input(_utf8(text))
    except (pyproj.exceptions.CRSError, UnicodeEncodeError) as error:
        raise ProjectionError(
            f"crs = {described(text)} is unknown",
            expected="an EPSG code such as 'EPSG:31255', a PROJ string or WKT",
            remedy="Look the code up, or leave crs out for a local system",
        ) from error
    is_plane = not crs.is_geographic and not crs.is_geocentric
    units = {axis.unit_name for axis in crs.axis_info[:2]}
    if not is_plane or (units and units != {"metre"}):
        axes = ", ".join(sorted(units))
        raise ProjectionError(
            f"crs = {described(text)} ({crs.name}) has axes in {axes}",
            expected="a plane system in metres",
            remedy="Name the projected system of the coordinates",
        )
    return crs


def _utf8(name):
    """Pass on what names a system, and nothing that PROJ would choke on."""
    if not isinstance(name, NAMES) or isinstance(name, bool):
        raise pyproj.exceptions.CRSError(f"{type(name).__name__} names no system")
    if isinstance(name, int) and name.bit_length() > CODE_BITS:
        raise pyproj.exceptions.CRSError("no authority has so long a code")
    # the library ends at a NUL, and takes what stands before it
    if isinstance(name, str) and "\0" in name:
        raise pyproj.exceptions.CRSError("NUL in the name")
    return name


def crs_name(crs):
    """Name of a system as text, however it was given.

    Parameters
    ----------
    crs : str, int or pyproj.CRS

    Returns
    -------
    str
        As given where it is text, else ``EPSG:31255`` or WKT.
    """
    return crs if isinstance(crs, str) else read_crs(crs).to_string()


def reproject(easting, northing, source_crs, target_crs):
    """Bring plane coordinates from one system into another.

    Parameters
    ----------
    easting, northing : ndarray, shape (n_points,)
        Coordinates in the source system [m].
    source_crs, target_crs : str or pyproj.CRS

    Returns
    -------
    easting, northing : ndarray, shape (n_points,)
        Coordinates in the target system [m].
    accuracy : float
        Accuracy that PROJ states for the operation [m], NaN where it states none.

    Raises
    ------
    ProjectionError
        The best known operation needs a grid that is not installed, or a point has
        no image in the target system.
    """
    source, target = read_crs(source_crs), read_crs(target_crs)
    try:
        transformer = pyproj.Transformer.from_crs(
            source, target, always_xy=True, only_best=True
        )
        east, north = transformer.transform(easting, northing, errcheck=True)
    except pyproj.exceptions.ProjError as error:
        raise ProjectionError(
            f"{source.name} cannot be brought into {target.name}: {error}",
            remedy="Install the grid that PROJ names, or give the coordinates in the "
            "system of the block",
        ) from error
    accuracy = transformer.accuracy
    return (
        np.asarray(east),
        np.asarray(north),
        accuracy if accuracy is not None and accuracy >= 0 else np.nan,
    )


def extent_of(crs):
    """Area of use of a plane system, in its own coordinates, with a margin.

    Parameters
    ----------
    crs : str or pyproj.CRS

    Returns
    -------
    tuple of float or None
        Smallest easting, smallest northing, largest easting, largest northing [m];
        None where the system states no area of use.
    """
    return _extent_of(read_crs(crs))


@lru_cache(maxsize=64)  # PROJ takes 60 ms, and each block of a batch asks for it
def _extent_of(crs):
    area = crs.area_of_use
    if area is None:
        return None
    transformer = pyproj.Transformer.from_crs("OGC:CRS84", crs, always_xy=True)
    bounds = transformer.transform_bounds(area.west, area.south, area.east, area.north)
    if not np.all(np.isfinite(bounds)):
        return None
    west, south, east, north = bounds
    wide, high = MARGIN * (east - west), MARGIN * (north - south)
    return west - wide, south - high, east + wide, north + high
