"""Which points keep the tolerance, and by which figure."""

import numpy as np

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import count, factor, length, lengths, names
from einschalt.pipeline.assessment.tolerance import TOTAL, checked_figure, tolerance_of
from einschalt.pipeline.summary.sections.section import Section

PROPAGATED = "the propagated one (standard_error_total)"
ADJUSTED = "that of the simultaneous adjustment (standard_error_total)"
BUDGET = (
    "Kovarik's budget (standard_error_paper), a lower bound: nothing larger is known"
)
UNKNOWN = "No figure is known for these points, so that none passes."
FALLEN = (
    "None passes, since the claimed figure does not stand: the true error is larger"
)
UNTESTED = "Nothing in the measurements could contradict the figure: it is not tested."
ROLES = ("new", "control", "check")


def section(result) -> Section:
    """Points of each role that pass and fail; no rows without a tolerance."""
    tolerance = tolerance_of(result.settings)
    if tolerance is None or result.points.empty:
        return Section("", (), ())
    by_role = {
        role: rows
        for role in ROLES
        if len(rows := result.points[result.points["role"] == role])
    }
    largest = lengths([r["standard_error_checked"].max() for r in by_role.values()])
    rows = [
        (f"{role} points", *_counts(points["is_within_tolerance"]), worst)
        for (role, points), worst in zip(by_role.items(), largest, strict=True)
    ]
    return Section(
        f"Tolerance {length(tolerance.point)} (total; {printable(tolerance.title)})",
        ("", "pass", "fail", "largest figure"),
        tuple(rows),
        (*_figure(result), *_suspects(result), *_control(result, tolerance)),
    )


def _counts(passes):
    return f"{passes.sum():d}", f"{(~passes).sum():d}"


def _figure(result):
    """Which figure decided, and whether it stands."""
    used = checked_figure(result)
    if not used.column:
        return (UNKNOWN,)
    title = PROPAGATED if used.column == TOTAL else BUDGET
    if result.simultaneous is not None:
        title = ADJUSTED
    times = f", taken {factor(used.factor)}" if used.factor > 1.0 else ""
    said = [f"Figure used: {title}{times}."]
    if not used.is_supported:
        said.append(f"{FALLEN}{' still' * bool(times)}.")
    return said if used.is_tested else [*said, UNTESTED]


def _suspects(result):
    """Suspects do not pass, however good their figure is."""
    suspects = result.points.loc[result.points["is_suspect"], "point_id"]
    if suspects.empty:
        return ()
    verb = "does" if len(suspects) == 1 else "do"
    return (f"{count(len(suspects), 'suspect')} {verb} not pass: {names(suspects)}.",)


def _control(result, tolerance):
    """Differences at control points beyond what the ordinance allows."""
    control = result.points[result.points["role"] == "control"]
    if not np.isfinite(tolerance.control) or control.empty:
        return ()
    miss = np.hypot(control["difference_easting"], control["difference_northing"])
    n_beyond = int((miss > tolerance.control).sum())
    allowed = length(tolerance.control)
    missed = f"{n_beyond} of {count(len(control), 'control point')} missed"
    return (f"{missed} by more than the {allowed} that are allowed there.",)
