"""Is the precision that a plan expects the precision that the block then has?

Twelve designs of flights on film, with large-format digital cameras and with UAVs:
propagation on one layout before anything is measured, against the true errors of many
simulated and densified blocks.
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from tests.truth.long_form.figures import Figure, Table, of_blocks, root_of_ratio

from einschalt.pipeline.densify import densify
from einschalt.pipeline.planning.estimate.effort import flights_of
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.pipeline.planning.propagation.expected_precision import (
    expect_precision,
    zones_of,
)
from einschalt.pipeline.simulation.repetitions import true_errors
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.theory.planning.expected_precision import expected_parts

# by the first word of a design: so many that the figures are known to 0.01
N_BLOCKS = {"film": 40, "DMC": 32, "UltraCam": 48, "UAV": 100}
WITHIN_3_PERCENT = {"low": 0.97, "high": 1.03}


def flown_with(camera, scale_number, spacing, m_g_um, **more):
    """Give a design with a camera and its usual overlaps."""
    preset = CAMERAS[camera]
    names = ("image_format", "principal_distance", "forward_overlap", "side_overlap")
    return FlightDesign(
        scale_number=scale_number,
        spacing=spacing,
        m_g_um=m_g_um,
        **{name: getattr(preset, name) for name in names},
        **more,
    )


FILM, DMC, EAGLE = "film_wide", "dmc_3", "ultracam_eagle"
FULL_FRAME, ONE_INCH = "uav_full_frame", "uav_one_inch"
SMALL = {"width": 7e3, "height": 7e3}
DESIGNS = {
    "film 1:8000, 300 m": flown_with(FILM, 8000, 300, 5.0, high_scale_number=15000),
    "film 1:6000, 200 m": flown_with(FILM, 6000, 200, 10.0, high_scale_number=12000),
    "film 1:10000, 400 m, helmert": flown_with(FILM, 10000, 400, 5.0, kind="helmert"),
    "film 1:12000, 300 m, nine control points": flown_with(
        FILM, 12000, 300, 10.0, control_per_model=9
    ),
    "DMC III 1:20000, 200 m": flown_with(DMC, 20000, 200, 1.7),
    "UltraCam 1:25000, 300 m": flown_with(EAGLE, 25000, 300, 1.7),
    "DMC III 1:30000, 400 m": flown_with(DMC, 30000, 400, 1.7),
    "UltraCam 1:30000, 250 m, rigid": flown_with(
        EAGLE, 30000, 250, 2.5, kind="rigid", **SMALL
    ),
    "UAV 36 mm 1:16000, 100 m": flown_with(FULL_FRAME, 16000, 100, 1.9),
    "UAV 36 mm 1:20000, 150 m": flown_with(FULL_FRAME, 20000, 150, 1.9),
    "UAV 13 mm 1:30000, 100 m, helmert": flown_with(
        ONE_INCH, 30000, 100, 1.0, kind="helmert", control_standard_error=0.02
    ),
    "UAV 36 mm 1:24000, 200 m": flown_with(FULL_FRAME, 24000, 200, 1.9),
}


class Squares(NamedTuple):
    """Mean squared true errors of one block, TOTAL [m²]."""

    mean: float
    edge: float
    centre: float


def tables():
    """Run the study.

    Returns
    -------
    list of Table
    """
    return [
        Table(
            f"Planned precision, {len(DESIGNS)} designs",
            "Expected error divided by true error, root mean squares: for the mean of "
            "all values of a point, and for the values of one model at the edge "
            "(bounds 0.97 to 1.03). The last columns give the true error of the mean, "
            "and the expectations of the closed estimate and of the formula of 1971.",
            (
                "design",
                "blocks",
                "mean",
                "edge",
                "middle",
                "true mean [cm]",
                "closed",
                "1971",
            ),
            [_row(name) for name in DESIGNS],
        )
    ]


def _row(name):
    design = DESIGNS[name]
    figures = expect_precision(design).figures
    n_blocks = N_BLOCKS[name.split()[0]]
    blocks = of_blocks(partial(true_squares, name), range(1, n_blocks + 1))
    mean, edge, centre = np.transpose(blocks)

    def over_truth(expected, squares, **bounds):
        return root_of_ratio(np.full(len(squares), expected**2), squares, **bounds)

    closed = float(expected_parts(flights_of(design), design.model).mean)
    return (
        name,
        f"{n_blocks}",
        over_truth(figures.mean, mean, **WITHIN_3_PERCENT),
        over_truth(figures.single_edge, edge, **WITHIN_3_PERCENT),
        over_truth(figures.single_centre, centre),
        Figure(100.0 * np.sqrt(mean.mean()), form=".2f"),
        Figure(over_truth(closed, mean).value, form=".2f"),
        Figure(over_truth(figures.paper_mean, mean).value, form=".2f"),
    )


def true_squares(name, seed) -> Squares:
    """Simulate a design with noise, densify it, and compare with the true points.

    Parameters
    ----------
    name : str
        A key of ``DESIGNS``.
    seed : int

    Returns
    -------
    Squares
        Of the means at the new points, and of one model's values at the edge and in
        the middle.
    """
    design = DESIGNS[name]
    block = simulate_block(seed=seed, geometry=design.geometry(), noise=design.noise())
    result = densify(block)
    points = result.solution.points  # not judged: only their places count
    new = points[points["role"] == "new"]
    values = result.single_values
    zones, of_values = zones_of(values), _squares(values, block.truth)
    return Squares(
        float(_squares(new, block.truth).mean()),
        float(of_values[zones["edge"]].mean()),
        float(of_values[zones["centre"]].mean()),
    )


def _squares(points, truth):
    return (true_errors(points, truth) ** 2).sum(axis=1)
