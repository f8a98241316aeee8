"""Precision of the new points: propagated, after the paper, and internal."""

import math
from functools import singledispatch

from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.typesetting import (
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
from einschalt.pipeline.summary.wording import flight_name, length_or_worse, mean_of

TITLE = mark("Precision of the new points (total, RMS)")
COLUMNS = mark_each(
    {"propagated": "propagated", "paper": "paper", "internal": "internal"}
)
TOTAL = mark(
    "All figures are total point errors, √(σ_E² + σ_N²); the error of one coordinate "
    "is total / √2."
)
INTERNAL = mark(
    "internal: from the differences of the coverages; it reflects only the "
    "uncorrelated part of the error."
)
HEIGHTS = mark("Heights are computed; their precision is not assessed.")
SINGLE = mark(
    "single: paper for the value of one model, internal for that of one coverage."
)
CARRIED = mark_each(
    {
        Carried.MEASUREMENTS: (
            "propagated: stated errors of control and of both flights, propagated "
            "through every stage with their correlations."
        ),
        Carried.ORIENTATIONS: (
            "propagated: stated errors of control and of both flights, and errors of "
            "the orientations from sigma_0 of all models, propagated through every "
            "stage with their correlations."
        ),
        Carried.IMAGES: (
            "propagated: stated errors of control and of the image points of both "
            "flights, propagated through relative orientation and every stage; models "
            "that share a photograph share the errors of its points."
        ),
        Carried.APPROXIMATIONS: (
            "propagated: errors of the approximate points with their stated "
            "correlations, and of the low flight, propagated through every stage."
        ),
    }
)
PAPER = mark("paper: Kovarik 1971, M² = (m_g · scale number)² + m_t².")
NEGLECTS = mark("The figure of the paper neglects shared errors: {reason}.")
NEGLECTS_TWICE = mark(
    "The figure of the paper neglects shared errors: {reason}, and {other}."
)
NEGLECTS_MORE_IF = mark(
    "The figure of the paper neglects shared errors: {reason}; more so if {condition}."
)
TOO_SMALL_IF = mark("The figure of the paper is too small if {condition}.")
SHARED = mark_each(
    {
        Shared.HIGH_FLIGHT: (
            "the approximate coordinates share the high flight's transformation error"
        ),
        Shared.MODEL_CONTROL: (
            "absolute-orientation errors are common to all points of a model"
        ),
        Shared.NEIGHBOURS_STATED: "neighbouring approximate points share errors",
    }
)
CONDITIONS = mark_each(
    {
        Shared.NEIGHBOURS_GIVEN: (
            "neighbouring approximate points share errors, which is not known here"
        ),
        Shared.GROUPS_UNTOLD: (
            "groups of given points are displaced, which group_error_m does not state "
            "and residuals do not show"
        ),
    }
)
BOTH_SHARE = mark("both coverages share the approximate coordinates")
ALL_SHARE = mark("all {number} coverages share the approximate coordinates")
BELIEVE_PROPAGATED = mark(
    "Use the propagated figure: it alone includes the errors that points and coverages "
    "share."
)
BELIEVE_NONE = mark(
    "None of the three can be relied on as it stands: the measurements contradict the "
    "stated errors, and the largest figure is a lower bound."
)
BELIEVE_NEITHER = mark(
    "Use the larger figure as a lower bound: neither includes the errors that points "
    "and coverages share."
)
BELIEVE_STATED = mark(
    "Use the figure of the first line: it also includes the stated errors of the "
    "approximate points, which models have absorbed and residuals do not show."
)
BELIEVE_ASSUMED = mark(
    "Use the figure of the first line: errors of all sources, those of the approximate "
    "points taken for independent. Errors that these share are not in it."
)
BELIEVE_DISPLACED = mark(
    "Use the figure of the first line for all points together: it includes what "
    "displaced regions do to them; standard_error_checked has it point by point."
)
BELIEVE_WRONG_POINTS = mark(
    "Use the figure of the first line for all points together: it includes what wrong "
    "approximate points do to them; standard_error_checked has it point by point."
)
BELIEVE_NAMES = mark(
    "Use the figure of the first line for all points together: it includes what wrong "
    "names do to them."
)
LEFT_ASIDE = mark(
    "The figure leaves point {name} aside, which took no part and is {length} off, as "
    "no other known point is: until it is checked, points near it may be as wrong."
)
SEVERAL_LEFT_ASIDE = mark(
    "The figure leaves points {names} aside, which took no part and are up to {length} "
    "off, as no other known point is: until they are checked, points near them may be "
    "as wrong."
)
BELIEVE = {
    Reason.PROPAGATED: BELIEVE_PROPAGATED,
    Reason.CONTRADICTED: BELIEVE_NONE,
    Reason.STATED: BELIEVE_STATED,
    Reason.ASSUMED: BELIEVE_ASSUMED,
    Reason.DISPLACED: BELIEVE_DISPLACED,
    Reason.WRONG_POINTS: BELIEVE_WRONG_POINTS,
    Reason.EXCHANGED_CONTROL: BELIEVE_NAMES,
    Reason.EXCHANGED_NAMES: BELIEVE_NAMES,
}
SIMULTANEOUS = mark(
    "simultaneous: all models of all flights and the control in one adjustment; stated "
    "errors, with their correlations."
)
SIMULTANEOUS_ORIENTED = mark(
    "simultaneous: all models of all flights and the control in one adjustment; stated "
    "errors, with their correlations, and errors of the orientations from sigma_0 of "
    "all models."
)
TWO_STEPS = mark(
    "two steps: approximate coordinates from the high flight, the low flight "
    "transformed onto them (two_step_easting, two_step_northing)."
)
TWO_STEPS_GIVEN = mark(
    "two steps: approximate coordinates as they were given, the low flight transformed "
    "onto them (two_step_easting, two_step_northing)."
)
APART = mark(
    "The two methods differ by {rms} (total, RMS), most at {worst}: {largest}."
)
KEEP_SET_ASIDE = mark(
    "The two steps hold control points that the adjustment set aside: what these do to "
    "their points is not in their figures."
)
IMPOSSIBLE = mark("The two steps are not possible in this block: {reason}")
UNSTATED = mark("No standard errors are given: {reason}.")
ESTIMATED = mark(
    "Errors of one coordinate (standard errors estimated from the residuals): {sizes}."
)
HEIGHT_PRECISION = mark("Heights of the new points: {length} (propagated, RMS).")
HEIGHT_PRECISION_OF_MODELS = mark(
    "Heights of the new points: {length} (propagated, RMS; errors of measured heights "
    "from the differences of the models)."
)
HEIGHTS_REFUTED = mark(
    "The measurements contradict the propagated figure of the heights: use the one of "
    "the first line."
)
MEASURED_HEIGHTS = mark(
    "Measured heights (standard errors estimated from the residuals): {sizes}."
)
CENTRES = mark(
    "The projection centres of {n:photograph|photographs} also tie the models, with "
    "errors estimated from the residuals."
)
S_0 = mark(
    "s_0 = {s_0} (redundancy {redundancy}); 1 if the errors are as large as stated. It "
    "does not reflect errors common to all models: see the deformation of models."
)
NO_REDUNDANCY = mark("No redundancy: nothing checks the adjustment.")
WAYS = mark('Choice of method (method = "auto"; total, RMS)')
TAKEN = mark_each({"two_step": "two steps", "simultaneous": "simultaneous adjustment"})
WHY = mark_each(
    {
        ChoiceReason.SUPPORTED: (
            "Chosen: {way}; the measurements contradict the figure of the other method."
        ),
        ChoiceReason.LEFT_OUT: (
            "Chosen: {way}; control points that were left out agree better with it."
        ),
        ChoiceReason.HEIGHTS: (
            "Chosen: {way}; the heights of the other method are known to be much worse."
        ),
        ChoiceReason.SMALLER: "Chosen: {way}; its figure is the smaller one.",
        ChoiceReason.MORE_MODELS: (
            "Chosen: {way}; the figures are alike, and it determines more models."
        ),
        ChoiceReason.MORE_POINTS: (
            "Chosen: {way}; the other method leaves many points without coordinates."
        ),
        ChoiceReason.WRONG_CONTROL: (
            "Chosen: {way}; it shows what the wrong control point does, which the "
            "other method does not test."
        ),
        ChoiceReason.CONTRADICTED: (
            "Chosen: {way}; the measurements contradict both figures."
        ),
        ChoiceReason.KNOWN_POINTS: (
            "Chosen: {way}; sizes of errors are not known, and known points that took "
            "no part, or were left out, agree better with it."
        ),
        ChoiceReason.ONLY_FIGURE: (
            "Chosen: {way}; the size of an error in the other method is not known."
        ),
        ChoiceReason.NO_FIGURE: (
            "Chosen: {way}; sizes of errors are not known in either method."
        ),
    }
)
ONLY_WAY = mark("Only one method is possible, {way}: {obstacle}.")
UNTRIED = mark(
    "One adjustment of all models may be more precise if nothing contradicts the "
    "stated errors: --method auto computes both methods, and keeps the better one."
)


def section(facts, credible, heights=None, *, is_untried=False) -> Section:
    """Set the figures of the new points; ``heights`` is what theirs are to believe."""
    header, rows = table(facts)
    told = (*_belief(facts, credible), caution(facts), *remarks(facts))
    told += _refuted(facts, heights)
    told += (translated(UNTRIED),) if is_untried else ()
    return Section(translated(TITLE), header, rows if facts.n_new else (), told)


def all_remarks(facts, credible, heights=None, *, is_untried=False) -> tuple[str, ...]:
    """Say which figure to believe, and what each means, the kind of error included."""
    told = (*_belief(facts, credible), translated(TOTAL), *remarks(facts))
    told += _refuted(facts, heights)
    told += (translated(UNTRIED),) if is_untried else ()
    return tuple(dict.fromkeys(told))


def _belief(facts, credible):
    """Which of the figures to believe, and why they differ, where there is a choice.

    And which known points were left aside.
    """
    told = ()
    if isinstance(facts, TwoStepPrecision):
        told = (what_to_believe(credible),)
    aside, off = credible.left_aside, length(credible.left_aside_by)
    if len(aside) == 1:
        told += (translated(LEFT_ASIDE, name=names(aside), length=off),)
    elif aside:
        told += (translated(SEVERAL_LEFT_ASIDE, names=names(aside), length=off),)
    return told


def what_to_believe(credible) -> str:
    """Say in one sentence which of the figures to believe, and why they differ."""
    return translated(BELIEVE.get(credible.reason, BELIEVE_NEITHER))


def _refuted(facts, heights):
    """Say that the heights are worse than their propagated figure, where they are."""
    is_told = facts.heights is not None and not math.isnan(facts.heights.total)
    if not (is_told and heights is not None and heights.is_lower_bound):
        return ()
    return (translated(HEIGHTS_REFUTED),)


@singledispatch
def table(facts: TwoStepPrecision):
    """Header and rows of the figures."""
    mean = mean_of(facts.n_coverages)
    named = ((translated("single"), facts.single), (mean, facts.mean))
    columns = {
        translated(COLUMNS[name]): lengths([getattr(f, attribute) for _, f in named])
        for name, attribute in zip(COLUMNS, ("total", "paper", "internal"), strict=True)
        if name != "propagated" or math.isfinite(facts.mean.total)
    }
    rows = zip((title for title, _ in named), *columns.values(), strict=True)
    return ("", *columns), tuple(rows)


@singledispatch
def caution(facts: TwoStepPrecision) -> str:
    """Say what the figures cannot see."""
    both = _coverages_share(facts.n_coverages)
    if facts.shared in SHARED:
        reason = translated(SHARED[facts.shared])
        if not both:
            return translated(NEGLECTS, reason=reason)
        return translated(NEGLECTS_TWICE, reason=reason, other=both)
    condition = translated(CONDITIONS[facts.shared])
    if both:
        return translated(NEGLECTS_MORE_IF, reason=both, condition=condition)
    return translated(TOO_SMALL_IF, condition=condition)


def _coverages_share(n_coverages):
    if n_coverages < 2:
        return ""
    if n_coverages == 2:
        return translated(BOTH_SHARE)
    return translated(ALL_SHARE, number=number_word(n_coverages))


@singledispatch
def remarks(facts: TwoStepPrecision) -> tuple[str, ...]:
    """Say what the figures mean."""
    messages = [TOTAL, PAPER]
    if facts.carried is not None:
        messages.insert(1, CARRIED[facts.carried])
    if facts.n_coverages > 1:
        messages.append(INTERNAL)
        if facts.coverage_mean == "all":
            messages.append(SINGLE)
    heights = () if facts.heights is None else (_heights(facts.heights),)
    return (*map(translated, messages), *heights)


def _heights(facts):
    """Say how good heights are, where that is known."""
    if math.isnan(facts.total):
        return translated(HEIGHTS)
    is_from_images = facts.is_from_images
    message = HEIGHT_PRECISION if is_from_images else HEIGHT_PRECISION_OF_MODELS
    return translated(message, length=length(facts.total))


@table.register
def _(facts: SimultaneousPrecision):
    unknown = math.nan
    rows = [(translated(TAKEN["simultaneous"]), facts.total, unknown, unknown)]
    if (other := facts.two_steps) is not None:
        title = translated(TAKEN["two_step"])
        rows.append((title, other.total, other.paper, other.internal))
    titles, *columns = zip(*rows, strict=True)
    texts = zip(titles, *(lengths(column) for column in columns), strict=True)
    return ("", *map(translated, COLUMNS.values())), tuple(texts)


@caution.register
def _(facts: SimultaneousPrecision):
    """Say what s_0 is, and what it cannot see."""
    if facts.redundancy <= 0:
        return translated(NO_REDUNDANCY)
    return translated(S_0, s_0=number(facts.s_0), redundancy=facts.redundancy)


@remarks.register
def _(facts: SimultaneousPrecision):
    """Say what the figures mean, and how far apart the two ways are."""
    told = [
        translated(SIMULTANEOUS_ORIENTED if facts.is_oriented else SIMULTANEOUS),
        *_estimated(facts),
        *_adjusted_heights(facts),
        *_two_ways(facts),
    ]
    if facts.unstated:
        told.append(translated(UNSTATED, reason=retold(str(facts.unstated))))
    return tuple(told)


def _estimated(facts):
    """Sizes of errors with which the block was adjusted, where they were estimated."""
    if facts.estimated is None:
        return ()
    sizes = [f"{_group(name)} {length(size)}" for name, size in facts.estimated]
    return (translated(ESTIMATED, sizes=", ".join(sizes) or translated("none")),)


def _group(name):
    """A flight, or what else the sizes of errors were estimated of."""
    flight, comma, rest = name.partition(", ")
    return f"{flight_name(flight)}{comma}{retold(rest)}"


def _adjusted_heights(facts):
    """How good the heights of spatial models are, and from where that is known."""
    if facts.heights is None:
        return ()
    told = []
    if not math.isnan(facts.heights.total):
        told.append(translated(HEIGHT_PRECISION, length=length(facts.heights.total)))
    sizes = [
        f"{flight_name(name)} {length(size)}" for name, size in facts.height_errors
    ]
    told.append(translated(MEASURED_HEIGHTS, sizes=", ".join(sizes)))
    if facts.n_centres:
        told.append(translated(CENTRES, n=facts.n_centres))
    return tuple(told)


def _two_ways(facts):
    if facts.two_steps is None:
        reason = retold(" ".join(facts.impossible.split()))
        return (translated(IMPOSSIBLE, reason=reason),)
    told = (translated(TWO_STEPS if facts.has_high_flight else TWO_STEPS_GIVEN),)
    if facts.two_steps_keep_set_aside:
        told += (translated(KEEP_SET_ASIDE),)
    if (apart := facts.comparison) is None:
        return told
    sizes = {"rms": length(apart.rms), "largest": length(apart.largest)}
    return (*told, translated(APART, worst=names([apart.worst]), **sizes))


def ways(choice) -> Section:
    """Set the figures to believe of both ways, and say which was taken."""
    if choice is None:
        return NO_SECTION
    figures = (("two_step", choice.two_step), ("simultaneous", choice.simultaneous))
    rows = tuple(
        (
            translated(TAKEN[method]),
            _believed(credible),
            translated("chosen") if method == choice.method else "",
        )
        for method, credible in figures
    )
    header = ("", translated("credible figure"), "")
    return Section(translated(WAYS), header, rows, (_why(choice),))


def _believed(credible):
    if credible is None:
        return translated("not possible")
    if math.isnan(credible.value):
        return translated("not known")
    return length_or_worse(credible)


def _why(choice):
    way = translated(TAKEN[choice.method])
    if choice.reason is ChoiceReason.ONLY_WAY:
        return translated(
            ONLY_WAY, way=way, obstacle=retold(choice.obstacle).rstrip(".")
        )
    return translated(WHY[choice.reason], way=way)
