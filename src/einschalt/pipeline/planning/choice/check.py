"""Plans of a search held against the propagation on their own layouts."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from einschalt.foundations.arguments import require_choice, require_kind
from einschalt.foundations.batches import working_on_parts
from einschalt.foundations.blas_threads import one_blas_thread
from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.language import figure, in_english, mark, translated
from einschalt.foundations.told_errors import told
from einschalt.foundations.typesetting import number, per_cent, wrapped
from einschalt.pipeline.planning.choice.finer_choices import (
    REFINED,
    describe_finer,
    finer_choices,
    is_among,
    plans_between,
    searched_with,
)
from einschalt.pipeline.planning.choice.rows import design_of
from einschalt.pipeline.planning.choice.trials import Trials
from einschalt.pipeline.planning.estimate.search import PlanSearch
from einschalt.pipeline.planning.estimate.text import (
    OF_ONE_COVERAGE,
    ONE_COVERAGE,
    WHERE_IS_OF_ONE,
    describe_plan,
    missed_in_cm,
)
from einschalt.pipeline.planning.flights.cameras import describe_heights
from einschalt.pipeline.planning.flights.flight_design import require_overlaps
from einschalt.pipeline.planning.propagation.expected_precision import (
    ExpectedPrecision,
    PropagatedBlock,
    propagate_design,
)
from einschalt.stages.results import Result

# layouts that are propagated, and those that may miss before the closed estimate is
# corrected by the worst of them: one that is bad says little of the next
MOST_TRIED, PATIENCE = 8, 3
MOST_BETWEEN = 6  # beside the cheapest of them
KIND = ("n_coverages", "control_per_model")
NEARLY = 0.3  # of a target that is missed: plans beside such ones may keep it
ALIKE = 0.1  # of logarithms of scales
FOR_GIVEN_VALUES = 0.55  # of the work that is allowed; the rest for values between
MOST_REFUSED = 60  # layouts that cannot be flown
MOST_SAID = 3  # plans that miss the target, the cheapest
RECOMMENDED = 2  # the plan that is recommended, and the next best


@dataclass(frozen=True, eq=False, repr=False)
class CheckedPlan(Result):
    """The cheapest plan that keeps its target on its own layout, or the nearest one.

    Attributes
    ----------
    plan : Series
        Row of the search.
    propagated : PropagatedBlock
        The block that was laid out.
    reached : float
        TOTAL error at the place of the target [m].
    target : float
        TOTAL error that the delivered coordinates may have [m].
    search : PlanSearch
        All plans by estimate, with those between the values that were asked for.
    missed : tuple of (Series, float)
        Other plans that were tried and miss it, with the TOTAL error of each [m].
    refused : tuple of (Series, EinschaltError)
        Those that cannot be flown, with the reason.
    next_best : CheckedPlan, optional
        The cheapest other one that keeps the target.
    place : {"centre", "edge", "corner"}, optional
        With one coverage: where in the models ``reached`` is the error; None with
        several, whose mean is alike everywhere.
    is_counted : bool
        Whether costs were counted on a layout over an area; otherwise they are
        estimated.
    asked_where : {"everywhere", "edge", "centre"}
        Place of the target.
    finer : dict of str to tuple of float
        Values of choices between those that were tried, of which one may be cheaper.
    """

    plan: "pd.Series[Any]"
    propagated: PropagatedBlock
    reached: float
    target: float
    search: PlanSearch
    missed: "tuple[tuple[pd.Series[Any], float], ...]" = ()
    refused: "tuple[tuple[pd.Series[Any], EinschaltError], ...]" = ()
    next_best: "CheckedPlan | None" = None
    place: str | None = None
    is_counted: bool = False
    asked_where: str = "everywhere"
    finer: dict[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def expected(self) -> ExpectedPrecision:
        """What is expected of the block that was laid out."""
        return self.propagated.expected

    @property
    def is_kept(self) -> bool:
        """Whether the target is reached on the layout too."""
        return bool(self.reached <= self.target)

    @property
    def dropped(self) -> tuple[str, ...]:
        """Other plans that were tried, with why they are not recommended."""
        missed = (
            f"{describe_plan(plan)}: {missed_in_cm(reached, self.target)}"
            for plan, reached in self.missed
        )
        refused = (f"{describe_plan(plan)}: {told(why)}" for plan, why in self.refused)
        return (*missed, *refused)

    def verdict(self) -> str:
        """Return which plan holds, the next best, and what does not hold."""
        lines = [wrapped(self.outcome(), indent="  ")]
        lines.append(f"  {describe_heights(self.plan)}")
        if self.plan["n_coverages"] == 1:
            lines.append(wrapped(translated(ONE_COVERAGE), first="  ", indent="    "))
        elif self.asked_where != "everywhere":
            said = translated(WHERE_IS_OF_ONE, where=self.asked_where)
            lines.append(wrapped(said, first="  ", indent="    "))
        if self.next_best is not None:
            other = self.next_best
            message = mark("Next best: {reached} with {plan}; {dearer} (estimated).")
            if self.is_counted:
                message = mark("Next best: {reached} with {plan}; {dearer} (counted).")
            said = translated(
                message,
                reached=_in_cm(other.reached),
                plan=describe_plan(other.plan),
                dearer=_dearer(other.plan["cost"] / self.plan["cost"]),
            )
            lines.append(wrapped(said, first="  ", indent="    "))
        said = [*self._said_of_missed(), *said_of_refused(self.refused)]
        said += [describe_finer(self.finer)] if self.finer else []
        lines += [wrapped(text, first="  ", indent="    ") for text in said]
        return "\n".join(lines)

    def _said_of_missed(self):
        """The cheapest plans that miss the target, and how many more there are."""
        missed = sorted(self.missed, key=lambda found: found[0]["cost"])
        for plan, reached in missed[:MOST_SAID]:
            yield translated(
                "Misses the target: {plan}: {reached}; estimated cost {cost} per km²",
                reached=missed_in_cm(reached, self.target),
                plan=describe_plan(plan),
                cost=number(plan["cost"], 3),
            )
        if len(missed) > MOST_SAID:
            n = len(missed) - MOST_SAID
            yield translated("{n:more plan misses|more plans miss} the target.", n=n)

    def outcome(self) -> str:
        """Say whether it is recommended, what it comes to, and where, in a sentence."""
        message = mark(
            "No plan is recommended. Checked by propagation on a layout: {reached} "
            "with {plan}. That is more than {target}."
        )
        if self.is_kept:
            message = mark(
                "Recommended: {reached} with {plan}. Checked by propagation on a "
                "layout."
            )
        reached = _in_cm(self.reached)
        if not self.is_kept:
            reached = missed_in_cm(self.reached, self.target)
        if self.place is not None:
            place = translated(OF_ONE_COVERAGE[self.place])
            reached = translated("{error} ({place})", error=reached, place=place)
        return translated(
            message,
            reached=reached,
            plan=describe_plan(self.plan),
            target=_in_cm(self.target),
        )

    def summary(self) -> str:
        """Return which plan holds, and its expected precision."""
        return f"{self.verdict()}\n\n{self.expected.summary()}"


@in_english
def check_plans(
    search,
    frame,
    *,
    most=MOST_TRIED,
    enough=RECOMMENDED,
    patience=PATIENCE,
    at_once=1,
    judge=None,
    cost=None,
    cost_on_layout=None,
    spent=None,
    refine=None,
    progress=None,
) -> CheckedPlan:
    """Find the cheapest plan that reaches the target on its own layout.

    So many as ``most`` are propagated: always the cheapest that is likely to be kept,
    by the closed estimate and what layouts have shown of it, until ``enough`` are and
    no cheaper one is likely to be. Those that cannot be laid out are not among them,
    nor tried with other settings, which have the same layout. After ``patience``
    misses, what a layout is worse than the closed estimate is asked of all. Where none
    is kept, it is the best of these. With one coverage gross errors stay unseen: such
    plans are tried only where the search has no others. EinschaltError where not one
    can be laid out.

    So many as ``at_once`` are propagated beside each other, on any machine, so that the
    plan does not depend on its cores; the later ones are chosen with less knowledge.

    ``judge(plan)`` gives the propagated block of a row of the search, by default that
    of a square layout, in a thread where several are beside each other; ``cost(plan)``
    what it costs as it was laid out, by default the cost of the row;
    ``cost_on_layout(plan)`` what it would cost as it is laid out, for each km², where
    rows have but an estimate: asked of plans that may be the cheapest, before one is
    propagated; None where counting has taken enough. ``spent()`` gives the part of the
    work that was allowed for which layouts were propagated: once one keeps the target,
    and no work is left, no more are tried. ``refine`` names choices of which values
    between those of the search are tried as well, about the cheapest that is kept,
    about the next where costs are counted, and about near misses of another kind:
    those of ``finer_choices``. ``progress(title, fraction)`` is told.
    """
    refine = _names_of_choices(refine)
    require_overlaps(frame.image_format, frame.forward_overlap, frame.side_overlap)
    judge = judge or (lambda plan: propagate_design(design_of(plan, frame)))
    cost = cost or (lambda plan: plan["cost"])
    plans = _with_several_coverages(search)
    trials = Trials(plans, search.target, patience, enough, cost_on_layout)
    # what progress counts
    all_tried = most + (MOST_BETWEEN if refine else 0)
    # BLAS before the threads, each of which asks for the same
    with one_blas_thread(), working_on_parts(at_once) as on_parts:
        tries = _Tries(search, judge, cost, progress, at_once, on_parts, spent)
        tries.go(trials, most, all_tried, work=FOR_GIVEN_VALUES if refine else 1.0)
        best = tries.best()
        if refine and best.is_kept:
            cheapest = [best, best.next_best][: 1 if cost_on_layout is None else 2]
            more = _between(tries, cheapest, frame, refine)
            tries.search = search = searched_with(search, more)
            trials = trials.extended(pd.concat([plans, more]))
            tries.go(trials, len(tries.tried) + MOST_BETWEEN, all_tried)
            best = tries.best()
    finer = finer_choices(search.plans, best.plan) if best.is_kept else {}
    return replace(best, search=search, finer=finer)


def _names_of_choices(refine):
    """Choices that are refined, as a list: of one name, of several, or of none."""
    if refine is None:
        return []
    names = [refine] if isinstance(refine, str) else refine
    expected = f"None, or a list of {', '.join(REFINED)}"
    require_kind("refine", names, (list, tuple, set), expected=expected)
    for name in names:
        require_choice("refine", name, tuple(REFINED))
    # the order of a set is that of this run
    return sorted(names) if isinstance(names, set) else list(names)


def _between(tries, cheapest, frame, refine):
    """Plans between those of a search, about the best ones and what came near to them.

    ``cheapest``: the best, and the next best where costs are counted, which may gain
    more; estimates tell less of it, and it would take trials from the best. With
    another number of coverages, or of control points in a model, none may have been
    kept, and one between may be: about the one of each that misses the target by the
    least.
    """
    about = [one.plan for one in cheapest if one is not None]
    about += tries.nearest_of_others(cheapest[0].plan)
    found = tries.search.plans.iloc[:0]
    for plan in about:
        more = plans_between(tries.search, plan, frame, refine)
        found = pd.concat([found, more[~is_among(more, found)]])
    first = tries.search.plans.index.max() + 1
    return found.set_axis(range(first, first + len(found)))


@dataclass
class _Tries:
    """Layouts that were propagated or refused, and what that needs."""

    search: PlanSearch
    judge: Callable
    cost: Callable
    progress: Callable | None
    at_once: int
    on_parts: Callable  # as over_parts
    spent: Callable | None  # part of the work that is allowed
    tried: list = field(default_factory=list)  # CheckedPlan with its cost
    refused: list = field(default_factory=list)  # errors
    # by name of a plan: itself with its error [m], or with the reason
    dropped: dict = field(default_factory=dict)

    def go(self, trials, most, all_tried, work=1.0):
        """Try what is worth it, until ``most`` are propagated in all.

        Or until one is kept, and a part of the ``work`` that is allowed is done.
        """
        while len(self.tried) < most and len(self.refused) < MOST_REFUSED:
            if trials.kept_costs and self.spent is not None and self.spent() >= work:
                break
            plans = trials.next_ones(min(self.at_once, most - len(self.tried)))
            if not plans:
                break
            if self.progress is not None:
                n_tried, n_refused = len(self.tried), len(self.refused)
                done = max(n_tried / all_tried, n_refused / MOST_REFUSED)
                self.progress("laying out plans", done)
            judged = self.on_parts(self._judged, plans)
            for plan, found in zip(plans, judged, strict=True):
                self._take(trials, plan, found)

    def _judged(self, plan):
        """Propagate a plan, or give the error that refuses it."""
        try:
            return self.judge(plan)
        except EinschaltError as error:
            return error

    def _take(self, trials, plan, found):
        """Keep what became of a plan, and let trials learn of it."""
        if isinstance(found, EinschaltError):
            self._refuse(trials, plan, found)
            return
        try:
            checked, cost = self._checked(plan, found, is_last=not trials.promise)
        except EinschaltError as error:
            self._refuse(trials, plan, error)
            return
        trials.learn(checked, cost)
        self.tried.append((checked, cost))
        if not checked.is_kept:
            self.dropped[plan.name] = plan, checked.reached

    def _refuse(self, trials, plan, error):
        self.refused.append(error)
        trials.refuse(plan)
        self.dropped[plan.name] = plan, error

    def _checked(self, plan, propagated, *, is_last):
        """Hold a plan against its target; with its cost, None if that is not needed."""
        search = self.search
        reached, place = _at_place(propagated, search.where)
        given = {"place": place, "asked_where": search.where}
        found = CheckedPlan(plan, propagated, reached, search.target, search, **given)
        return found, self.cost(plan) if found.is_kept or is_last else None

    def nearest_of_others(self, best):
        """Plans that miss the target by little, one of each kind but that of the best.

        Kinds differ in what no value lies between: coverages, and control in a model.
        """
        nearest = {}
        for found, _ in sorted(self.tried, key=lambda one: one[0].reached):
            if 0.0 < found.reached / self.search.target - 1.0 < NEARLY:
                kind = tuple(found.plan[name] for name in KIND)
                nearest.setdefault(kind, found.plan)
        nearest.pop(tuple(best[name] for name in KIND), None)
        return nearest.values()

    def best(self):
        """Put the cheapest that is kept, the next and the dropped ones together."""
        by_cost = sorted(
            (t for t in self.tried if t[0].is_kept), key=lambda found: found[1]
        )
        cheapest = [found for found, _ in by_cost]
        dropped = dict(self.dropped)
        best = cheapest[0] if cheapest else self._nearest(dropped)
        dropped.pop(best.plan.name, None)
        refused, missed = [], []
        for plan, why in dropped.values():
            to = refused if isinstance(why, EinschaltError) else missed
            to.append((plan, why))
        why_not = {"missed": tuple(missed), "refused": tuple(refused)}
        return replace(best, **why_not, next_best=_other_than(best, cheapest[1:]))

    def _nearest(self, dropped):
        """Give the most precise of those that miss, if what it takes can be told."""
        refused = [*self.refused]
        for found, _ in sorted(self.tried, key=lambda found: found[0].reached):
            try:
                self.cost(found.plan)
            except EinschaltError as error:
                refused.append(error)
                dropped[found.plan.name] = found.plan, error
            else:
                return found
        raise _commonest(refused)


def _other_than(best, others):
    """The cheapest of the others that is another flight, or else the cheapest."""
    other = [found for found in others if not _is_alike(found.plan, best.plan)]
    return next(iter(other or others), None)


def _is_alike(plan, other):
    """Whether two plans differ by so little that they are no choice."""
    alike = ("spacing", "n_coverages", "control_per_model")
    flights = ["scale_number", "high_scale_number"]
    ratios = np.log((plan[flights] / other[flights]).astype(float))
    return all(plan[n] == other[n] for n in alike) and max(abs(ratios)) < ALIKE


def said_of_refused(refused):
    """Say which plans cannot be flown: each reason once, with the cheapest of them."""
    by_reason = {}
    for plan, error in refused:
        by_reason.setdefault(error.expected or str(error), []).append((plan, error))
    for among in by_reason.values():
        plan, error = among[0]
        message = mark("Not recommended: {plan}: {reason}")
        if len(among) > 1:
            message = mark("Not recommended: {n} plans such as {plan}: {reason}")
        yield translated(
            message, n=len(among), plan=describe_plan(plan), reason=told(error)
        )


def _commonest(refused):
    """The commonest of the reasons for which layouts were refused, and how common."""
    by_reason = {}
    for error in refused:
        by_reason.setdefault(error.expected or str(error), []).append(error)
    first, *others = max(by_reason.values(), key=len)
    if len(refused) == 1:
        return first
    message = "{n} of {n_all} layouts that were tried are refused alike"
    said = kept(message, n=1 + len(others), n_all=len(refused))
    return first.with_facts(found=f"{said}: {first.found}")


def _with_several_coverages(search):
    """Give plans that see gross errors, if there are any."""
    several = search.plans[search.plans["n_coverages"] > 1]
    return several if len(several) else search.plans


def _dearer(ratio):
    if ratio < 1.005:
        return translated("as dear")
    return translated("{share} dearer", share=per_cent(ratio - 1.0))


def _in_cm(metres):
    # so far that 5.02 and 5.00 cm differ
    return f"{figure(100.0 * metres, '.2f')} cm"


def _at_place(propagated, where):
    """Give the error at the place of a target, and which place of models that is."""
    if propagated.design.n_coverages > 1:
        return propagated.mean, None
    figures = propagated.expected.figures
    places = ("centre", "edge", "corner") if where == "everywhere" else (where,)
    single = {place: getattr(figures, f"single_{place}") for place in places}
    # NaN where no point lies at a place
    place = max(single, key=lambda place: np.nan_to_num(single[place]))
    return single[place], place
