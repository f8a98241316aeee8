"""Covariances through bundles of numbers are those of the whole matrices."""

import numpy as np
import pytest
from scipy import sparse

from einschalt.theory.adjustment import bundled_covariance, joint_covariance
from einschalt.theory.adjustment.bundled_covariance import (
    BundledRows,
    points_in_a_bundle,
)
from einschalt.theory.adjustment.joint_covariance import BundlePairs
from einschalt.theory.adjustment.point_operator import Axes, PointOperator

N_POINTS, N_BUNDLES, N_EACH, N_SOURCES = 9, 5, 3, 11
PAIRS = np.array([[0, 0], [1, 3], [3, 1], [8, 2], [4, 4]])
SIZES = np.linspace(0.5, 2.0, N_SOURCES)


def _numbers(rng, shape, axes):
    numbers = rng.normal(size=shape)
    if axes is Axes.COMPLEX:
        numbers = numbers + 1j * rng.normal(size=shape)
    return numbers


def _of_bundles(axes, seed=1, n_each=N_EACH):
    """Points that depend on two or three bundles each."""
    rng = np.random.default_rng(seed)
    uses = np.zeros((N_POINTS, N_BUNDLES))
    for point in range(N_POINTS):
        uses[point, rng.choice(N_BUNDLES, 2 + point % 2, replace=False)] = 1.0
    where = np.kron(uses, np.ones((axes.value, axes.size(n_each))))
    return PointOperator(
        (sparse.csr_array(where * _numbers(rng, where.shape, axes)),), axes
    )


def _to_bundles(axes, seed=2, n_each=N_EACH):
    rng = np.random.default_rng(seed)
    shape = axes.size(N_BUNDLES * n_each), axes.size(N_SOURCES)
    numbers = _numbers(rng, shape, axes) * (rng.random(shape) < 0.4)
    return PointOperator((sparse.csr_array(numbers),), axes)


@pytest.mark.parametrize("axes", Axes)
def test_columns_that_the_same_rows_use_stand_together(axes):
    matrix = _of_bundles(axes).matrix
    assert points_in_a_bundle(matrix, axes) == N_EACH
    # a column less: nothing is common to all bundles any more
    assert points_in_a_bundle(matrix[:, axes.value :], axes) == 1


@pytest.mark.parametrize("faster", [0, 10**9])  # by pairs; by the whole matrix
@pytest.mark.parametrize("axes", Axes)
def test_pairs_of_points(axes, faster, monkeypatch):
    monkeypatch.setattr(joint_covariance, "QUICKER_AS_A_WHOLE", faster)
    points, parameters = _of_bundles(axes), _to_bundles(axes)
    size = axes.size(N_EACH)
    rows = BundledRows.of(points, size)
    met = rows.neighbours(PAIRS)
    joint = joint_covariance.joint_covariance(parameters, met, size, SIZES)
    found = rows.covariances(PAIRS, met, joint)
    whole = (points @ parameters).formed().covariances_between(PAIRS, SIZES)
    np.testing.assert_allclose(found, whole, atol=1e-12)


@pytest.mark.parametrize("size", [1, 2, 3, 4])  # 2 and 3 are summed in registers
@pytest.mark.parametrize("unit", [1.0, 1j])
def test_bundles_of_any_size(size, unit):
    rng = np.random.default_rng(8)
    numbers = rng.normal(size=(6 * size, N_SOURCES)) + unit * rng.normal(
        size=(6 * size, N_SOURCES)
    )
    some = np.kron(rng.random((6, N_SOURCES)) < 0.6, np.ones((size, 1)))
    operator = PointOperator((sparse.csr_array(numbers * some),), Axes.COMPLEX)
    pointer = np.cumsum(np.arange(7))
    column = np.concatenate([np.arange(n) for n in range(1, 7)])
    found = joint_covariance.joint_covariance(
        operator, BundlePairs(pointer, column), size, SIZES
    )
    scaled = (numbers * some * SIZES).reshape(6, size, N_SOURCES)
    later = np.repeat(np.arange(6), np.arange(1, 7))
    expected = np.einsum("pas,pbs->pab", scaled[later], scaled[column].conj())
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("n_each", [1, 2, 3, 4])  # 2 and 3 are summed in registers
@pytest.mark.parametrize("axes", Axes)
def test_points_with_themselves(axes, n_each):
    points = _of_bundles(axes, n_each=n_each)
    parameters = _to_bundles(axes, n_each=n_each)
    size, every = axes.size(n_each), np.column_stack([np.arange(N_POINTS)] * 2)
    rows = BundledRows.of(points, size)
    met = rows.neighbours(every)
    joint = joint_covariance.joint_covariance(parameters, met, size, SIZES)
    found = rows.variances(met, joint)
    whole = (points @ parameters).formed().covariances_between(every, SIZES)
    np.testing.assert_allclose(found, whole, atol=1e-12)
    np.testing.assert_allclose(rows.covariances(every, met, joint), whole, atol=1e-12)
    np.testing.assert_array_equal(found, found.swapaxes(1, 2))


@pytest.mark.parametrize("faster", [0, 10**9])
def test_an_unusable_source_spoils_only_bundles_that_know_it(faster, monkeypatch):
    monkeypatch.setattr(joint_covariance, "QUICKER_AS_A_WHOLE", faster)
    blocks = np.array([1.0, 2.0, np.nan]).reshape(3, 1, 1)
    to_bundles = PointOperator((of_diagonal(blocks),), Axes.COMPLEX)
    every = BundlePairs(np.array([0, 1, 3, 6]), np.array([0, 0, 1, 0, 1, 2]))
    joint = joint_covariance.joint_covariance(to_bundles, every, 1, np.ones(3)).ravel()
    np.testing.assert_array_equal(joint[:3], [1.0, 0.0, 4.0])
    assert np.isnan(joint[-1])


def of_diagonal(blocks):
    n = len(blocks)
    return sparse.bsr_array((blocks, np.arange(n), np.arange(n + 1)), shape=(n, n))


@pytest.mark.parametrize("axes", Axes)
def test_pairs_of_points_that_share_errors_with_bundles(axes):
    points, shared = _of_bundles(axes), _of_bundles(axes, 5)
    rows, others = (BundledRows.of(one, axes.size(N_EACH)) for one in (points, shared))
    found = rows.covariances_with(others, PAIRS)
    numbers, given = (one.matrix.toarray() for one in (points, shared))
    both = numbers @ given.conj().T
    both = both + both.conj().T
    n = axes.value
    blocks = both.reshape(N_POINTS, n, N_POINTS, n).swapaxes(1, 2)
    blocks = blocks[PAIRS[:, 0], PAIRS[:, 1]]
    if axes is Axes.COMPLEX:
        same, cross = blocks[:, 0, 0].real, blocks[:, 0, 0].imag
        blocks = np.stack(
            [np.stack([same, -cross], -1), np.stack([cross, same], -1)], -2
        )
    np.testing.assert_allclose(found, blocks, atol=1e-12)


def test_only_bundles_that_meet_are_paired():
    rows = BundledRows.of(_of_bundles(Axes.PLANE), 2 * N_EACH)
    held = [
        set(rows.rows.indices[a:b])
        for a, b in zip(rows.rows.indptr[:-1], rows.rows.indptr[1:], strict=True)
    ]
    expected = {
        (max(g, h), min(g, h))
        for one, two in PAIRS
        for g in held[one]
        for h in held[two]
    }
    met = rows.neighbours(PAIRS)
    later = np.repeat(np.arange(N_BUNDLES), np.diff(met.pointer))
    assert set(zip(later.tolist(), met.column.tolist(), strict=True)) == expected


@pytest.mark.parametrize("most", [0, 10**6])  # by a product; in a table
def test_values_are_paired_by_the_bundle_of_each(most, monkeypatch):
    monkeypatch.setattr(bundled_covariance, "NUMBERS_OF_TABLE", most)
    bundle, pairs = np.array([0, 3, 1, 3, 4]), np.array([[0, 1], [2, 0], [3, 1]])
    given = np.ones((5, 1, 2)), bundle, np.arange(6)
    rows = BundledRows(sparse.bsr_array(given, shape=(5, 10)), Axes.COMPLEX)
    met = rows.neighbours(pairs)
    assert met.pointer.tolist() == [0, 0, 1, 1, 3, 3]
    assert met.column.tolist() == [0, 0, 3]


def test_places_of_fewer_pairs():
    every = BundlePairs(np.array([0, 1, 3, 4]), np.array([0, 0, 1, 2]))
    some = BundlePairs(np.array([0, 0, 1, 2]), np.array([1, 2]))
    assert every.places_of(some).tolist() == [2, 3]
    assert every.places_of(every).tolist() == [0, 1, 2, 3]
    assert some.places_of(every) is None
    nothing = BundlePairs(np.zeros(4, dtype=int), np.array([], dtype=int))
    assert every.places_of(nothing).tolist() == []
    assert nothing.places_of(some) is None
