"""The error of a measured point, from settings and from the instrument."""

import numpy as np
import pytest

from einschalt.theory.measuring_error import (
    m_g_from_machine,
    m_g_from_repeated_settings,
    m_g_of_mean,
    mean_of_settings,
)


def test_mean_of_settings():
    np.testing.assert_allclose(m_g_of_mean(6.0, np.array([1, 4, 9])), [6.0, 3.0, 2.0])


def test_footnote_of_kovarik():
    # printed: 0.015 and 0.01 mm, together "about 0.02", through 2.5 "hardly 0.01"
    assert m_g_from_machine(0.015, 0.01, 1.0) == pytest.approx(0.018, abs=5e-5)
    assert m_g_from_machine(0.015, 0.01, 2.5) == pytest.approx(0.0072, abs=5e-5)


def test_two_settings_by_hand():
    # differences 2 and 0: each setting 1 from the mean, one redundant setting
    mean, spread = mean_of_settings(np.array([[0.0, 5.0], [2.0, 5.0]]), [0, 2])
    np.testing.assert_allclose(mean, [[1.0, 5.0]])
    m_g, error = m_g_from_repeated_settings(spread, [2])
    assert m_g == pytest.approx(np.sqrt(2.0))
    assert error == pytest.approx(np.sqrt(2.0) / 2.0)


def test_means_and_spread_are_those_of_numpy():
    rng = np.random.default_rng(4)
    settings = rng.normal([230e3, -5e6, 7.0], 0.01, (9, 3))
    mean, spread = mean_of_settings(settings, [0, 4, 5, 9])
    for place, rows in enumerate((settings[:4], settings[4:5], settings[5:])):
        np.testing.assert_allclose(mean[place], rows.mean(axis=0), rtol=1e-15)
        if len(rows) > 1:
            total = np.sqrt(rows[:, :2].var(axis=0, ddof=1).sum())
            assert spread[place] == pytest.approx(total, rel=1e-6)
    assert np.isnan(spread[1])


def test_settings_give_back_the_error_that_made_them():
    rng = np.random.default_rng(8)
    count = rng.integers(1, 5, 4000)
    start = np.concatenate([[0], np.cumsum(count)])
    true = np.repeat(rng.uniform(0, 230e3, (4000, 2)), count, axis=0)
    xy = true + rng.normal(0.0, 5.0 / np.sqrt(2.0), true.shape)
    _, spread = mean_of_settings(xy, start)
    m_g, error = m_g_from_repeated_settings(spread, count)
    redundancy = (count - 1).sum()
    assert error == pytest.approx(m_g / (2.0 * np.sqrt(redundancy)))
    assert m_g == pytest.approx(5.0, abs=3 * error)


def test_single_settings_say_nothing():
    for spread, n_settings in (([np.nan, 3.0], [2, 1]), ([], [])):
        m_g, error = m_g_from_repeated_settings(spread, n_settings)
        assert np.isnan(m_g)
        assert np.isnan(error)
