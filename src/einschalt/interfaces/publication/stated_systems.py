"""Systems that users state of what they publish, and whether these can be true."""

import numpy as np

from einschalt.foundations.areas_of_use import area_of, in_area
from einschalt.foundations.coordinate_operations import system_label
from einschalt.foundations.errors import (
    ConsistencyError,
    ProjectionError,
    SettingsError,
    raise_problems,
)
from einschalt.foundations.projections import degrees_of, label_of, read_crs
from einschalt.pipeline.block.axis_order import own_axis_problems

ZONES_BEYOND = 10.0  # degrees beyond its area in which an old system is used


def require_systems(crs, source_crs):
    """Refuse systems that are none for coordinates of the ground, or of a frame."""
    for name, system in (("crs", crs), ("source_crs", source_crs)):
        try:
            if system is not None:
                read_crs(system)
        except ProjectionError as error:
            found = error.found.replace("crs", name, 1)
            raise error.with_facts(found=found) from error
    if source_crs is not None and crs is None:
        raise SettingsError(
            f"source_crs = {label_of(source_crs)}, and no crs",
            expected="the system of the ground as well, which is tied to the old one",
            remedy="Name it as crs, or leave source_crs out",
        )


def require_places(source, target, frames, files=(None, None)):
    """Refuse systems in whose areas points do not lie.

    ``source``, ``target``: DataFrames, x, y of the old frame (None of machine
    coordinates), easting, northing of the ground; ``files``: the names of both. The
    system of an old frame is used beyond its area, as YKJ is in the whole of Finland:
    some zones further on.
    """
    problems = []
    if frames.target is not None and len(target):
        problems += own_axis_problems(target, frames.target, files[1])[0]
    if frames.source_crs is not None and source is not None and len(source):
        system = read_crs(frames.source_crs)
        problems += _far_problems(source[["x", "y"]].to_numpy(), system, files[0])
    raise_problems(problems)


def _far_problems(points, system, file):
    """Say that most points of an old frame are nowhere near its system's area."""
    area = area_of(system)
    if area is None:
        return []
    longitude, latitude = degrees_of(*np.median(points, axis=0), system)
    if in_area(longitude, latitude, system, around=ZONES_BEYOND):
        return []
    west, south, east, north = area
    at = f"longitude {longitude:.2f}°, latitude {latitude:.2f}°"
    return [
        ConsistencyError(
            f"source_crs {system_label(system)} puts the points at {at}",
            expected=f"within {ZONES_BEYOND:g}° of its area, longitudes {west:g}° to "
            f"{east:g}°, latitudes {south:g}° to {north:g}°",
            remedy="Correct source_crs, or leave it out: the frame is then one of its "
            "own",
            file=file,
        )
    ]


def require_system_of_block(crs, source_crs, own_crs):
    """Refuse systems that the models of a block do not have.

    ``crs``: of the ground, as users state it; ``own_crs``: that of the block, or None.
    Heights aside: they change nothing in plan.
    """
    if source_crs is not None:
        raise SettingsError(
            f"source_crs = {label_of(source_crs)} for the models of a block",
            expected="none: they have machine coordinates",
        )
    require_systems(crs, None)
    if None in (crs, own_crs) or _plan(crs) == _plan(own_crs):
        return
    raise SettingsError(
        f"crs = {label_of(crs)} for the models of a block in {label_of(own_crs)}",
        expected="the system of the block, into which its models lead",
        remedy="Leave crs out: PROJ goes on from there to every other system",
    )


def _plan(crs):
    return read_crs(crs).to_2d()
