"""Geometries as bytes, read back by hand after the standard (OGC 06-103r4, 8.2)."""

import struct

import numpy as np

from einschalt.interfaces.files.wkb_geometries import (
    lines_as_wkb,
    points_as_wkb,
    polygons_as_wkb,
)


def test_points():
    wkb = points_as_wkb(np.array([[1.5, -2.5], [np.nan, 1.0], [3.0, 4.0]])).to_pylist()
    assert wkb[0] == struct.pack("<BIdd", 1, 1, 1.5, -2.5)
    assert wkb[1] is None
    assert wkb[2] == struct.pack("<BIdd", 1, 1, 3.0, 4.0)


def test_lines():
    start = np.array([[0.0, 1.0], [2.0, np.nan]])
    wkb = lines_as_wkb(start, start + 1.0).to_pylist()
    assert wkb == [struct.pack("<BIIdddd", 1, 2, 2, 0.0, 1.0, 1.0, 2.0), None]


def test_polygons_close_their_rings():
    xy = np.array(
        [[0, 0], [9, 9], [0, 0], [2, 0], [0, 2], [5, 5], [6, 5], [6, 6.0], [5, 6]]
    )
    start = np.array([0, 2, 5, 5, 9])
    wkb = polygons_as_wkb(xy, start).to_pylist()
    assert wkb[0] is None  # two points enclose nothing
    assert wkb[2] is None
    assert wkb[1] == struct.pack("<BIII8d", 1, 3, 1, 4, 0, 0, 2, 0, 0, 2, 0, 0)
    assert wkb[3] == struct.pack("<BIII10d", 1, 3, 1, 5, 5, 5, 6, 5, 6, 6, 5, 6, 5, 5)


def test_nothing_gives_nothing():
    nothing = np.empty((0, 2))
    assert points_as_wkb(nothing).to_pylist() == []
    assert lines_as_wkb(nothing, nothing).to_pylist() == []
    assert polygons_as_wkb(nothing, np.array([0])).to_pylist() == []
    assert polygons_as_wkb(nothing, np.array([0, 0])).to_pylist() == [None]
