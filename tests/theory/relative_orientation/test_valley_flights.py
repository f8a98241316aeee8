"""Dangerous valleys before the flight: formulas, and the points that they stand for."""

import numpy as np
import pytest

from einschalt.theory.relative_orientation.base_normal_planes import examine_planes
from einschalt.theory.relative_orientation.valley_flights import (
    critical_depth,
    critical_wing_heights,
    standard_points,
    valley_depths,
    valley_inflation,
    valley_over_correction,
)


@pytest.mark.parametrize(
    ("principal_distance", "printed"), [(152.0, 0.30), (300.0, 0.10), (88.0, 0.56)]
)
def test_critical_depths_of_three_cameras(principal_distance, printed):
    # the printed value has two digits
    assert critical_depth(100.0, principal_distance) == pytest.approx(printed, abs=5e-3)


def test_valleys_at_the_critical_depth():
    critical = critical_depth(100.0, 152.0)
    assert valley_inflation(critical, critical) == np.inf
    assert abs(valley_over_correction(critical, critical)) == np.inf
    inflation = valley_inflation(np.array([-0.5, 0.0, 0.5, 0.9]) * critical, critical)
    np.testing.assert_allclose(inflation, [1 / 1.5, 1.0, 2.0, 10.0])


def test_over_correction_changes_sign_beyond_the_critical_depth():
    critical = critical_depth(100.0, 152.0)
    n = valley_over_correction(np.array([0.0, 0.25, 0.35, 0.5]), critical)
    assert (np.sign(n) == [1, 1, -1, -1]).all()
    np.testing.assert_allclose(n[0], (1 + 152.0**2 / 100.0**2) / 2)


def test_wings_at_the_critical_height_lie_on_the_circle():
    distance, flying_height = 400.0, np.array([801.0, 1000.0, 3000.0])
    for heights in critical_wing_heights(distance, flying_height):
        for height, depth in zip(heights, flying_height, strict=True):
            wing = [distance, height - depth]
            plane = [[0.0, -depth], wing, [-wing[0], wing[1]]]
            assert abs(examine_planes(np.array(plane)).gap) < 1e-12


def test_no_height_is_critical_for_wings_beyond_half_of_the_flying_height():
    low, high = critical_wing_heights(500.001, 1000.0)
    assert np.isnan([low, high]).all()
    low, high = critical_wing_heights(500.0, 1000.0)
    assert low == high == 500.0


def test_both_ways_to_the_critical_depth_agree():
    # seen under the same angle, and at the same distance on the ground
    tan_beta, flying_height = 100.0 / 152.0, 1000.0
    depth = critical_depth(100.0, 152.0) * flying_height
    distance = tan_beta * (flying_height - depth)
    np.testing.assert_allclose(
        critical_wing_heights(distance, flying_height)[0], depth, rtol=1e-12
    )


def test_standard_points_are_seen_where_they_should():
    heights = np.array([[600.0, 650.0, 700.0, 720.0, 580.0, 610.0]] * 2)
    altitude = np.array([1800.0, 2000.0])
    xyz, base = standard_points(heights, altitude, 0.152, 0.1, 0.092)
    np.testing.assert_allclose(xyz[:, :, 2], heights - altitude[:, np.newaxis])
    np.testing.assert_allclose(base, 0.092 / 0.152 * (altitude - 625.0))
    np.testing.assert_allclose(xyz[:, ::2, 0], 0.0)
    np.testing.assert_allclose(xyz[:, 1::2, 0], base[:, np.newaxis].repeat(3, axis=1))
    in_image = -0.152 * xyz[:, :, 1] / xyz[:, :, 2]
    expected = [0.0, 0.0, 0.1, 0.1, -0.1, -0.1]
    np.testing.assert_allclose(in_image, [expected, expected], atol=1e-15)


def test_depths_of_both_planes():
    heights = np.array([[600.0, 500.0, 700.0, 500.0, 800.0, 400.0]])
    np.testing.assert_allclose(valley_depths(heights), [[150.0, -50.0]])
