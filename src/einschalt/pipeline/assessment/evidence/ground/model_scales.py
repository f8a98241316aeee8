"""How many metres one unit of each model is, and models that have another unit."""

import numpy as np

from einschalt.foundations.units import METRES_PER_UNIT

# models of one flight are as alike in scale as its height above ground; flights over
# mountains and models set up at another scale of the plotter stay below
LARGEST_RATIO = 2.5
FEWEST_MODELS = 4
# of the models, so that it is these that have the unit of the flight
LEAST_SHARE_OF_OTHERS = 0.75


def scales_of_models(models, flight) -> np.ndarray:
    """Metres on the ground of one unit of each model; NaN where it is not usable."""
    if flight.transformation == "rigid":
        scale = np.full(len(models), METRES_PER_UNIT[flight.model_unit])
    elif flight.transformation == "affine":
        a_1, a_2, b_1, b_2 = (models[name] for name in ("a1", "a2", "b1", "b2"))
        scale = np.sqrt(np.abs(a_1 * b_2 - a_2 * b_1))
    elif flight.transformation == "helmert":
        scale = np.hypot(models["a"], models["b"])
    else:
        scale = models["scale"]
    return np.where(models["is_usable"].to_numpy(dtype=bool), scale, np.nan)


def find_models_in_another_unit(examined):
    """Models with a scale far from that of most models of their flight.

    Rows of ``models`` with ``scale_ratio``, how many times as large as usual their
    coordinates are. Of flights with y-parallaxes only: a transformation takes the
    unit of a model as it is, but its corrections are bent if the y-parallaxes, their
    points and the base have another one.
    """
    models = examined.models
    ratio = np.ones(len(models))
    for name, flight in examined.block.flights.items():
        if flight.y_parallaxes is None:
            continue
        rows = np.flatnonzero((models["flight"] == name).to_numpy())
        ratio[rows] = _ratios(scales_of_models(models.iloc[rows], flight))
    is_other = np.abs(np.log(ratio)) > np.log(LARGEST_RATIO)
    return models[is_other].assign(scale_ratio=ratio[is_other])


def _ratios(scales):
    """Usual scale of a flight over that of each model; 1 where too few have it."""
    known = np.isfinite(scales) & (scales > 0.0)
    if known.sum() < FEWEST_MODELS:
        return np.ones(len(scales))
    ratio = np.where(
        known, np.median(scales[known]) / np.where(known, scales, 1.0), 1.0
    )
    is_usual = np.abs(np.log(ratio[known])) <= np.log(LARGEST_RATIO)
    return ratio if is_usual.mean() >= LEAST_SHARE_OF_OTHERS else np.ones(len(scales))
