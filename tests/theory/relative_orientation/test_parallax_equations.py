"""The linear parallax equation against real rays, and the conversion of elements."""

import numpy as np
import pytest

from einschalt.foundations.rotations import rotation_from_angles
from einschalt.theory.relative_orientation.parallax_equations import (
    CASES,
    DEPENDENT_LEFT,
    DEPENDENT_RIGHT,
    ELEMENTS,
    INDEPENDENT,
    design_matrix,
    element_scale,
    independent_from_dependent,
)

BASE = 92.0


@pytest.fixture
def hilly_points():
    rng = np.random.default_rng(1951)
    low, high = [-5.0, -95.0, -190.0], [97.0, 95.0, -110.0]
    return rng.uniform(low, high, size=(40, 3))


def y_of_ray(xyz, centre, angles, shift):
    """Height kept: y of the ray through a point, after its bundle has moved."""
    ray = (xyz - centre) @ rotation_from_angles(*angles)
    return centre[1] + shift[0] + ray[:, 1] / ray[:, 2] * (xyz[:, 2] - shift[1])


def change_of_parallax(xyz, elements, case):
    """Change of y(moved) - y(fixed) at the same height, by turning real rays."""
    left, right = np.zeros(3), np.array([BASE, 0.0, 0.0])
    still, unmoved = np.zeros(3), np.zeros(2)
    omega, *rest = elements
    if case == INDEPENDENT:
        y_left = y_of_ray(xyz, left, (omega, rest[0], rest[2]), unmoved)
        return y_left - y_of_ray(xyz, right, (0.0, rest[1], rest[3]), unmoved)
    moved, fixed = (left, right) if case == DEPENDENT_LEFT else (right, left)
    y_moved = y_of_ray(xyz, moved, elements[:3], elements[3:])
    return y_moved - y_of_ray(xyz, fixed, still, unmoved)


@pytest.mark.parametrize("case", CASES)
def test_design_is_the_derivative_of_turned_rays(case, hilly_points):
    design = design_matrix(hilly_points, BASE, case)
    for element in range(5):
        step = np.zeros(5)
        step[element] = 1e-4 * (1.0 if ELEMENTS[case][element][2] != "b" else BASE)
        change = change_of_parallax(hilly_points, step, case)
        change -= change_of_parallax(hilly_points, -step, case)
        # the corrections take the parallax away, hence the minus
        numeric = -change / (2.0 * step[element])
        size = np.abs(design[:, element]).max()
        np.testing.assert_allclose(design[:, element], numeric, atol=1e-6 * size)


def test_x_of_a_turned_ray_does_not_matter_to_first_order(hilly_points):
    # moving the mark along one ray changes both y alike, for both slopes are y / z
    rng = np.random.default_rng(2)
    elements = rng.normal(scale=1e-6, size=5)
    lower = hilly_points * (1.0 + 1e-6)
    before = design_matrix(hilly_points, BASE, INDEPENDENT) @ elements
    after = design_matrix(lower, BASE, INDEPENDENT) @ elements
    np.testing.assert_allclose(after, before, atol=1e-5 * np.abs(before).max())


def test_base_may_differ_from_point_to_point(hilly_points):
    rng = np.random.default_rng(3)
    bases = rng.uniform(80.0, 100.0, size=len(hilly_points))
    together = design_matrix(hilly_points, bases, DEPENDENT_RIGHT)
    single = [
        design_matrix(xyz[None], base, DEPENDENT_RIGHT)[0]
        for xyz, base in zip(hilly_points, bases, strict=True)
    ]
    np.testing.assert_allclose(together, single, rtol=1e-13)


@pytest.mark.parametrize(
    ("case", "sign"), [(DEPENDENT_LEFT, 1.0), (DEPENDENT_RIGHT, -1.0)]
)
def test_converted_elements_give_the_same_parallaxes(case, sign, hilly_points):
    # y_left - y_right is one thing; p of dependent_right is its negative
    independent = design_matrix(hilly_points, BASE, INDEPENDENT)
    dependent = design_matrix(hilly_points, BASE, case)
    converted = independent @ independent_from_dependent(BASE, case)
    np.testing.assert_allclose(
        sign * dependent, converted, atol=1e-12 * np.abs(independent).max()
    )


def test_conversions_of_many_models_at_once():
    base = np.array([0.9, 92.0, 640.0])
    together = independent_from_dependent(base, DEPENDENT_LEFT)
    single = [independent_from_dependent(b, DEPENDENT_LEFT) for b in base]
    np.testing.assert_array_equal(together, single)


def test_scale_is_the_height_for_angles_and_one_for_shifts():
    height = np.array([152.0, 300.0])
    np.testing.assert_array_equal(element_scale(height, INDEPENDENT)[1], 300.0)
    np.testing.assert_array_equal(
        element_scale(height, DEPENDENT_LEFT)[0], [152.0, 152.0, 152.0, 1.0, 1.0]
    )
