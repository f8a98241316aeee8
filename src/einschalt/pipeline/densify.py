"""From a block to densified coordinates: the five stages in order."""

from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter

import numpy as np
import pandas as pd

from einschalt.pipeline.block import Block
from einschalt.pipeline.coverage_screening import screen_block, with_suspects
from einschalt.pipeline.error_propagation import can_propagate, propagate_block
from einschalt.pipeline.observation_precision import observation_precision
from einschalt.pipeline.precision_tables import PrecisionTables
from einschalt.pipeline.residual_distribution import distributed, require_control
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.summary import summarize
from einschalt.pipeline.variance_components import estimate_components
from einschalt.stages.coverage_screening import CoverageScreening
from einschalt.stages.model_screening import screen_models, without_suspects
from einschalt.stages.results import FAILURE_COLUMNS
from einschalt.stages.stage1_approximate_coordinates import (
    ApproximateCoordinates,
    approximate_coordinates,
    require_usable,
)
from einschalt.stages.stage2_relative_orientation import relative_orientation
from einschalt.stages.stage3_model_transformation import (
    STAGE,
    ModelTransformation,
    transform_models,
)
from einschalt.stages.stage4_error_budget import error_budget
from einschalt.stages.stage4_error_propagation import PropagatedErrors
from einschalt.stages.stage5_double_coverage import (
    CoverageMean,
    average_coverages,
    with_positions,
)

FLIGHT_LAST = "low_flight"


@dataclass(frozen=True)
class BlockFigures:
    """The figures of a block, metres and TOTAL unless said otherwise; NaN: not known.

    Attributes
    ----------
    m_0_high, m_0_low : float
        Standard error of unit weight of all models of a flight together, in plan.
    approximation_internal : float
        Approximate coordinates (mean of the coverages), from the differences of the
        coverages of the high flight.
    single_paper, mean_paper : float
        Root mean square of Kovarik's M over the values that were averaged, and over
        the new points.
    single_internal, mean_internal : float
        From the differences of the coverages of the low flight.
    mean_total : float
        Root mean square of the propagated ``standard_error_total`` of the new points.
    control_rms, check_rms : float
        Densified less given coordinates.
    n_points, n_new, n_control, n_check, n_models_high, n_models_low, n_failed : int
    """

    m_0_high: float
    m_0_low: float
    approximation_internal: float
    single_paper: float
    mean_paper: float
    mean_total: float
    single_internal: float
    mean_internal: float
    control_rms: float
    check_rms: float
    n_points: int
    n_new: int
    n_control: int
    n_check: int
    n_models_high: int
    n_models_low: int
    n_failed: int


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
        coordinates that comes from the distribution of residuals)] [m].
    models : DataFrame
        flight, coverage, model_id, transformation, n_points, redundancy, m_0, s_0,
        is_usable, reason, then the parameters.
    residuals : DataFrame
        flight, coverage, model_id, point_id, residual_easting, residual_northing
        [, residual_height] (transformed less given) [m], leverage, redundancy_number,
        w, p_value, is_suspect (of the joint test of both coordinates).
    orientations : DataFrame
        flight, coverage, model_id, case, n_points, redundancy, sigma_0 [mm],
        is_converged, verdict (on the dangerous surface: safe, weak, critical),
        inflation, reason, m_g_intersection_um, m_g_orientation_um, then the elements;
        no rows where nothing was oriented.
    orientation_residuals : DataFrame
        flight, coverage, model_id, point_id, then the residuals of stage 2 [mm] and,
        of images, weight, w, p_value, is_suspect; no rows where nothing was oriented.
    failures : DataFrame
        flight, coverage, model_id, stage, reason, remedy.
    single_values : DataFrame
        Every low-flight model's value of every point: coverage, model_id, point_id,
        easting, northing [, height], m_t, position_u, position_v,
        standard_error_paper.
    screening : CoverageScreening
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
    low : ModelTransformation
        Stage 3, the transformations of the low flight.
    seconds : float
        Time of the computation.
    """

    block: Block
    settings: Settings
    points: pd.DataFrame
    models: pd.DataFrame
    residuals: pd.DataFrame
    orientations: pd.DataFrame
    orientation_residuals: pd.DataFrame
    failures: pd.DataFrame
    single_values: pd.DataFrame
    screening: CoverageScreening
    approximations: pd.DataFrame
    figures: BlockFigures
    errors: PropagatedErrors | None
    high: ApproximateCoordinates | None
    low: ModelTransformation
    seconds: float

    @property
    def coverages(self):
        """Values of the single coverages of a point, DataFrame, see ``screening``."""
        return self.screening.table

    @cached_property
    def components(self):
        """Sizes of errors that the measurements show, BlockComponents or None.

        Computed when it is asked for the first time; None where the errors cannot be
        propagated, or the block is too small to tell.
        """
        if self.errors is None:
            return None
        return estimate_components(self.block, self.high, self.low)

    def summary(self):
        """Return verdict, problems and suggestions, then numbers."""
        return summarize(self)


def densify(block, settings=None, *, progress=None):
    """Compute the coordinates of a block's points in the two-step way of 1971.

    Approximate coordinates from the high flight (or given ones), relative orientation
    where it is to be computed, every low-flight model onto all its points, error
    budget, mean of the coverages. Check points enter no adjustment.

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
    said = progress or _silent
    said("relative orientation", 0.0)
    flights = {
        name: relative_orientation(flight, outliers=settings.outliers)
        for name, flight in block.flights.items()
    }
    said("approximate coordinates", 0.3)
    high = _high_flight(block, flights, settings)
    approximations = block.approximate_points if high is None else high.points
    said("model transformation", 0.5)
    precision = observation_precision(block, flights, high)
    low = _low_flight(
        block, flights[FLIGHT_LAST].model_points, approximations, precision, settings
    )
    said("error budget", 0.8)
    values = _single_values(block.low_flight, low, flights[FLIGHT_LAST].model_points)
    said("double coverage", 0.9)
    means = _means(values, low, settings)
    said("error propagation", 0.95)
    errors = propagate_block(block, high, low, means) if can_propagate(block) else None
    said("done", 1.0)
    screening = screen_block(means, errors, settings)
    stages = _Stages(flights, high, low, values, means, errors, screening)
    return _result(block, settings, stages, perf_counter() - started)


@dataclass(frozen=True, eq=False)
class _Stages:
    """What the stages gave, in their order."""

    flights: dict
    high: ApproximateCoordinates | None
    low: ModelTransformation
    values: pd.DataFrame
    means: CoverageMean
    errors: PropagatedErrors | None
    screening: CoverageScreening


def _result(block, settings, stages, seconds):
    high, low, values = stages.high, stages.low, stages.values
    points = with_suspects(stages.means.points, stages.screening)
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
        single_values=values[values["easting"].notna()].reset_index(drop=True),
        screening=stages.screening,
        approximations=block.approximate_points if high is None else high.points,
        figures=_figures(high, low, stages.means, points, failures),
        errors=errors,
        high=high,
        low=low,
        seconds=seconds,
    )


def _silent(_title, _fraction):
    """Report no progress."""


def _high_flight(block, flights, settings):
    if block.high_flight is None:
        return None
    high = approximate_coordinates(
        flights["high_flight"].model_points,
        block.control_points,
        block.high_flight.transformation,
        coverage_mean=settings.coverage_mean,
        weighting=settings.weighting,
    )
    # five control points cannot spare one: its suspects are only named
    named = screen_models(high.transformation, "keep", settings.significance)
    return replace(high, transformation=named)


def _low_flight(block, model_points, approximations, precision, settings):
    ground = approximations
    if block.control_points is not None:
        is_check = block.control_points["role"] == "check"
        check = block.control_points.loc[is_check, "point_id"]
        ground = ground[~ground["point_id"].isin(check)]
    low = transform_models(model_points, ground, block.low_flight.transformation)
    low = screen_models(low, settings.outliers, settings.significance, precision)
    require_usable(low, "low flight", STAGE)
    return low


def _single_values(flight, low, model_points):
    values = with_positions(low.values(model_points), model_points)
    values["standard_error_paper"] = error_budget(
        flight.m_g_um_of(model_points),
        flight.scale_number,
        values["m_t"].to_numpy(),
    )
    return values


def _means(values, low, settings):
    if settings.outliers != "keep":
        values = without_suspects(values, low)
    means = average_coverages(
        values,
        coverage_mean=settings.coverage_mean,
        weighting=settings.weighting,
    )
    if low.fit.redundancy.any():
        return means
    # models without redundancy repeat the approximate coordinates in both coverages:
    # that they agree says nothing
    points = means.points.assign(standard_error_internal=np.nan)
    return replace(means, points=points, internal_single=np.nan)


def _with_totals(points, errors):
    if errors is None:
        return points
    covariance = errors.covariance
    place = points.columns.get_loc("standard_error_paper")
    east, north = covariance[:, 0, 0], covariance[:, 1, 1]
    columns = {
        "standard_error_easting": np.sqrt(east),
        "standard_error_northing": np.sqrt(north),
        "covariance_en": covariance[:, 0, 1],
        "standard_error_total": np.sqrt(east + north),
    }
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
    filled = [part for part in parts if len(part)]
    columns = ["flight", *FAILURE_COLUMNS]
    if not filled:
        return pd.DataFrame(columns=columns)
    return pd.concat(filled, ignore_index=True)[columns]


def _figures(high, low, means, points, failures):
    new = points[points["role"] == "new"]
    by_role = points["role"].value_counts()
    approximation = np.nan
    if high is not None:
        by_coverages = np.sqrt(high.points["n_coverages"].to_numpy())
        approximation = _rms(high.internal_single / by_coverages)
    return BlockFigures(
        m_0_high=np.nan if high is None else high.transformation.m_0_plan,
        m_0_low=low.m_0_plan,
        approximation_internal=approximation,
        single_paper=_rms(means.used["standard_error_paper"]),
        mean_paper=_rms(new["standard_error_paper"]),
        mean_total=_rms(new.get("standard_error_total", np.nan)),
        single_internal=means.internal_single,
        mean_internal=_rms(new["standard_error_internal"]),
        control_rms=_total_rms(points[points["role"] == "control"]),
        check_rms=_total_rms(points[points["role"] == "check"]),
        n_points=len(points),
        n_new=int(by_role.get("new", 0)),
        n_control=int(by_role.get("control", 0)),
        n_check=int(by_role.get("check", 0)),
        n_models_high=0 if high is None else len(high.transformation.models),
        n_models_low=len(low.models),
        n_failed=len(failures),
    )


def _rms(values):
    values = np.atleast_1d(np.asarray(values, dtype=float))
    values = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(values**2))) if len(values) else np.nan


def _total_rms(points):
    return _rms(np.hypot(points["difference_easting"], points["difference_northing"]))
