"""Both flights over an area: which models are flown, and where control is wanted."""

from dataclasses import dataclass, fields, replace
from typing import Protocol

import numpy as np
import pandas as pd

from einschalt.foundations.batches import used_places
from einschalt.foundations.errors import GeometryError, SettingsError
from einschalt.foundations.typesetting import number, scale
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.models_over_ground import shown
from einschalt.pipeline.planning.estimate.possible_layouts import (
    FEWEST_POINTS,
    FEWEST_ROWS,
    MOST_MODELS,
    largest_scale,
    models_over,
    widest_spacing,
)
from einschalt.pipeline.planning.flights.flight_design import (
    LEAST_POINTS_PER_MODEL,
    NODES_IN_A_MODEL,
    FlightDesign,
    usable_model,
)
from einschalt.pipeline.planning.flights.points_in_models import downwards
from einschalt.pipeline.simulation.geometry import RANGES as BLOCK_RANGES
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.layout import (
    CONTROL_PLACES,
    FlightLayout,
    flight_rasters,
    scatter_points,
)
from einschalt.theory.planning.control_choice import serving_points

SCALE_OF_FLIGHT = {
    "high_flight": "high_scale_number",
    "low_flight": "low_scale_number",
}
FLIGHTS = tuple(SCALE_OF_FLIGHT)
LEAST_SHARE = 0.25
"""Of the model in the area: smaller ones are flown only where nothing else covers."""
LEFT_OVER = 1e-4  # of a model: as little of the area may stay uncovered
SAME_STRIP = 1e-6  # of half a model: models whose middles differ less are in one strip
REACH_OF_CONTROL = 0.75  # how far out control is wanted, in half models
NEAR_ENOUGH = 0.35  # a point serves as well, in half models
NEAR_ENOUGH_TO_LATTICE = 0.7
SURELY_ENOUGH = 0.65
"""Of an area, where a spacing is advised: points that are scattered about a lattice may
be fewer in a small area than its size says."""
SHORTEST_SIDE = 100.0  # metres, of the rectangle that is laid out


class Ground(Protocol):
    """Terrain that is not level."""

    def height(self, position: np.ndarray) -> np.ndarray:
        """Height at local positions (..., 2) [m], shape (...)."""


@dataclass(frozen=True, eq=False)
class AreaLayout:
    """A design laid out over an area; positions are local [m]."""

    area: FlightArea
    design: FlightDesign
    geometry: BlockGeometry
    position: np.ndarray  # (n_points, 2)
    # by flight: all models that are flown, and the points that they hold
    flights: dict[str, FlightLayout]
    is_control: np.ndarray  # (n_points,)
    # of a layout over ground that is not level; None where models hold what they show
    # of level ground
    terrain: Ground | None = None
    # its table of all photographs, as FlightPlan has it; None where it is not made yet
    photographs: pd.DataFrame | None = None

    @property
    def control(self) -> np.ndarray:
        """Places of the control points among the points, (n_control,)."""
        return np.flatnonzero(self.is_control)

    def oriented(self, flight: str) -> FlightLayout:
        """The models of a flight that hold enough points to be oriented."""
        layout = self.flights[flight]
        n_points = np.bincount(layout.model, minlength=layout.n_models)
        if flight == "low_flight":
            return _only(layout, n_points >= LEAST_POINTS_PER_MODEL)
        is_control = self.is_control[layout.point]
        n_control = np.bincount(layout.model[is_control], minlength=layout.n_models)
        is_enough = n_points >= self.geometry.control_per_model
        return _only(layout, is_enough & (n_control >= LEAST_POINTS_PER_MODEL))

    @property
    def n_left_out(self) -> int:
        """How many points no model holds that can be oriented."""
        n_flights = np.zeros(len(self.position), dtype=int)
        for flight in FLIGHTS:
            held = used_places(self.oriented(flight).point, len(self.position))
            n_flights[held] += 1
        return int((n_flights < len(FLIGHTS)).sum())


def lay_out(area, design, *, seed=0, control=None, known=None) -> AreaLayout:
    """Lay both flights of a design over an area.

    Every coverage covers all of it. Control is set where the high flight's models want
    it: near their corners and middles, each point serving as many models as it can; or
    where ``control`` says, local positions (n_control, 2) [m]. ``known`` keeps flights
    over the same area, and the same seed, for designs that differ in the other flight;
    points that ``control`` displaces have flights of their own.
    GeometryError where the area is smaller than a model, or the models are too many.
    """
    geometry = geometry_over(area, design)
    require_size(area, design)
    everywhere = scatter_points(geometry, np.random.default_rng(seed))
    position = everywhere[area.holds(everywhere)]
    if len(position) < FEWEST_POINTS:
        raise GeometryError(
            f"{len(position)} points, {design.layout_spacing:g} m apart, lie in the "
            "area",
            expected=f"at least {FEWEST_POINTS}",
            remedy="Give a smaller --spacing, or a larger area",
        )
    if control is not None:
        position, is_control = with_control_at(control, position)
    known = {} if known is None or control is not None else known
    flights = {f: _known_flight(known, area, geometry, f, position) for f in FLIGHTS}
    if control is None:
        is_control = chosen_control(geometry, flights["high_flight"], position)
    return AreaLayout(area, design, geometry, position, flights, is_control)


def with_control_at(control, position):
    """Put control in front of other points, the nearest of which give way to it.

    ``control`` (n_control, 2) and ``position`` (n_points, 2) [m]; gives all positions,
    and which of them are control.
    """
    from scipy.spatial import KDTree  # noqa: PLC0415 - loaded when asked for

    nearest = KDTree(position).query(control)[1]
    kept = np.delete(position, np.unique(nearest), axis=0)
    together = np.concatenate([control, kept])
    return together, np.arange(len(together)) < len(control)


def geometry_over(area, design):
    """Geometry of the rectangle around the area; its lattice reaches the border."""
    spacing = design.layout_spacing
    longest = (max(side, SHORTEST_SIDE) for side in area.extent)
    sides = [spacing * (np.ceil(side / spacing) + 1.0) for side in longest]
    try:
        return replace(design.geometry(), width=float(sides[0]), height=float(sides[1]))
    except SettingsError as error:
        raise GeometryError(
            f"the area is {area.extent[0]:.0f} x {area.extent[1]:.0f} m: {error}",
        ) from None


def require_size(area, design):
    """Refuse an area that is smaller than a model, or takes too many of them."""
    require_one_model(area, design.model, design.scale_number)
    require_rows(area, design.spacing)
    n_models = models_over(
        area.shape.area, design.model, design.scale_number, design.n_coverages
    )
    if n_models > MOST_MODELS:
        largest = area.square_km * MOST_MODELS / n_models
        raise GeometryError(
            f"the area of {number(area.square_km, 3)} km² would take {n_models:.0f} "
            f"models of the low flight at {scale(design.scale_number)}",
            expected=f"at most {MOST_MODELS}, which cover {downwards(largest)} km²",
            remedy=f"Split the area into {np.ceil(n_models / MOST_MODELS):.0f} parts "
            "or more, and plan each of them; or give larger scale numbers, for which "
            "--max-height must leave room",
        )


def require_one_model(area, model, scale_number):
    """Refuse an area that is smaller than a model of the low flight."""
    width, size = min(area.extent), area.shape.area
    largest = largest_scale(width, size, model)
    if scale_number > largest:
        low = scale_number * np.array(usable_model(model))
        apart = widest_spacing(width, SURELY_ENOUGH * size)
        is_possible = (
            float(downwards(largest)) in BLOCK_RANGES["low_scale_number"]
            and float(downwards(apart)) in BLOCK_RANGES["point_spacing"]
        )
        raise GeometryError(
            f"the area, {number(area.extent[0], 3)} x {number(area.extent[1], 3)} m, "
            f"is too narrow or too small for models of the low flight, "
            f"{number(low[0], 3)} x {number(low[1], 3)} m",
            expected="an area of several models",
            remedy=f"Give scale numbers of at most {downwards(largest)}, with points "
            f"at most {downwards(apart)} m apart; control alone does for less"
            if is_possible
            else "Survey its points on the ground, or give a camera with smaller "
            "images",
        )


def require_rows(area, spacing):
    """Refuse an area that has too few points, ``spacing`` [m] apart."""
    if spacing > widest_spacing(min(area.extent), area.shape.area):
        raise GeometryError(
            f"points {spacing:g} m apart are too few for an area of "
            f"{number(area.extent[0], 3)} x {number(area.extent[1], 3)} m",
            expected=f"at least {FEWEST_ROWS} rows of them, and {FEWEST_POINTS}",
            remedy="Give a smaller --spacing",
        )


def _known_flight(known, area, geometry, flight, position):
    """Take a flight from those that are known, or lay it and let it be known."""
    # control is chosen when the high flight is laid
    of_others = {*SCALE_OF_FLIGHT.values(), "control_per_model"}
    of_others.remove(SCALE_OF_FLIGHT[flight])
    names = (one.name for one in fields(geometry) if one.name not in of_others)
    key = flight, *(getattr(geometry, name) for name in names)
    if key not in known:
        known[key] = _lay_flight(area, geometry, flight, position)
    return known[key]


def _lay_flight(area, geometry, flight, position):
    """Lay the models of one flight that hold a part of the area worth flying."""
    scale = getattr(geometry, SCALE_OF_FLIGHT[flight])
    half = scale * np.array(geometry.usable_model) / 2.0
    rasters = flight_rasters(geometry, flight, few_strips=True)
    kept = [models_worth_flying(area.local_shape, r.centres(), half) for r in rasters]
    coverage = np.repeat(np.arange(len(kept)), [len(k) for k in kept])
    centre = np.concatenate(
        [r.centres()[k] for r, k in zip(rasters, kept, strict=True)]
    )
    layout = FlightLayout(
        scale,
        tuple(rasters),
        coverage=coverage,
        place=np.concatenate(kept),
        centre=centre,
        model=np.empty(0, dtype=int),
        point=np.empty(0, dtype=int),
    )
    return shown(layout, geometry, position)


def models_worth_flying(shape, centres, half):
    """Places of the models that hold enough of the area, and of those that fill gaps.

    Models whose part of the area is small are added, the largest parts first, where
    the others leave some of it uncovered.
    """
    import shapely  # noqa: PLC0415 - loaded when an area is planned

    low, high = centres - half, centres + half
    footprints = shapely.box(*low.T, *high.T)
    shapely.prepare(shape)
    is_inside = shapely.contains_properly(shape, footprints)
    is_cut = ~is_inside
    is_cut[is_cut] = shapely.intersects(shape, footprints[is_cut])
    share = np.where(is_inside, 1.0, 0.0)
    whole = float(np.prod(2.0 * half))
    edges = np.hstack([low, high])[is_cut].tolist()
    # a third of what intersections take, and as good for their areas
    parts = [shapely.clip_by_rect(shape, *edge) for edge in edges]
    share[is_cut] = shapely.area(parts) / whole
    kept = share >= LEAST_SHARE
    small = np.flatnonzero(~kept & (share > 0.0))
    if not len(small):
        return np.flatnonzero(kept)
    # others cannot cover more: what is theirs, and not of the large ones
    theirs = shapely.union_all(shapely.intersection(shape, footprints[small]))
    shapely.prepare(theirs)
    beside = np.flatnonzero(kept)
    beside = beside[shapely.intersects(theirs, footprints[beside])]
    left = theirs
    if len(beside):
        left = shapely.difference(
            theirs, shapely.union_all(_in_strips(centres[beside], half))
        )
    for place in small[np.argsort(-share[small], kind="stable")]:
        if left.area <= LEFT_OVER * whole:
            break
        rest = shapely.difference(left, footprints[place])
        if left.area - rest.area > LEFT_OVER * whole:
            kept[place], left = True, rest
    return np.flatnonzero(kept)


def _in_strips(centres, half):
    """Rectangles that hold what the footprints of models hold, fewer of them.

    Models of a strip overlap: those without a gap between them are one rectangle.
    """
    import shapely  # noqa: PLC0415 - loaded when an area is planned

    strip = np.round(centres[:, 1] / (SAME_STRIP * half[1]))
    order = np.lexsort((centres[:, 0], strip))
    centres, strip = centres[order], strip[order]
    is_apart = np.diff(centres[:, 0]) > 2.0 * half[0]
    edges = np.flatnonzero(is_apart | (np.diff(strip) != 0.0)) + 1
    first, last = np.append(0, edges), np.append(edges, len(centres)) - 1
    low, high = centres[first] - half, centres[last] + half
    return shapely.box(*low.T, *high.T)


def _only(layout, is_kept):
    """Return the models that are kept, numbered anew."""
    number = np.cumsum(is_kept) - 1
    rows = is_kept[layout.model]
    return replace(
        layout,
        coverage=layout.coverage[is_kept],
        place=layout.place[is_kept],
        centre=layout.centre[is_kept],
        model=number[layout.model[rows]],
        point=layout.point[rows],
    )


def chosen_control(geometry, layout, position):
    """Tell which points are control, as :func:`choose_control` does, (n_points,)."""
    is_control = np.zeros(len(position), dtype=bool)
    is_control[choose_control(geometry, layout, position)] = True
    return is_control


def choose_control(geometry, layout, position):
    """Choose control that serves every model, as few points as possible.

    In each model points are wanted near its corners and its middle (or at 3 x 3
    places). Where one that was chosen before lies near enough, it serves; otherwise
    the nearest point of the model is taken. Where images overlap much, a lattice that
    is so dense that every model holds enough of it takes fewer points. Gives the places
    of the points.
    """
    singly = _completed(geometry, layout, position, (), NEAR_ENOUGH)
    lattice = _on_lattice(geometry, layout, position)
    together = _completed(geometry, layout, position, lattice, NEAR_ENOUGH_TO_LATTICE)
    return min(singly, together, key=len)


def _on_lattice(geometry, layout, position):
    """Points nearest to the nodes of a lattice, several of which are in every model."""
    from scipy.spatial import KDTree  # noqa: PLC0415 - loaded when asked for

    per_axis = np.sqrt(NODES_IN_A_MODEL[geometry.control_per_model])
    step = layout.scale_number * np.array(geometry.usable_model) / per_axis
    low, high = position.min(axis=0), position.max(axis=0)
    axes = [
        np.linspace(a, b, max(2, int(np.ceil((b - a) / d)) + 1))
        for a, b, d in zip(low, high, step, strict=True)
    ]
    nodes = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    away, nearest = KDTree(position / step).query(nodes / step)
    return np.unique(nearest[away <= 0.5])


def _completed(geometry, layout, position, chosen, near_enough):
    """Add to chosen points what each model still wants."""
    half = layout.scale_number * np.array(geometry.usable_model) / 2.0
    places = REACH_OF_CONTROL * np.array(CONTROL_PLACES[geometry.control_per_model])
    start = np.searchsorted(layout.model, np.arange(layout.n_models + 1))
    is_chosen = np.zeros(len(position), dtype=bool)
    is_chosen[list(chosen)] = True
    serving_points(
        *(layout.point, start, position, layout.centre, half),
        *(places, is_chosen, near_enough),
    )
    return np.flatnonzero(is_chosen)
