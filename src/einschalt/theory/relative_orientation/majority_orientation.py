"""What most of the points of a pair agree on, whatever the others say.

A descent with weights that fall with the size of a misclosure (absolute values first,
then Tukey's function) settles near where it begins. One exchanged name, tens of
millimetres beside its own point, may leave the orientation of all points so far off
that it settles anywhere: with misclosures that no photograph has. Then it begins at the
orientation of a few points instead: of many such choices that with which the majority
agrees best, by the size that (n + 6) / 2 misclosures do not exceed.

The same size is the scale of the norms: with the median, Tukey's function closes in on
five of a few points, which always fit, and calls the others gross errors.

Sources: Beaton and Tukey 1974 (Technometrics 16); Rousseeuw 1984 (Journal of the
American Statistical Association 79), least quantile of squares; Rousseeuw and Van
Driessen 2006 (Data Mining and Knowledge Discovery 12), steps that concentrate.
"""

import math

import numpy as np

from einschalt.foundations.kernels import compiled
from einschalt.theory.relative_orientation.coplanarity_condition import (
    COMPILED,
    FIRST_ORDER,
    NO_SUMS,
    add_condition,
    coplanarity,
    descent_step,
    frame_of,
    moved,
    parameter_row,
)
from einschalt.theory.relative_orientation.coplanarity_solution import (
    MOST_ROUGH_STEPS,
    N_PARAMETERS,
    ROUGH,
    descend,
)
from einschalt.theory.relative_orientation.starting_orientations import (
    normal_case_start,
)

# with fewer points the majority is not worth more than the worst of them
FEWEST_POINTS = N_PARAMETERS + 3
TUKEY_LIMIT = 4.685  # standard errors, where Tukey's weight vanishes
N_ABSOLUTE_STEPS, N_TUKEY_STEPS = 10, 15
TUKEY = TUKEY_LIMIT, True
# the smallest size of a misclosure that a weight is taken of, in standard errors
LEAST_SIZE = 0.1
# choices of a few points: where 5 of 15 are wrong, 4 of 100 choices hold none of them
N_CHOICES, N_CHOSEN = 100, N_PARAMETERS + 1
N_CONCENTRATIONS = 2
# of the principal distance: coarser is no measuring, nor matching in digital images
CREDIBLE_SIGMA = 5e-4
NEWTON_STEPS = 8


@compiled(**COMPILED)
def sizes_by_majority(image, zr, pose, size):
    """Scale of the misclosures where most points agree, looked for from a pose on.

    ``size`` (n,) is filled with their sizes there, in left principal distances as the
    scale.
    """
    settled = _settle(image, zr, pose, size)
    least = misclosure_scale(image, zr, settled, size)
    if least <= CREDIBLE_SIGMA:
        return least
    start = _pose_of_few(image, zr, pose, size)
    for other in (start, _settle(image, zr, start, size)):
        scale = misclosure_scale(image, zr, other, size)
        if not least <= scale:
            settled, least = other, scale
    return misclosure_scale(image, zr, settled, size)


@compiled(**COMPILED)
def _settle(image, zr, pose, size):
    for turn in range(N_ABSOLUTE_STEPS + N_TUKEY_STEPS):
        scale = misclosure_scale(image, zr, pose, size)
        sums = weighted_sums(image, zr, pose, scale, TUKEY, turn < N_ABSOLUTE_STEPS)
        step, _ = descent_step(sums, 0.0)
        if not math.isfinite(step[0]):
            break
        pose = moved(pose, step)
    return pose


@compiled(**COMPILED)
def _pose_of_few(image, zr, pose, size):
    """Pose of a few points that most others agree with best."""
    n = image.shape[1]
    few = np.empty((4, N_CHOSEN))
    order = np.arange(n)
    best, least, drawn = pose, np.inf, 1971
    for _ in range(N_CHOICES):
        # the same choices for every pair, in whatever thread
        for i in range(N_CHOSEN):
            drawn = (1664525 * drawn + 1013904223) % 4294967296
            other = i + (drawn // 65536) % (n - i)
            order[i], order[other] = order[other], order[i]
            for axis in range(4):
                few[axis, i] = image[axis, order[i]]
        # upright pairs are found from the one start, oblique ones from the other
        for start in (pose, normal_case_start(few, zr)):
            found = _fitted(few, zr, start)
            for _ in range(N_CONCENTRATIONS):
                found = _concentrated(image, zr, found, size)
            scale = misclosure_scale(image, zr, found, size)
            if scale < least:
                best, least = found, scale
        if least <= CREDIBLE_SIGMA:
            break
    return best


@compiled(**COMPILED)
def _fitted(image, zr, start):
    idle = np.empty(image.shape)
    idle[:] = 0.0
    limits = (np.int64(MOST_ROUGH_STEPS), ROUGH)
    return descend(image, idle, zr, start, FIRST_ORDER, limits)[0]


@compiled(**COMPILED)
def _concentrated(image, zr, pose, size):
    """Pose of the majority that agrees best with another pose."""
    misclosure_scale(image, zr, pose, size)
    rows = np.argsort(size)
    best = np.empty((4, n_of_majority(image.shape[1])))
    for axis in range(4):
        for i in range(best.shape[1]):
            best[axis, i] = image[axis, rows[i]]
    return _fitted(best, zr, pose)


@compiled(**COMPILED)
def misclosure_scale(image, zr, pose, size):
    """Standard error of a misclosure by the majority, in left principal distances.

    ``size`` (n,) is filled with the lengths of the corrections that close each
    condition. What more than half of them do not exceed tells it, as the median does of
    many: of few the median is no measure, since any five can be closed together.
    """
    base, rotation = pose
    n = image.shape[1]
    for i in range(n):
        point = image[0, i], image[1, i], image[2, i], image[3, i]
        f, _, _, (d0, d1, d2, d3) = coplanarity(point, zr, base, rotation)
        size[i] = abs(f) / math.sqrt(d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3)
    last = n_of_majority(n) - 1
    usual = normal_size((last + 0.5) / n) * math.sqrt((n - N_PARAMETERS) / n)
    return np.partition(size, last)[last] / usual


@compiled(**COMPILED)
def n_of_majority(n):
    """How many of n points any others share a majority with, five being free."""
    return (n + N_PARAMETERS + 1) // 2


@compiled(**COMPILED)
def normal_size(share):
    """Size that a share of standard normal errors does not exceed."""
    z = 0.5
    for _ in range(NEWTON_STEPS):
        density = math.sqrt(2.0 / math.pi) * math.exp(-0.5 * z * z)
        z -= (math.erf(z / math.sqrt(2.0)) - share) / density
    return z


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
