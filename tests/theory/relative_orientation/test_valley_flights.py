"""Dangerous valleys before the flight: formulas, and the points that they stand for."""

import numpy as np
import pytest

from einschalt.theory.relative_orientation.base_normal_planes import examine_planes
from einschalt.theory.relative_orientation.dangerous_surfaces import examine_surfaces
from einschalt.theory.relative_orientation.valley_flights import (
    critical_depth,
    standard_points,
    valley_depths,
)


@pytest.mark.parametrize(
    ("principal_distance", "printed"), [(152.0, 0.30), (300.0, 0.10), (88.0, 0.56)]
)
def test_critical_depths_of_three_cameras(principal_distance, printed):
    # the printed value has two digits
    assert critical_depth(100.0, principal_distance) == pytest.approx(printed, abs=5e-3)


def test_formulas_of_the_docs_hold_in_symmetrical_valleys():
    """Inflation and over-correction of the page on valley flights, by adjustment."""
    flying_height, critical = 1000.0, critical_depth(100.0, 152.0)
    delta = np.array([-0.5, 0.0, 0.5, 0.9, 1.2, 2.0]) * critical
    heights = np.repeat([[0.0, 1.0]], len(delta), axis=0).repeat([2, 4], axis=1)
    heights *= flying_height * delta[:, None]
    altitude = np.full(len(delta), flying_height)
    xyz, base = standard_points(heights, altitude, 0.152, 0.1, 0.092)
    start = 6 * np.arange(len(delta) + 1)
    found = examine_surfaces(xyz.reshape(-1, 3), base, start)
    np.testing.assert_allclose(
        found.inflation, 1.0 / np.abs(1.0 - delta / critical), rtol=1e-7
    )
    n = (1.0 - delta) / (2.0 * (critical - delta))
    assert (np.sign(n) == [1, 1, 1, 1, -1, -1]).all()
    for plane in (0, 1):
        np.testing.assert_allclose(found.planes.over_correction_n[:, plane], n)
        np.testing.assert_allclose(found.planes.gap[:, plane], 1.0 / (2.0 * n))


def test_wings_at_the_critical_height_lie_on_the_circle():
    distance, flying_height = 400.0, np.array([801.0, 1000.0, 3000.0])
    reach = np.sqrt(flying_height**2 - 4.0 * distance**2)
    for heights in ((flying_height - reach) / 2.0, (flying_height + reach) / 2.0):
        for height, depth in zip(heights, flying_height, strict=True):
            wing = [distance, height - depth]
            plane = [[0.0, -depth], wing, [-wing[0], wing[1]]]
            assert abs(examine_planes(np.array(plane)).gap) < 1e-12


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
