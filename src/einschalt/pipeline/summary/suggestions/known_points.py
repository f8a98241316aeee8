"""What known points say of the claimed figure: check points, and control that holds."""

import numpy as np
from scipy.special import chdtri, stdtrit

from einschalt.foundations.typesetting import count, factor, length, names
from einschalt.pipeline.summary.suggestion import SIGNIFICANCE, Suggestion

MIN_REPORTED_RATIO = 1.25


def check_differences(result):
    """Differences at check points that the claimed figure does not explain."""
    rows = result.points[result.points["role"] == "check"]
    rms, claimed = _rms_of_differences(rows), _claimed(result, rows)
    ratio = rms / claimed
    limits = _ratio_limits(len(rows))
    if not (ratio > limits[1] or ratio < limits[0]):
        return None
    problem = (
        f"The differences at {count(len(rows), 'check point')} are {length(rms)} "
        f"(total, RMS), {factor(ratio)} the {length(claimed)} claimed for them"
    )
    if ratio > 1.0:
        return Suggestion(
            problem, "Trust them more than the budget; part of it is their own error"
        )
    return Suggestion(
        problem,
        "The claim is too cautious: m_g_um or the standard errors given are large",
    )


def check_points_exceed(result):
    """Whether the differences at check points are larger than the claimed figure."""
    rows = result.points[result.points["role"] == "check"]
    ratio = _rms_of_differences(rows) / _claimed(result, rows)
    return bool(ratio > _ratio_limits(len(rows))[1])


def _control_that_holds(result):
    """Control points without those that were set aside."""
    rows = result.points[result.points["role"] == "control"]
    if result.simultaneous is None:
        return rows
    control = result.simultaneous.control
    aside = control.loc[control["is_set_aside"], "point_id"]
    return rows[~rows["point_id"].isin(aside)]


def control_differences(result):
    """Control points that the densified coordinates miss by more than is claimed."""
    rows = _control_that_holds(result)
    rms, claimed = _rms_of_differences(rows), _claimed(result, rows)
    if not rms / claimed > _ratio_limits(len(rows))[1]:
        return None
    miss = np.hypot(rows["difference_easting"], rows["difference_northing"])
    worst = rows["point_id"][miss.sort_values(ascending=False).index]
    return Suggestion(
        f"The differences at {count(len(rows), 'control point')} are {length(rms)} "
        f"(total, RMS), {factor(rms / claimed)} the {length(claimed)} claimed for "
        f"them; largest at {names(worst[:3])}",
        "Look for wrong control points, or for strain in their network",
    )


def _rms_of_differences(rows):
    squares = rows["difference_easting"] ** 2 + rows["difference_northing"] ** 2
    return float(np.sqrt(squares.mean())) if len(rows) else np.nan


def _claimed(result, rows):
    """Total figure claimed for densified - given: both have an error."""
    given = result.block.control_points
    variance = rows[claim_column(result)].to_numpy() ** 2
    if given is not None and "standard_error_m" in given:
        errors = given.set_index("point_id")["standard_error_m"].astype(float)
        variance = variance + np.nan_to_num(errors.reindex(rows["point_id"])) ** 2
    variance = variance[np.isfinite(variance)]
    return float(np.sqrt(variance.mean())) if len(variance) else np.nan


def claim_column(result):
    """Name of the total error to believe: the propagated one, or a larger one."""
    figures = result.figures
    is_larger = figures.mean_total >= figures.mean_paper
    # the paper's budget is that of two steps
    is_adjusted = result.simultaneous is not None and np.isfinite(figures.mean_total)
    return (
        "standard_error_total" if is_larger or is_adjusted else "standard_error_paper"
    )


def _ratio_limits(n_points):
    """Ratios of a root mean square to its expectation that chance hardly exceeds."""
    if n_points == 0:
        return np.nan, np.nan
    degrees = 2 * n_points
    # quantiles of χ² from scipy.special: scipy.stats takes a second to import
    low = np.sqrt(chdtri(degrees, 1.0 - SIGNIFICANCE) / degrees)
    return min(low, 1.0 / MIN_REPORTED_RATIO), upper_ratio(degrees)


def upper_ratio(degrees):
    """Ratio of a root mean square to its expectation that chance hardly exceeds."""
    return max(np.sqrt(chdtri(degrees, SIGNIFICANCE) / degrees), MIN_REPORTED_RATIO)


def shifted_block(result):
    """Differences at known points with a mean that chance does not explain: drift."""
    for role in ("check", "control"):
        rows = result.points[result.points["role"] == role]
        if role == "control":
            rows = _control_that_holds(result)
        shift = rows[["difference_easting", "difference_northing"]].to_numpy(
            dtype=float
        )
        if len(shift) < 4:
            continue
        mean = shift.mean(axis=0)
        error = shift.std(axis=0, ddof=1) / np.sqrt(len(shift))
        limit = stdtrit(len(shift) - 1, 1.0 - SIGNIFICANCE / 4.0)
        # errors of neighbours are alike, so that the test alone would cry too often
        is_worth_a_word = np.hypot(*mean) > 0.5 * _rms_of_differences(rows)
        if is_worth_a_word and (np.abs(mean) > limit * error).any():
            return Suggestion(
                f"The block is shifted: the mean difference at "
                f"{count(len(shift), f'{role} point')} is easting {length(mean[0])}, "
                f"northing {length(mean[1])}",
                "Look at the reference system and the age of the given coordinates",
            )
    return None
