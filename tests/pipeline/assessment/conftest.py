"""Results of both ways for all rooms of the assessment."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import (
    PRESETS,
    BlockGeometry,
    simulate_block,
)


@pytest.fixture(scope="session")
def simultaneous_result(demo_block):
    """The block without faults in one adjustment."""
    return densify(demo_block, Settings(method="simultaneous"))


@pytest.fixture(scope="session")
def shifted_names_result(demo_block):
    """The block in one adjustment, its control under names that moved by one row."""
    control = demo_block.control_points
    names = np.roll(control["point_id"].to_numpy(), 1)
    block = replace(demo_block, control_points=control.assign(point_id=names))
    return densify(block, Settings(method="simultaneous", tolerance=0.10))


@pytest.fixture(scope="session")
def parallaxes_result():
    """A block whose models were oriented by y-parallaxes."""
    geometry = BlockGeometry(width=3_000.0, height=3_000.0, measurement="parallaxes")
    return densify(simulate_block("demo", seed=1, geometry=geometry))


@pytest.fixture(scope="session")
def spatial_block():
    """The demo block with heights, measured in a machine."""
    geometry = replace(PRESETS["demo"].geometry, transformation="helmert_3d")
    return simulate_block("demo", seed=2, geometry=geometry)


@pytest.fixture(scope="session")
def spatial_result(spatial_block):
    """What it gives in two steps."""
    return densify(spatial_block)


@pytest.fixture(scope="session")
def image_block():
    """The demo block with heights, from image coordinates."""
    geometry = replace(
        PRESETS["demo"].geometry, measurement="images", transformation="helmert_3d"
    )
    return simulate_block("demo", seed=1, geometry=geometry)
