"""Blocks that several studies look at, simulated once."""

from functools import cache

import pytest

from einschalt.pipeline.simulation.simulate_block import simulate_block


@pytest.fixture(scope="session")
def neukirchen():
    """Simulated Neukirchen by its seed."""
    return cache(lambda seed: simulate_block("neukirchen", seed=seed))
