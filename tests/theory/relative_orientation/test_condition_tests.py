"""Tests of the points of a pair against its orientation."""

import numpy as np
import pytest
from scipy.special import stdtrit

from einschalt.theory.adjustment.multiple_testing import is_rejected_by_holm
from einschalt.theory.relative_orientation.condition_tests import (
    StereoPairs,
    condition_tests,
    misclosures,
    prediction_tests,
)

SIGMA = 5e-3
LEVELS = np.array([0.001, 0.01, 0.1, 0.5])


@pytest.fixture(scope="module")
def good_pairs(make_pairs):
    made = make_pairs(1500, 11, make_pairs.geometry(n_points=(20, 20), tilt_deg=5.0))
    distance = np.full((1500, 2), made.principal_distance)
    return StereoPairs(made.image, made.start, distance)


def shares(p_value):
    """Shares of the probabilities below each level, and their standard errors."""
    found = np.mean(p_value[:, None] < LEVELS, axis=0)
    return found, np.sqrt(LEVELS * (1.0 - LEVELS) / len(p_value))


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["rigorous", "determinants"])
def test_probabilities_are_uniform(good_pairs, estimator):
    orientation = good_pairs.orient(estimator)
    tests = condition_tests(orientation, good_pairs)
    found, sigma = shares(tests.p_value)
    # points of a pair are correlated a little: 4 standard errors of independent ones
    np.testing.assert_array_less(np.abs(found - LEVELS), 4.0 * sigma)


def test_probabilities_of_predictions_are_uniform(good_pairs):
    is_used = np.arange(len(good_pairs.image)) % 20 < 12
    others = good_pairs.chosen(~is_used)
    tests = prediction_tests(good_pairs.chosen(is_used).orient(), others)
    found, sigma = shares(tests.p_value)
    # the eight others share an orientation, so that they count as one pair
    np.testing.assert_array_less(np.abs(found - LEVELS), 4.0 * np.sqrt(8.0) * sigma)


def test_spread_is_the_leverage(good_pairs):
    orientation = good_pairs.orient()
    spread = misclosures(orientation, good_pairs).spread
    # corrected or measured image coordinates: they differ by 1e-4 of their size
    np.testing.assert_allclose(
        1.0 - spread, orientation.redundancy_numbers, rtol=0.0, atol=1e-3
    )


def test_corrections_close_the_conditions(good_pairs):
    orientation = good_pairs.orient()
    found = misclosures(orientation, good_pairs)
    np.testing.assert_allclose(found.corrections, orientation.residuals, atol=2e-6)
    np.testing.assert_allclose(
        found.size**2, np.sum(found.corrections**2, axis=1), rtol=1e-12
    )


def test_a_blunder_of_ten_sigma_is_found(make_pairs):
    """In 200 pairs, wherever its redundancy allows, in the direction that is seen."""
    made = make_pairs(200, 12, make_pairs.geometry(n_points=(40, 40), tilt_deg=5.0))
    distance = np.full((200, 2), made.principal_distance)
    pairs = StereoPairs(made.image, made.start, distance)
    places = pairs.start[:-1] + np.arange(200) % 40
    orientation = pairs.orient()
    across = misclosures(orientation, pairs).corrections[places]
    image = pairs.image.copy()
    image[places] -= (
        10.0 * SIGMA * across / np.linalg.norm(across, axis=1, keepdims=True)
    )
    spoilt = StereoPairs(image, pairs.start, pairs.distance)
    tests = condition_tests(spoilt.orient(), spoilt)
    is_suspect = is_rejected_by_holm(tests.p_value, 0.001, pairs.start)[places]
    # Student's t of 34 degrees, one of 40 points, found with 95 %: 1.645 beyond its
    # limit, which is uncertain itself by the root of 1 + t²/(2 f)
    limit = stdtrit(34, 1.0 - 0.001 / 40 / 2)
    needed = limit + 1.645 * np.sqrt(1.0 + limit**2 / 68.0)
    seen = 10.0 * np.sqrt(orientation.redundancy_numbers[places])
    allows = seen > needed
    assert allows.mean() > 0.8
    assert is_suspect[allows].mean() >= 0.95


def test_false_alarms_are_not_more_than_nominal(good_pairs):
    tests = condition_tests(good_pairs.orient(), good_pairs)
    for level in (0.001, 0.01, 0.05):
        is_suspect = is_rejected_by_holm(tests.p_value, level, good_pairs.start)
        alarms = is_suspect.reshape(-1, 20).any(axis=1).mean()
        assert alarms <= level + 3.0 * np.sqrt(level / 1500)


def test_rounding_is_no_gross_error(make_pairs):
    made = make_pairs(20, 3, noise=0.0)
    distance = np.full((20, 2), made.principal_distance)
    pairs = StereoPairs(made.image, made.start, distance)
    assert np.isnan(condition_tests(pairs.orient(), pairs).p_value).all()


def test_pairs_of_too_few_points_are_not_tested(good_pairs):
    _, pairs = good_pairs.of_models(np.arange(3))
    few = pairs.chosen(np.arange(60) % 20 < [6] * 20 + [4] * 20 + [20] * 20)
    tests = condition_tests(few.orient(), few)
    is_tested = np.isfinite(tests.p_value)
    assert not is_tested[:10].any()
    assert is_tested[10:].all()
