"""Shifts of regions that a scan sees in four of five cases."""

import numpy as np
import pytest

from einschalt.theory.adjustment.detectable_shift import POWER, detectable_shift
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

N_REGIONS, N_POINTS = 1000, 100


def shift_of(information, size=20):
    information = np.asarray(information, dtype=float)
    sizes = np.full(len(information), size)
    return detectable_shift(information, sizes, N_POINTS, lambda at: information[at])


def test_four_of_five_displacements_are_seen():
    """Of draws: the test is significant among all regions together."""
    sigma = 0.02  # of each coordinate of a region's shift [m]
    size = shift_of(np.full(N_REGIONS, sigma**-2.0)).largest
    shifts = sigma * np.random.default_rng(1).standard_normal((20_000, 2))
    shifts += size * np.array([0.6, -0.8])
    squares = np.sum(shifts**2, axis=1) / sigma**2
    seen = N_REGIONS * np.exp(-squares / 2.0) <= FINDING_SIGNIFICANCE
    assert np.mean(seen) == pytest.approx(POWER, abs=0.01)


def test_the_worst_region_is_computed_and_not_drawn():
    drawn = np.linspace(0.5, 2.0, 50)
    exact = np.where(np.arange(50) == 3, 0.1, drawn)
    sizes = np.full(50, 20)
    found = detectable_shift(drawn, sizes, N_POINTS, lambda at: exact[at])
    ratio = found.largest / found.median
    assert ratio == pytest.approx((np.median(drawn) / 0.1) ** 0.5)


def test_small_regions_do_not_count():
    information, sizes = np.array([1e-3, 1.0, 1.0]), np.array([9, 10, 11])
    found = detectable_shift(information, sizes, N_POINTS, lambda at: information[at])
    assert found.largest == found.median


def test_of_a_part_that_nothing_holds_nothing_is_seen():
    found = shift_of([0.0, 1.0, 1.0])
    assert np.isinf(found.largest)
    assert np.isfinite(found.median)
