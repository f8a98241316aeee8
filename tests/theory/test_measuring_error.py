"""The error of a measured point, from settings and from the instrument."""

import numpy as np
import pytest

from einschalt.theory.measuring_error import (
    m_g_from_machine,
    m_g_from_repeated_settings,
    m_g_of_mean,
)


def test_mean_of_settings():
    np.testing.assert_allclose(m_g_of_mean(6.0, np.array([1, 4, 9])), [6.0, 3.0, 2.0])


def test_footnote_of_kovarik():
    # printed: 0.015 and 0.01 mm, together "about 0.02", through 2.5 "hardly 0.01"
    assert m_g_from_machine(0.015, 0.01, 1.0) == pytest.approx(0.018, abs=5e-5)
    assert m_g_from_machine(0.015, 0.01, 2.5) == pytest.approx(0.0072, abs=5e-5)


def test_two_settings_by_hand():
    # differences 2 and 0: each setting 1 from the mean, one redundant setting
    m_g, error = m_g_from_repeated_settings([[0.0, 5.0], [2.0, 5.0]], [0, 2])
    assert m_g == pytest.approx(np.sqrt(2.0))
    assert error == pytest.approx(np.sqrt(2.0) / 2.0)


def test_settings_give_back_the_error_that_made_them():
    rng = np.random.default_rng(8)
    count = rng.integers(0, 5, 4000)
    start = np.concatenate([[0], np.cumsum(count)])
    true = np.repeat(rng.uniform(0, 230e3, (4000, 2)), count, axis=0)
    xy = true + rng.normal(0.0, 5.0 / np.sqrt(2.0), true.shape)
    m_g, error = m_g_from_repeated_settings(xy, start)
    redundancy = np.maximum(count - 1, 0).sum()
    assert error == pytest.approx(m_g / (2.0 * np.sqrt(redundancy)))
    assert m_g == pytest.approx(5.0, abs=3 * error)


def test_single_settings_say_nothing():
    m_g, error = m_g_from_repeated_settings([[0.0, 5.0], [2.0, 5.0]], [0, 1, 1, 2])
    assert np.isnan(m_g)
    assert np.isnan(error)
