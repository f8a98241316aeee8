"""The three cases of elements, and their cofactors."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.rotations import rotation_by_vector, rotation_from_angles
from einschalt.theory.relative_orientation.coplanarity import orient_pairs
from einschalt.theory.relative_orientation.model_formation import form_model
from einschalt.theory.relative_orientation.orientation_elements import (
    CASES,
    orientation_elements,
)
from einschalt.theory.relative_orientation.parallax_equations import (
    ELEMENTS,
    design_matrix,
)

C = 153.0


@pytest.fixture(scope="module")
def oriented(make_pairs):
    """Oriented pairs with bases along x, along y, backwards and in between."""
    pairs = make_pairs(60, 3)
    return pairs, orient_pairs(pairs.image, pairs.start, C)


@pytest.mark.parametrize("case", CASES)
def test_cameras_of_every_case_are_the_same_pair(oriented, case):
    pairs, found = oriented
    length = np.linspace(1.0, 90.0, 60)
    cameras = orientation_elements(found, length, case).cameras
    base = cameras.right_centre - cameras.left_centre
    in_left = np.einsum("nij,nj->ni", cameras.left_rotation, base)
    size = np.linalg.norm(base, axis=1)
    np.testing.assert_allclose(in_left / size[:, None], found.base, atol=1e-14)
    relative = cameras.right_rotation @ np.swapaxes(cameras.left_rotation, 1, 2)
    np.testing.assert_allclose(relative, found.rotation, atol=1e-14)
    points = form_model(
        pairs.image, pairs.start, C, cameras, "adjusted_rays", found.residuals
    )
    # all in front of the left camera, where the rays say
    pair = np.repeat(np.arange(60), found.n_points)
    seen = np.einsum(
        "nij,nj->ni",
        cameras.left_rotation[pair],
        points.xyz - cameras.left_centre[pair],
    )
    adjusted = (pairs.image + found.residuals)[:, :2]
    np.testing.assert_allclose(-C * seen[:, :2] / seen[:, 2:], adjusted, atol=1e-9)
    assert (seen[:, 2] < 0.0).all()


@pytest.mark.parametrize("case", ["dependent_right", "dependent_left"])
def test_rule_of_bx(oriented, case):
    _, found = oriented
    base = found.base
    if case == "dependent_left":
        base = np.einsum("nij,nj->ni", found.rotation, base)
    values = orientation_elements(found, 92.0, case).values
    is_along_x = base[:, 0] >= np.sqrt(0.5)
    assert 0 < is_along_x.sum() < 60
    np.testing.assert_allclose(values[is_along_x, 0], 92.0, rtol=1e-15)
    length = np.linalg.norm(values[~is_along_x, :3], axis=1)
    np.testing.assert_allclose(length, 92.0, rtol=1e-14)


def test_elements_of_the_left_camera_are_its_place_and_rotation(oriented):
    _, found = oriented
    elements = orientation_elements(found, 1.0, "dependent_left")
    cameras = elements.cameras
    np.testing.assert_array_equal(cameras.left_centre[:, 1:], elements.values[:, 1:3])
    np.testing.assert_array_equal(cameras.left_centre[:, 0], 0.0)
    np.testing.assert_array_equal(cameras.right_centre[:, 0], elements.values[:, 0])
    np.testing.assert_array_equal(cameras.right_centre[:, 1:], 0.0)
    rotation = rotation_from_angles(*elements.values[:, 3:].T)
    np.testing.assert_allclose(rotation, cameras.left_rotation, atol=1e-14)


def test_base_of_the_independent_case_is_the_x_axis(oriented):
    _, found = oriented
    elements = orientation_elements(found, 7.0, "independent")
    np.testing.assert_array_equal(
        elements.cameras.right_centre, np.tile([7.0, 0.0, 0.0], (60, 1))
    )
    base, phi_1, kappa_1, omega_2, phi_2, kappa_2 = elements.values.T
    np.testing.assert_array_equal(base, 7.0)
    left = rotation_from_angles(np.zeros(60), phi_1, kappa_1)
    np.testing.assert_allclose(left, elements.cameras.left_rotation, atol=1e-15)
    right = rotation_from_angles(omega_2, phi_2, kappa_2)
    np.testing.assert_allclose(right, elements.cameras.right_rotation, atol=1e-14)


def shifted(found, change):
    """Orientations with base and right camera moved by a change of six."""
    base = found.base + change[:3]
    base = base / np.linalg.norm(base, axis=1)[:, None]
    rotation = found.rotation @ rotation_by_vector(change[3:]).T
    return replace(found, base=base, rotation=rotation)


@pytest.mark.parametrize("case", CASES)
def test_cofactors_equal_those_by_differences(oriented, case):
    _, found = oriented
    step = 1e-6
    columns = []
    for shift in step * np.eye(6):
        above = orientation_elements(shifted(found, shift), 5.0, case).values[:, 1:]
        below = orientation_elements(shifted(found, -shift), 5.0, case).values[:, 1:]
        change = above - below
        if case == "independent":
            change = (change + np.pi) % (2.0 * np.pi) - np.pi
        else:
            change[:, 2:] = (change[:, 2:] + np.pi) % (2.0 * np.pi) - np.pi
        columns.append(change / (2.0 * step))
    by_change = np.stack(columns, axis=-1)
    wanted = by_change @ found.cofactor @ np.swapaxes(by_change, 1, 2)
    given = orientation_elements(found, 5.0, case).cofactor
    scale = np.sqrt(np.diagonal(wanted, axis1=1, axis2=2))
    outer = scale[:, :, None] * scale[:, None, :] + 1e-12
    np.testing.assert_allclose(given / outer, wanted / outer, atol=1e-6)


@pytest.mark.parametrize("case", CASES)
def test_small_elements_are_those_of_the_parallax_equation(case):
    rng = np.random.default_rng(9)
    base = 92.0
    ground = rng.uniform([-5, -95, -190], [97, 95, -110], size=(20, 3))
    # true elements, and the parallaxes in a model formed without them
    small = 1e-5 * rng.normal(size=5)
    left, right = cameras_with(case, small, base)
    image = np.hstack([seen(ground, *left), seen(ground, *right)])
    nominal = orientation_elements(
        orient_pairs(
            np.hstack(
                [
                    seen(ground, [0, 0, 0], np.eye(3)),
                    seen(ground, [base, 0, 0], np.eye(3)),
                ]
            ),
            [0, 20],
            C,
        ),
        base,
    ).cameras
    model = form_model(image, [0, 20], C, nominal, "mean_y")
    sign = 1.0 if case == "dependent_right" else -1.0
    design = design_matrix(model.xyz, base, case)
    linear = np.linalg.lstsq(design, sign * model.y_parallax)[0]
    linear = dict(zip(ELEMENTS[case], linear, strict=True))
    found = orientation_elements(orient_pairs(image, [0, 20], C), base, case)
    names = found.estimated
    for name, value in zip(names, found.values[0, 1:], strict=True):
        is_relative = name == "omega_2"  # omega_1 is held at 0
        wanted = -linear["d_omega"] if is_relative else linear[f"d_{name}"]
        # what is of second order: 1e-5 of angles, 1e-5 of the base times 1e-5
        scale = base if name in {"by", "bz"} else 1.0
        assert value == pytest.approx(wanted, abs=3e-9 * scale)


def cameras_with(case, small, base):
    """Left and right centre and rotation with small elements."""
    at_left, at_right = np.zeros(3), np.array([base, 0.0, 0.0])
    if case == "independent":
        d_omega, phi_1, phi_2, kappa_1, kappa_2 = small
        return (
            (at_left, rotation_from_angles(0.0, phi_1, kappa_1)),
            (at_right, rotation_from_angles(-d_omega, phi_2, kappa_2)),
        )
    omega, phi, kappa, by, bz = small
    moved = rotation_from_angles(omega, phi, kappa)
    shift = np.array([0.0, by, bz]) * base
    if case == "dependent_left":
        return (at_left + shift, moved), (at_right, np.eye(3))
    return (at_left, np.eye(3)), (at_right + shift, moved)


def seen(ground, centre, rotation):
    ray = (ground - centre) @ np.asarray(rotation).T
    return -C * ray[:, :2] / ray[:, 2:]


def test_what_is_not_oriented_stays_without_elements():
    found = orient_pairs(np.zeros((8, 4)), [0, 8], C)
    for case in CASES:
        elements = orientation_elements(found, 1.0, case)
        assert np.isnan(elements.values[0, 1:]).all()
        assert np.isnan(elements.cofactor[0]).all()


def test_unknown_case(oriented):
    with pytest.raises(SettingsError, match="case = 'left' is unknown; expected"):
        orientation_elements(oriented[1], 1.0, "left")
