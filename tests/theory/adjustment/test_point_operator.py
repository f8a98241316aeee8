"""Operators on rows of points give the same, whatever stands for a point in them."""

import numpy as np
import pytest
from scipy import sparse

from einschalt.foundations import batches
from einschalt.theory.adjustment import point_operator
from einschalt.theory.adjustment.point_operator import (
    Axes,
    PointOperator,
    by_coordinate,
    on_diagonal,
    selection,
    stacked,
    sums,
    unchanged,
    weighted_mean,
    zero,
)

SHAPES = [(4, 6), (6, 5), (5, 7)]  # points
SIZES = np.array([0.5, 1.0, 2.0, 0.1, 3.0, 1.5, 0.7])


def numbers_of(operator):
    return operator.matrix.toarray()


def random_operator(axes, shapes, seed=1):
    """A product of matrices, some of whose entries are empty."""
    rng = np.random.default_rng(seed)
    factors = []
    for rows, columns in shapes:
        shape = axes.size(rows), axes.size(columns)
        part = rng.normal(size=shape)
        if axes is Axes.COMPLEX:
            part = part + 1j * rng.normal(size=shape)
        factors.append(sparse.csr_array(part * (rng.random(shape) < 0.7)))
    return PointOperator(tuple(factors), axes)


def vectors(axes, n_points, seed=2):
    return np.random.default_rng(seed).normal(size=(n_points, len(axes.names)))


def real_matrix(operator):
    """The matrix on coordinates, from unit errors, column by column."""
    n_coordinates = len(operator.axes.names)
    columns = []
    for k in range(operator.n_sources * n_coordinates):
        unit = np.zeros((operator.n_sources, n_coordinates))
        unit.ravel()[k] = 1.0
        columns.append(operator.of_vectors(unit).ravel())
    return np.column_stack(columns)


@pytest.mark.parametrize("axes", Axes)
def test_packed_vectors_come_back(axes):
    given = vectors(axes, 5)
    packed = axes.packed(given)
    assert packed.shape == (axes.size(5),)
    assert axes.count(len(packed)) == 5
    np.testing.assert_array_equal(axes.unpacked(packed), given)
    draws = np.column_stack([packed, 2.0 * packed])
    np.testing.assert_array_equal(axes.unpacked(draws)[:, :, 1], 2.0 * given)
    np.testing.assert_array_equal(axes.plan(draws)[:, :, 0], given[:, :2])


@pytest.mark.parametrize("axes", Axes)
def test_steps_follow_each_other_as_matrices_do(axes):
    one, two, three = (random_operator(axes, [s], k) for k, s in enumerate(SHAPES))
    chain = one @ two @ three
    assert (chain.n_points, chain.n_sources, len(chain.factors)) == (4, 7, 3)
    dense = numbers_of(one) @ numbers_of(two) @ numbers_of(three)
    np.testing.assert_allclose(numbers_of(chain), dense)
    assert len(chain.formed().factors) == len(chain.tocsr().factors) == 1
    moved = axes.packed(vectors(axes, 7))
    np.testing.assert_allclose(chain.apply(moved), dense @ moved)
    draws = np.column_stack([moved, -moved, 3.0 * moved])
    np.testing.assert_allclose(chain.apply(draws), dense @ draws)
    np.testing.assert_allclose(numbers_of(chain.T), dense.T)
    same = (unchanged(axes) @ chain, chain @ unchanged(axes))
    assert all(part.factors == chain.factors for part in same)


def test_steps_that_do_not_fit_are_refused_before_they_are_multiplied():
    one, two = (random_operator(Axes.PLANE, [shape]) for shape in SHAPES[:2])
    other = random_operator(Axes.SPACE, SHAPES[:1])
    with pytest.raises(ValueError, match=r"\(12, 10\) and \(8, 12\) numbers"):
        two @ one
    with pytest.raises(ValueError, match=r"Axes.PLANE and of Axes.SPACE"):
        one @ other
    with pytest.raises(ValueError, match=r"Axes.SPACE and of Axes.PLANE"):
        other + one


@pytest.mark.parametrize("axes", Axes)
@pytest.mark.parametrize("length", [1, 2, 3])
def test_sums_are_sums_of_the_products(axes, length):
    long = random_operator(axes, SHAPES)
    other = random_operator(axes, [(4, 7), (7, 7), (7, 7)][:length], 5)
    total, dense = long + other, numbers_of(long) + numbers_of(other)
    assert len(total.products) == 2
    np.testing.assert_allclose(numbers_of(total), dense)
    np.testing.assert_allclose(numbers_of(other + long), dense)
    np.testing.assert_allclose(numbers_of(long - other), 2 * numbers_of(long) - dense)


@pytest.mark.parametrize("axes", Axes)
def test_steps_before_and_after_a_sum_are_those_of_every_product(axes):
    """(a + b c) follows d, and is followed by a sum, without a product being formed."""
    before, after = random_operator(axes, [(3, 4)], 4), random_operator(axes, [(6, 5)])
    total = random_operator(axes, [(4, 6)], 5) + random_operator(
        axes, [(4, 2), (2, 6)], 6
    )
    last = after + random_operator(axes, [(6, 2), (2, 5)], 7)
    chain = before @ total @ last
    assert len(chain.products) == 4
    dense = numbers_of(before) @ numbers_of(total) @ numbers_of(last)
    np.testing.assert_allclose(numbers_of(chain), dense)
    given = vectors(axes, 5)
    moved = axes.packed(given)
    np.testing.assert_allclose(chain.apply(moved), dense @ moved)
    np.testing.assert_allclose(numbers_of(chain.T), dense.T)
    np.testing.assert_allclose(numbers_of(-chain), -dense)
    weights = np.random.default_rng(4).normal(size=(2, 3, len(axes.names)))
    expected = np.einsum("snc,nc->s", weights, chain.of_vectors(given))
    found = np.real(chain.of_functionals(weights) @ moved)
    np.testing.assert_allclose(found, expected)
    mean = weighted_mean(np.arange(4), np.ones(4), np.array([0, 1, 4]), 4, axes)
    other = numbers_of(chain.with_last_step(mean))
    rest = numbers_of(total) @ numbers_of(last)
    np.testing.assert_allclose(other, numbers_of(mean) @ rest)


@pytest.mark.parametrize("axes", Axes)
def test_another_last_step_takes_the_place_of_the_first_factor(axes):
    chain = random_operator(axes, SHAPES)
    mean = weighted_mean(np.arange(6), np.ones(6), np.array([0, 2, 6]), 6, axes)
    found = chain.with_last_step(mean)
    assert chain.last_step.n_sources == 6
    rest = PointOperator(chain.factors[1:], axes)
    np.testing.assert_allclose(numbers_of(found), numbers_of(mean @ rest))


@pytest.mark.parametrize("axes", Axes)
def test_covariances_are_those_of_the_real_coordinates(axes):
    chain = random_operator(axes, SHAPES)
    n = len(axes.names)
    real = real_matrix(chain) * np.repeat(SIZES, n)
    whole = (real @ real.T).reshape(4, n, 4, n).swapaxes(1, 2)
    own = chain.formed().covariances(SIZES)
    np.testing.assert_allclose(own, whole[range(4), range(4)], atol=1e-12)
    pairs = np.array([[0, 3], [2, 2], [1, 0]])
    found = chain.covariances_between(pairs, SIZES)
    np.testing.assert_allclose(found, whole[pairs[:, 0], pairs[:, 1]], atol=1e-12)


@pytest.mark.parametrize("axes", Axes)
def test_full_matrices_have_the_covariances_of_sparse_ones(axes, monkeypatch):
    operator = random_operator(axes, SHAPES)
    full = PointOperator((numbers_of(operator),), axes)
    pairs = np.array([[0, 1], [1, 0], [3, 3], [2, 0]])
    monkeypatch.setattr(point_operator, "NUMBERS_IN_CACHE", 30)  # in parts
    assert full.covariances(SIZES) == pytest.approx(operator.covariances(SIZES))
    between = full.covariances_between(pairs, SIZES)
    assert between == pytest.approx(operator.covariances_between(pairs, SIZES))
    assert between[2] == pytest.approx(full.covariances(SIZES)[3])


@pytest.mark.parametrize("axes", [Axes.PLANE, Axes.SPACE])
def test_every_coordinate_may_have_a_size_of_its_own(axes):
    chain = random_operator(axes, SHAPES)
    sizes = np.random.default_rng(3).uniform(0.5, 2.0, (7, axes.size(1)))
    real = real_matrix(chain) * sizes.ravel()
    n = len(axes.names)
    whole = (real @ real.T).reshape(4, n, 4, n).swapaxes(1, 2)
    np.testing.assert_allclose(chain.covariances(sizes), whole[range(4), range(4)])


@pytest.mark.parametrize("axes", Axes)
def test_sums_over_coordinates_go_backwards(axes):
    chain, given = random_operator(axes, SHAPES), vectors(axes, 7)
    weights = np.random.default_rng(4).normal(size=(2, 4, len(axes.names)))
    expected = np.einsum("snc,nc->s", weights, chain.of_vectors(given))
    found = np.real(chain.of_functionals(weights) @ axes.packed(given))
    np.testing.assert_allclose(found, expected)


@pytest.mark.parametrize("axes", Axes)
def test_means_sums_and_selections(axes):
    given = vectors(axes, 5)
    start, rows = np.array([0, 2, 5]), np.array([3, 0, 1, 2, 4])
    weights = np.array([1.0, 3.0, 2.0, 1.0, 1.0])
    mean = weighted_mean(rows, weights, start, 5, axes).of_vectors(given)
    expected = np.average(given[rows[:2]], axis=0, weights=weights[:2])
    np.testing.assert_allclose(mean[0], expected)
    total = sums(weights, rows, start, 5, axes).of_vectors(given)
    np.testing.assert_allclose(total[0], 4.0 * expected)
    picked = selection(rows, 5, axes)
    np.testing.assert_array_equal(picked.of_vectors(given), given[rows])
    np.testing.assert_array_equal(picked.T.of_vectors(given)[rows], given)


@pytest.mark.parametrize("axes", Axes)
def test_parts_beside_and_above_each_other(axes):
    one, other = selection([1, 0], 2, axes), selection([2, 0], 3, axes)
    whole = stacked([[one, other], [zero(1, 2, axes), zero(1, 3, axes)]])
    given = vectors(axes, 5)
    found = whole.of_vectors(given)
    np.testing.assert_allclose(found[:2], given[[1, 0]] + given[[4, 2]])
    np.testing.assert_array_equal(found[2], 0.0)


@pytest.mark.parametrize("axes", Axes)
def test_small_matrices_of_points(axes):
    chain = random_operator(axes, SHAPES[:2]).formed()
    blocks = chain.blocks_at(np.array([0, 3]), np.array([4, 1]))
    n = axes.size(1)
    np.testing.assert_array_equal(blocks[1], numbers_of(chain)[3 * n :, n : 2 * n])
    kept = sparse.csr_array(([1.0], ([3], [1])), shape=(4, 5))
    masked = chain.masked(kept)
    np.testing.assert_array_equal(masked.used_sources, [1])
    found = masked.blocks_at(np.array([3]), np.array([1]))
    np.testing.assert_array_equal(found[0], blocks[1])
    assert masked.depends_on(np.array([1, 2])).tolist() == [False, False, False, True]
    assert not masked.depends_on(np.array([0, 2])).any()
    diagonal = numbers_of(on_diagonal(blocks))
    np.testing.assert_array_equal(diagonal[n:, n:], blocks[1])
    np.testing.assert_array_equal(diagonal[:n, n:], 0.0)


@pytest.mark.parametrize("axes", Axes)
def test_a_shift_of_all_points_goes_through_the_sums_of_the_rows(axes):
    chain = random_operator(axes, SHAPES[:2]).formed()
    shift = vectors(axes, 1)
    found = chain.row_sums().of_vectors(np.repeat(shift, 4, axis=0))
    np.testing.assert_allclose(found, chain.of_vectors(np.repeat(shift, 5, axis=0)))


def test_what_is_no_number_becomes_nothing():
    bad = PointOperator((sparse.csr_array([[np.nan, 1.0]]),), Axes.COMPLEX)
    np.testing.assert_array_equal(numbers_of(bad.finite()), [[0.0, 1.0]])


def test_heights_may_stay_as_they_are():
    weights = sparse.csr_array([[0.5, 0.5]])
    given = vectors(Axes.SPACE, 2)
    whole = by_coordinate(weights, Axes.SPACE).of_vectors(given)
    in_plan = by_coordinate(weights, Axes.SPACE, is_plan_only=True).of_vectors(given)
    np.testing.assert_allclose(whole[0], given.mean(axis=0))
    np.testing.assert_allclose(in_plan[0], [*given[:, :2].mean(axis=0), 0.0])


@pytest.mark.parametrize("axes", [Axes.PLANE, Axes.SPACE])
def test_values_may_have_matrices_for_their_shares(axes):
    rng = np.random.default_rng(6)
    shares = rng.normal(size=(5, axes.value, axes.value))
    vectors = rng.normal(size=(7, axes.value))
    columns, start = np.array([6, 0, 3, 2, 2]), np.array([0, 2, 5])
    found = sums(shares, columns, start, 7, axes).of_vectors(vectors)
    each = np.einsum("nab,nb->na", shares, vectors[columns])
    np.testing.assert_allclose(found, [each[:2].sum(axis=0), each[2:].sum(axis=0)])


def test_complex_operators_take_shares_that_turn_and_scale():
    rng = np.random.default_rng(7)
    a, b = rng.normal(size=(2, 4))
    shares = np.stack([np.stack([a, -b], -1), np.stack([b, a], -1)], -2)
    vectors = rng.normal(size=(4, 2))
    arguments = (shares, np.arange(4), np.array([0, 1, 4]), 4)
    plane, packed = (
        sums(*arguments, axes).of_vectors(vectors)
        for axes in (Axes.PLANE, Axes.COMPLEX)
    )
    np.testing.assert_allclose(packed, plane, atol=1e-12)


@pytest.mark.parametrize("kind", [float, complex])
def test_rows_are_multiplied_on_any_number_of_cores(monkeypatch, kind):
    rng = np.random.default_rng(3)
    dense = rng.normal(size=(37, 20)) * (rng.random((37, 20)) < 0.3)
    dense[5:9] = 0.0  # rows without an entry
    columns = rng.normal(size=(20, 6)).astype(kind)
    operator = PointOperator((sparse.csr_array(dense),), Axes.COMPLEX)
    whole = operator.apply(columns)
    monkeypatch.setattr(batches, "ROWS_WORTH_A_THREAD", 1)
    for n_cores in (1, 2, 7):
        monkeypatch.setattr(batches, "n_cores", lambda n=n_cores: n)
        np.testing.assert_array_equal(operator.apply(columns), whole)
    np.testing.assert_allclose(whole, dense @ columns, atol=1e-12)
    nothing = PointOperator((sparse.csr_array((37, 20)),), Axes.COMPLEX)
    assert not nothing.apply(columns).any()


def test_complex_operators_stay_real_where_nothing_turns():
    shares = np.array([0.3, 0.7])[:, None, None] * np.eye(2)
    blocks = Axes.COMPLEX.blocks_of(shares)
    assert not np.iscomplexobj(blocks)
    np.testing.assert_array_equal(blocks[:, 0, 0], [0.3, 0.7])
    shares[1] += [[0.0, -1e-12], [1e-12, 0.0]]
    np.testing.assert_array_equal(
        Axes.COMPLEX.blocks_of(shares)[:, 0, 0], [0.3, 0.7 + 1e-12j]
    )
