"""Chains to some quantities: nothing changes but what is not needed is left out."""

import numpy as np
import pytest
from scipy import sparse

from einschalt.theory.adjustment.needed_errors import needed_errors
from einschalt.theory.adjustment.point_operator import Axes, PointOperator, unchanged

N_WANTED, N_BETWEEN, N_SOURCES = 6, 80, 400


def operator(rng, n_rows, n_columns, axes, density=0.01):
    pairs = sparse.random_array((n_rows, n_columns), density=density, rng=rng)
    whole = np.ones((axes.value, axes.value))
    return PointOperator((sparse.kron(pairs, whole, format="csr"),), axes)


@pytest.fixture(params=list(Axes), ids=lambda axes: axes.name.lower())
def chains(request):
    """Two sums of two sources, with a step in common."""
    rng, axes = np.random.default_rng(4), request.param
    common = operator(rng, N_BETWEEN, N_SOURCES, axes)
    found = []
    for _ in range(2):
        last = operator(rng, N_WANTED, N_BETWEEN, axes, density=0.05)
        both = last @ common + operator(rng, N_WANTED, N_SOURCES, axes)
        found.append({"shared": both, "own": operator(rng, N_WANTED, N_SOURCES, axes)})
    return found


def test_what_is_left_gives_the_same(chains):
    rng, axes = np.random.default_rng(1), chains[0]["own"].axes
    sizes = {name: rng.uniform(1.0, 2.0, N_SOURCES) for name in ("shared", "own")}
    short, left = needed_errors(chains, sizes)
    for name, given in sizes.items():
        kept = np.flatnonzero(np.isin(given, left[name]))
        assert 0 < len(kept) < 0.6 * N_SOURCES
        columns = axes.rows(kept).ravel()
        for whole, part in zip(chains, short, strict=True):
            matrix = whole[name].matrix.toarray()
            assert np.array_equal(part[name].matrix.toarray(), matrix[:, columns])
            assert not np.delete(matrix, columns, axis=1).any()


def test_steps_between_keep_only_the_rows_that_are_asked_for(chains):
    sizes = {name: np.ones(N_SOURCES) for name in ("shared", "own")}
    (first, _), _ = needed_errors(chains, sizes)
    last, common = first["shared"].products[0].factors
    used = np.unique(chains[0]["shared"].products[0].factors[0].indices)
    assert last.shape[1] == common.shape[0] == len(used)


def test_errors_that_are_quantities_themselves_all_stay():
    sizes = {"own": np.ones((5, 2))}
    (part,), left = needed_errors([{"own": unchanged(Axes.PLANE)}], sizes)
    assert part["own"].factors == ()
    assert left["own"].shape == (5, 2)
