"""How far a region of given points may be displaced before a scan sees it.

The minimal detectable bias of a region in place of a point: of a shift d of region p
the test χ² of two degrees of freedom has the noncentrality d² pᵀWp, W being what the
given points know of each other.

Sources: Baarda 1968 (minimal detectable bias); see displaced_regions for the scores.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.theory.adjustment.reliability import noncentrality
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

POWER = 0.80
SMALLEST_SHARE = 0.1  # of all points: of smaller parts little of a block depends
N_LOOKED_AT = 16  # regions that may be the worst, of what is known roughly


@dataclass(frozen=True)
class DetectableShift:
    """Shifts of regions of a tenth of the points or more that four of five times show.

    Infinite where nothing ties a region to the others.
    """

    median: float  # of all such regions [m]
    largest: float  # of that which is known worst [m]


def detectable_shift(information, n_points, n_all, exactly) -> DetectableShift:
    """Find how far regions must be displaced, so that a scan of all of them shows it.

    Parameters
    ----------
    information : ndarray, shape (n_regions,)
        pᵀWp of each region that is tried, as known by draws [1/m²].
    n_points : ndarray, shape (n_regions,)
        Number of points in each.
    n_all : int
        Number of all points.
    exactly : callable
        Gives pᵀWp of some regions, by their places.

    Examples
    --------
    A single region of which a shift is known to 1 cm in each coordinate:

    >>> known, size = np.array([1e4]), np.array([20])
    >>> shift = detectable_shift(known, size, 100, lambda places: known[places])
    >>> round(shift.median, 3)
    0.044
    """
    is_large = n_points >= SMALLEST_SHARE * n_all
    places = np.flatnonzero(is_large)
    worst = places[np.argsort(information[places], kind="stable")[:N_LOOKED_AT]]
    delta = noncentrality(FINDING_SIGNIFICANCE / len(information), POWER, degrees=2)
    known = np.array([np.median(information[places]), np.min(exactly(worst))])
    with np.errstate(divide="ignore"):
        median, largest = delta / np.sqrt(np.maximum(known, 0.0))
    return DetectableShift(float(median), float(max(median, largest)))
