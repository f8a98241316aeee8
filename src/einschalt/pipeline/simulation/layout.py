"""Where the points of a simulated block lie, and which model holds which of them.

All positions are easting, northing from the centre of the area. The axes of a flight
are *along* and *across*: along its strips, and to the left of that.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.simulation.geometry import BlockGeometry

FEWEST_IN_ROW = 3
TOLERANCE = 1e-6  # metres on the ground: lattice and footprint are sums of decimals
SLACK = 1e-9  # of a step, likewise
FEW_STRIPS = 2
N_WAVES = 8  # enough for a terrain without a visible direction
LONGEST_WAVE, SHORTEST_WAVE = 6000.0, 2000.0  # metres
FIRST_POINT = 1001
CORNERS_AND_CENTRE = ((-1, 1), (1, 1), (0, 0), (-1, -1), (1, -1))
THREE_BY_THREE = tuple((east, north) for north in (1, 0, -1) for east in (-1, 0, 1))
CONTROL_PLACES = {5: CORNERS_AND_CENTRE, 9: THREE_BY_THREE}


@dataclass(frozen=True, eq=False)
class Terrain:
    """A smooth terrain: plane waves of equal amplitude above a mean height."""

    mean_height: float  # [m]
    amplitude: float  # [m]
    wave_vector: np.ndarray  # (n_waves, 2) [rad/m]
    phase: np.ndarray  # (n_waves,) [rad]

    def height(self, position):
        """Height of the terrain [m].

        ``position`` (..., 2): easting, northing from the centre of the area [m].
        """
        waves = np.sin(position @ self.wave_vector.T + self.phase)
        return self.mean_height + self.amplitude * waves.sum(axis=-1)


def shape_terrain(geometry, rng) -> Terrain:
    """Draw the terrain of a block."""
    length = rng.uniform(SHORTEST_WAVE, LONGEST_WAVE, N_WAVES)
    direction = rng.uniform(0.0, 2.0 * np.pi, N_WAVES)
    towards = np.column_stack([np.cos(direction), np.sin(direction)])
    return Terrain(
        geometry.mean_height,
        geometry.relief * np.sqrt(2.0 / N_WAVES),
        2.0 * np.pi / length[:, None] * towards,
        rng.uniform(0.0, 2.0 * np.pi, N_WAVES),
    )


def scatter_points(geometry, rng, spacing=None):
    """Lay the points on a lattice and displace each a little.

    ``spacing`` [m]: where they stand for closer ones, each in the middle of what it
    stands for. Easting, northing from the centre of the area (n_points, 2) [m], row by
    row from the north-west. The outermost points are moved inward only, so that the
    models that cover the lattice hold them all.
    """
    east, north = geometry.half_extent
    if spacing is None:
        column = np.linspace(-east, east, geometry.n_columns)
        row = np.linspace(north, -north, geometry.n_rows)
        reach = geometry.jitter * geometry.point_spacing
    else:
        own = geometry.point_spacing / 2.0
        column, row = (_middles(half + own, spacing) for half in (east, north))
        reach = geometry.jitter * spacing
    place = np.stack(np.meshgrid(column, row), axis=-1).reshape(-1, 2)
    moved = rng.uniform(-reach, reach, place.shape)
    is_outermost = np.abs(place) > np.array([east, north]) - TOLERANCE
    inward = -np.sign(place) * np.abs(moved)
    return place + np.where(is_outermost, inward, moved)


def _middles(half, spacing):
    """Middles of cells of about a size, that fill a line [m]."""
    n = max(FEWEST_IN_ROW, round(2.0 * half / spacing))
    return (2.0 * np.arange(n) + 1.0 - n) * (half / n)


def name_points(n_points):
    """Names of the points, text that counts from 1001."""
    return np.arange(FIRST_POINT, FIRST_POINT + n_points).astype(str).astype(object)


@dataclass(frozen=True, eq=False)
class Raster:
    """The model (or image) centres of one coverage."""

    # along, across: (n_along,), (n_across,): centres in the axes of the flight,
    # increasing [m]
    along: np.ndarray
    across: np.ndarray
    base: float  # distance of consecutive centres [m]
    direction: float  # of the strips, from east to the left [rad]

    @property
    def shape(self) -> tuple[int, int]:
        """Number of centres along and across."""
        return len(self.along), len(self.across)

    def images(self) -> "Raster":
        """Raster of the images that make these models: one more along each strip."""
        along = np.append(self.along, self.along[-1] + self.base) - self.base / 2.0
        return Raster(along, self.across, self.base, self.direction)

    def centres(self) -> np.ndarray:
        """Easting, northing of all centres, strip by strip, shape (n_centres, 2)."""
        across, along = np.meshgrid(self.across[::-1], self.along, indexing="ij")
        return turn(np.column_stack([along.ravel(), across.ravel()]), self.direction)

    def names(self) -> np.ndarray:
        """Strip / place in the strip, strips counted from the left, (n_centres,)."""
        n_along, n_across = self.shape
        strip = np.repeat(np.arange(1, n_across + 1), n_along).astype(str)
        place = np.tile(np.arange(1, n_along + 1), n_across).astype(str)
        return np.strings.add(np.strings.add(strip, "/"), place).astype(object)

    def holding(
        self, position: np.ndarray, half_size: ArrayLike
    ) -> tuple[np.ndarray, np.ndarray]:
        """Pair each point with every centre that lies near enough.

        ``position`` (n, 2) [m]; ``half_size`` is the reach of a centre along and across
        [m]. Gives centre and point of each pair, (n_pairs,), sorted by centre.
        """
        in_flight = turn(position, -self.direction)
        first_along, n_along = _window(self.along, in_flight[:, 0], half_size[0])
        first_across, n_across = _window(self.across, in_flight[:, 1], half_size[1])
        step_along = np.arange(n_along.max(initial=0))
        step_across = np.arange(n_across.max(initial=0))
        is_along = step_along < n_along[:, None]
        is_across = step_across < n_across[:, None]
        is_held = is_along[:, :, None] & is_across[:, None, :]
        point, along, across = np.nonzero(is_held)
        strip = len(self.across) - 1 - (first_across[point] + across)
        centre = strip * len(self.along) + first_along[point] + along
        by_centre = np.argsort(centre, kind="stable")
        return centre[by_centre], point[by_centre]


def turn(position, angle):
    """Turn positions to the left about the centre of the area.

    ``position`` (n, 2); one angle, or one for each [rad].
    """
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = position[:, 0], position[:, 1]
    return np.column_stack([cos * x - sin * y, sin * x + cos * y])


def _window(centres, position, reach):
    first = np.searchsorted(centres, position - reach - TOLERANCE, side="left")
    last = np.searchsorted(centres, position + reach + TOLERANCE, side="right")
    return first, last - first


def _lay_axis(extent, reach, step, shift):
    """Centres that cover -extent to extent, and their step.

    The step is shortened where the centre of the outermost model would lie outside:
    control in a sliver of a model determines nothing.
    """
    first = min(np.floor((reach - extent) / step - shift + SLACK), 0.0)
    last = max(np.ceil((extent - reach) / step - shift - SLACK), first)
    place = np.arange(first, last + 1.0) + shift
    farthest = np.abs(place).max()
    if farthest > 0.0:
        step = min(step, extent / farthest)
    return place * step, step


@dataclass(frozen=True, eq=False)
class FlightLayout:
    """The models of one flight, and the points that they hold."""

    scale_number: float
    rasters: tuple[Raster, ...]  # one per coverage
    coverage: np.ndarray  # (n_models,): position in ``rasters``
    place: np.ndarray  # (n_models,): position among the centres of that raster
    # (n_models, 2): easting, northing from the centre of the area [m]
    centre: np.ndarray
    # model, point: (n_rows,): which model holds which point, sorted by model
    model: np.ndarray
    point: np.ndarray
    # of each coverage the altitudes of its raster's images, NaN where none is taken;
    # None where all fly at the height of the image scale above the mean ground [m]
    altitudes: tuple[np.ndarray, ...] | None = None

    @property
    def n_models(self) -> int:
        """Number of models of all coverages."""
        return len(self.coverage)

    @property
    def coverage_id(self) -> np.ndarray:
        """Name of each model's coverage, text from "1", (n_models,)."""
        return (self.coverage + 1).astype(str).astype(object)

    @property
    def model_id(self) -> np.ndarray:
        """Name of each model within its coverage, as "3/12", (n_models,)."""
        names = [raster.names() for raster in self.rasters]
        start = np.cumsum([0, *(len(part) for part in names)])
        return np.concatenate(names)[start[self.coverage] + self.place]

    @property
    def image_places(self) -> np.ndarray:
        """Places of each model's two images in ``images()`` of its raster, (n, 2)."""
        n_along = np.array([raster.shape[0] for raster in self.rasters])[self.coverage]
        strip, along = np.divmod(self.place, n_along)
        left = strip * (n_along + 1) + along
        return np.column_stack([left, left + 1])

    def camera_altitude(self, geometry: BlockGeometry) -> np.ndarray:
        """Mean altitude of each model's two cameras, (n_models,) [m]."""
        if self.altitudes is None:
            usual = geometry.flying_height(self.scale_number)
            return np.full(self.n_models, usual)
        start = np.cumsum([0, *(len(part) for part in self.altitudes)])
        places = start[self.coverage][:, None] + self.image_places
        return np.concatenate(self.altitudes)[places].mean(axis=1)

    @property
    def direction(self) -> np.ndarray:
        """Direction of each model's strip, from east to the left (n_models,) [rad]."""
        return np.array([raster.direction for raster in self.rasters])[self.coverage]

    @property
    def base(self) -> np.ndarray:
        """Base of each model on the ground (n_models,) [m]."""
        return np.array([raster.base for raster in self.rasters])[self.coverage]


def lay_flight(geometry, flight, position) -> FlightLayout:
    """Lay the models of one flight over the block.

    Without the models that hold too few points.
    """
    is_high = flight == "high_flight"
    scale = geometry.high_scale_number if is_high else geometry.low_scale_number
    least = geometry.least_points_per_model
    if is_high:
        least = max(least, geometry.control_per_model)
    rasters, parts = flight_rasters(geometry, flight), []
    for raster in rasters:
        half_size = scale * np.array(geometry.usable_model) / 2.0
        centre, point = raster.holding(position, half_size)
        parts.append(_with_enough(centre, point, least))
        if not len(parts[-1][0]):
            raise SettingsError(
                f"no model of the {flight.replace('_', ' ')} holds {least} points",
                expected=f"models of at least {least} points",
                remedy="Lower point_spacing or least_points_per_model",
            )
    places, models, points = zip(*parts, strict=True)
    n_models = [len(place) for place in places]
    centres = [r.centres()[place] for r, place in zip(rasters, places, strict=True)]
    first_model = np.cumsum([0, *n_models[:-1]])
    numbers = [model + first for model, first in zip(models, first_model, strict=True)]
    return FlightLayout(
        scale,
        tuple(rasters),
        coverage=np.repeat(np.arange(len(places)), n_models),
        place=np.concatenate(places),
        centre=np.concatenate(centres),
        model=np.concatenate(numbers),
        point=np.concatenate(points),
    )


def flight_rasters(geometry, flight, *, few_strips=False) -> list[Raster]:
    """Lay the model centres of each coverage of a flight over the whole rectangle.

    With ``few_strips`` coverages are shifted across less where a strip or two hold all
    of a rectangle, and the usual shift would take more.
    """
    is_high = flight == "high_flight"
    scale = geometry.high_scale_number if is_high else geometry.low_scale_number
    is_cross = geometry.high_cross_flight if is_high else geometry.low_cross_flight
    return [
        _lay_raster(geometry, scale, k, is_cross and k % 2 == 1, few_strips)
        for k in range(geometry.n_coverages)
    ]


def _lay_raster(geometry, scale_number, coverage, is_across, few_strips):
    extent = geometry.half_extent[::-1] if is_across else geometry.half_extent
    sizes, steps = geometry.usable_model, geometry.neat_model
    axes = [
        (reach, scale_number * size / 2.0, scale_number * step)
        for reach, size, step in zip(extent, sizes, steps, strict=True)
    ]
    shifts = [coverage * geometry.shift] * 2
    if few_strips:
        given = geometry.n_coverages, geometry.shift
        shifts[1] = _shifts_across(*axes[1], *given)[coverage]
    along, base = _lay_axis(*axes[0], shifts[0])
    across, _ = _lay_axis(*axes[1], shifts[1])
    return Raster(along, across, base, np.pi / 2.0 if is_across else 0.0)


def least_strips(width, held, step):
    """How few strips hold all of a width, each so much of it, ``step`` apart [m].

    >>> least_strips(np.array([1000.0, 2000.0, 2500.0]), 1500.0, 1000.0)
    array([1., 2., 2.])
    """
    return np.maximum(np.ceil((width - held) / step - SLACK), 0.0) + 1.0


def _shifts_across(extent, reach, step, n_coverages, shift):
    """Shift of each coverage across its strips, in steps.

    The usual one takes a strip more for every other coverage. Where one or two hold all
    that lies between -extent and extent, they are shifted as far as these still do.
    """
    usual = np.arange(n_coverages) * shift
    n_strips = least_strips(2.0 * extent, 2.0 * reach, step)
    taken = sum(len(_lay_axis(extent, reach, step, one)[0]) for one in usual)
    if n_strips > FEW_STRIPS or taken <= n_coverages * n_strips:
        return usual
    between = n_strips - 1.0
    # all is held, and no strip is centred outside
    beyond = 2.0 * (extent - reach) / step
    room = min(between - beyond, 2.0 * extent / step - between, usual[-1])
    return between / 2.0 + max(room, 0.0) * np.linspace(-0.5, 0.5, n_coverages)


def _with_enough(centre, point, least):
    """Keep the centres that hold enough points, numbered anew."""
    count = np.bincount(centre)
    kept = np.flatnonzero(count >= least)
    number = np.full(len(count), -1)
    number[kept] = np.arange(len(kept))
    is_kept = number[centre] >= 0
    return kept, number[centre[is_kept]], point[is_kept]


def choose_control(geometry, layout, position):
    """Choose the control points of each model of the high flight.

    Wanted are the corners and the centre (or 3 x 3 places) of the neat model, enlarged
    by ``control_reach`` and moved to the border of the block where they lie outside: so
    neighbouring models, and those of the other coverage, share most of their control.
    The nearest point of the model that is still free is taken. Gives places of points,
    (n_models, 5 or 9).
    """
    start = np.searchsorted(layout.model, np.arange(layout.n_models))
    is_free = np.ones(len(layout.model), dtype=bool)
    chosen = []
    for wanted in _wanted_control(geometry, layout):
        away = position[layout.point] - wanted[layout.model]
        distance = np.where(is_free, np.hypot(*away.T), np.inf)
        nearest = np.lexsort((distance, layout.model))[start]
        is_free[nearest] = False
        chosen.append(layout.point[nearest])
    return np.column_stack(chosen)


def _wanted_control(geometry, layout):
    """Where each model wants control, (5 or 9, n_models, 2) [m]."""
    half = geometry.control_reach * _neat_half(geometry, layout)
    extent = np.array(geometry.half_extent)
    places = np.array(CONTROL_PLACES[geometry.control_per_model])
    return np.clip(layout.centre + half * places[:, None], -extent, extent)


def with_control_of_all(geometry, layout, position):
    """Give few points control that stands where it would among all of them.

    Each wanted place is moved to the nearest node of their lattice. Gives the control
    first, then the others, of which the nearest have made room; and how many control
    points there are.
    """
    from scipy.spatial import KDTree  # noqa: PLC0415 - loaded when points are thinned

    corner, spacing = -np.array(geometry.half_extent), geometry.point_spacing
    wanted = _wanted_control(geometry, layout).reshape(-1, 2) - corner
    control = np.unique(np.round(wanted / spacing), axis=0) * spacing + corner
    nearest = KDTree(position).query(control)[1]
    others = np.delete(position, np.unique(nearest), axis=0)
    return np.concatenate([control, others]), len(control)


def on_control_alone(layout, n_control, least) -> FlightLayout:
    """Leave out of each model all but the first points, which are control.

    The layout as it is where that would leave a model fewer than ``least`` of them.
    """
    is_kept = layout.point < n_control
    count = np.bincount(layout.model[is_kept], minlength=layout.n_models)
    if count.min() < least:
        return layout
    return replace(layout, model=layout.model[is_kept], point=layout.point[is_kept])


def leave_control_of_others(layout, control) -> FlightLayout:
    """Leave out of each model the control that was chosen for other models.

    ``control`` is that of each model, as it was chosen.
    """
    is_own = (control[layout.model] == layout.point[:, None]).any(axis=1)
    is_kept = is_own | ~np.isin(layout.point, control)
    return replace(layout, model=layout.model[is_kept], point=layout.point[is_kept])


def _neat_half(geometry, layout):
    along, across = layout.scale_number * np.array(geometry.neat_model) / 2.0
    is_turned = layout.direction > 0.0
    return np.where(is_turned[:, None], [across, along], [along, across])
