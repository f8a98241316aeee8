"""Convex hulls of many groups against scipy (Qhull), one group after another."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from einschalt.foundations.hulls import convex_hulls


def test_hulls_are_those_of_qhull():
    random = np.random.default_rng(3)
    count = random.integers(0, 40, size=300)
    start = np.concatenate([[0], np.cumsum(count)])
    # far from the origin, as ground coordinates are
    xy = random.normal(size=(start[-1], 2)) * 1000.0 + [13_000.0, 5_300_000.0]
    vertices, hull_start = convex_hulls(xy, start)
    for group in range(len(count)):
        hull = vertices[hull_start[group] : hull_start[group + 1]]
        points = xy[start[group] : start[group + 1]]
        if len(points) < 3:
            assert len(hull) == len(points)
            continue
        expected = ConvexHull(points).vertices
        first = np.flatnonzero(expected == hull[0] - start[group])[0]
        # both run anticlockwise, from different vertices
        np.testing.assert_array_equal(hull - start[group], np.roll(expected, -first))


GRID = st.lists(
    st.tuples(st.integers(-3, 3), st.integers(-3, 3)), min_size=1, max_size=12
)


@settings(max_examples=200, deadline=None)
@given(points=GRID)
def test_hull_holds_every_point_and_turns_left(points):
    """Also where many points lie on lines or on each other."""
    xy = np.array(points, dtype=float)
    vertices, _ = convex_hulls(xy, np.array([0, len(xy)]))
    ring = xy[vertices]
    if len(ring) < 3:
        return
    edge = np.roll(ring, -1, axis=0) - ring
    turn = edge[:, 0] * np.roll(edge, -1, axis=0)[:, 1] - (
        edge[:, 1] * np.roll(edge, -1, axis=0)[:, 0]
    )
    assert (turn > 0).all()
    to_point = xy[None] - ring[:, None]
    side = edge[:, None, 0] * to_point[..., 1] - edge[:, None, 1] * to_point[..., 0]
    assert (side >= 0).all()


def test_points_on_a_line_leave_their_ends():
    xy = np.array([[1.0, 1.0], [0.0, 0.0], [3.0, 3.0], [2.0, 2.0]])
    vertices, start = convex_hulls(xy, np.array([0, 4]))
    assert vertices.tolist() == [1, 2]
    assert start.tolist() == [0, 2]
