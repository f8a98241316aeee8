"""Sizes of errors that the measurements show, against those that were given.

Four sums of squares know of them. The values of a point in several models, of either
flight, differ by measuring errors and transformations; the control points are missed
by the high flight, and the approximate points by the low flight, on the average of the
models that hold them.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import numbered, segment_sum, segments
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode
from einschalt.foundations.patches import Patches
from einschalt.pipeline.assessment.evidence.without_gross_errors import (
    gross_rows,
)
from einschalt.pipeline.block.facts import FLIGHTS
from einschalt.stages.error_propagation.error_model import (
    CONTROL,
    HIGH,
    LOW,
    PLAN,
    add_flight_sources,
    given_errors,
    places_fitted_onto,
)
from einschalt.stages.error_propagation.given_points import GROUPS, errors_of_control
from einschalt.stages.error_propagation.measurement_errors import (
    ORIENTATION,
    OWN_DEFORMATION,
    measurement_errors,
)
from einschalt.stages.error_propagation.operators import (
    GroundSources,
    flight_operator,
    mean_operator,
)
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.point_operator import (
    Axes,
    selection,
    weighted_mean,
)
from einschalt.theory.adjustment.variance_components import (
    SumOfSquares,
    estimate_factors,
)

# a standard error of variance components is itself uncertain, and a difference of a
# few per cent changes nothing
LARGE_DIFFERENCE = 4.0
MIN_REPORTED_RATIO = 1.10
# values of the low flight, of which that many tell its m_g to a few thousandths; of
# more there are patches over the whole block
MOST_VALUES, VALUES_OF_PATCH = 100_000, 5_000


@dataclass(frozen=True)
class Component:
    """The size of the errors of one source, as given and as estimated."""

    # TOTAL; m_g in µm, control in m
    given: float
    estimated: float
    standard_error: float

    @property
    def is_contradicted(self) -> bool:
        """Whether the given size is far from the estimated one."""
        difference = abs(self.estimated - self.given)
        is_significant = difference > LARGE_DIFFERENCE * self.standard_error
        is_large = difference > (MIN_REPORTED_RATIO - 1.0) * self.given
        return bool(is_significant and is_large)

    def facts_of(self, flight: str) -> dict[str, str | float]:
        """Facts for a finding on the m_g of a flight, plain numbers in µm."""
        return {
            "flight": str(flight),
            "given_um": float(self.given),
            "estimated_um": float(self.estimated),
            "standard_error_um": float(self.standard_error),
        }


@dataclass(frozen=True)
class BlockComponents:
    """Variance components of a block."""

    # standard error of the control points [m]; where they have several, their root mean
    # square
    control: Component
    # m_g [µm]
    high_flight: Component
    low_flight: Component


def can_tell_components(examined):
    """Whether both flights were measured in plan, each point with errors of its own.

    Image points are shared by models, which sums over single models do not know.
    """
    flights = examined.block.flights
    is_own = not any(flight.has_images for flight in flights.values())
    is_plane = examined.errors.axes is not Axes.SPACE
    return is_own and len(flights) == len(FLIGHTS) and is_plane


def estimate_components(examined, low):
    """Estimate the errors of control and of both flights from the measurements.

    ``low`` is the low flight onto the approximate coordinates. Gross measurements and
    suspects are left out; errors of orientations are held at the sizes that their
    parallaxes show. None where the block is too small to tell.
    """
    block, points = examined.block, examined.model_points
    sources = _Sources.of(examined, low)
    patches = _patches(low)
    every = _sums(examined, low, sources, patches)
    sums = [part for part in every if len(part.values)]
    sizes = given_errors(block, points)
    if len(sums) < len(sizes):
        return None
    try:
        found = estimate_factors(
            sums,
            {**sizes, **sources.sizes},
            held=sources.held,
            are_of_part=patches is not None,
        )
    except np.linalg.LinAlgError:  # a source that no sum can tell from another
        return None
    control = SQRT2 * np.sqrt(np.mean(sizes[CONTROL] ** 2))
    given = {
        CONTROL: float(control),
        **{name: float(flight.m_g_um) for name, flight in block.flights.items()},
    }
    # factors are those of the errors that were counted with
    counted = {name: flight.m_g_counted_um for name, flight in block.flights.items()}
    counted = given | counted
    return BlockComponents(
        **{
            source: Component(size, *found.scaled(source, counted[source]))
            for source, size in given.items()
        }
    )


@dataclass(frozen=True, eq=False)
class _Sources:
    """What stands behind the measuring errors of each flight.

    Orientations are a source for each flight: their sizes come from its parallaxes.
    """

    axes: Axes
    behind: dict
    sizes: dict
    held: dict

    @classmethod
    def of(cls, examined, low):
        fits = {HIGH: examined.high.transformation, LOW: low}
        errors = examined.orientation_errors
        points, bent = examined.model_points, examined.own_deformation
        own = measurement_errors(examined.block, points, fits, errors, bent)
        behind, sizes, held = {}, {}, {}
        # shifts of groups are held at the size of the propagation
        known = examined.errors.standard_errors
        for source in set(GROUPS.values()) & known.keys():
            sizes[source], held[source] = known[source], 0.0
        for name, chains in own.chains.items():
            behind[name] = {name: chains[name]}
            if ORIENTATION in chains:
                source = f"{ORIENTATION}, {name}"
                behind[name][source] = chains[ORIENTATION]
                sizes[source] = np.ones(own.n_unit[ORIENTATION])
                held[source] = np.sqrt(2.0 / errors[name].redundancy)
            if OWN_DEFORMATION in chains:
                behind[name][OWN_DEFORMATION] = chains[OWN_DEFORMATION]
                sizes[OWN_DEFORMATION] = np.ones(own.n_unit[OWN_DEFORMATION])
                held[OWN_DEFORMATION] = bent.error_of_variance
        return cls(own.axes, behind, sizes, held)


def _patches(low):
    """Part of a large block; None where all of it is looked at."""
    values = values_of(low.own_values, PLAN)
    values = values[np.isfinite(values).all(axis=1)]
    every = -(-len(values) // MOST_VALUES)
    return Patches.over(values, VALUES_OF_PATCH, every) if every > 1 else None


def _sums(examined, low, sources, patches):
    """Sums of squares of both flights, with their chains of operators."""
    control, high = examined.block.control_points, examined.high
    is_control = (control["role"] != "check").to_numpy()
    of_high = _MeasuredFlight(
        high.transformation,
        examined.model_points[HIGH],
        GroundSources(np.flatnonzero(is_control), len(control)),
        gross_rows(examined, HIGH, high.transformation),
        (sources.axes, sources.behind[HIGH]),
        patches,
    )
    places = places_fitted_onto(examined.block, high.points["point_id"])
    of_low = _MeasuredFlight(
        low,
        examined.model_points[LOW],
        GroundSources(places, len(high.points)),
        gross_rows(examined, LOW, low),
        (sources.axes, sources.behind[LOW]),
        patches,
    )
    n_high = len(examined.model_points[HIGH])
    approximate = mean_operator(high.means, np.arange(n_high), n_high, sources.axes)
    given = errors_of_control(examined.block, sources.axes)
    from_control = given.chains
    from_high = {
        name: approximate @ chain
        for name, chain in add_flight_sources(
            given.picked(of_high.operator.ground).chains,
            of_high.operator.measured,
            sources.behind[HIGH],
        ).items()
    }
    return [
        of_high.misfit(from_control),
        of_high.differences(from_control),
        of_low.misfit(from_high),
        of_low.differences(from_high),
    ]


class _MeasuredFlight:
    """Values and residuals of a flight, with the operators that they come from."""

    def __init__(self, transformation, model_points, ground, is_out, sources, patches):
        self._observed, self._ground = transformation.observed, ground
        self._axes, self._own = sources
        self.operator = flight_operator(
            transformation, model_points, ground, self._axes
        )
        values = transformation.own_values
        self._values = values_of(values, PLAN)
        self._point = encode(values["point_id"]).codes
        self._is_good = np.isfinite(self._values).all(axis=1) & ~is_out
        if patches is not None:
            self._is_good &= self._in_patches(patches)

    def _in_patches(self, patches):
        """Whether the point of each value lies there, by the mean of its good ones."""
        rows = np.flatnonzero(self._is_good)
        n_points = int(self._point.max(initial=-1)) + 1
        points = segments(self._point[rows], n_points)
        count = np.maximum(np.diff(points.start), 1)
        total = segment_sum(self._values[rows[points.order]], points.start)
        return patches.hold(total / count[:, None])[self._point]

    def differences(self, chains):
        """Values of each point less their mean."""
        rows = np.flatnonzero(self._is_good)
        groups = _Groups(self._point[rows], self._axes)
        n_values = len(self._values)
        mean = groups.mean(rows, n_values)
        each = selection(rows[groups.order], n_values, self._axes)
        picked = each - (groups.spread() @ mean).formed()
        return self._sum((picked, self._values), picked, None, chains)

    def misfit(self, chains):
        """Residuals of each point that was fitted, on the average of its models."""
        observed = self._observed
        is_good = self._is_good[observed.row_numbers]
        rows, onto = observed.row_numbers[is_good], observed.ground_rows[is_good]
        residuals = (self._values[observed.row_numbers] - observed.target)[is_good]
        groups = _Groups(self._point[rows], self._axes)
        mean = groups.mean(np.arange(len(rows)), len(rows))
        picked = (mean @ selection(rows, len(self._values), self._axes)).formed()
        places = self._ground.places[onto]
        given = (mean @ selection(places, self._ground.count, self._axes)).formed()
        return self._sum((mean, residuals), picked, given, chains)

    def _sum(self, observed, picked, given, chains):
        # not formed: both sums of a flight share what stands behind its values
        through_ground = picked @ self.operator.ground
        if given is not None:
            through_ground = through_ground - given
        through = {name: through_ground @ rest for name, rest in chains.items()}
        measured = picked @ self.operator.measured
        operator, vectors = observed
        return SumOfSquares(
            operator.apply(self._axes.packed(vectors)),
            add_flight_sources(through, measured, self._own),
        )


class _Groups:
    """Rows grouped by their point."""

    def __init__(self, points, axes):
        _, group = numbered(points)
        sort = segments(group, int(group.max(initial=-1)) + 1)
        self.order, self._start, self._axes = sort.order, sort.start, axes

    def mean(self, rows, n_all):
        """Mean of each group, from all values."""
        weights = np.ones(len(rows))
        return weighted_mean(rows[self.order], weights, self._start, n_all, self._axes)

    def spread(self):
        """Mean of its group for each row, sorted by group."""
        n_groups = len(self._start) - 1
        group = np.repeat(np.arange(n_groups), np.diff(self._start))
        return selection(group, n_groups, self._axes)
