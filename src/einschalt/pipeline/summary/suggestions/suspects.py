"""Suggestions on gross errors and on wrong sizes of errors, from tests of residuals."""

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.typesetting import (
    count,
    length,
    names,
    number,
    round_by_error,
)
from einschalt.pipeline.block.repeated_pointings import spread_of_points
from einschalt.pipeline.summary.suggestion import SIGNIFICANCE, Suggestion

# a standard error of variance components is itself uncertain, and a difference of a
# few per cent changes nothing
LARGE_DIFFERENCE = 4.0
MIN_REPORTED_RATIO = 1.10
GROSS = 3.0
OBSERVATION = ["flight", "coverage", "model_id", "point_id"]


def suspect_observations(result):
    """Observations with residuals that chance does not explain: gross errors."""
    residuals = _not_yet_named(result)
    p_value = residuals["p_value"].to_numpy(dtype=float)
    # a suspect of one model in a thousand is chance: the worst must stand out of all
    if not np.isfinite(p_value).any():
        return None
    if np.nanmin(p_value) * np.isfinite(p_value).sum() > SIGNIFICANCE:
        return None
    suspects = residuals[residuals["is_suspect"]].sort_values("p_value")
    if suspects.empty:
        return None
    miss = np.hypot(suspects["residual_easting"], suspects["residual_northing"])
    shown = names(_observations(suspects), 4)
    problem = (
        f"{count(len(suspects), 'residual')} of up to {length(miss.max())} that chance "
        f"does not explain, worst first (flight, coverage, model, point): {shown}"
    )
    is_low = suspects["flight"] == "low_flight"
    if result.settings.outliers == "keep" and is_low.any():
        return Suggestion(problem, 'Measure them again, or set outliers = "snoop"')
    return Suggestion(problem, "Measure them again")


def gross_measurements(result):
    """Measurements that contradict the other models of their flight."""
    found = result.gross_measurements.sort_values("p_value", kind="stable")
    if found.empty:
        return None
    miss = np.hypot(found["residual_easting"], found["residual_northing"])
    return Suggestion(
        f"{count(len(found), 'measurement')}, off by up to {length(miss.max())} from "
        "what the other models of the flight say, took no part, worst first (flight, "
        f"coverage, model, point): {names(_observations(found), 4)}",
        "Measure them again; all stand in gross_measurements.csv",
    )


def _not_yet_named(result):
    """Residuals of all but the gross measurements."""
    residuals, found = result.residuals, result.gross_measurements
    if found.empty:
        return residuals
    rows = pd.MultiIndex.from_frame(residuals[OBSERVATION])
    return residuals[~rows.isin(pd.MultiIndex.from_frame(found[OBSERVATION]))]


def _observations(rows):
    columns = (rows[name] for name in OBSERVATION)
    return [
        f"{flight.removesuffix('_flight')} {coverage} {shortened(model)} {point}"
        for flight, coverage, model, point in zip(*columns, strict=True)
    ]


def coverages_that_differ(result):
    """Points whose coverages differ by more than chance explains: gross errors."""
    suspects = result.coverages[result.coverages["is_suspect"]]
    if suspects.empty:
        return None
    p_value = result.coverages["p_value"].to_numpy(dtype=float)
    # one good point in a thousand is a suspect: the worst must stand out of all
    is_tested = np.isfinite(p_value).any()
    if is_tested and np.nanmin(p_value) * result.screening.n_tested > SIGNIFICANCE:
        return None
    miss = np.hypot(suspects["difference_easting"], suspects["difference_northing"])
    order = miss.sort_values(ascending=False, kind="stable").index
    points = suspects["point_id"].loc[order].drop_duplicates()
    return Suggestion(
        f"{count(len(points), 'point')} with coverages that differ by up to "
        f"{length(miss.max())}, more than they may: {names(points)}",
        "Measure them again; the values of their coverages stand in coverages.csv",
    )


def control_that_contradicts(result):
    """Control points that the others miss by more than chance explains."""
    table = result.control_left_out
    suspects = table[table["is_suspect"].astype(bool)].sort_values("p_value")
    if suspects.empty:
        return None
    miss = np.hypot(suspects["difference_easting"], suspects["difference_northing"])
    return Suggestion(
        f"{count(len(suspects), 'control point')} missed by up to {length(miss.max())} "
        "where predicted without themselves, more than chance explains, worst first: "
        f"{names(suspects['point_id'])}",
        "Check the first one and its measurements: a wrong one spoils the others",
    )


def control_against_block(result):
    """Control points that the simultaneous adjustment of all models contradicts."""
    if not has_control_against_block(result):
        return None
    control = result.simultaneous.control
    suspects = control[control["is_suspect"]].sort_values("p_value", kind="stable")
    size = np.hypot(suspects["strain_easting"], suspects["strain_northing"])
    problem = (
        f"{count(len(suspects), 'control point')} {{}} the block, by up to "
        f"{length(size.max())}: {names(suspects['point_id'])}"
    )
    if suspects["is_set_aside"].any():
        return Suggestion(
            problem.format("set aside, for contradicting"),
            "Check their coordinates and names",
        )
    verb = "contradicts" if len(suspects) == 1 else "contradict"
    return Suggestion(
        f"{problem.format(f'that {verb}')}. Kept, they make the new points near them "
        "worse than claimed",
        'Check their coordinates and names, or set outliers = "snoop"',
    )


def has_control_against_block(result):
    """Whether the simultaneous adjustment contradicts single control points."""
    adjusted = result.simultaneous
    return adjusted is not None and adjusted.control["is_suspect"].any()


def wrong_measuring_errors(result):
    """Flights whose m_g, as it was given, is not that of the measurements."""
    if result.components is None:
        return None
    wrong = [
        (flight, component)
        for flight, component in (
            ("high flight", result.components.high_flight),
            ("low flight", result.components.low_flight),
        )
        if is_wrong(component)
    ]
    if not wrong:
        return None
    problems = [
        f"m_g_um of the {flight} is given as {number(component.given)}, but the "
        f"measurements show {shown_component(component)}"
        for flight, component in wrong
    ]
    if any(c.estimated > GROSS * c.given for _, c in wrong):
        return Suggestion("; ".join(problems), "Look for gross errors")
    return Suggestion(
        "; ".join(problems), "Give that figure, if no gross error made it"
    )


def settings_that_scatter(result):
    """Repeated settings of a point that lie farther apart than m_g allows."""
    flights = result.repeated_settings
    larger = flights[flights["is_larger"]]
    if larger.empty:
        return scattered_points(result)
    said = "; ".join(
        f"m_g_um of the {flight.flight.replace('_', ' ')} is given as "
        f"{number(flight.m_g_um)}, but repeated settings scatter by "
        f"{shown_settings(flight)}"
        for flight in larger.itertuples()
    )
    return Suggestion(said, "Give at least that figure, if no gross error made it")


def scattered_points(result):
    """Single points whose settings lie farther apart than m_g allows."""
    points = spread_of_points(result)
    n_tested = points["p_value"].notna().sum()
    found = points[points["p_value"] * n_tested < SIGNIFICANCE].sort_values("p_value")
    if found.empty:
        return None
    return Suggestion(
        f"{count(len(found), 'point')} with settings up to "
        f"{number(found['spread_um'].max())} µm apart in the image (total, one "
        "setting), which chance does not explain, worst first (flight, coverage, "
        f"model, point): {names(_observations(found), 4)}",
        "Set them again: their mean is wrong",
    )


def shown_settings(flight):
    """Write m_g from repeated settings with its standard error."""
    value, error = round_by_error(flight.m_g_settings_um, flight.standard_error_um)
    return f"{value} ± {error}"


def is_wrong(component):
    """Whether an m_g as it was given is far from the one that was estimated."""
    difference = abs(component.estimated - component.given)
    is_significant = difference > LARGE_DIFFERENCE * component.standard_error
    return is_significant and difference > (MIN_REPORTED_RATIO - 1.0) * component.given


def shown_component(component):
    """Write an estimated m_g with its standard error."""
    value, error = round_by_error(component.estimated, component.standard_error)
    return f"{value} ± {error}"
