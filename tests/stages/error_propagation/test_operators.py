"""Covariances between points, on either way from the sources."""

import numpy as np
import pytest
from scipy import sparse

from einschalt.stages.error_propagation import operators
from einschalt.stages.error_propagation.operators import covariances_of_pairs
from einschalt.theory.adjustment.point_operator import Axes, PointOperator

N_VALUES, N_BETWEEN, N_SOURCES = 60, 8, 40
SIZES = {
    "control": np.linspace(0.5, 2.0, N_SOURCES),
    "high_flight": np.ones(N_SOURCES),
    "low_flight": np.full(N_SOURCES, 0.3),
}


def _step(rng, n_rows, n_columns):
    shape = Axes.PLANE.size(n_rows), Axes.PLANE.size(n_columns)
    numbers = rng.normal(size=shape) * (rng.random(shape) < 0.3)
    return PointOperator((sparse.csr_array(numbers),), Axes.PLANE)


@pytest.fixture
def chains():
    """Two sources whose errors pass through few points, and one apart."""
    rng = np.random.default_rng(1)
    onto = _step(rng, N_VALUES, N_BETWEEN)
    return {
        "control": onto @ _step(rng, N_BETWEEN, N_SOURCES),
        "high_flight": onto @ _step(rng, N_BETWEEN, N_SOURCES),
        "low_flight": _step(rng, N_VALUES, N_SOURCES),
    }


def _every_pair():
    return np.stack(np.meshgrid(np.arange(N_VALUES), [0, 5, 7]), -1).reshape(-1, 2)


@pytest.mark.parametrize("numbers", [0, 30])  # 0: pair by pair
def test_both_ways_give_the_same(chains, numbers, monkeypatch):
    monkeypatch.setattr(operators, "NUMBERS_PER_PAIR", numbers)
    pairs = _every_pair()
    expected = 0.0
    for name, chain in chains.items():
        rows = chain.matrix.toarray() * np.repeat(SIZES[name], 2)
        whole = (rows @ rows.T).reshape(N_VALUES, 2, N_VALUES, 2).swapaxes(1, 2)
        expected = expected + whole[pairs[:, 0], pairs[:, 1]]
    np.testing.assert_allclose(covariances_of_pairs(chains, SIZES, pairs), expected)


def test_few_points_are_gone_through_where_that_is_quicker(chains):
    def through(n_pairs):
        return set(operators._through_few_points(chains, n_pairs))

    shared = {"control", "high_flight"}
    assert through(len(_every_pair())) == shared
    assert through(8) == set()  # 16 x 16 numbers for 8 pairs
    alone = {"low_flight": chains["low_flight"]}
    assert operators._through_few_points(alone, 1000) == {}
    assert through(10**6) == shared


def test_all_chains_may_go_through_them(chains):
    both = {name: chains[name] for name in ("control", "high_flight")}
    pairs = _every_pair()
    apart = covariances_of_pairs(chains, SIZES, pairs)
    alone = {"low_flight": chains["low_flight"]}
    rest = covariances_of_pairs(alone, SIZES, pairs)
    np.testing.assert_allclose(covariances_of_pairs(both, SIZES, pairs), apart - rest)
