"""A plan that is tried: the block that would be measured if it were flown.

Photographs, models, control and errors are those of the plan, and points stand as close
as was planned. What is computed from such a block is comparable with what was expected.
"""

from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import pandas as pd

from einschalt.foundations.arguments import described, require_kind
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.language import in_english
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.layout import (
    FLIGHTS,
    geometry_over,
    lay_out,
    with_control_at,
)
from einschalt.pipeline.planning.area.models_over_ground import shown
from einschalt.pipeline.planning.area.on_the_ground import (
    SurveyedTerrain,
    over_ground,
)
from einschalt.pipeline.planning.area.recommended import AreaPlan, propagate
from einschalt.pipeline.planning.area.tried_layouts import (
    OverGround,
    design_over,
    laid_out,
)
from einschalt.pipeline.planning.choice.check import CheckedPlan
from einschalt.pipeline.planning.choice.rows import (
    design_of,
    design_of_row,
    require_frame,
    require_row,
)
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights
from einschalt.pipeline.planning.propagation.expected_precision import (
    ExpectedPrecision,
    propagate_design,
)
from einschalt.pipeline.simulation.layout import name_points, scatter_points, turn
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import (
    SimulatedBlock,
    scene_of_layouts,
    set_scene,
    title_of,
)

LAYOUT_SEED = 0  # of the points: that with which plans are propagated
MOST_RELIEF = 0.025  # standard deviation, of the flying height, where none is known
AS_LONG = 1e-6  # of a length: cameras differ by more
ASKED = {"asked_by": "simulate_plan"}
CHANGES = ("measurement", "transformation", "n_check")
"""What may be measured otherwise than planned: fields of BlockGeometry."""


@dataclass(frozen=True, eq=False)
class PlannedBlock:
    """All of a plan that its simulation needs."""

    design: FlightDesign
    expected: float  # TOTAL error of the new points [m]
    area: FlightArea | None = None  # of a flight plan; else a rectangle of its own
    heights: GroundHeights | None = None  # over the area
    max_height: float | None = None  # of cameras above ground [m]
    follows: bool = False  # whether photographs follow the ground
    name: str = ""  # of the area

    @property
    def title(self) -> str:
        """What the simulated block is called."""
        geometry = self._unthinned.geometry()
        return title_of(geometry, self.name, camera_of(geometry))

    @property
    def _unthinned(self):
        """The design with all its points, as far as they can be held."""
        if self.area is None:
            return replace(self.design, most_work=np.inf)
        return design_over(self.area, self.design, np.inf)

    def simulated(self, seed=0, *, noise=None, title=None, **changes):
        """Measure the block, with errors of a seed; see :func:`simulate_plan`."""
        noise = self.design.noise() if noise is None else noise
        scene = self._scene(noise, changes).with_noise_of(seed)
        return scene.measured(self.title if title is None else title)

    def _scene(self, noise, changes):
        if self.area is None:
            geometry = _as_measured(self._unthinned.geometry(), changes)
            return set_scene(geometry, noise, LAYOUT_SEED)
        flown, geometry = self.flown, _as_measured(self.flown.geometry, changes)
        return scene_of_layouts(
            *(flown.flights, flown.position, flown.is_control),
            geometry=geometry,
            noise=noise,
            seed=LAYOUT_SEED,
            terrain=flown.terrain,
            point_id=flown.point_id,
        )

    @cached_property
    def flown(self) -> "FlownArea":
        """The area as it is flown, with all points; of a plan over one."""
        layout, terrain = lay_out(self.area, self.design, seed=LAYOUT_SEED), None
        if self.heights is not None:
            given = layout, self.heights, self.max_height
            layout = over_ground(*given, follows=self.follows)
            centre = _centre(self.area)  # whose axes are those of the map
            terrain = SurveyedTerrain(self.heights, partial(np.add, centre))
        return _flown(layout, self._unthinned, terrain)


def _as_measured(geometry, changes):
    """Geometry of what is measured otherwise than planned, over gentle ground."""
    unknown = sorted(set(changes) - set(CHANGES))
    if unknown:
        raise SettingsError(
            f"{unknown[0]} cannot be changed in a plan",
            expected=", ".join(CHANGES),
            remedy="Make another plan",
        )
    lowest = geometry.principal_distance * geometry.low_scale_number
    changes.setdefault("relief", min(geometry.relief, MOST_RELIEF * lowest))
    return replace(geometry, **changes)


def camera_of(geometry):
    """Name of the camera preset that has such images, or "".

    Overlaps tell presets of one camera apart; of several cameras that are alike in
    them too, none is named.
    """
    images = geometry.image_format, geometry.across, geometry.principal_distance
    overlaps = geometry.forward_overlap, geometry.side_overlap
    alike = [
        (name, _is_as(overlaps, (camera.forward_overlap, camera.side_overlap)))
        for name, camera in CAMERAS.items()
        if _is_as(images, (*camera.image_format, camera.principal_distance))
    ]
    if len(alike) > 1:
        alike = [(name, is_flown_so) for name, is_flown_so in alike if is_flown_so]
    return alike[0][0] if len(alike) == 1 else ""


def _is_as(has, known):
    return np.allclose(has, known, rtol=AS_LONG, atol=0.0)


@dataclass(frozen=True, eq=False)
class FlownArea:
    """A layout in easting and northing, with all points that are wanted."""

    geometry: object
    position: np.ndarray  # (n_points, 2): easting, northing from the centre [m]
    is_control: np.ndarray  # (n_points,)
    point_id: np.ndarray  # (n_points,): control as the plan's table names it
    flights: dict  # the models that can be oriented, FlightLayout by flight
    terrain: SurveyedTerrain | None


def _centre(area):
    return area.to_ground(np.zeros((1, 2)))[0]


def _flown(layout, design, terrain) -> FlownArea:
    """Turn a layout into easting and northing, its points as close as in a design."""
    area, (east, north) = layout.area, _centre(layout.area)
    position, is_control = _as_close_as(design, layout)
    turned = turn(position, area.direction)
    ground = None if terrain is None else terrain.height(turned)
    spacing = min(layout.geometry.point_spacing, design.layout_spacing)
    geometry = replace(
        layout.geometry,
        point_spacing=float(spacing),
        centre_easting=float(east),
        centre_northing=float(north),
        crs=area.crs,
    )
    if ground is not None:
        geometry = replace(geometry, mean_height=float(ground.mean()))
    flights = {
        flight: shown(flown, geometry, position, ground)
        for flight, flown in layout.flights.items()
    }
    whole = replace(layout, position=position, flights=flights, is_control=is_control)
    names = name_points(len(position))
    names[is_control] = [f"C{k + 1}" for k in range(int(is_control.sum()))]
    oriented = {f: _turned(whole.oriented(f), area.direction) for f in FLIGHTS}
    return FlownArea(geometry, turned, is_control, names, oriented, terrain)


def _as_close_as(design, layout):
    """Local positions of all points; control stays where the plan has set it.

    A plan is propagated with fewer points, where it wants many.
    """
    if layout.geometry.point_spacing <= design.layout_spacing * (1.0 + AS_LONG):
        return layout.position, layout.is_control
    area = layout.area
    dense = scatter_points(
        geometry_over(area, design), np.random.default_rng(LAYOUT_SEED)
    )
    dense = dense[area.holds(dense)]
    return with_control_at(layout.position[layout.control], dense)


def _turned(flown, direction):
    """Turn the models of a flight to the left, about the centre of the area."""
    rasters = (replace(r, direction=r.direction + direction) for r in flown.rasters)
    centre = turn(flown.centre, direction)
    return replace(flown, rasters=tuple(rasters), centre=centre)


def planned_block(plan, frame=None, *, name="") -> PlannedBlock:
    """Take what a simulation needs out of a plan.

    ``plan`` is an AreaPlan, a FlightDesign, an ExpectedPrecision, a CheckedPlan, or a
    row of a search, of which ``frame`` tells the camera; or what it gives.
    """
    if frame is not None:
        _check_frame(plan, frame)
    if isinstance(plan, PlannedBlock):
        return plan
    if isinstance(plan, AreaPlan):
        given = plan.area, plan.heights, plan.frame.max_height, plan.follows
        expected = plan.checked.expected.figures.mean
        return PlannedBlock(plan.layout.design, expected, *given, name)
    if isinstance(plan, CheckedPlan):
        _require_whole(plan)
        plan = plan.expected
    if isinstance(plan, ExpectedPrecision):
        return PlannedBlock(plan.design, plan.figures.mean, name=name)
    if isinstance(plan, pd.Series) and frame is not None:
        plan = design_of_row("plan", plan, frame, **ASKED)
    if not isinstance(plan, FlightDesign):
        raise SettingsError(
            f"plan is {described(plan)}",
            expected="a FlightDesign, what expect_precision, plan_target or plan_area "
            "gives, the folder of a plan, or a row of find_plans with its frame",
            remedy="Write simulate_plan(found.nearest, frame=frame)"
            if isinstance(plan, pd.Series)
            else "",
        )
    return PlannedBlock(plan, propagate_design(plan).mean, name=name)


def _require_whole(checked):
    """Refuse what was checked of a plan over an area, without the area."""
    if checked.is_counted:
        raise SettingsError(
            "plan is what was checked of a plan over an area, without its area",
            expected="the AreaPlan itself",
            remedy="Write simulate_plan(plan), and not plan.checked",
        )


def _check_frame(plan, frame):
    """See that a frame is one, and stands beside a row, which needs it."""
    require_frame(frame)
    whole = AreaPlan, CheckedPlan, ExpectedPrecision, FlightDesign, PlannedBlock
    if isinstance(plan, whole):
        raise SettingsError(
            f"frame beside a plan that is {described(plan)}",
            expected="a frame beside a row of find_plans only",
            remedy="Leave frame out",
        )


@in_english
def another_row(planned, row, frame) -> PlannedBlock:
    """Take another row of the search that a plan is from, propagated as it would be."""
    area = planned.area
    if area is None:
        return planned_block(row, frame)
    require_row("plan", row, **ASKED)
    ground = OverGround(planned.heights, planned.max_height, planned.follows)
    found = laid_out(area, row, frame, ground)
    design = found.layout.design  # whose layout, thinned or not, has the control
    if found.is_part:
        design = design_over(area, design_of(row, frame), np.inf)
    expected = propagate(found.layout).mean
    return replace(planned, design=design, expected=expected)


@in_english
def simulate_plan(
    plan, *, frame=None, seed=0, noise=None, title=None, **changes
) -> SimulatedBlock:
    """Simulate the block that a plan would give.

    ``plan`` and ``frame`` are those of :func:`planned_block`; ``noise`` stands in place
    of the plan's errors; ``changes``: measurement, transformation, n_check.

    Examples
    --------
    >>> design = FlightDesign(scale_number=8000, spacing=300, m_g_um=5)
    >>> simulate_plan(design).name
    'film_wide, 1:8000 and 1:15000, 300 m (simulated)'
    """
    if noise is not None:
        remedy = "Write noise=BlockNoise(…), or leave it out for the errors of the plan"
        require_kind("noise", noise, BlockNoise, expected="a BlockNoise", remedy=remedy)
    planned = planned_block(plan, frame)
    return planned.simulated(seed, noise=noise, title=title, **changes)
