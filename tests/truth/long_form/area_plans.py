"""Is the precision of a flight plan over an area what the flight then has?

Twelve plans each on film, with large-format digital cameras and with UAVs, over areas
of any outline: propagation on the plan's own layout before anything is measured,
against the true errors of flights that are simulated on it and densified.
"""

from dataclasses import replace
from functools import cache, partial

import numpy as np
import pandas as pd
import shapely
from tests.truth.long_form.figures import Figure, Table, of_blocks, root_of_ratio

from einschalt.pipeline.densify import densify
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.layout import FLIGHTS, lay_out
from einschalt.pipeline.planning.area.recommended import propagate
from einschalt.pipeline.planning.area.simulated_plan import PlannedBlock
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.pipeline.simulation.repetitions import true_errors
from einschalt.pipeline.simulation.simulate_block import scene_of_layouts

WITHIN_3_PERCENT = {"low": 0.97, "high": 1.03}
N_BLOCKS = {"film": 200, "large format": 200, "UAV": 800}
TOGETHER = 20
CAMERAS_OF = {
    "film": ("film_wide", "film_normal", "film_super_wide"),
    "large format": ("dmc_3", "ultracam_eagle", "ultracam_xp", "dmc_ii_250"),
    "UAV": ("uav_full_frame", "uav_one_inch", "uav_four_thirds"),
}
DESIGNS = tuple(f"{kind} {k + 1}" for kind in CAMERAS_OF for k in range(12))
CENTRE = np.array([500_000.0, 5_300_000.0])
POINTS_IN_A_MODEL = (12, 30)


@cache
def plan_of(name):
    """Draw an area and a design for it; the layout that results."""
    kind, _, number = name.rpartition(" ")
    rng = np.random.default_rng([list(CAMERAS_OF).index(kind), int(number)])
    names = CAMERAS_OF[kind]
    preset = CAMERAS[names[int(number) % len(names)]]
    scale = float(rng.choice(preset.scale_numbers))
    along, across = (scale * side for side in preset.image_format)
    in_model = rng.uniform(*POINTS_IN_A_MODEL)
    spacing = round(float(np.sqrt(preset.forward_overlap * along * across / in_model)))
    design = FlightDesign(
        scale_number=scale,
        spacing=max(spacing, 2),
        m_g_um=preset.m_g_um[0] * rng.uniform(0.7, 1.5),
        kind=str(rng.choice(["affine", "affine", "helmert"])),
        image_format=preset.image_format,
        principal_distance=preset.principal_distance,
        forward_overlap=preset.forward_overlap,
        side_overlap=preset.side_overlap,
        n_coverages=int(rng.choice([1, 2, 2])),
        high_scale_number=scale * float(rng.choice([1.25, 1.5, 1.875])),
        high_m_g_um=preset.m_g_um[0],
        control_standard_error=float(rng.choice([0.01, 0.02, 0.03])),
        control_per_model=int(rng.choice([5, 9])),
        width=3.0 * max(along, across),
        height=3.0 * max(along, across),
    )
    return lay_out(star_shaped(rng, 3.2 * max(along, across)), design)


def star_shaped(rng, size):
    """Draw a star-shaped outline as an area."""
    angle = np.sort(rng.uniform(0, 2 * np.pi, 9))
    away = size / 2.0 * rng.uniform(0.7, 1.0, 9)
    ring = np.column_stack([away * np.cos(angle), away * np.sin(angle)])
    return FlightArea(shapely.Polygon(ring + CENTRE))


def true_squares(name, seed, n_flights=TOGETHER):
    """Mean squared true errors of the new points of some flights, TOTAL [m²].

    The flights are densified together, as one block of parts that share nothing: that
    is quicker. With the default settings, as users densify theirs.
    """
    layout = plan_of(name)
    flown = PlannedBlock(layout.design, np.nan, layout.area).flown
    n_points = len(flown.position)
    scene = scene_of_layouts(
        {
            flight: _repeated(flown.flights[flight], n_points, n_flights)
            for flight in FLIGHTS
        },
        np.tile(flown.position, (n_flights, 1)),
        np.tile(flown.is_control, n_flights),
        geometry=flown.geometry,
        noise=layout.design.noise(),
        seed=seed,
    )
    block = scene.measured("Planned (simulated)")
    points = densify(block).solution.points
    new = points[points["role"] == "new"]
    names = pd.Index(block.truth["point_id"])
    flight = names.get_indexer(new["point_id"]) // n_points
    square = (true_errors(new, block.truth) ** 2).sum(axis=1)
    return np.bincount(flight, square) / np.bincount(flight)


def _repeated(layout, n_points, n_flights):
    """Lay the same flight several times, over points of their own."""
    times = np.arange(n_flights)[:, None]
    return replace(
        layout,
        rasters=layout.rasters * n_flights,
        coverage=(layout.coverage + times * len(layout.rasters)).ravel(),
        place=np.tile(layout.place, n_flights),
        centre=np.tile(layout.centre, (n_flights, 1)),
        model=(layout.model + times * layout.n_models).ravel(),
        point=(layout.point + times * n_points).ravel(),
    )


def tables():
    """Run the study.

    Returns
    -------
    list of Table
    """
    return [
        Table(
            f"Flight plans over areas, {len(DESIGNS)} designs",
            "Expected error of the new points divided by the true one, root mean "
            "squares (bounds 0.97 to 1.03). Control is that of the plan; flights are "
            "densified with the default settings.",
            ("design", "flights", "models", "control", "ratio", "true [cm]"),
            [_row(name) for name in DESIGNS],
        )
    ]


def _row(name):
    """More flights, and more again, until the ratio is known well enough."""
    n_flights = N_BLOCKS[name.rpartition(" ")[0]]
    layout = plan_of(name)
    expected, squares = propagate(layout).mean, np.empty(0)
    ratio = None
    while ratio is None or ratio.error > ratio.known_to:
        before = len(squares) // TOGETHER
        seeds = range(before + 1, before + n_flights // TOGETHER + 1)
        found = of_blocks(partial(true_squares, name), seeds)
        squares = np.concatenate([squares, *found])
        expected_squares = np.full(len(squares), expected**2)
        ratio = root_of_ratio(expected_squares, squares, **WITHIN_3_PERCENT)
    return (
        name,
        f"{len(squares)}",
        f"{sum(layout.oriented(flight).n_models for flight in FLIGHTS)}",
        f"{int(layout.is_control.sum())}",
        ratio,
        Figure(100.0 * float(np.sqrt(np.mean(squares))), form=".2f"),
    )
