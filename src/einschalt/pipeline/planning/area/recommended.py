"""The flight plan over an area that keeps a target on its own layout."""

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import pandas as pd

from einschalt.foundations.arguments import require_kind
from einschalt.foundations.errors import EinschaltError, GeometryError
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import figure, in_english, mark_each, translated
from einschalt.foundations.typesetting import (
    decimals_for,
    fixed,
    per_cent,
    table,
    wrapped,
)
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.flight_plan import (
    FlightPlan,
    GroundTooHighError,
    flight_plan,
    require_above_ground,
    require_overlap,
    said_of_level_ground,
    said_of_limit,
)
from einschalt.pipeline.planning.area.high_ground import remedy_above
from einschalt.pipeline.planning.area.layout import (
    FLIGHTS,
    AreaLayout,
    lay_out,
    require_one_model,
    require_rows,
    require_size,
)
from einschalt.pipeline.planning.area.on_the_ground import require_cover
from einschalt.pipeline.planning.area.tried_layouts import (
    OverGround,
    TriedLayouts,
    design_over,
    laid_out,
    require_densified,
)
from einschalt.pipeline.planning.choice.check import CheckedPlan, check_plans
from einschalt.pipeline.planning.choice.rows import design_of
from einschalt.pipeline.planning.estimate.possible_layouts import (
    MOST_MODELS,
    fits_in,
    models_over,
)
from einschalt.pipeline.planning.estimate.search import (
    PlanFrame,
    PlanSearch,
    find_plans,
)
from einschalt.pipeline.planning.flights.arguments import flown_model
from einschalt.pipeline.planning.flights.costs import COLUMN_OF_ITEM
from einschalt.pipeline.planning.flights.points_in_models import (
    downwards,
)
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights
from einschalt.pipeline.planning.propagation.expected_precision import (
    on_a_plane,
    propagate_scene,
)
from einschalt.pipeline.simulation.simulate_block import scene_of_layouts
from einschalt.stages.results import Result

MOST_LEFT_OUT = 0.002
# layouts that are propagated, those of them that may miss, and that keep the target:
# the closed estimate may take the fourth cheapest for the first
MOST_TRIED, PATIENCE, ENOUGH = 16, 4, 3
AT_ONCE = 2  # layouts that are propagated side by side, whatever the machine
# where each takes a second or more, of areas of so many points
LARGE, MOST_OF_LARGE = 20_000, 10
# pairs of models at the points of all layouts that are propagated, of both flights:
# two or three seconds, where dozens of models hold each point
MOST_PAIRS = 5_500_000
ITEM_TEXT = mark_each(
    {
        "image": "photographs",
        "model": "models",
        "setting": "pointings at a point",
        "control_point": "control points",
    }
)


@dataclass(frozen=True, eq=False, repr=False)
class AreaPlan(Result):
    """A flight plan whose precision was propagated on its own layout.

    Attributes
    ----------
    area : FlightArea
        The polygon that is covered [m].
    search : PlanSearch
        All plans by estimate; the border of the area counts.
    checked : CheckedPlan
        The plan and its propagated precision [m]; costs as they were counted.
    layout : AreaLayout
        Models, points and control of the whole area [m].
    checked_on : FlightArea
        All of the area, or the part on which precision was propagated [m].
    flown : FlightPlan
        What is flown and measured: lines, photographs, control, effort.
    next_flown : FlightPlan, optional
        The same of the next best plan.
    notes : tuple of str
        What is to be said of the area, the ground and plans that were not tried.
    frame : PlanFrame
        What was at hand.
    heights : GroundHeights, optional
        Heights of the terrain over the area [m].
    follows : bool
        Whether photographs follow the ground.
    """

    area: FlightArea
    search: PlanSearch
    checked: CheckedPlan
    layout: AreaLayout
    checked_on: FlightArea
    flown: FlightPlan
    next_flown: FlightPlan | None
    notes: tuple[str, ...]
    frame: PlanFrame
    heights: GroundHeights | None
    follows: bool

    @property
    def is_recommended(self) -> bool:
        """Whether it keeps the target."""
        return self.checked.is_kept

    @property
    def expected_points(self) -> pd.DataFrame:
        """Points with their expected precision [m], in the system of the area.

        As ``checked.expected.points``, whose axes are those of the strips.
        """
        points = self.checked.expected.points
        ground = self.checked_on.to_ground(points[["easting", "northing"]])
        return points.assign(easting=ground[:, 0], northing=ground[:, 1])

    def summary(self) -> str:
        """Return the plan, the next best, what it takes, and its precision."""
        parts = [
            self.verdict(),
            self.checked.expected.summary(),
            self.search.summary(),
        ]
        return "\n\n".join(parts)

    def verdict(self) -> str:
        """Return the plan, the next best, and what it takes."""
        notes = map(retold, [*self.area.notes, *self.notes])
        said = [self.area.describe(), *notes]
        lines = [self.checked.verdict()]
        lines += [wrapped(one, first="  ", indent="    ") for one in said]
        return "\n".join([*lines, "", _effort_text(self)])


@in_english
def frame_over(area, frame) -> PlanFrame:
    """What is at hand, as plans over an area are searched with: its border counts."""
    require_kind("frame", frame, PlanFrame, expected="a PlanFrame")
    length, width = area.extent
    extent = (length, width, float(area.shape.area))
    return replace(frame, shares_control=True, extent=extent)


@in_english
def search_over(target, area, choices, frame, *, where="everywhere", by="expected"):
    """Find plans as :func:`find_plans` does; the border of an area counts.

    Gives the search and the frame for :func:`plan_area`.
    """
    frame = frame_over(area, frame)
    try:
        return find_plans(target, choices, frame, where=where, by=by), frame
    except GeometryError:
        _require_least_model(area, choices, frame)  # where the area itself is at fault
        raise


def _require_least_model(area, choices, frame):
    """Refuse an area that is too small for the least model and spacing to choose."""
    require_one_model(area, flown_model(frame), min(choices.scale_number))
    require_rows(area, min(choices.spacing))


def plan_area(
    area, search, frame, *, heights=None, follows=None, refine=None, progress=None
):
    """Find the cheapest plan of a search that keeps its target over an area.

    Each plan that is tried is laid out over the area and propagated there; where the
    area has too many models for that, over a part of it that has borders of its own.
    ``heights``: GroundHeights over the area; ``follows``: see :func:`flight_plan`; left
    out, where flying heights are limited; ``refine``: see :func:`check_plans`.

    GeometryError where no plan can be laid out: the area is smaller than a model, or
    the ground is too high.
    """
    ground = OverGround.under(frame, heights, follows)
    try:
        return _planned(area, search, frame, ground, progress, refine)
    except GroundTooHighError as error:

        def is_plan(frame, choices):
            try:
                given = {"where": search.where, "by": search.by}
                found = find_plans(search.target, choices, frame, **given)
                _require_overlap_of_some(area, found.plans, frame, ground)
                return _planned(area, found, frame, ground, progress).is_recommended
            except EinschaltError:
                return False

        remedy = remedy_above(search, frame, is_plan)
        raise error.with_facts(remedy=remedy) from None


def _require_overlap_of_some(area, plans, frame, ground):
    """Refuse ground that is too high for the largest scales and for the smallest."""
    by_scale = plans.iloc[np.argsort(plans["high_scale_number"], kind="stable")]
    try:
        laid_out(area, by_scale.iloc[-1], frame, ground)
    except GroundTooHighError:
        laid_out(area, by_scale.iloc[0], frame, ground)


def _planned(area, search, frame, ground, progress, refine=None) -> AreaPlan:
    search, left_out = _that_fit(area, search, frame)
    over = _OverArea(TriedLayouts(area, frame, ground))
    checked = check_plans(
        *(search, frame),
        most=_most_tried(area, search),
        patience=PATIENCE,
        enough=ENOUGH,
        at_once=AT_ONCE,
        judge=over.judge,
        cost=over.cost,
        cost_on_layout=over.layouts.cost,
        spent=over.spent,
        refine=refine,
        progress=progress,
    )
    layout, flown, said = over.whole(checked.plan)
    other = checked.next_best
    next_flown = None if other is None else over.whole(other.plan)[1]
    if other is not None:
        other = _priced(other, next_flown.effort, area)
    best = replace(_priced(checked, flown.effort, area), next_best=other)
    part = over.layouts.of(best.plan)
    notes = [*said, *_note_of_part(part, layout), *left_out]
    parts = (area, checked.search, best, layout, part.layout.area, flown, next_flown)
    return AreaPlan(*parts, tuple(notes), frame, ground.heights, ground.follows)


@dataclass(frozen=True, eq=False)
class _OverArea:
    """What plans of a search are worth over an area, and what they take."""

    layouts: TriedLayouts
    # by name of a plan: its whole layout, its FlightPlan, and what is to be said of it
    wholes: dict = field(default_factory=dict)
    n_pairs: list = field(default_factory=list)  # of each layout that was propagated

    def judge(self, plan):
        """Propagate a row of a search; GeometryError where its layout is refused."""
        found = self.layouts.of(plan)
        _require_held(found.layout)
        if not found.is_part:  # a part has more, for its border
            require_densified(found.layout, plan, self.layouts.frame.max_height)
        self.n_pairs.append(_pairs_of_models(found.layout))
        return propagate(found.layout)

    def spent(self):
        """Part of the work that is allowed for which layouts were propagated."""
        return sum(self.n_pairs) / MOST_PAIRS

    def whole(self, plan):
        """Give a plan's layout and FlightPlan over the whole area, and their notes."""
        if plan.name not in self.wholes:
            over, found = self.layouts, self.layouts.of(plan)
            whole = _whole(over.area, plan, found, over.frame, over.ground)
            self.wholes[plan.name] = whole
        return self.wholes[plan.name]

    def cost(self, plan):
        """Cost of a plan for each km², by what the area takes, not by the estimate.

        Ground that is too high anywhere in the area refuses what would be kept; level
        ground refuses no line, and none need be drawn.
        """
        found = self.layouts.of(plan)
        if self.layouts.ground.heights is None and not found.is_part:
            return self.layouts.counted(found.layout, plan)
        return self.whole(plan)[1].cost / self.layouts.area.square_km


def _pairs_of_models(layout):
    """Pairs of models that hold a point, each with itself, of all points and flights.

    What propagation takes grows with them.
    """
    held = (np.bincount(flown.point) for flown in layout.flights.values())
    return sum(int((n_models**2).sum()) for n_models in held)


def _most_tried(area, search):
    n_points = area.shape.area / search.plans["spacing"].min() ** 2
    return MOST_OF_LARGE if n_points > LARGE else MOST_TRIED


def _note_of_part(part, whole):
    """Say on what a plan was propagated, where the whole area is too large.

    A part has more control, for its own borders: say what the whole layout has.
    """
    if not part.is_part:
        return []
    length, width = part.layout.area.extent
    said = (
        f"Its precision was propagated on a part of {length:.0f} x {width:.0f} m, "
        "with borders of its own: the whole has too many models. Of the whole area "
        f"{per_cent(len(whole.control) / len(whole.position))} of the points are "
        "control."
    )
    return [said]


def _that_fit(area, search, frame):
    """Leave out plans whose models are too many, or too large as their spacings.

    Gives the search, and a note on those that were left out because of their number.
    """
    plans = search.plans
    n_models = models_over(
        area.shape.area, search.model, plans["scale_number"], plans["n_coverages"]
    )
    if n_models.min() > MOST_MODELS:
        require_size(area, design_of(plans.loc[n_models.idxmin()], frame))
    is_few = n_models <= MOST_MODELS
    plans = plans[is_few]
    length, width = area.extent
    extent = length, width, area.shape.area
    names = ("scale_number", "spacing", "n_coverages")
    is_fit = fits_in({n: plans[n].to_numpy() for n in names}, extent, search.model)
    if not is_fit.any():  # the cheapest of them is refused, with what would do
        require_size(area, design_of(plans.iloc[0], frame))
    fitting = replace(search, plans=plans[is_fit].reset_index(drop=True))
    return fitting, _notes_of_size(area, n_models, int((~is_fit).sum()))


def _notes_of_size(area, n_models, n_large):
    """Say how many plans the area cannot have, and why; the others stand."""
    is_many, said = n_models > MOST_MODELS, []
    if is_many.any():
        largest = area.square_km * MOST_MODELS / n_models.max()
        said.append(
            f"{is_many.sum()} of {len(n_models)} plans were not tried: their low "
            f"flights would take more than {MOST_MODELS} models over this area. Split "
            f"it into parts of at most {downwards(largest)} km² to have all of them "
            "tried."
        )
    if n_large:
        said.append(
            f"{n_large} of {len(n_models)} plans were not tried: the area is too small "
            "for their models, or for points so far apart."
        )
    return said


def _priced(checked, effort, area):
    """Put what a plan takes for each km² down as it was laid out."""
    plan = checked.plan.copy()
    of_item = effort.set_index("item")["amount"] / area.square_km
    for item, column in COLUMN_OF_ITEM.items():
        plan[column] = of_item[item]
    plan["cost"] = effort["cost"].sum() / area.square_km
    return replace(checked, plan=plan, is_counted=True)


def _whole(area, plan, found, frame, ground):
    """Lay a plan out over the whole area, if that was not done when it was judged."""
    layout = found.layout
    if found.is_part:
        layout = lay_out(area, design_over(area, design_of(plan, frame), np.inf))
        layout = ground.flown(layout, plan)
        require_densified(layout, plan, frame.max_height)
    heights, follows = ground.heights, ground.follows
    as_flown = {"follows": follows, "photographs": layout.photographs}
    flown = flight_plan(layout, plan, frame, heights, **as_flown)
    if heights is None:
        said = said_of_level_ground(frame.max_height)
        return layout, flown, [said] if said else []
    said = [
        require_overlap(flown.photographs, plan, layout, heights),
        require_cover(layout),
        require_above_ground(flown.photographs, plan, heights),
        said_of_limit(flown, plan, frame.max_height),
        heights.said_of_zeros(),
    ]
    return layout, flown, [text for text in said if text]


def _require_held(layout):
    share = layout.n_left_out / len(layout.position)
    if share > MOST_LEFT_OUT:
        raise GeometryError(
            f"{per_cent(share, 1)} of the points lie in no model that holds enough "
            "points to be oriented",
            expected="all of them",
            remedy="Give a smaller --spacing, or smaller image scales",
        )


def propagate(layout):
    """Compute the precision that a layout will have; a PropagatedBlock."""
    layouts = {flight: layout.oriented(flight) for flight in FLIGHTS}
    set_anew = partial(
        scene_of_layouts,
        *(layouts, layout.position, layout.is_control),
        geometry=on_a_plane(layout.geometry),
        noise=layout.design.noise(),
        terrain=layout.terrain,
    )
    return propagate_scene(set_anew, layout.design)


def _effort_text(plan):
    """What the plan takes over the whole area, the next best beside it."""
    other = plan.next_flown
    rows = []
    for k, row in enumerate(plan.flown.effort.itertuples()):
        cells = [translated(ITEM_TEXT[row.item]), figure(row.amount, ".0f")]
        cells.append(figure(row.price, "g"))
        cells.append(_cost(row.cost))
        if other is not None:
            cells.append(figure(other.effort["amount"][k], ".0f"))
        rows.append(cells)
    last = [translated("all"), "", "", _cost(plan.flown.cost)]
    header = [
        translated("What the area takes"),
        translated("amount"),
        translated("price"),
        translated("cost"),
    ]
    if other is not None:
        header.append(translated("next best"))
        last.append(translated("cost {cost}", cost=_cost(other.cost)))
    rows.append(last)
    text = table(rows, header=header, align="l" + "r" * (len(header) - 1))
    km = plan.flown.flight_lines["length"].sum() / 1e3
    lines = translated(
        "{n} flight lines of {km} km together.",
        n=len(plan.flown.flight_lines),
        km=fixed(km, 1),
    )
    return f"{text}\n  {lines}"


def _cost(amount):
    """Write what someone will add up: whole, or with three digits where it is small."""
    return fixed(amount, max(0, decimals_for(amount, 3)))
