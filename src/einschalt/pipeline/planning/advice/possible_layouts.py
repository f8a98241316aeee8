"""Which combinations of a search can be laid out at all."""

import numpy as np

from einschalt.foundations.errors import GeometryError, SettingsError
from einschalt.pipeline.planning.area.layout import (
    MOST_MODELS,
    largest_scale,
    models_over,
    widest_spacing,
)
from einschalt.pipeline.simulation.geometry import RANGES

SCALES = RANGES["low_scale_number"]


def of_possible_scales(given, extent):
    """Leave out combinations of scales that no layout over an area can have.

    ``given`` has scale_number and high_over_low, (n,); ``extent``: see :func:`fits_in`.
    """
    if extent is None:
        return given
    high = given["scale_number"] * given["high_over_low"]
    is_possible = (given["scale_number"] >= SCALES.low) & (high <= SCALES.high)
    return {name: values[is_possible] for name, values in given.items()}


def require_possible(given, frame):
    """Give the combinations that a layout can have, with the overlaps of a frame.

    SettingsError where it can have none with these, GeometryError where none is left.
    """
    for name in ("forward_overlap", "side_overlap"):
        value, allowed = getattr(frame, name), RANGES[name]
        if value not in allowed:
            raise SettingsError(f"{name} = {value:g}", expected=str(allowed))
    possible = of_possible_scales(given, frame.extent)
    if not len(possible["scale_number"]):
        low = given["scale_number"]
        high = low * given["high_over_low"]
        raise GeometryError(
            f"scale numbers from {low.min():g} to {high.max():g} in both flights",
            expected=f"{SCALES}",
            remedy="Give --scale-number within; --max-height must leave room for it",
        )
    return possible


def fits_in(columns, extent, model):
    """Tell which combinations an area takes: models neither too many nor too large.

    ``columns`` has scale_number, spacing and n_coverages, (n,); ``extent``: length,
    width and size of the area [m, m, m²], None where it is endless.
    """
    scale_number, spacing = columns["scale_number"], columns["spacing"]
    if extent is None:
        return np.ones(len(scale_number), dtype=bool)
    width, size = min(extent[:2]), extent[2]
    n_models = models_over(size, model, scale_number, columns["n_coverages"])
    is_large_enough = scale_number <= largest_scale(width, size, model)
    is_close_enough = spacing <= widest_spacing(width, size)
    return (n_models <= MOST_MODELS) & is_large_enough & is_close_enough
