"""The test for a smooth pattern: how often it cries, and what it finds."""

import numpy as np
import pytest
from scipy.stats import binom

from einschalt.theory.adjustment.smooth_pattern import smooth_pattern

N, EXTENT = 60, 1e4


@pytest.fixture(scope="module")
def network():
    """Points, and an information that leaves shift, turn and scale open."""
    rng = np.random.default_rng(0)
    xy = rng.uniform(0.0, EXTENT, (N, 2))
    trend = np.column_stack([np.ones(N), xy / EXTENT])
    free = np.eye(N) - trend @ np.linalg.solve(trend.T @ trend, trend.T)
    return xy, free / 0.04**2


def scores(network, rng, displacement=0.0, factor=1.0):
    _, information = network
    values, vectors = np.linalg.eigh(information)
    # symmetric, and so the same whichever vectors the library finds: the eigenvalues of
    # a projector are all alike
    root = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
    noise = factor * root @ rng.standard_normal((N, 2))
    return noise + information @ np.broadcast_to(displacement, (N, 2))


def wave(network, size):
    xy, _ = network
    return size * np.sin(2.0 * np.pi * xy[:, ::-1] / 6000.0)


def is_usual(n_alarms, n_draws, alpha):
    """Whether so many alarms come of chance, but for one in ten thousand."""
    low, high = binom.ppf([1e-4, 1.0 - 1e-4], n_draws, alpha)
    return low <= n_alarms <= high


@pytest.mark.slow
def test_clean_networks_raise_no_more_alarms_than_they_should(network):
    xy, information = network
    rng = np.random.default_rng(1)
    found = [smooth_pattern(scores(network, rng), information, xy) for _ in range(200)]
    p_value = np.array([one.p_value for one in found])
    for alpha in (0.05, 0.01):
        assert is_usual(np.sum(p_value < alpha), len(found), alpha)


def test_a_wave_is_found_with_its_size_and_reach(network):
    xy, information = network
    rng = np.random.default_rng(2)
    true = wave(network, 0.05)
    found = [
        smooth_pattern(scores(network, rng, true), information, xy) for _ in range(20)
    ]
    assert all(one.p_value < 1e-3 for one in found)
    assert all(one.p_value_if_scaled < 0.05 for one in found)
    sizes = np.array([one.size for one in found])
    # shrunk, and without what looks like a trend
    assert 0.5 < np.median(sizes) / np.sqrt(np.mean(true**2)) < 1.1
    assert all(0.5e3 < one.reach < 3e3 for one in found)


def test_the_field_is_not_continued_into_what_nothing_is_known_of(network):
    xy, information = network
    rng = np.random.default_rng(6)
    trend = np.column_stack([np.ones(N), xy / EXTENT])
    for wavelength in (6e3, 12e3):
        true = 0.15 * np.sin(2.0 * np.pi * xy[:, ::-1] / wavelength)
        known = true - trend @ np.linalg.lstsq(trend, true, rcond=None)[0]
        found = smooth_pattern(scores(network, rng, true), information, xy)
        assert np.abs(trend.T @ found.field).max() < 1e-9
        assert found.size / np.sqrt(np.mean(known**2)) == pytest.approx(1.0, abs=0.2)


def test_the_field_is_nearer_to_the_truth_than_the_points_themselves(network):
    xy, information = network
    rng = np.random.default_rng(4)
    free = information * 0.04**2
    true = (free @ wave(network, 0.05)).ravel()
    gained = []
    for _ in range(20):
        seen = scores(network, rng, wave(network, 0.05))
        field = free @ smooth_pattern(seen, information, xy).field
        autocorrelation = [
            np.corrcoef(values.ravel(), true)[0, 1]
            for values in (field, seen * 0.04**2)
        ]
        gained.append(autocorrelation[0] - autocorrelation[1])
    # 3.5 cm of each coordinate among errors of 4 cm
    assert autocorrelation[1] == pytest.approx(3.5 / np.hypot(3.5, 4.0), abs=0.2)
    assert min(gained) > 0.0


def test_errors_of_single_points_are_no_smooth_pattern(network):
    xy, information = network
    rng = np.random.default_rng(3)
    found = [
        smooth_pattern(scores(network, rng, factor=2.0), information, xy)
        for _ in range(100)
    ]
    assert all(one.p_value < 1e-3 for one in found)
    is_alarm = [one.p_value_if_scaled < 0.05 for one in found]
    assert is_usual(np.sum(is_alarm), len(found), 0.05)


def test_few_points_tell_nothing():
    found = smooth_pattern(np.zeros((2, 2)), np.eye(2), np.eye(2))
    assert np.isnan(found.p_value)
    nothing = smooth_pattern(np.zeros((5, 2)), np.zeros((5, 5)), np.eye(5)[:, :2])
    assert np.isnan(nothing.p_value)


def test_no_verdict_where_control_points_hardly_check_each_other(network):
    # two checks as good as the points; another, that of a model which hangs on three
    # points in a row, a thousand times as coarse and missed by metres
    xy, _ = network
    rng = np.random.default_rng(3)
    vectors = np.linalg.qr(rng.standard_normal((5, 5)))[0]
    information = (vectors * [1.0, 0.4, 1e-4, 0.0, 0.0]) @ vectors.T / 0.02**2
    missed = information @ np.outer(vectors[:, 2], [30.0, 0.0])
    assert np.isnan(smooth_pattern(missed, information, xy[:5]).p_value)
