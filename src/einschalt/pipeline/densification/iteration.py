"""The low flight again and again onto the coordinates that it gave, control held.

Approximate coordinates of the high flight share errors that one pass leaves in the
result. Onto its own coordinates the low flight tightens them, as long as control holds
the block: without it the passes drift. Every pass is linear in the errors of all
observations, so that the propagation goes through all of them.

See docs/theory/iteration.md.
"""

from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
import pandas as pd
from scipy import sparse

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode
from einschalt.pipeline.densification.low_flight_fit import LowFlightFit
from einschalt.stages.error_propagation.covariances import (
    SharedCovariances,
    covariances_of_pairs,
)
from einschalt.stages.error_propagation.error_model import (
    CONTROL,
    LOW,
    PLAN,
    ErrorModel,
    assumed_model,
    places_fitted_onto,
)
from einschalt.stages.error_propagation.given_points import (
    CONTROL_POINTS,
    errors_of_control,
    group_members,
)
from einschalt.stages.error_propagation.operators import (
    GroundSources,
    flight_operator,
    mean_operator,
)
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS
from einschalt.theory.adjustment.point_operator import (
    by_coordinate,
    selection,
    stacked,
    zero,
)

PLAN_COLUMNS = [*PLAN]
MOVES = ["iteration", "largest_move", "point_id", "move_rms"]
# whose residuals are tested with their covariances: in each further pass more of the
# block stands behind a point, and they take three times as long
MOST_TESTED = 3
# nothing that is signed for changes by less
LEAST_MOVE = 0.001  # metres


@dataclass(frozen=True, eq=False)
class Iteration:
    """Passes of the low flight, each onto the coordinates of the one before."""

    passes: tuple[LowFlightFit, ...]  # the first onto approximate coordinates
    # iteration (2 is the second pass), largest_move, point_id (where), move_rms (TOTAL,
    # over all points) [m]
    moves: pd.DataFrame
    n_held: int  # control points of the low flight, which kept their given coordinates
    # usable models of the last pass, and those that hold such a point
    n_models: int
    n_models_held: int

    @property
    def is_converged(self) -> bool:
        """Whether the last pass moved nothing that counts."""
        return bool(self.moves["largest_move"].iloc[-1] < LEAST_MOVE)


def require_iterable(block, settings):
    """Refuse iterations in one adjustment of all models, and of models in space."""
    if settings.iterations == 1:
        return
    said = f"iterations = {settings.iterations}"
    if settings.method == "simultaneous":
        raise SettingsError(
            f'{said}, but method = "simultaneous" adjusts all models at once',
            expected="iterations = 1 with it",
            remedy='Take iterations out, or set method = "two_step"',
        )
    kind = block.low_flight.transformation
    if len(TRANSFORMATION_KINDS[kind].target) > len(PLAN):
        raise SettingsError(
            f"{said}, but the low flight is transformed in space ({kind})",
            expected="a plane transformation, or iterations = 1",
            remedy='Set transformation = "affine" or "helmert" in [low_flight]',
        )
    control = block.control_points
    is_only_held = block.high_flight is None and control is not None
    if (
        is_only_held
        and group_members(control) is not None
        and CONTROL_POINTS not in block.group_errors_m
    ):
        raise SettingsError(
            f"{said} hold control, whose groups have shifts of unknown size",
            expected="group_error_m in [control_points]",
            remedy="Give it, or take the column group out",
        )


def iterate(block, first, pass_onto, most_passes):
    """Repeat the low flight on its own coordinates, control points held.

    ``pass_onto`` makes a LowFlightFit of a table of ground points, and of the passes
    that have given it. It ends early where no point moves by 1 mm. None where one pass
    is all that is asked for.
    """
    if most_passes == 1:
        return None
    passes, moves = [first], []
    while len(passes) < most_passes:
        ground = _with_held_control(block, passes[-1].means.points)
        passes.append(pass_onto(ground, tuple(passes)))
        moves.append((len(passes), *_moves(passes[-2], passes[-1])))
        if moves[-1][1] < LEAST_MOVE:
            break
    held = _held(block, passes[-2].means.points["point_id"])
    models = _models_with(passes[-1].low, held.names)
    table = pd.DataFrame(moves, columns=MOVES)
    return Iteration(tuple(passes), table, len(held.rows), *models)


@dataclass(frozen=True, eq=False)
class _Held:
    """Control points among the points of the low flight: names, and their places."""

    names: np.ndarray
    rows: np.ndarray
    control_rows: np.ndarray


def _held(block, point_ids):
    control = block.control_points
    if control is None:
        nothing = np.array([], dtype=np.int64)
        return _Held(nothing.astype(object), nothing, nothing)
    controlled = np.flatnonzero((control["role"] != "check").to_numpy())
    names = encode(control["point_id"].iloc[controlled])
    place = encode(point_ids).locate(names)[names.codes]
    is_there = place >= 0
    used = control["point_id"].to_numpy(dtype=object)[controlled[is_there]]
    return _Held(used, place[is_there], controlled[is_there])


def _with_held_control(block, points):
    """Coordinates for the next pass: those of the last, given ones at control."""
    ground = points[["point_id", *PLAN_COLUMNS]].copy()
    held = _held(block, ground["point_id"])
    if len(held.rows):
        given = values_of(block.control_points, PLAN_COLUMNS)
        coordinates = ground[PLAN_COLUMNS].to_numpy(copy=True)
        coordinates[held.rows] = given[held.control_rows]
        ground[PLAN_COLUMNS] = coordinates
    return ground


def _moves(before, after):
    """Largest move from pass to pass, where it is, and the root mean square."""
    old, new = (
        p.means.points.set_index("point_id")[PLAN_COLUMNS] for p in (before, after)
    )
    shift = (new - old).dropna()
    length = np.hypot(shift["easting"], shift["northing"])
    return float(length.max()), length.idxmax(), float(np.sqrt(np.mean(length**2)))


def _models_with(low, names):
    """Count the usable models, and those that were fitted onto any of the names."""
    observed = low.observed
    is_named = observed.rows["point_id"].isin(names).to_numpy()
    model = np.repeat(np.arange(len(low.models)), np.diff(observed.start))
    n_named = np.bincount(model, is_named, len(low.models))
    is_usable = low.models["is_usable"].to_numpy()
    return int(is_usable.sum()), int((is_usable & (n_named > 0)).sum())


@dataclass(frozen=True, eq=False)
class IteratedErrorModel(ErrorModel):
    """How errors enter the last of several passes of the low flight.

    ``ground`` are the coordinates onto which it was fitted, behind which the errors of
    the low flight stand as well.
    """

    # from the sources to these coordinates, all errors of the low flight and all of
    # control, one below the other
    state: dict

    @property
    def chains_to_values(self):
        """From the sources to the values of the low flight, dict of PointOperator."""
        return self._through(self.low.ground, self.low.measured)

    def chains_to_fits(self, flight, observed):
        """From the sources to what a flight was fitted with, ground less measurement.

        See ``ErrorModel.chains_to_fits``.
        """
        if flight != LOW:
            return super().chains_to_fits(flight, observed)
        onto, fitted = self.low.selections(self.places, observed)
        return self._through(onto, -fitted)

    def _through(self, of_ground, of_measured):
        width = self.state[LOW].n_points
        n_others = width - of_ground.n_sources - of_measured.n_sources
        others = zero(of_ground.n_points, n_others, self.axes)
        whole = stacked([[of_ground, of_measured, others]])
        return {source: whole @ chain for source, chain in self.state.items()}


class PassErrors:
    """How errors enter what each further pass of the low flight is fitted with.

    Exact for the passes as they were made: what the low flight is fitted onto depends
    on the errors of all sources, its own among them. ``model`` is that of the first
    pass; ``low_points`` are the model points of the low flight, as they were
    transformed.
    """

    def __init__(self, block, model, low_points):
        self.block, self.model, self.low_points = block, model, low_points
        self._states = []  # after each pass

    @cached_property
    def _steps(self):
        """Made where there are further passes."""
        return _Steps(self.block, self.model.axes, self.low_points)

    def iterated_model(self, passes) -> "IteratedErrorModel":
        """Model of errors of the last pass."""
        model, steps, state = self.model, self._steps, self._state_after(passes[:-1])
        before, last = passes[-2:]
        operator = steps.operator(before.means, last.low)
        n_ground = operator.ground.n_sources
        picked = selection(np.arange(n_ground), state[LOW].n_points, model.axes)
        return IteratedErrorModel(
            final=steps.mean(last.means),
            low=operator,
            ground={source: picked @ chain for source, chain in state.items()},
            high=model.high,
            places=places_fitted_onto(self.block, before.means.points["point_id"]),
            standard_errors=steps.sizes(model),
            is_assumed=model.is_assumed,
            own=model.own,
            state=state,
        )

    def covariances_after(self, passes):
        """Covariances of what the next pass is fitted with, ground less measured.

        A function of pairs of rows of the low flight's points, (n_pairs, 2), that gives
        (n_pairs, 2, 2) [m²]; None of passes after the third.
        """
        if len(passes) >= MOST_TESTED:
            return None
        known = SharedCovariances()
        chains = cache(lambda: self._chains_after(passes))
        sizes = self._steps.sizes(self.model)
        return lambda pairs: covariances_of_pairs(chains(), sizes, pairs, known)

    def _chains_after(self, passes):
        """From the sources to ground less measured, of all points of the low flight."""
        state, axes = self._state_after(passes), self.model.axes
        ids = passes[-1].means.points["point_id"]
        points = encode(self.low_points["point_id"])
        place = encode(ids).locate(points)[points.codes]
        # a point without a place is not fitted: nobody asks for it
        onto = selection(np.where(place >= 0, place, 0), len(ids), axes)
        others = zero(len(place), self._steps.n_control, axes)
        apart = stacked([[onto, -self._steps.own, others]])
        return {source: apart @ chain for source, chain in state.items()}

    def _state_after(self, passes):
        steps = self._steps
        if not self._states:
            self._states.append(steps.after_first(self.model, passes[0].means))
        for k in range(len(self._states), len(passes)):
            moved = steps.through(passes[k - 1].means, passes[k])
            before = self._states[-1].items()
            self._states.append({source: moved @ chain for source, chain in before})
        return self._states[len(passes) - 1]


class _Steps:
    """Operators from pass to pass.

    The state after a pass are the coordinates for the next one, control held, then all
    errors of the low flight, then those of control.
    """

    def __init__(self, block, axes, low_points):
        self.block, self.axes, self.low_points = block, axes, low_points
        control = block.control_points
        self.n_low = len(low_points)
        self.n_control = 0 if control is None else len(control)
        self.own, self.control = (
            selection(np.arange(n), n, axes) for n in (self.n_low, self.n_control)
        )

    def sizes(self, model):
        """Sizes of the errors of all sources; of control also where it is only held."""
        if CONTROL in model.standard_errors or not self._has_control_errors:
            return model.standard_errors
        return {**model.standard_errors, **self.given.sizes}

    @cached_property
    def given(self):
        """Errors of the given coordinates of control."""
        return errors_of_control(self.block, self.axes)

    @property
    def _has_control_errors(self):
        control = self.block.control_points
        return control is not None and "standard_error_m" in control

    def after_first(self, model, means):
        """State after the first pass from all sources."""
        free, direct = self._held(means)
        n_points, n_low, n_control = free.n_points, self.n_low, self.n_control
        into = stacked([[free], [zero(n_low + n_control, n_points, self.axes)]])
        state = {source: into @ chain for source, chain in model.chains.items()}
        above, below = (zero(n, n_low, self.axes) for n in (n_points, n_control))
        own = stacked([[above], [self.own], [below]])
        for source, chain in model.own.items():
            state[source] = state[source] + own @ chain
        if self._has_control_errors:
            between = zero(n_low, n_control, self.axes)
            held = stacked([[direct], [between], [self.control]])
            for source, chain in self.given.picked(held).chains.items():
                known = state.get(source)
                state[source] = known + chain if known else chain
        return state

    def through(self, before, now):
        """State after a pass from the state before it."""
        free, direct = self._held(now.means)
        operator = self.operator(before, now.low)
        mean = (free @ self.mean(now.means)).formed()
        onto, own = ((mean @ o).formed() for o in (operator.ground, operator.measured))
        n_others = self.n_low + self.n_control
        others = selection(np.arange(n_others), n_others, self.axes)
        below = zero(n_others, onto.n_sources, self.axes)
        return stacked([[onto, own, direct], [below, others]])

    def operator(self, before, low):
        """Of a pass onto the coordinates of the one before."""
        names = before.points["point_id"]
        sources = GroundSources(places_fitted_onto(self.block, names), len(names))
        return flight_operator(low, self.low_points, sources, self.axes)

    def mean(self, means):
        """Operator of stage 5."""
        return mean_operator(means, np.arange(self.n_low), self.n_low, self.axes)

    def _held(self, means):
        """Coordinates for the next pass, from those of this one and from control."""
        names = means.points["point_id"]
        held = _held(self.block, names)
        is_free = np.ones(len(names))
        is_free[held.rows] = 0.0
        picked = sparse.csr_array(
            (np.ones(len(held.rows)), (held.rows, held.control_rows)),
            shape=(len(names), self.n_control),
        )
        return (
            by_coordinate(sparse.diags_array(is_free), self.axes),
            by_coordinate(picked, self.axes),
        )


def assumed_after_iteration(result):
    """Model of errors of a block whose errors cannot be propagated, or None.

    See :func:`einschalt.stages.error_propagation.error_model.assumed_model`.
    """
    iteration = result.iteration
    if iteration is None:
        return assumed_model(result)
    first = iteration.passes[0]
    model = assumed_model(replace(result, low=first.low, means=first.means))
    if model is None:
        return None
    errors = PassErrors(result.block, model, result.model_points[LOW])
    return errors.iterated_model(iteration.passes)
