"""Two control points that are given under each other's name.

Each lies where the other is given. One that was fitted draws its models along; so all
models are adjusted at once in plan, which is linear whatever the models are like, and
every pair is exchanged there. The pair is the cause where the block, computed once more
with the two put right, misses its control by a fifth of what it did.
"""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.frame_columns import values_of
from einschalt.pipeline.assessment.evidence.control.displacements import (
    Displacement,
    new_points_apart,
)
from einschalt.pipeline.assessment.known_points import DIFFERENCES, total_rms
from einschalt.pipeline.densification.simultaneous import ADJUSTED_AS, block_tables
from einschalt.stages.error_propagation.given_points import (
    PLAN,
    approximations_are_control,
)
from einschalt.stages.simultaneous.adjustment import determined_part
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE
from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.exchanged_points import pairs_of_given_points

# what control is missed by must become so many times smaller
LEAST_IMPROVEMENT = 5.0
# pairs, the one that matches best first, with which the block is computed again
MOST_PAIRS = 3
# of chance, where all models are mirrored and would not be
LEVEL_OF_MIRROR = 0.05
# measured points, beyond which a block is not computed again
MOST_MEASURED = 20_000


@dataclass(frozen=True, eq=False)
class ExchangedControl:
    """A pair of control points under each other's name."""

    points: tuple[str, str]
    apart: float  # of their given coordinates [m]
    rms: float  # of the differences at all given points, TOTAL [m]
    rms_exchanged: float  # the same of the block with both put right
    corrected: object  # examination of that block
    moved: Displacement  # the new points by putting it right


def find_exchanged_control(examined) -> ExchangedControl | None:
    """Look for a pair that explains what the block misses its given points by.

    Control and check points. None where they are missed by no more than is stated and
    claimed, and of large blocks.
    """
    if examined.block.control_points is None:
        return None
    if not _is_small(_all_flights(examined)):
        return None
    for measure in MEASURES:
        missed = measure(examined)
        if _is_too_far(examined, measure, missed):
            return _first_of(examined, measure, missed)
    return None


def _first_of(examined, measure, missed):
    """The first pair that explains what given points are missed by, or None."""
    for pair in _pairs(examined):
        found = _tried(examined, measure, missed, pair)
        if found is not None:
            return found
    return None


def adjusted_in_plan(examined):
    """All models adjusted at once in plan, and the names of its points, or None."""
    return _in_plan(examined.block, _all_flights(examined))


def _all_flights(examined):
    """The flights with models that were given up, which may have been so for a pair."""
    return examined.all_in_two_steps.solution.flights


def _is_small(flights):
    measured = sum(len(flight.model_points) for flight in flights.values())
    return measured <= MOST_MEASURED


def with_control_exchanged(error, block, flights, solve):
    """The same error, naming two control points as its cause where there are any.

    Two that ``solve(block)`` does not fail with under each other's name.
    """
    is_possible = block.control_points is not None and _control_is_fitted(block)
    if not (is_possible and _is_small(flights)):
        return error
    for pair in _pairs_that_adjust(_in_plan(block, flights), FINDING_SIGNIFICANCE):
        try:
            solve(with_names_exchanged(block, pair))
        except EinschaltError:
            continue
        return error.with_facts(
            remedy=f"Exchange the names of control points {pair[0]} and {pair[1]}: "
            "each lies where the other one is given"
        )
    return error


def with_names_exchanged(block, pair):
    """A block whose given points have two names exchanged.

    Approximate points as well, where models are fitted onto control.
    """
    tables = ["control_points"]
    if _are_fitted_onto_control(block):
        tables.append("approximate_points")
    return replace(block, **{n: _exchanged(getattr(block, n), pair) for n in tables})


def _exchanged(points, pair):
    names = points["point_id"].to_numpy(dtype=object, copy=True)
    one, other = (names == name for name in pair)
    names[one], names[other] = pair[1], pair[0]
    return points.assign(point_id=names)


def _control_is_fitted(block):
    """Whether models are fitted onto control, and drawn along by a wrong one."""
    return block.high_flight is not None or _are_fitted_onto_control(block)


def _are_fitted_onto_control(block):
    """Whether what models of one flight are fitted onto is control."""
    return block.high_flight is None and approximations_are_control(block)


def _missed_in_two_steps(examined):
    """What given points are missed by, TOTAL (RMS) [m]; NaN where nothing tells."""
    two_step = examined.all_in_two_steps
    return _rms(two_step) if two_step.is_possible else np.nan


def _missed(examined):
    """The same by what is examined: two steps may lack the models of a pair."""
    return _rms(examined)


def _missed_in_plan(examined):
    """The same by all models in plan, with errors as stated.

    Where some have failed, or new points are known far worse than given ones: then
    estimated errors, or bends of models, may have taken up what given points are missed
    by.
    """
    block, figures = examined.block, examined.figures
    claimed = np.fmax(figures.mean_within, figures.mean_paper)
    is_coarse = claimed > LEAST_IMPROVEMENT * _stated(block)
    is_doubtful = is_coarse or not examined.failures.empty
    if not (is_doubtful and _control_is_fitted(block)):
        return np.nan
    found = examined.adjusted_in_plan
    return np.nan if found is None else total_rms(found[0].control_residuals)


MEASURES = (_missed_in_two_steps, _missed, _missed_in_plan)


def _is_too_far(examined, measure, missed):
    """Whether given points are missed by more than is stated or claimed.

    What is claimed does not tell alone: a model on three points meets a wrong one with
    errors as large.
    """
    stated = _stated(examined.block)
    if not missed > 0.0:
        return False
    if missed > LEAST_IMPROVEMENT * stated:
        return True
    if np.isnan(stated) and _are_fitted_onto_control(examined.block):
        return True
    if measure is not _missed_in_two_steps:
        return False
    two_step = examined.all_in_two_steps
    left_out = two_step.control_left_out["is_suspect"].astype(bool)
    return two_step.known_control.are_beyond or bool(left_out.any())


def _stated(block):
    """Standard error of given points, TOTAL (RMS) [m]; NaN where none is given."""
    control = block.control_points
    if "standard_error_m" not in control:
        return np.nan
    errors = control["standard_error_m"].to_numpy(dtype=float)
    errors = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(errors**2))) if len(errors) else np.nan


def _rms(judged):
    """What given points are missed by, set aside or not, TOTAL (RMS) [m]."""
    points = judged.points
    return total_rms(values_of(points[points["role"] != "new"], DIFFERENCES))


def _pairs(examined):
    """Pairs of names that may be exchanged, a few, the best first."""
    if _control_is_fitted(examined.block):
        # two opposite corners exchanged are a mirror, which shows by itself
        is_mirrored = examined.frame.is_mirrored
        level = LEVEL_OF_MIRROR if is_mirrored else FINDING_SIGNIFICANCE
        return _pairs_that_adjust(examined.adjusted_in_plan, level)
    two_step = examined.all_in_two_steps
    return _pairs_that_match(two_step) if two_step.is_possible else []


def _pairs_that_match(two_step):
    """Pairs each of which lies where the other is given."""
    points = two_step.points
    points = points[points["role"] != "new"]
    names, there = points["point_id"].to_numpy(dtype=object), values_of(points, PLAN)
    given = two_step.block.control_points.drop_duplicates("point_id")
    known = given.set_index("point_id")[PLAN].reindex(names).to_numpy(dtype=float)
    is_known = np.isfinite(known).all(axis=1) & np.isfinite(there).all(axis=1)
    names, known, there = names[is_known], known[is_known], there[is_known]
    squares = np.sum((there[:, None] - known) ** 2, axis=2)
    away = np.sqrt((squares + squares.T) / 2.0)  # of both, RMS
    apart = np.hypot(*np.moveaxis(known[:, None] - known, 2, 0))
    return _best(names, away, LEAST_IMPROVEMENT * away < apart)


def _pairs_that_adjust(in_plan, significance):
    """Pairs that leave least of what an adjustment misses given points by."""
    if in_plan is None:
        return []
    solution, names = in_plan
    pairs = pairs_of_given_points(solution)
    is_better = LEAST_IMPROVEMENT**2 * pairs.left < 1.0
    is_better &= pairs.chance() <= significance
    return _best(names[pairs.places], pairs.left, is_better)


def _in_plan(block, flights):
    """All models adjusted at once in plan, onto check points as well, and names.

    None where given points do not hold all models at once.
    """
    kinds = {name: flight.transformation for name, flight in block.flights.items()}
    kinds = {name: ADJUSTED_AS.get(kind, kind) for name, kind in kinds.items()}
    given = block.control_points.assign(role="control")
    try:
        tables = block_tables(replace(block, control_points=given), flights, kinds)
        part, _ = determined_part(tables)
    except EinschaltError:
        return None
    observations = part.observations
    if observations.is_in_space:
        observations = observations.in_plan(is_affine=True)
    return adjust(observations), tables.point_id[part.points]


def _best(names, score, is_pair):
    """Pairs of names with the least scores."""
    one, other = np.nonzero(np.triu(is_pair, 1))
    best = np.argsort(score[one, other], kind="stable")[:MOST_PAIRS]
    return [(str(names[one[k]]), str(names[other[k]])) for k in best]


def _tried(examined, measure, missed, pair):
    """The pair, if the block with both put right misses given points by far less."""
    try:
        again = examined.computed_again(with_names_exchanged(examined.block, pair))
    except EinschaltError:  # nothing is gained
        return None
    # models that failed for the pair need not fail then
    after = np.nan_to_num(measure(again), nan=_rms(again))
    if not LEAST_IMPROVEMENT * after < missed:
        return None
    if examined.frame.is_mirrored and again.frame.is_mirrored:
        return None
    given = examined.block.control_points.drop_duplicates("point_id")
    given = given.set_index("point_id").loc[list(pair), PLAN].to_numpy(dtype=float)
    moved = new_points_apart(examined, again.points)
    apart = float(np.hypot(*(given[1] - given[0])))
    return ExchangedControl(pair, apart, missed, after, again, moved)
