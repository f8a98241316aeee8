"""Blocks with known truth: for tests, for examples, and for the question "what if?".

Geometry and noise are set apart and drawn apart: with one seed, other noise leaves
points, layout and control where they are, and larger noise is the same noise enlarged.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations.arguments import described, is_choice, require_kind
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.near_words import nearest
from einschalt.foundations.typesetting import scale
from einschalt.foundations.units import METRES_PER_MM
from einschalt.foundations.value_ranges import Range
from einschalt.pipeline.block.block import Block, Flight
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.layout import (
    choose_control,
    lay_flight,
    leave_control_of_others,
    name_points,
    on_control_alone,
    scatter_points,
    shape_terrain,
    with_control_of_all,
)
from einschalt.pipeline.simulation.measurements import (
    GROSS_ERROR_COLUMNS,
    MEASURE,
    FlightToMeasure,
    Ground,
    measure_plane_in_machine,
)
from einschalt.pipeline.simulation.noise import BlockNoise, strain_network
from einschalt.stages.bent_map import (
    bends_plane_models,
    is_of_the_earth,
    straightened,
    straightened_in_plan,
)

FLIGHTS = ("high_flight", "low_flight")
GEOMETRY_STREAMS = ("points", "terrain", "check", "setting_high", "setting_low")
FLIGHT_NOISE = ("measurement", "gross", "height", "orientation", "deformation")
# in this order: what a seed gives must not change
NOISE_STREAMS = (
    *("control", "strain"),
    *(f"{name}_{height}" for name in FLIGHT_NOISE for height in ("high", "low")),
)
GROUND_AXES = ("easting", "northing", "height")
# what a block without noise declares: its tables allow no error of zero
LEAST_M_G_UM = 0.1
LENGTHS = ("x", "y", "z", "y_parallax", "base")
LEAST_STANDARD_ERROR = 1e-4


@dataclass(frozen=True)
class Preset:
    """A block that has a name."""

    title: str
    geometry: BlockGeometry
    noise: BlockNoise


PRESETS = {
    "neukirchen": Preset("Neukirchen (simulated)", BlockGeometry(), BlockNoise()),
    "demo": Preset(
        "Demo (simulated)",
        BlockGeometry(width=3_000.0, height=3_000.0, n_check=6),
        BlockNoise(),
    ),
}


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SimulatedBlock(Block):
    """A block whose true coordinates are known.

    Attributes
    ----------
    truth : DataFrame
        point_id, easting, northing [, height] of all points [m].
    gross_errors : DataFrame
        flight, coverage, model_id, image_id, point_id of the measurements with a gross
        error; the one of model and image that was not measured is empty.
    geometry : BlockGeometry
    noise : BlockNoise
    seed : int
    """

    truth: pd.DataFrame
    gross_errors: pd.DataFrame
    geometry: BlockGeometry
    noise: BlockNoise
    seed: int


def simulate_block(
    preset: str = "neukirchen",
    *,
    seed: int = 0,
    geometry: BlockGeometry | None = None,
    noise: BlockNoise | None = None,
    title: str | None = None,
) -> SimulatedBlock:
    """Simulate the two flights of a block over points with known truth.

    As :func:`einschalt.simulate_block`.

    Examples
    --------
    >>> block = simulate_block("demo", seed=1)
    >>> block.truth.shape, block.control_points["role"].value_counts()["check"]
    ((100, 3), np.int64(6))
    """
    chosen = _preset(preset)
    geometry = chosen.geometry if geometry is None else geometry
    noise = chosen.noise if noise is None else noise
    _require_kinds(geometry=(geometry, BlockGeometry), noise=(noise, BlockNoise))
    if title is None:
        is_other = replace(geometry, **_measured(chosen.geometry)) != chosen.geometry
        title = title_of(geometry) if is_other else chosen.title
    return set_scene(geometry, noise, seed).measured(title)


def _measured(geometry):
    """What is measured in a block; another choice leaves it the same block."""
    names = ("measurement", "transformation", "n_check", "relief", "camera_tilt")
    return {name: getattr(geometry, name) for name in names}


def title_of(geometry, *names):
    """Name of a block by what was simulated, behind names of an area or a camera.

    >>> title_of(BlockGeometry(), "dmc_3")
    'dmc_3, 1:8000 and 1:15000, 300 m (simulated)'
    """
    low, high = scale(geometry.low_scale_number), scale(geometry.high_scale_number)
    said = [*filter(None, names), f"{low} and {high}", f"{geometry.point_spacing:g} m"]
    return f"{', '.join(said)} (simulated)"


def scene_of_layouts(
    *given, geometry, noise, seed=0, terrain=None, point_id=None
) -> "Scene":
    """Scene of flights that were laid out elsewhere, over points of theirs.

    ``given``: layouts, a FlightLayout for "high_flight" and one for "low_flight";
    position (n_points, 2) from the centre of the area [m]; is_control (n_points,). The
    rest of ``geometry`` and ``noise`` is that of :func:`simulate_block`. ``terrain``
    has ``height(position)``; where it or the names of the points are left out, they are
    those of any block.
    """
    layouts, position, is_control = given
    streams = _streams(seed)
    if terrain is None:
        terrain = shape_terrain(geometry, streams["terrain"])
    if point_id is None:
        point_id = name_points(len(position))
    cartesian = _cartesian(geometry, position, terrain)
    ground = Ground(point_id, position, terrain, cartesian)
    is_check = _choose_check(geometry, layouts, is_control, streams["check"])
    parts = (geometry, noise, streams, ground, layouts, is_control, is_check)
    return Scene(seed, *parts)


@dataclass(frozen=True, eq=False)
class Scene:
    """The block before it is measured, which can be done once: streams run on."""

    seed: int
    geometry: BlockGeometry
    noise: BlockNoise
    streams: dict
    ground: Ground
    layouts: dict
    is_control: np.ndarray
    is_check: np.ndarray

    def measured(self, name) -> SimulatedBlock:
        """Measure it: the block with every table as it would be read from files."""
        measure = MEASURE[self.geometry.measurement]
        measured = {flight: measure(self.to_measure(flight)) for flight in FLIGHTS}
        return SimulatedBlock(
            name=name,
            crs=self.geometry.crs,
            control_points=self.given_points(),
            high_flight=_flight("high", measured["high_flight"], self),
            low_flight=_flight("low", measured["low_flight"], self),
            truth=self.truth(),
            gross_errors=_gross_errors(measured),
            geometry=self.geometry,
            noise=self.noise,
            seed=int(self.seed),
        )

    def with_noise_of(self, seed) -> "Scene":
        """The same block, disturbed by the errors of another seed."""
        drawn = _streams(seed)
        noise = {name: drawn[name] for name in NOISE_STREAMS}
        return replace(self, seed=seed, streams={**self.streams, **noise})

    def to_measure(self, flight) -> FlightToMeasure:
        """All that the measurement of one flight needs."""
        height = flight.removesuffix("_flight")
        names = ("setting", *FLIGHT_NOISE)
        streams = {name: self.streams[f"{name}_{height}"] for name in names}
        layout, noise = self.layouts[flight], self.noise.of_flight(flight)
        return FlightToMeasure(self.geometry, self.ground, layout, noise, streams)

    def plane_measured(self, flight):
        """Measured x, y of plane models in the unit of the flight, (n_rows, 2)."""
        xy = measure_plane_in_machine(self.to_measure(flight))
        if self.geometry.transformation_kind != "rigid":
            return xy
        return xy * (self.layouts[flight].scale_number * METRES_PER_MM)

    def truth(self):
        """point_id, easting, northing [, height] of all points."""
        geometry, ground = self.geometry, self.ground
        table = pd.DataFrame(
            {
                "point_id": ground.point_id,
                "easting": geometry.centre_easting + ground.position[:, 0],
                "northing": geometry.centre_northing + ground.position[:, 1],
            }
        )
        if geometry.has_heights:
            table["height"] = ground.terrain.height(ground.position)
        return table

    def given_points(self):
        """Control and check points, as a survey would give them."""
        names = [name for name in GROUND_AXES if name in self.truth()]
        given = self.truth()
        given[names] += self.errors_of_given()[:, : len(names)]
        given["standard_error_m"] = self.stated_error
        given["role"] = np.where(self.is_control, "control", "check")
        return given[self.is_control | self.is_check].reset_index(drop=True)

    def errors_of_given(self):
        """Errors of given easting, northing, height of all points (n_points, 3) [m]."""
        per_coordinate = self.noise.control_standard_error / np.sqrt(2.0)
        error = per_coordinate * self.streams["control"].standard_normal(
            (len(self.is_control), len(GROUND_AXES))
        )
        strain = self.streams["strain"]
        error[:, :2] += strain_network(self.ground.position, self.noise, strain)
        return error

    @property
    def stated_error(self):
        """Standard error that the given points say of themselves, TOTAL [m]."""
        return max(self.noise.control_standard_error, LEAST_STANDARD_ERROR)

    def stated_m_g_um(self, flight):
        """TOTAL error of a measured point that a flight says of itself [µm]."""
        return max(getattr(self.noise, f"{flight}_m_g_um"), LEAST_M_G_UM)


def set_scene(geometry, noise, seed, *, spacing=None) -> Scene:
    """Lay both flights of a block over its points, and choose control.

    ``spacing`` [m]: where fewer points stand for all of them, among which control is
    chosen.
    """
    streams = _streams(seed)
    is_thinned = spacing is not None and spacing > geometry.point_spacing
    given = geometry, streams["points"], *((spacing,) if is_thinned else ())
    position, n_control = scatter_points(*given), 0
    terrain = shape_terrain(geometry, streams["terrain"])
    if is_thinned:
        high = lay_flight(geometry, "high_flight", position)
        position, n_control = with_control_of_all(geometry, high, position)
    layouts = {flight: lay_flight(geometry, flight, position) for flight in FLIGHTS}
    high = layouts["high_flight"]
    if n_control:
        high = on_control_alone(high, n_control, geometry.control_per_model)
    control = choose_control(geometry, high, position)
    is_control = np.zeros(len(position), dtype=bool)
    is_control[control] = True
    if not geometry.shares_control and geometry.measurement != "images":
        of_all = layouts["high_flight"]
        layouts["high_flight"] = leave_control_of_others(of_all, control)
    given = layouts, position, is_control
    how = {"geometry": geometry, "noise": noise, "seed": seed}
    return scene_of_layouts(*given, **how, terrain=terrain)


def _cartesian(geometry, position, terrain):
    """What models show: the map made straight about the middle of the area."""
    height, crs = terrain.height(position), geometry.crs
    if not geometry.has_heights:
        middle = np.array([geometry.centre_easting, geometry.centre_northing])
        points, scale_number = position + middle, geometry.high_scale_number
        if crs is None or not bends_plane_models(points, scale_number, crs):
            return None
        plane = straightened_in_plan(points, middle, crs) - middle
        return np.column_stack([plane, height])
    if not is_of_the_earth(crs):
        return None
    middle = np.array([geometry.centre_easting, geometry.centre_northing, 0.0])
    points = np.column_stack([position, height]) + middle
    away = np.array([0.0, 0.0, geometry.mean_height])
    return straightened(points, middle + away, crs) - middle


def _choose_check(geometry, layouts, is_control, rng):
    """Draw check points among the new points that both flights hold."""
    if geometry.n_check == 0:
        return np.zeros_like(is_control)
    is_held = [np.isin(np.arange(len(is_control)), o.point) for o in layouts.values()]
    new = np.flatnonzero(is_held[0] & is_held[1] & ~is_control)
    if geometry.n_check > len(new):
        raise SettingsError(
            f"n_check = {geometry.n_check}",
            expected=f"0 to {len(new)}, the number of new points",
            remedy="Lower n_check, or point_spacing",
        )
    # a permutation, so that one more check point leaves the others as they are
    is_check = np.zeros_like(is_control)
    is_check[rng.permutation(new)[: geometry.n_check]] = True
    return is_check


def _flight(height, measured, scene):
    geometry = scene.geometry
    flight = Flight(
        **measured.tables,
        scale_number=getattr(geometry, f"{height}_scale_number"),
        m_g_um=scene.stated_m_g_um(height),
        transformation=geometry.transformation_kind,
    )
    return _at_ground_scale(flight) if flight.transformation == "rigid" else flight


def _at_ground_scale(flight):
    """The flight as a plotter that shows ground units would give it."""
    factor = flight.scale_number * METRES_PER_MM
    tables = {
        name: table.assign(**{n: table[n] * factor for n in LENGTHS if n in table})
        for name in ("model_points", "y_parallaxes", "base")
        if isinstance(table := getattr(flight, name), pd.DataFrame)
    }
    return replace(flight, **tables, model_unit="m")


def _gross_errors(measured):
    parts = [m.gross_errors.assign(flight=flight) for flight, m in measured.items()]
    return pd.concat(parts, ignore_index=True)[GROSS_ERROR_COLUMNS]


def _preset(name):
    if is_choice(name, PRESETS):
        return PRESETS[name]
    near = nearest(name, PRESETS, alike=0.3)
    raise SettingsError(
        f"preset {described(name)} is unknown",
        expected=" or ".join(PRESETS),
        remedy=f"Write {near!r}" if near else "",
    )


def _require_kinds(**given):
    for name, (value, kind) in given.items():
        remedy = f"Write {name}={kind.__name__}(…)"
        require_kind(name, value, kind, expected=f"a {kind.__name__}", remedy=remedy)


def _streams(seed):
    """One stream of random numbers per purpose, those of noise apart."""
    if seed not in Range(0, np.inf, is_whole=True):
        found = f"seed = {described(seed)}"
        raise SettingsError(found, expected="a whole number from 0")
    of_geometry, of_noise = np.random.SeedSequence(int(seed)).spawn(2)
    return {
        name: np.random.default_rng(child)
        for root, names in ((of_geometry, GEOMETRY_STREAMS), (of_noise, NOISE_STREAMS))
        for name, child in zip(names, root.spawn(len(names)), strict=True)
    }
