"""Nets of triangles: there, back, and what does not lead back."""

import numpy as np
import pytest

from einschalt.theory.triangulation.held_out_points import held_out_differences
from einschalt.theory.triangulation.reversible_net import (
    is_turned_over,
    make_reversible_net,
)
from einschalt.theory.triangulation.triangle_net import TriangleNet, delaunay_corners

FAR = np.array([3.4e6, 5.6e6])
TURN = np.array([[0.9996, -0.001], [0.001, 0.9996]])


@pytest.fixture(scope="module")
def frames():
    """400 points of two frames of a country that fit to 5 cm."""
    rng = np.random.default_rng(3)
    source = FAR + rng.uniform(0.0, 5_000.0, (400, 2))
    target = (source - FAR) @ TURN.T + [2e5, 6e6] + rng.normal(0.0, 0.05, (400, 2))
    return source, target


def test_corners_go_where_they_were_measured_and_come_back(frames):
    net = make_reversible_net(*frames).net
    np.testing.assert_allclose(net.apply(frames[0]), frames[1], atol=1e-8, rtol=0)
    np.testing.assert_allclose(net.invert(frames[1]), frames[0], atol=1e-8, rtol=0)


def test_an_affine_change_is_reproduced_everywhere(frames):
    source = frames[0]
    net = make_reversible_net(source, (source - FAR) @ TURN.T).net
    xy = FAR + np.random.default_rng(0).uniform(500.0, 4_500.0, (1_000, 2))
    np.testing.assert_allclose(net.apply(xy), (xy - FAR) @ TURN.T, atol=1e-8, rtol=0)
    np.testing.assert_allclose(net.invert(net.apply(xy)), xy, atol=1e-8, rtol=0)


def test_nothing_is_known_outside(frames):
    net = make_reversible_net(*frames).net
    outside = FAR + np.array([[-100.0, 50.0], [np.nan, 0.0]])
    assert np.isnan(net.apply(outside)).all()


def test_points_that_changed_places_are_left_out(frames):
    source, target = frames[0], frames[1].copy()
    pair = np.argsort(np.hypot(*(source - source[7]).T))[:2]
    target[pair] = target[pair[::-1]]
    assert is_turned_over(source, target, delaunay_corners(source)).any()
    found = make_reversible_net(source, target)
    assert found.n_turned > 0
    assert set(found.left_out) <= set(pair)
    assert len(found.left_out)
    net = found.net
    assert not is_turned_over(source, target, net.corners).any()
    xy = FAR + np.random.default_rng(0).uniform(500.0, 4_500.0, (1_000, 2))
    np.testing.assert_allclose(net.invert(net.apply(xy)), xy, atol=1e-7, rtol=0)


def test_of_gross_errors_the_wrong_points_go_and_not_their_neighbours(frames):
    source, target = frames[0], frames[1].copy()
    wrong = np.array([11, 97, 203, 305])
    target[wrong] += [[900.0, 0.0], [0.0, -900.0], [700.0, 700.0], [-800.0, 300.0]]
    assert set(make_reversible_net(source, target).left_out) == set(wrong)


def test_a_point_in_the_place_of_another_one_is_left_out(frames):
    source, target = (np.concatenate([f, f[:1]]) for f in frames)
    found = make_reversible_net(source, target + 0.0)
    assert len(found.left_out) == 1
    assert found.left_out[0] in {0, len(source) - 1}
    assert np.isinf(found.deviations[found.left_out[0]])


@pytest.mark.parametrize("n_points", [0, 2, 5])
def test_points_on_a_line_have_no_triangle(n_points):
    line = np.column_stack([np.arange(n_points) * 3.0, np.arange(n_points) * 1.0])
    assert delaunay_corners(line).shape == (0, 3)


def test_held_out_points_show_the_noise_and_not_the_fit(frames):
    # a corner is predicted from three others: its own error and theirs
    differences = held_out_differences(*frames)
    known = np.isfinite(differences).all(axis=1)
    assert known.mean() > 0.85
    assert 0.05 < differences[known].std() < 0.05 * np.sqrt(2.0)


def test_triangles_may_be_given_in_any_order(frames):
    source, target = frames
    corners = delaunay_corners(source)
    turned = TriangleNet(source, target, np.roll(corners[::-1], 1, axis=1))
    xy = FAR + np.random.default_rng(1).uniform(500.0, 4_500.0, (300, 2))
    plain = TriangleNet(source, target, corners)
    np.testing.assert_allclose(turned.apply(xy), plain.apply(xy), atol=1e-8, rtol=0)


def test_one_gross_error_takes_no_others_with_it():
    """It tilts an affine transformation of all points, and seems to tilt their shifts.

    Before, seven neighbours went with it.
    """
    rng = np.random.default_rng(0)
    source = rng.uniform(0.0, 2000.0, (60, 2))
    target = source + 0.03 * rng.normal(size=(60, 2))
    target[5, 0] += 50.0
    found = make_reversible_net(source, target, significance=0.01)
    assert found.contradicting.tolist() == [5]
    assert found.left_out.tolist() == [5]
