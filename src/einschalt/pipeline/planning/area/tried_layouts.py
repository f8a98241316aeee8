"""Layouts of the plans of a search over an area, and over its ground."""

from dataclasses import dataclass, replace
from functools import partial
from threading import Lock

import numpy as np

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.typesetting import per_cent
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.flight_plan import amounts_of, require_overlap
from einschalt.pipeline.planning.area.layout import (
    SHORTEST_SIDE,
    AreaLayout,
    lay_out,
    require_size,
)
from einschalt.pipeline.planning.area.on_the_ground import over_ground
from einschalt.pipeline.planning.choice.rows import design_of
from einschalt.pipeline.planning.choice.trials import LAYOUT
from einschalt.pipeline.planning.flights.costs import cost_of
from einschalt.pipeline.planning.flights.flight_design import MOST_WORK, FlightDesign
from einschalt.pipeline.planning.flights.points_in_models import (
    MOST_ON_THE_GROUND,
    downwards,
    of_closer_points,
    refusal_of_control,
)
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights

FEWEST_IN_A_MODEL = 8
"""Points that a model of the checked layout holds at least; else a part is checked."""
MOST_POINTS = 200_000
# points in models of all layouts that are counted, and what the smallest takes as much
# time as: a second, about
MOST_COUNTED, LEAST_COUNTED = 1_000_000, 10_000
LEAST_COUNTED_ON_GROUND = 30_000
WELL_BELOW = 0.9  # of the most control, where points closer to each other are advised


@dataclass(frozen=True, eq=False)
class LaidOut:
    """A plan over the area, or over a part of it, with its precision."""

    layout: AreaLayout
    is_part: bool


@dataclass(frozen=True)
class OverGround:
    """The ground that a plan is flown over, and how it is flown over it."""

    heights: GroundHeights | None = None  # None where it is level
    max_height: float | None = None  # of cameras above ground [m]
    follows: bool = False  # whether photographs follow it

    @classmethod
    def under(cls, frame, heights, follows):
        """With the limit of a frame, where photographs follow the ground by default."""
        limit = frame.max_height
        return cls(heights, limit, limit is not None if follows is None else follows)

    def flown(self, layout, plan):
        """Fly the layout of a row of a search over it.

        GeometryError where it is so high that photographs do not overlap.
        """
        if self.heights is None:
            return layout
        given = layout, self.heights, self.max_height
        ground = {"layout": layout, "heights": self.heights}
        require = partial(require_overlap, plan=plan, **ground)
        return over_ground(*given, follows=self.follows, require=require)


class TriedLayouts:
    """Layouts of plans over an area: one for all that are measured in other ways."""

    def __init__(self, area, frame, ground):
        self.area, self.frame, self.ground = area, frame, ground
        self._known, self._flights, self._work = {}, {}, 0
        self._one_by_one = Lock()  # shapes are prepared as they are cut

    def of(self, plan):
        """Give the layout of a row of a search, with its errors of measuring."""
        found, usual = self._of_any(plan), design_of(plan, self.frame)
        errors = {"m_g_um": usual.m_g_um, "high_m_g_um": usual.high_m_g_um}
        design = replace(found.layout.design, **errors)
        return replace(found, layout=replace(found.layout, design=design))

    def _of_any(self, plan):
        """Give the same layout, with the errors of the plan that had it first."""
        key = tuple(plan[name] for name in LAYOUT)
        with self._one_by_one:
            if key not in self._known:
                self._known[key] = self._tried(plan)
        found = self._known[key]
        if isinstance(found, EinschaltError):
            raise found
        return found

    def _tried(self, plan):
        """Lay a plan out, or give the error that refuses it: that takes as long."""
        try:
            given = self.area, plan, self.frame, self.ground
            return laid_out(*given, known=self._flights)
        except EinschaltError as error:
            return error

    def cost(self, plan):
        """Count what a plan costs for each km²; None where that would take too long.

        NaN for a plan that is laid out on a part of the area only.
        """
        if self._work > MOST_COUNTED:
            return None
        n_known = len(self._known)
        found = self._of_any(plan)
        if len(self._known) > n_known:
            flights = found.layout.flights.values()
            is_level = self.ground.heights is None
            least = LEAST_COUNTED if is_level else LEAST_COUNTED_ON_GROUND
            self._work += least + sum(len(flown.point) for flown in flights)
        if found.is_part:
            return np.nan
        return self.counted(found.layout, plan)

    def counted(self, layout, plan):
        """Count what a plan with some layout costs for each km²."""
        amounts = amounts_of(layout, plan)
        return cost_of(amounts, self.frame.costs) / self.area.square_km


def laid_out(area, plan, frame, ground=OverGround(), *, known=None):
    """Lay a row of a search out as it is propagated: over an area, or a part of it.

    ``known`` keeps flights over the area, as :func:`lay_out` has them.
    """
    usual = design_of(plan, frame)
    require_size(area, usual)
    design = design_over(area, usual)
    model = np.prod(design.geometry().usable_model) * design.scale_number**2
    is_part = model / design.layout_spacing**2 < FEWEST_IN_A_MODEL
    if is_part:  # as large as the layouts of a search
        area = _part_of(area, usual.extent)
        design, known = design_over(area, usual), None
    layout = lay_out(area, design, known=known)
    return LaidOut(ground.flown(layout, plan), is_part=is_part)


def _part_of(area, extent):
    """Cut a rectangle out of an area, about a point that lies well inside."""
    import shapely  # noqa: PLC0415 - loaded when an area is planned

    inside = shapely.get_coordinates(shapely.point_on_surface(area.local_shape))[0]
    half = np.array(extent) / 2.0
    window = shapely.box(*(inside - half), *(inside + half))
    cut = shapely.intersection(area.local_shape, window)
    parts = [p for p in shapely.get_parts(cut) if p.geom_type == "Polygon"]
    largest = max(parts, key=lambda part: part.area)
    return FlightArea(shapely.transform(largest, area.to_ground), area.crs)


def design_over(area, design, most_work=MOST_WORK) -> FlightDesign:
    """Give a design the extent of an area, and no more points than can be held."""
    length, width = (max(side, SHORTEST_SIDE) for side in area.extent)
    design = replace(design, width=length, height=width)
    most_work = min(most_work, MOST_POINTS * design.work_of_a_point)
    return replace(design, most_work=most_work)


def require_densified(layout, plan, max_height):
    """Refuse a layout of which so many points are control that it densifies little.

    ``plan`` is its row of a search, ``max_height`` the limit above ground, None if
    there is none [m].
    """
    # the points as they are planned: those of the layout may be thinned
    spacing = plan["spacing"]
    n_points = layout.area.shape.area / spacing**2
    share = len(layout.control) / n_points
    if share < MOST_ON_THE_GROUND:
        return
    # as many points more; control is chosen among them, and hardly grows
    closer = np.sqrt(WELL_BELOW * MOST_ON_THE_GROUND / share)
    apart = downwards(spacing * closer)
    # control is less where models of the high flight are larger
    limit = np.inf if max_height is None else closer * max_height
    is_limited = plan["high_flying_height"] > limit
    raise refusal_of_control(
        f"{len(layout.control)} control points are {per_cent(share)} of all points",
        of_closer_points(apart, is_limited=is_limited),
    )
