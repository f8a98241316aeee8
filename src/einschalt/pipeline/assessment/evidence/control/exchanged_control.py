"""Two control points that are given under each other's name.

Each lies where the other is given. One that was fitted draws its models along; so all
models are adjusted at once in plan, which is linear whatever the models are like, and
control that contradicts is set aside there: the others tell where it lies. The pair is
the cause where the block, computed once more with the two put right, misses its control
by a fifth of what it did.
"""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.frame_columns import values_of
from einschalt.pipeline.assessment.evidence.control.displacements import (
    Displacement,
    new_points_apart,
)
from einschalt.pipeline.densification.simultaneous import ADJUSTED_AS, block_tables
from einschalt.stages.error_propagation.given_points import PLAN
from einschalt.stages.simultaneous.adjustment import determined_part
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE
from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.gross_errors import examine_control

# what control is missed by must become so many times smaller
LEAST_IMPROVEMENT = 5.0
# pairs, the one that matches best first, with which the block is computed again
MOST_PAIRS = 3
# measured points, beyond which a block is not computed again
MOST_MEASURED = 20_000


@dataclass(frozen=True, eq=False)
class ExchangedControl:
    """A pair of control points under each other's name."""

    points: tuple[str, str]
    apart: float  # of their given coordinates [m]
    rms: float  # of the differences at all control points, TOTAL [m]
    rms_exchanged: float  # the same of the block with both put right
    corrected: object  # examination of that block
    moved: Displacement  # the new points by putting it right


def find_exchanged_control(examined) -> ExchangedControl | None:
    """Look for a pair that explains what the block misses its control by.

    None where control is not missed by more than is claimed, and of large blocks.
    """
    # models that were given up may have been so for the pair
    two_step = examined.all_in_two_steps
    if not two_step.is_possible or not _is_missed(two_step):
        return None
    if sum(map(len, two_step.model_points.values())) > MOST_MEASURED:
        return None
    for pair, apart in _matching_pairs(two_step):
        found = _tried(examined, pair, apart)
        if found is not None:
            return found
    return None


def with_names_exchanged(block, pair):
    """A block whose control has two names exchanged."""
    control = block.control_points
    names = control["point_id"].to_numpy(dtype=object, copy=True)
    one, other = (names == name for name in pair)
    names[one], names[other] = pair[1], pair[0]
    return replace(block, control_points=control.assign(point_id=names))


def _is_missed(two_step):
    left_out = two_step.control_left_out["is_suspect"].astype(bool)
    return two_step.known_control.are_beyond or bool(left_out.any())


def _matching_pairs(two_step):
    """Pairs each of which lies where the other is given, and how far apart [m].

    A few, the best match first.
    """
    block = two_step.block
    given = block.control_points.drop_duplicates("point_id").set_index("point_id")[PLAN]
    names, there = _as_others_have_it(two_step)
    known = given.reindex(names).to_numpy(dtype=float)
    is_off = np.isfinite(known).all(axis=1) & np.isfinite(there).all(axis=1)
    names, known, there = names[is_off], known[is_off], there[is_off]
    squares = np.sum((there[:, None] - known) ** 2, axis=2)
    away = np.sqrt((squares + squares.T) / 2.0)  # of both, RMS
    apart = np.hypot(*np.moveaxis(known[:, None] - known, 2, 0))
    one, other = np.nonzero(np.triu(LEAST_IMPROVEMENT * away < apart, 1))
    best = np.argsort(away[one, other], kind="stable")[:MOST_PAIRS]
    return [
        ((str(names[i]), str(names[j])), float(apart[i, j]))
        for i, j in zip(one[best], other[best], strict=True)
    ]


def _as_others_have_it(two_step):
    """Names of control that may be exchanged, and where all others have it."""
    block, flights = two_step.block, two_step.solution.flights
    if block.high_flight is None:  # no model is fitted onto control
        points = two_step.points
        control = points[points["role"] != "new"]
        return control["point_id"].to_numpy(dtype=object), values_of(control, PLAN)
    kinds = {name: flight.transformation for name, flight in block.flights.items()}
    kinds = {name: ADJUSTED_AS.get(kind, kind) for name, kind in kinds.items()}
    try:
        tables = block_tables(block, flights, kinds)
        part, _ = determined_part(tables)
    except EinschaltError:  # control does not hold all models at once
        return np.empty(0, dtype=object), np.empty((0, 2))
    observations = part.observations
    if observations.is_in_space:
        observations = observations.in_plan(is_affine=True)
    verdict = examine_control(adjust(observations), FINDING_SIGNIFICANCE)
    is_out = verdict.is_suspect
    return tables.point_id[part.points[is_out]], verdict.without.points[is_out, :2]


def _tried(examined, pair, apart):
    """The pair, if the block with both put right misses its control by far less."""
    before = examined.all_in_two_steps.known_control.rms
    try:
        again = examined.computed_again(with_names_exchanged(examined.block, pair))
    except EinschaltError:  # nothing is gained
        return None
    if not again.all_in_two_steps.is_possible:
        return None
    after = again.all_in_two_steps.known_control.rms
    if not LEAST_IMPROVEMENT * after < before:
        return None
    moved = new_points_apart(examined, again.points)
    return ExchangedControl(pair, apart, before, after, again, moved)
