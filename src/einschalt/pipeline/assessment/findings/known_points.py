"""Whether points with given coordinates agree with the claimed figure."""

import numpy as np

from einschalt.pipeline.assessment.finding import Finding, Gravity, Subject
from einschalt.pipeline.assessment.findings.row_keys import first_names
from einschalt.theory.adjustment.global_tests import (
    mean_differs_from_zero,
    mean_p_values,
)
from einschalt.theory.adjustment.multiple_testing import bonferroni
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

FEWEST_POINTS = 4
# of the root mean square: errors of neighbours are alike, so that the test of a shift
# alone would cry too often
LEAST_SHARE_OF_SHIFT = 0.5


def check_points_beyond_claim(examined):
    """Differences at check points that are larger than the claimed figure."""
    known = examined.known_check
    if not known.are_beyond:
        return None
    return Finding(
        "check_points_beyond_claim",
        Subject.BLOCK,
        Gravity.GRAVE,
        remedy="trust_check_points",
        **_compared("check points", known),
    )


def check_points_better_than_claim(examined):
    """Differences at check points that are smaller than the claimed figure."""
    known = examined.known_check
    if not known.are_too_small:
        return None
    return Finding(
        "check_points_better_than_claim",
        Subject.BLOCK,
        Gravity.NOTE,
        remedy="give_smaller_errors",
        **_compared("check points", known),
    )


def control_points_beyond_claim(examined):
    """Control points that the densified coordinates miss by more than is claimed."""
    known = examined.known_control
    if not known.are_beyond:
        return None
    miss = np.hypot(*known.differences.T)
    return Finding(
        "control_points_beyond_claim",
        Subject.CONTROL,
        names=first_names(known.point_ids[np.argsort(-miss, kind="stable")]),
        remedy="look_for_wrong_control",
        **_compared("control points", known),
    )


def _compared(title, known):
    """What all comparisons with the claim have to say."""
    return {
        "statistic": f"RMS of the differences at {title}",
        "observed": known.rms,
        "expected": known.claimed,
        "probability": known.p_value,
        "facts": {
            "n_points": known.count,
            "rms": known.rms,
            "claimed": known.claimed,
            "ratio": float(known.ratio),
        },
    }


def shifted_block(examined):
    """Differences at known points with a mean that chance does not explain: drift."""
    for role, known in (
        ("check", examined.known_check),
        ("control", examined.known_control),
    ):
        if known.count < FEWEST_POINTS:
            continue
        shift = known.differences.mean(axis=0)
        is_large = np.hypot(*shift) > LEAST_SHARE_OF_SHIFT * known.rms
        if is_large and mean_differs_from_zero(known.differences, FINDING_SIGNIFICANCE):
            return _shifted(role, known, shift)
    return None


def _shifted(role, known, shift):
    return Finding(
        "shifted_block",
        Subject.BLOCK,
        Gravity.GRAVE,
        statistic=f"mean difference at {role} points",
        observed=float(np.hypot(*shift)),
        expected=0.0,
        probability=float(np.nanmin(bonferroni(mean_p_values(known.differences)))),
        remedy="look_at_reference_system",
        facts={
            "role": role,
            "n_points": known.count,
            "easting": float(shift[0]),
            "northing": float(shift[1]),
        },
    )


TWO_STEP = SIMULTANEOUS = (
    check_points_beyond_claim,
    check_points_better_than_claim,
    control_points_beyond_claim,
    shifted_block,
)
