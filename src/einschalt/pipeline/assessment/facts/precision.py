"""The figures of precision of the new points, each way with what they rest on."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from einschalt.pipeline.densification.simultaneous import unknown_error
from einschalt.stages.error_propagation.error_model import (
    APPROXIMATE,
    errors_are_stated,
)


class Carried(StrEnum):
    """Which errors are carried to the points."""

    MEASUREMENTS = "control and measurements"
    ORIENTATIONS = "and those of the orientations by y-parallaxes"
    IMAGES = "image points through relative orientation"
    APPROXIMATIONS = "errors of approximate points and of the low flight"


class Shared(StrEnum):
    """Why the paper's figure is too small: what it takes to be independent."""

    HIGH_FLIGHT = "the transformation of the high flight"
    MODEL_CONTROL = "what a model lacks on its control points"
    NEIGHBOURS_STATED = "errors of given neighbouring points, as they were stated"
    NEIGHBOURS_GIVEN = "errors of given neighbouring points, of unknown size"
    GROUPS_UNTOLD = "shifts of groups of given points, which no residual shows"


class Unstated(StrEnum):
    """Why a simultaneous adjustment gives no standard errors."""

    MOVED = "points were moved by the distribution of residuals"


@dataclass(frozen=True)
class Figures:
    """Propagated, after the paper, and internal; TOTAL, RMS [m], NaN: not known."""

    total: float
    paper: float
    internal: float


@dataclass(frozen=True)
class HeightFacts:
    """How good the heights of the new points are."""

    total: float  # standard error, RMS [m]; NaN where it is not known
    # of all flights; otherwise measured heights have the errors that the differences of
    # the models show
    is_from_images: bool


@dataclass(frozen=True)
class TwoStepPrecision:
    """Precision of the new points in two steps."""

    # of one value, and of the mean of the coverages
    single: Figures
    mean: Figures
    n_new: int
    n_coverages: int
    coverage_mean: str  # of the settings
    carried: Carried | None  # None where nothing was propagated
    shared: Shared
    heights: HeightFacts | None  # None where points have no heights


@dataclass(frozen=True)
class Comparison:
    """How far the two ways are apart; RMS and largest TOTAL [m]."""

    rms: float
    largest: float
    worst: str  # name of the point with the largest difference


@dataclass(frozen=True)
class SimultaneousPrecision:
    """Precision of the new points in one adjustment, and in two steps beside it."""

    total: float  # propagated, TOTAL, RMS [m]
    two_steps: Figures | None  # None where the two steps are not possible
    impossible: str  # why they are not; empty where they are
    # whether they hold control that the adjustment set aside, which spoils them
    two_steps_keep_set_aside: bool
    comparison: Comparison | None  # None where no point was computed both ways
    has_high_flight: bool  # the two steps' approximate coordinates come from it
    n_new: int
    n_coverages: int
    s_0: float
    redundancy: int
    is_oriented: bool  # whether errors of orientations are taken into account
    # groups of observations whose errors were estimated, and their sizes per coordinate
    # [m]; None where all were taken as given
    estimated: tuple[tuple[str, float], ...] | None
    heights: HeightFacts | None
    # measured heights of each flight, as the residuals show their errors [m]
    height_errors: tuple[tuple[str, float], ...]
    n_centres: int  # photographs whose projection centres tie the models
    unstated: str  # why no standard errors are given; empty where they are


def two_step_precision(examined) -> TwoStepPrecision:
    """Collect the figures of the two steps."""
    figures = examined.figures
    heights = _heights(examined) if "height" in examined.points else None
    return TwoStepPrecision(
        single=Figures(np.nan, figures.single_paper, figures.single_internal),
        mean=_mean_figures(figures),
        n_new=figures.n_new,
        n_coverages=examined.block.low_flight.n_coverages,
        coverage_mean=examined.settings.coverage_mean,
        carried=_carried(examined),
        shared=_shared(examined),
        heights=heights,
    )


def _mean_figures(figures):
    return Figures(figures.mean_total, figures.mean_paper, figures.mean_internal)


def _carried(examined):
    if not np.isfinite(examined.figures.mean_total):
        return None
    if any(flight.has_images for flight in examined.block.flights.values()):
        return Carried.IMAGES
    parts = {} if examined.errors is None else examined.errors.parts
    if APPROXIMATE in parts:
        return Carried.APPROXIMATIONS
    return Carried.ORIENTATIONS if "orientation" in parts else Carried.MEASUREMENTS


def _shared(examined):
    block = examined.block
    if examined.has_untold_groups:
        return Shared.GROUPS_UNTOLD
    if block.high_flight is not None:
        return Shared.HIGH_FLIGHT
    if np.isfinite(examined.figures.mean_total):
        is_stated = errors_are_stated(block)
        return Shared.NEIGHBOURS_STATED if is_stated else Shared.MODEL_CONTROL
    return Shared.NEIGHBOURS_GIVEN


def _heights(examined):
    points = examined.points
    is_new = points["role"] == "new"
    total = np.nan
    if "standard_error_height" in points and is_new.any():
        total = np.sqrt(np.mean(points.loc[is_new, "standard_error_height"] ** 2))
    flights = examined.block.flights.values()
    return HeightFacts(float(total), all(flight.has_images for flight in flights))


def simultaneous_precision(examined) -> SimultaneousPrecision:
    """Collect the figures of one adjustment, and of the two steps beside it."""
    adjusted, figures = examined.adjustment, examined.figures
    beside = examined.two_step
    is_spatial = adjusted.tables.is_spatial
    return SimultaneousPrecision(
        total=figures.mean_total,
        two_steps=_mean_figures(beside.figures) if beside.is_possible else None,
        impossible="" if beside.is_possible else beside.solution.reason,
        two_steps_keep_set_aside=examined.two_steps_keep_set_aside,
        comparison=_comparison(examined.points),
        has_high_flight=examined.block.high_flight is not None,
        n_new=figures.n_new,
        n_coverages=examined.block.low_flight.n_coverages,
        s_0=float(adjusted.s_0),
        redundancy=int(adjusted.redundancy),
        is_oriented=getattr(adjusted.tables.observations, "orientation", None)
        is not None,
        estimated=_estimated(examined),
        heights=_heights(examined) if is_spatial else None,
        height_errors=_height_errors(adjusted) if is_spatial else (),
        n_centres=len(adjusted.centres) if is_spatial else 0,
        unstated=_unstated(examined),
    )


def _comparison(points):
    apart = np.hypot(
        points["easting"] - points["two_step_easting"],
        points["northing"] - points["two_step_northing"],
    )
    apart = apart[apart.notna()]
    if apart.empty:
        return None
    worst = points.loc[apart.idxmax(), "point_id"]
    rms = float(np.sqrt(np.mean(apart**2)))
    return Comparison(rms, float(apart.max()), worst)


def _estimated(examined):
    """Groups whose errors were estimated, with their sizes."""
    if examined.settings.variance_components == "given":
        return None
    components = examined.adjustment.components
    shown = components[components["is_estimated"]]
    sizes = shown["standard_error_m"].astype(float)
    return tuple(zip(shown["group"], sizes, strict=True))


def _height_errors(adjusted):
    sizes = adjusted.components.set_index("group")["standard_error_m"]
    groups = {name: f"{name}, height" for name in adjusted.tables.flights}
    # a flight all of whose models were left out has no errors
    known = {name: group for name, group in groups.items() if group in sizes}
    return tuple((name, float(sizes[group])) for name, group in known.items())


def _unstated(examined):
    figures = examined.figures
    if not (np.isnan(figures.mean_total) and figures.n_new):
        return ""
    tables = examined.adjustment.tables
    why = unknown_error(examined.block, examined.orientation_errors, tables)
    return why or Unstated.MOVED
