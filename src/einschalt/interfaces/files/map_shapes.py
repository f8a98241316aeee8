"""Shapes of map layers as well-known binary, the form in which Arrow carries them."""

import numpy as np
import pyarrow as pa


def points(xy):
    """Write points (n, 2); NaN gives a missing geometry, here and below."""
    return _as_wkb(_shapes("points", xy))


def lines(xy):
    """Write lines (n, n_vertices, 2)."""
    return _as_wkb(_shapes("linestrings", xy))


def polygons(xy):
    """Write polygons of one ring each (n, n_vertices, 2), not closed."""
    return _as_wkb(_shapes("polygons", xy))


def hulls(xy, group, n_groups):
    """Write the convex hulls of points (n_points, 2) by their ascending group.

    Rings run anticlockwise from the westernmost vertex; missing where the points of a
    group enclose nothing.
    """
    import shapely  # noqa: PLC0415 - loaded when a file is written

    held = np.full(n_groups, None)
    shapely.multipoints(_shapes("points", xy), indices=group, out=held)
    # normalised: equal points give equal bytes, whatever order they came in
    outlines = shapely.reverse(shapely.normalize(shapely.convex_hull(held)))
    is_area = shapely.get_type_id(outlines) == shapely.GeometryType.POLYGON
    return _as_wkb(np.where(is_area, outlines, None))


def _shapes(kind, xy):
    import shapely  # noqa: PLC0415 - loaded when a file is written

    shapes = np.full(len(xy), None)
    is_known = np.isfinite(xy).all(axis=tuple(range(1, xy.ndim)))
    shapes[is_known] = getattr(shapely, kind)(xy[is_known])
    return shapes


def _as_wkb(shapes):
    import shapely  # noqa: PLC0415 - loaded when a file is written

    return pa.array(shapely.to_wkb(shapes, byte_order=1), pa.binary())


def shapes(given):
    """Write shapes of shapely as they are."""
    return _as_wkb(given)
