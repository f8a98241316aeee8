"""Two flights transformed, averaged and propagated as arrays, without a table.

What the stages do with the tables of any block, for two flights of plane models over
points that are numbered, all of them usable. A search lays out several plans to
recommend one, and of each it is a third of the work.
"""

from dataclasses import dataclass
from functools import cached_property, partial, reduce
from operator import add

import numpy as np
import pandas as pd

from einschalt.foundations.batches import segments
from einschalt.foundations.projections import read_crs
from einschalt.foundations.units import METRES_PER_UM
from einschalt.stages.bent_map import (
    LEAST,
    PLACED_BY,
    bends_plane_models,
    flat_system,
    is_of_the_earth,
    moved_coordinates,
)
from einschalt.stages.error_propagation.covariances import (
    PropagatedErrors,
    SharedCovariances,
    covariances_of_pairs,
    propagate,
)
from einschalt.stages.error_propagation.operators import (
    GroundSources,
    operator_of_fit,
)
from einschalt.stages.stage4_error_budget import error_budget
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS
from einschalt.stages.value_weights import PLAIN, value_weights
from einschalt.theory.adjustment.least_squares import (
    SQRT2,
    pooled_standard_error,
    standard_error_of_unit_weight,
    total_from_coordinate,
)
from einschalt.theory.adjustment.point_operator import (
    Axes,
    PointOperator,
    on_diagonal,
    selection,
    sums,
    unchanged,
    weighted_mean,
)
from einschalt.theory.double_coverage import mean_of_values, position_in_extent
from einschalt.theory.relative_orientation.deformation_error import roots_of
from einschalt.theory.transformation.sensitivity import CONFORMAL

CONTROL, HIGH, LOW = "control", "high_flight", "low_flight"
# a point that stands for several is fitted with the error of their mean: what its own
# measurement is off that, and what others add to the measurement of control
SINGLE, OTHERS = "low_flight_single", "high_flight_others"
# what the high flight's measuring errors of points that no model is fitted on make of
# the means of these: nothing else depends on them
UNFITTED = "high_flight_unfitted"


@dataclass(frozen=True, eq=False)
class PlaneFlight:
    """Measured plane models of a flight, and the points that they hold."""

    kind: str  # of the transformation: affine, helmert or rigid
    scale_number: float
    m_g_um: float  # TOTAL error of a measured point, as it is stated [µm]
    # (n_rows,): number of the model, ascending from 0 without a gap, and of the point
    model: np.ndarray
    point: np.ndarray
    xy: np.ndarray  # (n_rows, 2): in the unit of the models
    # points that each one stands for: models of the low flight are fitted on so many,
    # and its error is that of their mean
    stands_for: float = 1.0
    # how much larger errors are in the model than in the image, (n_rows,): by the depth
    # of a point below the cameras, over that of the scale
    enlarged: np.ndarray | float = 1.0

    @property
    def n_models(self):
        """Number of models."""
        return int(self.model[-1]) + 1

    @property
    def ground_error(self):
        """Error of each measured coordinate on the ground [m], (n_rows,)."""
        m_g_um = np.full(len(self.model), self.m_g_um)
        on_ground = m_g_um * METRES_PER_UM * self.scale_number * self.enlarged
        return on_ground / SQRT2


@dataclass(frozen=True, eq=False)
class GivenControl:
    """Control as it is given."""

    point: np.ndarray  # (n,): its points, ascending
    plane: np.ndarray  # (n, 2): easting, northing [m]
    standard_error: float  # TOTAL [m]
    crs: str | None


class UnusableModelError(Exception):
    """A model that cannot be transformed, which the tables of the stages tell of."""


@dataclass(frozen=True, eq=False)
class _Models:
    """Which model each row belongs to, as a ModelTransformation has it."""

    codes: np.ndarray
    count: int

    def __len__(self):
        return self.count


@dataclass(frozen=True, eq=False)
class _Observed:
    """Points of both frames, sorted by model, as a ModelTransformation has them."""

    source: np.ndarray
    target: np.ndarray
    weights: np.ndarray
    start: np.ndarray
    row_numbers: np.ndarray
    ground_rows: np.ndarray
    models: _Models


@dataclass(frozen=True, eq=False)
class _Transformation:
    """The models of a flight on ground points."""

    flight: PlaneFlight
    xy: np.ndarray
    fit: object
    observed: _Observed

    def values(self):
        """Ground coordinates of all rows, (n_rows, 2) [m]."""
        return self.fit.apply(self.flight.model, self.xy)

    def operator(self, ground, axes):
        """Error operator of all rows."""
        return operator_of_fit(self.fit, self.observed, self.xy, ground, axes)


@dataclass(frozen=True, eq=False)
class _Means:
    """Means of the values of each point, in the order in which points appear."""

    point: np.ndarray  # (n_points,)
    order: np.ndarray  # (n_rows,): rows sorted by point
    start: np.ndarray  # (n_points + 1,)
    weights: np.ndarray  # (n_rows,) or (n_rows, 2, 2): of the rows in that order

    @classmethod
    def of(cls, flight, weighting=PLAIN, chains=None, sizes=None, known=None):
        """Plain means, or those of least variance.

        ``chains`` lead from all sources, whose errors are ``sizes``, to the values;
        ``known`` are their SharedCovariances.
        """
        codes, point = pd.factorize(flight.point)
        sort = segments(codes, len(point))
        covariances = partial(covariances_of_pairs, chains, sizes, known=known)
        found = value_weights(weighting, None, sort.order, sort.start, covariances)
        return cls(point, sort.order, sort.start, found.in_mean)

    def mean(self, coordinates, standard_error):
        """PointMeans of values (n_rows, 2) with TOTAL errors (n_rows,) [m]."""
        values = coordinates[self.order], standard_error[self.order]
        return mean_of_values(*values, self.weights, self.start)

    def operator(self, axes):
        """Operator from the values to the means."""
        n_rows = len(self.order)
        return weighted_mean(self.order, self.weights, self.start, n_rows, axes)


@dataclass(frozen=True, eq=False)
class PropagatedFlights:
    """Points of two flights with their propagated errors; values when asked for."""

    means: _Means
    low: _Transformation
    errors: PropagatedErrors  # of the final points
    chains_to_values: dict

    @property
    def point(self):
        """Numbers of the final points, (n_points,)."""
        return self.means.point

    @property
    def n_models(self):
        """How many models of the low flight hold each of them, (n_points,)."""
        return np.diff(self.means.start)

    @cached_property
    def errors_of_values(self) -> PropagatedErrors:
        """Errors of the value of every point in every model, row for row."""
        sizes = self.errors.standard_errors
        return propagate(self.low.flight.point, self.chains_to_values, sizes)

    @property
    def parts(self):
        """Covariance of each point from control and flights, dict of arrays [m²]."""
        parts = dict(self.errors.parts)
        for name, of in ((HIGH, UNFITTED), (LOW, SINGLE)):
            if of in parts:
                parts[name] = parts[name] + parts.pop(of)
        return parts

    @property
    def m_0(self):
        """TOTAL standard error of unit weight of all low-flight models [m]."""
        return float(total_from_coordinate(self._pooled))

    @property
    def _pooled(self):
        fit = self.low.fit
        return pooled_standard_error(fit.sum_of_squares, fit.redundancy)

    @cached_property
    def paper_of_values(self):
        """TOTAL error of each value by the formula of 1971 [m], (n_rows,)."""
        fit, flight = self.low.fit, self.low.flight
        own = standard_error_of_unit_weight(fit.sum_of_squares, fit.redundancy)
        s_0 = np.where(fit.redundancy >= 1, own, self._pooled)
        cofactors = fit.point_cofactors(flight.model, self.low.xy)
        plan = cofactors[:, 0, 0] + cofactors[:, 1, 1]
        m_t = s_0[flight.model] * np.sqrt(plan)
        m_g_um = np.full(len(m_t), flight.m_g_um)
        return error_budget(m_g_um, flight.scale_number, m_t)

    @property
    def paper_of_points(self):
        """The same of plain means of all values, (n_points,)."""
        values, errors = self.low.values(), self.paper_of_values
        return _Means.of(self.low.flight).mean(values, errors).standard_error

    @property
    def position(self):
        """Place u, v of each value in the extent of its model, (n_rows, 2)."""
        models = np.arange(self.low.flight.n_models + 1)
        start = np.searchsorted(self.low.flight.model, models)
        return position_in_extent(self.low.xy, start)


def propagate_flights(high, low, control, weighting=PLAIN) -> PropagatedFlights:
    """Transform two flights, average their values, and propagate all errors.

    ``high``, ``low``: PlaneFlight; ``control``: GivenControl; ``weighting`` "plain" or
    "rigorous" in the means of both flights. UnusableModelError where a model of either
    cannot be transformed.
    """
    high_xy, low_xy = _bent(high, low, control)
    axes = Axes.COMPLEX if {high.kind, low.kind} <= set(CONFORMAL) else Axes.PLANE
    own, sizes = unchanged(axes), _sizes(high, low, control)
    of_high = _transformed(high, high_xy, high.kind, control.point, control.plane)
    operator = of_high.operator(_sources(len(control.point)), axes)
    chains = {CONTROL: operator.ground @ own, HIGH: operator.measured @ own}
    high_means = _Means.of(high, weighting, chains, sizes)
    if high.stands_for > 1.0:
        chains, sizes = _as_fitted(high, control, chains, sizes, axes)
    approximate = _mean_ground(of_high, high_means)
    of_low = _transformed(low, low_xy, low.kind, high_means.point, approximate)
    operator = of_low.operator(_sources(len(high_means.point)), axes)
    averaged, rows = high_means.operator(axes), of_high.observed.row_numbers
    chains, sizes = _by_point(averaged, chains, sizes, rows)
    chains = {name: operator.ground @ chain for name, chain in chains.items()}
    chains[LOW] = operator.measured @ own
    if low.stands_for > 1.0:
        share = 1.0 / low.stands_for
        sizes[SINGLE] = sizes[LOW] * np.sqrt(1.0 - share)
        sizes[LOW] = sizes[LOW] * np.sqrt(share)
        chains[SINGLE] = _of_rows(np.ones(len(low.point)), axes)
    known = SharedCovariances(through_models=True)
    means = _Means.of(low, weighting, chains, sizes, known)
    final = means.operator(axes)
    to_points = {name: final @ chain for name, chain in chains.items()}
    errors = propagate(means.point, to_points, sizes, known)
    return PropagatedFlights(means, of_low, errors, chains)


def _as_fitted(flight, control, chains, sizes, axes):
    """Chains to values, and errors, of a flight on which another one is fitted.

    Each value is the mean of those for which it stands. Where control lies, its own
    measurement, on which the models of this flight are fitted, is one of them.
    """
    share, n_rows = 1.0 / flight.stands_for, len(flight.point)
    is_control, of_one = np.isin(flight.point, control.point), sizes[HIGH]
    less = _of_rows(np.where(is_control, share - 1.0, 0.0), axes)
    chains = chains | {
        HIGH: chains[HIGH] + less,
        OTHERS: _of_rows(np.ones(n_rows), axes),
    }
    of_others = np.sqrt(share * (1.0 - share))
    errors = {
        HIGH: of_one * np.where(is_control, 1.0, np.sqrt(share)),
        OTHERS: of_one * np.where(is_control, of_others, 0.0),
    }
    return chains, sizes | errors


def _by_point(averaged, chains, sizes, fitted):
    """Chains to means of the high flight, and errors, with one number for many.

    Errors that no model is fitted on, those of all rows but ``fitted`` and of OTHERS,
    meet in the mean of their point alone: what they make of it stands for them, so that
    models of the low flight depend on one number a point, not on one of each model that
    holds it.
    """
    axes, n_rows = averaged.axes, averaged.n_sources
    of_fitted = selection(fitted, n_rows, axes).T
    unfitted = sizes[HIGH].copy()
    unfitted[fitted] = 0.0
    if OTHERS in sizes:  # no model is fitted on these either
        unfitted = np.hypot(unfitted, sizes[OTHERS])
        chains = {name: one for name, one in chains.items() if name != OTHERS}
        sizes = {name: size for name, size in sizes.items() if name != OTHERS}
    roots = roots_of(averaged.covariances(unfitted))
    chains = {
        name: chain if name == CONTROL else _multiplied(chain, -1, of_fitted)
        for name, chain in chains.items()
    }
    # means depend on no more parameters than their values did
    known = {}
    chains = {
        name: _multiplied(chain, 0, averaged, known) for name, chain in chains.items()
    }
    chains[UNFITTED] = on_diagonal(axes.blocks_of(roots))
    sizes = {
        name: size[fitted] if name == HIGH else size for name, size in sizes.items()
    }
    sizes[UNFITTED] = np.ones(averaged.n_points)
    return chains, sizes


def _multiplied(chain, place, step, known=None):
    """Take one more step at an end of a chain, multiplied by what stands there.

    At the ``place`` 0, after all others, or -1; ``known`` keeps products of the same
    two matrices, so that chains that begin alike still do. Products of one factor are
    added.
    """
    (matrix,), known = step.factors, {} if known is None else known

    def with_step(product):
        factors = list(product.factors)
        one = factors[place]
        if id(one) not in known:
            known[id(one)] = matrix @ one if place == 0 else one @ matrix
        factors[place] = known[id(one)]
        return PointOperator(tuple(factors), product.axes)

    products = [with_step(one) for one in chain.products]
    short = [one for one in products if len(one.factors) == 1]
    longer = [one for one in products if len(one.factors) > 1]
    added = [reduce(add, short)] if short else []
    return PointOperator.sum_of([*longer, *added])


def _of_rows(factors, axes):
    """Operator that multiplies each row with a factor."""
    n_rows = len(factors)
    return sums(factors, np.arange(n_rows), np.arange(n_rows + 1), n_rows, axes)


def _sizes(high, low, control):
    """Errors of the observations of each source, per coordinate [m]."""
    return {
        CONTROL: np.full(len(control.point), control.standard_error) / SQRT2,
        HIGH: high.ground_error,
        LOW: low.ground_error,
    }


def _sources(count):
    return GroundSources(np.arange(count), count)


def _mean_ground(transformation, means):
    values = transformation.values()
    return means.mean(values, np.ones(len(values))).mean


def _transformed(flight, xy, kind, points, plane) -> _Transformation:
    """Transform all models onto the points that are known, ``plane`` (n, 2) [m]."""
    ground_row = np.full(max(flight.point.max(), points.max()) + 1, -1)
    ground_row[points] = np.arange(len(points))
    ground_row = ground_row[flight.point]
    rows = np.flatnonzero(ground_row >= 0)
    observed = _Observed(
        source=xy[rows],
        target=plane[ground_row[rows]],
        weights=np.ones(len(rows)),
        start=np.searchsorted(flight.model[rows], np.arange(flight.n_models + 1)),
        row_numbers=rows,
        ground_rows=ground_row[rows],
        models=_Models(flight.model, flight.n_models),
    )
    fit = TRANSFORMATION_KINDS[kind].fit(
        observed.source, observed.target, observed.weights, observed.start
    )
    if (fit.status != 0).any() or fit.is_mirrored.any():
        raise UnusableModelError
    return _Transformation(flight, xy, fit, observed)


def _bent(high, low, control):
    """Coordinates of both flights' models, bent as the map is; see bend_flights."""
    high_xy, low_xy = high.xy, low.xy
    if not is_of_the_earth(control.crs):
        return high_xy, low_xy
    is_high_bent, is_low_bent = (
        bends_plane_models(control.plane, flight.scale_number, control.crs)
        for flight in (high, low)
    )
    if not is_high_bent and not is_low_bent:
        return high_xy, low_xy
    crs = flat_system(read_crs(control.crs))
    kind = PLACED_BY.get(high.kind, high.kind)
    placed = _transformed(high, high.xy, kind, control.point, control.plane)
    if is_high_bent:
        high_xy = _moved(placed, crs)
    if is_low_bent:
        means, kind = _Means.of(high), PLACED_BY.get(low.kind, low.kind)
        ground = _mean_ground(placed, means)
        low_xy = _moved(_transformed(low, low.xy, kind, means.point, ground), crs)
    return high_xy, low_xy


def _moved(placed, crs):
    """Coordinates as the map bends them; as they were where that is not worth it."""
    model = placed.flight.model
    moved, away = moved_coordinates(placed.xy, model, placed, crs)
    if not np.isfinite(away).all():
        raise UnusableModelError
    return moved if away.max() > LEAST else placed.xy
