"""Does a plan that is recommended keep its target on a layout of its own?

Random requests, as planners might make them, without an area and over areas of any
outline, level or not; UAVs below the height that they may usually fly, and half of the
others below a limit of their own. What a refusal advises is asked for instead. What is
recommended is laid out and propagated once more with other points (over areas about the
control that the plan has), which judges it. With the points that it was checked with
the same figure comes that decided, which judges nothing.
"""

import re
from dataclasses import dataclass, field, replace

import numpy as np
from tests.truth.long_form.area_plans import CAMERAS_OF, star_shaped
from tests.truth.long_form.figures import Figure, Table, of_blocks

from einschalt.foundations.errors import EinschaltError
from einschalt.pipeline.planning.area.layout import lay_out
from einschalt.pipeline.planning.area.recommended import (
    plan_area,
    propagate,
    search_over,
)
from einschalt.pipeline.planning.area.tried_layouts import OverGround, design_over
from einschalt.pipeline.planning.choice.check import check_plans
from einschalt.pipeline.planning.choice.finer_choices import REFINED
from einschalt.pipeline.planning.choice.rows import design_of
from einschalt.pipeline.planning.estimate.search import (
    PlanChoices,
    PlanFrame,
    find_plans,
)
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.pipeline.planning.flights.costs import PlanCosts
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights
from einschalt.pipeline.planning.propagation.expected_precision import propagate_design

N_REQUESTS, N_OVER_AREAS = 200, 50
LIMITED, ON_RELIEF, RIGID, BY_PAPER, SINGLE = 0.5, 0.5, 0.2, 0.2, 0.1  # of requests
REFUSED_AT_MOST = 2  # times, each with advice
OTHERS_OVER_AREA = 4
"""Sets of other points: areas are small, and one with 55 new points has 2 % more or
less with each set."""
ADVICE = {
    "spacing": re.compile(r"spacings of at most ([\d.]+) m"),
    "scale_number": re.compile(r"scale numbers of at most ([\d.]+)"),
}
WITH_OTHER_POINTS = 1.02
"""What other points of the same spacing may make of a target that is just kept."""


@dataclass(frozen=True)
class Request:
    """What a planner asks for."""

    camera: str
    target: float
    choices: PlanChoices
    frame: PlanFrame
    # where and by, as find_plans has them
    judged: dict = field(default_factory=dict)

    @property
    def kind(self):
        """Film, large format or UAV."""
        return next(kind for kind, names in CAMERAS_OF.items() if self.camera in names)


@dataclass(frozen=True)
class Outcome:
    """What became of a request; the shares of its target are NaN unless recommended."""

    kind: str
    what: str  # "recommended", "none", "refused"
    own: float = np.nan
    other: float = np.nan
    is_single: bool = False  # one coverage, where there were others


def random_request(seed):
    """Draw a target, choices and a frame."""
    rng = np.random.default_rng(seed)
    camera = str(rng.choice(list(CAMERAS)))
    preset = CAMERAS[camera]
    scales = np.array(preset.scale_numbers) * rng.uniform(0.6, 1.6)
    least = 2 if rng.random() < 0.7 else 1
    frame = PlanFrame(
        kind=str(rng.choice(["affine", "helmert"])),
        image_format=preset.image_format,
        principal_distance=preset.principal_distance,
        forward_overlap=preset.forward_overlap,
        side_overlap=preset.side_overlap,
        control_standard_error=rng.uniform(0.01, 0.05),
        costs=PlanCosts(setting=rng.uniform(0, 1), control_point=rng.uniform(20, 500)),
        sampled_um=preset.sampled_um,
    )
    choices = PlanChoices(
        scale_number=tuple(scales),
        spacing=(float(rng.choice(preset.spacings)),),
        m_g_um=preset.m_g_um[:1],
        n_coverages=(least, least + 1),
    )
    target = rng.uniform(0.6, 2.0) * preset.m_0[0] * 0.5
    request = Request(camera, float(target), choices, frame)
    return _with_more(request, np.random.default_rng([seed, 2]))


def _with_more(request, rng):
    """Draw a limit of height, and now and then what is seldom asked for."""
    frame, choices = request.frame, request.choices
    limit = CAMERAS[request.camera].max_height  # as the command line has it
    if limit is None and rng.random() < LIMITED:
        limit = _binding_limit(rng, frame, choices)
    kind = "rigid" if rng.random() < RIGID else frame.kind
    by = "paper" if rng.random() < BY_PAPER else "expected"
    where = "everywhere"
    if rng.random() < SINGLE:
        where = str(rng.choice(["everywhere", "edge", "centre"]))
        choices = replace(choices, n_coverages=(1,))
    frame = replace(frame, max_height=limit, kind=kind)
    judged = {"where": where, "by": by}
    return replace(request, frame=frame, choices=choices, judged=judged)


def _binding_limit(rng, frame, choices):
    """Draw a limit that some of the high flights keep, and some do not [m]."""
    heights = frame.principal_distance * np.outer(
        choices.scale_number, choices.high_over_low
    )
    return float(rng.uniform(heights.min(), heights.max()))


def _as_advised(answer, request):
    """Answer a request; what a refusal advises is asked for instead.

    EinschaltError where nothing is advised, or that is refused as well.
    """
    for _ in range(REFUSED_AT_MOST):
        try:
            return request, answer(request)
        except EinschaltError as error:
            advised = {
                name: (float(found[1]),)
                for name, pattern in ADVICE.items()
                if (found := pattern.search(error.remedy or ""))
            }
            if not advised:
                raise
            request = replace(request, choices=replace(request.choices, **advised))
    return request, answer(request)


def _searched(request):
    frame = request.frame
    found = find_plans(request.target, request.choices, frame, **request.judged)
    return check_plans(found, frame, refine=list(REFINED))


def outcome_of(seed):
    """Search for a plan, and propagate what is recommended once more."""
    request = random_request(seed)
    try:
        request, checked = _as_advised(_searched, request)
    except EinschaltError:
        return Outcome(request.kind, "refused")
    if not checked.is_kept:
        return Outcome(request.kind, "none")
    design = design_of(checked.plan, request.frame)
    own, other = (propagate_design(design, seed=of_points) for of_points in (0, 1))
    return _recommended(request.kind, request, checked.search, own, [other])


def _recommended(kind, request, search, own, others):
    """What a recommended plan comes to, with its own points and with others."""
    shares = [
        _at_place(block, request.judged["where"]) / request.target
        for block in (own, *others)
    ]
    other = float(np.sqrt(np.mean(np.square(shares[1:]))))
    # with a limit of height, plans of two coverages may take too much control
    is_single = own.design.n_coverages == 1 < search.plans["n_coverages"].max()
    return Outcome(kind, "recommended", float(shares[0]), other, bool(is_single))


def _at_place(block, where):
    """Error of a propagated block at the place of its target [m]."""
    if block.design.n_coverages > 1:
        return block.mean
    figures = block.expected.figures
    places = ("centre", "edge", "corner") if where == "everywhere" else (where,)
    return np.nanmax([getattr(figures, f"single_{place}") for place in places])


def outcome_over_area(seed):
    """The same over an area of some models of the smallest scale, level or not."""
    request = random_request(seed)
    rng = np.random.default_rng([seed, 1])
    largest = max(request.choices.scale_number) * np.max(request.frame.image_format)
    area = star_shaped(rng, float(rng.uniform(2.0, 4.0) * largest))
    heights = None
    if rng.random() < ON_RELIEF:
        heights = relief_over(rng, area, request)
    kind = f"{request.kind}, over areas"

    def planned(request):
        given = (request.target, area, request.choices, request.frame)
        found, frame = search_over(*given, **request.judged)
        return plan_area(area, found, frame, heights=heights, refine=list(REFINED))

    try:
        request, plan = _as_advised(planned, request)
    except EinschaltError:
        return Outcome(kind, "refused")
    if not plan.is_recommended:
        return Outcome(kind, "none")
    layouts = _own_and_others(plan, OverGround.under(plan.frame, heights, None))
    own, *others = map(propagate, layouts)
    return _recommended(kind, request, plan.search, own, others)


def _own_and_others(plan, ground):
    """Lay a plan out as it was checked, and with other points about its control."""
    design, row = plan.checked.propagated.design, plan.checked.plan
    own = ground.flown(lay_out(plan.checked_on, design), row)
    yield own
    # control is surveyed where the plan has it, whatever the points about it, of which
    # none are left out
    control = own.position[own.control]
    dense = design_over(plan.checked_on, design, np.inf)
    for seed in range(1, 1 + OTHERS_OVER_AREA):
        level = lay_out(plan.checked_on, dense, seed=seed, control=control)
        # over ground that is not level control would be chosen anew
        yield replace(ground.flown(level, row), is_control=level.is_control)


def relief_over(rng, area, request):
    """Draw terrain over an area and beside it: some waves, for the lowest flight."""
    frame, scales = request.frame, request.choices.scale_number
    low, high = np.array(area.shape.bounds).reshape(2, 2)
    axes = np.linspace(2 * low - high, 2 * high - low, 61).T
    plane = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    lowest = frame.principal_distance * min(scales)
    if frame.max_height is not None:
        lowest = min(lowest, frame.max_height)
    waves = rng.uniform(0.3, 1.5, 4) / np.max(high - low)
    phase, towards = rng.uniform(0, 2 * np.pi, (2, 4))
    along = plane @ np.stack([np.cos(towards), np.sin(towards)])
    surface = np.sin(2 * np.pi * waves * along + phase).mean(axis=1)
    height = 500.0 + rng.uniform(0.01, 0.10) * lowest * surface
    return GroundHeights(plane, height, "drawn").over(area)


def tables():
    """Run the study.

    Returns
    -------
    list of Table
    """
    outcomes = of_blocks(outcome_of, range(N_REQUESTS))
    outcomes += of_blocks(outcome_over_area, range(N_OVER_AREAS))
    kinds = [*CAMERAS_OF, *(f"{kind}, over areas" for kind in CAMERAS_OF)]
    return [
        Table(
            f"Recommended plans, {N_REQUESTS + N_OVER_AREAS} random requests",
            "What is recommended is laid out and propagated once more. Largest error "
            "divided by the target: with the points that it was checked with (for "
            "comparison: it was recommended because this is at most 1), and with other "
            f"points, which judge it (bound {WITH_OTHER_POINTS}; over areas, which are "
            f"small, the root mean square of {OTHERS_OVER_AREA} sets of them; control "
            "stays where the plan has it, and no point is left out). Nothing is "
            "recommended where no plan keeps the target; refused are requests that no "
            "plan fits, with the spacings and scales that refusals advise either "
            "(bound 0). UAVs fly below 120 m, half of the others below a limit that "
            "some of the flights asked for exceed; half of the areas are not level.",
            (
                *("request", "number", "recommended", "nothing", "refused"),
                *("one coverage", "largest, own points", "other points"),
            ),
            [_row(kind, [o for o in outcomes if o.kind == kind]) for kind in kinds],
        )
    ]


def _row(kind, outcomes):
    whats = [outcome.what for outcome in outcomes]
    counts = [str(whats.count(what)) for what in ("recommended", "none")]
    refused = Figure(whats.count("refused"), high=0, form="d")
    good = [outcome for outcome in outcomes if outcome.what == "recommended"]
    largest = ("–", "–")  # of no plan
    if good:
        largest = (
            Figure(max(outcome.own for outcome in good)),
            Figure(max(outcome.other for outcome in good), high=WITH_OTHER_POINTS),
        )
    n_single = sum(outcome.is_single for outcome in good)
    single = Figure(n_single, high=0, form="d")
    return (kind, str(len(outcomes)), *counts, refused, single, *largest)
