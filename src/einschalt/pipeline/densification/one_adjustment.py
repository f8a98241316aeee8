"""All models of all flights in one adjustment, with the two steps beside it."""

from dataclasses import dataclass
from operator import attrgetter

import numpy as np
import pandas as pd

from einschalt.foundations.errors import GeometryError
from einschalt.foundations.frame_columns import MODEL
from einschalt.foundations.language import mark_each
from einschalt.pipeline.densification.figures import adjusted_figures
from einschalt.pipeline.densification.gross_errors import (
    columns_of_gross,
    no_gross_measurements,
)
from einschalt.pipeline.densification.result_tables import (
    failures_of,
    of_orientations,
    with_roles,
)
from einschalt.pipeline.densification.simultaneous import (
    DIFFERENCES,
    STANDARD_ERRORS,
    adjust_flights,
    bend_for_adjustment,
    distribute_adjusted,
    searched_flights,
    unknown_error,
)
from einschalt.pipeline.densification.solution import Solution
from einschalt.pipeline.densification.two_steps import (
    TwoStepSolution,
    WithoutTwoSteps,
    solve_in_two_steps,
)
from einschalt.pipeline.progress import Stage
from einschalt.stages.curved_earth import bend_flights
from einschalt.stages.error_propagation.given_points import PLAN
from einschalt.stages.error_propagation.shared_error import (
    shared_error_of,
    with_shared_columns,
)
from einschalt.stages.simultaneous.adjustment import BlockAdjustment
from einschalt.stages.stage2_relative_orientation import relative_orientation
from einschalt.theory.block_adjustment.gross_errors import NORMS

# standard errors that an adjustment has from two steps
OF_TWO_STEPS = ("standard_error_paper", "standard_error_internal")
NOTHING_HELD = mark_each(
    {
        "high_flight": "the adjustment holds no model of the high flight.",
        "low_flight": "the adjustment holds no model of the low flight.",
    }
)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class SimultaneousSolution(Solution):
    """Points of a block from one adjustment of all its models."""

    adjustment: BlockAdjustment  # where points, models and residuals are from
    # in two steps: what the adjustment holds, and the whole block as it is set
    two_step: TwoStepSolution | WithoutTwoSteps
    all_in_two_steps: TwoStepSolution | WithoutTwoSteps

    single_values = property(attrgetter("two_step.single_values"))
    approximations = property(attrgetter("two_step.approximations"))
    coverages = property(attrgetter("two_step.coverages"))
    iterations = property(attrgetter("two_step.iterations"))


def orient_flights(block, settings):
    """Orient the models of all flights, and bend them as the map is bent: stage 2."""
    flights = {
        name: relative_orientation(flight, outliers=settings.outliers)
        for name, flight in block.flights.items()
    }
    if settings.earth_curvature != "treated":
        return flights
    bend = bend_flights if settings.method == "two_step" else bend_for_adjustment
    return bend(block, flights)


def solve_in_one_adjustment(
    block, settings, flights, report_progress, **known
) -> SimultaneousSolution:
    """Densify a block in one adjustment of all models and the control.

    ``flights`` after stage 2; ``known`` is what the two steps beside it may take. A
    GeometryError where nothing of the block can be determined.
    """
    gross = known.get("gross")
    searched = searched_flights(block, flights, gross and gross.searched)
    known["searched"] = searched
    in_two_steps = _beside(block, settings, flights, report_progress, **known)
    report_progress(Stage.SIMULTANEOUS_ADJUSTMENT)
    return adjust_beside(in_two_steps, block, settings, flights, searched)


def adjust_beside(
    in_two_steps, block, settings, flights, searched=None, adjusted=None
) -> SimultaneousSolution:
    """Adjust a block whose two steps are computed already.

    ``searched`` are SearchedFlights that may be these, ``adjusted`` is the
    BlockAdjustment of these flights if it is known. A GeometryError where nothing of
    the block can be determined.
    """
    searched = searched_flights(block, flights, searched)
    if adjusted is None:
        adjusted = adjust_flights(block, settings, flights, searched)
    two_step = _of_what_it_holds(in_two_steps, adjusted, settings, searched)
    points = _point_columns(block, flights, adjusted, two_step)
    if settings.outliers != "keep":
        points = points.assign(is_set_aside=_are_set_aside(adjusted, points))
    points = with_roles(points, block.control_points)
    points = distribute_adjusted(block, settings, points)
    shared_error = shared_error_of(block, "simultaneous")
    points = with_shared_columns(points, shared_error)
    parts = [(name, oriented.failures) for name, oriented in flights.items()]
    failures = failures_of([*parts, ("", adjusted.failures)])
    return SimultaneousSolution(
        block=block,
        settings=settings,
        points=points,
        models=adjusted.models,
        residuals=adjusted.residuals,
        failures=failures,
        gross_measurements=_taken_out(adjusted, settings),
        figures=adjusted_figures(adjusted, points, failures, shared_error),
        adjustment=adjusted,
        two_step=two_step,
        all_in_two_steps=in_two_steps,
        **of_orientations(flights),
    )


def _point_columns(block, flights, adjusted, two_step):
    """Adjusted points with the columns of every densified point.

    A point is suspect with a residual or with given coordinates that contradict.
    ``standard_error_paper`` and ``standard_error_internal`` are those of two steps,
    ``two_step_easting``, ``two_step_northing`` its coordinates. Standard errors are
    left out where the size of a source of error is not known.
    """
    points = adjusted.points.drop(columns=["role", *DIFFERENCES], errors="ignore")
    errors = {name: oriented.errors for name, oriented in flights.items()}
    if unknown_error(block, errors, adjusted.tables):
        points = points.drop(columns=STANDARD_ERRORS, errors="ignore")
    place = points.columns.get_loc("n_models")
    for k, name in enumerate(OF_TWO_STEPS):
        points.insert(place + k, name, np.nan)
    points["is_suspect"] = points["point_id"].isin(_suspects(adjusted))
    return with_two_steps(points, two_step)


def with_two_steps(points, two_step):
    """Adjusted points with the columns that two steps give, which may not be possible.

    ``standard_error_paper``, ``standard_error_internal``, ``two_step_easting``,
    ``two_step_northing``: NaN for points that two steps do not have.
    """
    beside = _of_two_steps(points["point_id"], two_step)
    errors = {name: beside[name].to_numpy() for name in OF_TWO_STEPS}
    places = {f"two_step_{name}": beside[name].to_numpy() for name in PLAN}
    return points.assign(**errors, **places)


def _suspects(adjusted):
    tables = (adjusted.residuals, adjusted.control)
    return pd.concat([t.loc[t["is_suspect"], "point_id"] for t in tables]).unique()


def _of_two_steps(point_id, two_step):
    names = [*PLAN, *OF_TWO_STEPS]
    if not two_step.is_possible:
        return pd.DataFrame(np.nan, index=point_id, columns=names)
    return two_step.points.set_index("point_id")[names].reindex(point_id)


def _taken_out(adjusted, settings):
    """Measurements that data snooping took out of the adjustment, the worst first."""
    if settings.outliers != "snoop":  # named only, or of less weight
        return no_gross_measurements()
    residuals = adjusted.residuals
    out = residuals.loc[residuals["is_suspect"], columns_of_gross(residuals)]
    return out.sort_values("p_value", kind="stable").reset_index(drop=True)


def _are_set_aside(adjusted, points):
    control = adjusted.control
    names = control.loc[control["is_set_aside"], "point_id"]
    return points["point_id"].isin(names).to_numpy()


def _of_what_it_holds(in_two_steps, adjusted, settings, searched):
    """The two steps of the models and measurements that an adjustment holds.

    What a model does that was given up is in none of its points: it would draw the two
    steps beside them, and what is tested by these, as if it were. So would what a
    robust norm leaves of a gross error, which is more where a model alone bears it.
    """
    block, flights = searched.block, searched.flights
    lost = adjusted.failures[["flight", *MODEL]]
    has_less_weight = _has_gross_errors_of_less_weight(adjusted, flights, settings)
    if not (len(lost) or has_less_weight) or not in_two_steps.is_possible:
        return in_two_steps
    if has_less_weight:
        settings = settings.updated({"outliers": "snoop"})
        flights = _oriented_without_gross_errors(block, settings, flights)
        searched = searched_flights(block, flights, searched)
        if not adjusted.loses_no_others:
            also = _lost_without_gross_errors(searched, settings)
            lost = pd.concat([lost, also])
    held = {
        name: oriented.without_models(lost[lost["flight"] == name])
        if (lost["flight"] == name).any()
        else oriented
        for name, oriented in flights.items()
    }
    for name, oriented in held.items():
        if oriented.model_points.empty:
            return WithoutTwoSteps(block, held, NOTHING_HELD[name])
    known = {"before": in_two_steps, "searched": searched}
    return _beside(block, settings, held, lambda *_: None, **known)


def _lost_without_gross_errors(searched, settings):
    """Models that an adjustment without gross errors gives up: flight and name.

    A robust norm holds a model whatever contradicts it.
    """
    what = searched.block, settings, searched.flights, searched
    try:
        lost = adjust_flights(*what).failures
    except GeometryError:  # it holds nothing, and tells nothing of single models
        return pd.DataFrame(columns=["flight", *MODEL])
    return lost[["flight", *MODEL]]


def _has_gross_errors_of_less_weight(adjusted, flights, settings):
    """Whether data snooping refuses what a robust norm has only given less weight."""
    if settings.outliers not in NORMS:
        return False
    tables = [adjusted.residuals, *(each.residuals for each in flights.values())]
    return any(t["is_suspect"].any() for t in tables if "is_suspect" in t)


def _oriented_without_gross_errors(block, settings, flights):
    """The flights, those of photographs oriented anew; as they were if that fails."""
    has_images = {name: flight.has_images for name, flight in block.flights.items()}
    try:
        anew = orient_flights(block, settings) if any(has_images.values()) else flights
    except GeometryError:
        return flights
    return {name: anew[name] if has_images[name] else flights[name] for name in flights}


def _beside(block, settings, flights, report_progress, **known):
    """The two steps, whose points stand beside the adjusted ones."""
    # what is distributed in the end are the residuals of the adjustment
    plain = settings.model_copy(update={"residual_distribution": "none"})
    try:
        return solve_in_two_steps(block, plain, flights, report_progress, **known)
    except GeometryError as error:  # the summary says so, and gives the other way
        return WithoutTwoSteps(block, flights, str(error))
