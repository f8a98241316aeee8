"""A layout over ground that is not level: what its models show, and more of them.

Where the ground is high, models show less of it than of the level ground for which a
layout is made: strips and models are added until each coverage shows all of the area.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations.errors import GeometryError
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.typesetting import per_cent
from einschalt.pipeline.planning.area.layout import (
    FLIGHTS,
    chosen_control,
    models_worth_flying,
)
from einschalt.pipeline.planning.area.models_over_ground import (
    half_at,
    risen,
    shown,
)
from einschalt.pipeline.planning.area.photographs import (
    by_image,
    photographs_of,
    planned_heights,
    reach_of,
)
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights
from einschalt.pipeline.simulation.layout import turn

RISES_MORE = 1.1
"""Ground is taken to rise more, which keeps a margin between the places looked at."""
PLACES_IN_HALF_A_MODEL = 6.0
MOST_PLACES = 30_000
MOST_ROUNDS = 16  # of models that are added
MOVED_MORE = 1.25  # than places want, since models elsewhere fly at other altitudes
SLACK = 1e-9  # of a step, for sums of decimals
NEAR = 1.5  # half models: a model so near may show a place on lower ground
MOST_UNCOVERED, LEAST_SAID = 0.002, 0.0001  # of the area


@dataclass(frozen=True, eq=False)
class SurveyedTerrain:
    """Terrain of given heights, as layouts and simulations ask for it."""

    heights: GroundHeights
    to_ground: Callable  # from positions (n, 2) to easting, northing [m]

    def height(self, position):
        """Height of the terrain at places (..., 2) [m]."""
        ground = self.to_ground(np.reshape(position, (-1, 2)))
        return self.heights.straight_below(ground).reshape(np.shape(position)[:-1])


@dataclass(frozen=True, eq=False)
class _Places:
    """Places of an area at which every coverage is wanted."""

    position: np.ndarray  # (n, 2): local [m]
    ground: np.ndarray  # (n,): height [m]
    n_inside: int  # the first of them are evenly spread, the others on the border
    # by flight and number of a coverage, (n,): which of them it would show of level
    # ground
    wanted: dict


def over_ground(layout, heights, limit=None, *, follows=False, require=None):
    """Fly a layout over ground as it is, with as many models more as that takes.

    ``heights``, ``limit`` and ``follows`` as with ``photographs_of``;
    ``require(photographs)`` refuses ground over which nothing is to be added. Gives an
    AreaLayout whose cameras have altitudes, whose models hold what they show of the
    ground, and whose control is chosen among that.
    """
    photographs = photographs_of(layout, heights, limit, follows=follows)
    if require is not None:
        require(photographs)
    terrain = SurveyedTerrain(heights, layout.area.to_ground)
    places = _places_of(layout, terrain)
    for _ in range(MOST_ROUNDS):
        layout = _with_altitudes(layout, photographs)
        flights = {
            flight: _with_more(layout, flight, places, heights, follows)
            for flight in FLIGHTS
        }
        if all(flights[flight] is layout.flights[flight] for flight in FLIGHTS):
            break
        layout = replace(layout, flights=flights)
        photographs = photographs_of(layout, heights, limit, follows=follows)
    else:
        layout = _with_altitudes(layout, photographs)
    below = terrain.height(layout.position)
    flights = {
        flight: shown(flown, layout.geometry, layout.position, below)
        for flight, flown in layout.flights.items()
    }
    control = chosen_control(layout.geometry, flights["high_flight"], layout.position)
    found = {"flights": flights, "is_control": control, "photographs": photographs}
    return replace(layout, terrain=terrain, **found)


def _with_altitudes(layout, photographs):
    flights = {
        flight: replace(flown, altitudes=by_image(photographs, flown, flight))
        for flight, flown in layout.flights.items()
    }
    return replace(layout, flights=flights)


def _places_of(layout, terrain):
    """Places all over the area and on its border, some in each half of a model."""
    import shapely  # noqa: PLC0415 - loaded when an area is planned

    area, scale_number = layout.area, layout.flights["low_flight"].scale_number
    half = scale_number * min(layout.geometry.usable_model) / 2.0
    size = area.shape.area
    step = max(half / PLACES_IN_HALF_A_MODEL, np.sqrt(size / MOST_PLACES))
    inside = area.to_local(area.places(size / step**2))
    border = shapely.get_coordinates(shapely.segmentize(area.local_shape, step))
    border = border[:: max(1, len(border) // MOST_PLACES)]
    position, wanted = np.concatenate([inside, border]), {}
    for flight, flown in layout.flights.items():
        level = shown(flown, layout.geometry, position)
        wanted |= _seen(level, flight, len(position))
    return _Places(position, terrain.height(position), len(inside), wanted)


def _seen(flown, flight, n_places):
    """Which places each coverage of a flight shows; by flight and number."""
    coverage, found = flown.coverage[flown.model], {}
    for k in range(len(flown.rasters)):
        found[flight, k] = np.zeros(n_places, dtype=bool)
        found[flight, k][flown.point[coverage == k]] = True
    return found


def uncovered(layout):
    """Part of the area that no model of a coverage shows.

    Of a layout over ground; {(flight, number of the coverage): part}.
    """
    places = _places_of(layout, layout.terrain)
    inside, ground = (
        part[: places.n_inside] for part in (places.position, places.ground)
    )
    found = {}
    for flight, flown in layout.flights.items():
        seen = shown(flown, layout.geometry, inside, ground)
        found |= _seen(seen, flight, len(inside))
    return {name: 1.0 - is_seen.mean() for name, is_seen in found.items()}


def require_cover(layout):
    """Refuse a layout of which a coverage does not show all of the ground.

    Returns what is to be said of it.
    """
    found = uncovered(layout)
    (flight, number), part = max(found.items(), key=lambda item: item[1])
    if part > MOST_UNCOVERED:
        raise GeometryError(
            f"on this ground {per_cent(part, 1)} of the area lie in no model of "
            f"coverage {number + 1} of the {flight.replace('_', ' ')}",
            expected="all of it",
            remedy="Give larger overlaps (--forward-overlap, --side-overlap), or fly "
            "higher above the ground",
        )
    if part > LEAST_SAID:
        message = "On this ground {part} of the area lie in no model of a coverage."
        return kept(message, part=per_cent(part, 2))
    return kept("On this ground every coverage of both flights shows the whole area.")


def _with_more(layout, flight, places, heights, follows):
    """Add models where a coverage shows too little; the same flight if it does not."""
    flown, geometry = layout.flights[flight], layout.geometry
    given = flown, geometry, places.position, places.ground
    seen = _seen(shown(*given, rises=RISES_MORE), flight, len(places.position))
    rasters, places_flown, is_same = list(flown.rasters), [], True
    for k, raster in enumerate(flown.rasters):
        places_flown.append(flown.place[flown.coverage == k])
        left = np.flatnonzero(places.wanted[flight, k] & ~seen[flight, k])
        if not len(left):
            continue
        tried = _Coverage(layout, flight, k, heights, follows)
        added, left = tried.adding(places, left)
        if len(left):
            rasters[k] = tried.with_ends(places, left)
        if rasters[k] is not raster:
            half = flown.scale_number * np.array(geometry.usable_model) / 2.0
            shape = layout.area.local_shape
            places_flown[k] = models_worth_flying(shape, rasters[k].centres(), half)
        elif len(added):
            places_flown[k] = np.sort(np.concatenate([places_flown[k], added]))
        else:
            continue
        is_same = False
    return flown if is_same else _of_places(flown, rasters, places_flown)


def _of_places(flown, rasters, places_flown):
    """Models of a flight at places of its rasters, which hold nothing yet."""
    coverage = np.repeat(np.arange(len(places_flown)), [len(k) for k in places_flown])
    centre = [r.centres()[k] for r, k in zip(rasters, places_flown, strict=True)]
    return replace(
        flown,
        rasters=tuple(rasters),
        coverage=coverage,
        place=np.concatenate(places_flown),
        centre=np.concatenate(centre),
        model=np.empty(0, dtype=int),
        point=np.empty(0, dtype=int),
        altitudes=None,
    )


class _Coverage:
    """Models of one coverage that may be added, flown or not."""

    def __init__(self, layout, flight, number, heights, follows):
        flown, self.geometry = layout.flights[flight], layout.geometry
        self.flown, self.area = flown, layout.area
        self.flight, self.number = flight, number
        self.raster = flown.rasters[number]
        self.kept = flown.place[flown.coverage == number]
        self.nominal = planned_heights(layout.design)[flight]
        self.reach, self.heights = reach_of(layout, flight), heights
        self.lines = None if follows else _of_strips(self.raster, flown, number)

    def adding(self, places, left):
        """Places of models that show what is left, and what they leave of it."""
        centre, point = self._holding(places, left)
        added = []
        is_left = np.isin(np.arange(len(places.position)), left)
        is_new = ~np.isin(centre, self.kept)
        centre, point = centre[is_new], point[is_new]
        while (counts := np.bincount(centre[is_left[point]])).any():
            best = int(np.argmax(counts))
            added.append(best)
            is_left[point[centre == best]] = False
        return np.array(added, dtype=int), np.flatnonzero(is_left)

    def _altitudes(self, centre):
        """Altitudes of models at places of the raster, as far as they are known [m]."""
        plane = self.area.to_ground(self.raster.centres()[centre])
        own = self.heights.mean_around(plane, self.reach) + self.nominal
        if self.lines is None:
            return own
        of_line = self.lines[centre // self.raster.shape[0]]
        return np.where(np.isfinite(of_line), of_line, own)

    def _holding(self, places, left):
        """Pair places that are left with the models that show them."""
        half = self.flown.scale_number * np.array(self.geometry.usable_model) / 2.0
        centre, rows = self.raster.holding(places.position[left], NEAR * half)
        if not len(centre):
            return centre, rows
        point, (near, of_near) = left[rows], np.unique(centre, return_inverse=True)
        altitude = self._altitudes(near)[of_near]
        depth = (altitude - places.ground[point]) / self.nominal
        away = places.position[point] - self.raster.centres()[centre]
        away = np.abs(turn(away, -self.raster.direction))
        depth = risen(depth, RISES_MORE)[:, None]
        is_in = (away <= half_at(depth, self.flown, self.geometry)).all(axis=1)
        return centre[is_in], point[is_in]

    def with_ends(self, places, left):
        """The raster moved or stretched to its ends, or longer there, as these want it.

        One strip, or one model in each, more where moving does not do. The same raster
        where places are left between models alone.
        """
        raster, geometry = self.raster, self.geometry
        apart = self.flown.scale_number * np.array(geometry.neat_model)
        wanted = np.flatnonzero(places.wanted[self.flight, self.number])
        half, local = self._half_at(places, wanted)
        is_left = np.isin(wanted, left)
        axes = []
        for axis, values in enumerate((raster.along, raster.across)):
            room = _room_at_ends(values, local[:, axis], half[:, axis])
            is_short = [end.min(initial=np.inf, where=is_left) < 0.0 for end in room]
            if not any(is_short):
                axes.append(values)
                continue
            extent = self.area.extent[axis] / 2.0
            closest = min(apart[axis], 2.0 * half[:, axis].min())
            moved = _moved(values, [end.min(initial=np.inf) for end in room], closest)
            if moved is None or np.abs(moved[[0, -1]]).max() > extent:
                moved = _with_ends_of(values, apart[axis], extent, is_short)
            axes.append(moved)
        along, across = axes
        if along is raster.along and across is raster.across:
            return raster
        base = float(np.diff(along).min()) if len(along) > 1 else raster.base
        return replace(raster, along=along, across=across, base=base)

    def _half_at(self, places, rows):
        """What the nearest models show of places, half [m], and their local positions.

        Both (n, 2), along and across the strips.
        """
        raster = self.raster
        local = turn(places.position[rows], -raster.direction)
        place, strip = (
            np.searchsorted((centres[1:] + centres[:-1]) / 2.0, local[:, axis])
            for axis, centres in enumerate((raster.along, raster.across))
        )
        n_along, n_across = raster.shape
        centre = (n_across - 1 - strip) * n_along + place
        near, of_near = np.unique(centre, return_inverse=True)
        depth = (self._altitudes(near)[of_near] - places.ground[rows]) / self.nominal
        depth = risen(depth, RISES_MORE)[:, None]
        return half_at(depth, self.flown, self.geometry), local


def _of_strips(raster, flown, number):
    """Mean altitudes of the strips of a coverage, NaN where none is flown [m]."""
    n_along, n_across = raster.shape
    altitudes = flown.altitudes[number].reshape(n_across, n_along + 1)
    is_flown = np.isfinite(altitudes)
    total = np.where(is_flown, altitudes, 0.0).sum(axis=1)
    return total / np.where(is_flown.any(axis=1), is_flown.sum(axis=1), np.nan)


def _room_at_ends(centres, place, half):
    """How much farther out the first and the last models would show places [m].

    Each (n,), infinite for places that lie at the other end; negative where they lie
    too far out.
    """
    below, above = centres[0] - place, place - centres[-1]
    low = np.where(below > 0.0, half - below, np.inf)
    high = np.where(above > 0.0, half - above, np.inf)
    return low, high


def _moved(centres, room, apart):
    """Centres along one axis, moved or stretched so that both ends have room [m].

    ``room`` at the first and at the last of them, negative where they must move out;
    they stand at most ``apart``. None where that does not do.
    """
    low, high = centres[0], centres[-1]
    least_low, least_high = (max(0.0, -MOVED_MORE * one) for one in room)
    to_low, to_high = (max(0.0, one / MOVED_MORE) for one in room)
    low = low - least_low + min(least_high, to_low)
    high = high + least_high - min(least_low, to_high)
    n_steps = len(centres) - 1
    if high - low > n_steps * apart * (1.0 + SLACK) + (n_steps == 0) * SLACK:
        return None
    return np.linspace(low, high, n_steps + 1)


def _with_ends_of(values, step, extent, beyond):
    """Centres along one axis, with one more at ends that want it [m].

    No centre lies beyond the area: the others stand closer instead.
    """
    low, high = float(values[0]), float(values[-1])
    at_low, at_high = beyond
    n_more = int(at_low) + int(at_high)
    if n_more == 0:
        return values
    if at_low:
        low = max(low - step, min(-extent, low))
    if at_high:
        high = min(high + step, max(extent, high))
    return np.linspace(low, high, len(values) + n_more)
