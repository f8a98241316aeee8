"""A region of given points that is displaced: what it is called by.

See ``displaced_region`` for what it does to a block.
"""

from dataclasses import dataclass, fields, replace
from enum import Enum, auto

import numpy as np
from scipy.spatial import cKDTree

from einschalt.foundations.frame_columns import values_of
from einschalt.stages.error_propagation.given_points import PLAN
from einschalt.theory.adjustment.least_squares import total_from_coordinate

# of the other points: of two parts as large as this nothing tells which one is off
LARGEST_PART = 1.0 / 2.0
SURELY = 3.0  # standard errors by which a shift may be less than it seems
OF_MEDIAN = 1.25  # its standard error by that of a mean
# of a shift: known points tell of it if the error of their median is less
CLEAR = 1.0 / 6.0


class Part(Enum):
    """Which part of given points is off."""

    REGION = auto()
    OTHERS = auto()
    UNKNOWN = auto()


@dataclass(frozen=True)
class GivenRegion:
    """Points that are given too far in one direction, against all others."""

    point_ids: tuple[str, ...]  # those nearest to its middle first
    n_given: int  # points of their kind in all
    middle: tuple[float, float]  # easting, northing [m]
    extent: float  # largest distance across [m], along easting or northing
    shift: tuple[float, float]  # easting, northing [m]
    standard_error: float  # of each coordinate of the shift [m]
    p_value: float  # by chance, of all regions that were tried together
    # control points in it; of a region of control the check points
    control_ids: tuple[str, ...]
    control_is_alike: bool  # whether these are displaced as well
    # points of their kind in no region that is displaced, and of a region of control
    # the check points that have not moved with it
    n_elsewhere: int
    # from the middle of all to its own, over the extent of all: east, north
    direction: tuple[float, float] = (0.0, 0.0)
    is_of_control: bool = False  # whether it is control, and no approximate points
    is_decided: bool = False  # whether known points tell that it is off, or the others
    # whether its points lie among the others: nearest to most of them is none of it
    is_scattered: bool = False

    @property
    def size(self):
        """Length of the shift [m]."""
        return float(np.hypot(*self.shift))

    @property
    def may_be_the_others(self):
        """Whether nothing tells which part is off: it, or those in no region.

        Check points that have moved with a part of the control belong to it.
        """
        n_inside = len(self.point_ids)
        n_inside += len(self.control_ids) if self.is_of_control else 0
        return not self.is_decided and is_large(n_inside, self.n_elsewhere)


def is_large(n_inside, n_elsewhere):
    """Whether a region is so large that the others may be off instead."""
    return n_inside > LARGEST_PART * n_elsewhere


def exceeds_stated(regions, errors):
    """Whether each shift surely exceeds what is stated of points, which may be shared.

    ``errors`` (n,) of one coordinate of the given points [m].
    """
    return all(
        np.hypot(*region.shift) - SURELY * region.standard_error
        > total_from_coordinate(np.median(errors[region.rows]))
        for region in regions
    )


@dataclass(frozen=True, eq=False)
class KnownPoints:
    """Points that are known by themselves, beside a region and its surroundings."""

    point_ids: np.ndarray  # (n,)
    is_inside: np.ndarray  # (n,)
    # (n, 2): as the given points, or the block, have them, less as they are known [m]
    misses: np.ndarray
    errors: np.ndarray  # (n,): of one coordinate of these [m]

    def picked(self, rows):
        """Some of them, by a mask."""
        values = (getattr(self, each.name) for each in fields(self))
        return KnownPoints(*(value[rows] for value in values))

    def contradict(self, shift):
        """Whether they are missed by a shift; None where they are too few to tell."""
        n, size = len(self.misses), float(np.hypot(*shift))
        if not n:
            return None
        error = OF_MEDIAN * np.median(self.errors) / np.sqrt(n)
        if not error < CLEAR * size:
            return None
        return bool(np.median(self.misses @ shift) > 0.5 * size**2)


def which_part(shift, known, *, is_large) -> Part:
    """Tell by known points whether a region is off, or all others.

    Where those of one part contradict what is given there, and those of the other do
    not, that part is off; and of two large parts the one in which none are known. Each
    part may hold points that have been displaced with it: where none contradict
    anything, nothing tells.

    Parameters
    ----------
    shift : ndarray, shape (2,)
        Of the region against the others [m].
    known : KnownPoints
    is_large : bool
        Whether both parts are large.
    """
    shift = np.asarray(shift)
    inside = known.picked(known.is_inside).contradict(shift)
    outside = known.picked(~known.is_inside).contradict(-shift)
    if bool(inside) != bool(outside):
        return Part.REGION if inside else Part.OTHERS
    if is_large and not inside and (inside is None) != (outside is None):
        return Part.REGION if inside is None else Part.OTHERS
    return Part.UNKNOWN


def turned(found, n):
    """All others of n given points, where they are displaced and not the region."""
    others = np.setdiff1d(np.arange(n), found.rows)
    return replace(found, rows=others, shift=-found.shift)


def by_known_points(regions, n, known_beside):
    """A single region, or all others where known points tell that these are off.

    Parameters
    ----------
    regions : sequence of DisplacedRegion
    n : int
        Given points in all.
    known_beside : callable
        Tables of KnownPoints beside a region; the first that tells counts.

    Returns
    -------
    regions : sequence of DisplacedRegion
    is_decided : bool
    """
    if len(regions) != 1:
        return regions, False
    (region,) = regions
    n_inside = len(region.rows)
    for known in known_beside(region):
        large = is_large(n_inside, n - n_inside)
        part = which_part(region.shift, known, is_large=large)
        if part is not Part.UNKNOWN:
            return [region if part is Part.REGION else turned(region, n)], True
    return regions, False


def told_region(
    known, found, n_elsewhere, others, *, is_of_control, is_decided, usual=(0.0, 0.0)
):
    """The region by its names, with the control or check points in it.

    ``known``: given points; ``others``: KnownPoints beside the region, of which those
    in no region are missed by ``usual`` in the mean.
    """
    inside = others.picked(others.is_inside)
    n_of_others = np.count_nonzero(~others.is_inside)
    names = tuple(map(str, inside.point_ids))
    return GivenRegion(
        **_described(known, found),
        n_elsewhere=n_elsewhere + (n_of_others if is_of_control else 0),
        control_ids=names,
        control_is_alike=_is_alike(inside.misses - usual, found.shift),
        is_of_control=is_of_control,
        is_decided=is_decided,
    )


def _is_alike(missed, shift):
    """Whether known points in a region, (n, 2), are displaced as it is.

    Points that are right are missed by the shift.
    """
    mean = missed.mean(axis=0) if len(missed) else np.zeros(2)
    return bool(np.sum(mean**2) < np.sum((mean - shift) ** 2))


def _described(known, found):
    """What is to be said of some of given points: names, place and shift."""
    inside, everything = known.iloc[found.rows], values_of(known, PLAN)
    xy = everything[found.rows]
    middle, lowest = xy.mean(axis=0), everything.min(axis=0)
    extent = np.maximum(np.ptp(everything, axis=0).max(), np.finfo(float).tiny)
    of_all = lowest + np.ptp(everything, axis=0) / 2.0
    order = np.argsort(np.sum((xy - middle) ** 2, axis=1), kind="stable")
    nearest = cKDTree(everything).query(xy, 2)[1][:, 1]
    return {
        "point_ids": tuple(inside["point_id"].iloc[order].astype(str)),
        "n_given": len(known),
        "middle": tuple(map(float, middle)),
        "extent": float(np.ptp(xy, axis=0).max()),
        "direction": tuple(map(float, (middle - of_all) / extent)),
        "shift": tuple(map(float, found.shift)),
        "standard_error": float(found.standard_error),
        "p_value": float(found.p_value),
        "is_scattered": bool(2 * np.isin(nearest, found.rows).sum() < len(xy)),
    }
