import numpy as np
import pytest

from einschalt.theory.transformation.plane_fit import (
    SAME_GROUND,
    TOO_FEW,
    UNDETERMINED,
    USABLE,
    CentredFit,
    is_spread,
    mirror_gain,
    plane_moments,
    status_of,
    without_unusable,
)


@pytest.fixture
def moments_of_two():
    """Moments of two models, one point of weight 3 among them, and none between."""
    xy = np.array([[0.0, 0], [2, 0], [0, 2], [10, 10], [14, 10]])
    en = 2.0 * xy + [4.5e6, 5.3e6]
    weights = np.array([1.0, 1, 1, 3, 1])
    return plane_moments(xy, en, weights, np.array([0, 3, 3, 5]))


def test_moments_by_hand(moments_of_two):
    m = moments_of_two
    assert m.n_points.tolist() == [3, 0, 2]
    np.testing.assert_array_equal(m.weight_sum, [3.0, np.nan, 4.0])
    np.testing.assert_allclose(m.centroid_model[[0, 2]], [[2 / 3, 2 / 3], [11, 10]])
    np.testing.assert_allclose(
        m.centroid_ground[2], [4.5e6 + 22, 5.3e6 + 20], rtol=1e-15
    )
    np.testing.assert_allclose(
        m.model_model[0], [[8 / 3, -4 / 3], [-4 / 3, 8 / 3]], rtol=1e-14
    )
    # 3 · 1² + 1 · 3² along x, and twice that against the ground
    np.testing.assert_allclose(m.model_model[2], [[12, 0], [0, 0]], atol=1e-12)
    np.testing.assert_allclose(m.model_ground[2], [[24, 0], [0, 0]], atol=1e-8)
    np.testing.assert_allclose(m.polar, [16 / 3, 0, 12], rtol=1e-14)
    np.testing.assert_allclose(m.ground_polar, [64 / 3, 0, 48], rtol=1e-8)
    np.testing.assert_allclose(m.determinant, [16 / 3, 0, 0], atol=1e-12)


def test_model_without_points_is_not_spread(moments_of_two):
    assert moments_of_two.is_spread.tolist() == [True, False, True]


def test_moments_do_not_depend_on_memory_layout(moments_of_two):
    xy = np.array([[0.0, 0], [2, 0], [0, 2], [10, 10], [14, 10]])
    en = 2.0 * xy + [4.5e6, 5.3e6]
    weights = np.repeat(np.array([1, 1, 1, 3, 1]), 2)[::2]
    again = plane_moments(
        np.asfortranarray(xy), en[::-1][::-1], weights, np.array([0, 3, 3, 5])
    )
    np.testing.assert_array_equal(again.model_ground, moments_of_two.model_ground)


@pytest.mark.parametrize(
    ("apart", "found"), [(0.0, False), (1e-9, False), (1e-4, True), (1.0, True)]
)
def test_apart_by_more_than_rounding(apart, found):
    # at 5·10⁶ m the limit is 5 µm
    polar = np.array([2 * (apart / 2) ** 2])
    assert is_spread(polar, np.array([2.0]), np.array([[5e6, 0.0]])) == [found]


def test_status():
    n_points = np.array([0, 2, 3, 3, 3])
    is_determined = np.array([True, False, True, False, True])
    is_ground_spread = np.array([False, False, True, True, False])
    wanted = [TOO_FEW, TOO_FEW, USABLE, UNDETERMINED, SAME_GROUND]
    found = status_of(n_points, 3, is_determined, is_ground_spread)
    assert found.tolist() == wanted


def test_without_unusable_leaves_its_argument_alone():
    values = np.ones((3, 2), dtype=int)
    found = without_unusable(values, np.array([USABLE, TOO_FEW, UNDETERMINED]))
    np.testing.assert_array_equal(found, [[1, 1], [np.nan] * 2, [np.nan] * 2])
    assert values.all()


def test_mirror_image_must_fit_a_hundred_times_better():
    fit = CentredFit()
    fit.sum_of_squares = np.array([100.0, 100.0, 100.0, np.nan])
    fit.mirror_gain = np.array([99.5, 98.0, np.nan, 99.5])
    assert fit.is_mirrored.tolist() == [True, False, False, False]


def test_mirror_image_of_a_line_or_of_the_fewest_points_tells_nothing():
    direct = np.array([1.0, 1.0, 1.0])
    turned = np.array([1.0000001, 2.0, 2.0])
    is_overdetermined = np.array([True, False, True])
    found = mirror_gain(np.full(3, 5.0), direct, turned, is_overdetermined)
    np.testing.assert_array_equal(found, [np.nan, np.nan, 5.0])
