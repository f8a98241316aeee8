"""The two steps of 1971: approximate coordinates, then the low flight onto them."""

from dataclasses import dataclass
from functools import partial
from operator import attrgetter

import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.errors import GeometryError, TableError
from einschalt.foundations.frame_columns import MODEL
from einschalt.foundations.names import is_among
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.densification.coverage_screening import (
    screen_block,
    with_suspects,
)
from einschalt.pipeline.densification.figures import two_step_figures
from einschalt.pipeline.densification.gross_errors import find_gross_measurements
from einschalt.pipeline.densification.iteration import (
    MOVES,
    Iteration,
    PassErrors,
    iterate,
)
from einschalt.pipeline.densification.low_flight_fit import (
    average_low_flight,
    transform_low_flight,
)
from einschalt.pipeline.densification.residual_distribution import distributed
from einschalt.pipeline.densification.residual_test_weights import (
    residual_test_covariances,
    residual_test_weights,
)
from einschalt.pipeline.densification.result_tables import (
    HIGH,
    LOW,
    failures_of,
    models_with_parameters,
    of_orientations,
    of_transformed_flights,
    with_roles,
    with_standard_errors,
)
from einschalt.pipeline.densification.simultaneous import (
    MODELLED,
    SearchedFlights,
    own_deformation_of,
    searched_flights,
)
from einschalt.pipeline.densification.solution import Solution
from einschalt.pipeline.progress import Stage
from einschalt.stages.control_in_plan import known_in_plan_alone
from einschalt.stages.coverage_screening import COLUMNS, CoverageScreening
from einschalt.stages.error_propagation.covariances import PropagatedErrors
from einschalt.stages.error_propagation.error_model import ErrorModel
from einschalt.stages.error_propagation.given_points import approximations_are_control
from einschalt.stages.error_propagation.shared_bend_errors import with_shared_bends
from einschalt.stages.error_propagation.shared_error import (
    shared_error_of,
    with_shared_error,
)
from einschalt.stages.model_screening import screen_models
from einschalt.stages.simultaneous.straight_models import BentFlights, bent_flights
from einschalt.stages.stage1_approximate_coordinates import (
    ApproximateCoordinates,
    average_high_flight,
    transform_high_flight,
)
from einschalt.stages.stage2_relative_orientation import RelativeOrientation
from einschalt.stages.stage3_model_transformation import ModelTransformation
from einschalt.stages.stage4_error_propagation import (
    covariances_for,
    model_of_known_errors,
    model_of_known_high_errors,
    propagate_model,
)
from einschalt.stages.stage5_double_coverage import CoverageMean
from einschalt.stages.transformation_kinds import SPATIAL
from einschalt.stages.value_weights import RIGOROUS
from einschalt.theory.block_adjustment.own_deformation import OwnDeformation
from einschalt.theory.block_adjustment.own_deformation_size import MOST_MODELS

PLANE_POINT = ["point_id", "easting", "northing"]
VALUE_COLUMNS = [*MODEL, *PLANE_POINT]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class TwoStepSolution(Solution):
    """Points of a block in the two steps of 1971.

    Attributes
    ----------
    single_values : DataFrame
        Every low-flight model's value of every point: coverage, model_id, point_id,
        easting, northing [, height], m_t, position_u, position_v,
        standard_error_paper.
    screening : CoverageScreening
        What each coverage gives for a point, and how far the coverages differ.
    approximations : DataFrame
        point_id, easting, northing [, height], n_models, n_coverages, spread_total.
    high : ApproximateCoordinates or None
        Stage 1, with the transformations of the high flight; None where approximate
        coordinates were given.
    low : ModelTransformation
        Stage 3, the transformations of the low flight.
    means : CoverageMean
        Stage 5, the means behind the points.
    model_points : dict of str to DataFrame
        Of each flight, as they were transformed.
    flights : dict of str to RelativeOrientation
        Of each flight, what stage 2 gave, before ``shared_bends`` corrected it.
    errors : PropagatedErrors or None
        Covariances of the points, and their sources; None where the size of a source
        of error is not known.
    propagation : ErrorModel or None
        Operators behind ``errors``.
    iteration : Iteration or None
        Every pass of the low flight; None where it was made only once.
    own_deformation : OwnDeformation or None
        What each model is bent by for itself; None where nothing shows.
    shared_bends : BentFlights or None
        What the spatial models of each flight are bent by alike, which they were
        corrected by before they were transformed; None where nothing shows.
    searched : SearchedFlights or None
        What an adjustment of the same flights may share; None of a large block.
    """

    single_values: pd.DataFrame
    screening: CoverageScreening
    approximations: pd.DataFrame
    high: ApproximateCoordinates | None
    low: ModelTransformation
    means: CoverageMean
    model_points: dict[str, pd.DataFrame]
    flights: dict[str, RelativeOrientation]
    errors: PropagatedErrors | None
    propagation: ErrorModel | None
    iteration: Iteration | None
    own_deformation: OwnDeformation | None
    shared_bends: BentFlights | None
    searched: SearchedFlights | None

    is_possible = True

    @property
    def coverages(self) -> pd.DataFrame:
        """Values of the single coverages of a point, DataFrame, see ``screening``."""
        return self.screening.table

    def ground_of(self, flight: str) -> pd.DataFrame:
        """Points that the models of a flight were first fitted onto, a DataFrame."""
        control = self.block.control_points
        if flight == HIGH:
            return control[control["role"] == "control"]
        points = self.approximations
        if control is None:
            return points
        is_check = (control["role"] == "check").to_numpy(dtype=bool)
        return points[~is_among(points["point_id"], control["point_id"][is_check])]

    def first_fit(self, flight: str) -> ModelTransformation:
        """Transformation of a flight, of several passes the first."""
        if flight == HIGH:
            return self.high.transformation
        return self.low if self.iteration is None else self.iteration.passes[0].low

    def first_models(self, flight: str) -> pd.DataFrame:
        """Usable models of the first fit of a flight, a DataFrame."""
        models = tables.with_coverage(self.first_fit(flight).models)
        return models[models["is_usable"].astype(bool)]

    @property
    def iterations(self) -> pd.DataFrame:
        """How far the points moved in each further pass, a DataFrame; see Iteration."""
        return no_moves() if self.iteration is None else self.iteration.moves


@dataclass(frozen=True, eq=False, repr=False)
class WithoutTwoSteps:
    """A block with too little control for two steps: its tables have no rows."""

    block: Block
    flights: dict[str, RelativeOrientation]  # of each flight, what stage 2 gave
    reason: str  # why the two steps are not possible

    is_possible = False

    @property
    def approximations(self) -> pd.DataFrame:
        """Approximate points that were given, a DataFrame."""
        known = self.block.approximate_points
        return pd.DataFrame(columns=PLANE_POINT) if known is None else known

    @property
    def single_values(self) -> pd.DataFrame:
        """No values, a DataFrame."""
        return pd.DataFrame(columns=VALUE_COLUMNS)

    @property
    def coverages(self) -> pd.DataFrame:
        """No coverages, a DataFrame."""
        return pd.DataFrame(columns=COLUMNS).astype({"is_suspect": bool})

    @property
    def iterations(self) -> pd.DataFrame:
        """No passes, a DataFrame."""
        return no_moves()


def no_moves():
    """Moves of the points where nothing was repeated, a DataFrame without rows."""
    return pd.DataFrame(columns=MOVES)


def solve_in_two_steps(
    block,
    settings,
    flights,
    report_progress,
    *,
    before=None,
    gross=None,
    searched=None,
) -> TwoStepSolution:
    """Densify a block in two steps.

    ``flights`` after stage 2. Where they are known, ``before`` is a solution of it with
    other settings, ``gross`` are the gross measurements of this block and these
    flights, and ``searched`` the SearchedFlights that find them. A GeometryError where
    not one model of a flight could be used.
    """
    report_progress(Stage.APPROXIMATE_COORDINATES)
    gross = gross or find_gross_measurements(block, flights, settings, searched)
    alike = searched_flights(block, flights, gross.searched or searched)
    known = _of_the_same(before, block, settings, flights)
    bends, straight = _straightened(_found_alike(known, settings), alike, settings)
    measured = {name: oriented.model_points for name, oriented in straight.items()}
    high = _high_flight(block, straight, settings, gross.rows)
    approximations = block.approximate_points if high is None else high.points
    report_progress(Stage.MODEL_TRANSFORMATION)
    alike = searched_flights(block, straight, alike)
    own = _own_deformation(known, alike, settings, approximations)
    low_flight = _LowFlight(block, straight, high, own, settings, gross.rows[LOW])
    model, last = low_flight.first(approximations)
    model = None if model is None else model.with_means(last.means)
    iteration, model, last = low_flight.iterated(model, last)
    report_progress(Stage.ERROR_PROPAGATION)
    errors = _propagated(model, last, high, bends)
    report_progress(Stage.DOUBLE_COVERAGE)
    screening = screen_block(last.means, errors, settings, model)
    points, errors = _final_points(block, settings, last.means, screening, errors)
    return TwoStepSolution(
        block=block,
        settings=settings,
        points=points,
        gross_measurements=gross.table,
        screening=screening,
        approximations=approximations,
        high=high,
        model_points=measured,
        flights=flights,
        errors=errors,
        propagation=model,
        iteration=iteration,
        own_deformation=own,
        shared_bends=bends,
        searched=gross.searched,
        **_of_last_fit(last),
        **_tables(flights, high, last, points, shared_error_of(block)),
    )


def _propagated(model, last, high, bends):
    """Errors of the means by a model of them, with those of the bends; or None."""
    errors = None if model is None else propagate_model(model, last.means)
    fits = {LOW: last.low, **({} if high is None else {HIGH: high.transformation})}
    return with_shared_bends(errors, model, bends, fits)


def _of_the_same(before, block, settings, flights):
    """The solution before, if deformations of the same flights are known from it."""
    if before and before.is_possible and _bends_alike(before, block, settings, flights):
        return before
    return None


def _found_alike(known, settings):
    """The solution before, if gross errors were kept there as they are here."""
    if known is None:
        return None
    kept = (each.outliers == "keep" for each in (known.settings, settings))
    return known if len(set(kept)) == 1 else None


def _straightened(known, searched, settings):
    """What spatial models are bent by alike, and the flights without that.

    As it is known from another solution, or estimated.
    """
    flights = searched.flights
    bends = _shared_bends(searched, settings) if known is None else known.shared_bends
    return bends, flights if bends is None else bends.straightened(flights)


def _shared_bends(searched, settings):
    """What spatial models share, estimated where it shows; or None."""
    block = searched.block
    kinds = {block.flights[name].transformation for name in searched.flights}
    is_asked_for = settings.model_deformation == MODELLED
    if not is_asked_for or kinds != {SPATIAL} or block.control_points is None:
        return None
    try:
        observed = searched.tables
    except (GeometryError, TableError):  # two steps ask for less than an adjustment
        return None
    how = settings.outliers, settings.significance, searched.searches
    return bent_flights(observed, *how)


def _own_deformation(known, searched, settings, approximations):
    """What models are bent by for themselves, as it is known, or estimated."""
    if known is not None:
        return known.own_deformation
    return own_deformation_of(searched, settings, approximations)


def _bends_alike(before, block, settings, flights):
    """Whether a solution has estimated what models are bent by from the same.

    What is done to gross errors does not matter, but for the points by which some of
    the models of a large block are chosen.
    """
    models = (tables.with_coverage(o.model_points)[MODEL] for o in flights.values())
    n_models = sum(len(rows.drop_duplicates()) for rows in models)
    is_same = (before.flights[name] is oriented for name, oriented in flights.items())
    return (
        n_models <= MOST_MODELS
        and before.block is block
        and before.settings.model_deformation == settings.model_deformation
        and before.settings.significance == settings.significance
        and before.flights.keys() == flights.keys()
        and all(is_same)
    )


def _of_last_fit(last):
    """What the last fit of the low flight gives."""
    values = last.values[last.values["easting"].notna()].reset_index(drop=True)
    return {"low": last.low, "means": last.means, "single_values": values}


def _tables(flights, high, last, points, shared_error):
    """Tables of all flights together."""
    low = last.low
    failures = _failures(flights, high, low)
    return {
        "models": of_transformed_flights(high, low, models_with_parameters),
        "residuals": of_transformed_flights(high, low, attrgetter("residuals")),
        **of_orientations(flights),
        "failures": failures,
        "figures": two_step_figures(
            high, low, last.means, points, failures, shared_error
        ),
    }


class _LowFlight:
    """The low flight, to be transformed onto given coordinates, once or again."""

    def __init__(self, block, flights, high, own, settings, is_gross):
        self.block, self.flights, self.high, self.own = block, flights, high, own
        self.settings, self.is_gross = settings, is_gross
        self.points = flights[LOW].model_points
        self.precision = residual_test_weights(block, flights, high)

    def first(self, ground):
        """Onto approximate coordinates: the model of its errors, and the fit."""
        shared = residual_test_covariances(self.block, self.flights, self.high)
        low = self._transformed(ground, shared)
        flown = self.block, self.flights, self.high, low
        model = model_of_known_errors(*flown, self.own)
        return model, self._averaged(low, model)

    def again(self, ground, passes, *, model, errors):
        """Onto coordinates of passes before, weighed by the errors of the first time.

        ``errors`` are the PassErrors, by which residuals are tested; None where they
        are not known.
        """
        known = errors and errors.covariances_after(passes)
        return self._averaged(self._transformed(ground, known), model)

    def iterated(self, model, last):
        """Onto its own points, as often as is asked for: an Iteration or None.

        And the model of errors, or None, and the fit of the last pass.
        """
        block = self.block
        errors = None if model is None else PassErrors(block, model, self.points)
        fit_onto = partial(self.again, model=model, errors=errors)
        iteration = iterate(block, last, fit_onto, self.settings.iterations)
        if iteration is None:
            return None, model, last
        model = model and errors.iterated_model(iteration.passes)
        return iteration, model, iteration.passes[-1]

    def _transformed(self, ground, covariances=None):
        how = (self.precision, self.settings)
        which = {"covariances": covariances, "is_gross": self.is_gross}
        return transform_low_flight(self.block, self.points, ground, *how, **which)

    def _averaged(self, low, model):
        averaging = averaging_with(self.settings, model, self.block)
        what = self.block, self.points, low, self.settings
        return average_low_flight(*what, is_gross=self.is_gross, averaging=averaging)


def _high_flight(block, flights, settings, gross):
    if block.high_flight is None:
        return None
    points, is_out = flights[HIGH].model_points, gross[HIGH]
    kind = block.high_flight.transformation
    fitted = transform_high_flight(points, block.control_points, kind)
    # five control points cannot spare one: suspects of a model alone are only named
    named = screen_models(fitted, "keep", settings.significance, is_gross=is_out)
    model = None
    if settings.weighting_with(covariances_are_known=True) == RIGOROUS:
        model = model_of_known_high_errors(block, flights[HIGH], named)
    averaging = averaging_with(settings, model, block)
    return average_high_flight(named, points, is_gross=is_out, **averaging)


def averaging_with(settings, model, block):
    """How the values of a point are averaged by a model of their errors, arguments."""
    weighting = settings.weighting_with(covariances_are_known=model is not None)
    return {
        "coverage_mean": settings.coverage_mean,
        "weighting": weighting,
        "covariances": covariances_for(weighting, model, block),
    }


def _final_points(block, settings, means, screening, errors):
    """Points with roles and standard errors, and errors, after the distribution."""
    points = with_suspects(means.points, screening)
    points = with_roles(points, block.control_points, _without_part(block))
    points, errors = distributed(block, settings, points, errors)
    errors = with_shared_error(errors, shared_error_of(block))
    return with_standard_errors(points, errors), errors


def _without_part(block):
    """Names of control onto which no spatial model is fitted, having no height."""
    if block.high_flight is None and not approximations_are_control(block):
        return ()
    flight = block.high_flight or block.low_flight
    control = block.control_points
    return () if control is None else known_in_plan_alone(control, flight)


def _failures(flights, high, low):
    parts = [(name, oriented.failures) for name, oriented in flights.items()]
    if high is not None:
        parts.append((HIGH, high.failures))
    return failures_of([*parts, (LOW, low.failures)])
