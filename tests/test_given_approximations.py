"""Given approximate coordinates have the errors that were asked for."""

import numpy as np
import pytest
from tests.given_approximations import onto_given_approximations

from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.theory.adjustment.spatial_correlation import morans_i, nearest_neighbours


@pytest.fixture(scope="module")
def block():
    return simulate_block("neukirchen", seed=2)


def errors_of(given, block):
    plan = ["easting", "northing"]
    return given.approximate_points[plan].to_numpy() - block.truth[plan].to_numpy()


def test_own_errors_have_their_size_and_no_neighbours(block):
    given = onto_given_approximations(block, own_error=0.1, seed=1)
    error = errors_of(given, block)
    total = np.sqrt(np.mean(np.sum(error**2, axis=1)))
    assert total == pytest.approx(0.1, rel=0.06)
    assert given.approximate_m_0_m == pytest.approx(total)
    near = nearest_neighbours(block.truth[["easting", "northing"]].to_numpy())
    assert abs(morans_i(error, near)) < 0.06


def test_photographs_make_neighbours_alike(block):
    given = onto_given_approximations(
        block, own_error=0.0, photograph_error=0.1, seed=1, is_stated=False
    )
    assert given.approximate_m_0_m is None
    error = errors_of(given, block)
    near = nearest_neighbours(block.truth[["easting", "northing"]].to_numpy())
    assert morans_i(error, near) > 0.5
    # means of two to six photographs
    assert 0.1 / np.sqrt(6) < np.sqrt(np.mean(np.sum(error**2, axis=1))) < 0.1
