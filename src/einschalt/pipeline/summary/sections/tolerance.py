"""Which points keep the tolerance, and by which figure."""

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import count, factor, length, lengths, names
from einschalt.pipeline.assessment.credibility import Reason
from einschalt.pipeline.summary.section import NO_SECTION, Section

PROPAGATED = "the propagated one (standard_error_total)"
ADJUSTED = "that of the simultaneous adjustment (standard_error_total)"
BUDGET = (
    "Kovarik's budget (standard_error_paper), a lower bound: nothing larger is known"
)
TITLES = {"standard_error_total": PROPAGATED, "standard_error_paper": BUDGET}
ADJUSTMENTS = (
    Reason.ADJUSTED,
    Reason.ADJUSTED_UNKNOWN,
    Reason.ADJUSTED_ENLARGED,
    Reason.ADJUSTED_CONTRADICTED,
)
UNKNOWN = "No figure is known for these points, so that none passes."
FALLEN = (
    "None passes, since the claimed figure does not stand: the true error is larger"
)
UNTESTED = "Nothing in the measurements could contradict the figure: it is not tested."


def section(facts, credible) -> Section:
    """Set how many points of each role pass and fail."""
    if facts is None:
        return NO_SECTION
    largest = lengths([outcome.largest for outcome in facts.roles])
    rows = tuple(
        (f"{role.role} points", f"{role.n_pass:d}", f"{role.n_fail:d}", worst)
        for role, worst in zip(facts.roles, largest, strict=True)
    )
    tolerance = facts.tolerance
    return Section(
        f"Tolerance {length(tolerance.point)} (total; {printable(tolerance.title)})",
        ("", "pass", "fail", "largest figure"),
        rows,
        (*_figure(facts.figure, credible), *_suspects(facts), *_control(facts)),
    )


def _figure(used, credible):
    """Which figure decided, and whether it stands."""
    if not used.column:
        return (UNKNOWN,)
    is_adjusted = credible.reason in ADJUSTMENTS
    title = ADJUSTED if is_adjusted else TITLES[used.column]
    times = f", taken {factor(used.factor)}" if used.factor > 1.0 else ""
    said = [f"Figure used: {title}{times}."]
    if not used.is_supported:
        said.append(f"{FALLEN}{' still' * bool(times)}.")
    return said if used.is_tested else [*said, UNTESTED]


def _suspects(facts):
    """Suspects do not pass, however good their figure is."""
    if not facts.n_suspects:
        return ()
    verb = "does" if facts.n_suspects == 1 else "do"
    shown = names(facts.suspects, n_all=facts.n_suspects)
    return (f"{count(facts.n_suspects, 'suspect')} {verb} not pass: {shown}.",)


def _control(facts):
    """Differences at control points beyond what the ordinance allows."""
    if facts.n_control_beyond is None:
        return ()
    allowed = length(facts.tolerance.control)
    missed = (
        f"{facts.n_control_beyond} of {count(facts.n_control, 'control point')} missed"
    )
    return (f"{missed} by more than the {allowed} that are allowed there.",)
