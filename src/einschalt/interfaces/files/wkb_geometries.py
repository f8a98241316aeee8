"""Coordinates as well-known binary, the form in which Arrow carries geometries."""

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

LITTLE_ENDIAN = 1
POINT, LINE, POLYGON = 1, 2, 3
HEAD = np.dtype([("order", "u1"), ("kind", "<u4")])
POINT_RECORD = np.dtype([*HEAD.descr, ("xy", "<f8", (2,))])
LINE_RECORD = np.dtype([*HEAD.descr, ("size", "<u4"), ("xy", "<f8", (2, 2))])
RING_HEAD = np.dtype([*HEAD.descr, ("n_rings", "<u4"), ("size", "<u4")])
SMALLEST_RING = 3


def points_as_wkb(xy):
    """Write points.

    Parameters
    ----------
    xy : ndarray, shape (n, 2)
        NaN gives a missing geometry.

    Returns
    -------
    pyarrow.BinaryArray
    """
    records = np.zeros(len(xy), dtype=POINT_RECORD)
    records["kind"], records["xy"] = POINT, xy
    return _fixed(records, np.isfinite(xy).all(axis=1))


def lines_as_wkb(xy_start, xy_end):
    """Write lines of two points.

    Parameters
    ----------
    xy_start, xy_end : ndarray, shape (n, 2)
        NaN gives a missing geometry.

    Returns
    -------
    pyarrow.BinaryArray
    """
    xy = np.stack([xy_start, xy_end], axis=1)
    records = np.zeros(len(xy), dtype=LINE_RECORD)
    records["kind"], records["size"], records["xy"] = LINE, 2, xy
    return _fixed(records, np.isfinite(xy).all(axis=(1, 2)))


def polygons_as_wkb(xy, start):
    """Write polygons of one ring each.

    Parameters
    ----------
    xy : ndarray, shape (n_vertices, 2)
        Vertices, one polygon after another, the first vertex not repeated.
    start : ndarray of int, shape (n_polygons + 1,)
        First vertex of each polygon; fewer than three give a missing geometry.

    Returns
    -------
    pyarrow.BinaryArray
    """
    size = np.diff(start)
    is_area = size >= SMALLEST_RING
    size = np.where(is_area, size + 1, 0)  # a ring ends where it begins
    n_bytes = np.where(is_area, RING_HEAD.itemsize + 16 * size, 0)
    offsets = np.concatenate([[0], np.cumsum(n_bytes)])
    data = np.zeros(offsets[-1], dtype=np.uint8)
    heads = np.zeros(len(size), dtype=RING_HEAD)
    heads["order"], heads["kind"] = LITTLE_ENDIAN, POLYGON
    heads["n_rings"], heads["size"] = 1, size
    head_bytes = heads.view(np.uint8).reshape(len(size), RING_HEAD.itemsize)
    _put(data, offsets[:-1][is_area], head_bytes[is_area])
    polygon = np.repeat(np.arange(len(size)), size)
    rank = np.arange(len(polygon)) - np.repeat(np.cumsum(size) - size, size)
    vertex = start[polygon] + rank % np.maximum(size[polygon] - 1, 1)
    ring = np.ascontiguousarray(xy[vertex], dtype="<f8")
    places = offsets[polygon] + RING_HEAD.itemsize + 16 * rank
    _put(data, places, ring.view(np.uint8).reshape(len(polygon), 16))
    return _array(data, offsets, is_area)


def _put(data, places, parts):
    data[places[:, None] + np.arange(parts.shape[1])] = parts


def _fixed(records, is_known):
    records["order"] = LITTLE_ENDIAN
    offsets = np.arange(len(records) + 1) * records.dtype.itemsize
    return _array(records.view(np.uint8), offsets, is_known)


def _array(data, offsets, is_known):
    buffers = [None, pa.py_buffer(offsets.astype(np.int64)), pa.py_buffer(data)]
    whole = pa.Array.from_buffers(pa.large_binary(), len(is_known), buffers)
    return pc.if_else(pa.array(is_known), whole, None).cast(pa.binary())
