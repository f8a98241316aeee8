"""Two control points that are given under each other's name.

Each lies where the other is given. One that was fitted draws its models along; so all
models are adjusted at once in plan, which is linear whatever the models are like, and
control that contradicts is set aside there: the others tell where it lies. The pair is
the cause where the block, computed once more with the two put right, misses its control
by a fifth of what it did.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.frame_columns import values_of
from einschalt.pipeline.densification.one_adjustment import solve_in_one_adjustment
from einschalt.pipeline.densification.simultaneous import ADJUSTED_AS, block_tables
from einschalt.pipeline.densification.two_steps import (
    TwoStepSolution,
    solve_in_two_steps,
)
from einschalt.stages.simultaneous.adjustment import determined_part
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE
from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.gross_errors import examine_control

PLAN = ["easting", "northing"]
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
    # root mean square distance of the two from where the other is given, TOTAL [m]
    away: float
    rms: float  # of the differences at all control points, TOTAL [m]
    rms_exchanged: float  # the same of the block with both put right
    corrected: object  # examination of that block
    moved: float  # the new points by putting it right, TOTAL, RMS [m]
    moved_heights: float  # their heights, RMS [m]; 0 without


class BesideExchangedControl:
    """What can be asked of an examination about control under another's name."""

    @cached_property
    def exchanged_control(self):
        """The pair of control points that explains what is missed, or None."""
        return find_exchanged_control(self, self._examined_again)

    def _examined_again(self, block):
        """Examination of a block that is computed in the same way."""
        is_in_two_steps = isinstance(self.solution, TwoStepSolution)
        solve = solve_in_two_steps if is_in_two_steps else solve_in_one_adjustment
        flights = self.two_step.solution.flights
        return type(self)(solve(block, self.settings, flights, _in_silence))


def find_exchanged_control(examined, solved) -> ExchangedControl | None:
    """Look for a pair that explains what the block misses its control by.

    ``solved(block)`` examines a block that is computed in the same way. None where
    control is not missed by more than is claimed, and of large blocks.
    """
    two_step = examined.two_step
    if not two_step.is_possible or not _is_missed(two_step):
        return None
    if sum(map(len, two_step.model_points.values())) > MOST_MEASURED:
        return None
    for pair, away in _matching_pairs(two_step)[:MOST_PAIRS]:
        found = _tried(examined, solved, pair, away)
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
    """Pairs each of which lies where the other is given, and how far from there [m].

    The best match first.
    """
    block = two_step.block
    given = block.control_points.drop_duplicates("point_id").set_index("point_id")[PLAN]
    names, there = _as_others_have_it(two_step)
    known = given.reindex(names).to_numpy(dtype=float)
    is_off = np.isfinite(known).all(axis=1) & np.isfinite(there).all(axis=1)
    pairs = []
    for i, j in combinations(np.flatnonzero(is_off), 2):
        away = np.sqrt(np.mean(np.sum((there[[i, j]] - known[[j, i]]) ** 2, axis=1)))
        if LEAST_IMPROVEMENT * away < np.hypot(*(known[i] - known[j])):
            pairs.append(((str(names[i]), str(names[j])), float(away)))
    return sorted(pairs, key=lambda pair: pair[1])


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


def _tried(examined, solved, pair, away):
    """The pair, if the block with both put right misses its control by far less."""
    before = examined.two_step.known_control.rms
    block = examined.block
    try:
        again = solved(with_names_exchanged(block, pair))
    except EinschaltError:  # nothing is gained
        return None
    if not again.two_step.is_possible:
        return None
    after = again.two_step.known_control.rms
    if not LEAST_IMPROVEMENT * after < before:
        return None
    given = block.control_points.drop_duplicates("point_id").set_index("point_id")[PLAN]
    apart = np.hypot(*np.diff(given.loc[list(pair)].to_numpy(dtype=float), axis=0)[0])
    moved = _moved(examined.points, again.points)
    return ExchangedControl(pair, float(apart), away, before, after, again, *moved)


def _moved(points, there):
    """How far the new points lie from where others have them, RMS [m]: plan, height."""
    axes = [*PLAN, *(["height"] if "height" in points else [])]
    new = points[points["role"] == "new"]
    there = there.drop_duplicates("point_id").set_index("point_id")
    there = there.reindex(index=new["point_id"], columns=axes).to_numpy(dtype=float)
    if not len(new):
        return 0.0, 0.0
    squares = np.nan_to_num(values_of(new, axes) - there) ** 2
    plan, height = squares[:, :2].sum(axis=1), squares[:, 2:].sum(axis=1)
    return float(np.sqrt(plan.mean())), float(np.sqrt(height.mean()))


def _in_silence(_stage):
    """Report nothing: the work is done."""
