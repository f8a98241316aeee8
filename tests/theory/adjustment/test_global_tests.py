"""RMS errors and means against scipy.stats, and how often chance alone rejects them."""

import numpy as np
import pytest
from scipy import stats
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.weightstats import DescrStatsW

from einschalt.theory.adjustment.global_tests import (
    mean_p_values,
    ratio_limits,
    ratio_p_value,
)
from einschalt.theory.adjustment.multiple_testing import any_significant

LEVEL = 0.001


@pytest.mark.parametrize("degrees", [1, 2, 12, 500, 40_000])
def test_limits_of_ratios_are_quantiles_of_chi_square(degrees):
    lower, upper = ratio_limits(degrees, LEVEL)
    assert lower == pytest.approx(np.sqrt(stats.chi2.ppf(LEVEL, degrees) / degrees))
    assert upper == pytest.approx(np.sqrt(stats.chi2.isf(LEVEL, degrees) / degrees))


def test_limits_for_many_sets_at_once_and_none_without_degrees():
    lower, upper = ratio_limits([0, 4, 100], LEVEL)
    assert np.isnan([lower[0], upper[0]]).all()
    for place, degrees in ((1, 4), (2, 100)):
        assert (lower[place], upper[place]) == ratio_limits(degrees, LEVEL)


def test_least_ratio_widens_limits_that_are_too_narrow_to_matter():
    assert ratio_limits(1e6, LEVEL, 1.25) == (0.8, 1.25)
    assert ratio_limits(4, LEVEL, 1.25) == ratio_limits(4, LEVEL)
    assert np.isnan(ratio_limits(0, LEVEL, 1.25)).all()


@pytest.mark.parametrize("degrees", [1, 8, 300])
def test_probability_of_a_ratio_at_its_limit_is_the_significance(degrees):
    lower, upper = ratio_limits(degrees, LEVEL)
    assert ratio_p_value(upper, degrees) == pytest.approx(LEVEL)
    assert ratio_p_value(lower, degrees) == pytest.approx(1.0 - LEVEL)
    expected = stats.chi2.sf(degrees * 1.1**2, degrees)
    assert ratio_p_value(1.1, degrees) == pytest.approx(expected)
    assert np.isnan(ratio_p_value(1.1, 0))


def mean_differs_from_zero(values, level):
    """Whether the mean in any axis is farther from zero than chance explains."""
    return any_significant(mean_p_values(values), level)


@pytest.mark.parametrize("n", [2, 3, 15, 400])
def test_means_are_tested_as_scipy_and_statsmodels_do(n):
    values = np.random.default_rng(n).normal(0.3, 1.0, (n, 2))
    found = mean_p_values(values)
    np.testing.assert_allclose(found, stats.ttest_1samp(values, 0.0).pvalue, rtol=1e-9)
    theirs = DescrStatsW(values).ttest_mean(0.0)[1]
    np.testing.assert_allclose(found, theirs, rtol=1e-9)
    is_rejected = multipletests(theirs, alpha=0.05, method="bonferroni")[0].any()
    assert mean_differs_from_zero(values, 0.05) == is_rejected


def test_chance_alone_rejects_a_mean_as_often_as_the_level_says():
    draws = np.random.default_rng(3).normal(size=(4000, 9, 2))
    n_rejected = sum(mean_differs_from_zero(values, 0.05) for values in draws)
    # binomial, four standard errors either way of 5 %; independent axes make 4.9 %
    assert abs(n_rejected - 0.0494 * 4000) < 4.0 * np.sqrt(4000 * 0.05)


def test_a_mean_of_one_value_and_of_zeros_is_not_tested():
    assert np.isnan(mean_p_values(np.ones((1, 2)))).all()
    assert np.isnan(mean_p_values(np.zeros((5, 3)))).all()
    assert not mean_differs_from_zero(np.ones((1, 2)), 0.05)
    # all shifted by exactly the same: as certain as can be
    assert mean_differs_from_zero(np.ones((5, 2)), 1e-9)
