"""The right one of the relative orientations that fit the image coordinates.

The coplanarity condition has several minima, some of them with all points in front of
both cameras. The cheap start (normal case) is refined first, and accepted only where
that is safe (:func:`is_safe`, and no second solution of a plane scene); otherwise the
lattice of all rotations is searched.

Of all solutions with every point in front the one with the smallest sum of squares is
taken. Where two fit so equally that observations cannot tell them apart (five points;
points in a plane), the one nearer to the normal case is: -2 log likelihood, of errors
not below 1e-5 of the principal distance, plus the squares of the tilts in units of
their usual spread.

Descents are Gauss-Newton steps, damped as Levenberg and Marquardt do. While they are
far from a minimum, the base is set to the best one for the rotation after every step:
the valleys of narrow bundles are straight in the rotation alone.
"""

import math

import numpy as np

from einschalt.foundations.kernels import compiled, copy_values, place_of_least
from einschalt.theory.relative_orientation.coplanarity_condition import (
    COMPILED,
    DIAGONAL,
    FIRST_ORDER,
    GRADIENT,
    NO_SUMS,
    SQUARES,
    descent_step,
    factorise,
    form_normals,
    frame_of,
    moved,
    reduce_side,
    square_of,
)
from einschalt.theory.relative_orientation.starting_orientations import (
    facing,
    next_start,
    normal_case_start,
    planar_twin,
    survey_lattice,
    with_best_base,
)

N_PARAMETERS = 5
# squares of steps in units of their standard error: enough to compare, and final
ROUGH, FINE = 1e-4, 1e-14
# sum of squares per point that is nothing but rounding of numbers of the order of 1
ROUNDING = 1e-29
MOST_ROUGH_STEPS, MOST_FINE_STEPS = 30, 60
# sums of squares may grow by this part, since corrections change the linearisation
GROWTH = 1.001
LONGEST_STEP = 0.7
FIRST_DAMPING, LARGEST_DAMPING = 1e-4, 1e8
# descents of a search that finds something convincing, and of one that does not
FEW_STARTS, MOST_STARTS = 20, 120
# points for which several orientations may be convincing
MOST_AMBIGUOUS = 6
N_FOUND = 14
MISFIT, COST = 12, 13

# what makes the cheap start safe
SAFE_POINTS = 8
SAFE_SIGMA = 2e-4
SAFE_SPREAD = 3e-3
SAFE_BASE_TILT = math.sin(math.radians(30.0))
SAFE_AXES = math.cos(math.radians(45.0))
# image errors below this part of the principal distance do not tell solutions apart
LEAST_SIGMA = 1e-5
# bound of the doubt in large errors, so that points in front still matter more
MOST_DISBELIEF = 1e3
# a priori spread of the tilts of the base against either image, and of the axes [rad]
BASE_TILT_SPREAD, AXES_SPREAD = 0.35, 0.52
IN_FRONT_REWARD = 1e4
# difference of -2 log likelihood that tells two solutions apart
TELLING = 12.0
# trace of the rotation between two solutions that count as one
SAME_TRACE = 1.0 + 2.0 * math.cos(0.02)


@compiled(**COMPILED)
def descend(image, corrections, zr, pose, mode, limits):
    """Minimise the sum of squares from a pose: pose, sums, whether it converged.

    ``limits`` are the most steps, and the square of a step in units of its standard
    error that ends the descent.
    """
    most_steps, tolerance = limits
    is_rough = mode.is_weighted and mode.keep == 0.0
    n = image.shape[1]
    trial, step, gain = pose, (0.0, 0.0, 0.0, 0.0, 0.0), 0.0
    sums, squares, damping = NO_SUMS, np.inf, 0.0
    for _ in range(most_steps):
        frame = frame_of(trial, mode.fixes_x)
        trial_sums = form_normals(image, corrections, zr, frame, mode)
        if is_short(step) and trial_sums[SQUARES] <= GROWTH * squares:
            damping = less_damping(damping, step, sums, trial_sums)
            pose, sums, squares = trial, trial_sums, trial_sums[SQUARES]
            if descent_step(sums, 0.0)[1] <= tolerance * squares / n + ROUNDING * n:
                return pose, sums, True
        else:
            damping = more_damping(damping, step, gain, sums, trial_sums)
            corrections[:] = 0.0
            if damping > LARGEST_DAMPING:
                break
        step, gain = descent_step(sums, damping)
        trial = moved(pose, step)
        if is_rough:
            trial = with_best_base(image, zr, trial)
    return pose, sums, False


@compiled(**COMPILED)
def less_damping(damping, step, sums, next_sums):
    """Damping with which an accepted step would have led to where its slope is zero.

    A secant in one number, which adds the curvature that Gauss-Newton neglects and
    takes away damping that is no longer needed.
    """
    slope = 0.0
    for i in range(N_PARAMETERS):
        slope += step[i] * next_sums[GRADIENT + i]
    size = step_size(step, sums)
    return max(0.0, damping + slope / size) if size > 0.0 else 0.0


@compiled(**COMPILED)
def more_damping(damping, step, gain, sums, next_sums):
    """Damping after a step that was not accepted.

    Along a step in a bent valley the sum of squares is
    ``s (1 - 2 t) + gain t^2 + bend t^4``; the damping shortens the step to the smallest
    value of that.
    """
    bend = next_sums[SQUARES] - sums[SQUARES] + gain
    size = step_size(step, sums)
    if not (bend < np.inf and size > 0.0 and gain > 0.0):
        return max(10.0 * damping, FIRST_DAMPING)
    part = min(0.5, (0.5 * gain / bend) ** (1.0 / 3.0))
    return damping + gain / size * (1.0 / part - 1.0)


@compiled(**COMPILED)
def step_size(step, sums):
    """Square of a step in the metric of the damping."""
    size = 0.0
    for i in range(N_PARAMETERS):
        size += step[i] * step[i] * sums[DIAGONAL[i]]
    return size


@compiled(**COMPILED)
def is_short(step):
    """Whether a step is short enough for the linearisation to be of use."""
    square = 0.0
    for part in step:
        square += part * part
    return square < LONGEST_STEP * LONGEST_STEP


@compiled(**COMPILED)
def misfit(squares, n):
    """-2 log likelihood of a solution with errors of unknown size.

    Redundancy times log variance; sizes below 1e-5 are not told apart, and sizes above
    2e-4 are hardly believed. (With five points only the latter tells a solution from a
    mere minimum.)
    """
    size = math.log(squares / n + LEAST_SIGMA * LEAST_SIGMA)
    disbelief = min(squares / (SAFE_SIGMA * SAFE_SIGMA), MOST_DISBELIEF)
    return (n - N_PARAMETERS) * size + disbelief


@compiled(**COMPILED)
def tilts(pose):
    """Sines of the base against the left and right image, cosine between the axes."""
    (x, y, z), r = pose
    return z, r[2] * x + r[5] * y + r[8] * z, r[8]


@compiled(**COMPILED)
def cost(pose, squares, n, n_front):
    """What the choice between solutions makes smallest."""
    left, right, axes = tilts(pose)
    obliquity = (left * left + right * right) / BASE_TILT_SPREAD**2
    obliquity += 2.0 * (1.0 - axes) / AXES_SPREAD**2
    return misfit(squares, n) + obliquity + IN_FRONT_REWARD * (n - n_front)


@compiled(**COMPILED)
def is_safe(pose, sums, n, n_front):
    """Whether a solution from the cheap start needs no search for others."""
    left, right, axes = tilts(pose)
    if n < SAFE_POINTS or n_front < n:
        return False
    if max(abs(left), abs(right)) > SAFE_BASE_TILT or axes < SAFE_AXES:
        return False
    variance = sums[SQUARES] / (n - N_PARAMETERS)
    spread = variance * trace_of_inverse(factorise(sums, 0.0))
    return variance < SAFE_SIGMA * SAFE_SIGMA and spread < SAFE_SPREAD * SAFE_SPREAD


@compiled(**COMPILED)
def trace_of_inverse(factor):
    """Sum of the cofactors of the five parameters."""
    return (
        square_of(reduce_side(factor, (1.0, 0.0, 0.0, 0.0, 0.0)))
        + square_of(reduce_side(factor, (0.0, 1.0, 0.0, 0.0, 0.0)))
        + square_of(reduce_side(factor, (0.0, 0.0, 1.0, 0.0, 0.0)))
        + square_of(reduce_side(factor, (0.0, 0.0, 0.0, 1.0, 0.0)))
        + square_of(reduce_side(factor, (0.0, 0.0, 0.0, 0.0, 1.0)))
    )


@compiled(**COMPILED)
def pose_at(row):
    """Pose that stands in a row of an array."""
    rotation = row[3], row[4], row[5], row[6], row[7], row[8], row[9], row[10], row[11]
    return (row[0], row[1], row[2]), rotation


@compiled(**COMPILED)
def put_pose(pose, row):
    """Write a pose into the first places of a row of an array."""
    base, rotation = pose
    for i in range(3):
        row[i] = base[i]
    for i in range(9):
        row[3 + i] = rotation[i]


@compiled(**COMPILED)
def find(image, idle, zr, start, found):
    """Descend from one start: the pose, and whether it is safe without any search.

    ``found`` (14,) is filled with pose (12), misfit and cost; ``idle`` (4, n) holds
    zeros.
    """
    n = image.shape[1]
    # a literal number would be compiled as a case of its own
    limits = (np.int64(MOST_ROUGH_STEPS), ROUGH)
    pose, sums, is_converged = descend(image, idle, zr, start, FIRST_ORDER, limits)
    pose, n_front = facing(image, zr, pose)
    put_pose(pose, found)
    found[MISFIT] = misfit(sums[SQUARES], n)
    found[COST] = cost(pose, sums[SQUARES], n, n_front)
    if not found[COST] < np.inf:
        found[COST] = np.inf
    return pose, is_converged and is_safe(pose, sums, n, n_front)


@compiled(**COMPILED)
def choose(image, zr):
    """Best approximate pose of a pair, and whether another one fits equally well."""
    idle, found = np.empty(image.shape), np.empty((2, N_FOUND))
    idle[:], found[:] = 0.0, np.inf
    squares, bases = np.empty(0), np.empty((0, 3))
    start, is_last = normal_case_start(image, zr), False
    for place in range(MOST_STARTS + 2):
        pose, is_enough = find(image, idle, zr, start, found[place])
        if is_last:
            break
        if place == 0 and is_enough:
            has_twin, start = planar_twin(image, zr, pose)
            if not has_twin:
                return pose, False
            is_last = True
            continue
        if place == 0:
            squares, bases = survey_lattice(image, zr)
            first = found[0]
            found = np.empty((MOST_STARTS + 2, N_FOUND))
            found[:] = np.inf
            copy_values(found[0], first)
        is_last = is_searched(found, place, image.shape[1], squares)
        if is_last:
            best = pose_at(found[place_of_least(found[:, COST])])
            start = planar_twin(image, zr, best)[1]
        else:
            start = next_start(squares, bases)
    best = place_of_least(found[:, COST])
    return pose_at(found[best]), has_rival(found, best)


@compiled(**COMPILED)
def is_searched(found, place, n, squares):
    """Whether the search may end.

    As long as nothing convincing is found, or if there are so few points that several
    solutions convince, all places of the lattice are tried.
    """
    if place == MOST_STARTS or not squares[place_of_least(squares)] < np.inf:
        return True
    if place < FEW_STARTS or n <= MOST_AMBIGUOUS:
        return False
    limit = misfit(n * SAFE_SIGMA * SAFE_SIGMA, n)
    for row in found[: place + 1]:
        if row[COST] < 0.5 * IN_FRONT_REWARD and row[MISFIT] < limit:
            return True
    return False


@compiled(**COMPILED)
def has_rival(found, best):
    """Whether a solution that differs from the best fits about as well."""
    for row in found:
        trace = 0.0
        for i in range(3, 12):
            trace += row[i] * found[best, i]
        is_possible = row[COST] < found[best, COST] + 0.5 * IN_FRONT_REWARD
        if (
            trace < SAME_TRACE
            and is_possible
            and row[MISFIT] < found[best, MISFIT] + TELLING
        ):
            return True
    return False
