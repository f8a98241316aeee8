"""Which points keep the tolerance, and by which figure."""

from einschalt.foundations.display_names import printable
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import figure, mark, translated
from einschalt.foundations.typesetting import factor, length, lengths, names
from einschalt.pipeline.assessment.credibility import Reason
from einschalt.pipeline.summary.section import NO_SECTION, Section
from einschalt.pipeline.summary.sections.moves import POINTS_OF_ROLE

PROPAGATED = mark("the propagated one (standard_error_total)")
ADJUSTED = mark("that of the simultaneous adjustment (standard_error_total)")
BUDGET = mark(
    "Kovarik's budget (standard_error_paper), a lower bound: nothing larger is known"
)
TITLES = {"standard_error_total": PROPAGATED, "standard_error_paper": BUDGET}
ADJUSTMENTS = (
    Reason.ADJUSTED,
    Reason.ADJUSTED_UNKNOWN,
    Reason.ADJUSTED_ENLARGED,
    Reason.ADJUSTED_CONTRADICTED,
)
UNKNOWN = mark("No figure is known for these points, so none passes.")
FALLEN = mark(
    "None passes, since the stated precision is not supported: the true error is "
    "larger."
)
FALLEN_STILL = mark(
    "None passes, since even so the stated precision is not supported: the true error "
    "is larger."
)
DISPLACED = mark(
    "Figure used: what is left without displaced regions, and what these do to each "
    "point."
)
WRONG_POINTS = mark(
    "Figure used: what is left without wrong approximate points, and what these do to "
    "each point."
)
FALLEN_TOGETHER = mark("None passes, since nothing tells which part is displaced.")
PUT_OFF = {Reason.DISPLACED: DISPLACED, Reason.WRONG_POINTS: WRONG_POINTS}
UNTESTED = mark("The figure is not tested: no measurement could contradict it.")
SUSPECTS = mark("{n:suspect does|suspects do} not pass: {names}.")
MISSED = mark(
    "At {n} of {n_all:control point|control points} the difference exceeds the "
    "{allowed} that are allowed there."
)


def section(facts, credible) -> Section:
    """Set how many points of each role pass and fail."""
    if facts is None:
        return NO_SECTION
    largest = lengths([outcome.largest for outcome in facts.roles])
    rows = tuple(
        (
            translated(POINTS_OF_ROLE[role.role]),
            figure(role.n_pass, "d"),
            figure(role.n_fail, "d"),
            worst,
        )
        for role, worst in zip(facts.roles, largest, strict=True)
    )
    titles = translated("within"), translated("beyond"), translated("largest figure")
    return Section(
        translated(
            "Tolerance {length} (total; {title})",
            length=length(facts.tolerance.point),
            title=retold(printable(facts.tolerance.title)),
        ),
        ("", *titles),
        rows,
        (*_figure(facts.figure, credible), *_suspects(facts), *_control(facts)),
    )


def _figure(used, credible):
    """Which figure decided, and whether it stands."""
    if not used.column:
        return (translated(UNKNOWN),)
    if credible.reason in PUT_OFF:
        return _beside_regions(used, PUT_OFF[credible.reason])
    is_adjusted = credible.reason in ADJUSTMENTS
    title = translated(ADJUSTED if is_adjusted else TITLES[used.column])
    if is_enlarged := used.factor > 1.0:
        by = {"title": title, "factor": factor(used.factor)}
        remarks = [translated("Figure used: {title}, taken {factor}.", **by)]
    else:
        remarks = [translated("Figure used: {title}.", title=title)]
    if not used.is_supported:
        remarks.append(translated(FALLEN_STILL if is_enlarged else FALLEN))
    return remarks if used.is_tested else [*remarks, translated(UNTESTED)]


def _beside_regions(used, words):
    """The same where regions of given points, or single ones, are displaced."""
    fallen = FALLEN_STILL if used.is_told else FALLEN_TOGETHER
    fallen = () if used.is_supported else (translated(fallen),)
    return (translated(words), *fallen)


def _suspects(facts):
    """Suspects do not pass, however good their figure is."""
    if not facts.n_suspects:
        return ()
    shown = names(facts.suspects, n_all=facts.n_suspects)
    return (translated(SUSPECTS, n=facts.n_suspects, names=shown),)


def _control(facts):
    """Differences at control points beyond what the ordinance allows."""
    if facts.n_control_beyond is None:
        return ()
    allowed = length(facts.tolerance.control)
    numbers = {"n": facts.n_control_beyond, "n_all": facts.n_control}
    return (translated(MISSED, **numbers, allowed=allowed),)
