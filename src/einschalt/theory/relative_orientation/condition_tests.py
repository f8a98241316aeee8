"""Which points contradict the orientation of their pair.

Each point gives one condition, so one number can be tested: the length of its four
corrections, which is its misclosure over √q, q being the sum of squares of dF/d(image
coordinates). Its variance is sigma_0² r in the adjustment of the point itself, and
sigma_0² (1 + s) in one that it took no part in, with ``s = j.T C j / q``: j is the row
of the condition, C the cofactor matrix of the orientation. Along the epipolar ray a
gross error stays unseen: a pair knows nothing of x-parallaxes.

Sources: Baarda 1968, Pope 1976; see docs/theory/reliability.md.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr

from einschalt.foundations.batches import over_segments
from einschalt.foundations.kernels import compiled
from einschalt.foundations.sorted_points import SortedPoints
from einschalt.theory.adjustment.reliability import (
    PointTests,
    standardized_residuals,
    tau_p_value,
)
from einschalt.theory.relative_orientation.coplanarity import orient_pairs
from einschalt.theory.relative_orientation.coplanarity_condition import (
    COMPILED,
    coplanarity,
    frame_of,
    parameter_row,
)
from einschalt.theory.relative_orientation.coplanarity_solution import (
    N_PARAMETERS,
    pose_at,
)

# residuals below it are those of rounding [mm]
LEAST_SIGMA_MM = 1e-9


@dataclass(frozen=True, eq=False)
class StereoPairs(SortedPoints):
    """Image coordinates of many pairs."""

    image: np.ndarray  # (n_points, 4): x', y', x", y" [mm], sorted by pair
    start: np.ndarray  # of int, (n_pairs + 1,)
    # (n_pairs, 2): principal distances of the left and the right photograph [mm]
    distance: np.ndarray

    @property
    def weights(self):
        """Weight 1 for each point."""
        return np.ones(len(self.image))

    def _taken(self, rows, start, pairs=...):
        return StereoPairs(self.image[rows], start, self.distance[pairs])

    def orient(self, estimator="rigorous"):
        """Orient all pairs; PairOrientation."""
        return orient_pairs(self.image, self.start, self.distance, estimator)


@dataclass(frozen=True, eq=False)
class Misclosures:
    """What points lack of their conditions in orientations that are given."""

    # (n_points, 4): smallest corrections that close the linearised condition [mm]
    corrections: np.ndarray
    # (n_points,): variance of the misclosure that comes from the orientation, over that
    # which comes from the point's own image coordinates
    spread: np.ndarray

    @property
    def size(self):
        """Length of the corrections, shape (n_points,) [mm]."""
        return np.sqrt(np.sum(self.corrections**2, axis=1))


def misclosures(orientation, pairs) -> Misclosures:
    """Compare points with orientations in which they need not have taken part.

    NaN where a pair is not oriented.
    """
    left = pairs.distance[:, :1]
    found = Misclosures(np.empty((len(pairs.image), 4)), np.empty(len(pairs.image)))
    over_segments(
        _compare,
        *_arrays_of(pairs),
        orientation.poses,
        np.ascontiguousarray(orientation.cofactor * left[:, :, None] ** 2),
        *(found.corrections, found.spread),
    )
    return found


def linear_conditions(orientation, pairs):
    """Conditions of the points as functions of the changes of their orientations.

    Rows by the five parameters, (n_points, 5), and misclosures, (n_points,), both over
    √q, so that their errors are those of an image coordinate [mm]. NaN where a pair is
    not oriented.
    """
    rows = np.empty((len(pairs.image), N_PARAMETERS))
    lengths = np.empty(len(pairs.image))
    over_segments(
        _linearise,
        *_arrays_of(pairs),
        orientation.poses,
        *(rows, lengths),
    )
    return rows, lengths


def _arrays_of(pairs):
    """First point of each pair, image coordinates and distances, for kernels."""
    start = np.ascontiguousarray(pairs.start, dtype=np.int64)
    image = np.ascontiguousarray(pairs.image, dtype=float)
    return start, image, np.ascontiguousarray(pairs.distance)


def condition_tests(orientation, pairs) -> PointTests:
    """Test the points of an adjustment against its other points.

    w is the length of the corrections over its standard error (Pope's τ without its
    sign), p_value that of Student's t of the adjustment without the point. NaN where
    the redundancy is 1 or less, the point is not checked by others, or nothing but
    rounding is left.

    Notes
    -----
    For "determinants" the variance is that of this estimator; sigma_0 then is not quite
    independent of the numerator, and p_value an approximation.
    """
    r = orientation.redundancy_numbers
    if orientation.estimator == "determinants":
        # (1 - h)² q plus the part of the others: 1 - 2 h + s in units of q
        r = 2.0 * r - 1.0 + misclosures(orientation, pairs).spread
    size = np.sqrt(np.sum(orientation.residuals**2, axis=1))
    w = standardized_residuals(size, r, _sigma(orientation)[pairs.model])
    return PointTests(w, tau_p_value(w, orientation.redundancy[pairs.model]))


def prediction_tests(orientation, pairs) -> PointTests:
    """Test points against an adjustment in which they took no part.

    w is the misclosure over its predicted standard error, p_value that of Student's t;
    NaN without redundancy.
    """
    found = misclosures(orientation, pairs)
    sigma = _sigma(orientation)[pairs.model]
    w = found.size / (sigma * np.sqrt(1.0 + found.spread))
    degrees = orientation.redundancy[pairs.model].astype(float)
    return PointTests(w, 2.0 * stdtr(np.where(degrees > 0, degrees, np.nan), -w))


def _sigma(orientation):
    sigma = orientation.sigma_0
    # the comparison fails for NaN, too
    return np.where(sigma > LEAST_SIGMA_MM, sigma, np.nan)


@compiled(**COMPILED)
def _linearise(first, last, start, image, distance, poses, rows, lengths):
    for k in range(first, last):
        base, tangents, rotation = frame_of(pose_at(poses[k]), False)
        left, zr = distance[k, 0], -distance[k, 1] / distance[k, 0]
        for i in range(start[k], start[k + 1]):
            x, y = image[i, 0] / left, image[i, 1] / left
            point = x, y, image[i, 2] / left, image[i, 3] / left
            f, by_base, by_turn, by_image = coplanarity(point, zr, base, rotation)
            d0, d1, d2, d3 = by_image
            size = left / math.sqrt(d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3)
            row = parameter_row(by_base, by_turn, tangents)
            for k_row in range(N_PARAMETERS):
                rows[i, k_row] = size * row[k_row]
            lengths[i] = size * f


@compiled(**COMPILED)
def _compare(
    first, last, start, image, distance, poses, cofactors, corrections, spread
):
    row = np.empty(6)
    for k in range(first, last):
        base, rotation = pose_at(poses[k])
        left, zr = distance[k, 0], -distance[k, 1] / distance[k, 0]
        for i in range(start[k], start[k + 1]):
            x, y = image[i, 0] / left, image[i, 1] / left
            point = x, y, image[i, 2] / left, image[i, 3] / left
            f, by_base, by_turn, by_image = coplanarity(point, zr, base, rotation)
            d0, d1, d2, d3 = by_image
            q = d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3
            closing = -left * f / q
            corrections[i, 0], corrections[i, 1] = closing * d0, closing * d1
            corrections[i, 2], corrections[i, 3] = closing * d2, closing * d3
            row[0], row[1], row[2] = by_base
            row[3], row[4], row[5] = by_turn
            total = 0.0
            for m in range(6):
                for n in range(6):
                    total += row[m] * cofactors[k, m, n] * row[n]
            spread[i] = total / q
