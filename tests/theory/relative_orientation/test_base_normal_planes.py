"""Kasper's criteria: signs, circles, and planes that have no answer."""

import numpy as np
import pytest

from einschalt.theory.relative_orientation.base_normal_planes import (
    base_system,
    examine_planes,
    standard_planes,
)
from einschalt.theory.relative_orientation.hallert import flat_six_points


def hilly_planes(n_planes, seed):
    rng = np.random.default_rng(seed)
    low, high = [[-15, -190], [60, -190], [-110, -190]], [[15, -110], [110, -110]]
    return rng.uniform(low, [*high, [-60, -110]], size=(n_planes, 3, 2))


def flat_plane(half_width, depth):
    return np.array([[0.0, -depth], [half_width, -depth], [-half_width, -depth]])


@pytest.mark.parametrize(("a", "h"), [(95.0, 152.0), (100.0, 88.0), (100.0, 300.0)])
def test_closed_forms_of_flat_terrain(a, h):
    plane = examine_planes(flat_plane(a, h))
    np.testing.assert_allclose(plane.over_correction_n, (1 + h**2 / a**2) / 2)
    np.testing.assert_allclose(plane.over_correction_k, (h**2 / a**2 - 1) / 2)
    np.testing.assert_allclose(plane.gap, a**2 / (a**2 + h**2))
    np.testing.assert_allclose(plane.determinant, 2 * a**3 * h)
    # both planes together have the tilt of Hallert's six points, 3 h² / 4 a⁴
    np.testing.assert_allclose(1 / (2 * plane.weight), 0.75 * h**2 / a**4)


def test_k_is_negative_where_the_wings_lie_wider_than_the_model_is_deep():
    assert examine_planes(flat_plane(100.0, 88.0)).over_correction_k < 0.0
    assert examine_planes(flat_plane(100.0, 88.0)).over_correction_n > 0.0
    np.testing.assert_allclose(
        examine_planes(flat_plane(100.0, 100.0)).over_correction_k, 0.0, atol=1e-15
    )


def test_k_is_what_the_turn_leaves_and_n_what_it_takes():
    # turn by n times what clears point l, and the parallax of l becomes -k times itself
    planes = hilly_planes(50, seed=1)
    criteria = examine_planes(planes)
    np.testing.assert_allclose(
        criteria.over_correction_n - criteria.over_correction_k, 1.0
    )
    # the parallaxes of i and j are cleared by swings and tips, which take a multiple
    # of y and z from p z; the turn that clears l alone takes its r² only
    y, z = planes[..., 0], planes[..., 1]
    d_omega = 0.002
    p_z = d_omega * (y**2 + z**2)
    pair = np.stack([y[:, :2], z[:, :2]], axis=-1)
    cleared = np.linalg.solve(pair, p_z[:, :2, np.newaxis])[..., 0]
    left = p_z[:, 2] - y[:, 2] * cleared[:, 0] - z[:, 2] * cleared[:, 1]
    just_clearing = left / (y[:, 2] ** 2 + z[:, 2] ** 2)
    np.testing.assert_allclose(
        d_omega / just_clearing, criteria.over_correction_n, rtol=1e-10
    )


def test_k_from_the_construction_and_from_heights():
    planes = hilly_planes(200, seed=2)
    criteria = examine_planes(planes)
    last = planes[:, 2]
    along = last / np.linalg.norm(last, axis=1)[:, np.newaxis]
    to_circle = np.sum(criteria.intersection * along, axis=1)
    beyond = np.sum((last - criteria.intersection) * along, axis=1)
    np.testing.assert_allclose(to_circle / beyond, criteria.over_correction_k)
    height = criteria.intersection[:, 1]
    np.testing.assert_allclose(
        height / (last[:, 1] - height), criteria.over_correction_k, rtol=1e-9
    )
    # the circle holds centre, i, j and the intersection
    middle = criteria.circle_end / 2
    for point in (planes[:, 0], planes[:, 1], criteria.intersection, 0.0 * last):
        radius = np.linalg.norm(point - middle, axis=1)
        np.testing.assert_allclose(radius, criteria.circle_radius)


def test_gap_is_what_point_i_lacks_from_the_circle_of_the_others():
    planes = hilly_planes(100, seed=3)
    criteria = examine_planes(planes)
    through_others = examine_planes(planes[:, [1, 2, 0]])
    nearest, on_circle = planes[:, 0], through_others.intersection
    np.testing.assert_allclose(
        criteria.gap,
        1 - np.linalg.norm(nearest, axis=1) / np.linalg.norm(on_circle, axis=1),
    )


def collinearity_of_inverted(yz):
    """Inverted in the centre, points on a circle through it lie on a line."""
    u = yz / np.sum(yz**2, axis=-1, keepdims=True)
    return np.linalg.det(np.concatenate([u, np.ones_like(u[..., :1])], axis=-1))


def test_circle_test_by_inversion():
    planes = hilly_planes(200, seed=4)
    criteria = examine_planes(planes)
    squares = np.sum(planes**2, axis=-1).prod(axis=-1)
    np.testing.assert_allclose(
        criteria.determinant, squares * collinearity_of_inverted(planes), rtol=1e-9
    )


def test_points_on_a_circle_through_the_centre_are_dangerous():
    angle = np.radians([-91.0, -40.0, -150.0])
    radius = 80.0
    circle = radius * np.stack([np.cos(angle), np.sin(angle) - 1.0], axis=-1)
    criteria = examine_planes(circle)
    size = np.sum(circle**2, axis=1).max() ** 2
    assert abs(criteria.determinant) < 1e-14 * size
    assert abs(criteria.gap) < 1e-14
    assert criteria.weight < 1e-20
    assert criteria.sigma_omega > 1e10
    assert abs(criteria.over_correction_n) > 1e12
    assert abs(collinearity_of_inverted(circle)) < 1e-18


@pytest.mark.parametrize(
    "plane",
    [
        [[0.0, -1.0], [1.0, -1.0], [-1.0, -1.0]],
        [[0.0, -2.0], [1.0, -1.0], [-1.0, -1.0]],  # on the circle, exactly
        [[0.0, -1.0], [0.0, -2.0], [0.0, -3.0]],  # one ray
        [[0.0, -1.0], [0.0, -1.0], [0.0, -1.0]],  # one point
        [[0.0, -1.0], [1.0, -1.0], [1.0, -1.0]],  # two points
        [[0.0, -1.0], [0.0, -2.0], [1.0, -1.0]],  # i and j on one ray
        [[0.0, 0.0], [1.0, -1.0], [-1.0, -1.0]],  # in the centre
        [[np.nan, -1.0], [1.0, -1.0], [-1.0, -1.0]],
    ],
)
def test_nothing_stops_at_a_hopeless_plane(plane):
    criteria = examine_planes(np.array(plane))
    assert criteria.weight >= 0.0 or np.isnan(np.array(plane)).any()
    if criteria.weight == 0.0:
        assert criteria.sigma_omega == np.inf


def test_standard_points_are_found_in_any_order():
    xyz = flat_six_points(95.0, 92.0, 152.0)
    rng = np.random.default_rng(5)
    xyz[:, 2] += rng.uniform(-10, 10, 6)
    expected = xyz[:, 1:].reshape(2, 3, 2)
    order = rng.permutation(6)
    chosen = standard_planes(xyz[order], np.array([92.0]), np.array([0, 6]))
    np.testing.assert_array_equal(chosen[0], expected)


def test_planes_without_three_points_are_nan():
    xyz = flat_six_points(95.0, 92.0, 152.0)
    xyz[4, 0] -= 0.2 * 92.0
    xyz = np.concatenate([xyz, xyz[:0], xyz[[0, 0, 0]], flat_six_points(1.0, 1.0, 1.0)])
    start = np.array([0, 6, 6, 9, 15])
    base = np.array([92.0, 92.0, 92.0, 1.0])
    is_missing = np.isnan(standard_planes(xyz, base, start)).all(axis=(2, 3))
    np.testing.assert_array_equal(
        is_missing, [[False, True], [True, True], [True, True], [False, False]]
    )


def test_base_system_is_a_rotation_with_the_base_along_x():
    rng = np.random.default_rng(6)
    base = rng.normal(size=(20, 3)) * [1.0, 1.0, 0.2]
    axis = np.array([0.0, 0.0, 1.0]) + 0.1 * rng.normal(size=(20, 3))
    axis /= np.linalg.norm(axis, axis=1)[:, np.newaxis]
    axes = base_system(base, axis + np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(
        axes @ axes.swapaxes(1, 2), np.broadcast_to(np.eye(3), (20, 3, 3)), atol=1e-15
    )
    np.testing.assert_allclose(np.linalg.det(axes), 1.0)
    turned = np.einsum("pij,pj->pi", axes, base)
    np.testing.assert_allclose(turned[:, 0], np.linalg.norm(base, axis=1))
    np.testing.assert_allclose(turned[:, 1:], 0.0, atol=1e-15)
    assert (axes[:, 2, 2] > 0.5).all()


def test_base_system_of_nothing_is_nan():
    base = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    axis = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]])
    assert np.isnan(base_system(base, axis)).any(axis=(1, 2)).all()
