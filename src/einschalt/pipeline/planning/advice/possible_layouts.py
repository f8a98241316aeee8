"""Which combinations of a search can be laid out at all."""

import numpy as np

from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.planning.area.layout import (
    FEWEST_POINTS,
    FEWEST_ROWS,
    MOST_MODELS,
)
from einschalt.pipeline.planning.flight_design import usable_model
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


def require_possible_scales(given, extent):
    """Do the same; GeometryError where none is left."""
    possible = of_possible_scales(given, extent)
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
    (along, across), width, size = model.image_format, min(extent[:2]), extent[2]
    neat = (1.0 - model.forward_overlap) * along * (1.0 - model.side_overlap) * across
    n_models = columns["n_coverages"] * size / (neat * scale_number**2)
    usable = usable_model(model)
    largest = min(2.0 * width / min(usable), np.sqrt(2.0 * size / np.prod(usable)))
    widest = min(width / FEWEST_ROWS, np.sqrt(size / FEWEST_POINTS))
    is_few = n_models <= MOST_MODELS
    return is_few & (scale_number <= largest) & (spacing <= widest)
