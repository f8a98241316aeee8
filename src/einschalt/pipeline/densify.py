"""From a block to densified coordinates: the five stages, orientation first."""

from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter

import numpy as np
import pandas as pd

from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.assessment.claim import examine_claim
from einschalt.pipeline.assessment.figures import (
    BlockFigures,
    adjusted_figures,
    two_step_figures,
)
from einschalt.pipeline.assessment.precision_tables import PrecisionTables
from einschalt.pipeline.assessment.systematic_errors import find_patterns
from einschalt.pipeline.assessment.tolerance import with_tolerance
from einschalt.pipeline.assessment.variance_components import (
    can_tell_components,
    estimate_components,
)
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.block.repeated_pointings import m_g_of_repeated_settings
from einschalt.pipeline.densification.coverage_screening import (
    screen_block,
    with_suspects,
)
from einschalt.pipeline.densification.gross_errors import (
    GrossMeasurements,
    find_gross_measurements,
    no_gross_measurements,
)
from einschalt.pipeline.densification.iteration import (
    MOVES,
    Iteration,
    assumed_after_iteration,
    iterate,
    iterated_model,
    require_iterable,
)
from einschalt.pipeline.densification.low_flight_fit import LowFlightFit, fit_low_flight
from einschalt.pipeline.densification.residual_distribution import (
    distributed,
    require_control,
)
from einschalt.pipeline.densification.residual_test_weights import residual_test_weights
from einschalt.pipeline.densification.simultaneous import (
    adjust_flights,
    distribute_adjusted,
    point_columns,
    require_adjustable,
)
from einschalt.pipeline.progress import Stage, stage_reporter
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.summary.summary import summarize
from einschalt.stages.coverage_screening import COLUMNS, CoverageScreening
from einschalt.stages.error_propagation.error_model import PLAN, ErrorModel
from einschalt.stages.error_propagation.operators import PropagatedErrors
from einschalt.stages.model_screening import screen_models
from einschalt.stages.results import FAILURE_COLUMNS
from einschalt.stages.simultaneous.adjustment import BlockAdjustment
from einschalt.stages.stage1_approximate_coordinates import (
    ApproximateCoordinates,
    average_high_flight,
    transform_high_flight,
)
from einschalt.stages.stage2_relative_orientation import relative_orientation
from einschalt.stages.stage3_model_transformation import (
    ModelTransformation,
)
from einschalt.stages.stage4_error_propagation import (
    model_of_known_errors,
    propagate_model,
)
from einschalt.stages.stage5_double_coverage import (
    CoverageMean,
)

FLIGHT_LAST = "low_flight"
PLANE_POINT = ["point_id", "easting", "northing"]
VALUE_COLUMNS = ["coverage", "model_id", *PLANE_POINT]


@dataclass(frozen=True, eq=False, repr=False)
class DensificationResult(PrecisionTables):
    """Densified coordinates of a block, with everything that led to them.

    Attributes
    ----------
    block : Block
        The input as it was checked.
    settings : Settings
    points : DataFrame
        point_id, easting, northing [, height] [, standard_error_easting,
        standard_error_northing, covariance_en, standard_error_total],
        standard_error_paper, standard_error_internal, n_models, n_coverages,
        spread_total, role (new, control, check), is_suspect (coverages that differ by
        more than they may), difference_easting,
        difference_northing [, difference_height] (densified less given, control and
        check points only) [, distributed_easting, distributed_northing (part of the
        coordinates that comes from the distribution of residuals)] [,
        standard_error_checked, is_within_tolerance (where a tolerance is set)] [m].
    models : DataFrame
        flight, coverage, model_id, transformation, n_points, redundancy, m_0, s_0,
        is_usable, reason, then the parameters.
    residuals : DataFrame
        flight, coverage, model_id, point_id, residual_easting, residual_northing
        [, residual_height] (transformed less given) [m], leverage, redundancy_number,
        w, p_value, is_suspect (of the joint test of both coordinates).
    orientations : DataFrame
        flight, coverage, model_id, case, n_points, redundancy, sigma_0 [mm],
        is_converged, is_ambiguous (another orientation fits as well), verdict (on the
        dangerous surface: safe, weak, critical), inflation, reason,
        m_g_intersection_um, m_g_orientation_um, then the elements; no rows where
        nothing was oriented.
    orientation_residuals : DataFrame
        flight, coverage, model_id, point_id, then the residuals of stage 2 [mm] and,
        of images, weight, w, p_value, is_suspect; no rows where nothing was oriented.
    failures : DataFrame
        flight, coverage, model_id, stage, reason, remedy.
    gross_measurements : DataFrame
        flight, coverage, model_id, point_id, residual_easting, residual_northing [m],
        w, p_value of the measurements that contradict the other models of their flight,
        and took no part; no rows with ``outliers = "keep"``.
    single_values : DataFrame
        Every low-flight model's value of every point: coverage, model_id, point_id,
        easting, northing [, height], m_t, position_u, position_v,
        standard_error_paper.
    screening : CoverageScreening or None
        What each coverage gives for a point, and how far the coverages differ; the
        values of suspects stand there beside their mean.
    approximations : DataFrame
        point_id, easting, northing [, height], n_models, n_coverages, spread_total.
    figures : BlockFigures
    errors : PropagatedErrors or None
        Covariances of the points, and their sources; None where the size of a source
        of error is not known.
    high : ApproximateCoordinates or None
        Stage 1, with the transformations of the high flight.
    low : ModelTransformation or None
        Stage 3, the transformations of the low flight; None where the two-step way
        was not possible.
    seconds : float
        Time of the computation.
    means : CoverageMean or None
        Stage 5, the means behind the points of the two steps.
    model_points : dict of str to DataFrame
        Of each flight, as they were transformed.
    orientation_errors : dict of str to OrientationErrors, ImageErrors or None
        Of each flight that was oriented by y-parallaxes or formed from images.
    propagation : ErrorModel or None
        Operators behind ``errors``.
    iteration : Iteration or None
        With ``iterations`` above 1: every pass of the low flight.
    simultaneous : BlockAdjustment or None
        With ``method = "simultaneous"``: where points, models and residuals are from.
    two_step : DensificationResult or None
        Then, the same block in two steps, where that is possible.
    """

    block: Block
    settings: Settings
    points: pd.DataFrame
    models: pd.DataFrame
    residuals: pd.DataFrame
    orientations: pd.DataFrame
    orientation_residuals: pd.DataFrame
    failures: pd.DataFrame
    gross_measurements: pd.DataFrame
    single_values: pd.DataFrame
    screening: CoverageScreening | None
    approximations: pd.DataFrame
    figures: BlockFigures
    errors: PropagatedErrors | None
    high: ApproximateCoordinates | None
    low: ModelTransformation | None
    seconds: float
    means: CoverageMean | None = None
    model_points: dict | None = None
    orientation_errors: dict | None = None
    propagation: ErrorModel | None = None
    iteration: Iteration | None = None
    simultaneous: BlockAdjustment | None = None
    two_step: "DensificationResult | None" = None

    @property
    def coverages(self):
        """Values of the single coverages of a point, DataFrame, see ``screening``."""
        if self.screening is None:
            return pd.DataFrame(columns=COLUMNS).astype({"is_suspect": bool})
        return self.screening.table

    @property
    def iterations(self):
        """How far the points moved in each further pass, a DataFrame; see Iteration."""
        return (
            pd.DataFrame(columns=MOVES) if not self.iteration else self.iteration.moves
        )

    @cached_property
    def error_model(self):
        """The model of errors that the two-step figure rests on, ErrorModel or None.

        That of the propagation; without one, a model in which nothing is shared that
        it cannot know of: given approximate coordinates are independent, orientations
        without errors. None where sizes of errors are not known.
        """
        if self.propagation is not None or self.low is None:
            return self.propagation
        return assumed_after_iteration(self)

    @cached_property
    def claim(self):
        """Tests of the claimed figure of two steps against the measurements: Claim."""
        return examine_claim(self)

    @cached_property
    def components(self):
        """Sizes of errors that the measurements show, BlockComponents or None.

        Computed when it is asked for the first time; None where the errors cannot be
        propagated, or the block is too small to tell.
        """
        if self.two_step is not None:
            return self.two_step.components
        if self.errors is None or not can_tell_components(self):
            return None
        first = self.low if self.iteration is None else self.iteration.passes[0].low
        return estimate_components(self, first)

    @cached_property
    def repeated_settings(self):
        """What points that were set several times say of m_g, a DataFrame."""
        return m_g_of_repeated_settings(self)

    @cached_property
    def patterns(self):
        """Affinity of film and strain of control: SystematicPatterns."""
        return find_patterns(self)

    def summary(self):
        """Return verdict, problems and suggestions, then numbers."""
        return summarize(self)


def densify(block, settings=None, *, progress=None):
    """Compute the coordinates of a block's points, as its settings say.

    In the two-step way of 1971: approximate coordinates from the high flight (or given
    ones), relative orientation where it is to be computed, every low-flight model onto
    all its points, error budget, mean of the coverages. Or all models of all flights
    in one adjustment. Check points enter neither.

    Parameters
    ----------
    block : Block
    settings : Settings, optional
        The block's own where left out.
    progress : callable, optional
        Called with the title of each stage and the fraction that is done.

    Returns
    -------
    DensificationResult
        A model that fails is a row of ``failures`` and does not stop the rest.

    Raises
    ------
    GeometryError
        Not one model of a flight could be used.
    """
    started = perf_counter()
    settings = settings or block.settings
    require_control(block, settings)
    require_iterable(block, settings)
    report_progress = stage_reporter(progress)
    report_progress(Stage.RELATIVE_ORIENTATION)
    flights = {
        name: relative_orientation(flight, outliers=settings.outliers)
        for name, flight in block.flights.items()
    }
    ways = {"two_step": _in_two_steps, "simultaneous": _in_one_adjustment}
    result = ways[settings.method](block, settings, flights, report_progress)
    report_progress(Stage.ASSESSMENT)
    result = replace(result, points=with_tolerance(result))
    report_progress(Stage.DONE)
    return replace(result, seconds=perf_counter() - started)


def _in_two_steps(block, settings, flights, report_progress):
    report_progress(Stage.APPROXIMATE_COORDINATES)
    gross = find_gross_measurements(block, flights, settings)
    measured = {name: oriented.model_points for name, oriented in flights.items()}
    high = _high_flight(block, measured, settings, gross.rows)
    approximations = block.approximate_points if high is None else high.points
    report_progress(Stage.MODEL_TRANSFORMATION)
    precision = residual_test_weights(block, flights, high)
    low_points, is_gross = measured[FLIGHT_LAST], gross.rows[FLIGHT_LAST]

    def pass_onto(ground):
        return fit_low_flight(
            block, low_points, ground, precision, settings, is_gross=is_gross
        )

    first = pass_onto(approximations)
    iteration = iterate(block, first, pass_onto, settings.iterations)
    last = first if iteration is None else iteration.passes[-1]
    report_progress(Stage.ERROR_PROPAGATION)
    model = model_of_known_errors(block, flights, high, first)
    if model is not None:
        model = iterated_model(block, model, iteration, measured[FLIGHT_LAST])
    errors = None if model is None else propagate_model(model, last.means)
    report_progress(Stage.DOUBLE_COVERAGE)
    screening = screen_block(last.means, errors, settings)
    stages = _Stages(flights, gross, high, last, iteration, model, errors, screening)
    return _result(block, settings, stages)


def _in_one_adjustment(block, settings, flights, report_progress):
    require_adjustable(block)
    # what is distributed in the end are the residuals of the adjustment
    plain = settings.model_copy(update={"residual_distribution": "none"})
    try:
        two_step = _in_two_steps(block, plain, flights, report_progress)
    except GeometryError:  # the summary says so, and gives the other way
        two_step = None
    report_progress(Stage.SIMULTANEOUS_ADJUSTMENT)
    adjusted = adjust_flights(block, settings, flights)
    points = point_columns(block, flights, adjusted, two_step)
    points = _with_roles(points, block.control_points)
    points = distribute_adjusted(block, settings, points)
    start = two_step or _without_steps(block, settings, flights)
    failures = _joined_failures(
        [o.failures.assign(flight=name) for name, o in flights.items()]
        + [adjusted.failures]
    )
    return replace(
        start,
        settings=settings,
        points=points,
        models=adjusted.models,
        residuals=adjusted.residuals,
        failures=failures,
        gross_measurements=no_gross_measurements(),  # all are in the residuals
        figures=adjusted_figures(adjusted, points, failures),
        errors=None,
        simultaneous=adjusted,
        two_step=two_step,
    )


@dataclass(frozen=True, eq=False)
class _Stages:
    """What the stages gave, in their order."""

    flights: dict
    gross: GrossMeasurements
    high: ApproximateCoordinates | None
    last: LowFlightFit
    iteration: Iteration | None
    model: ErrorModel | None
    errors: PropagatedErrors | None
    screening: CoverageScreening


def _result(block, settings, stages):
    high, low, values = stages.high, stages.last.low, stages.last.values
    means = stages.last.means
    points = with_suspects(means.points, stages.screening)
    points = _with_roles(points, block.control_points)
    points, errors = distributed(block, settings, points, stages.errors)
    points = _with_totals(points, errors)
    failures = _failures(stages.flights, high, low)
    return DensificationResult(
        block=block,
        settings=settings,
        points=points,
        models=_by_flight(high, low, _models_with_parameters),
        residuals=_by_flight(high, low, lambda fit: fit.residuals),
        orientations=_of_flights(stages.flights, "orientations"),
        orientation_residuals=_of_flights(stages.flights, "residuals"),
        failures=failures,
        gross_measurements=stages.gross.table,
        single_values=values[values["easting"].notna()].reset_index(drop=True),
        screening=stages.screening,
        approximations=block.approximate_points if high is None else high.points,
        figures=two_step_figures(high, low, means, points, failures),
        errors=errors,
        high=high,
        low=low,
        seconds=np.nan,
        means=means,
        model_points={n: flight.model_points for n, flight in stages.flights.items()},
        orientation_errors=_errors_of(stages.flights),
        propagation=stages.model,
        iteration=stages.iteration,
    )


def _without_steps(block, settings, flights):
    """What is left of a result where the two-step way is not possible."""
    nothing = pd.DataFrame()
    known = block.approximate_points
    return DensificationResult(
        block=block,
        settings=settings,
        points=nothing,
        models=nothing,
        residuals=nothing,
        orientations=_of_flights(flights, "orientations"),
        orientation_residuals=_of_flights(flights, "residuals"),
        failures=nothing,
        gross_measurements=no_gross_measurements(),
        single_values=pd.DataFrame(columns=VALUE_COLUMNS),
        screening=None,
        approximations=pd.DataFrame(columns=PLANE_POINT) if known is None else known,
        figures=None,
        errors=None,
        high=None,
        low=None,
        seconds=np.nan,
    )


def _errors_of(flights):
    """Errors of the orientations of each flight."""
    return {name: oriented.errors for name, oriented in flights.items()}


def _high_flight(block, measured, settings, gross):
    if block.high_flight is None:
        return None
    points, is_out = measured["high_flight"], gross["high_flight"]
    kind = block.high_flight.transformation
    fitted = transform_high_flight(points, block.control_points, kind)
    # five control points cannot spare one: suspects of a model alone are only named
    named = screen_models(fitted, "keep", settings.significance, is_gross=is_out)
    return average_high_flight(named, points, is_gross=is_out, **settings.averaging)


def _with_totals(points, errors):
    if errors is None:
        return points
    covariance = errors.covariance
    n_axes = covariance.shape[1]
    place = points.columns.get_loc("standard_error_paper")
    east, north = covariance[:, 0, 0], covariance[:, 1, 1]
    columns = {
        "standard_error_easting": np.sqrt(east),
        "standard_error_northing": np.sqrt(north),
        "covariance_en": covariance[:, 0, 1],
        "standard_error_total": np.sqrt(east + north),
    }
    if n_axes > len(PLAN):
        columns["standard_error_height"] = np.sqrt(covariance[:, 2, 2])
    before, after = points.iloc[:, :place], points.iloc[:, place:]
    return pd.concat([before, pd.DataFrame(columns), after], axis=1)


def _with_roles(points, control_points):
    names = [n for n in ("easting", "northing", "height") if n in points]
    differences = [f"difference_{name}" for name in names]
    if control_points is None:
        points.insert(points.columns.get_loc("is_suspect"), "role", "new")
        return points.assign(**dict.fromkeys(differences, np.nan))
    given = control_points.set_index("point_id").reindex(points["point_id"])
    role = given["role"].fillna("new").to_numpy()
    points.insert(points.columns.get_loc("is_suspect"), "role", role)
    for name, difference in zip(names, differences, strict=True):
        known = given[name].to_numpy() if name in given else np.nan
        points[difference] = points[name] - known
    return points


def _by_flight(high, low, table_of):
    parts = [table_of(low).assign(flight=FLIGHT_LAST)]
    if high is not None:
        parts.insert(0, table_of(high.transformation).assign(flight="high_flight"))
    table = pd.concat(parts, ignore_index=True)
    return table[["flight", *(name for name in table if name != "flight")]]


def _models_with_parameters(fit):
    return pd.concat([fit.models, fit.parameters.reset_index(drop=True)], axis=1)


def _of_flights(flights, table):
    """A table of stage 2 of all flights that were oriented."""
    of_flights = {name: getattr(oriented, table) for name, oriented in flights.items()}
    parts = [part.assign(flight=name) for name, part in of_flights.items() if len(part)]
    if not parts:
        empty = next(iter(of_flights.values()))
        return pd.DataFrame(columns=["flight", *empty.columns])
    joined = pd.concat(parts, ignore_index=True)
    return joined[["flight", *(name for name in joined if name != "flight")]]


def _failures(flights, high, low):
    parts = [o.failures.assign(flight=name) for name, o in flights.items()]
    if high is not None:
        parts.append(high.failures.assign(flight="high_flight"))
    parts.append(low.failures.assign(flight=FLIGHT_LAST))
    return _joined_failures(parts)


def _joined_failures(parts):
    filled = [part for part in parts if len(part)]
    columns = ["flight", *FAILURE_COLUMNS]
    if not filled:
        return pd.DataFrame(columns=columns)
    return pd.concat(filled, ignore_index=True)[columns]
