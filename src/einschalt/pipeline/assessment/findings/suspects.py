"""Gross errors and wrong sizes of errors, from tests of residuals and differences."""

import numpy as np

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.units import METRES_PER_UM
from einschalt.pipeline.assessment.evidence.control.patterns import wrong_control
from einschalt.pipeline.assessment.evidence.control.suspect_control import (
    are_alike_in_height,
    are_many_in_height,
    are_many_set_aside,
    are_set_aside_alike,
)
from einschalt.pipeline.assessment.evidence.control.suspects import (
    LARGE_SPREAD,
    coverages_stand_out,
    residuals_not_yet_named,
    residuals_stand_out,
)
from einschalt.pipeline.assessment.evidence.repeated_settings import spread_of_points
from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings.kinds import (
    OBSERVATION,
    finding,
    first_names,
    row_keys,
)
from einschalt.theory.adjustment.multiple_testing import bonferroni
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

# an m_g this many times the given one is no measuring error, nor is the given one if it
# is this many times what shows
GROSS = 3.0
FLIGHTS = ("high_flight", "low_flight")


def suspect_observations(examined):
    """Observations with residuals that chance does not explain: gross errors."""
    residuals = residuals_not_yet_named(examined)
    p_value = residuals["p_value"].to_numpy(dtype=float)
    # a suspect of one model in a thousand is chance: the worst must stand out of all
    if not residuals_stand_out(examined):
        return None
    suspects = residuals[residuals["is_suspect"]].sort_values("p_value")
    if suspects.empty:
        return None
    return finding(
        "suspect_observations",
        statistic="residual",
        probability=np.nanmin(bonferroni(p_value)),
        remedy=_remedy_of(suspects, examined),
        **_observations(suspects, largest_residual(suspects)),
    )


def _remedy_of(suspects, examined):
    """What to do about suspects, of which data snooping may have excluded all."""
    outliers, flights = examined.settings.outliers, suspects["flight"]
    if outliers == "snoop" and flights.isin(examined.snooped_flights).all():
        return "measure_excluded_again"
    can_snoop = outliers == "keep" and (flights == "low_flight").any()
    return "measure_again_or_snoop" if can_snoop else "measure_again"


def gross_measurements(two_step):
    """Measurements that contradict the other models of their flight."""
    found = two_step.gross_measurements.sort_values("p_value", kind="stable")
    if found.empty:
        return None
    observed = _observations(found, largest_residual(found))
    undecided = undecided_points(two_step, found)
    observed["facts"] |= {"n_undecided": len(undecided), "undecided": undecided}
    return finding(
        "gross_measurements",
        statistic="residual",
        probability=found["p_value"].iloc[0],
        remedy="measure_rejected_again",
        **observed,
    )


def undecided_points(two_step, found):
    """Points of which several measurements contradict each other, and all are found."""
    names = []
    for flight, rows in found.groupby("flight", sort=False):
        measured = two_step.model_points[flight]["point_id"].value_counts()
        out = rows["point_id"].value_counts()
        is_all = (out > 1) & (out == measured.reindex(out.index))
        names += list(out.index[is_all])
    return first_names(names)


def _observations(rows, largest):
    """Names and facts of observations, the worst first."""
    return {
        "names": rows["point_id"],
        "observed": largest,
        "facts": {
            "n_observations": len(rows),
            "observations": row_keys(rows, OBSERVATION),
            "largest": largest,
        },
    }


def _largest(rows, what):
    """Largest total of two columns [m]."""
    return float(np.hypot(rows[f"{what}_easting"], rows[f"{what}_northing"]).max())


def largest_residual(rows):
    """Largest residual, with that of the height where it has one [m]."""
    return float(_lengths(rows, "residual").max())


def _lengths(rows, what):
    """Lengths of what is given by axes, of two or of three [m]."""
    names = [f"{what}_{axis}" for axis in ("easting", "northing", "height")]
    axes = values_of(rows, [name for name in names if name in rows])
    # control may be known in plan alone
    in_height = np.nan_to_num(axes[:, 2:])
    return np.sqrt(np.sum(axes[:, :2] ** 2, axis=1) + np.sum(in_height**2, axis=1))


def coverages_that_differ(examined):
    """Points whose coverages differ by more than chance explains: gross errors."""
    suspects = examined.coverages[examined.coverages["is_suspect"]]
    if suspects.empty:
        return None
    p_value = examined.coverages["p_value"].to_numpy(dtype=float)
    n_tested = examined.screening.n_tested
    # one good point in a thousand is a suspect: the worst must stand out of all
    is_tested = np.isfinite(p_value).any()
    if not coverages_stand_out(examined):
        return None
    miss = _lengths(suspects, "difference")
    order = np.argsort(-miss, kind="stable")
    points = suspects["point_id"].iloc[order].drop_duplicates()
    smallest = np.nanmin(bonferroni(p_value, n_tested)) if is_tested else np.nan
    return finding(
        "coverages_that_differ",
        names=points,
        statistic="difference of a coverage",
        observed=miss.max(),
        probability=float(smallest),
        remedy="measure_again_see_coverages",
        facts={"n_points": len(points), "largest": float(miss.max())},
    )


def points_that_differ(examined):
    """Points whose models or coverages lie far apart: gross errors."""
    points = examined.points
    is_large = examined.far_apart
    if not is_large.any():
        return None
    usual = float(points["spread_total"].median())
    far = points.loc[is_large].sort_values("spread_total", ascending=False)
    largest = float(far["spread_total"].iloc[0])
    return finding(
        "points_that_differ",
        names=far["point_id"],
        statistic="spread_total",
        observed=largest,
        expected=usual,
        remedy="look_for_gross_errors_and_exchanged_names",
        facts={
            "n_points": len(far),
            "times_usual": LARGE_SPREAD,
            "median": usual,
            "largest": largest,
        },
    )


def control_that_contradicts(two_step):
    """Control points that the others miss by more than chance explains."""
    table = two_step.control_left_out
    suspects = table[table["is_suspect"].astype(bool)].sort_values("p_value")
    if suspects.empty:
        return None
    largest = _largest(suspects, "difference")
    names = suspects["point_id"].to_numpy(dtype=object)
    # the one that explains most: a wrong one moves what is predicted with it as well
    is_wrong = np.isin(names, wrong_control(two_step.control_patterns))
    return finding(
        "control_that_contradicts",
        names=names[np.argsort(~is_wrong, kind="stable")],
        statistic="difference at a control point that was left out",
        observed=largest,
        probability=np.nanmin(bonferroni(table["p_value"])),
        remedy="check_worst_control",
        facts={"n_points": len(suspects), "largest": largest},
    )


def control_against_block(adjusted):
    """Control points that the simultaneous adjustment of all models contradicts."""
    control = adjusted.adjustment.control
    suspects = control[control["is_suspect"]].sort_values("p_value", kind="stable")
    if suspects.empty:
        return None
    largest = float(_lengths(suspects, "strain").max())
    facts = {"n_points": len(suspects), "largest": largest}
    told = {
        "names": suspects["point_id"],
        "statistic": "strain of a control point",
        "observed": largest,
        "probability": suspects["p_value"].iloc[0],
    }
    if not suspects["is_set_aside"].any():
        remedy = "check_control_or_snoop"
        return finding("control_against_block", remedy=remedy, facts=facts, **told)
    may_be_right = adjusted.set_aside_may_be_right
    return finding(
        "control_set_aside",
        # if the others are wrong, so is the whole block
        gravity=Gravity.GRAVE if may_be_right else Gravity.WARNING,
        remedy="check_all_control" if may_be_right else "check_control",
        facts={
            **facts,
            "n_control": len(control),
            "are_alike": may_be_right
            and (are_set_aside_alike(control) or are_alike_in_height(control)),
            "are_many": may_be_right
            and (are_many_set_aside(control) or are_many_in_height(control)),
        },
        **told,
    )


def wrong_measuring_errors(examined):
    """Flights whose m_g, as it was given, is not that of the measurements."""
    if examined.components is None:
        return None
    components = {name: getattr(examined.components, name) for name in FLIGHTS}
    wrong = {name: c for name, c in components.items() if c.is_contradicted}
    if not wrong:
        return None
    remedy = "give_that_m_g"
    if any(c.estimated > GROSS * c.given for c in wrong.values()):
        remedy = "look_for_gross_errors"
    elif any(GROSS * c.estimated < c.given for c in wrong.values()):
        remedy = "check_scale_and_independence"
    first = next(iter(wrong.values()))
    return finding(
        "wrong_measuring_errors",
        names=wrong,
        statistic="m_g of a flight",
        observed=float(first.estimated) * METRES_PER_UM,
        expected=float(first.given) * METRES_PER_UM,
        remedy=remedy,
        facts={"flights": tuple(c.facts_of(name) for name, c in wrong.items())},
    )


def settings_that_scatter(examined):
    """Flights whose repeated settings lie farther apart than m_g allows."""
    flights = examined.repeated_settings
    if not flights["is_larger"].any():
        return None
    larger = list(flights[flights["is_larger"]].itertuples())
    return finding(
        "settings_that_scatter",
        names=[flight.flight for flight in larger],
        statistic="m_g of a setting",
        observed=float(larger[0].m_g_settings_um) * METRES_PER_UM,
        expected=float(larger[0].m_g_um) * METRES_PER_UM,
        probability=larger[0].p_value,
        remedy="give_at_least_that_m_g",
        facts={"flights": tuple(map(_settings_of, larger))},
    )


def _settings_of(flight):
    return {
        "flight": str(flight.flight),
        "given_um": float(flight.m_g_um),
        "estimated_um": float(flight.m_g_settings_um),
        "standard_error_um": float(flight.standard_error_um),
    }


def scattered_points(examined):
    """Single points whose settings lie farther apart than m_g allows."""
    if examined.repeated_settings["is_larger"].any():
        return None  # m_g is too small for all of them
    points = spread_of_points(examined)
    p_value = bonferroni(points["p_value"].to_numpy(dtype=float))
    found = points[p_value < FINDING_SIGNIFICANCE].sort_values("p_value")
    if found.empty:
        return None
    widest = float(found["spread_um"].max())
    return finding(
        "scattered_points",
        names=found["point_id"],
        statistic="standard deviation of a setting",
        observed=widest * METRES_PER_UM,
        probability=np.nanmin(p_value),
        remedy="set_again",
        facts={
            "n_points": len(found),
            "observations": row_keys(found, OBSERVATION),
            "widest_um": widest,
        },
    )


FOR_BOTH = (
    wrong_measuring_errors,
    settings_that_scatter,
    scattered_points,
    suspect_observations,
    coverages_that_differ,
    points_that_differ,
)
TWO_STEP = (control_that_contradicts, gross_measurements, *FOR_BOTH)
SIMULTANEOUS = (control_against_block, *FOR_BOTH)
