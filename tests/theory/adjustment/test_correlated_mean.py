"""Means of correlated values: against least squares, and against what draws say."""

from itertools import pairwise

import numpy as np
import pytest
from tests.theory.adjustment.best_shares import best_shares

from einschalt.theory.adjustment import correlated_mean
from einschalt.theory.adjustment.correlated_mean import (
    JointCovariance,
    pairs_of_values,
    squared_sizes,
    times,
)


def random_covariance(rng, n_values, d, n_shared=2):
    """Values with errors of their own, of different sizes, and errors they share."""
    own = rng.uniform(0.02, 0.3, n_values)
    rows = np.zeros((n_values * d, n_values * d + n_shared))
    rows[:, : n_values * d] = np.diag(np.repeat(own, d))
    rows[:, n_values * d :] = rng.normal(0.0, 0.1, (n_values * d, n_shared))
    rows[:, : n_values * d] += 0.02 * rng.normal(size=(n_values * d, n_values * d))
    return rows @ rows.T


def as_blocks(matrix, k):
    d = len(matrix) // k
    return matrix.reshape(k, d, k, d).transpose(0, 2, 1, 3)


def as_rows(shares):
    """Shares of one point beside each other, shape (d, k d)."""
    k, d, _ = shares.shape
    return shares.transpose(1, 0, 2).reshape(d, k * d)


def by_least_squares(matrix, d):
    """Observations of one vector, made independent of each other."""
    n = len(matrix)
    whiten = np.linalg.inv(np.linalg.cholesky(matrix))
    design = np.tile(np.eye(d), (n // d, 1))
    return np.linalg.lstsq(whiten @ design, whiten, rcond=None)[0]


@pytest.mark.parametrize("d", [1, 2, 3])
@pytest.mark.parametrize("k", [1, 2, 5, 9])
def test_shares_are_those_of_least_squares(k, d):
    rng = np.random.default_rng(10 * k + d)
    matrices = [random_covariance(rng, k, d) for _ in range(7)]
    found = best_shares(np.array([as_blocks(m, k) for m in matrices]))
    for shares, matrix in zip(found, matrices, strict=True):
        expected = by_least_squares(matrix, d)
        np.testing.assert_allclose(as_rows(shares), expected, atol=1e-6)


def test_means_have_the_variance_that_is_claimed_and_less_than_plain_ones():
    rng = np.random.default_rng(5)
    k, d, n_draws = 4, 2, 40_000
    matrix = random_covariance(rng, k, d)
    shares = as_rows(best_shares(as_blocks(matrix, k)[None])[0])
    drawn = rng.multivariate_normal(np.zeros(k * d), matrix, n_draws)
    scatter = np.cov((drawn @ shares.T).T)
    claimed = shares @ matrix @ shares.T
    np.testing.assert_allclose(scatter, claimed, atol=0.03 * np.trace(claimed))
    plain = np.cov(drawn.reshape(n_draws, k, d).mean(axis=1).T)
    assert np.trace(scatter) < 0.9 * np.trace(plain)


@pytest.mark.parametrize("seed", range(20))
def test_no_other_shares_give_less_variance(seed):
    rng = np.random.default_rng(seed)
    k, d = int(rng.integers(2, 7)), int(rng.integers(1, 4))
    matrix = random_covariance(rng, k, d)
    best = as_rows(best_shares(as_blocks(matrix, k)[None])[0])
    smallest = np.trace(best @ matrix @ best.T)
    every = np.tile(np.eye(d), (k, 1))
    even, change = every.T / k, rng.normal(size=(d, k * d))
    for other in (even, best + 0.1 * (change - change @ every @ even)):
        np.testing.assert_allclose(other @ every, np.eye(d), atol=1e-12)
        assert smallest <= np.trace(other @ matrix @ other.T) * (1.0 + 1e-9)


def shared_by_all(k, d):
    return as_blocks(np.tile(np.eye(d), (k, k)), k)


def shared_by_two():
    rows = np.array([[0.1, 0.0], [0.1, 0.0], [0.0, 0.1]])
    return as_blocks(np.kron(rows @ rows.T, np.eye(2)), 3)


@pytest.mark.parametrize(
    ("blocks", "expected"),
    [
        (shared_by_all(3, 2), [1 / 3, 1 / 3, 1 / 3]),
        (0.0 * shared_by_all(3, 2), [1 / 3, 1 / 3, 1 / 3]),
        (shared_by_two(), [0.25, 0.25, 0.5]),
    ],
    ids=["all errors shared", "no errors", "two values with the same errors"],
)
def test_values_with_the_same_errors_have_the_same_shares(blocks, expected):
    found = best_shares(blocks[None])[0]
    # last digits of the covariance, over the least variance that tells anything
    wanted = np.multiply.outer(expected, np.eye(2))
    np.testing.assert_allclose(found, wanted, atol=1e-6)


def test_a_badly_determined_value_hardly_counts():
    size = np.array([0.1, 0.1, 25.0])
    found = best_shares(as_blocks(np.kron(np.diag(size**2), np.eye(3)), 3)[None])[0]
    np.testing.assert_allclose(found[2], 8e-6 * np.eye(3), atol=1e-6)
    np.testing.assert_allclose(found.sum(axis=0), np.eye(3), atol=1e-12)


def test_values_without_a_variance_count_where_there_are_no_others():
    blocks = as_blocks(np.kron(np.diag([0.01, 0.04, 1.0]), np.eye(2)), 3)
    blocks[1, :] = blocks[:, 1] = np.nan
    some, none = best_shares(np.array([blocks, np.full_like(blocks, np.nan)]))
    np.testing.assert_allclose(some[1], 0.0, atol=1e-5)
    np.testing.assert_allclose(some[0], 100 / 101 * np.eye(2), atol=1e-5)
    np.testing.assert_allclose(none, np.tile(np.eye(2) / 3, (3, 1, 1)), atol=1e-9)


def test_the_mean_does_not_depend_on_the_direction_of_the_axes():
    rng = np.random.default_rng(2)
    matrix = random_covariance(rng, 4, 2)
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s], [s, c]])
    each = np.kron(np.eye(4), turn)
    before = best_shares(as_blocks(matrix, 4)[None])[0]
    after = best_shares(as_blocks(each @ matrix @ each.T, 4)[None])[0]
    np.testing.assert_allclose(after, turn @ before @ turn.T, atol=1e-9)


def joint_of(rng, start, d):
    """Blocks of all pairs of values, and the whole matrix of each point."""
    matrices = [random_covariance(rng, k, d) for k in np.diff(start)]
    blocks = []
    for later, earlier in pairs_of_values(start):
        point = np.searchsorted(start, later, side="right") - 1
        i, j = later - start[point], earlier - start[point]
        blocks.append(matrices[point][d * i : d * i + d, d * j : d * j + d])
    return JointCovariance(np.array(blocks), start), matrices


def test_points_of_any_number_of_values_have_their_own_shares():
    start, d = np.array([0, 3, 4, 9, 12, 14]), 2
    joint, matrices = joint_of(np.random.default_rng(4), start, d)
    found = joint.shares(np.arange(start[-1]), start)
    for point, matrix in enumerate(matrices):
        own = found[start[point] : start[point + 1]]
        expected = by_least_squares(matrix, d)
        np.testing.assert_allclose(as_rows(own), expected, atol=1e-6)


def test_groups_within_points_are_weighted_by_their_part_of_the_covariance():
    start, d = np.array([0, 3, 7]), 3
    joint, matrices = joint_of(np.random.default_rng(8), start, d)
    order, groups = np.array([2, 0, 1, 5, 3, 6, 4]), np.array([0, 2, 3, 6, 7])
    found = joint.shares(order, groups)
    for first, last in pairwise(groups):
        point = int(order[first] >= 3)
        places = order[first:last] - start[point]
        rows = (d * places[:, None] + np.arange(d)).ravel()
        part = matrices[point][np.ix_(rows, rows)]
        expected = by_least_squares(part, d)
        np.testing.assert_allclose(as_rows(found[first:last]), expected, atol=1e-6)


def test_numbers_and_matrices_multiply_alike():
    rng = np.random.default_rng(1)
    numbers, vectors = rng.normal(size=5), rng.normal(size=(5, 3))
    matrices = numbers[:, None, None] * np.eye(3)
    np.testing.assert_allclose(times(matrices, vectors), times(numbers, vectors))
    np.testing.assert_allclose(squared_sizes(matrices), squared_sizes(numbers))


def test_groups_without_values_have_no_shares():
    joint, _ = joint_of(np.random.default_rng(6), np.array([0, 2]), 2)
    some = joint.shares([0, 1], [0, 0, 2, 2])
    np.testing.assert_array_equal(some, joint.shares([0, 1], [0, 2]))


@pytest.mark.parametrize("k", [2, 3, 7])
def test_what_is_alike_in_all_coordinates_has_the_shares_of_one_of_them(k):
    single = random_covariance(np.random.default_rng(k), k, 1)
    alike = as_blocks(np.kron(single, np.eye(2)), k)[None]
    of_one = best_shares(as_blocks(single, k)[None])
    np.testing.assert_array_equal(best_shares(alike), of_one * np.eye(2))
    # as long as nothing tells the coordinates apart: these are found the long way
    apart = alike * np.array([[1.0, 0.0], [0.0, 1.0 + 1e-9]])
    np.testing.assert_allclose(best_shares(apart), best_shares(alike), atol=1e-8)


@pytest.mark.parametrize("is_unknown", [False, True])  # then by pairs of numbers
@pytest.mark.parametrize("k", [2, 5])
def test_what_turns_and_scales_has_the_shares_of_complex_numbers(
    k, is_unknown, monkeypatch
):
    """Shares of both coordinates as one number are those of the pairs of them."""
    rng = np.random.default_rng(3)
    of_errors = rng.normal(size=(7, k, 2 * k)) + 1j * rng.normal(size=(7, k, 2 * k))
    of_errors[0, 1] = of_errors[0, 0]  # the same errors
    joint = of_errors @ of_errors.conj().swapaxes(1, 2)
    if is_unknown:
        joint[1, 0] = joint[1, :, 0] = np.nan
    real, imag = joint.real, joint.imag
    rows = np.stack([real, -imag], -1), np.stack([imag, real], -1)
    covariance = np.stack(rows, -2)
    later, earlier = np.tril_indices(k)
    found = correlated_mean._of_one_number(
        covariance[:, later, earlier].reshape(-1, 2, 2)
    )
    assert np.iscomplexobj(found) != is_unknown
    shares = best_shares(covariance)
    monkeypatch.setattr(correlated_mean, "_of_one_number", lambda blocks: blocks)
    np.testing.assert_allclose(shares, best_shares(covariance), atol=1e-9)
    assert abs(shares[..., 0, 1]).max() > 0.01  # they turn
