"""Gross errors in image coordinates, taken out of all pairs at once.

Snooping alone fails where there are many: together they enlarge sigma_0 until none of
them stands out. So it is the last of three steps.

1. From the orientation of all points, a descent with weights that fall with the size
   of the misclosure (absolute values first, then Tukey's function) finds what most of
   the points agree on.
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
from einschalt.theory.adjustment.norms import SIGMA_PER_MEDIAN
from einschalt.theory.adjustment.robust import snoop
from einschalt.theory.adjustment.significance import GROSS_ERROR_SIGNIFICANCE
from einschalt.theory.relative_orientation.condition_tests import (
    condition_tests,
    prediction_tests,
)
from einschalt.theory.relative_orientation.coplanarity_condition import (
    COMPILED,
    NO_SUMS,
    add_condition,
    coplanarity,
    descent_step,
    frame_of,
    moved,
    parameter_row,
)
from einschalt.theory.relative_orientation.coplanarity_solution import (
    N_PARAMETERS,
    pose_at,
)

# with fewer points the majority is not worth more than the worst of them
FEWEST_POINTS = N_PARAMETERS + 3
# standard errors: where Tukey's weight vanishes, and where a point is put aside
TUKEY_LIMIT, PUT_ASIDE = 4.685, 5.0
N_ABSOLUTE_STEPS, N_TUKEY_STEPS = 10, 15
TUKEY = TUKEY_LIMIT, True
# the smallest size of a misclosure that a weight is taken of, in standard errors
LEAST_SIZE = 0.1
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
        image = np.ascontiguousarray(scaled[:, begin:end])
        size = np.empty(end - begin)
        pose, zr = pose_at(poses[k]), right_z[k]
        for turn in range(N_ABSOLUTE_STEPS + N_TUKEY_STEPS):
            scale = misclosure_scale(image, zr, pose, size)
            sums = weighted_sums(image, zr, pose, scale, TUKEY, turn < N_ABSOLUTE_STEPS)
            step, _ = descent_step(sums, 0.0)
            if not math.isfinite(step[0]):
                break
            pose = moved(pose, step)
        scale = misclosure_scale(image, zr, pose, size)
        # nothing is far where most points fit exactly
        if scale > 0.0 and np.sum(size > PUT_ASIDE * scale) < 0.5 * (end - begin):
            is_out[begin:end] = size > PUT_ASIDE * scale


@compiled(**COMPILED)
def misclosure_scale(image, zr, pose, size):
    """Standard error of a misclosure by the median, in left principal distances.

    ``size`` (n,) is filled with the lengths of the corrections that close each
    condition.
    """
    base, rotation = pose
    n = image.shape[1]
    for i in range(n):
        point = image[0, i], image[1, i], image[2, i], image[3, i]
        f, _, _, (d0, d1, d2, d3) = coplanarity(point, zr, base, rotation)
        size[i] = abs(f) / math.sqrt(d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3)
    return SIGMA_PER_MEDIAN * np.median(size) * math.sqrt(n / (n - N_PARAMETERS))


@compiled(**COMPILED)
def weight_factor(ratio, norm, is_absolute):
    """Factor of a weight: of absolute values, or of a norm (limit, is_tukey)."""
    limit, is_tukey = norm
    if is_absolute:
        return 1.0 / max(ratio, LEAST_SIZE)
    if is_tukey:
        share = 1.0 - (ratio / limit) ** 2
        return share * share if share > 0.0 else 0.0
    return limit / max(ratio, limit)


@compiled(**COMPILED)
def weighted_sums(image, zr, pose, scale, norm, is_absolute):
    """Normal equations with weights that fall with the size of a misclosure."""
    base, tangents, rotation = frame_of(pose, False)
    sums = NO_SUMS
    for i in range(image.shape[1]):
        point = image[0, i], image[1, i], image[2, i], image[3, i]
        f, by_base, by_turn, by_image = coplanarity(point, zr, base, rotation)
        d0, d1, d2, d3 = by_image
        q = d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3
        factor = weight_factor(abs(f) / math.sqrt(q) / scale, norm, is_absolute)
        row = parameter_row(by_base, by_turn, tangents)
        sums = add_condition(sums, row, f, factor / q)
    return sums
