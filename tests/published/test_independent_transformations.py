"""Transformations computed independently to full precision, plane and spatial.

Everything that the transformation gives is compared: parameters, cofactors and
covariances, s_0 and m_0, residuals, leverages, redundancy numbers, new points with
their cofactors and errors. Tolerance 1e-9 relative, and 1e-8 m for coordinates of
5·10⁶ m, where one unit in the last place of the number is 1e-9.
"""

import numpy as np
import pytest

from einschalt.foundations.rotations import rotation_from_angles

PLANE_NAMES = {
    "affine": ["a1", "a2", "a0", "b1", "b2", "b0"],
    "helmert": ["a", "b", "te", "tn"],
    "rigid": ["theta", "te", "tn"],
}
COORDINATE = {"rtol": 0, "atol": 1e-8}
FIGURE = {"rtol": 1e-9, "atol": 1e-15}


def assert_equal_as_correlations(found, expected):
    # what is zero by symmetry is only zero against the variances
    size = np.sqrt(np.diag(expected))
    assert np.abs((found - expected) / np.outer(size, size)).max() < 1e-9


@pytest.fixture(params=PLANE_NAMES)
def plane(request, read_case, transform_case):
    case = read_case(f"single_{request.param}")
    return case, transform_case(case, request.param)


def test_plane_parameters(plane):
    case, fit = plane
    names = PLANE_NAMES[fit.kind]
    found = fit.parameters.loc["7/8", names]
    # the shift is that of the origin, 1e-8 m off for 1e-12 in a rotation
    np.testing.assert_allclose(found, case["expected"]["params"], rtol=1e-11, atol=2e-8)


def test_plane_cofactors_and_covariance(plane):
    case, fit = plane
    names, expected = PLANE_NAMES[fit.kind], case["expected"]
    for found, wanted in (
        (fit.cofactor("7/8"), np.array(expected["Qpp"])),
        (fit.covariance("7/8"), np.array(expected["cov"])),
    ):
        assert_equal_as_correlations(found.loc[names, names].to_numpy(), wanted)


def test_plane_errors(plane):
    case, fit = plane
    model, expected = fit.models.iloc[0], case["expected"]
    assert model["redundancy"] == expected["dof"]
    assert model["n_points"] == expected["n"]
    np.testing.assert_allclose(model["s_0"], expected["s0"], rtol=1e-8)
    np.testing.assert_allclose(model["m_0"], expected["s0_total"], rtol=1e-8)
    np.testing.assert_allclose(fit.m_0, expected["s0_total"], rtol=1e-8)
    np.testing.assert_allclose(fit.fit.sum_of_squares, expected["vPv"], rtol=1e-8)


def test_plane_residuals_and_leverage(plane, residuals_of):
    case, fit = plane
    expected = case["expected"]
    np.testing.assert_allclose(residuals_of(fit), expected["residuals"], **COORDINATE)
    np.testing.assert_allclose(fit.fit.leverage, expected["leverage"], **FIGURE)
    mean = np.mean(expected["leverage"], axis=1)
    np.testing.assert_allclose(fit.residuals["leverage"], mean, **FIGURE)
    redundancy = np.mean(expected["redundancy"], axis=1)
    np.testing.assert_allclose(fit.residuals["redundancy_number"], redundancy, **FIGURE)


def test_plane_new_points(plane, model_table, transformed):
    case, fit = plane
    expected, points = case["expected"], case["new_source"]
    np.testing.assert_allclose(transformed(fit, points), expected["new"], **COORDINATE)
    cofactors = fit.fit.point_cofactors(np.zeros(3, dtype=int), np.array(points))
    np.testing.assert_allclose(cofactors, expected["new_Q"], rtol=1e-9, atol=1e-15)
    coordinate = fit.fit.s_0[0] * np.sqrt(np.diagonal(cofactors, axis1=1, axis2=2))
    np.testing.assert_allclose(coordinate, expected["new_se_coord"], rtol=1e-8)
    m_t = fit.transform(model_table(points))["m_t"]
    np.testing.assert_allclose(m_t, expected["new_mt_total"], rtol=1e-8)


def test_affine_shape(read_case, transform_case):
    case = read_case("single_affine")
    a1, a2, b1, b2 = transform_case(case, "affine").parameters.loc[
        "7/8", ["a1", "a2", "b1", "b2"]
    ]
    expected = case["expected"]
    np.testing.assert_allclose(np.arctan2(b1, a1), expected["rotation"], rtol=1e-10)
    np.testing.assert_allclose(np.hypot(a1, b1), expected["scale_x"], rtol=1e-10)
    np.testing.assert_allclose(np.hypot(a2, b2), expected["scale_y"], rtol=1e-10)


def test_helmert_scale_and_rotation(read_case, transform_case):
    case = read_case("single_helmert")
    a, b = transform_case(case, "helmert").parameters.loc["7/8", ["a", "b"]]
    np.testing.assert_allclose(np.hypot(a, b), case["expected"]["scale"], rtol=1e-10)
    rotation = case["expected"]["rotation"]
    np.testing.assert_allclose(np.arctan2(b, a), rotation, rtol=1e-10)


@pytest.fixture(params=["expected", "expected_weighted"])
def space(request, read_case, transform_case):
    case = read_case("spatial7")
    weights = case["weights"] if request.param == "expected_weighted" else None
    return case[request.param], transform_case(case, "helmert_3d", weights=weights)


def test_space_parameters(space):
    expected, fit = space
    found = fit.parameters.loc["7/8"]
    np.testing.assert_allclose(found["scale"], expected["scale"], rtol=1e-12)
    np.testing.assert_allclose(
        found[["te", "tn", "th"]], expected["t"], rtol=0, atol=1e-10
    )
    # right-handed R_x R_y R_z: the transpose of the matrix of the camera
    rotation = rotation_from_angles(*found[["omega", "phi", "kappa"]]).T
    np.testing.assert_allclose(rotation, expected["R"], rtol=0, atol=1e-12)


def test_space_errors(space, residuals_of):
    expected, fit = space
    model = fit.models.iloc[0]
    assert model["redundancy"] == expected["dof"]
    np.testing.assert_allclose(model["s_0"], expected["s0"], rtol=1e-9)
    np.testing.assert_allclose(fit.fit.sum_of_squares, expected["vPv"], rtol=1e-9)
    np.testing.assert_allclose(
        residuals_of(fit), expected["residuals"], rtol=0, atol=1e-10
    )


def test_space_leverage(space):
    expected, fit = space
    np.testing.assert_allclose(fit.fit.leverage, expected["leverage"], **FIGURE)
    plan = np.array(expected["redundancy"])[:, :2].mean(axis=1)
    np.testing.assert_allclose(fit.residuals["redundancy_number"], plan, **FIGURE)


def test_space_cofactors_at_the_centroid(space):
    expected, fit = space
    wanted = np.array(expected["Qpp_centred"])
    found = np.zeros((7, 7))
    found[:3, :3] = np.eye(3) / fit.fit.weight_sum[0]
    found[3, 3] = fit.fit.cofactor_scale[0]
    found[4:, 4:] = fit.fit.cofactor_rotation[0]
    assert_equal_as_correlations(found, wanted)
    np.testing.assert_allclose(
        fit.fit.centroid_model[0], expected["centroid_src"], rtol=1e-12
    )
    np.testing.assert_allclose(
        fit.fit.centroid_ground[0], expected["centroid_dst"], rtol=1e-12
    )
