"""Ellipses that hold as many held-out points as they say, tails and wrong ones too."""

import numpy as np
import pytest
from scipy import stats

from einschalt.theory.residual_distribution.held_out_ellipses import (
    LIMIT,
    held_out_ellipses,
)

N_POINTS = 4000


@pytest.fixture(params=[None, 3.0], ids=["normal", "tails"])
def good(request):
    """Differences of turned and stretched errors, over variances of 1."""
    rng = np.random.default_rng(4)
    errors = rng.normal(size=(2 * N_POINTS, 2)) @ np.array([[2.0, 0.0], [0.5, 1.0]])
    if request.param:
        chi = rng.chisquare(request.param, 2 * N_POINTS) / request.param
        errors /= np.sqrt(chi)[:, None]
    return errors


def share_within(differences, found):
    inverse = np.linalg.inv(found.shape)
    squares = np.einsum("ni,ij,nj->n", differences, inverse, differences)
    return np.count_nonzero(squares <= LIMIT)


def test_as_many_further_points_lie_within_as_the_ellipses_say(good):
    found = held_out_ellipses(good[:N_POINTS], np.ones(N_POINTS))
    assert not found.is_wrong.any()
    low, high = stats.binom.ppf([1e-4, 1 - 1e-4], N_POINTS, 0.95)
    # the sample from which they come is as large as the one that they hold
    assert low - 40 < share_within(good[N_POINTS:], found) < high + 40


def test_wrong_points_are_named_and_make_no_ellipse_larger(good):
    rng = np.random.default_rng(5)
    is_wrong = rng.random(N_POINTS) < 0.05
    directions = rng.normal(size=(N_POINTS, 2)) * 300.0
    given = good[:N_POINTS] + directions * is_wrong[:, None]
    found = held_out_ellipses(given, np.ones(N_POINTS))
    assert np.count_nonzero(found.is_wrong & ~is_wrong) < 0.01 * N_POINTS
    assert np.count_nonzero(~found.is_wrong & is_wrong) < 0.002 * N_POINTS
    assert found.tails.share_wrong == pytest.approx(0.05, abs=0.01)
    assert 0.93 < share_within(good[N_POINTS:], found) / N_POINTS < 0.97
    kept = held_out_ellipses(given, np.ones(N_POINTS), keep_wrong=True)
    assert not kept.is_wrong.any()
    assert share_within(given, kept) / N_POINTS == pytest.approx(0.95, abs=0.001)


def test_correlation_and_size_of_both_axes_are_those_of_the_differences():
    rng = np.random.default_rng(6)
    turned = np.array([[2.0, 0.0], [0.5, 1.0]])
    errors = rng.normal(size=(N_POINTS, 2)) @ turned
    found = held_out_ellipses(errors, np.ones(N_POINTS))
    np.testing.assert_allclose(found.shape, turned.T @ turned, rtol=0.1, atol=0.1)


def test_few_points_have_round_ellipses_of_their_size():
    errors = np.array([[1.0, 0.0], [0.0, -1.0], [np.nan, 0.0], [0.6, 0.8]])
    found = held_out_ellipses(errors, np.ones(4))
    assert found.n_held_out == 3
    assert found.shape[0, 1] == 0.0
    assert np.isfinite(found.shape).all()
