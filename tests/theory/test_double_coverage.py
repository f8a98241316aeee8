import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from einschalt.theory.double_coverage import (
    internal_standard_error,
    mean_of_values,
    most_central_rows,
    position_in_extent,
)

examples = settings(max_examples=30, deadline=None, derandomize=True)


def values_of(seed, counts, noise=0.1):
    """Values of several points about random places of 5·10⁶ m."""
    rng = np.random.default_rng(seed)
    places = np.array([4.5e6, 5.3e6]) + rng.uniform(-1e4, 1e4, (len(counts), 2))
    coordinates = np.repeat(places, counts, axis=0)
    coordinates += rng.normal(0.0, noise, coordinates.shape)
    start = np.concatenate([[0], np.cumsum(counts)])
    return coordinates, rng.uniform(0.02, 0.2, len(coordinates)), start


# position in the model


def test_position_by_hand():
    xy = np.array([[0.0, 0], [10, 0], [10, 4], [5, 2], [7, 7], [9, 7]])
    found = position_in_extent(xy, np.array([0, 4, 4, 6]))
    wanted = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [0, 0], [-0.5, 0], [0.5, 0]]
    np.testing.assert_allclose(found, wanted, atol=1e-15)


def test_position_of_a_single_point_is_the_middle():
    found = position_in_extent(np.array([[3.0, 4.0]]), np.array([0, 1]))
    np.testing.assert_array_equal(found, [[0.0, 0.0]])


@examples
@given(seed=st.integers(0, 2**32 - 1), shift=st.floats(-1e5, 1e5))
def test_position_does_not_depend_on_the_frame(seed, shift):
    xy = np.random.default_rng(seed).uniform(-100, 100, (9, 2))
    start = np.array([0, 9])
    found = position_in_extent(xy, start)
    moved = position_in_extent(3.0 * xy + shift, start)
    np.testing.assert_allclose(moved, found, rtol=0, atol=1e-9)
    assert np.abs(found).max() == pytest.approx(0.5)


# the most central row


def test_most_central_row_per_point_and_coverage():
    point = np.array([0, 0, 0, 1, 0, 1])
    coverage = np.array([0, 0, 1, 0, 1, 1])
    position = np.array(
        [[0.3, 0.0], [0.1, -0.2], [0.4, 0.4], [0.5, 0.5], [0.4, -0.39], [0, 0]]
    )
    # of rows 2 and 4 the larger of |u| and |v| is 0.4 both times: the first model
    found = most_central_rows(point, coverage, position, np.arange(6))
    assert found.tolist() == [1, 2, 3, 5]


def test_equally_central_rows_are_told_by_their_models_and_not_by_their_order():
    point, position = np.zeros(4, dtype=int), np.full((4, 2), 0.4)
    position[3] = 0.1, 0.45
    model = np.array([7, 3, 4, 0])
    rng = np.random.default_rng(1)
    for order in (rng.permutation(4) for _ in range(10)):
        found = most_central_rows(point, point, position[order], model[order])
        assert model[order][found].tolist() == [3]


def test_most_central_rows_of_one_row():
    one = np.zeros(1, dtype=int)
    assert most_central_rows(one, one, np.zeros((1, 2)), one).tolist() == [0]


# means


def test_mean_by_hand():
    coordinates = np.array([[10.0, 20.0], [10.2, 20.0], [5.0, 5.0]])
    error = np.array([0.03, 0.04, 0.05])
    found = mean_of_values(coordinates, error, np.ones(3), np.array([0, 2, 3]))
    np.testing.assert_allclose(found.mean, [[10.1, 20.0], [5.0, 5.0]], rtol=1e-15)
    # √(0.03² + 0.04²) / 2, and the value's own where there is one
    np.testing.assert_allclose(found.standard_error, [0.025, 0.05])
    assert found.n_values.tolist() == [2, 1]
    # |d| / √2; one value has no spread
    np.testing.assert_allclose(found.spread_total, [0.2 / np.sqrt(2.0), np.nan])


def test_weights_of_the_inverse_variance_are_the_best():
    coordinates, error, start = values_of(1, [5, 2, 9])
    best = mean_of_values(coordinates, error, error**-2.0, start)
    plain = mean_of_values(coordinates, error, np.ones(16), start)
    assert (best.standard_error <= plain.standard_error + 1e-15).all()
    wanted = np.add.reduceat(error**-2.0, start[:-1]) ** -0.5
    np.testing.assert_allclose(best.standard_error, wanted, rtol=1e-12)
    weights = np.column_stack([error**-2.0] * 2)
    for point in range(3):
        rows = slice(start[point], start[point + 1])
        mean = np.average(coordinates[rows], axis=0, weights=weights[rows])
        np.testing.assert_allclose(best.mean[point], mean, rtol=0, atol=2e-9)


@examples
@given(seed=st.integers(0, 2**32 - 1), factor=st.floats(0.01, 100.0))
def test_unit_of_the_weights_is_irrelevant(seed, factor):
    coordinates, error, start = values_of(seed, [3, 1, 4])
    weights = error**-2.0
    one = mean_of_values(coordinates, error, weights, start)
    other = mean_of_values(coordinates, error, factor * weights, start)
    np.testing.assert_allclose(other.mean, one.mean, rtol=0, atol=2e-9)
    np.testing.assert_allclose(other.standard_error, one.standard_error, rtol=1e-12)


@examples
@given(seed=st.integers(0, 2**32 - 1))
def test_order_of_values_is_irrelevant(seed):
    coordinates, error, start = values_of(seed, [6])
    order = np.random.default_rng(seed).permutation(6)
    one = mean_of_values(coordinates, error, np.ones(6), start)
    other = mean_of_values(coordinates[order], error[order], np.ones(6), start)
    np.testing.assert_allclose(other.mean, one.mean, rtol=0, atol=2e-9)
    np.testing.assert_allclose(other.spread_total, one.spread_total, rtol=1e-6)


def test_heights_are_averaged_but_have_no_part_in_the_plan():
    coordinates = np.array([[0.0, 0.0, 100.0], [0.0, 0.1, 102.0]])
    found = mean_of_values(coordinates, np.ones(2), np.ones(2), np.array([0, 2]))
    np.testing.assert_allclose(found.mean, [[0.0, 0.05, 101.0]], rtol=1e-15)
    np.testing.assert_allclose(found.spread_total, 0.1 / np.sqrt(2.0))


def test_sums_keep_their_digits():
    # weights as large as 1/M² of millimetres, coordinates of 5·10⁶ m
    coordinates = np.array([[4512345.678, 5312345.678]] * 7)
    weights = np.linspace(1e4, 1e6, 7)
    found = mean_of_values(coordinates, np.ones(7), weights, np.array([0, 7]))
    np.testing.assert_array_equal(found.mean, coordinates[:1])
    assert found.spread_total[0] == 0.0


# the differences of the coverages


def test_internal_error_by_hand():
    # differences 0.06 and 0.08: √((0.06² + 0.08²) / (2 · 2)) = 0.05
    coordinates = np.array([[0.0, 0], [0.06, 0], [5, 5], [5, 5.08], [9, 9]])
    found = internal_standard_error(coordinates, np.array([0, 2, 4, 5]))
    assert found == pytest.approx(0.05)


def test_internal_error_of_three_coverages():
    # three values of one point: Σ|x − mean|² / 2
    coordinates = np.array([[0.0, 0.0], [0.3, 0.0], [0.0, 0.3]])
    found = internal_standard_error(coordinates, np.array([0, 3]))
    assert found == pytest.approx(np.sqrt(0.12 / 2))


def test_internal_error_of_one_coverage_is_unknown():
    found = internal_standard_error(np.zeros((3, 2)), np.array([0, 1, 2, 3]))
    assert np.isnan(found)


def test_internal_error_is_the_error_of_a_value_where_nothing_is_shared():
    n = 4000
    coordinates, _, start = values_of(7, np.full(n, 2), noise=0.05)
    found = internal_standard_error(coordinates, start)
    # total = √2 · 0.05; relative standard deviation 1 / √(2 · 2 n)
    assert abs(found / (0.05 * np.sqrt(2.0)) - 1.0) < 4.0 / np.sqrt(4.0 * n)


def test_internal_error_does_not_see_what_the_coverages_share():
    coordinates, _, start = values_of(8, np.full(50, 2), noise=0.05)
    shared = np.repeat(np.random.default_rng(8).normal(0, 0.5, (50, 2)), 2, axis=0)
    before = internal_standard_error(coordinates, start)
    after = internal_standard_error(coordinates + shared, start)
    assert after == pytest.approx(before, rel=1e-6)
