"""Points from intersecting rays: the terrestrial way to a control point.

From known stations the directions to a new point were measured (theodolite, or
terrestrial photographs). Each ray passes the adjusted point at a linear deviation e,
its distance from the point at right angles. An error of direction, equal for all rays,
shifts a ray in proportion to the distance d, hence the weights 1 / d², and

    Σ (e / d)² = min .

Distances are needed for the weights only, so roughly: a distance that is not known can
be had from the parallactic angle under which a known transverse shift appears.

Source: tail of an article in Schweizerische Zeitschrift für Vermessung 49 (1951) 11;
only its last page is at hand, with weights, deviations and one distance.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import segment_sum
from einschalt.theory.adjustment.least_squares import standard_error_of_unit_weight

N_COORDINATES = 2
MOST_ITERATIONS = 50
CONVERGED = 1e-10
"""Largest change of a distance in the last iteration, in parts of it."""
SMALLEST_ANGLE = 1e-3
"""Under which the rays must meet at least [rad]."""


@dataclass(frozen=True, eq=False)
class RayIntersection:
    """Intersected points with their precision."""

    # (n_points, 2): easting, northing; NaN where the rays do not determine them
    point: np.ndarray
    # (n_points, 2, 2): times the variance of a direction [rad²] it is the covariance
    cofactor: np.ndarray
    # (n_points,): of one direction, from the deviations [rad]; NaN without redundancy
    sigma_0: np.ndarray
    # (n_rays,): distance of the point from each ray, positive to the right of it [m]
    deviation: np.ndarray
    # (n_rays,): from each station to the point, as used in the weights
    distance: np.ndarray
    weight: np.ndarray  # (n_rays,): 1 / distance²
    # of bool, (n_rays,): the point lies behind the station, against the ray
    is_behind: np.ndarray

    @property
    def is_determined(self):
        """Whether the rays determine the point, ndarray of bool (n_points,)."""
        return np.isfinite(self.point[:, 0])

    @property
    def covariance(self):
        """Covariance of the points from their own deviations, (n_points, 2, 2)."""
        return self.cofactor * self.sigma_0[:, np.newaxis, np.newaxis] ** 2


def intersect_rays(station, azimuth, point_start, distance=None):
    """Intersect the rays of many points.

    Parameters
    ----------
    station : ndarray, shape (n_rays, 2)
        Easting, northing of the station of each ray [m], sorted by new point.
    azimuth : ndarray, shape (n_rays,)
        Of each ray, clockwise from north [rad].
    point_start : ndarray of int, shape (n_points + 1,)
        Point k owns rays point_start[k]:point_start[k + 1].
    distance : ndarray, shape (n_rays,), optional
        For the weights [m]; otherwise those of the adjusted points, by iteration.

    Returns
    -------
    RayIntersection
        NaN for a point with fewer than two rays, or with rays that are parallel.

    Notes
    -----
    Cost: one pass per iteration; four or five are usual.

    Examples
    --------
    >>> rays = intersect_rays(
    ...     np.array([[0.0, 0.0], [300.0, 0.0]]), np.radians([45.0, -45.0]),
    ...     np.array([0, 2]))
    >>> rays.point.round(9).tolist()
    [[150.0, 150.0]]
    """
    station = np.asarray(station, dtype=float)
    azimuth = np.asarray(azimuth, dtype=float)
    count = np.diff(point_start)
    along = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    # reduced to the first station of each point: nothing is lost to large coordinates
    has_rays = count > 0
    origin = np.zeros((len(count), 2))
    origin[has_rays] = station[point_start[:-1][has_rays]]
    rays = _Rays(station - np.repeat(origin, count, axis=0), along, point_start)
    with np.errstate(divide="ignore", invalid="ignore"):
        # a point in a station has no distance from it, and becomes NaN
        if distance is None:
            distance = _distances(rays)
        weight = 1.0 / np.asarray(distance, dtype=float) ** 2
        cofactor = rays.cofactor(weight)
        point = rays.point(weight)
    towards = rays.towards(point)
    deviation = np.sum(rays.right * towards, axis=1)
    redundancy = np.where(np.isfinite(point[:, 0]), count - N_COORDINATES, 0)
    squares = segment_sum(weight * deviation**2, point_start)
    return RayIntersection(
        point=point + origin,
        cofactor=cofactor,
        sigma_0=standard_error_of_unit_weight(squares, redundancy),
        deviation=deviation,
        distance=np.asarray(distance, dtype=float),
        weight=weight,
        is_behind=np.sum(along * towards, axis=1) < 0.0,
    )


def distance_from_parallax(transverse_shift, parallactic_angle):
    """Distance at which a transverse shift appears under a small angle [m].

    The shift [m] of the station, or of the target, is at right angles to the ray; 1 /
    distance² is the weight of the ray.

    Examples
    --------
    8.5 cm under ten centesimal seconds, 1e-3 gon:

    >>> round(distance_from_parallax(0.085, 1e-3 * np.pi / 200.0))
    5411
    """
    return transverse_shift / np.tan(parallactic_angle)


@dataclass(frozen=True, eq=False)
class _Rays:
    """Rays of all points: feet, unit vectors, and where each point's rays begin."""

    foot: np.ndarray
    along: np.ndarray
    start: np.ndarray

    @property
    def right(self):
        """Unit vectors to the right of the rays."""
        return np.stack([self.along[:, 1], -self.along[:, 0]], axis=1)

    def cofactor(self, weight):
        """Inverse normal matrices; NaN where the rays are parallel."""
        outer = self.right[:, :, np.newaxis] * self.right[:, np.newaxis]
        directions = np.linalg.eigvalsh(segment_sum(outer, self.start))
        # for two rays the smaller eigenvalue is 2 sin² of half of their angle
        is_open = directions[:, 0] > 2.0 * (SMALLEST_ANGLE / 2.0) ** 2
        normal = segment_sum(outer * weight[:, np.newaxis, np.newaxis], self.start)
        determinant = np.linalg.det(normal)
        trace = np.trace(normal, axis1=1, axis2=2)[:, None, None]
        inverse = (trace * np.eye(2) - normal) / determinant[:, np.newaxis, np.newaxis]
        return np.where(is_open[:, np.newaxis, np.newaxis], inverse, np.nan)

    def point(self, weight):
        """Points with the least weighted sum of squared deviations."""
        offset = np.sum(self.right * self.foot, axis=1) * weight
        total = segment_sum(self.right * offset[:, np.newaxis], self.start)
        return np.einsum("pij,pj->pi", self.cofactor(weight), total)

    def towards(self, point):
        """From the station of each ray to its point."""
        return np.repeat(point, np.diff(self.start), axis=0) - self.foot


def _distances(rays):
    """Distances to the points whose weights are those of these very distances."""
    distance = np.ones(len(rays.foot))
    for _ in range(MOST_ITERATIONS):
        before = distance
        distance = np.hypot(*rays.towards(rays.point(1.0 / before**2)).T)
        change = np.abs(distance - before) / distance
        if not np.any(change > CONVERGED):
            break
    return distance
