"""Gross errors in image coordinates, taken out of all pairs at once.

Snooping alone fails where there are many: together they enlarge sigma_0 until none of
them stands out. So it is the last of three steps.

1. From the orientation of all points, or of a few where that is nowhere near
   (:mod:`~.majority_orientation`), a descent with weights that fall with the size of
   the misclosure finds what most of the points agree on.
2. Points far from that are put aside, the others are oriented, and whatever does not
   contradict them comes back; this is repeated. All come back where their part of the
   sum of squares is no more than that of the worst points of a good pair (F test, with
   Bonferroni's limit for the choice of k among n points).
3. The worst point of each pair that the test refuses is taken out until there is none.

Only pairs that still change are oriented again.

Sources: Beaton and Tukey 1974 (Technometrics 16); Baarda 1968.
"""

import math

import numpy as np
from scipy.special import betaln, fdtrc

from einschalt.foundations.batches import over_segments, segment_sum
from einschalt.foundations.kernels import compiled
from einschalt.theory.adjustment.robust import snoop
from einschalt.theory.adjustment.significance import GROSS_ERROR_SIGNIFICANCE
from einschalt.theory.relative_orientation.condition_tests import (
    condition_tests,
    prediction_tests,
)
from einschalt.theory.relative_orientation.coplanarity_condition import COMPILED
from einschalt.theory.relative_orientation.coplanarity_solution import pose_at
from einschalt.theory.relative_orientation.majority_orientation import (
    FEWEST_POINTS,
    sizes_by_majority,
)

PUT_ASIDE = 5.0  # standard errors
MOST_RETURNS = 10


def find_gross_errors(
    pairs, estimator="rigorous", significance=GROSS_ERROR_SIGNIFICANCE
):
    """Find the points that contradict the others of their pair: bool, (n_points,).

    ``significance`` is the probability with which a pair without gross errors loses a
    point. At least six points are left to a pair that lost any.
    """
    is_out = _put_aside(pairs, estimator, significance)

    def tests_of(part):
        return condition_tests(part.orient(estimator), part)

    kept = np.flatnonzero(~is_out)
    is_out[kept] = snoop(pairs.chosen(~is_out), tests_of, significance)
    return is_out


def _put_aside(pairs, estimator, significance):
    """Points that contradict what the majority of their pair agrees on."""
    is_out = _far_from_majority(pairs, estimator)
    n_points = np.diff(pairs.start)
    active = _pairs_with(is_out, pairs)
    for _ in range(MOST_RETURNS):
        if len(active) == 0:
            break
        rows, part = pairs.of_models(active)
        is_aside = is_out[rows]
        orientation = part.chosen(~is_aside).orient(estimator)
        others = part.chosen(is_aside)
        p_value = prediction_tests(orientation, others).p_value
        limit = significance / n_points[active][others.model]
        # the comparison fails for NaN, too: what cannot be tested comes back
        is_back = ~(p_value <= limit)
        is_out[rows[is_aside][is_back]] = False
        active = active[np.unique(others.model[is_back])]
        active = np.intersect1d(active, _pairs_with(is_out, pairs))
    is_chance = _is_chance(is_out, pairs, estimator, significance)
    return is_out & ~is_chance[pairs.model]


def _is_chance(is_out, pairs, estimator, significance):
    """Whether the points of a pair that were put aside are just its worst ones."""
    active = _pairs_with(is_out, pairs)
    rows, part = pairs.of_models(active)
    whole, kept = part.orient(estimator), part.chosen(~is_out[rows]).orient(estimator)
    n = np.diff(part.start)
    k = n - np.diff(part.chosen(~is_out[rows]).start)
    # the sum of squares of a pair that did not converge is no measure
    lost = np.where(whole.is_converged, whole.sum_of_squares, np.inf)
    lost = np.maximum(lost - kept.sum_of_squares, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = lost / k / kept.sigma_0**2
    log_choices = -betaln(n - k + 1.0, k + 1.0) - np.log(n + 1.0)
    # one k of about n was chosen as well
    limit = significance / np.maximum(n, 1) * np.exp(-log_choices)
    is_chance = np.zeros(len(pairs.start) - 1, dtype=bool)
    # the comparison fails for NaN, too
    degrees = np.maximum(kept.redundancy, 1)
    is_chance[active] = ~(fdtrc(k, degrees, ratio) <= limit)
    return is_chance


def _pairs_with(is_out, pairs):
    return np.flatnonzero(segment_sum(is_out.astype(np.int64), pairs.start))


def _far_from_majority(pairs, estimator):
    orientation = pairs.orient(estimator)
    start = np.ascontiguousarray(pairs.start, dtype=np.int64)
    scaled = np.ascontiguousarray(pairs.image.T / pairs.distance[pairs.model, 0])
    right_z = -pairs.distance[:, 1] / pairs.distance[:, 0]
    is_out = np.zeros(len(pairs.image), dtype=np.bool_)
    over_segments(_find_majority, start, scaled, right_z, orientation.poses, is_out)
    return is_out


@compiled(**COMPILED)
def _find_majority(first, last, start, scaled, right_z, poses, is_out):
    for k in range(first, last):
        begin, end = start[k], start[k + 1]
        if end - begin < FEWEST_POINTS or not math.isfinite(poses[k, 0]):
            continue
        image, zr = np.ascontiguousarray(scaled[:, begin:end]), right_z[k]
        size = np.empty(end - begin)
        scale = sizes_by_majority(image, zr, pose_at(poses[k]), size)
        # nothing is far where most points fit exactly
        if scale > 0.0 and np.sum(size > PUT_ASIDE * scale) < 0.5 * (end - begin):
            is_out[begin:end] = size > PUT_ASIDE * scale
