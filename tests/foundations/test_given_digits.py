"""To how many digits numbers were given."""

import numpy as np
import pytest

from einschalt.foundations.given_digits import FEWEST, resolution_of

VALUES = 5_312_000.0 + np.random.default_rng(1).uniform(0.0, 5000.0, 60)


@pytest.mark.parametrize("digits", [-2, -1, 0, 1, 2, 3])
def test_the_last_digit_is_found(digits):
    assert resolution_of(VALUES.round(digits)) == pytest.approx(10.0**-digits)


def test_degrees_to_five_digits():
    degrees = 48.0 + (VALUES - VALUES.min()) / 111_000.0
    assert resolution_of(degrees.round(5)) == pytest.approx(1e-5)


def test_a_few_of_more_digits_count_little():
    values = VALUES.round(0)
    values[:2] += 0.37
    assert resolution_of(values) == 1.0
    values[2:6] += 0.37
    assert resolution_of(values) == pytest.approx(0.01)


def test_full_precision_and_few_values_tell_nothing():
    assert resolution_of(VALUES) == 0.0
    assert resolution_of(VALUES.round(0)[: FEWEST - 1]) == 0.0
    assert resolution_of([np.nan, *VALUES.round(1)]) == pytest.approx(0.1)


def test_equal_values_tell_of_digits_once():
    grid = np.repeat([463000.0, 463500.0, 464000.0], 4)
    noise = 1e-9 * np.random.default_rng(2).standard_normal(len(grid))
    assert resolution_of(grid + noise) == 0.0
