"""Easting and northing exchanged, or of another place: told by the area of use."""

import numpy as np

from einschalt.foundations import tables
from einschalt.foundations.coordinate_operations import system_label
from einschalt.foundations.errors import ConsistencyError, ProjectionError
from einschalt.foundations.projections import extent_of, read_crs
from einschalt.pipeline.block.places import place_problems

PLANE = ("easting", "northing")


def axis_problems(frame, crs, source):
    """Points that do not lie where their system is used, most often exchanged axes.

    Problems, and notes of how many points lie outside either way; ``source`` is the
    file.
    """
    try:
        return own_axis_problems(frame, read_crs(crs), source) if crs else ([], [])
    except ProjectionError:  # said by check_facts
        return [], []


def own_axis_problems(frame, system, source):
    """The same for points in a system of their own.

    Longitude and latitude of a geographic one stand as easting and northing.
    """
    axes = ("longitude", "latitude") if system.is_geographic else PLANE
    east, north = (frame[name].to_numpy() for name in PLANE)
    extent, label = extent_of(system), system_label(system)
    is_outside = is_swapped = np.zeros(len(frame), dtype=bool)
    if extent is not None:
        is_outside = ~_inside(east, north, extent)
        is_swapped = is_outside & _inside(north, east, extent)

    def problem(place):
        return ConsistencyError(
            f"{axes[0]} {east[place]:.3f}, {axes[1]} {north[place]:.3f} lies outside "
            f"the area of {label}, and inside with the two exchanged",
            expected=f"{axes[0]}, {axes[1]} in this order",
            remedy="Exchange the two columns, or correct crs",
            file=source,
            **tables.row_location(frame, place),
        )

    rest = f"{axes[0]} and {axes[1]} are exchanged"
    problems = tables.listed(np.flatnonzero(is_swapped), problem, rest)
    if not problems:
        problems = place_problems(east, north, system, source)
    n_far = int((is_outside & ~is_swapped).sum())
    far = f"{n_far} of {len(frame)} points lie outside the area of use of {label}"
    return problems, [f"{source}: {far}"] if n_far and not problems else []


def tells_axes(frame, system):
    """Whether a system tells easting from northing: exchanged, points lie outside.

    Of Austria's Lambert system, or Britain's grid, the area holds many points either
    way. ``frame``: as for :func:`own_axis_problems`.
    """
    extent = extent_of(system)
    east, north = (frame[name].to_numpy() for name in PLANE)
    return extent is not None and not _inside(north, east, extent).all()


def _inside(easting, northing, extent):
    west, south, east, north = extent
    return (
        (easting >= west)
        & (easting <= east)
        & (northing >= south)
        & (northing <= north)
    )
