"""Families of tests, each as statsmodels adjusts it alone."""

import gc
from itertools import pairwise

import numpy as np
import pytest
from statsmodels.stats.multitest import multipletests

from einschalt.theory.adjustment.multiple_testing import (
    any_significant,
    bonferroni,
    count_tested,
    is_rejected_by_holm,
)


@pytest.fixture(autouse=True)
def kept_garbage(monkeypatch):
    """statsmodels searches all memory at each call, for arrays that it has left."""
    monkeypatch.setattr(gc, "collect", lambda: 0)


@pytest.fixture(scope="module")
def families():
    """Sixty families of 0 to 12 tests, some of them NaN, some probabilities equal."""
    rng = np.random.default_rng(2)
    count = rng.integers(0, 13, 60)
    p_values = rng.uniform(size=count.sum()) ** 4
    p_values[::7] = np.round(p_values[::7], 1)
    p_values[::11] = np.nan
    return p_values, np.concatenate([[0], np.cumsum(count)])


@pytest.mark.parametrize("significance", [0.001, 0.05, 0.3, 0.9])
def test_each_family_is_rejected_as_statsmodels_does(families, significance):
    p_values, start = families
    is_rejected = is_rejected_by_holm(p_values, significance, start)
    assert is_rejected.any()
    for first, last in pairwise(start):
        own = p_values[first:last]
        is_tested = np.isfinite(own)
        assert not is_rejected[first:last][~is_tested].any()
        if is_tested.any():
            expected = multipletests(own[is_tested], significance, method="holm")[0]
            found = is_rejected[first:last][is_tested]
            np.testing.assert_array_equal(found, expected)


def test_nothing_tested_nothing_rejected():
    nothing = np.full(3, np.nan)
    assert not is_rejected_by_holm(nothing, 0.05, np.array([0, 2, 3])).any()
    assert count_tested(nothing, np.array([0, 2, 3])).tolist() == [0, 0]


@pytest.mark.parametrize("level", [0.001, 0.05, 0.3])
def test_one_family_is_adjusted_by_its_size_as_statsmodels_does(families, level):
    p_values, start = families
    for first, last in pairwise(start):
        own = p_values[first:last]
        tested = own[np.isfinite(own)]
        found = bonferroni(own)
        assert np.isnan(found).sum() == len(own) - len(tested)
        if not len(tested):
            assert not any_significant(own, level)
            continue
        is_rejected, expected, *_ = multipletests(tested, level, "bonferroni")
        np.testing.assert_allclose(found[np.isfinite(own)], expected, rtol=1e-12)
        assert any_significant(own, level) == is_rejected.any()


def test_part_of_a_family_is_adjusted_by_the_whole_of_it():
    assert bonferroni([0.01, 0.3], 20).tolist() == [0.2, 1.0]
    assert any_significant([0.01], 0.05)
    assert not any_significant([0.01], 0.05, n_tests=6)
