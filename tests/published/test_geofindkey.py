"""geofindkey: Helmert transformations in the plane and in space, four points.

The program prints residuals as transformed − given, and as 'diff' the root of [vv]/2
of each coordinate. Its spatial transformation is linearised: what it prints as scale
is a − 1, its height shift is 24 mm off the rigorous one, and its residuals up to
0.45 mm. Hence the tolerances of the file for the spatial case (0.002, 0.03 and
0.0006 m) instead of half a unit of the last digit.
"""

import numpy as np
import pytest


@pytest.fixture
def plane(read_case):
    return read_case("geofindkey_helmert_2d")


@pytest.fixture
def space(read_case):
    return read_case("geofindkey_helmert_3d")


@pytest.fixture
def plane_fit(plane, transform_case):
    return transform_case(plane["data"], "helmert")


@pytest.fixture
def space_fit(space, transform_case):
    return transform_case(space["data"], "helmert_3d")


def test_plane_parameters(plane, plane_fit):
    printed = plane["printed"]
    found = plane_fit.parameters.loc["7/8"]
    np.testing.assert_allclose(found["a"], printed["a"], rtol=0, atol=5e-13)
    np.testing.assert_allclose(found["b"], printed["b"], rtol=0, atol=5e-13)
    np.testing.assert_allclose(found["te"], printed["tx"], rtol=0, atol=5e-5)
    np.testing.assert_allclose(found["tn"], printed["ty"], rtol=0, atol=5e-5)


def test_plane_scale_and_rotation(plane, plane_fit):
    a, b = plane_fit.parameters.loc["7/8", ["a", "b"]]
    printed = plane["printed"]
    np.testing.assert_allclose(np.hypot(a, b), printed["scale"], rtol=0, atol=5e-13)
    rotation = np.degrees(np.arctan2(b, a))
    np.testing.assert_allclose(rotation, printed["rot_deg"], rtol=0, atol=5e-11)


def test_plane_residuals(plane, plane_fit, residuals_of):
    printed = plane["printed"]
    found = residuals_of(plane_fit)
    np.testing.assert_allclose(found, printed["residuals"], rtol=0, atol=5e-5)
    diff = np.sqrt(np.sum(found**2, axis=0) / 2)
    np.testing.assert_allclose(diff, printed["rms_xy"], rtol=0, atol=5e-5)


def test_space_shift(space, space_fit):
    found = space_fit.parameters.loc["7/8", ["te", "tn", "th"]]
    east, north, height = np.abs(found - space["printed"]["t"])
    assert max(east, north) < 0.002
    assert height < 0.03


def test_space_residuals(space, space_fit, residuals_of):
    found = residuals_of(space_fit)
    np.testing.assert_allclose(
        found, space["printed"]["residuals"], rtol=0, atol=0.0006
    )
    diff = np.sqrt(np.sum(found**2, axis=0) / 2)
    np.testing.assert_allclose(diff, space["printed"]["rms"], rtol=0, atol=0.0006)
