"""Control points that are given under each other's name.

Each lies where another one is given: two of them, several that went round, or a part of
the list whose names have slipped by some rows. One that was fitted draws its models
along; so all models are adjusted at once in plan, which is linear whatever the models
are like, and names are exchanged there. They are the cause where the block, computed
once more with them put right, misses its control by a fifth of what it did.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy.spatial import KDTree

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.evidence.control.displacements import (
    Displacement,
    moved_beyond_chance,
    new_points_apart,
)
from einschalt.pipeline.assessment.known_points import DIFFERENCES, total_rms
from einschalt.pipeline.densification.simultaneous import ADJUSTED_AS, block_tables
from einschalt.stages.error_propagation.given_points import (
    PLAN,
    approximations_are_control,
)
from einschalt.stages.simultaneous.determined_part import determined_part
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE
from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.exchanged_points import (
    NOWHERE,
    Slips,
    names_of_given_points,
    put_right,
    slipped_names,
)

# what control is missed by must become so many times smaller
LEAST_IMPROVEMENT = 5.0
# ways to put names right, the likeliest first, with which the block is computed again
MOST_TRIED = 3
# of chance, where all models are mirrored and would not be
LEVEL_OF_MIRROR = 0.05
# measured points, beyond which a block is not computed again
MOST_MEASURED = 100_000


@dataclass(frozen=True)
class MixedNames:
    """Given points whose coordinates stand under other names."""

    # the name under which the coordinates of each are given, in the order of the list
    given_as: dict[str, str]
    # where the list has lost a name: the point whose coordinates are not given, and the
    # name under which those of a point stand that is not in the list
    lost: str = ""
    nameless: str = ""
    rows: int = 0  # by which a part of the list has slipped; 0 where none has

    @property
    def points(self):
        """Names of all that lie elsewhere, in the order of the list; ``lost`` last."""
        return (*self.given_as, self.lost) if self.lost else tuple(self.given_as)


@dataclass(frozen=True, eq=False)
class ExchangedControl:
    """Control points under each other's name."""

    names: MixedNames
    apart: float  # the farthest from where it is given [m]
    rms: float  # of the differences at all given points, TOTAL [m]
    rms_exchanged: float  # the same of the block with the names put right
    corrected: object  # examination of that block
    moved: Displacement  # the new points by putting it right, beyond chance


def find_exchanged_control(examined) -> ExchangedControl | None:
    """Look for names that explain what the block misses its given points by.

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
    """The first names that explain what given points are missed by, or None."""
    for names in _likely(examined):
        found = _tried(examined, measure, missed, names)
        if found is not None:
            return found
    return None


def adjusted_in_plan(examined):
    """All models adjusted at once in plan, and the names of its points, or None."""
    return _in_plan(examined.block, _all_flights(examined))


def _all_flights(examined):
    """The flights with models that were given up, which may be so for such names."""
    return examined.all_in_two_steps.solution.flights


def _is_small(flights):
    measured = sum(len(flight.model_points) for flight in flights.values())
    return measured <= MOST_MEASURED


def with_control_exchanged(error, block, flights, solve):
    """The same error, naming control points as its cause where there are any.

    Under each other's name, which ``solve(block)`` does not fail with put right.
    """
    is_possible = block.control_points is not None and _control_is_fitted(block)
    if not (is_possible and _is_small(flights)):
        return error
    in_plan = _in_plan(block, flights)
    for names in _that_adjust(block, in_plan, FINDING_SIGNIFICANCE):
        try:
            solve(with_names_put_right(block, names))
        except EinschaltError:
            continue
        return error.with_facts(remedy=_remedy(names))
    return error


def _remedy(names):
    one, other = next(iter(names.given_as.items()))
    if len(names.points) == 2:
        return (
            f"Exchange the names of control points {one} and {other}: each lies where "
            "the other one is given"
        )
    n_more = len(names.points) - 1
    return (
        f"Put the names of control right: {one} lies where {other} is given, and "
        f"{n_more} more lie where others of them are"
    )


def with_names_put_right(block, names):
    """A block whose given points have the names of where they lie.

    Approximate points as well, where models are fitted onto control.

    Parameters
    ----------
    block : Block
    names : MixedNames
        What has no name then, is left out.
    """
    tables = ["control_points"]
    if _are_fitted_onto_control(block):
        tables.append("approximate_points")
    return replace(block, **{n: _renamed(getattr(block, n), names) for n in tables})


def _renamed(points, names):
    right = {given: name for name, given in names.given_as.items()}
    points = points[points["point_id"] != names.nameless].reset_index(drop=True)
    named = [right.get(name, name) for name in points["point_id"]]
    return points.assign(point_id=np.array(named, dtype=object))


def _control_is_fitted(block):
    """Whether models are fitted onto control, and drawn along by a wrong one."""
    return block.high_flight is not None or _are_fitted_onto_control(block)


def _are_fitted_onto_control(block):
    """Whether what models of one flight are fitted onto is control."""
    return block.high_flight is None and approximations_are_control(block)


def _missed(judged):
    """What given points are missed by, set aside or not, TOTAL (RMS) [m]."""
    points = judged.points
    return total_rms(values_of(points[points["role"] != "new"], DIFFERENCES))


def _missed_in_two_steps(examined):
    """What given points are missed by, TOTAL (RMS) [m]; NaN where nothing tells."""
    two_step = examined.all_in_two_steps
    return _missed(two_step) if two_step.is_possible else np.nan


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
    found = examined.adjusted_in_plan if is_doubtful else None
    return np.nan if found is None else total_rms(found[0].control_residuals)


# two steps may lack the models of a pair
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


def _likely(examined):
    """Names under which points may be given, in some ways, the likeliest first."""
    two_step, found = examined.all_in_two_steps, []
    if two_step.is_possible and not _control_is_fitted(examined.block):
        found = _that_match(two_step)
    if found:
        return found
    # two opposite corners exchanged are a mirror, which shows by itself
    level = LEVEL_OF_MIRROR if examined.frame.is_mirrored else FINDING_SIGNIFICANCE
    return _that_adjust(examined.block, examined.adjusted_in_plan, level)


def _that_match(two_step):
    """Points each of which lies where another of them is given: all, and each round."""
    points = two_step.points
    points = points[points["role"] != "new"]
    names, there = points["point_id"].to_numpy(dtype=object), values_of(points, PLAN)
    given = two_step.block.control_points.drop_duplicates("point_id")
    known = given.set_index("point_id")[PLAN].reindex(names).to_numpy(dtype=float)
    is_known = np.isfinite(known).all(axis=1) & np.isfinite(there).all(axis=1)
    names, known, there = names[is_known], known[is_known], there[is_known]
    if not len(names):
        return []
    away, nearest = KDTree(known).query(there)
    is_other = LEAST_IMPROVEMENT * away < np.hypot(*(there - known).T)
    rounds = _rounds({k: int(nearest[k]) for k in np.flatnonzero(is_other)})
    ways = [[k for each in rounds for k in each], *rounds] if rounds else []
    given_as = [{str(names[k]): str(names[nearest[k]]) for k in way} for way in ways]
    return list(map(MixedNames, given_as[:MOST_TRIED]))


def _rounds(step):
    """The closed rounds of places, each of which lies where the next one is given."""
    rounds, seen = [], set()
    for first in step:
        way, place = [], first
        while place in step and place not in seen:
            seen.add(place)
            way.append(place)
            place = step[place]
        if way and place in way:
            rounds.append(way[way.index(place) :])
    return sorted(rounds, key=len, reverse=True)


def _that_adjust(block, in_plan, significance):
    """Names that leave least of what an adjustment misses given points by."""
    if in_plan is None:
        return []
    solution, point_id = in_plan
    names = names_of_given_points(solution)
    name_of = point_id[names.places]
    lists, likely, least = _lists(block, name_of), [], np.inf
    slips = [slipped_names(each, len(name_of)) for each in lists]
    slips = Slips(*map(np.concatenate, zip(*slips, strict=True)))
    for found in put_right(names, slips):
        is_better = LEAST_IMPROVEMENT**2 * found.left < 1.0
        is_better &= found.log_chance <= np.log(significance)
        places = np.flatnonzero(is_better)[:MOST_TRIED]
        # more mistakes leave a little less of any errors
        if len(places) and LEAST_IMPROVEMENT**2 * found.left[places[0]] < least:
            least = found.left[places[0]]
            ways = [_named(name_of, lists[0], found, k) for k in places]
            likely = [*ways, *likely]
    return likely[:MOST_TRIED]


def _named(name_of, listed, found, place):
    """The order at a place among those that were found, by names."""
    order, free = found.orders[place], found.free[place]
    moved = [k for k in listed if order[k] != k and k != free]
    return MixedNames(
        given_as={str(name_of[k]): str(name_of[order[k]]) for k in moved},
        lost="" if free == NOWHERE else str(name_of[free]),
        nameless="" if free == NOWHERE else str(name_of[order[free]]),
        rows=int(found.rows[place]),
    )


def _lists(block, name_of):
    """Places of given points in the order of their list: all, and control alone."""
    given = block.control_points.drop_duplicates("point_id")
    place = pd.Series(np.arange(len(name_of)), index=name_of)
    place = place.reindex(given["point_id"]).to_numpy()
    is_control = (given["role"] == "control").to_numpy()
    lists = (place, place[is_control]) if not is_control.all() else (place,)
    return [each[np.isfinite(each)].astype(int) for each in lists]


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


def _tried(examined, measure, missed, names):
    """Names, if the block with them put right misses given points by far less."""
    try:
        again = examined.computed_again(with_names_put_right(examined.block, names))
    except EinschaltError:  # nothing is gained
        return None
    # models that failed for the names need not fail then
    after = np.nan_to_num(measure(again), nan=_missed(again))
    if not LEAST_IMPROVEMENT * after < missed:
        return None
    if examined.frame.is_mirrored and again.frame.is_mirrored:
        return None
    given = examined.block.control_points.drop_duplicates("point_id")
    given = given.set_index("point_id")[PLAN]
    here, there = (
        given.loc[list(points)].to_numpy(dtype=float)
        for points in (names.given_as, names.given_as.values())
    )
    apart = float(np.hypot(*(there - here).T).max())
    moved = _moved(examined, again, list(names.given_as))
    return ExchangedControl(names, apart, missed, after, again, moved)


def _moved(examined, again, names):
    """How far the new points lie from where they do with names put right.

    Of names that take no part in them no more than chance leaves.
    """
    if is_among(names, examined.held_control["point_id"]).any():
        return new_points_apart(examined, again.points)
    return moved_beyond_chance(examined, again)
