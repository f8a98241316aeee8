"""Points of a result for geopandas."""

from typing import TYPE_CHECKING

import numpy as np

from einschalt.foundations.extras import imported
from einschalt.foundations.frame_columns import PLAN
from einschalt.foundations.projections import read_crs

if TYPE_CHECKING:
    import geopandas


def points_with_geometry(result) -> "geopandas.GeoDataFrame":
    """Points of a result with their geometries and their reference system."""
    geopandas = imported("geopandas", "a GeoDataFrame", extra="notebook")
    points = result.points
    crs = None if result.crs is None else read_crs(result.crs)
    return geopandas.GeoDataFrame(points, geometry=_shapes(points), crs=crs)


def _shapes(points):
    """Points in space where a height is known, else in plan; None without a place."""
    import shapely  # noqa: PLC0415 - loaded when it is needed

    shapes = np.full(len(points), None)
    columns = [*PLAN, "height"] if "height" in points else PLAN
    xyz = points[columns].to_numpy(dtype=float)
    in_plan = np.isfinite(xyz[:, :2]).all(axis=1)
    in_space = np.isfinite(xyz).all(axis=1) & (xyz.shape[1] == 3)
    flat = in_plan & ~in_space
    shapes[flat] = shapely.points(xyz[flat, :2])
    shapes[in_space] = shapely.points(xyz[in_space])
    return shapes
