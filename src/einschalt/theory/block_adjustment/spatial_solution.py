"""All spatial models of a block in one adjustment, each with seven parameters.

Gauss-Newton: a small step of a model about its centroid moves a point by

    dT = dt + dλ a + dω × a,    a = s R (x − c),

with shift, relative scale and turn in units of its extent, the root mean square of a.
Model coordinates are measured, with errors in their own unit and along their own axes,
and so a is their adjusted one in the end: with measured ones a block would be the
smaller, and lean the more, the more is measured beside little control, since residuals
on the ground shrink with its scale.
Where residuals are so large that such steps grow, or hardly become smaller, second
derivatives are counted too. Points are eliminated and the models are factored front by
front as in the plane, with three rows a point and seven unknowns a model; the last
linearisation gives every variance. Bends that models of a flight share
(:mod:`einschalt.theory.block_adjustment.shared_bend`) border that; the models are
corrected by them, and the block is adjusted again until they settle.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from einschalt.foundations.rotations import cross_matrix, rotation_by_vector
from einschalt.theory.block_adjustment.adjusted_block import (
    AdjustedBlock,
    BlockInOrder,
    held_coordinates,
    in_old_order,
    largest_error,
)
from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.common_border import (
    Bordered,
    UndeterminedTermsError,
    inverse_of_common,
    normals_of_common,
)
from einschalt.theory.block_adjustment.model_graph import incidence_of
from einschalt.theory.block_adjustment.second_order import (
    among_unknowns,
    second_derivatives,
)
from einschalt.theory.block_adjustment.solver import (
    Projection,
    Solver,
    factor_block,
    order_block,
)
from einschalt.theory.block_adjustment.spatial_start import Placement, place_models
from einschalt.theory.transformation.helmert_3d import angles_of, parameters_from_step

MOST_PASSES, MOST_SHIFTS = 100, 20
# a step that is as small as this changes nothing but its own square [m]
SETTLED, ROUGHLY = 1e-7, 1e-3
# beyond it gross errors take part
LARGEST_S_0 = 2.0
# share of that which common terms may still move: their step is not applied
OF_COMMON = 0.01
# steps that grow beyond it [m] are no rounding
FAR = 0.1
# a step that is not so much smaller than the last one comes from large residuals
SLOWLY = 0.5
# share of its standard error that a model may still move by where residuals are large
SETTLED_OF_ERROR = 1e-3
# relative growth of the sum of squares that is no rounding
GROWS = 1e-9
# which second derivatives a pass counts: none, those that hold models, or all
LINEAR, POSITIVE, FULL = 0, 1, 2
N_UNKNOWNS = 7


class NoConvergenceError(ArithmeticError):
    """The adjustment of the spatial models does not converge.

    ``model`` of so many models still moves by the largest step.
    """

    def __init__(self, step, model, n_models):
        super().__init__(f"the last step was {step:g} m")
        self.model, self.n_models = model, n_models


@dataclass(frozen=True, eq=False)
class SpatialSolution(AdjustedBlock):
    """Adjusted block of spatial models."""

    placement: Placement  # of the adjusted models
    # (n_models,): root mean square distance of the points of each model from its
    # centroid, on the ground [m]: unit of its scale and turn
    extent: np.ndarray
    # (n_models, n_bent): coefficients of each model's own deformation, over their
    # standard errors
    bent: np.ndarray
    # (n_terms,): coefficients of the bends that models share, with the sign of what
    # corrects them
    common: np.ndarray

    def readjusted(self, observations, *, is_rough=False, settled=SETTLED):
        """Adjust the same models and points with other errors or given coordinates.

        A rough solution is for sums over the block. ``settled`` is the largest step
        that is left [m].
        """
        settled = ROUGHLY if is_rough else settled
        ordering = self.ordering
        if ordering.has_outgrown(_n_solved(observations)):
            ordering = _ordered(observations, self.placement)
        task = _Task(observations, ordering)
        return task.solve(self.placement, settled, self.common)

    @property
    def linear(self):
        """Linear part of each model, from model to ground, (n_models, 3, 3)."""
        return self.placement.matrix

    def adjusted_anew(self, observations):
        """Adjust other observations of the same models."""
        return adjust_spatially(observations, self.placement)

    def answer_to(self, errors, control_errors, *, is_rough=False):
        """Errors of points, and residuals; as in plan, of small errors."""
        answer = self._projected(-errors, control_errors, is_rough=is_rough)
        if self.observations.shared_bend is None:
            return answer
        given = self.observations
        on_ground = self.linear[given.model] @ given.shared_bend
        return self._with_common(*answer, on_ground)

    def _cofactors(self, quantity):
        plain = super()._cofactors(quantity)
        return self.bordered.with_spread(plain, getattr(self.bordered, quantity))

    @property
    def common_cofactors(self):
        """Of the coefficients of bends that models share, (n_terms, n_terms)."""
        return self.bordered.cofactors

    @property
    def relative_errors(self):
        """Standard error of scale and turn of each model, relative.

        For σ_0 = 1; NaN where rounding has left no positive variance.
        """
        return largest_error(np.diagonal(self._step_cofactors, axis1=1, axis2=2)[:, 3:])

    @cached_property
    def unknown_cofactors(self):
        """Of everything unknown of each model, (n_models, n_unknowns, n_unknowns)."""
        own, bordered = self.solver.model_cofactors, self.bordered
        own = bordered.with_spread(own, bordered.unknowns)
        return in_old_order(own, self.ordering.order)

    @property
    def log_determinant(self):
        """Of the normal equations without the points."""
        common = np.linalg.slogdet(self.common_cofactors)[1]
        return self.solver.factor.log_determinant - common

    @cached_property
    def _step_cofactors(self):
        """Of shift, relative scale and turn about the centroid."""
        own = self.unknown_cofactors[:, :N_UNKNOWNS, :N_UNKNOWNS]
        unit = np.ones((len(own), N_UNKNOWNS))
        unit[:, 3:] = 1.0 / self.extent[:, None]
        return own * unit[:, :, None] * unit[:, None, :]

    @cached_property
    def parameters(self):
        """Parameters te, tn, th, scale, ω, φ, κ, shape (n_models, 7)."""
        place = self.placement
        shift = place.centre + place.origin
        shift -= np.einsum("nij,nj->ni", place.matrix, place.centroid)
        return np.column_stack([shift, place.scale, angles_of(place.rotation)])

    @cached_property
    def parameter_cofactors(self):
        """Cofactors of the parameters, shape (n_models, 7, 7)."""
        place = self.placement
        jacobian = parameters_from_step(place.scale, place.rotation, place.centroid)
        jacobian[:, :, 3] *= place.scale[:, None]  # of the relative scale
        return jacobian @ self._step_cofactors @ np.swapaxes(jacobian, 1, 2)


def adjust_spatially(observations, start=None, *, is_rough=False) -> SpatialSolution:
    """Adjust all spatial models of a determined block with its control.

    Without a ``start`` the models must stand upright but for some degrees. A rough
    solution is for sums over the block. Raises NoConvergenceError.
    """
    if start is None:
        start = place_models(observations)
    task = _Task(observations, _ordered(observations, start))
    return task.solve(start, ROUGHLY if is_rough else SETTLED)


def _ordered(observations, start):
    """Order of elimination of the models, by where their points lie."""
    plan = observations.in_plan(is_affine=True)
    incidence = incidence_of(plan.model, plan.point, plan.n_models, plan.n_points)
    chained = plan.xy - start.centroid[plan.model][:, :2]
    return order_block(incidence, chained, _n_solved(observations))


def _n_solved(observations):
    """Unknowns of a model that are solved together."""
    bent = observations.bent
    return N_UNKNOWNS + (0 if bent is None else bent.shape[2])


def adjust_models(observations, terms=(), *, is_rough=False):
    """Adjust in plan, with what models share, or in space, as they were observed.

    A rough solution is for sums over the block.
    """
    if observations.is_in_space:
        return adjust_spatially(observations, is_rough=is_rough)
    return adjust(observations, terms, is_rough=is_rough)


class _Task(BlockInOrder):
    """A spatial block that is adjusted, in the order of elimination."""

    def __init__(self, observations, ordering):
        super().__init__(observations, ordering)
        self._model = self.incidence.model
        self._xyz = observations.xyz[self.rows]
        self._held = held_coordinates(observations)[self.points]
        self._bent = np.zeros((len(self.rows), 3, 0))
        if observations.bent is not None:
            self._bent = observations.bent[self.rows]
        self._shared = np.zeros((len(self.rows), 3, 0))
        if observations.shared_bend is not None:
            self._shared = observations.shared_bend[self.rows]

    def solve(self, start, settled=SETTLED, common=()) -> SpatialSolution:
        """Iterate from a start until no step is larger than ``settled`` [m].

        ``common`` are coefficients that the models share, to begin with. An
        UndeterminedTermsError where the block does not determine them, or they do not
        settle: no model is to blame for that.
        """
        place = start.arranged(lambda values: values[self.ordering.order])
        control = self.control_from(place.origin)
        bent = np.zeros((len(place.scale), self._bent.shape[2]))
        n_terms = self._shared.shape[2]
        common = common if len(common) == n_terms else np.zeros(n_terms)
        for _ in range(MOST_SHIFTS):
            self._xyz = self.given.xyz[self.rows] + self._shared @ common
            last = self._settled(place, bent, control, settled)
            last = self._without_pull(last, control, settled)
            bordered, shift, moved = self._border(last)
            # where second derivatives count, models settle within a share of errors
            limit = OF_COMMON * settled if last.order == LINEAR else ROUGHLY
            if moved < limit:
                return self._solution(last, control, common, bordered)
            common = common + shift
            place, bent = last.moved()
        raise UndeterminedTermsError(f"the last step was {moved:g} m")

    def _border(self, last):
        """What common terms add to a block that has settled, and their next step.

        And the most that the step moves any point by [m].
        """
        n_terms = self._shared.shape[2]
        if n_terms == 0:
            n_models, n_points = self.incidence.n_models, self.incidence.n_points
            n_unknowns = N_UNKNOWNS + self._bent.shape[2]
            sizes = (
                (n_points, 3, 0),
                (*self.weights.shape, 0),
                (n_models, n_unknowns, 0),
            )
            nothing = Bordered(np.zeros((0, 0)), *map(np.zeros, sizes))
            return nothing, np.zeros(0), 0.0
        on_ground = last.place.matrix[self._model] @ self._shared
        held = np.zeros((self.incidence.n_points, 3, n_terms))
        answer = last.solver.project(-on_ground, held)
        left = normals_of_common(on_ground, self.weights, answer.residuals)
        cofactors = inverse_of_common(*left)
        bordered = Bordered(
            cofactors, answer.points, answer.residuals, answer.parameters
        )
        weighted = on_ground * self.weights[:, :, None]
        residuals = last.found.residuals[:, :, 0]
        shift = -cofactors @ np.einsum("ncj,nc->j", weighted, residuals)
        return bordered, shift, np.abs(on_ground @ shift).max(initial=0.0)

    def _settled(self, place, bent, control, settled):
        """Last pass from a start, for common terms as they are.

        Where second derivatives count, errors are larger than stated, and a model may
        hang on little: until no step counts beside the errors that residuals show.
        """
        before, share, held, hold = None, 1.0, 0, 1
        now = self._pass(place, bent, control)
        for _ in range(MOST_PASSES):
            if before is not None and now.squares > before.squares * (1.0 + GROWS):
                order, share = POSITIVE, share / 2.0
                if before.order == FULL:  # it led uphill: no minimum is near as yet
                    share, held, hold = 1.0, hold, 2 * hold
                    stood = before.place, before.bent
                    before = self._pass(*stood, control, before.residuals, order)
            elif not np.isfinite(now.size):
                break
            elif now.size < settled or now.is_settled:
                return now
            else:
                order = min(POSITIVE if held else FULL, _next_order(now, before))
                before, share, held = now, min(1.0, 2.0 * share), max(0, held - 1)
            now = self._pass(*before.moved(share), control, before.residuals, order)
        worst = int(self.ordering.order[now.moves.argmax()])
        raise NoConvergenceError(now.size, worst, self.incidence.n_models)

    def _without_pull(self, last, control, settled):
        """Last pass with the arms of adjusted points, beginning where models settled.

        As it was where a rough solution is asked for, and beside gross errors, of which
        residuals may be as long as arms: where second derivatives count, errors are
        much larger than stated, or steps do not become smaller.
        """
        n_free = last.residuals.size - N_UNKNOWNS * self.incidence.n_models
        n_free -= 3 * (self.incidence.n_points - np.count_nonzero(self.is_control))
        is_gross = last.squares > LARGEST_S_0**2 * max(n_free, 1)
        if last.order != LINEAR or settled > SETTLED or is_gross:
            return last
        now, before = last, np.inf
        for _ in range(MOST_PASSES):
            is_settled = now is not last and now.size < settled
            now = self._pass(*now.moved(), control, now.residuals, adjusted=True)
            if is_settled:  # a step is some thousand times smaller than the one before
                return now
            if not now.size < max(before, ROUGHLY):
                return last
            before = now.size
        return last

    def _pass(
        self, place, bent, control, residuals=None, order=LINEAR, *, adjusted=False
    ):
        """Linearise the block where its models stand, and find their step from there.

        ``residuals`` are those of the place before, for second derivatives, or
        (``adjusted``) for arms that end at the adjusted points.
        """
        arm = self._arms(place)
        extent = self._extents(arm)
        second = None
        if order != LINEAR:
            given = self.incidence, arm, self.weights * residuals, extent
            second = second_derivatives(*given, is_positive=order == POSITIVE)
        ends = arm - residuals if adjusted else arm
        solver = self._factored(ends, extent, second)
        right = -(place.centre[self._model] + arm)[:, :, None], control[:, :, None]
        found = solver.project(*right)
        stand = self._as_they_stand(solver, bent, right, found.parameters)
        return _Pass(place, bent, extent, solver, found, *stand, order)

    def _as_they_stand(self, solver, bent, right, found):
        """Models before their step: the points that fit them best, and residuals.

        Then Σ w v² of measurements, control and deformations, and the part of it that
        half of the step would take away.
        """
        still = np.zeros((len(bent), N_UNKNOWNS))
        parameters = np.concatenate([still, bent], axis=1)[:, :, None]
        points, residuals = solver.system.project(parameters, *right)
        away = (points - right[1])[self.is_control, :, 0]
        weight = self.prior[0][self.is_control]
        squares = np.sum(self.weights * residuals[:, :, 0] ** 2) + np.sum(bent**2)
        squares += np.einsum("na,nab,nb->", away, weight, away)
        slope = solver.system.gradient(residuals) + solver.prior[:, None] * parameters
        decrease = np.sum(slope * (parameters - found))
        return points[:, :, 0], residuals[:, :, 0], float(squares), float(decrease)

    def _arms(self, place):
        """Points from the centre of their model, on the ground."""
        offset = self._xyz - place.centroid[self._model]
        return np.einsum("nij,nj->ni", place.matrix[self._model], offset)

    def _extents(self, arm):
        """Root mean square length of the arms of each model; 1 where they have none."""
        n_models = len(self.ordering.order)
        count = np.bincount(self._model, minlength=n_models)
        squares = np.bincount(self._model, (arm**2).sum(axis=1), n_models)
        extent = np.sqrt(squares / np.maximum(count, 1))
        # all of its measurements may have been taken out, or all but one in its middle:
        # it is neither turned nor scaled
        return np.where(extent > 0.0, extent, 1.0)

    def _factored(self, arm, extent, second=None):
        design = np.zeros((len(arm), 3, N_UNKNOWNS))
        design[:, range(3), range(3)] = 1.0
        unit = arm / extent[self._model][:, None]
        design[:, :, 3] = unit
        design[:, :, 4:] = cross_matrix(-unit)
        design = np.concatenate([design, self._bent], axis=2)
        prior = np.repeat([0.0, 1.0], [N_UNKNOWNS, self._bent.shape[2]])
        if second is not None:
            second = among_unknowns(second, len(prior))
        control = self.prior[0], self._held
        given = self.ordering, design, self.weights, control, prior
        return factor_block(*given, second=second)

    def _solution(self, last, control, common, bordered):
        """The block after its last step; its variances are those of a linear one."""
        found, order = last.found, self.ordering.order
        place, bent = last.moved()
        points, residuals = found.points[:, :, 0], found.residuals[:, :, 0]
        if last.order != LINEAR:
            # it stays there: a linear step may lead away again, and far
            last = self._pass(place, bent, control)
            points, residuals = last.points, last.residuals
            bordered = self._border(last)[0]
        extent, solver = last.extent, last.solver
        n_unknowns = N_UNKNOWNS * self.given.n_models + len(common)
        fields = self.common_fields(
            points, residuals, control, place.origin, n_unknowns
        )
        fields["sum_of_squares"] += float(np.sum(bent**2))
        return SpatialSolution(
            **fields,
            bent=in_old_order(bent, order),
            placement=place.arranged(lambda values: in_old_order(values, order)),
            extent=in_old_order(extent, order),
            common=common,
            bordered=bordered,
            solver=solver,
        )


@dataclass(frozen=True, eq=False)
class _Pass:
    """A linearisation: everything in the order of elimination."""

    place: Placement
    bent: np.ndarray  # (n_models, n_bent): each model's own deformation, as it stands
    extent: np.ndarray  # (n_models,): unit of scale and turn [m]
    solver: Solver
    found: Projection
    points: np.ndarray  # (n_points, 3): as the models stand [m]
    residuals: np.ndarray  # (n_rows, 3): likewise
    squares: float  # Σ w v², likewise
    decrease: float  # of it, by half of the step: the step squared, over its variance
    order: int  # which second derivatives it counts

    @property
    def moves(self):
        """The largest step of each model [m]."""
        return np.abs(self.found.parameters[:, :N_UNKNOWNS, 0]).max(axis=1)

    @property
    def size(self):
        """The largest step of any model [m]."""
        return self.moves.max()

    @property
    def is_settled(self):
        """Whether the step is nothing beside the errors of what it moves.

        Only where second derivatives count: small errors deserve every digit.
        """
        variance = max(1.0, self.squares / self.residuals.size)
        is_little = abs(self.decrease) < SETTLED_OF_ERROR**2 * variance
        return self.order != LINEAR and is_little

    def moved(self, share=1.0):
        """Models and their deformations after a share of the step."""
        found, place = self.found.parameters[:, :, 0], self.place
        step = share * found[:, :N_UNKNOWNS]
        relative = step[:, 3:] / self.extent[:, None]
        turn = rotation_by_vector(relative[:, 1:])
        moved = replace(
            place,
            centre=place.centre + step[:, :3],
            scale=place.scale * (1.0 + relative[:, 0]),
            rotation=turn @ place.rotation,
        )
        return moved, self.bent + share * (found[:, N_UNKNOWNS:] - self.bent)


def _next_order(now, before):
    """Second derivatives that the next pass is to count, by the steps so far."""
    if before is None or now.size < SLOWLY * before.size:
        return now.order
    if now.size > before.size:
        return POSITIVE if before.size > FAR else now.order
    return min(now.order + 1, FULL)
