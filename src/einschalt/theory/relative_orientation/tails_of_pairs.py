"""How precise the good ones are among the image points of many pairs.

By the residuals of the ordinary orientations chance is told from a share of worse
points: those of robust ones are larger than normal in small pairs, and weights of the
same residuals have chosen them. How large share and errors are then follows from the
conditions themselves, linear at a robust orientation, with every orientation unknown.

See docs/theory/robust.md.
"""

import numpy as np

from einschalt.theory.adjustment.heavy_tails import (
    HeavyTails,
    find_heavy_tails,
    find_tails_of_models,
)
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE
from einschalt.theory.relative_orientation.condition_tests import linear_conditions
from einschalt.theory.relative_orientation.coplanarity import ORIENTED
from einschalt.theory.relative_orientation.robust_orientation import orient_robustly

# a smaller share far out changes nothing that anyone would do
LEAST_FAR_OUT = 0.01


def tails_of_residuals(orientation) -> HeavyTails | None:
    """Tell good image points from worse ones by the residuals of all pairs alone."""
    length = np.sqrt((orientation.residuals**2).sum(axis=1))
    is_free = orientation.redundancy_numbers > 0.0
    number = orientation.redundancy_numbers[is_free]
    return find_heavy_tails(length[is_free] / np.sqrt(number))


def find_tails_of_pairs(pairs, ordinary) -> HeavyTails | None:
    """Tell good image points of all pairs from a share of worse ones.

    Parameters
    ----------
    pairs : StereoPairs
    ordinary : PairOrientation
        Their rigorous orientation, all points with equal weights.

    Returns
    -------
    HeavyTails or None
        [mm]; by the ordinary residuals alone where chance explains these. None for
        fewer than 50 conditions with redundancy.
    """
    first = tails_of_residuals(ordinary)
    if first is None or not first.p_value < FINDING_SIGNIFICANCE:
        return first
    robust = orient_robustly(pairs, "tukey").orientation
    is_known = (robust.status == ORIENTED) & (robust.redundancy > 0)
    if not is_known.any():
        return first
    rows, misclosures = linear_conditions(robust, pairs)
    of_known = is_known[pairs.model]
    start = np.append(0, np.cumsum(np.diff(pairs.start)[is_known]))
    return find_tails_of_models(rows[of_known], misclosures[of_known], start, first)
