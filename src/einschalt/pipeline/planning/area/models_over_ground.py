"""Which points show in the models of a flight, over ground as it is."""

from dataclasses import replace

import numpy as np

from einschalt.pipeline.simulation.layout import turn
from einschalt.theory.planning.points_shown import points_shown


def shown(flown, geometry, position, ground=None, *, rises=1.0):
    """Say which points show in which models of a flight.

    ``position`` (n, 2) of the points, and their heights ``ground`` (n,) [m]; by the
    altitudes of the cameras, without heights (None) as on level ground. What lies
    higher than planned is taken to rise so many times as much.
    """
    planned = geometry.principal_distance * flown.scale_number
    sides, base = _sides_and_base(flown, geometry)
    altitude = flown.camera_altitude(geometry)
    if ground is None:
        altitude, ground = np.full(flown.n_models, planned), np.zeros(len(position))
    parts, first = [], 0
    for k, raster in enumerate(flown.rasters):
        is_own = flown.coverage == k
        n_own, places = np.count_nonzero(is_own), flown.place[is_own]
        n_along, n_across = raster.shape
        height = np.full(n_along * n_across, -np.inf)
        height[places] = altitude[is_own]
        number = np.full(len(height), -1)
        number[places] = np.arange(first, first + n_own)
        centre, point = points_shown(
            *(raster.along, raster.across, height.reshape(n_across, n_along)),
            *(turn(position, -raster.direction), ground),
            *(planned, sides, base, rises),
        )
        parts.append((number[centre], point))
        first += n_own
    model, point = (np.concatenate(part) for part in zip(*parts, strict=True))
    return replace(flown, model=model, point=point)


def half_at(depth, flown, geometry):
    """Half extents of a model of two images, so many times as deep as planned [m]."""
    sides, base = _sides_and_base(flown, geometry)
    return (depth * sides - base) / 2.0


def _sides_and_base(flown, geometry):
    """What an image shows of the ground along and across, and the base there [m]."""
    sides = np.array([geometry.image_format, geometry.across])
    seen = flown.scale_number * (sides - 2.0 * geometry.unusable_rim)
    return seen, flown.scale_number * np.array([geometry.image_base, 0.0])


def risen(depth, rises):
    """Depth of ground as if all that is higher than planned rose more."""
    return np.where(depth < 1.0, 1.0 - rises * (1.0 - depth), depth)
