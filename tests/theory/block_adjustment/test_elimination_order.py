"""Where models lie to each other, and the order of elimination that follows."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from einschalt.foundations.sparse_cholesky.nested_dissection import _sort, dissect
from einschalt.theory.block_adjustment.model_graph import (
    Neighbours,
    chained_positions,
    incidence_of,
    neighbours_of,
)

SIDE = 60
SPACING = 1000.0
SIGMA = 0.03


@pytest.fixture(scope="module")
def block():
    """Models on a square grid, each turned as it likes: centres, fans, coordinates."""
    rng = np.random.default_rng(8)
    centre = (np.stack(np.divmod(np.arange(SIDE**2), SIDE), axis=-1) + 0.5) * SPACING
    ground = rng.uniform(0.0, SIDE * SPACING, (7 * SIDE**2, 2))
    near = cKDTree(ground).query_ball_point(centre, 0.75 * SPACING, p=np.inf)
    model = np.repeat(np.arange(SIDE**2), [len(points) for points in near])
    point = np.concatenate([np.sort(points) for points in near]).astype(int)
    turn = np.exp(1j * rng.uniform(-np.pi, np.pi, SIDE**2)) / 8.0
    z = (ground[point] - centre[model]) @ [1.0, 1j]
    z = turn[model] * (z + SIGMA * rng.standard_normal((len(z), 2)) @ [1.0, 1j])
    incidence = incidence_of(model, point, SIDE**2, len(ground))
    return centre, incidence, np.column_stack([z.real, z.imag])


def test_positions_are_those_of_the_models(block):
    centre, incidence, xy = block
    found = chained_positions(incidence, xy) @ [1.0, 1j]
    design = np.column_stack([found, np.ones(len(found))])
    true = centre @ [1.0, 1j]
    similarity = np.linalg.lstsq(design, true, rcond=None)[0]
    assert np.abs(design @ similarity - true).max() < 0.2 * SPACING


def test_a_square_is_cut_into_halves_along_its_rows(block):
    _, incidence, xy = block
    elimination = dissect(neighbours_of(incidence), chained_positions(incidence, xy))
    n_own = np.diff(elimination.start)
    # models at the first cut: one row of the grid, less or more at a slanting one
    assert SIDE <= n_own[-1] <= 1.2 * SIDE
    assert n_own.max() <= 1.2 * SIDE


def test_a_block_is_cut_at_its_neck():
    """Two fields, twenty models wide, that two models of a strip hold together."""
    fields = [(i, j) for j in range(20) for i in (*range(20), *range(24, 40))]
    neck = [(i, j) for i in range(20, 24) for j in (9, 10)]
    place = np.array(fields + neck)
    away = np.abs(place[:, None] - place[None]).max(axis=2)
    start = np.concatenate([[0], np.cumsum((away == 1).sum(axis=1))])
    neighbours = Neighbours(start, np.nonzero(away == 1)[1])
    elimination = dissect(neighbours, place.astype(float))
    last = elimination.order[elimination.start[-2] :]
    assert len(last) == 2
    assert set(last.tolist()) <= set(range(len(fields), len(place))) | set(
        np.flatnonzero((place[:, 0] == 19) | (place[:, 0] == 24)).tolist()
    )


def test_every_model_is_eliminated_once_and_after_those_below(block):
    _, incidence, xy = block
    neighbours = neighbours_of(incidence)
    elimination = dissect(neighbours, chained_positions(incidence, xy))
    assert np.array_equal(np.sort(elimination.order), np.arange(SIDE**2))
    assert np.array_equal(elimination.position[elimination.order], np.arange(SIDE**2))
    assert elimination.start[-1] == SIDE**2
    front = np.repeat(np.arange(len(elimination.parent)), np.diff(elimination.start))
    above = {f: _line_of(f, elimination.parent) for f in set(front.tolist())}
    of_model = front[elimination.position]
    pairs = np.repeat(np.arange(SIDE**2), np.diff(neighbours.start))
    for a, b in zip(of_model[pairs], of_model[neighbours.models], strict=True):
        # neighbours stand in one line of fronts, or one would fill the other's branch
        assert a in above[b] or b in above[a]


def test_models_without_common_points_lie_anywhere_and_are_ordered():
    incidence = incidence_of(np.array([0, 0, 1, 1, 1]), np.array([0, 1, 2, 3, 4]), 2, 5)
    xy = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    positions = chained_positions(incidence, xy)
    assert np.isfinite(positions).all()
    elimination = dissect(neighbours_of(incidence), positions)
    assert sorted(elimination.order.tolist()) == [0, 1]


def _line_of(front, parent):
    """A front and all that stand above it."""
    line = set()
    while front >= 0:
        line.add(front)
        front = parent[front]
    return line


@pytest.mark.parametrize("n", [1, 2, 3, 64, 101])
def test_models_with_the_same_key_stay_in_their_order(n):
    rng = np.random.default_rng(n)
    models = rng.permutation(n + 7)[:n]
    key = rng.integers(0, 5, n + 7).astype(float)
    expected = models[np.argsort(key[models], kind="stable")]
    _sort(models, key)
    np.testing.assert_array_equal(models, expected)
