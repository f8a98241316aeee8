"""Results of both ways for all rooms of the assessment."""

import pytest

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import BlockGeometry, simulate_block


@pytest.fixture(scope="session")
def simultaneous_result(demo_block):
    """The block without faults in one adjustment."""
    return densify(demo_block, Settings(method="simultaneous"))


@pytest.fixture(scope="session")
def parallaxes_result():
    """A block whose models were oriented by y-parallaxes."""
    geometry = BlockGeometry(width=3_000.0, height=3_000.0, measurement="parallaxes")
    return densify(simulate_block("demo", seed=1, geometry=geometry))
