"""A small block in one dense matrix is adjusted as it is by fronts."""

from dataclasses import replace

import numpy as np
import pytest
from tests.theory.block_adjustment.test_spatial_solution import a_block

from einschalt.foundations.sparse_cholesky.elimination_pattern import (
    block_pattern,
    find_fronts,
)
from einschalt.foundations.sparse_cholesky.multifrontal import factorize
from einschalt.foundations.sparse_cholesky.nested_dissection import at_once, dissect
from einschalt.theory.block_adjustment import solver
from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.model_graph import Neighbours
from einschalt.theory.block_adjustment.spatial_solution import adjust_spatially

ROUNDING = 1e-10


@pytest.fixture
def both(monkeypatch):
    """Solutions of a block at once and by fronts."""

    def adjust_twice(block):
        at_once = adjust(block)
        monkeypatch.setattr(solver, "MOST_AT_ONCE", 0)
        return at_once, adjust(block)

    return adjust_twice


def numbers(solution):
    return {
        "points": solution.points,
        "affinities": solution.affinities,
        "of points": solution.point_cofactors,
        "of observations": solution.adjusted_cofactors,
        "of parameters": solution.parameter_cofactors,
        "determinant": solution.log_determinant,
    }


@pytest.mark.parametrize("layout", ["grid", "dense grid", "strip", "ring"])
@pytest.mark.parametrize("kind", ["affine", "helmert", "mixed"])
def test_both_ways_agree(make_block, both, layout, kind):
    solutions = both(make_block(layout, kind))
    n_fronts = [len(one.ordering.fronts.parent) for one in solutions]
    assert n_fronts[0] == 1 < n_fronts[1]
    at_once, by_fronts = map(numbers, solutions)
    for name, values in by_fronts.items():
        size = np.abs(values).max()
        assert np.abs(at_once[name] - values).max() <= ROUNDING * size, name
    np.testing.assert_allclose(
        solutions[0].residuals, solutions[1].residuals, atol=ROUNDING
    )


@pytest.mark.parametrize("is_rough", [False, True])
@pytest.mark.parametrize("kind", ["affine", "helmert", "mixed"])
def test_a_block_that_own_deformations_make_large_is_parted(
    make_block, monkeypatch, kind, is_rough
):
    plain = adjust(make_block("grid", kind))
    x, y = (plain.observations.xy / np.abs(plain.observations.xy).max()).T
    turns = np.exp(1j * np.arange(3))
    bent = 0.05 * np.stack([x * x, x * y, y * y], axis=1) * turns  # at the edge [m]
    if kind == "affine":
        bent = bent.real
    observations = replace(plain.observations, bent=bent)
    at_once = plain.readjusted(observations, is_rough=is_rough)
    assert at_once.ordering is plain.ordering
    n_solved = plain.solver.factor.n_unknowns * (2 if kind == "helmert" else 1)
    most = plain.observations.n_models * n_solved
    monkeypatch.setattr(solver, "MOST_AT_ONCE", most)
    by_fronts = plain.readjusted(observations, is_rough=is_rough)
    assert len(by_fronts.ordering.fronts.parent) > 1
    # what has been parted stays so
    again = by_fronts.readjusted(observations, is_rough=is_rough)
    assert again.ordering is by_fronts.ordering
    for name, values in numbers(at_once).items():
        size = np.abs(values).max()
        assert np.abs(numbers(by_fronts)[name] - values).max() <= ROUNDING * size, name


def test_spatial_models_that_own_deformations_make_many_are_parted(monkeypatch):
    plain = adjust_spatially(a_block(n_points=240)[0])
    x, y = (plain.observations.xyz / np.abs(plain.observations.xyz).max()).T[:2]
    bent = np.zeros((len(x), 3, 4))
    bent[:, 0, :2] = bent[:, 1, 2:] = 0.05 * np.stack([x * x, x * y], axis=1)
    observations = replace(plain.observations, bent=bent)
    at_once = plain.readjusted(observations)
    assert at_once.ordering is plain.ordering
    monkeypatch.setattr(solver, "MOST_AT_ONCE", 9 * 7)
    by_fronts = plain.readjusted(observations)
    assert by_fronts.ordering is not plain.ordering
    assert by_fronts.readjusted(observations).ordering is by_fronts.ordering
    assert plain.readjusted(plain.observations).ordering is plain.ordering
    for name in ("points", "residuals", "bent", "unknown_cofactors", "log_determinant"):
        expected, found = getattr(at_once, name), getattr(by_fronts, name)
        size = np.abs(expected).max()
        assert np.abs(found - expected).max() <= ROUNDING * size, name


def free_chains(dtype):
    """Two chains of models that only hang together: neighbours, and their matrix."""
    n, u = 24, 2
    near = np.arange(n - 1)[np.arange(n - 1) != 11]
    pairs = np.concatenate([np.stack([near, near + 1]), np.stack([near + 1, near])], 1)
    pairs = pairs[:, np.lexsort(pairs[::-1])]
    start = np.searchsorted(pairs[0], np.arange(n + 1))
    turn = np.exp(0.5j * np.arange(n)) if dtype is complex else np.ones(n)
    laplacian = np.zeros((n, n), dtype=dtype)
    laplacian[*pairs] = -turn[pairs[0]] * np.conj(turn[pairs[1]])
    laplacian[np.arange(n), np.arange(n)] = np.diff(start)
    return Neighbours(start, pairs[1]), np.kron(laplacian, np.eye(u))


@pytest.mark.parametrize("dtype", [float, complex])
def test_both_ways_hold_what_nothing_determines(dtype):
    neighbours, matrix = free_chains(dtype)
    n, u = len(neighbours.start) - 1, 2
    blocks_of = matrix.reshape(n, u, n, u)
    position = np.column_stack([np.arange(n), np.zeros(n)])
    right = matrix @ np.random.default_rng(2).standard_normal((n * u, 3))
    for elimination in (at_once(n), dissect(neighbours, position)):
        pattern = block_pattern(neighbours, elimination)
        order = elimination.order
        column = np.repeat(np.arange(n), np.diff(pattern.start))
        blocks = blocks_of[order[pattern.row], :, order[column]].copy()
        factor = factorize(blocks, pattern, find_fronts(pattern, elimination))
        places, unknowns = np.nonzero(factor.is_held)
        assert len(places) == 2 * u
        reordered = blocks_of[order][:, :, order].reshape(n * u, n * u)
        for place, unknown in zip(places, unknowns, strict=True):
            motion = factor.null_vector(place, unknown)
            assert motion[place, unknown] == pytest.approx(1.0)
            assert np.abs(reordered @ motion.ravel()).max() < ROUNDING
        found = factor.solve(right.reshape(n, u, 3)[order])
        assert np.abs(found[places, unknowns]).max() < 1e-100
        again = reordered @ found.reshape(n * u, 3)
        np.testing.assert_allclose(
            again.reshape(n, u, 3), right.reshape(n, u, 3)[order], atol=ROUNDING
        )
