"""Numerical relative orientation of all pairs of a flight at once.

No start value is needed: the direction of the base and kappa may be anything, tilts and
convergence moderate to strong. Each pair is oriented by itself in a fused kernel, in
two steps: ``coplanarity_solution.choose`` finds the right minimum, and a descent from
there gives the estimate:

rigorous
    Gauss-Helmert model with equal weights of the four image coordinates, linearised at
    the corrected observations until these are consistent: the result is that of the
    bundle adjustment with free model points.
determinants
    Least sum of squares of the unweighted determinants F = B . (u x v), as in lecture
    notes; bx is fixed where the base lies within 45 degrees of x, otherwise the length
    of the base. Cofactors are those of this estimator for equal weights of the image
    coordinates, and sigma_0 is computed from the smallest corrections of the image
    coordinates that satisfy the conditions, so both mean the same as for "rigorous".

A pair has converged when the remaining undamped Gauss-Newton step is smaller than 1e-7
of its own standard error.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from einschalt.foundations.arguments import require_choice
from einschalt.foundations.batches import over_segments
from einschalt.foundations.kernels import compiled, copy_values
from einschalt.theory.relative_orientation.coplanarity_condition import (
    COMPILED,
    DETERMINANTS,
    FAST,
    GAUSS_HELMERT,
    SQUARES,
    coplanarity,
    form_normals,
    frame_of,
    parameter_row,
)
from einschalt.theory.relative_orientation.coplanarity_precision import fill_precision
from einschalt.theory.relative_orientation.coplanarity_solution import (
    FINE,
    MOST_FINE_STEPS,
    N_PARAMETERS,
    choose,
    descend,
    pose_at,
    put_pose,
)
from einschalt.theory.relative_orientation.starting_orientations import facing

MODES = {"rigorous": GAUSS_HELMERT, "determinants": DETERMINANTS}
ORIENTED, TOO_FEW, UNDETERMINED, NOT_CONVERGED, BEHIND = range(5)
# largest standard error of base and turn [rad] for an image error of 1e-4 principal
# distances: beyond it, the points lie in a line or near a dangerous surface
WEAKEST = 0.2
IMAGE_ERROR = 1e-4
# part of the points that may lie behind a camera, as gross errors do
MOST_BEHIND = 0.2


@dataclass(frozen=True, eq=False)
class PairOrientation:
    """Relative orientation of many pairs, the left photograph being the reference.

    A point X of the left image system (origin in the left projection centre) has the
    right image ray ``rotation @ (X - base)``.
    """

    estimator: str
    # (n_pairs, 3): unit vector from the left to the right projection centre; NaN where
    # the pair could not be oriented
    base: np.ndarray
    rotation: np.ndarray  # (n_pairs, 3, 3): right image system from left image system
    # (n_pairs, 6, 6): of the base vector (3) and a small turn of the right camera about
    # the axes of the left system (3) [1/mm²]; of rank 5, since the base stays a unit
    # vector
    cofactor: np.ndarray
    # (n_pairs,): of the corrections of all image coordinates [mm²]
    sum_of_squares: np.ndarray
    # (n_points, 4): corrections of x', y', x", y" [mm]: adjusted minus measured
    residuals: np.ndarray
    # (n_points,): of the conditions; each pair's sum is its redundancy
    redundancy_numbers: np.ndarray
    # both of int, (n_pairs,): points, and those of them in front of both cameras
    n_points: np.ndarray
    n_in_front: np.ndarray
    # of int, (n_pairs,): ORIENTED, TOO_FEW, UNDETERMINED, NOT_CONVERGED or BEHIND
    status: np.ndarray
    # of bool, (n_pairs,): another one with all points in front fits about as well
    is_ambiguous: np.ndarray

    @property
    def poses(self):
        """Base and transposed rotation as the kernels take them, (n_pairs, 12)."""
        turned = np.swapaxes(self.rotation, 1, 2).reshape(-1, 9)
        return np.hstack([self.base, turned])

    @property
    def redundancy(self):
        """Points less five, at least 0."""
        return np.maximum(self.n_points - N_PARAMETERS, 0)

    @property
    def sigma_0(self):
        """Standard error of an image coordinate [mm], NaN without redundancy."""
        redundancy = np.where(self.redundancy > 0, self.redundancy, np.nan)
        return np.sqrt(self.sum_of_squares / redundancy)

    @property
    def is_converged(self):
        """Whether the orientation is the minimum that it claims to be."""
        return (self.status == ORIENTED) | (self.status == BEHIND)


def orient_pairs(image, model_start, principal_distance, estimator="rigorous"):
    """Orient all pairs from their image coordinates.

    Parameters
    ----------
    image : ndarray, shape (n_points, 4)
        x', y', x", y" [mm], origin in the principal point, sorted by pair.
    model_start : ndarray of int, shape (n_pairs + 1,)
        First row of each pair; pair k owns rows model_start[k]:model_start[k + 1].
    principal_distance : float or ndarray, shape (2,) or (n_pairs, 2)
        Of both photographs, or of the left and the right one [mm].
    estimator : {"rigorous", "determinants"}

    Returns
    -------
    PairOrientation
        A pair that cannot be oriented has NaN and a status, and stops nothing.

    Raises
    ------
    SettingsError
        The estimator is unknown.

    Notes
    -----
    Source: Gauss-Helmert model as in any text-book of adjustment; the starts are in
    ``starting_orientations``. The arithmetic of a pair is sequential, so that results
    do not depend on the number of threads.
    """
    require_choice("estimator", estimator, MODES)
    model_start = np.ascontiguousarray(model_start, dtype=np.int64)
    n_points = np.diff(model_start)
    distance = np.empty((len(n_points), 2))
    distance[:] = principal_distance
    left = np.repeat(distance[:, 0], n_points)
    scaled = np.ascontiguousarray(np.asarray(image, dtype=float).T / left)
    out = _Arrays(
        pose=np.full((len(n_points), 12), np.nan),
        cofactor=np.full((len(n_points), 6, 6), np.nan),
        squares=np.full(len(n_points), np.nan),
        n_in_front=np.zeros(len(n_points), dtype=np.int64),
        status=np.full(len(n_points), TOO_FEW),
        is_ambiguous=np.zeros(len(n_points), dtype=np.bool_),
        corrections=np.full(scaled.shape, np.nan),
        redundancy_numbers=np.full(scaled.shape[1], np.nan),
    )
    right_z = -distance[:, 1] / distance[:, 0]
    mode = MODES[estimator]
    over_segments(_choose_range, model_start, scaled, right_z, out)
    over_segments(_adjust_range, model_start, scaled, right_z, mode, out)
    over_segments(_judge_range, model_start, scaled, right_z, mode, out)
    return PairOrientation(
        estimator=estimator,
        base=out.pose[:, :3],
        rotation=out.pose[:, 3:].reshape(-1, 3, 3).transpose(0, 2, 1),
        cofactor=out.cofactor / distance[:, :1, None] ** 2,
        sum_of_squares=out.squares * distance[:, 0] ** 2,
        residuals=(out.corrections * left).T,
        redundancy_numbers=out.redundancy_numbers,
        n_points=n_points,
        n_in_front=out.n_in_front,
        status=out.status,
        is_ambiguous=out.is_ambiguous,
    )


class _Arrays(NamedTuple):
    """What the kernels fill, lengths in left principal distances."""

    pose: np.ndarray
    cofactor: np.ndarray
    squares: np.ndarray
    n_in_front: np.ndarray
    status: np.ndarray
    is_ambiguous: np.ndarray
    corrections: np.ndarray
    redundancy_numbers: np.ndarray


# three kernels instead of one: that takes a third of the time to compile


@compiled(**COMPILED)
def _choose_range(first, last, model_start, scaled, right_z, out):
    """Find the approximate orientations of a range of pairs."""
    for k in range(first, last):
        begin, end = model_start[k], model_start[k + 1]
        if end - begin < N_PARAMETERS:
            continue
        image = columns_of(scaled, begin, end)
        pose, out.is_ambiguous[k] = choose(image, right_z[k])
        out.status[k] = NOT_CONVERGED
        put_pose(pose, out.pose[k])


@compiled(**COMPILED)
def _adjust_range(first, last, model_start, scaled, right_z, mode, out):
    """Descend to the minimum, and close the conditions there."""
    limits = (np.int64(MOST_FINE_STEPS), FINE)
    for k in range(first, last):
        begin, end = model_start[k], model_start[k + 1]
        if end - begin < N_PARAMETERS:
            continue
        image, zr = columns_of(scaled, begin, end), right_z[k]
        corrections, pose = np.empty(image.shape), pose_at(out.pose[k])
        corrections[:] = 0.0
        pose, _, is_converged = descend(image, corrections, zr, pose, mode, limits)
        at = columns_of(scaled, begin, end)
        add_part(at, 1.0, corrections)
        pose, n_in_front = facing(at, zr, pose)
        if is_converged:
            is_behind = n_in_front < (1.0 - MOST_BEHIND) * (end - begin)
            out.status[k] = BEHIND if is_behind else ORIENTED
        put_pose(pose, out.pose[k])
        out.n_in_front[k] = n_in_front
        out.squares[k] = close_conditions(image, corrections, zr, pose)
        for i in range(4):
            copy_values(out.corrections[i, begin:end], corrections[i])


@compiled(**COMPILED)
def _judge_range(first, last, model_start, scaled, right_z, mode, out):
    """Find the precision, and blot out what is not determined."""
    for k in range(first, last):
        begin, end = model_start[k], model_start[k + 1]
        if end - begin < N_PARAMETERS:
            continue
        at = columns_of(scaled, begin, end)
        add_part(at, mode.keep, columns_of(out.corrections, begin, end))
        numbers = out.redundancy_numbers[begin:end]
        pose = pose_at(out.pose[k])
        estimate_precision(at, right_z[k], pose, mode, numbers, out.cofactor[k])
        if not is_determined(out.cofactor[k]):
            out.status[k] = UNDETERMINED
            out.pose[k], out.cofactor[k], out.squares[k] = np.nan, np.nan, np.nan
            out.corrections[:, begin:end], numbers[:] = np.nan, np.nan


@compiled(**COMPILED)
def columns_of(matrix, begin, end):
    """Copy the columns of one pair, (4, n)."""
    columns = np.empty((4, end - begin))
    for i in range(4):
        copy_values(columns[i], matrix[i, begin:end])
    return columns


@compiled(**COMPILED)
def add_part(matrix, part, other):
    """Do ``matrix += part * other``, which takes numba 0.5 s to compile."""
    for i in range(matrix.shape[0]):
        for k in range(matrix.shape[1]):
            matrix[i, k] += part * other[i, k]


@compiled(**COMPILED)
def close_conditions(image, corrections, zr, pose):
    """Sum of squares of the smallest corrections that satisfy the conditions at a pose.

    ``corrections`` (4, n) are improved in place; each pass squares what is missing.
    """
    frame = frame_of(pose, False)
    sums = form_normals(image, corrections, zr, frame, GAUSS_HELMERT)
    for _ in range(2):
        sums = form_normals(image, corrections, zr, frame, GAUSS_HELMERT)
    return sums[SQUARES]


@compiled(**COMPILED)
def is_determined(cofactor):
    """Whether the points determine an orientation well enough to be of any use."""
    trace = 0.0
    for i in range(len(cofactor)):
        trace += cofactor[i, i]
    # the comparison fails for NaN, too
    return trace * IMAGE_ERROR**2 <= WEAKEST**2


@compiled(fastmath=FAST, **COMPILED)
def estimate_precision(at, zr, pose, mode, numbers, cofactor):
    """Cofactors of the orientation and redundancy numbers of its conditions.

    Linearised at the image coordinates ``at`` (4, n). Fills ``numbers`` (n,) and
    ``cofactor`` (6, 6), of the base vector and the turn of the right camera, as
    :mod:`~.coplanarity_precision` forms them; NaN where the points do not determine
    them.
    """
    base, tangents, rotation = frame_of(pose, mode.fixes_x)
    n = at.shape[1]
    rows, weights, strengths = np.empty((n, N_PARAMETERS)), np.empty(n), np.empty(n)
    for i in range(n):
        point = at[0, i], at[1, i], at[2, i], at[3, i]
        _, by_base, by_turn, by_image = coplanarity(point, zr, base, rotation)
        row = parameter_row(by_base, by_turn, tangents)
        for k in range(N_PARAMETERS):
            rows[i, k] = row[k]
        d0, d1, d2, d3 = by_image
        variance = d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3
        weights[i] = 1.0 / variance if mode.is_weighted else 1.0
        strengths[i] = weights[i] * weights[i] * variance
    tangents = frame_of(pose, False)[1]
    fill_precision(rows, weights, strengths, tangents, numbers, cofactor)
