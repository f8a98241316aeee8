"""Shapes as bytes, read back by hand after the standard (OGC 06-103r4, 8.2)."""

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from einschalt.interfaces.files import map_shapes


def ring_of(wkb):
    order, kind, n_rings, _ = struct.unpack("<BIII", wkb[:13])
    assert (order, kind, n_rings) == (1, 3, 1)
    ring = np.frombuffer(wkb[13:], dtype="<f8").reshape(-1, 2)
    np.testing.assert_array_equal(ring[0], ring[-1])
    return ring[:-1]


def test_points():
    xy = np.array([[1.5, -2.5], [np.nan, 1.0], [3.0, 4.0]])
    wkb = map_shapes.points(xy).to_pylist()
    assert wkb[0] == struct.pack("<BIdd", 1, 1, 1.5, -2.5)
    assert wkb[1] is None
    assert wkb[2] == struct.pack("<BIdd", 1, 1, 3.0, 4.0)


def test_lines():
    start = np.array([[0.0, 1.0], [2.0, np.nan]])
    wkb = map_shapes.lines(np.stack([start, start + 1.0], axis=1)).to_pylist()
    assert wkb == [struct.pack("<BIIdddd", 1, 2, 2, 0.0, 1.0, 1.0, 2.0), None]


def test_polygons_close_their_rings():
    xy = np.array([[[0, 0], [2, 0], [0, 2]], [[5, 5], [6, np.nan], [6, 6.0]]])
    wkb = map_shapes.polygons(xy).to_pylist()
    assert wkb[0] == struct.pack("<BIII8d", 1, 3, 1, 4, 0, 0, 2, 0, 0, 2, 0, 0)
    assert wkb[1] is None


def test_nothing_gives_nothing():
    nothing = np.empty((0, 2))
    no_group = np.empty(0, dtype=int)
    assert map_shapes.points(nothing).to_pylist() == []
    assert map_shapes.lines(nothing[:, None]).to_pylist() == []
    assert map_shapes.polygons(nothing[:, None]).to_pylist() == []
    assert map_shapes.hulls(nothing, no_group, 0).to_pylist() == []
    assert map_shapes.hulls(nothing, no_group, 2).to_pylist() == [None, None]


def test_hulls_are_those_of_qhull():
    random = np.random.default_rng(3)
    count = random.integers(0, 40, size=300)
    group = np.repeat(np.arange(300), count)
    # far from the origin, as ground coordinates are
    xy = random.normal(size=(len(group), 2)) * 1000.0 + [13_000.0, 5_300_000.0]
    wkb = map_shapes.hulls(xy, group, 300).to_pylist()
    assert [shape is None for shape in wkb] == (count < 3).tolist()
    for k in np.flatnonzero(count >= 3):
        held = xy[group == k]
        expected = held[ConvexHull(held).vertices]  # anticlockwise as well
        first = np.argmin(expected[:, 0])
        np.testing.assert_array_equal(ring_of(wkb[k]), np.roll(expected, -first, 0))


GRID = st.lists(
    st.tuples(st.integers(-3, 3), st.integers(-3, 3)), min_size=1, max_size=12
)


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(points=GRID)
def test_hull_holds_every_point_and_turns_left(points):
    """Also where many points lie on lines or on each other."""
    xy = np.array(points, dtype=float)
    (wkb,) = map_shapes.hulls(xy, np.zeros(len(xy), dtype=int), 1).to_pylist()
    if np.linalg.matrix_rank(xy - xy[0]) < 2:
        assert wkb is None  # points on a line enclose nothing
        return
    ring = ring_of(wkb)
    edge = np.roll(ring, -1, axis=0) - ring
    following = np.roll(edge, -1, axis=0)
    assert (edge[:, 0] * following[:, 1] > edge[:, 1] * following[:, 0]).all()
    to_point = xy[None] - ring[:, None]
    side = edge[:, None, 0] * to_point[..., 1] - edge[:, None, 1] * to_point[..., 0]
    assert (side >= 0).all()
