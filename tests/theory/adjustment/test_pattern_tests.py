"""Patterns in correlated errors: estimates, probabilities, and what nothing tells."""

import numpy as np
import pytest
import statsmodels.api as sm
from scipy.stats import binom, f, kstest

from einschalt.theory.adjustment.pattern_tests import (
    estimate_scores_together,
    estimate_together,
    examine_patterns,
    examine_scores,
    nested_p_value,
)

N = 14


@pytest.fixture(scope="module")
def covariance():
    root = np.random.default_rng(3).normal(size=(N, N))
    return root @ root.T + 0.5 * np.eye(N)


@pytest.fixture(scope="module")
def signatures():
    return np.random.default_rng(4).normal(size=(3, N, 2))


def test_estimates_and_tests_are_those_of_generalized_least_squares(
    covariance, signatures
):
    observed = np.random.default_rng(5).normal(size=N) + 2.0 * signatures[1, :, 0]
    found = examine_patterns(observed, covariance, signatures)
    for place, signature in enumerate(signatures):
        other = sm.GLS(observed, signature, sigma=covariance).fit()
        np.testing.assert_allclose(found.amplitudes[place], other.params)
        whole = other.wresid @ other.wresid
        nothing = observed @ np.linalg.solve(covariance, observed)
        assert found.squares[place] == pytest.approx(nothing - whole)
        ratio = (nothing - whole) / 2.0 / (whole / (N - 2))
        assert found.p_values_if_scaled[place] == pytest.approx(f.sf(ratio, 2, N - 2))
    assert found.worst == 1


def test_probabilities_are_uniform_where_there_is_no_pattern(covariance, signatures):
    drawn = np.random.default_rng(6).multivariate_normal(np.zeros(N), covariance, 2000)
    tests = [examine_patterns(row, covariance, signatures[:1]) for row in drawn]
    for name in ("p_values", "p_values_if_scaled"):
        values = np.array([getattr(test, name)[0] for test in tests])
        assert kstest(values, "uniform").pvalue > 0.001


def test_what_is_free_is_estimated_with_each_pattern(covariance, signatures):
    free = np.random.default_rng(10).normal(size=(N, 2))
    observed = np.random.default_rng(11).normal(size=N) + free @ [50.0, -80.0]
    found = examine_patterns(observed, covariance, signatures, free)
    without = sm.GLS(observed, free, sigma=covariance).fit()
    for place, signature in enumerate(signatures):
        other = sm.GLS(observed, np.hstack([signature, free]), sigma=covariance).fit()
        np.testing.assert_allclose(found.amplitudes[place], other.params[:2], rtol=1e-6)
        expected = without.wresid @ without.wresid - other.wresid @ other.wresid
        assert found.squares[place] == pytest.approx(expected)
        p_value = other.compare_f_test(without)[1]
        assert found.p_values_if_scaled[place] == pytest.approx(p_value)


def test_patterns_together_are_those_of_generalized_least_squares(
    covariance, signatures
):
    free = np.random.default_rng(14).normal(size=(N, 1))
    observed = np.random.default_rng(15).normal(size=N) + 30.0 * free[:, 0]
    found = estimate_together(observed, covariance, signatures, free)
    columns = np.hstack([*signatures, free])
    other = sm.GLS(observed, columns, sigma=covariance).fit()
    np.testing.assert_allclose(found.ravel(), other.params[:-1], rtol=1e-6)


def test_scores_give_patterns_together_as_the_errors_do(covariance):
    errors = np.random.default_rng(16).normal(size=(N, 2))
    patterns = np.random.default_rng(17).normal(size=(3, N))
    weight = np.linalg.inv(covariance)
    found = estimate_scores_together(weight @ errors, weight, patterns, [4])
    columns = np.vstack([patterns, np.eye(N)[4]]).T
    for axis in range(2):
        other = sm.GLS(errors[:, axis], columns, sigma=covariance).fit()
        np.testing.assert_allclose(found[:, axis], other.params[:-1], rtol=1e-6)


def test_points_that_are_free_do_not_count_in_scores(covariance):
    """As the same errors without these points, whatever they are."""
    errors = np.random.default_rng(12).normal(size=(N, 2))
    patterns = np.random.default_rng(13).normal(size=(2, N))
    free, others = [2, 7], np.delete(np.arange(N), [2, 7])
    weight = np.linalg.inv(covariance)
    found = examine_scores(weight @ errors, weight, patterns, free)
    cofactors = np.linalg.inv(covariance[np.ix_(others, others)])
    expected = examine_scores(
        cofactors @ errors[others], cofactors, patterns[:, others]
    )
    np.testing.assert_allclose(found.amplitudes, expected.amplitudes)
    np.testing.assert_allclose(found.p_values, expected.p_values)
    np.testing.assert_allclose(found.p_values_if_scaled, expected.p_values_if_scaled)


def test_a_common_factor_is_no_pattern(covariance, signatures):
    drawn = np.random.default_rng(7).multivariate_normal(np.zeros(N), covariance, 1000)
    tests = [examine_patterns(9.0 * row, covariance, signatures[:1]) for row in drawn]
    assert np.mean([test.p_values[0] < 0.01 for test in tests]) > 0.9
    n_refused = sum(test.p_values_if_scaled[0] < 0.01 for test in tests)
    assert n_refused <= binom.isf(0.001, len(tests), 0.01)


def test_scores_give_what_the_errors_themselves_give(covariance):
    """The scores are C⁻¹ e, and the information is C⁻¹."""
    errors = np.random.default_rng(8).normal(size=(N, 2))
    patterns = np.random.default_rng(9).normal(size=(2, N))
    weight = np.linalg.inv(covariance)
    of_scores = examine_scores(weight @ errors, weight, patterns)
    for axis in (0, 1):
        of_errors = examine_patterns(errors[:, axis], covariance, patterns[:, :, None])
        np.testing.assert_allclose(
            of_scores.amplitudes[:, axis], of_errors.amplitudes[:, 0]
        )
    both = examine_patterns(
        errors.T.ravel(),
        np.kron(np.eye(2), covariance),
        np.stack([np.kron(np.eye(2), row[:, None]) for row in patterns]),
    )
    np.testing.assert_allclose(of_scores.squares, both.squares)
    np.testing.assert_allclose(of_scores.p_values_if_scaled, both.p_values_if_scaled)


def test_a_pattern_that_nothing_shows_is_not_tested(covariance, signatures):
    unseen = np.concatenate([signatures, np.zeros((1, N, 2))])
    found = examine_patterns(np.ones(N), covariance, unseen)
    assert np.isnan(found.squares[-1])
    assert np.isfinite(found.squares[:-1]).all()
    centring = np.eye(N) - 1.0 / N
    shift = examine_scores(centring @ np.ones((N, 2)), centring, np.ones((1, N)))
    assert shift.worst is None


def test_whether_points_move_together_is_the_f_test_of_nested_models():
    observed = np.array([0.1, -0.3, 0.2, 2.6, 1.9, 0.4, -0.2, 1.1])
    step = np.array([0, 0, 0, 1, 1, 0, 0, 1.0])
    alone = np.eye(8)[:, step != 0.0]
    tests = examine_patterns(observed, np.eye(8), step[None, :, None])
    freed = examine_patterns(observed, np.eye(8), step[None, :, None], alone)
    nested, whole = (sm.OLS(observed, x).fit() for x in (step, alone))
    expected = whole.compare_f_test(nested)[1]
    assert nested_p_value(tests, 0, freed) == pytest.approx(expected, rel=1e-9)
    same = examine_patterns(observed, np.eye(8), step[None, :, None], step[:, None])
    assert np.isnan(nested_p_value(tests, 0, same))
