"""Whether points with given coordinates agree with the claimed figure."""

import numpy as np

from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings.kinds import finding
from einschalt.pipeline.assessment.known_points import (
    contradicting_points,
    few_contradicting_points,
    lone_contradiction,
)
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

FEWEST_POINTS = 4
# of the root mean square: a smaller one explains little
LEAST_SHARE_OF_SHIFT = 0.5


def check_points_beyond_claim(examined):
    """Differences at check points that are larger than the claimed figure."""
    known = examined.known_check
    if not known.are_beyond:
        return None
    miss = np.hypot(*known.differences.T)
    few = few_contradicting_points(examined)
    is_other = ~np.isin(known.point_ids, few)
    compared = _compared("check points", known)
    compared["facts"] |= {
        "median": float(np.nanmedian(miss)),
        "largest": float(np.nanmax(miss[~is_other] if len(few) else miss)),
        "n_far": len(few),  # that contradict the claim each by itself, others do not
    }
    return finding(
        "check_points_beyond_claim",
        names=known.point_ids[np.lexsort((-miss, is_other))],
        remedy="check_far_points" if len(few) else "trust_check_points",
        **compared,
    )


def lone_wrong_check_point(examined):
    """A single check point that makes the differences of all of them too large."""
    others = lone_contradiction(examined)
    if others is None:
        return None
    known, (name,) = examined.known_check, contradicting_points(examined)
    miss = float(np.hypot(*known.differences[known.point_ids == name][0]))
    return finding(
        "lone_wrong_check_point",
        names=(name,),
        statistic="difference at a check point",
        observed=miss,
        expected=known.claimed,
        remedy="check_lone_point",
        facts={
            "largest": miss,
            "n_points": known.count,
            "rms": known.rms,
            "n_others": others.count,
            "rms_of_others": others.rms,
            "claimed": known.claimed,
        },
    )


def check_points_better_than_claim(examined):
    """Differences at check points that are smaller than the claimed figure."""
    known = examined.known_check
    if not known.are_too_small:
        return None
    return finding(
        "check_points_better_than_claim",
        remedy="give_smaller_errors",
        **_compared("check points", known),
    )


def control_points_beyond_claim(examined):
    """Control points that the densified coordinates miss by more than is claimed."""
    known = examined.known_control
    if not known.are_beyond:
        return None
    miss = np.hypot(*known.differences.T)
    is_stated = np.isfinite(examined.figures.mean_total)
    return finding(
        "control_points_beyond_claim",
        names=known.point_ids[np.argsort(-miss, kind="stable")],
        remedy="look_for_wrong_control" if is_stated else "state_control_errors",
        **_compared("control points", known),
    )


def _compared(title, known):
    """What all comparisons with the claim have to say."""
    rms, claimed, ratio = known.rms, known.claimed, float(known.ratio)
    return {
        "statistic": f"RMS of the differences at {title}",
        "observed": rms,
        "expected": claimed,
        "probability": known.p_value,
        "facts": {
            "n_points": known.count,
            "rms": rms,
            "claimed": claimed,
            "ratio": ratio,
        },
    }


def shifted_block(examined):
    """Differences at known points with a mean that chance does not explain: drift."""
    by_role = {"check": examined.known_check, "control": examined.known_control}
    for role, known in by_role.items():
        if known.count < FEWEST_POINTS:
            continue
        shift = known.differences.mean(axis=0)
        is_large = np.hypot(*shift) > LEAST_SHARE_OF_SHIFT * known.rms
        if is_large and known.shift_p_value <= FINDING_SIGNIFICANCE:
            return _shifted(role, known, shift)
    return None


def _shifted(role, known, shift):
    easting, northing = map(float, shift)
    facts = {"n_points": known.count, "easting": easting, "northing": northing}
    return finding(
        "shifted_block",
        # within what is claimed it spoils nothing
        gravity=Gravity.GRAVE if known.are_beyond else Gravity.WARNING,
        statistic=f"mean difference at {role} points",
        observed=np.hypot(*shift),
        expected=0.0,
        probability=known.shift_p_value,
        remedy="look_at_reference_system",
        facts={"role": role, **facts},
    )


TWO_STEP = SIMULTANEOUS = (
    lone_wrong_check_point,
    check_points_beyond_claim,
    check_points_better_than_claim,
    control_points_beyond_claim,
    shifted_block,
)
