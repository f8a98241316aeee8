"""Where reference systems are used, as EPSG states it, and whether points lie there.

An area over the antimeridian ends west of where it begins: New Zealand's from 160.6° to
-171.2°, North America's from 167.65° to -40.73°.
"""

from functools import lru_cache

import numpy as np
from pyproj.enums import TransformDirection
from pyproj.exceptions import ProjError

from einschalt.foundations.coordinate_operations import offline
from einschalt.foundations.longitudes import FULL_CIRCLE, eastern_end
from einschalt.foundations.projections import read_source_crs, to_degrees

INVERSE = TransformDirection.INVERSE
MARGIN = 0.1  # of the area's width: surveys reach a little over the border
# zones are kept beyond theirs, as 32 in Bavaria to 13.84° E, 0.17 of its width; of
# countries are few as tall, and their neighbours have systems of their own
MARGIN_OF_ZONES, TALL = 0.2, 3.0


def area_of(crs):
    """Area of use of a system: west, south, east, north [degrees], or None.

    East is less than west where it lies over the antimeridian. That of all its usages:
    Finland's YKJ is used in its zone on large maps, and in the whole country on small
    ones.
    """
    plane = (crs.sub_crs_list or [crs])[0]
    plane = plane.source_crs if plane.is_bound else plane
    stated = plane.to_json_dict()
    usages = [one["bbox"] for one in stated.get("usages", [stated]) if "bbox" in one]
    if not usages:
        return None
    west, south, east, north = (
        [box[f"{side}itude"] for box in usages]
        for side in ("west_long", "south_lat", "east_long", "north_lat")
    )
    furthest = max(eastern_end(*pair) for pair in zip(west, east, strict=True))
    east = furthest - FULL_CIRCLE if furthest > FULL_CIRCLE / 2.0 else furthest
    return min(west), min(south), east, max(north)


@lru_cache(maxsize=1024)  # PROJ takes 60 ms, and each block of a batch asks for it
def _extent_of(crs):
    """Area of use of a system, in its own coordinates, with a margin.

    Smallest easting, smallest northing, largest easting, largest northing, in its
    units; None where the system states no area of use, or PROJ does not have its
    projection. Longitudes go on beyond 180° where it lies over the antimeridian.
    """
    area = area_of(crs)
    if area is None:
        return None
    west, south, east, north = area
    area = west, south, eastern_end(west, east), north
    with offline():
        try:
            # the way back of what places are found with: to look for one takes 40 ms
            bounds = to_degrees(crs).transform_bounds(*area, direction=INVERSE)
        except ProjError:  # PROJ has not the projection of every system that EPSG lists
            return None
    if not np.all(np.isfinite(bounds)):
        return None
    west, south, east, north = bounds
    is_zone = not crs.is_geographic and north - south > TALL * (east - west)
    wide = (MARGIN_OF_ZONES if is_zone else MARGIN) * (east - west)
    high = MARGIN * (north - south)
    return west - wide, south - high, east + wide, north + high


def in_extent(easting, northing, crs):
    """Whether points lie in the extent of a system, in its own coordinates.

    That of its area of use with a margin; None where the system states none.
    """
    system = read_source_crs(crs)
    extent = _extent_of(system)
    if extent is None:
        return None
    circle = None
    if system.is_geographic:
        circle = 2.0 * np.pi / system.axis_info[0].unit_conversion_factor
    return _within(extent, easting, northing, circle)


def in_area(longitude, latitude, crs, around=0.0):
    """Whether places lie in the area of use of a system, or ``around`` it [degrees].

    None where the system states none.
    """
    area = area_of(crs)
    if area is None:
        return None
    west, south, east, north = area
    east = eastern_end(west, east)
    bounds = west - around, south - around, east + around, north + around
    return _within(bounds, longitude, latitude, FULL_CIRCLE)


def _within(bounds, easting, northing, circle):
    """Whether points lie within bounds; longitudes are the same after a full circle."""
    west, south, east, north = bounds
    easting, northing = np.asarray(easting, float), np.asarray(northing, float)
    is_inside = (northing >= south) & (northing <= north)
    if circle is not None:
        is_inside &= np.abs(easting) <= circle  # metres are no longitudes
        with np.errstate(invalid="ignore"):  # infinite where a point has no place
            easting = west + np.mod(easting - west, circle)
    return is_inside & (easting >= west) & (easting <= east)
