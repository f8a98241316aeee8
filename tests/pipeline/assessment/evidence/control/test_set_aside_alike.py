"""Control that was set aside and is off in one direction."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom

from einschalt.pipeline.assessment.evidence.control.suspect_control import (
    SIGNIFICANCE,
    are_alike_in_height,
    are_many_set_aside,
    are_set_aside_alike,
)


def control_off_by(vectors, *, is_set_aside=True):
    east, north = np.asarray(vectors, dtype=float).T
    return pd.DataFrame(
        {
            "strain_easting": east,
            "strain_northing": north,
            "is_set_aside": is_set_aside,
        }
    )


@pytest.mark.parametrize(
    ("vectors", "is_alike"),
    [
        ([(1.0, 1.0)], False),  # one point has no direction in common with others
        ([(-1.90, -0.69), (-1.89, -0.74)], True),
        ([(1.0, 0.1), (-0.1, 1.0)], False),
        # a block that bends moves its far end to the other side
        ([(0.0, 0.6), (-0.2, 3.4), (-0.1, 0.7), (0.02, -0.35)], True),
        # around east: the arc is not cut at 0
        ([(1.0, 0.01), (1.0, -0.01)], True),
    ],
)
def test_points_off_in_one_direction(vectors, is_alike):
    assert are_set_aside_alike(control_off_by(vectors)) is is_alike


def test_only_what_was_set_aside_counts():
    vectors = [(1.0, 0.0), (1.0, 0.01), (1.0, 0.02)]
    aside = [True, False, False]
    assert not are_set_aside_alike(control_off_by(vectors, is_set_aside=aside))


@pytest.mark.parametrize(("n", "are_many"), [(0, False), (2, False), (3, True)])
def test_more_than_two_of_five_are_many(n, are_many):
    aside = np.arange(5) < n
    control = control_off_by(np.ones((5, 2)), is_set_aside=aside)
    assert are_many_set_aside(control) is are_many
    assert not are_many_set_aside(control.iloc[:0])


@pytest.mark.parametrize(
    ("heights", "are_alike"),
    [
        ([0.5], False),
        ([0.52, 0.5], True),
        ([0.5, 0.5], True),
        ([0.54, 0.47, 0.59, 0.36], True),
        ([0.4, -0.48, 0.35], False),
        # as those that are kept: it is not for its height that it went
        ([0.05, 0.051], False),
    ],
)
def test_heights_off_in_one_direction(heights, are_alike):
    vectors = np.random.default_rng(1).standard_normal((len(heights) + 6, 2))
    aside = np.arange(len(vectors)) < len(heights)
    control = control_off_by(vectors, is_set_aside=aside)
    assert not are_alike_in_height(control)  # there are none
    kept = [0.06, -0.04, 0.03, -0.05, 0.02, -0.04]
    assert are_alike_in_height(control.assign(strain_height=[*heights, *kept])) is (
        are_alike
    )


@pytest.mark.slow
def test_independent_heights_are_seldom_alike():
    rng = np.random.default_rng(15)
    n_draws, found = 1000, 0
    aside = np.arange(12) < 4
    for _ in range(n_draws):
        control = control_off_by(np.ones((12, 2)), is_set_aside=aside)
        heights = rng.standard_normal(12) * np.where(aside, 1.0, 0.01)
        found += are_alike_in_height(control.assign(strain_height=heights))
    assert 0 < found <= binom.ppf(0.9999, n_draws, SIGNIFICANCE)


@pytest.mark.slow
@pytest.mark.parametrize("n", [2, 3, 6])
def test_independent_errors_are_seldom_alike(n):
    rng = np.random.default_rng(15)
    n_draws = 1000
    found = sum(
        are_set_aside_alike(control_off_by(rng.standard_normal((n, 2))))
        for _ in range(n_draws)
    )
    assert found <= binom.ppf(0.9999, n_draws, SIGNIFICANCE)
    assert found > 0
