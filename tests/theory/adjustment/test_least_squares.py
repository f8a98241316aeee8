import numpy as np
import pytest

from einschalt.theory.adjustment.least_squares import (
    pool_standard_errors,
    pooled_standard_error,
    standard_error_of_unit_weight,
    total_from_coordinate,
)


def test_root_of_sum_of_squares_over_redundancy():
    found = standard_error_of_unit_weight(np.array([8.0, 0.0]), np.array([2, 5]))
    np.testing.assert_array_equal(found, [2.0, 0.0])


@pytest.mark.parametrize("sum_of_squares", [0.0, 1e-30, 4.0, np.nan])
def test_nothing_redundant_nothing_known(sum_of_squares):
    # never 0: that would claim perfection where nothing was checked
    found = standard_error_of_unit_weight(np.array([sum_of_squares]), np.array([0]))
    assert np.isnan(found).all()


def test_pooled_over_models_weighs_by_redundancy():
    found = pooled_standard_error(np.array([2.0, 30.0]), np.array([2, 6]))
    assert found == pytest.approx(2.0)


def test_pooled_passes_over_models_without_redundancy():
    sums = np.array([8.0, np.nan, 1e-25])
    assert pooled_standard_error(sums, np.array([2, 0, 0])) == pytest.approx(2.0)
    assert np.isnan(pooled_standard_error(sums[1:], np.array([0, 0])))


def test_standard_errors_are_pooled_as_their_sums_of_squares():
    sums, redundancy = np.array([2.0, 30.0, 0.3, 5.0]), np.array([2, 6, 1, 0])
    of_models = standard_error_of_unit_weight(sums, redundancy)
    expected = pooled_standard_error(sums[:3], redundancy[:3])
    assert pool_standard_errors(of_models, redundancy) == pytest.approx(expected)
    # what is not known takes no part, whatever redundancy it is said to have
    unknown = np.append(of_models, np.nan), np.append(redundancy, 4)
    assert pool_standard_errors(*unknown) == pytest.approx(expected)


def test_pooled_standard_errors_of_normal_samples_are_unbiased_in_the_square():
    rng = np.random.default_rng(5)
    sizes = rng.integers(2, 9, 4000)
    errors = [rng.normal(0.0, 3.0, size).std(ddof=1) for size in sizes]
    pooled = pool_standard_errors(errors, sizes - 1)
    # four standard errors of an s² from that many degrees of freedom
    assert pooled**2 == pytest.approx(9.0, rel=4.0 * np.sqrt(2.0 / np.sum(sizes - 1)))


def test_nothing_known_nothing_pooled():
    assert np.isnan(pool_standard_errors([], []))
    assert np.isnan(pool_standard_errors([np.nan, 1.0], [3, 0]))


def test_total_is_root_two_of_a_coordinate():
    errors = np.array([0.05, np.nan])
    np.testing.assert_allclose(total_from_coordinate(errors), np.hypot(errors, errors))
