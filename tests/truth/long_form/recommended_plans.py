"""Does a plan that is recommended keep its target on a layout of its own?

Random requests, as planners might make them, without an area and over areas of any
outline. What is recommended is laid out and propagated once more with other points
(over areas about the control that the plan has), which judges it. With the points that
it was checked with the same figure comes that decided, which judges nothing.
"""

from dataclasses import dataclass

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
from einschalt.pipeline.planning.area.tried_layouts import design_over
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
from einschalt.pipeline.planning.propagation.expected_precision import expect_precision

N_REQUESTS, N_OVER_AREAS = 200, 50
WITH_OTHER_POINTS = 1.02
"""What other points of the same spacing may make of a target that is just kept."""


@dataclass(frozen=True)
class Request:
    """What a planner asks for."""

    camera: str
    target: float
    choices: PlanChoices
    frame: PlanFrame

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
    return Request(camera, float(target), choices, frame)


def outcome_of(seed):
    """Search for a plan, and propagate what is recommended once more."""
    request = random_request(seed)
    frame = request.frame
    try:
        found = find_plans(request.target, request.choices, frame)
        checked = check_plans(found, frame, refine=list(REFINED))
    except EinschaltError:
        return Outcome(request.kind, "refused")
    if not checked.is_kept:
        return Outcome(request.kind, "none")
    design = design_of(checked.plan, frame)

    def share(seed_of_points):
        figures = expect_precision(design, seed=seed_of_points).figures
        single = max(figures.single_centre, figures.single_edge)
        reached = single if design.n_coverages == 1 else figures.mean
        return reached / request.target

    is_single = design.n_coverages == 1
    return Outcome(request.kind, "recommended", share(0), share(1), is_single)


def outcome_over_area(seed):
    """The same over an area of some models of the smallest scale."""
    request = random_request(seed)
    rng = np.random.default_rng([seed, 1])
    largest = max(request.choices.scale_number) * np.max(request.frame.image_format)
    area = star_shaped(rng, float(rng.uniform(2.0, 4.0) * largest))
    kind = f"{request.kind}, over areas"
    try:
        found, frame = search_over(request.target, area, request.choices, request.frame)
        plan = plan_area(area, found, frame, refine=list(REFINED))
    except EinschaltError:
        return Outcome(kind, "refused")
    if not plan.is_recommended:
        return Outcome(kind, "none")
    design = plan.checked.propagated.design
    own = lay_out(plan.checked_on, design)
    # control is surveyed where the plan has it, whatever the points about it, of which
    # none are left out
    control = own.position[own.control]
    dense = design_over(plan.checked_on, design, np.inf)
    other = lay_out(plan.checked_on, dense, seed=1, control=control)
    shares = (propagate(layout).mean / request.target for layout in (own, other))
    return Outcome(kind, "recommended", *shares, design.n_coverages == 1)


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
            f"points, which judge it (bound {WITH_OTHER_POINTS}; over areas control "
            "stays where the plan has it, and no point is left out). Nothing is "
            "recommended where no plan keeps the target; refused are requests that no "
            "plan fits (bound 0).",
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
    return (
        *(kind, str(len(outcomes)), *counts, refused),
        Figure(sum(outcome.is_single for outcome in good), high=0, form="d"),
        Figure(max(outcome.own for outcome in good)),
        Figure(max(outcome.other for outcome in good), high=WITH_OTHER_POINTS),
    )
