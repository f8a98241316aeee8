"""The a-priori model of a block's errors: operators on everything that it measured.

Where all sources of error have a size, it is the model of the propagation. Where
approximate coordinates were given and nobody says what they share, they are taken for
independent of each other, with their stated error or with that which the fits show: it
is the assumption under which a budget could hold, and it is there to be tested.
"""

from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from einschalt.foundations.names import encode, is_among
from einschalt.stages.error_propagation.covariances import (
    SharedCovariances,
    covariances_of_pairs,
)
from einschalt.stages.error_propagation.given_points import (
    APPROXIMATE_POINTS,
    GivenErrors,
    approximations_are_control,
    control_errors,
    errors_of_control,
    errors_of_table,
    errors_where_control,
    group_members,
)
from einschalt.stages.error_propagation.group_size import with_group_sizes
from einschalt.stages.error_propagation.measurement_errors import (
    measurement_errors,
)
from einschalt.stages.error_propagation.operators import (
    FlightOperator,
    GroundSources,
    flight_operator,
    mean_operator,
)
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.monte_carlo import apply_chains, draw_errors
from einschalt.theory.adjustment.point_operator import (
    Axes,
    PointOperator,
    selection,
)

APPROXIMATE = "approximate_points"
PLAN = ("easting", "northing")
CONTROL, HIGH, LOW = "control", "high_flight", "low_flight"


@dataclass(frozen=True, eq=False)
class HighFlight:
    """How errors enter the values of the high flight."""

    operator: FlightOperator
    mean: PointOperator  # approximate coordinates from the values
    control: GivenErrors
    # which control point stands in each row of the table that was fitted onto
    places: np.ndarray
    own: dict[str, PointOperator]  # measuring errors from the sources behind them

    @property
    def chains(self):
        """From the sources to the values, dict of str to PointOperator."""
        measured = {n: self.operator.measured @ c for n, c in self.own.items()}
        return {**self.control.picked(self.operator.ground).chains, **measured}


@dataclass(frozen=True, eq=False)
class ErrorModel:
    """How errors of the given sizes enter values, residuals and final points."""

    # final points from the values of the low flight, or these as they are
    final: PointOperator
    # values of the low flight from its own errors, and from those of the approximate
    # coordinates
    low: FlightOperator
    # approximate coordinates from the sources behind them
    ground: dict[str, PointOperator]
    high: HighFlight | None
    # which approximate point stands in each row of the table that was fitted onto
    places: np.ndarray
    # of each source's observations, per coordinate [m]; with a column for each axis
    # where they differ
    standard_errors: dict[str, np.ndarray]
    # whether the approximate coordinates are only assumed to be independent, or
    # orientations to be without errors
    is_assumed: bool
    # measuring errors of the low flight from the sources behind them
    own: dict[str, PointOperator]
    # what the values share; of other chains it is computed anew
    known: SharedCovariances = field(
        default_factory=SharedCovariances, repr=False, kw_only=True
    )

    @property
    def axes(self):
        """Of the operators."""
        return self.low.measured.axes

    @property
    def chains_to_values(self):
        """From the sources to the values of the low flight, dict of PointOperator."""
        through = {n: self.low.ground @ c for n, c in self.ground.items()}
        return add_flight_sources(through, self.low.measured, self.own)

    def is_last(self, flight):
        """Whether a flight is the one of ``low``: a high flight alone stands there."""
        return flight == LOW or self.high is None

    def groups_of_fits(self, flight, source, observed):
        """Group of the given point behind each fit of a flight, −1 where it has none.

        ``source`` are the shifts of the groups.
        """
        is_last = self.is_last(flight)
        chain = self.ground[source] if is_last else self.high.control.chains[source]
        places = self.places if is_last else self.high.places
        members = chain.matrix.tocsr()
        group = np.full(chain.n_points, -1)
        for_points = np.flatnonzero(np.diff(members.indptr)[:: self.axes.value])
        first = members.indptr[for_points * self.axes.value]
        group[for_points] = self.axes.count(members.indices[first])
        return group[places[observed.ground_rows]]

    def with_means(self, means):
        """Take means of the values for the final points.

        ``means`` are of all values of the low flight, row for row as its model points.
        """
        n_values = self.low.measured.n_points
        final = mean_operator(means, np.arange(n_values), n_values, self.axes)
        return replace(self, final=final)

    def covariances_of_values(self, pairs):
        """Covariances between values of the low flight.

        ``pairs`` (n_pairs, 2) of rows of its model points; gives (n_pairs,
        n_coordinates, n_coordinates) [m²], NaN where a model is not usable. Values of
        spatial models are the less known the more these may be turned.
        """
        found = covariances_of_pairs(
            self.chains_to_values, self.standard_errors, pairs, self.known
        )
        if self.low.turned is not None:
            own = np.flatnonzero(pairs[:, 0] == pairs[:, 1])
            found[own] += self.beyond_linear(pairs[own, 0])
        return found

    def beyond_linear(self, rows):
        """Mean products of what values of spatial models miss the linear by.

        ``rows`` (n_rows,) of the model points of the low flight; gives (n_rows, 3, 3)
        [m²], 0 where a model is not usable.
        """
        onto = replace(self, low=self.low.parameters).chains_to_values
        return self.low.turned.squares(onto, self.standard_errors, rows)

    @property
    def chains(self):
        """From the sources to the final points, dict of str to PointOperator."""
        return {name: self.final @ c for name, c in self.chains_to_values.items()}

    @property
    def from_control(self):
        """Operator from the given coordinates of control to the final points."""
        onto = self.high.mean @ self.high.operator.ground
        return self.final @ self.low.ground @ onto

    def chains_to_fits(self, flight, observed):
        """From the sources to what a flight was fitted with: ground minus measured."""
        is_last = self.is_last(flight)
        operator = self.low if is_last else self.high.operator
        places = self.places if is_last else self.high.places
        onto, fitted = operator.selections(places, observed)
        ground = self.ground if is_last else self.high.control.chains
        through = {name: onto @ chain for name, chain in ground.items()}
        return add_flight_sources(
            through, -fitted, self.own if is_last else self.high.own
        )

    def draw(self, n_draws, seed):
        """Draw the errors of all sources and carry them to all values."""
        errors = draw_errors(
            self.standard_errors, self.axes, n_draws=n_draws, seed=seed
        )
        high = None
        control = None
        if self.high is not None:
            high = apply_chains(errors, self.high.chains)
            control = self.high.control.apply(errors)
        ground = apply_chains(errors, self.ground)
        own = {name: self.low.measured @ c for name, c in self.own.items()}
        low = self.low.ground.apply(ground) + apply_chains(errors, own)
        return DrawnBlock(errors, control, high, ground, low)


def add_flight_sources(chains, measured, own):
    """Add to chains what a flight's own errors bring.

    ``measured`` leads from its measuring errors, ``own`` to these from the sources.
    """
    found = dict(chains)
    for name, chain in own.items():
        part = measured @ chain
        found[name] = found[name] + part if name in found else part
    return found


@dataclass(frozen=True, eq=False)
class DrawnBlock:
    """Errors of a block, drawn many times; packed, a column for each draw."""

    sources: dict[str, np.ndarray]  # of all observations
    # of the given coordinates of all control points
    control: np.ndarray | None
    high: np.ndarray | None  # of the values of the high flight
    ground: np.ndarray  # of the approximate coordinates
    low: np.ndarray  # of the values of the low flight


def model_of_both_flights(
    block, points, high, low, oriented=None, bent=None
) -> ErrorModel:
    """Errors of control and of both flights, of the sizes that were given.

    ``points`` are the model points of each flight as they were transformed,
    ``oriented`` the errors of each orientation (none where left out). Sources:
    ``control``, ``high_flight``, ``low_flight`` and, where flights were oriented,
    ``orientation``; where models are bent each in its own way, ``own_deformation``.
    """
    fits = {HIGH: high.transformation, LOW: low}
    own = measurement_errors(block, points, fits, oriented or {}, bent)
    of_high = _high_flight(block, points[HIGH], high, own)
    places = places_fitted_onto(block, high.points["point_id"])
    sources = GroundSources(places, len(high.points))
    model = ErrorModel(
        **_of_last_flight(low, points[LOW], own, sources),
        ground={name: of_high.mean @ c for name, c in of_high.chains.items()},
        high=of_high,
        standard_errors=_with_unit_sources(_sizes(block, points, of_high.control), own),
        is_assumed=not own.is_complete,
    )
    return with_group_sizes(model, of_high.control, HIGH, high.transformation)


def _of_last_flight(fit, points, own, sources, name=LOW):
    """Fields of the model that concern the low flight, or what stands in its place."""
    n_values = len(points)
    return {
        "final": selection(np.arange(n_values), n_values, own.axes),
        "low": flight_operator(fit, points, sources, own.axes),
        "places": sources.places,
        "own": own.chains[name],
    }


def model_of_high_flight(block, points, transformation, oriented=None) -> ErrorModel:
    """Errors of the high flight alone, the one that is transformed onto control.

    With the high flight in the place of the low one, and control for what it was fitted
    onto. Its orientations are without errors where ``oriented`` is left out.
    """
    flight = {HIGH: points}, {HIGH: transformation}, {HIGH: oriented}
    own = measurement_errors(block, *flight)
    sources = _fitted_control(block)
    control = errors_of_control(block, own.axes)
    is_oriented = block.high_flight.is_oriented_numerically
    model = ErrorModel(
        **_of_last_flight(transformation, points, own, sources, HIGH),
        ground=control.chains,
        high=None,
        standard_errors=_with_unit_sources(_sizes(block, {HIGH: points}, control), own),
        is_assumed=is_oriented and oriented is None,
    )
    return with_group_sizes(model, control, HIGH, transformation)


def _fitted_control(block):
    control = block.control_points
    places = np.flatnonzero((control["role"] != "check").to_numpy())
    return GroundSources(places, len(control))


def _high_flight(block, points, high, own):
    """How errors enter the values of the high flight and their means."""
    sources = _fitted_control(block)
    operator = flight_operator(high.transformation, points, sources, own.axes)
    n_points = len(points)
    mean = mean_operator(high.means, np.arange(n_points), n_points, own.axes)
    control = errors_of_control(block, own.axes)
    return HighFlight(operator, mean, control, sources.places, own.chains[HIGH])


def _with_unit_sources(sizes, own):
    """Sizes of the errors of all sources, those among them that have variance 1."""
    return {**sizes, **{name: np.ones(n) for name, n in own.n_unit.items()}}


def given_errors(block, points):
    """Sizes of the errors of all observations as they were given, by their source.

    Per coordinate [m]: ``control``, ``high_flight``, ``low_flight``.
    """
    control = {CONTROL: control_errors(block.control_points, Axes.PLANE)}
    return control | _measured_sizes(block, points)


def _sizes(block, points, given):
    return given.sizes | _measured_sizes(block, points)


def _measured_sizes(block, points):
    return {n: _measuring_errors(block.flights[n], p) for n, p in points.items()}


def _measuring_errors(flight, model_points):
    """Error of each measured coordinate [m]; of images their points are measured."""
    measured = flight.image_points if flight.has_images else model_points
    return flight.ground_error_of(measured)


def places_fitted_onto(block, point_ids):
    """Rows of the approximate points that the low flight was fitted onto.

    All but check points; ``point_ids`` are those of the approximate points.
    """
    control = block.control_points
    if control is None:
        return np.arange(len(point_ids))
    is_check = (control["role"] == "check").to_numpy(dtype=bool)
    return np.flatnonzero(~is_among(point_ids, control["point_id"][is_check]))


def assumed_model(result) -> ErrorModel | None:
    """Model of errors of a block whose errors cannot be propagated.

    None where control points have no standard errors, or heights of a machine enter
    from the high flight.
    """
    block = result.block
    if result.high is not None:
        kinds = result.high.transformation.kind, result.low.kind
        is_plane = all(TRANSFORMATION_KINDS[kind].target == PLAN for kind in kinds)
        if not is_plane or "standard_error_m" not in block.control_points:
            return None
    return model_of_block(
        *(block, result.model_points, result.high, result.low),
        *(result.orientation_errors, result.own_deformation),
    ).with_means(result.means)


def model_of_block(block, points, high, low, oriented, bent=None) -> ErrorModel:
    """Errors of everything that a block was made of.

    As :func:`model_of_both_flights`; ``high`` is None where approximate coordinates
    were given.
    """
    if high is None:
        return model_of_given_approximations(block, points[LOW], low, oriented, bent)
    return model_of_both_flights(block, points, high, low, oriented, bent)


def model_of_given_approximations(
    block, low_points, low, oriented=None, bent=None
) -> ErrorModel:
    """Errors of the low flight and of given approximate points.

    Sources: ``approximate_points``, ``approximate_groups`` and ``low_flight``. Where no
    error of the first was stated, it is what m_0 leaves beside m_g, or residuals beside
    the shifts of groups. Where nobody says what points share, they share nothing. Where
    they are control points, these are the source; where some are, these have the errors
    of control.
    """
    flight = {LOW: low_points}, {LOW: low}, oriented or {}
    own = measurement_errors(block, *flight, bent)
    known = block.approximate_points
    sources = GroundSources(places_fitted_onto(block, known["point_id"]), len(known))
    is_control = approximations_are_control(block)
    is_control = is_control and "standard_error_m" in block.control_points
    # what is said of the approximate points themselves comes first
    is_control = is_control and not errors_are_stated(block)
    if is_control:
        rows = pd.Index(block.control_points["point_id"])
        rows = rows.get_indexer(known["point_id"])
        given = errors_of_control(block, own.axes)
        n_given = len(block.control_points)
    else:
        rows, n_given = np.arange(len(known)), len(known)
        size = _errors_of_approximations(block, low, low_points)
        table = block, APPROXIMATE_POINTS, APPROXIMATE
        given = errors_of_table(*table, size, own.axes)
    is_known = is_control or errors_are_stated(block)
    measured = _measuring_errors(block.low_flight, low_points)
    if not (is_known or block.low_flight.has_images):
        measured = _with_heights(measured, low, own.axes)
    given = given.picked(selection(rows, n_given, own.axes))
    model = ErrorModel(
        **_of_last_flight(low, low_points, own, sources),
        ground=given.chains,
        high=None,
        standard_errors=_with_unit_sources({**given.sizes, LOW: measured}, own),
        is_assumed=not (is_known and own.is_complete),
    )
    is_free = not is_control and block.approximate_m_0_m is None
    return with_group_sizes(model, given, LOW, low, (APPROXIMATE,) if is_free else ())


def errors_are_stated(block) -> bool:
    """Whether it is said what errors of approximate points have in common.

    By groups, whose shifts are given or show in the residuals, or by a correlation
    length beside their error.
    """
    if block.approximate_points is None:
        return False
    # a length of 0 says that errors are independent
    is_correlated = block.correlation_lengths_m.get(APPROXIMATE_POINTS, 0.0) > 0.0
    if is_correlated and block.approximate_m_0_m is not None:
        return True
    return not is_correlated and group_members(block.approximate_points) is not None


def _errors_of_approximations(block, low, low_points):
    """Errors of one coordinate of given approximate points, (n_points,) [m].

    Those of control points are known by themselves, unless the table says what its
    points share.
    """
    known = block.approximate_points
    of_control = np.full(len(known), np.nan)
    if not errors_are_stated(block):
        of_control = errors_where_control(block)
    if block.approximate_m_0_m is not None:
        rest = block.approximate_m_0_m / SQRT2
    else:
        measured = _measuring_errors(block.low_flight, low_points)
        square = max(low.m_0_plan**2 / 2.0 - np.mean(measured**2), 0.0)
        used = encode(low_points["point_id"])
        places = encode(known["point_id"]).locate(used)[used.codes]
        rest = _error_of_others(square, of_control[places[places >= 0]])
    return np.where(np.isfinite(of_control), of_control, rest)


def _error_of_others(square, of_control):
    """Error of points that are no control, by the mean square of all [m].

    ``of_control`` (n_values,) has the errors of control, NaN at the others.
    """
    is_control = np.isfinite(of_control)
    n_others = np.count_nonzero(~is_control)
    if not n_others:
        return np.sqrt(square)
    left = len(of_control) * square - np.sum(of_control[is_control] ** 2)
    return np.sqrt(max(left, 0.0) / n_others)


def _with_heights(plan_errors, low, axes):
    """Errors of each axis: heights scatter by what their residuals say."""
    if axes is not Axes.SPACE:
        return plan_errors
    squares = np.nanmean(low.fit.residuals**2, axis=0)
    plan = max(np.mean(squares[:2]), np.finfo(float).tiny)
    ratio = max(float(np.sqrt(squares[2] / plan)), 1.0)
    return plan_errors[:, None] * [1.0, 1.0, ratio]
