"""Collocation of shifts of which some are wrong: found first, then left out.

See docs/theory/collocation.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from einschalt.theory.adjustment.norms import RAYLEIGH_MEDIAN
from einschalt.theory.residual_distribution.collocation import collocate_left_out
from einschalt.theory.residual_distribution.covariance_function import (
    CovarianceFunction,
    estimate_covariance,
)
from einschalt.theory.residual_distribution.held_out_ellipses import (
    WRONG,
    HeldOutEllipses,
    estimate_tails,
    held_out_ellipses,
)

N_COMPARED = 8
ROUNDS = 4
FEW = 1e-3  # share of the points whose change of sides changes nothing


@dataclass(frozen=True, eq=False)
class RobustCollocation:
    """What collocation needs of known points, and what it found in them."""

    trusted: np.ndarray  # of bool, (n,): points from which others are predicted
    covariance: CovarianceFunction
    # differences: (n, 2) [m], predicted minus given, of each point without itself;
    # variances: (n,), of each coordinate of it [m²]
    differences: np.ndarray
    variances: np.ndarray
    ellipses: HeldOutEllipses


def robust_collocation(xy, shifts, *, keep_wrong=False):
    """Estimate the covariance function of shifts, and find wrong ones.

    Points are first compared with the median of their neighbours, then with their
    collocation from those that are trusted, until these stay the same. ``xy``,
    ``shifts``: (n, 2) [m]; ``keep_wrong``: whether all are trusted.
    """
    n_points = len(xy)
    trusted = np.ones(n_points, dtype=bool)
    if not keep_wrong and n_points > N_COMPARED:
        trusted = _near_their_neighbours(xy, shifts)
    for _ in range(ROUNDS):
        covariance = estimate_covariance(xy[trusted], shifts[trusted])
        predicted, variances = collocate_left_out(xy, shifts, covariance, trusted)
        differences = predicted - shifts
        ellipses = held_out_ellipses(differences, variances, keep_wrong=keep_wrong)
        n_changed = np.count_nonzero(trusted == ellipses.is_wrong)
        if keep_wrong or n_changed <= FEW * n_points:
            break
        trusted = ~ellipses.is_wrong
    return RobustCollocation(trusted, covariance, differences, variances, ellipses)


def _near_their_neighbours(xy, shifts):
    """Which shifts are near the median of their neighbours'."""
    n_near = min(N_COMPARED, len(xy) - 1)
    near = KDTree(xy).query(xy, np.arange(2, n_near + 2))[1]
    deviations = np.hypot(*(shifts - np.median(shifts[near], axis=1)).T)
    size = np.median(deviations) / RAYLEIGH_MEDIAN
    if size == 0.0:
        return deviations == 0.0
    squares = (deviations / size) ** 2
    return estimate_tails(squares).probability_wrong(squares) <= WRONG
