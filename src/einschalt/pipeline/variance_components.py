"""Sizes of errors that the measurements show, against those that were given.

Four sums of squares know of them. The values of a point in several models, of either
flight, differ by measuring errors and transformations; the control points are missed
by the high flight, and the approximate points by the low flight, on the average of the
models that hold them.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import segments
from einschalt.foundations.names import encode
from einschalt.pipeline.block_facts import FLIGHTS
from einschalt.pipeline.error_model import PLAN, given_errors
from einschalt.pipeline.gross_measurements import is_gross
from einschalt.pipeline.own_errors import ORIENTATION
from einschalt.stages.model_screening import suspect_rows
from einschalt.stages.stage4_error_propagation import (
    GroundSources,
    flight_operator,
    mean_operator,
)
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.propagation import selection, weighted_mean
from einschalt.theory.adjustment.variance_components import (
    SumOfSquares,
    estimate_factors,
)
from einschalt.theory.transformation.sensitivity import CONFORMAL


@dataclass(frozen=True)
class Component:
    """The size of the errors of one source, as given and as estimated.

    Attributes
    ----------
    given, estimated, standard_error : float
        TOTAL; m_g in µm, control in m.
    """

    given: float
    estimated: float
    standard_error: float


@dataclass(frozen=True)
class BlockComponents:
    """Variance components of a block.

    Attributes
    ----------
    control : Component
        Standard error of the control points [m]; where they have several, their root
        mean square.
    high_flight, low_flight : Component
        m_g [µm].
    """

    control: Component
    high_flight: Component
    low_flight: Component


def has_plain_measurements(result):
    """Whether machine coordinates of both flights, in plan, are all that was measured.

    What is looked for in models one by one knows nothing of image points that models
    share, and of orientations.

    Parameters
    ----------
    result : DensificationResult

    Returns
    -------
    bool
    """
    flights = result.block.flights
    is_plain = ORIENTATION not in result.errors.parts and not any(
        flight.has_images for flight in flights.values()
    )
    n_axes = result.errors.covariance.shape[1]
    return is_plain and len(flights) == len(FLIGHTS) and n_axes == len(PLAN)


def estimate_components(block, high, low, gross_measurements):
    """Estimate the errors of control and of both flights from the measurements.

    Parameters
    ----------
    block : Block
        One of which :func:`can_propagate` is true.
    high : ApproximateCoordinates
    low : ModelTransformation
    gross_measurements : DataFrame
        flight, coverage, model_id, point_id of those that are known.

    Returns
    -------
    BlockComponents or None
        None where the block is too small to tell. Gross errors and suspects are left
        out.
    """
    n_axes = 1 if {high.transformation.kind, low.kind} <= set(CONFORMAL) else 2
    gross = {
        name: is_gross(gross_measurements, name, points)
        for name, points in _points(block).items()
    }
    sums = _sums(block, high, low, gross, n_axes)
    sums = [part for part in sums if len(part.values)]
    sizes = {
        source: np.repeat(errors, n_axes)
        for source, errors in given_errors(block, _points(block)).items()
    }
    if len(sums) < len(sizes):
        return None
    try:
        found = estimate_factors(sums, sizes)
    except np.linalg.LinAlgError:  # a source that no sum can tell from another
        return None
    control = SQRT2 * np.sqrt(np.mean(sizes["control"] ** 2))
    given = {
        "control": float(control),
        **{name: float(flight.m_g_um) for name, flight in block.flights.items()},
    }
    return BlockComponents(
        **{
            source: Component(size, *found.scaled(source, size))
            for source, size in given.items()
        }
    )


def _points(block):
    return {name: flight.points_to_fit for name, flight in block.flights.items()}


def _sums(block, high, low, gross, n_axes):
    """Sums of squares of both flights, with their chains of operators."""
    control = block.control_points
    is_control = (control["role"] != "check").to_numpy()
    of_high = _MeasuredFlight(
        high.transformation,
        block.high_flight.points_to_fit,
        GroundSources(np.flatnonzero(is_control), len(control)),
        gross["high_flight"],
        n_axes,
    )
    check = control.loc[~is_control, "point_id"]
    is_ground = ~high.points["point_id"].isin(check).to_numpy()
    of_low = _MeasuredFlight(
        low,
        block.low_flight.points_to_fit,
        GroundSources(np.flatnonzero(is_ground), len(high.points)),
        gross["low_flight"],
        n_axes,
    )
    n_high = len(block.high_flight.points_to_fit)
    approximate = mean_operator(high.means, np.arange(n_high), n_high, n_axes)
    from_high = {
        "control": (approximate, of_high.operator.ground),
        "high_flight": (approximate, of_high.operator.measured),
    }
    return [
        of_high.misfit("high_flight", {"control": ()}),
        of_high.differences("high_flight", {"control": ()}),
        of_low.misfit("low_flight", from_high),
        of_low.differences("low_flight", from_high),
    ]


class _MeasuredFlight:
    """Values and residuals of a flight, with the operators that they come from."""

    def __init__(self, transformation, model_points, ground, is_known, n_axes):
        self._observed, self._ground = transformation.observed, ground
        self._n_axes = n_axes
        self.operator = flight_operator(
            transformation, model_points, ground, is_conformal=n_axes == 1
        )
        values = transformation.transform(model_points)
        if "coverage" not in values:
            values = values.assign(coverage="1")
        self._values = values[["easting", "northing"]].to_numpy()
        self._point = encode(values["point_id"]).codes
        is_out = is_known | suspect_rows(values, transformation)
        self._is_good = np.isfinite(self._values).all(axis=1) & ~is_out

    def differences(self, own, chains):
        """Values of each point less their mean."""
        rows = np.flatnonzero(self._is_good)
        groups = _Groups(self._point[rows], self._n_axes)
        size = (len(self._values), self._n_axes)
        mean = groups.mean(rows, size)
        each = selection(rows[groups.order], *size)
        matrix = each - groups.spread() @ mean
        return self._sum(matrix @ self._flat(self._values), matrix, None, own, chains)

    def misfit(self, own, chains):
        """Residuals of each point that was fitted, on the average of its models."""
        observed = self._observed
        is_good = self._is_good[observed.row_numbers]
        rows, onto = observed.row_numbers[is_good], observed.ground_rows[is_good]
        residuals = (self._values[observed.row_numbers] - observed.target)[is_good]
        groups = _Groups(self._point[rows], self._n_axes)
        mean = groups.mean(np.arange(len(rows)), (len(rows), self._n_axes))
        picked = mean @ selection(rows, len(self._values), self._n_axes)
        places = self._ground.places[onto]
        given = mean @ selection(places, self._ground.count, self._n_axes)
        return self._sum(mean @ self._flat(residuals), picked, given, own, chains)

    def _sum(self, values, picked, given, own, chains):
        through_ground = picked @ self.operator.ground
        if given is not None:
            through_ground = through_ground - given
        return SumOfSquares(
            values,
            {
                own: (picked @ self.operator.measured,),
                **{name: (through_ground, *rest) for name, rest in chains.items()},
            },
        )

    def _flat(self, values):
        # one complex number, or two in a row, as the operators have it
        return values @ [1.0, 1j] if self._n_axes == 1 else values.ravel()


class _Groups:
    """Rows grouped by their point."""

    def __init__(self, points, n_axes):
        _, group = np.unique(points, return_inverse=True)
        sort = segments(group, int(group.max(initial=-1)) + 1)
        self.order, self._start, self._n_axes = sort.order, sort.start, n_axes

    def mean(self, rows, size):
        """Mean of each group, from all values."""
        weights = np.ones(len(rows))
        return weighted_mean(rows[self.order], weights, self._start, size)

    def spread(self):
        """Mean of its group for each row, sorted by group."""
        n_groups = len(self._start) - 1
        group = np.repeat(np.arange(n_groups), np.diff(self._start))
        return selection(group, n_groups, self._n_axes)
