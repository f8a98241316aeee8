"""Blocks of photographs without a high flight: models go straight onto the control."""

from dataclasses import replace

import numpy as np

from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.simulate_block import simulate_block

ERROR = 0.02  # of each given coordinate [m]
GEOMETRY = BlockGeometry(width=3000.0, height=3000.0, measurement="images", n_check=0)
AXES = ["easting", "northing", "height"]


def one_flight(seed, n_given=25):
    """Photographs that go straight onto control, with its true errors."""
    block = simulate_block("demo", seed=seed, geometry=GEOMETRY)
    rng = np.random.default_rng(seed)
    rows = np.sort(rng.choice(len(block.truth), n_given, replace=False))
    given = block.truth.iloc[rows].reset_index(drop=True)
    given = given[["point_id", *AXES]]
    given[AXES] += rng.normal(0.0, ERROR, (n_given, 3))
    error = np.sqrt(2.0) * ERROR
    return replace(
        block,
        high_flight=None,
        approximate_points=given,
        approximate_m_0_m=error,
        control_points=given.assign(standard_error_m=error, role="control"),
    )


def with_wrong_control(block, row, error):
    """The block with another place of one control point [m], approximate as well."""

    def moved(points):
        points = points.copy()
        points.loc[row, AXES] += error
        return points

    names = ("control_points", "approximate_points")
    return replace(block, **{name: moved(getattr(block, name)) for name in names})
