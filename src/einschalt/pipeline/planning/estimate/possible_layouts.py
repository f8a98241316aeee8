"""Which combinations of a search can be laid out at all."""

import numpy as np

from einschalt.foundations.errors import GeometryError, SettingsError
from einschalt.pipeline.planning.flights.flight_design import usable_model
from einschalt.pipeline.simulation.geometry import RANGES

SCALES = RANGES["low_scale_number"]
MOST_MODELS = 20_000
FEWEST_POINTS, FEWEST_ROWS = 12, 3
ROUNDED = 1.0 + 1e-6  # of sizes: of what just fits, and is advised


def of_possible_scales(given):
    """Leave out combinations of scales that no layout can have.

    ``given`` has scale_number and high_over_low, (n,).
    """
    low = given["scale_number"]
    is_possible = are_possible(low, low * given["high_over_low"])
    return {name: values[is_possible] for name, values in given.items()}


def are_possible(low, high):
    """Tell which scale numbers of both flights a layout can have."""
    return (low >= SCALES.low) & (high <= SCALES.high)


def require_possible(given, frame):
    """Give the combinations that a layout can have, with the overlaps of a frame.

    SettingsError where it can have none with these, GeometryError where none is left.
    """
    for name in ("forward_overlap", "side_overlap"):
        value, allowed = getattr(frame, name), RANGES[name]
        if value not in allowed:
            raise SettingsError(f"{name} = {value:g}", expected=str(allowed))
    possible = of_possible_scales(given)
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


def models_over(size, model, scale_number, n_coverages):
    """Estimate how many models of the low flight an area takes, ``size`` [m²]."""
    along, across = model.image_format
    neat = (1.0 - model.forward_overlap) * along * (1.0 - model.side_overlap) * across
    return n_coverages * size / (neat * scale_number**2)


def largest_scale(width, size, model):
    """Scale number of the largest model of the low flight that an area takes.

    As far as an area may be narrower than a model, ``width`` [m], or smaller, [m²].
    """
    usable = usable_model(model)
    largest = min(2.0 * width / min(usable), np.sqrt(2.0 * size / np.prod(usable)))
    return ROUNDED * largest


def widest_spacing(width, size):
    """Largest distance of points that gives an area enough of them [m]."""
    return ROUNDED * min(width / FEWEST_ROWS, np.sqrt(size / FEWEST_POINTS))
