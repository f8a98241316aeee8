"""Precision of the new points: propagated, after the paper, and internal."""

import math
from functools import singledispatch

from einschalt.foundations.typesetting import (
    count,
    length,
    lengths,
    names,
    number,
    number_word,
)
from einschalt.pipeline.assessment.choice import ChoiceReason
from einschalt.pipeline.assessment.credibility import Reason
from einschalt.pipeline.assessment.facts.precision import (
    Carried,
    Shared,
    SimultaneousPrecision,
    TwoStepPrecision,
)
from einschalt.pipeline.summary.section import NO_SECTION, Section
from einschalt.pipeline.summary.wording import mean_of

TITLE = "Precision of the new points (total, RMS)"
HEADER = ("", "propagated", "paper", "internal")
TOTAL = (
    "All figures are total point errors, √(σ_E² + σ_N²); the error of one coordinate "
    "is total / √2."
)
INTERNAL = (
    "internal: from the differences of the coverages; it sees only the uncorrelated "
    "part of the error."
)
HEIGHTS = "Heights are computed; no figure here judges them."
SINGLE = "single: paper for the value of one model, internal for that of one coverage."
CARRIED = {
    Carried.MEASUREMENTS: (
        "propagated: errors of control and of both flights, of the sizes given, "
        "carried through every stage with their correlations."
    ),
    Carried.ORIENTATIONS: (
        "propagated: errors of control and of both flights, of the sizes given, and of "
        "the orientations, as sigma_0 of all models has them, carried through every "
        "stage with their correlations."
    ),
    Carried.IMAGES: (
        "propagated: errors of control and of the image points of both flights, of the "
        "sizes given, carried through relative orientation and every stage; models "
        "that share a photograph share the errors of its points."
    ),
    Carried.APPROXIMATIONS: (
        "propagated: errors of the approximate points, with what they are said to "
        "share, and of the low flight, carried through every stage."
    ),
}
PAPER = "paper: Kovarik 1971, M² = (m_g · scale number)² + m_t²."
TOO_SMALL = "standard_error_paper is too small: {}."
SHARED = {
    Shared.HIGH_FLIGHT: (
        "the approximate coordinates share the high flight's transformation error"
    ),
    Shared.MODEL_CONTROL: (
        "what a model lacks on its control points, all of its points share"
    ),
    Shared.NEIGHBOURS_STATED: "neighbouring approximate points share errors",
    Shared.NEIGHBOURS_GIVEN: (
        "neighbouring approximate points share errors, which is not known here"
    ),
    Shared.GROUPS_UNTOLD: (
        "groups of given points are displaced: group_error_m is not given, and "
        "residuals do not show it"
    ),
}
BOTH_SHARE = "{} coverages share the approximate coordinates"
BELIEVE_PROPAGATED = (
    "Believe the propagated figure: it alone counts the errors that points and "
    "coverages share, which the other two leave out."
)
BELIEVE_NONE = (
    "Believe none of the three as it stands: the measurements contradict the sizes of "
    "errors that were given, and the largest figure is a lower bound."
)
BELIEVE_NEITHER = (
    "Believe the larger figure as a lower bound: neither of them counts the errors "
    "that points and coverages share."
)
BELIEVE_STATED = (
    "Believe the figure of the first line: to these it adds the stated errors of the "
    "approximate points that the residuals do not show, since models took them up."
)
BELIEVE = {
    Reason.PROPAGATED: BELIEVE_PROPAGATED,
    Reason.CONTRADICTED: BELIEVE_NONE,
    Reason.STATED: BELIEVE_STATED,
}
SIMULTANEOUS = (
    "simultaneous: all models of all flights and the control in one adjustment; errors "
    "of the sizes given, with their correlations{}."
)
ORIENTED = ", and of the orientations, as sigma_0 of all models has them"
TWO_STEPS = (
    "two steps: approximate coordinates from the high flight, the low flight onto them "
    "(two_step_easting, two_step_northing)."
)
IMPOSSIBLE = "The two-step way is not possible in this block: {}"
UNSTATED = "No standard errors are given: {}."
SHOWN = "(standard errors that the residuals show)"
WAYS = 'Which way (method = "auto"; total, RMS)'
TAKEN = {"two_step": "two steps", "simultaneous": "simultaneous adjustment"}
WHY = {
    ChoiceReason.SUPPORTED: "the measurements contradict the figure of the other one",
    ChoiceReason.LEFT_OUT: "control points that were left out lie nearer to it",
    ChoiceReason.SMALLER: "its figure is the smaller one",
    ChoiceReason.MORE_MODELS: "the figures are alike, and it determines more models",
    ChoiceReason.CONTRADICTED: "measurements contradict both figures",
    ChoiceReason.ONLY_FIGURE: "the size of an error of the other one is not known",
    ChoiceReason.NO_FIGURE: "sizes of errors are not known in either way",
}
UNTRIED = (
    "One adjustment of all models may be more precise where nothing contradicts the "
    "sizes of errors: --method auto computes both ways, and keeps the better one."
)
BLIND = "It does not see errors that all models share: look at the model deformation"


def section(facts, credible, *, is_untried=False) -> Section:
    """Set the figures of the new points."""
    header, rows = table(facts)
    said = (*_belief(facts, credible), caution(facts), *remarks(facts))
    said += (UNTRIED,) if is_untried else ()
    return Section(TITLE, header, rows if facts.n_new else (), said)


def all_remarks(facts, credible, *, is_untried=False) -> tuple[str, ...]:
    """Say which figure to believe, and what each means, the kind of error included."""
    said = (*_belief(facts, credible), TOTAL, *remarks(facts))
    said += (UNTRIED,) if is_untried else ()
    return tuple(dict.fromkeys(said))


def _belief(facts, credible):
    """Which of the figures to believe, and why they differ, where there is a choice."""
    if isinstance(facts, TwoStepPrecision):
        return (what_to_believe(credible),)
    return ()


def what_to_believe(credible) -> str:
    """Say in one sentence which of the figures to believe, and why they differ."""
    return BELIEVE.get(credible.reason, BELIEVE_NEITHER)


@singledispatch
def table(facts: TwoStepPrecision):
    """Header and rows of the figures."""
    named = (("single", facts.single), (mean_of(facts.n_coverages), facts.mean))
    columns = {
        name: lengths([getattr(f, attribute) for _, f in named])
        for name, attribute in zip(
            HEADER[1:], ("total", "paper", "internal"), strict=True
        )
        if name != "propagated" or math.isfinite(facts.mean.total)
    }
    rows = zip((title for title, _ in named), *columns.values(), strict=True)
    return ("", *columns), tuple(rows)


@singledispatch
def caution(facts: TwoStepPrecision) -> str:
    """Say what the figures cannot see."""
    n_coverages, shared = facts.n_coverages, SHARED[facts.shared]
    word = "both" if n_coverages == 2 else f"all {number_word(n_coverages)}"
    both = [BOTH_SHARE.format(word)] if n_coverages > 1 else []
    if facts.shared not in (Shared.NEIGHBOURS_GIVEN, Shared.GROUPS_UNTOLD):
        return TOO_SMALL.format(", and ".join([shared, *both]))
    if both:
        return TOO_SMALL.format(f"{both[0]}; more so where {shared}")
    return f"standard_error_paper is too small where {shared}."


@singledispatch
def remarks(facts: TwoStepPrecision) -> tuple[str, ...]:
    """Say what the figures mean."""
    said = [TOTAL, PAPER]
    if facts.carried is not None:
        said.insert(1, CARRIED[facts.carried])
    if facts.n_coverages > 1:
        said.append(INTERNAL)
        if facts.coverage_mean == "all":
            said.append(SINGLE)
    if facts.heights is not None:
        said.append(_heights(facts.heights))
    return tuple(said)


def _heights(facts):
    """Say how good heights are, where that is known."""
    if math.isnan(facts.total):
        return HEIGHTS
    said = f"Heights of the new points: {length(facts.total)} (propagated, RMS"
    if facts.is_from_images:
        return f"{said})."
    return f"{said}; measured heights as the differences of the models show them)."


@table.register
def _(facts: SimultaneousPrecision):
    unknown = math.nan
    rows = [("simultaneous adjustment", facts.total, unknown, unknown)]
    if (other := facts.two_steps) is not None:
        rows.append(("two steps", other.total, other.paper, other.internal))
    titles, *columns = zip(*rows, strict=True)
    texts = zip(titles, *(lengths(column) for column in columns), strict=True)
    return HEADER, tuple(texts)


@caution.register
def _(facts: SimultaneousPrecision):
    """Say what s_0 is, and what it cannot see."""
    if facts.redundancy <= 0:
        return "No redundancy: nothing checks the adjustment."
    return (
        f"s_0 = {number(facts.s_0)} (redundancy {facts.redundancy}); 1 where the "
        f"errors are as large as given. {BLIND}."
    )


@remarks.register
def _(facts: SimultaneousPrecision):
    """Say what the figures mean, and how far apart the two ways are."""
    said = [
        SIMULTANEOUS.format(ORIENTED if facts.is_oriented else ""),
        *_estimated(facts),
        *_adjusted_heights(facts),
        *_two_ways(facts),
    ]
    if facts.unstated:
        said.append(UNSTATED.format(facts.unstated))
    return tuple(said)


def _estimated(facts):
    """Sizes of errors with which the block was adjusted, where they were estimated."""
    if facts.estimated is None:
        return ()
    sizes = [f"{name.replace('_', ' ')} {length(s)}" for name, s in facts.estimated]
    return (f"Errors of one coordinate {SHOWN}: {', '.join(sizes) or 'none'}.",)


def _adjusted_heights(facts):
    """How good the heights of spatial models are, and from where that is known."""
    if facts.heights is None:
        return ()
    said = []
    if not math.isnan(facts.heights.total):
        size = length(facts.heights.total)
        said.append(f"Heights of the new points: {size} (propagated, RMS).")
    flights = [f"{n.replace('_', ' ')} {length(s)}" for n, s in facts.height_errors]
    said.append(f"Measured heights: {', '.join(flights)} {SHOWN}.")
    if facts.n_centres:
        said.append(
            f"Projection centres of {count(facts.n_centres, 'photograph')} tie the "
            "models as well, with errors that the residuals show."
        )
    return tuple(said)


def _two_ways(facts):
    if facts.two_steps is None:
        return (IMPOSSIBLE.format(" ".join(facts.impossible.split())),)
    if (apart := facts.comparison) is None:
        return (TWO_STEPS,)
    differ = (
        f"The two ways differ by {length(apart.rms)} (total, RMS), "
        f"most at {names([apart.worst])}: {length(apart.largest)}."
    )
    return TWO_STEPS, differ


def ways(choice) -> Section:
    """Set the figures to believe of both ways, and say which was taken."""
    if choice is None:
        return NO_SECTION
    figures = (("two_step", choice.two_step), ("simultaneous", choice.simultaneous))
    rows = tuple(
        (TAKEN[method], _believed(figure), "taken" if method == choice.method else "")
        for method, figure in figures
    )
    return Section(WAYS, ("", "figure to believe", ""), rows, (_why(choice),))


def _believed(figure):
    if figure is None:
        return "not possible"
    if math.isnan(figure.value):
        return "not known"
    return f"{length(figure.value)}{' or worse' if figure.is_lower_bound else ''}"


def _why(choice):
    way = TAKEN[choice.method]
    if choice.reason is ChoiceReason.ONLY_WAY:
        return f"Only one way is possible, the {way}: {choice.obstacle}."
    return f"Taken: the {way}; {WHY[choice.reason]}."
