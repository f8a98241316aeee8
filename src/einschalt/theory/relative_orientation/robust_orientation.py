"""Relative orientations that gross errors do not spoil, of all pairs at once.

Iteratively reweighted least squares: each condition has, beside the weight of its image
coordinates, a factor that falls with the size of its misclosure (Huber, Tukey). It
begins at the ordinary orientation, with the weights of absolute values, so that a few
large errors have lost their pull before the norm begins; where that orientation is not
credible, at that of the points that are left without gross errors.

Conditions are weighted at the measured coordinates (Sampson's error); that of corrected
coordinates differs from it by squares of image errors over the principal distance.

Sources: Huber 1981, ch. 7; see docs/theory/robust.md.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations.batches import over_segments
from einschalt.foundations.kernels import compiled
from einschalt.theory.adjustment.norms import HUBER, TUKEY
from einschalt.theory.relative_orientation.coplanarity import (
    BEHIND,
    MOST_BEHIND,
    NOT_CONVERGED,
    ORIENTED,
    UNDETERMINED,
    PairOrientation,
    is_determined,
)
from einschalt.theory.relative_orientation.coplanarity_condition import (
    COMPILED,
    coplanarity,
    descent_step,
    frame_of,
    moved,
    parameter_row,
)
from einschalt.theory.relative_orientation.coplanarity_precision import fill_precision
from einschalt.theory.relative_orientation.coplanarity_solution import (
    N_PARAMETERS,
    pose_at,
    put_pose,
)
from einschalt.theory.relative_orientation.gross_errors import find_gross_errors
from einschalt.theory.relative_orientation.majority_orientation import (
    CREDIBLE_SIGMA,
    FEWEST_POINTS,
    N_ABSOLUTE_STEPS,
    TUKEY_LIMIT,
    misclosure_scale,
    weight_factor,
    weighted_sums,
)
from einschalt.theory.relative_orientation.starting_orientations import facing

MOST_STEPS = 500
# the scale may jump to and fro for ever: after so many steps the scale is held
STEPS_WITH_SCALE = 250
# square of the last step in units of its standard error
LAST_STEP = 1e-14
# what is left of numbers of the order of 1 where points fit exactly
ROUNDING = 1e-13
# limits for one condition, and the norm by its name
NORMS = {"huber": (1.345, HUBER[1]), "tukey": (TUKEY_LIMIT, TUKEY[1])}


@dataclass(frozen=True, eq=False)
class RobustOrientation:
    """Robust relative orientations."""

    # ``sum_of_squares`` is such that sigma_0 is that of a good image coordinate
    orientation: PairOrientation
    # (n_points,): of the weights, 0 to 1; 1 in pairs of fewer than eight points, whose
    # majority is not worth more than the worst of them
    factors: np.ndarray


def orient_robustly(pairs, norm):
    """Orient all pairs with weights that fall with the size of a misclosure.

    ``norm`` is huber or tukey. Pairs that could not be oriented at all are what they
    were.
    """
    ordinary = pairs.orient("rigorous")
    start = np.ascontiguousarray(pairs.start, dtype=np.int64)
    left = pairs.distance[pairs.model, 0]
    poses, is_of_majority = _begin(pairs, ordinary)
    out = (
        poses,
        ordinary.cofactor * pairs.distance[:, :1, None] ** 2,
        ordinary.sum_of_squares / pairs.distance[:, 0] ** 2,
        ordinary.n_in_front.copy(),
        ordinary.status.copy(),
        np.ascontiguousarray(ordinary.residuals.T / left),
        ordinary.redundancy_numbers.copy(),
        np.ones(len(pairs.image)),
    )
    limit, of_norm = NORMS[norm]
    over_segments(
        _orient_range,
        start,
        np.ascontiguousarray(pairs.image.T / left),
        -pairs.distance[:, 1] / pairs.distance[:, 0],
        is_of_majority,
        (limit, norm == "tukey", of_norm.consistency),
        out,
    )
    _, cofactor, squares, n_in_front, status, corrections, numbers, factors = out
    robust = replace(
        ordinary,
        base=poses[:, :3],
        rotation=poses[:, 3:].reshape(-1, 3, 3).transpose(0, 2, 1),
        cofactor=cofactor / pairs.distance[:, :1, None] ** 2,
        sum_of_squares=squares * pairs.distance[:, 0] ** 2,
        residuals=(corrections * left).T,
        redundancy_numbers=numbers,
        n_in_front=n_in_front,
        status=status,
    )
    return RobustOrientation(robust, factors)


def _begin(pairs, ordinary):
    """Poses, and of bool, (n_pairs,), whether gross errors were taken out for them.

    Those of the ordinary orientation, where these are credible.
    """
    poses = ordinary.poses
    is_of_majority = np.zeros(len(poses), dtype=np.bool_)
    size = ordinary.sigma_0 / pairs.distance[:, 0]
    doubtful = np.flatnonzero(~(ordinary.is_converged & (size <= CREDIBLE_SIGMA)))
    if not len(doubtful):
        return poses, is_of_majority
    _, part = pairs.of_models(doubtful)
    found = part.chosen(~find_gross_errors(part)).orient()
    is_better = found.is_converged & ~(found.sigma_0 >= ordinary.sigma_0[doubtful])
    is_of_majority[doubtful] = is_better
    poses[is_of_majority] = found.poses[is_better]
    return poses, is_of_majority


@compiled(**COMPILED)
def _orient_range(first, last, start, scaled, right_z, is_of_majority, norm, out):
    poses, cofactor, squares, n_in_front, status, corrections, numbers, factors = out
    for k in range(first, last):
        begin, end = start[k], start[k + 1]
        if end - begin < FEWEST_POINTS or not math.isfinite(poses[k, 0]):
            continue
        image, zr = np.ascontiguousarray(scaled[:, begin:end]), right_z[k]
        # gross errors that have no pull yet would have it by absolute values
        n_absolute = 0 if is_of_majority[k] else N_ABSOLUTE_STEPS
        pose = pose_at(poses[k])
        pose, scale, is_converged = _descend(image, zr, pose, n_absolute, norm)
        factor = factors[begin:end]
        _set_factors(image, zr, pose, (scale, norm), factor)
        closing = corrections[:, begin:end]
        of_points = factor, closing, numbers[begin:end]
        found = _judge(image, zr, pose, of_points, cofactor[k])
        squares[k] = found / norm[2]
        pose, n_in_front[k] = facing(image + closing, zr, pose)
        is_behind = n_in_front[k] < (1.0 - MOST_BEHIND) * (end - begin)
        status[k] = BEHIND if is_behind else ORIENTED
        if not is_converged:
            status[k] = NOT_CONVERGED
        if not is_determined(cofactor[k]):  # by the points that kept their weight
            status[k] = UNDETERMINED
            poses[k], cofactor[k], squares[k] = np.nan, np.nan, np.nan
            closing[:], numbers[begin:end] = np.nan, np.nan
            continue
        put_pose(pose, poses[k])


@compiled(**COMPILED)
def _descend(image, zr, pose, n_absolute, norm):
    """Pose, scale of the misclosures there, and whether it converged."""
    size = np.empty(image.shape[1])
    scale = misclosure_scale(image, zr, pose, size)
    for turn in range(MOST_STEPS):
        if 0 < turn < STEPS_WITH_SCALE:
            # half of the way, so that steps to and fro die away
            scale = math.sqrt(scale * misclosure_scale(image, zr, pose, size))
        if not scale > ROUNDING:  # most points fit exactly
            return pose, 0.0, scale >= 0.0
        is_absolute = turn < n_absolute
        sums = weighted_sums(image, zr, pose, scale, norm[:2], is_absolute)
        step, gain = descent_step(sums, 0.0)
        if not math.isfinite(step[0]):
            return pose, scale, False
        pose = moved(pose, step)
        if not is_absolute and gain <= LAST_STEP * scale * scale:
            return pose, scale, True
    return pose, scale, False


@compiled(**COMPILED)
def _set_factors(image, zr, pose, scaled_norm, factor):
    scale, norm = scaled_norm
    misclosure_scale(image, zr, pose, factor)
    for i in range(factor.size):
        factor[i] = (
            weight_factor(factor[i] / scale, norm[:2], False) if scale > 0.0 else 1.0
        )


@compiled(**COMPILED)
def _judge(image, zr, pose, of_points, cofactor):
    """Fill corrections, redundancy numbers and cofactors; weighted sum of squares."""
    factor, corrections, numbers = of_points
    base, tangents, rotation = frame_of(pose, False)
    rows = np.empty((factor.size, N_PARAMETERS))
    weights, squares = np.empty(factor.size), 0.0
    for i in range(factor.size):
        point = image[0, i], image[1, i], image[2, i], image[3, i]
        f, by_base, by_turn, by_image = coplanarity(point, zr, base, rotation)
        q = by_image[0] ** 2 + by_image[1] ** 2 + by_image[2] ** 2 + by_image[3] ** 2
        row = parameter_row(by_base, by_turn, tangents)
        for k in range(N_PARAMETERS):
            rows[i, k] = row[k]
        weights[i] = factor[i] / q
        squares += weights[i] * f * f
        for axis in range(4):
            corrections[axis, i] = -f / q * by_image[axis]
    # variances of observations with these weights: w² q is w
    fill_precision(rows, weights, weights, tangents, numbers, cofactor)
    return squares
