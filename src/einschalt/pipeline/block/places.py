"""Where ground coordinates lie, if their system is the one that was named.

A block in the neighbouring zone, outside the area of use, or in a system that shows
lengths half as long again as they are, would be computed to the last digit, and wrong.
"""

from itertools import product

import numpy as np

from einschalt.foundations.areas_of_use import area_of, in_area, in_extent
from einschalt.foundations.coordinate_operations import system_label
from einschalt.foundations.errors import ConsistencyError, ProjectionError
from einschalt.foundations.likely_systems import likely_sources, likely_systems
from einschalt.foundations.projections import degrees_of, scale_range

# of a length: national systems keep within a few tenths of a per cent
WORST_SCALE = 0.01
LEAST_SHARE = 0.5  # of the points that lie outside of the area
ANGLES = {"degree": 1.0, "radian": 180.0 / np.pi, "grad": 0.9}  # in degrees
DEGREES_AROUND = 1.0  # beyond an area of use, for control along the border


def place_problems(easting, northing, crs, source):
    """Say what is wrong with a system for the points that are given in it.

    At most one problem: most points lie outside the area of use, or lengths are
    distorted. ``source`` is the file.
    """
    is_inside = in_extent(easting, northing, crs)
    if is_inside is not None and np.mean(~is_inside) > LEAST_SHARE:
        angles = _angles(easting, northing, crs, source)
        return [angles or _outside(easting, northing, crs, source)]
    return scale_problems(easting, northing, crs, source)


def scale_problems(easting, northing, crs, source):
    """Say that a system shows lengths longer or shorter than they are, at points."""
    found = scale_range(easting, northing, crs)
    if found is None or max(1.0 - found[0], found[1] - 1.0) < WORST_SCALE:
        return []
    worst = max(found, key=lambda scale: abs(np.log(scale)))
    return [
        ConsistencyError(
            f"{system_label(crs)} shows lengths there {worst:.3g} times as "
            "long as they are",
            expected=f"a system true to scale within {WORST_SCALE:.0%}",
            remedy="Take the national system or the UTM zone of the place as crs of "
            "the block, and transform its points into it",
            file=source,
        )
    ]


def _angles(easting, northing, crs, source):
    """Say that coordinates are angles in another unit than the system's, or None.

    So they are where they lie near its area of use as angles of that unit, in the one
    order or the other.
    """
    own = crs.axis_info[0].unit_name
    middle = np.array([np.median(easting), np.median(northing)])
    orders = {"longitude and latitude": middle, "latitude and longitude": middle[::-1]}
    for (unit, size), (axes, angles) in product(ANGLES.items(), orders.items()):
        if unit == own or not in_area(*angles * size, crs, DEGREES_AROUND):
            continue
        geographic = system_label((crs.sub_crs_list or [crs])[0].geodetic_crs)
        ways = [f"Multiply them by {size:.10g} for degrees"] if size != 1.0 else []
        if not crs.is_geographic:
            # lists of receivers lie 100 m beside those of the old survey
            ways.append(
                f"Call the columns {axes}, and name as their crs the system that they "
                f"are in: WGS 84 (EPSG:4326) of many receivers, or {geographic}"
            )
        remedy = ". ".join(ways) or f"Convert them to {own}"
        first = "longitude" if crs.is_geographic else "easting"
        second = "latitude" if crs.is_geographic else "northing"
        return ConsistencyError(
            f"the points, about {first} {middle[0]:.4f}, {second} {middle[1]:.4f}, "
            f"are {axes} in {unit}s, as which they lie in the area of use of "
            f"{system_label(crs)}",
            expected=f"{own}s",
            remedy=remedy,
            file=source,
        )
    return None


def _outside(easting, northing, crs, source):
    middle = np.median(easting), np.median(northing)
    fitting, there = likely_systems(easting, northing, crs)
    plane, degrees = ("easting", "northing"), ("longitude", "latitude")
    names, digits = (degrees, 2) if crs.is_geographic else (plane, 0)
    ways = []
    if len(fitting) == 1:
        ways.append(f"These coordinates fit {fitting[0]}: correct crs")
    elif fitting:
        several = ", ".join(fitting)
        ways.append(f"These coordinates may be in one of {several}: correct crs")
    if there:
        ways.append(f"The place belongs to {', '.join(there)}: transform into that")
    ways += _with_other_signs(easting, northing, crs)
    remedy = ". Or: ".join(ways) or "Check crs, and the unit of the coordinates"
    return ConsistencyError(
        f"the points, about {names[0]} {middle[0]:.{digits}f}, {names[1]} "
        f"{middle[1]:.{digits}f}, lie outside the area of use of {system_label(crs)}",
        expected=_area(crs),
        remedy=remedy,
        file=source,
    )


def _with_other_signs(easting, northing, crs):
    """What to do where points that count to the south and west lie in the area."""
    if in_extent(-np.median(northing), -np.median(easting), crs):
        return ["Exchange the two columns, and write a minus before both"]
    if in_extent(-np.median(easting), -np.median(northing), crs):
        return ["Write a minus before both"]
    return []


def _area(crs):
    west, south, east, north = area_of(crs)
    if east < west:
        return (
            f"longitudes {west:g}° over 180° to {east:g}°, "
            f"latitudes {south:g}° to {north:g}°"
        )
    return f"longitudes {west:g}° to {east:g}°, latitudes {south:g}° to {north:g}°"


def target_problems(points, source_crs, target_crs, source):
    """Say that points of another system lie outside the area of the block's.

    ``points``, shape (n_points, n_axes), in their own system.
    """
    if area_of(target_crs) is None or source_crs.is_engineering:
        return []
    east, north = np.median(points[:, :2], axis=0)
    longitude, latitude = degrees_of(east, north, source_crs)
    if in_area(longitude, latitude, target_crs, DEGREES_AROUND):
        return []
    likely = likely_sources(east, north, source_crs, target_crs)
    remedy = "Correct crs of the points, or that of the block"
    if likely:
        meant = ", ".join(likely)
        remedy = f"Correct crs of the points to {meant}, or that of the block"
    if source_crs.is_geographic and in_area(latitude, longitude, target_crs, 0.0):
        remedy = (
            "Exchanged they lie in it: call the columns the other way round; a layer "
            "has the longitude first"
        )
    return [
        ProjectionError(
            f"{system_label(source_crs)} puts the points at longitude "
            f"{longitude:.2f}°, latitude {latitude:.2f}°, outside the area of "
            f"{system_label(target_crs)}",
            expected=_area(target_crs),
            remedy=remedy,
            file=source,
        )
    ]
