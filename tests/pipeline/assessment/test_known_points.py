"""Known points against the claim."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import chi2
from tests.changed_results import changed

from einschalt.pipeline.assessment.known_points import (
    KnownPoints,
    check_points,
    check_points_confirmed_by_two,
    control_points,
    far_control,
)


def known(ratio, n=10):
    """Points whose differences are that many times the 5 cm claimed."""
    differences = np.full((n, 2), 0.05 * ratio / np.sqrt(2.0))
    names = np.array([f"{k}" for k in range(n)], dtype=object)
    return KnownPoints(names, differences, 0.05, 2.0 * n)


@pytest.mark.parametrize("n", [1, 6, 40])
def test_limits_are_those_of_chance(n):
    high = np.sqrt(chi2.isf(0.001, 2 * n) / (2 * n))
    assert known(1.01 * high, n).are_beyond
    assert not known(0.99 * high, n).are_beyond
    low = np.sqrt(chi2.ppf(0.001, 2 * n) / (2 * n))
    assert known(0.99 * low, n).are_too_small
    assert not known(1.01 * low, n).are_too_small
    assert known(high, n).p_value == pytest.approx(0.001)


def test_a_quarter_more_or_less_is_not_worth_a_word():
    """However many points there are."""
    assert not known(1.24, 100_000).are_beyond
    assert known(1.26, 100_000).are_beyond
    assert not known(0.81, 100_000).are_too_small
    assert known(0.79, 100_000).are_too_small


def test_no_points_say_nothing():
    none = known(1.0, 0)
    assert np.isnan(none.rms)
    assert not none.are_beyond
    assert not none.are_too_small


def test_differences_are_those_of_the_figures(good_result):
    assert check_points(good_result.examination).rms == pytest.approx(
        good_result.figures.check_rms
    )
    control = control_points(good_result.examination)
    assert control.rms == pytest.approx(good_result.figures.control_rms)
    # both coordinates have errors
    rows = good_result.points[good_result.points["role"] == "control"]
    square = np.mean(rows["standard_error_total"] ** 2) + 0.03**2
    assert control.claimed == pytest.approx(np.sqrt(square))


def test_check_points_that_exceed_are_beyond(good_result):
    points = good_result.points.assign(
        difference_easting=4.0 * good_result.points["difference_easting"],
        difference_northing=4.0 * good_result.points["difference_northing"],
    )
    assert not good_result.examination.known_check.are_beyond
    spoilt = changed(good_result, points=points).examination
    assert spoilt.known_check.are_beyond


def far_ones(*misses, n=12):
    """Control points of 5 cm, the first of which are so far off [m]."""
    rng = np.random.default_rng(4)
    differences = 0.05 / np.sqrt(2.0) * rng.standard_normal((n, 2))
    differences[: len(misses), 0] += misses
    names = np.array([f"{k}" for k in range(n)], dtype=object)
    known = KnownPoints(names, differences, 0.05, 2.0 * n)
    return far_control(SimpleNamespace(known_control=known)).tolist()


def test_single_control_points_that_are_far_off_are_named():
    assert far_ones() == []
    assert far_ones(1.0) == ["0"]
    assert far_ones(1.0, -0.4) == ["0", "1"]
    # most of them: then it is the claim that is wrong
    assert far_ones(*[0.3] * 7) == []
    # all are worse than claimed, and no single one is to blame
    assert far_ones(1.0, *[0.1] * 11) == []


@pytest.mark.parametrize(("outliers", "n_left"), [("huber", 2), ("snoop", 3)])
def test_a_check_point_that_hangs_on_one_measurement_tests_nothing(outliers, n_left):
    """Of refused ones and another; with two that confirm each other it is a test."""
    residuals = pd.DataFrame(
        {
            "point_id": ["0", "0", "0", "1", "1", "1", "2"],
            "is_suspect": [True, True, False, True, False, False, False],
        }
    )
    adjusted = SimpleNamespace(
        known_check=known(2.0, 3),
        lone_points=(),
        residuals=residuals,
        settings=SimpleNamespace(outliers=outliers),
    )
    confirmed = check_points_confirmed_by_two(adjusted)
    assert confirmed.count == n_left
    assert confirmed.point_ids.tolist() == ["0", "1", "2"][-n_left:]
