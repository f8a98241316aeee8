"""Whether points with given coordinates agree with the claimed figure."""

from dataclasses import asdict

import numpy as np
import pandas as pd

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.evidence.control.patterns import wrong_control
from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings.kinds import MOST_NAMED, finding
from einschalt.pipeline.assessment.known_points import (
    MOST_OF_MISS,
    WITHIN_CLAIM,
    confirmed_check_points,
    contradicting_points,
    far_control,
    few_contradicting_points,
    picked,
)
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

FEWEST_POINTS = 4
# of the root mean square: a smaller one explains little
LEAST_SHARE_OF_SHIFT = 0.5
PLAN, GIVEN = ["easting", "northing"], ["given_easting", "given_northing"]
# as near a new point is where it is the control point: by what is claimed, and by the
# distance that the control point itself is off, which moves its neighbours
WITHIN_MISS = 0.02


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
    known, others = examined.known_check, examined.confirmed_check
    lone = [p for p in examined.lone_points if p.point_id in set(known.point_ids)]
    if len(lone) != 1:
        return None
    (lone,) = lone
    return finding(
        "lone_wrong_check_point",
        names=(lone.point_id, *filter(None, [lone.found_there])),
        statistic="difference at a check point",
        observed=lone.miss,
        expected=known.claimed,
        remedy="correct_check_name" if lone.found_there else "check_lone_point",
        facts={
            "largest": lone.miss,
            "n_points": known.count,
            "rms": known.rms,
            "n_others": others.count,
            "rms_of_others": others.rms,
            "claimed": known.claimed,
            "away": lone.away,  # of the new point that lies where it is given
        },
    )


def suspect_check_points(examined):
    """Check points that contradict the claim each by itself, though all together not.

    They are suspects in the table of points.
    """
    known = confirmed_check_points(examined)
    names = contradicting_points(examined)
    # those that are left aside are told as such
    names = names[is_among(names, known.point_ids)]
    if not len(names) or known.are_beyond:
        return None
    miss = np.hypot(*known.differences[is_among(known.point_ids, names)].T)
    return finding(
        "suspect_check_points",
        names=names[np.argsort(-miss, kind="stable")],
        statistic="difference at a check point",
        observed=float(miss.max()),
        expected=known.claimed,
        remedy="check_far_points",
        facts={
            "n_points": len(names),
            "largest": float(miss.max()),
            "rms": known.rms,
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
    miss, few = np.hypot(*known.differences.T), far_control(examined)
    is_other = ~np.isin(known.point_ids, few)
    # where nothing was propagated they may be stated all the same
    is_stated = "standard_error_m" in examined.block.control_points
    remedy = "look_for_wrong_control" if is_stated else "state_control_errors"
    compared = _compared("control points", known)
    compared["facts"] |= {
        "n_far": len(few),  # that contradict the claim each by itself, others do not
        "rms_of_others": picked(known, is_other).rms,
    }
    return finding(
        "control_points_beyond_claim",
        names=known.point_ids[np.lexsort((-miss, is_other))],
        remedy="check_far_points" if len(few) else remedy,
        **compared,
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


def exchanged_control(examined):
    """Control points that lie where others of them are given."""
    found = examined.exchanged_control
    if found is None:
        return None
    mixed = found.names
    is_pair = len(mixed.points) == 2
    return finding(
        "exchanged_control",
        names=mixed.points,
        statistic="RMS of the differences at control points, and with names put right",
        observed=found.rms,
        expected=found.rms_exchanged,
        remedy="exchange_control_names" if is_pair else "put_control_names_right",
        facts={
            "n_points": len(mixed.points),
            "given_as": tuple(mixed.given_as.values())[:MOST_NAMED],
            "slipped_rows": mixed.rows,
            "last": next(reversed(mixed.given_as)),
            "lost": mixed.lost,
            "nameless": mixed.nameless,
            "apart": found.apart,
            "rms": found.rms,
            "rms_exchanged": found.rms_exchanged,
            "moved": found.moved.plan,
        },
    )


def lone_control_under_another_name(two_step):
    """New points that lie where control is given that took no part and is far off."""
    names = set(two_step.known_control.point_ids)
    pairs = [p for p in two_step.lone_points if p.point_id in names and p.found_there]
    if not pairs:
        return None
    return finding(
        "control_under_another_name",
        names=[name for pair in pairs for name in (pair.point_id, pair.found_there)],
        statistic="distance of a new point from the given control point",
        observed=pairs[0].away,
        expected=pairs[0].miss,
        remedy="correct_control_name",
        facts={
            "n_points": len(pairs),
            "miss": pairs[0].miss,
            "away": pairs[0].away,
        },
    )


def control_under_another_name(two_step):
    """New points that lie where control is given, which lies elsewhere itself.

    Two names that are exchanged in all measurements, or in the list of control, leave
    no residual but that of the control point.
    """
    table = two_step.control_left_out
    # others may be off because of the wrong one
    table = table[table["point_id"].isin(wrong_control(two_step.control_patterns))]
    columns = ["difference_easting", "difference_northing"]
    return _under_another_name(two_step, table, columns)


def control_under_another_name_of_adjustment(adjusted):
    """The same, by the strain of control that contradicts the adjustment."""
    columns = ["strain_easting", "strain_northing"]
    return _under_another_name(adjusted, adjusted.adjustment.control, columns)


def _under_another_name(examined, table, columns):
    off = _far_off(examined, table[table["is_suspect"].astype(bool)], columns)
    if not len(off):
        return None
    points = examined.points
    new = points[points["role"] == "new"].dropna(subset=PLAN)
    if not len(new):
        return None
    nearest, away = _nearest(values_of(new, PLAN), values_of(off, GIVEN))
    miss = off["miss"].to_numpy()
    precise = np.nan_to_num(float(examined.figures.mean_within))
    is_there = away <= np.minimum(
        np.maximum(WITHIN_CLAIM * precise, WITHIN_MISS * miss), MOST_OF_MISS * miss
    )
    if not is_there.any():
        return None
    rows = np.flatnonzero(is_there)[np.argsort(-miss[is_there], kind="stable")]
    control = off["point_id"].to_numpy(dtype=object)[rows]
    other = new["point_id"].to_numpy(dtype=object)[nearest[rows]]
    return finding(
        "control_under_another_name",
        names=[name for pair in zip(control, other, strict=True) for name in pair],
        statistic="distance of a new point from the given control point",
        observed=away[rows[0]],
        expected=miss[rows[0]],
        remedy="correct_control_name",
        facts={
            "n_points": len(rows),
            "miss": float(miss[rows[0]]),
            "away": float(away[rows[0]]),
        },
    )


def _far_off(examined, table, columns):
    """Where suspects are given, and how far off they are: GIVEN, ``miss`` [m]."""
    given = examined.block.control_points
    if not len(table) or given is None:
        return pd.DataFrame(columns=["point_id", *GIVEN, "miss"])
    off = pd.DataFrame({"point_id": table["point_id"].to_numpy(dtype=object)})
    off["miss"] = np.hypot(*values_of(table, columns).T)
    given = given.set_index("point_id")[PLAN].reindex(off["point_id"])
    off[GIVEN] = given.to_numpy(dtype=float)
    return off.dropna(subset=[*GIVEN, "miss"])


def _nearest(places, wanted):
    """Row of the nearest of places to each that is wanted, and its distance [m]."""
    from scipy.spatial import KDTree  # noqa: PLC0415 - loaded when control is off

    away, nearest = KDTree(places).query(wanted)
    return nearest, away


FOR_BOTH = (
    lone_wrong_check_point,
    check_points_beyond_claim,
    suspect_check_points,
    check_points_better_than_claim,
    control_points_beyond_claim,
    shifted_block,
)


def other_targets(examined):
    """Points for which the flights have measured different targets."""
    exchanged = {name for pair in examined.exchanged_names for name in pair.points}
    found = [each for each in examined.other_targets if each.point_id not in exchanged]
    if not found:
        return None
    worst, flights = found[0], {each.flight for each in found}
    return finding(
        "other_targets",
        names=[each.point_id for each in found],
        statistic="distance of a point in the low flight from where the high has it",
        observed=worst.distance,
        probability=worst.p_value,
        remedy="compare_targets",
        facts={
            "n_points": len(found),
            "largest": worst.distance,
            # where given coordinates tell of all of them which flight it is
            "flight": flights.pop() if len(flights) == 1 else "",
            "explains": (),
            "targets": tuple(map(asdict, found[:MOST_NAMED])),
        },
    )


TWO_STEP = (
    *(exchanged_control, other_targets, control_under_another_name),
    lone_control_under_another_name,
    *FOR_BOTH,
)
SIMULTANEOUS = (
    *(exchanged_control, other_targets, control_under_another_name_of_adjustment),
    *FOR_BOTH,
)
