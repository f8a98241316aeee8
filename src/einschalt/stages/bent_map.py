"""What a map makes of straight lines, as arrays.

A model is a true likeness of the terrain, up to its scale; easting, northing and height
are not. See :mod:`einschalt.stages.curved_earth`, where flights are bent by this.
"""

import numpy as np

from einschalt.foundations.batches import segment_sum
from einschalt.foundations.projections import (
    from_geocentric,
    read_crs,
    scale_gradient,
    to_geocentric,
)

LEAST = 1e-3  # metres: the largest movement of a flight that is not worth it
# a likeness tells where models lie, rigid ones in whichever unit they are
PLACED_BY = {"rigid": "helmert", "helmert_film_affinity": "helmert"}
N_SPACE = 3  # coordinates of a spatial model
MODEL_RADIUS_M = 0.134  # to the corners of what two photographs of 23 cm share, 60 %


def bends_plane_models(places, scale_number, crs):
    """Whether the map bends plane models of a scale by a millimetre at some places.

    ``places``, shape (n, 2): easting, northing [m], of which the outermost count.
    """
    system = read_crs(crs)
    if not len(places) or not system.is_projected:
        return False
    outermost = zip(places.min(axis=0), places.max(axis=0), strict=True)
    corners = np.stack(np.meshgrid(*outermost), axis=-1).reshape(-1, 2)
    radius = MODEL_RADIUS_M * scale_number
    bent = scale_gradient(corners, system) * radius**2 / 2.0
    return bool(np.any(bent > LEAST))


def is_of_the_earth(crs):
    """Whether a block with this system (str or None) lies on the curved Earth."""
    return crs is not None and not read_crs(crs).is_engineering


def flat_system(crs):
    """Leave out what a system (read) has of heights."""
    return (crs.sub_crs_list or [crs])[0]


def moved_coordinates(xyz, place, fit, crs):
    """Coordinates of points in their models, moved, and how far on the ground [m].

    ``xyz`` (n, n_axes), each in the model ``place`` (n,) of a fit that has ``fit`` and
    ``observed`` as a ModelTransformation; NaN where the map does not reach.
    """
    ground = fit.fit.apply(place, xyz)
    bent = _in_map(ground, place, fit, crs)
    return fit.fit.invert(place, bent), np.linalg.norm(bent - ground, axis=1)


def _in_map(ground, place, fit, crs):
    """Map coordinates of points that are given in Cartesian ones of their model.

    These have their origin and their axes where the middle of the model's points has
    easting, northing and height. Plane ones have the scale of the map there as well:
    then only what bends a model moves it, and no transformation takes that up.
    """
    middles = _middles(fit)
    away, n_axes = ground - middles[place], middles.shape[1]
    if n_axes == N_SPACE:
        origin, axes = _cartesian_frames(middles, crs)
    else:
        at_zero = np.column_stack([middles, np.zeros(len(middles))])
        origin, axes = to_geocentric(at_zero, crs)
    geocentric = origin[place] + np.einsum(
        "nij,nj->ni", axes[place][..., :n_axes], away
    )
    return from_geocentric(geocentric, crs)[:, :n_axes]


def _cartesian_frames(middles, crs):
    """Geocentric origins (n, 3), and axes (n, 3, 3) as columns, of Cartesian frames."""
    origin, jacobian = to_geocentric(middles, crs)
    return origin, jacobian / np.linalg.norm(jacobian, axis=1, keepdims=True)


def straightened(points, middle, crs):
    """Cartesian coordinates of points on the map, which a model is a likeness of.

    ``points`` (n, 3): easting, northing, height above the ellipsoid [m]; ``middle``
    (3,): where both are the same, and have the same axes.
    """
    system = flat_system(read_crs(crs))
    origin, axes = _cartesian_frames(np.asarray(middle, dtype=float)[None], system)
    geocentric, _ = to_geocentric(points, system)
    return middle + (geocentric - origin) @ axes[0]


def straightened_in_plan(points, middle, crs):
    """The same of plane points (n, 2) at height 0, in the scale of the map there."""
    system = flat_system(read_crs(crs))
    at_zero = np.column_stack([np.vstack([middle, points]), np.zeros(len(points) + 1)])
    geocentric, axes = to_geocentric(at_zero, system)
    axes = axes[0, :, :2]
    away = (geocentric[1:] - geocentric[0]) @ axes / (axes**2).sum(axis=0)
    return middle + away


def _middles(fit):
    """Mean of the known points of each model, (n_models, 3); NaN without any."""
    start = fit.observed.start
    count = np.diff(start)[:, None].astype(float)
    sums = segment_sum(fit.observed.target, start)
    return np.divide(sums, count, out=np.full(sums.shape, np.nan), where=count > 0.0)
