"""The a-priori model of a block's errors: operators on everything that it measured.

Where all sources of error have a size, it is the model of the propagation. Where
approximate coordinates were given, they are taken for independent of each other, with
their stated error or with that which the fits show: it is the assumption under which
a budget could hold, and it is there to be tested.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.stages.error_propagation.measurement_errors import (
    measurement_errors,
)
from einschalt.stages.error_propagation.operators import (
    FlightOperator,
    GroundSources,
    covariances_of_pairs,
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
    unchanged,
)

APPROXIMATE = "approximate_points"
PLAN = ("easting", "northing")
# metres; coordinates that lie nearer are the same, written with fewer digits
LEAST_APART = 1e-4
CONTROL, HIGH, LOW = "control", "high_flight", "low_flight"


@dataclass(frozen=True, eq=False)
class HighFlight:
    """How errors enter the values of the high flight."""

    operator: FlightOperator
    mean: PointOperator  # approximate coordinates from the values
    # which control point stands in each row of the table that was fitted onto
    places: np.ndarray
    own: dict[str, PointOperator]  # measuring errors from the sources behind them

    @property
    def chains(self):
        """From the sources to the values, dict of str to PointOperator."""
        measured = {n: self.operator.measured @ c for n, c in self.own.items()}
        return {CONTROL: self.operator.ground, **measured}


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

    @property
    def axes(self):
        """Of the operators."""
        return self.low.measured.axes

    @property
    def chains_to_values(self):
        """From the sources to the values of the low flight, dict of PointOperator."""
        through = {n: self.low.ground @ c for n, c in self.ground.items()}
        return add_flight_sources(through, self.low.measured, self.own)

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
        n_coordinates, n_coordinates) [m²], NaN where a model is not usable.
        """
        return covariances_of_pairs(self.chains_to_values, self.standard_errors, pairs)

    @property
    def chains(self):
        """From the sources to the final points, dict of str to PointOperator."""
        return {name: self.final @ c for name, c in self.chains_to_values.items()}

    def chains_to_fits(self, flight, observed):
        """From the sources to what a flight was fitted with: ground less measured."""
        is_low = flight == LOW
        operator = self.low if is_low else self.high.operator
        places = self.places if is_low else self.high.places
        onto, fitted = operator.selections(places, observed)
        ground = self.ground if is_low else {CONTROL: unchanged(self.axes)}
        through = {name: onto @ chain for name, chain in ground.items()}
        return add_flight_sources(
            through, -fitted, self.own if is_low else self.high.own
        )

    def draw(self, n_draws, seed):
        """Draw the errors of all sources and carry them to all values."""
        errors = draw_errors(
            self.standard_errors, self.axes, n_draws=n_draws, seed=seed
        )
        high = None
        if self.high is not None:
            high = apply_chains(errors, self.high.chains)
        ground = apply_chains(errors, self.ground)
        own = {name: self.low.measured @ c for name, c in self.own.items()}
        low = self.low.ground.apply(ground) + apply_chains(errors, own)
        return DrawnBlock(errors, high, ground, low)


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
    return ErrorModel(
        **_of_last_flight(low, points[LOW], own, sources),
        ground={name: of_high.mean @ c for name, c in of_high.chains.items()},
        high=of_high,
        standard_errors=_with_unit_sources(given_errors(block, points, own.axes), own),
        is_assumed=not own.is_complete,
    )


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
    sizes = given_errors(block, {HIGH: points}, own.axes)
    is_oriented = block.high_flight.is_oriented_numerically
    return ErrorModel(
        **_of_last_flight(transformation, points, own, sources, HIGH),
        ground={CONTROL: unchanged(own.axes)},
        high=None,
        standard_errors=_with_unit_sources(sizes, own),
        is_assumed=is_oriented and oriented is None,
    )


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
    return HighFlight(operator, mean, sources.places, own.chains[HIGH])


def _with_unit_sources(sizes, own):
    """Sizes of the errors of all sources, those among them that have variance 1."""
    return {**sizes, **{name: np.ones(n) for name, n in own.n_unit.items()}}


def given_errors(block, points, axes=Axes.PLANE):
    """Sizes of the errors of all observations as they were given, by their source.

    Per coordinate [m]: ``control`` (in space heights have errors of their own),
    ``high_flight``, ``low_flight``.
    """
    measured = {n: _measuring_errors(block.flights[n], p) for n, p in points.items()}
    return {CONTROL: control_errors(block.control_points, axes), **measured}


def control_errors(control_points, axes):
    """Errors of given coordinates; a height has that of a coordinate if none is given.

    Per coordinate [m], (n_points,), in space (n_points, 3).
    """
    in_plan = control_points["standard_error_m"].to_numpy(dtype=float) / SQRT2
    if axes is not Axes.SPACE or "standard_error_height" not in control_points:
        return in_plan
    of_height = control_points["standard_error_height"].to_numpy(dtype=float)
    of_height = np.where(np.isfinite(of_height), of_height, in_plan)
    return np.column_stack([in_plan, in_plan, of_height])


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
    check = control.loc[control["role"] == "check", "point_id"]
    return np.flatnonzero(~point_ids.isin(check).to_numpy())


def approximations_are_control(block) -> bool:
    """Whether all approximate coordinates are the given ones of control points.

    Then their errors are those of control: independent, and of known size.
    """
    known, control = block.approximate_points, block.control_points
    if known is None or control is None:
        return False
    axes = [n for n in (*PLAN, "height") if n in known and n in control]
    given = control.set_index("point_id")[axes].reindex(known["point_id"])
    apart = known[axes].to_numpy(dtype=float) - given.to_numpy(dtype=float)
    is_named = known["point_id"].isin(control["point_id"]).to_numpy()
    return bool((is_named & (np.nan_to_num(np.abs(apart)) < LEAST_APART).all(1)).all())


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
    """Errors of the low flight and of approximate points that share nothing.

    Sources: ``approximate_points`` and ``low_flight``. Where no error of the former was
    stated, it is what m_0 leaves beside m_g. Where they are control points, these are
    the source.
    """
    flight = {LOW: low_points}, {LOW: low}, oriented or {}
    own = measurement_errors(block, *flight, bent)
    known = block.approximate_points
    sources = GroundSources(places_fitted_onto(block, known["point_id"]), len(known))
    names = known["point_id"]
    is_control = approximations_are_control(block)
    is_control = is_control and "standard_error_m" in block.control_points
    if is_control:
        control, source = block.control_points, CONTROL
        rows = pd.Index(control["point_id"]).get_indexer(names)
        n_sources, size = len(control), control_errors(control, own.axes)
    else:
        rows, n_sources, source = np.arange(len(known)), len(known), APPROXIMATE
        size = np.full(n_sources, _stated_error(block, low, low_points) / SQRT2)
    measured = _measuring_errors(block.low_flight, low_points)
    if not (is_control or block.low_flight.has_images):
        measured = _with_heights(measured, low, own.axes)
    return ErrorModel(
        **_of_last_flight(low, low_points, own, sources),
        ground={source: selection(rows, n_sources, own.axes)},
        high=None,
        standard_errors=_with_unit_sources({source: size, LOW: measured}, own),
        is_assumed=not (is_control and own.is_complete),
    )


def _stated_error(block, low, low_points):
    """TOTAL error of given approximate points [m]."""
    if block.approximate_m_0_m is not None:
        return block.approximate_m_0_m
    measured = _measuring_errors(block.low_flight, low_points) * SQRT2
    return np.sqrt(max(low.m_0_plan**2 - np.mean(measured**2), 0.0))


def _with_heights(plan_errors, low, axes):
    """Errors of each axis: heights scatter by what their residuals say."""
    if axes is not Axes.SPACE:
        return plan_errors
    squares = np.nanmean(low.fit.residuals**2, axis=0)
    plan = max(np.mean(squares[:2]), np.finfo(float).tiny)
    ratio = max(float(np.sqrt(squares[2] / plan)), 1.0)
    return plan_errors[:, None] * [1.0, 1.0, ratio]
