"""What of a block can be determined, said before anything is computed.

A model needs points that other models or the control hold as well: three off a line
for affine, two for helmert. What hangs together needs as much control. Models that
fall short are taken out, which may leave their neighbours short in turn. Parts that
are joined like a hinge, at one point, pass these counts; they show as unknowns that
nothing determines when the normal equations are factored, and their free motion tells
which models they are.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.kernels import compiled
from einschalt.theory.block_adjustment.model_graph import incidence_of

FINE, FEW_TIES, TIES_ON_LINE, NO_CONTROL, CONTROL_ON_LINE, LOOSE = range(6)
# of models that are given up only while the block is adjusted
CONTRADICTED, RESTLESS = 6, 7
LEAST_POINTS = {True: 3, False: 2}  # affine, helmert
INCREDIBLE = 5.0  # s_0 above which least squares are not to be trusted
# smaller principal extent over larger one, below which points lie on a line
ON_LINE = 1e-6
# the same of measured points that lay on a line before they were measured
NEAR_LINE = 0.01


@dataclass(frozen=True, eq=False)
class Determinacy:
    """Which models of a block can be determined."""

    # (n_models,): FINE, FEW_TIES, TIES_ON_LINE, NO_CONTROL, CONTROL_ON_LINE, LOOSE,
    # CONTRADICTED, RESTLESS
    verdict: np.ndarray
    # (n_models,): points that control or another determined model holds as well
    n_ties: np.ndarray
    # (n_models,): parts that hang together, −1 for models that were taken out singly
    part: np.ndarray
    n_control: np.ndarray  # (n_models,): control points of each model's part

    @property
    def is_fine(self):
        """Models that can be determined, ndarray of bool."""
        return self.verdict == FINE


def examine(observations) -> Determinacy:
    """Find the models that cannot be determined, and why."""
    n_models = observations.n_models
    verdict = np.full(n_models, FINE)
    needed = _least_points(observations.is_affine)
    incidence = incidence_of(
        observations.model, observations.point, n_models, observations.n_points
    )
    is_control = observations.is_control
    n_ties = np.zeros(n_models, dtype=np.int64)
    while True:
        _prune(verdict, n_ties, needed, is_control, *incidence.arrays)
        on_line = _ties_on_line(observations, verdict, is_control)
        if not on_line.any():
            break
        verdict[on_line] = TIES_ON_LINE
    part = _label_parts(verdict, *incidence.arrays)
    n_control = _judge_parts(observations, verdict, part)
    return Determinacy(verdict, n_ties, part, n_control)


@compiled
def _prune(verdict, n_ties, needed, is_control, model, point, model_start, fan, rows):
    """Take out models with too few ties, until all that are left have enough."""
    n_models = needed.size
    holders = np.empty(fan.size - 1, dtype=np.int64)
    holders[:] = 0
    for row in range(model.size):
        if verdict[model[row]] == FINE:
            holders[point[row]] += 1
    queue = np.empty(n_models, dtype=np.int64)
    head, tail = 0, 0
    for m in range(n_models):
        if verdict[m] != FINE:
            continue
        n_ties[m] = 0
        for row in range(model_start[m], model_start[m + 1]):
            if is_control[point[row]] or holders[point[row]] > 1:
                n_ties[m] += 1
        if n_ties[m] < needed[m]:
            verdict[m] = FEW_TIES
            queue[tail] = m
            tail += 1
    while head < tail:
        m = queue[head]
        head += 1
        for row in range(model_start[m], model_start[m + 1]):
            p = point[row]
            holders[p] -= 1
            if is_control[p] or holders[p] != 1:
                continue
            # the one model that still holds the point has it for itself now
            for k in range(fan[p], fan[p + 1]):
                other = model[rows[k]]
                if verdict[other] == FINE:
                    n_ties[other] -= 1
                    if n_ties[other] < needed[other]:
                        verdict[other] = FEW_TIES
                        queue[tail] = other
                        tail += 1


@compiled
def _label_parts(verdict, model, point, model_start, fan, rows):
    part = np.empty(verdict.size, dtype=np.int64)
    queue = np.empty(verdict.size, dtype=np.int64)
    part[:] = -1
    n_parts = 0
    for seed in range(verdict.size):
        if verdict[seed] != FINE or part[seed] >= 0:
            continue
        head, tail = 0, 1
        queue[0], part[seed] = seed, n_parts
        while head < tail:
            m = queue[head]
            head += 1
            for row in range(model_start[m], model_start[m + 1]):
                p = point[row]
                for k in range(fan[p], fan[p + 1]):
                    other = model[rows[k]]
                    if verdict[other] == FINE and part[other] < 0:
                        part[other] = n_parts
                        queue[tail] = other
                        tail += 1
        n_parts += 1
    return part


def _ties_on_line(observations, verdict, is_control):
    """Affine models whose ties lie on a line or in one place; helmert: in one place."""
    model, point = observations.model, observations.point
    is_used = verdict[model] == FINE
    holders = np.bincount(point[is_used], minlength=observations.n_points)
    is_tie = is_used & (is_control[point] | (holders[point] > 1))
    flat = _is_flat(observations.xy[is_tie], model[is_tie], observations.is_affine)
    return flat & (verdict == FINE)


def _is_flat(xy, group, is_affine, share=ON_LINE):
    """Whether the points of each group lie on a line, or all in one place."""
    n_groups = len(is_affine)
    count = np.maximum(np.bincount(group, minlength=n_groups), 1)
    origin = np.zeros((n_groups, 2))
    origin[group] = xy
    near = xy - origin[group]
    mean = np.column_stack([np.bincount(group, c, n_groups) for c in near.T])
    d = near - (mean / count[:, None])[group]
    xx, yy, xy_ = (
        np.bincount(group, value, n_groups)
        for value in (d[:, 0] ** 2, d[:, 1] ** 2, d[:, 0] * d[:, 1])
    )
    trace, determinant = xx + yy, xx * yy - xy_**2
    is_line = determinant <= (share * trace) ** 2
    return (trace <= 0.0) | (is_affine & is_line)


def _judge_parts(observations, verdict, part):
    """Control of each part; parts with too little of it get their verdict."""
    row_part = part[observations.model]
    is_held = (row_part >= 0) & observations.is_control[observations.point]
    pairs = np.unique(
        np.column_stack([row_part[is_held], observations.point[is_held]]), axis=0
    )
    n_parts = int(part.max(initial=-1)) + 1
    count = np.bincount(pairs[:, 0], minlength=n_parts)
    # one helmert model in a part ties easting to northing for all of it
    is_affine = np.ones(n_parts, dtype=bool)
    is_helmert = (part >= 0) & ~observations.is_affine
    is_affine[part[is_helmert]] = False
    on_line = _is_flat(observations.control[pairs[:, 1]], pairs[:, 0], is_affine)
    of_part = np.where(on_line, CONTROL_ON_LINE, FINE)
    of_part[count < _least_points(is_affine)] = NO_CONTROL
    is_in = part >= 0
    verdict[is_in] = of_part[part[is_in]]
    n_control = np.zeros(len(part), dtype=np.int64)
    n_control[is_in] = count[part[is_in]]
    return n_control


def _least_points(is_affine):
    return np.where(is_affine, LEAST_POINTS[True], LEAST_POINTS[False])


# what moves less than this share of the largest motion does not move
STANDS_STILL = 1e-6
MOST_MOTIONS = 50
# a model whose edge may lie anywhere within this share of its extent is not placed
LEAST_PRECISION = 0.1


def loose_models(solution):
    """Models that move freely, or as good as freely, against the rest of the block.

    They are joined to it like a hinge, or hang on it by a thread.
    """
    is_loose = solution.is_held.any(axis=1)
    if is_loose.any():
        for model in np.flatnonzero(is_loose)[:MOST_MOTIONS]:
            unknown = int(np.argmax(solution.is_held[model]))
            motion = solution.null_motion(model, unknown)
            is_loose |= motion > STANDS_STILL * motion.max(initial=0.0)
        return is_loose
    return ~(solution.relative_errors < LEAST_PRECISION)


def why_loose(solution, is_loose):
    """Say why models of an adjusted block move.

    CONTRADICTED where least squares are not credible: gross errors have shrunk them.
    CONTROL_ON_LINE where nothing of the block stands and its control lies near a line:
    errors of a few centimetres keep it from lying on one. LOOSE otherwise.
    """
    observations = solution.observations
    if solution.s_0 > INCREDIBLE and not solution.is_held.any():
        return np.full(is_loose.size, CONTRADICTED)
    cause = np.full(is_loose.size, LOOSE)
    control = observations.control[observations.is_control][:, :2]
    group = np.zeros(len(control), dtype=np.int64)
    is_affine = np.ones(1, dtype=bool)
    if is_loose.all() and _is_flat(control, group, is_affine, NEAR_LINE)[0]:
        cause[:] = CONTROL_ON_LINE
    return cause
