"""What the standard errors of the new points show."""

import numpy as np

from einschalt.foundations.frame_columns import MODEL, PLAN
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.credibility import TOTAL, is_large_s_0
from einschalt.pipeline.assessment.evidence.control.displacements import LARGEST_S_0
from einschalt.pipeline.assessment.evidence.control.smaller_errors import (
    size_of_control,
)
from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings.kinds import finding, first_names
from einschalt.theory.adjustment.global_tests import ratio_p_value

LARGE = 3.0
MOSTLY = 0.5
# of the claimed figure: what the block's own pull must move the points by
LEAST_PULL = 0.5
# of stated errors over those that residuals show, and by how much it may be missed
UNITS, NEAR_A_UNIT = {"centimetres": 100.0, "millimetres": 1000.0}, 2.5


def imprecise_points(examined):
    """Points that spoil the figure of the block, and the models that they lie in."""
    new = examined.points[examined.points["role"] == "new"]
    if TOTAL in new:
        new = new[np.isfinite(new[TOTAL])]
    if TOTAL not in new or new.empty:
        return None
    error = new[TOTAL].to_numpy(dtype=float)
    median = float(np.median(error))
    is_large = error > LARGE * median
    if not is_large.any():
        return None
    worst_first = new["point_id"].to_numpy()[np.argsort(-error, kind="stable")]
    weak, largest = worst_first[: is_large.sum()], float(error.max())
    models = _models_of(examined, new["point_id"], weak)
    return finding(
        "imprecise_points",
        names=weak,
        statistic="standard error of a new point",
        observed=largest,
        expected=median,
        remedy="measure_more_control_there",
        facts={
            "n_points": len(weak),
            "times_usual": LARGE,
            "median": median,
            "largest": largest,
            "rms_of_others": _rms(error[~is_large]),
            "n_models": len(models),
            "models": first_names(models),
        },
    )


def _models_of(examined, new, weak):
    """Names of the low-flight models most of whose new points are weak."""
    table = examined.block.low_flight.model_table()
    table = table[is_among(table["point_id"], new)]
    is_weak = table["point_id"].isin(weak)
    share = is_weak.groupby([table[name] for name in MODEL], sort=False).mean()
    return share.index.get_level_values("model_id")[share > MOSTLY]


def block_that_shrinks(adjusted):
    """A simultaneous adjustment that control does not hold against its own pull."""
    adjustment = adjusted.adjustment
    if adjustment.displacements is None:
        return None
    is_new = (adjustment.points["role"] == "new").to_numpy()
    points = adjustment.points[is_new]
    moved = np.hypot(*adjustment.displacements.loc[is_new, PLAN].to_numpy().T)
    errors = points[[f"standard_error_{name}" for name in PLAN]]
    claimed = np.hypot(*errors.to_numpy().T)
    if not len(moved) or not _rms(moved) > LEAST_PULL * _rms(claimed):
        return None
    worst = points["point_id"].iloc[int(np.argmax(moved))]
    return finding(
        "block_that_shrinks",
        names=(str(worst),),
        statistic="displacement of the new points by the block's own pull, RMS",
        observed=_rms(moved),
        expected=0.0,
        remedy="give_control_on_the_far_side",
        facts={
            "moved": _rms(moved),
            "largest": float(moved.max()),
            "worst": str(worst),
            "ratio_to_claimed": _rms(moved) / _rms(claimed),
        },
    )


def adjustment_that_misfits(adjusted):
    """Residuals of the simultaneous adjustment that the given errors do not explain."""
    adjustment = adjusted.adjustment
    if not is_large_s_0(adjustment):
        return None
    s_0 = float(adjustment.s_0)
    is_grave = s_0 > LARGEST_S_0
    return finding(
        "adjustment_that_misfits",
        gravity=Gravity.GRAVE if is_grave else Gravity.WARNING,
        statistic="s_0 of the simultaneous adjustment",
        observed=s_0,
        expected=1.0,
        probability=ratio_p_value(s_0, adjustment.redundancy),
        remedy="look_for_names_control_and_units" if is_grave else "give_larger_errors",
        facts={"s_0": s_0, "redundancy": int(adjustment.redundancy)},
    )


def wrong_control_errors(examined):
    """Control whose standard errors are stated much larger than residuals show them."""
    found = size_of_control(examined)
    if found is None:
        return None
    ratio = found.given / found.estimated
    near = [k for k, n in UNITS.items() if 1.0 / NEAR_A_UNIT < ratio / n < NEAR_A_UNIT]
    unit = near[0] if near else ""
    return finding(
        "wrong_control_errors",
        statistic="standard error of control in plan",
        observed=found.estimated,
        expected=found.given,
        remedy="check_unit_of_control_errors" if unit else "give_that_standard_error",
        facts={
            "stated": found.given,
            "shown": found.estimated,
            "error_of_shown": found.standard_error,
            "unit": unit,
        },
    )


def deformed_models(adjusted):
    """Models that are deformed, which one adjustment of all accumulates."""
    if not adjusted.is_deformed:
        return None
    found = adjusted.deformation
    probabilities = [flight.p_value for flight in found.flights]
    return finding(
        "deformed_models",
        statistic="deformation of the models",
        observed=max(flight.size_edge for flight in found.flights),
        expected=0.0,
        probability=np.nanmin([1.0, *probabilities]),
        remedy="believe_the_two_steps",
        facts={
            "belief": found.belief.name.lower(),
            "check_rms_simultaneous": found.check_rms_simultaneous,
            "check_rms_two_steps": found.check_rms_two_steps,
        },
    )


def _rms(values):
    return float(np.sqrt(np.mean(values**2)))


TWO_STEP = (imprecise_points, wrong_control_errors)
SIMULTANEOUS = (
    imprecise_points,
    wrong_control_errors,
    block_that_shrinks,
    adjustment_that_misfits,
    deformed_models,
)
