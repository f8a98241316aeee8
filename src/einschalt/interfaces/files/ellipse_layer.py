"""The layer of confidence ellipses in block.gpkg."""

import numpy as np

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.frame_columns import (
    columns_of,
    joined,
    values_of,
    with_columns,
)
from einschalt.foundations.units import RADIANS_PER_GON
from einschalt.interfaces.files import map_shapes
from einschalt.interfaces.files.map_layers import Layer, exaggeration
from einschalt.theory.adjustment.ellipses import Ellipses, ellipse_outlines


def require_scale(ellipse_scale):
    """Refuse a factor with which no ellipse can be drawn."""
    if ellipse_scale is None or 0.0 < ellipse_scale < np.inf:
        return
    raise SettingsError(
        f"ellipse_scale = {ellipse_scale!r}",
        expected="a positive factor",
        remedy="Leave it out for one that suits the map",
    )


def ellipse_layer(result, ellipse_scale=None) -> Layer:
    """Draw the confidence ellipses of a result, so much larger that they are seen.

    A round factor where no scale is said; no rows where the errors were not propagated.
    """
    roles = columns_of(result.points, ["point_id", "role"])
    table = joined(result.ellipses, roles, "point_id")
    xy = values_of(table, ["easting", "northing"])
    axes = values_of(table, ["semi_major", "semi_minor"])
    factor = ellipse_scale or exaggeration(xy, axes * [1.0, 0.0])
    azimuth = table["azimuth_gon"].to_numpy(dtype=float) * RADIANS_PER_GON
    outlines = ellipse_outlines(xy, Ellipses(*(factor * axes).T, azimuth))
    return Layer(
        "ellipses",
        with_columns(table, exaggeration=factor),
        map_shapes.polygons(outlines),
        "Polygon",
        f"Confidence ellipses, drawn {factor:g} times as large",
    )
