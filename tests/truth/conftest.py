"""Blocks that several studies look at, simulated once."""

from functools import cache
from types import SimpleNamespace

import pytest

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import simulate_block


@pytest.fixture(scope="session")
def neukirchen():
    """Simulated Neukirchen by its seed."""
    return cache(lambda seed: simulate_block("neukirchen", seed=seed))


@pytest.fixture(scope="session")
def densified_neukirchen(neukirchen):
    """What it gives with certain settings, as light as it can be kept."""

    @cache
    def call(seed, coverage_mean, weighting):
        settings = Settings(coverage_mean=coverage_mean, weighting=weighting)
        result = densify(neukirchen(seed), settings)
        return SimpleNamespace(
            points=result.solution.points,
            approximations=result.approximations,
            single_values=result.single_values,
            figures=result.figures,
            covariance=result.errors.covariance,
        )

    return call
