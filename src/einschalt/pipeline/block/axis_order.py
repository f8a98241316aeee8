"""Easting and northing exchanged: told by the area of use of the system."""

import numpy as np

from einschalt.foundations import tables
from einschalt.foundations.errors import ConsistencyError, ProjectionError
from einschalt.foundations.projections import extent_of


def axis_problems(frame, crs, source):
    """Points whose easting and northing are exchanged, told by the area of use.

    Problems, and notes of how many points lie outside either way; ``source`` is the
    file.
    """
    try:
        extent = extent_of(crs) if crs else None
    except ProjectionError:  # said by check_facts
        extent = None
    if extent is None:
        return [], []
    east, north = frame["easting"].to_numpy(), frame["northing"].to_numpy()
    is_outside = ~_inside(east, north, extent)
    is_swapped = is_outside & _inside(north, east, extent)

    def problem(place):
        return ConsistencyError(
            f"easting {east[place]:.3f}, northing {north[place]:.3f} lies outside the "
            f"area of {crs}, and inside with the two exchanged",
            expected="easting, northing in this order",
            remedy="Exchange the two columns, or correct crs",
            file=source,
            **tables.row_location(frame, place),
        )

    rest = "easting and northing are exchanged"
    problems = tables.listed(np.flatnonzero(is_swapped), problem, rest, source)
    n_far = int((is_outside & ~is_swapped).sum())
    far = f"{n_far} of {len(frame)} points lie outside the area of use of {crs}"
    return problems, [f"{source}: {far}"] if n_far else []


def _inside(easting, northing, extent):
    west, south, east, north = extent
    return (
        (easting >= west)
        & (easting <= east)
        & (northing >= south)
        & (northing <= north)
    )
