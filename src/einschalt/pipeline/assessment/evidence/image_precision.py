"""How precise image points are, from the residuals of relative orientation."""

import numpy as np

from einschalt.foundations.units import METRES_PER_MM, METRES_PER_UM
from einschalt.pipeline.assessment.evidence.variance_components import Component
from einschalt.theory.adjustment.heavy_tails import find_heavy_tails
from einschalt.theory.adjustment.least_squares import SQRT2, pool_standard_errors
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

UM_PER_MM = METRES_PER_MM / METRES_PER_UM
# an image point lies in two models at most of its strip: their residuals repeat it
MODELS_OF_IMAGE = 2
# a smaller share far out changes nothing that anyone would do
LEAST_FAR_OUT = 0.01
WEIGHED_DOWN = ("huber", "tukey")
IMAGE_RESIDUALS = [
    f"residual_{name}" for name in ("x_left", "y_left", "x_right", "y_right")
]


def common_sigma_0(rows):
    """RMS of the sigma_0 of models [mm], by redundancy, and their redundancy."""
    known = rows[np.isfinite(rows["sigma_0"].to_numpy(dtype=float))]
    redundancy = known["redundancy"].to_numpy(dtype=float)
    sigma_0 = known["sigma_0"].to_numpy(dtype=float)
    return pool_standard_errors(sigma_0, redundancy), float(redundancy.sum())


def find_image_tails(examined):
    """Flights of whose image points a share is much worse than the others.

    Dict of flight to HeavyTails [mm], of what the residuals make sure.
    """
    rows = examined.orientation_residuals
    found = {
        name: _tails_of(rows[rows["flight"] == name])
        for name, flight in examined.block.flights.items()
        if flight.has_images and len(rows)
    }
    return {name: tails for name, tails in found.items() if tails is not None}


def good_sigma_0(examined, name):
    """Standard error of the good image coordinates [mm], where others weigh less.

    None where all points of the flight weigh alike, or are alike.
    """
    tails = examined.image_tails.get(name)
    if tails is None or examined.settings.outliers not in WEIGHED_DOWN:
        return None
    return tails.sigma


def _tails_of(rows):
    length = np.sqrt((rows[IMAGE_RESIDUALS].to_numpy(dtype=float) ** 2).sum(axis=1))
    number = rows["redundancy_number"].to_numpy(dtype=float)
    is_free = number > 0.0
    tails = find_heavy_tails(length[is_free] / np.sqrt(number[is_free]))
    if tails is None or not tails.p_value < FINDING_SIGNIFICANCE:
        return None
    return tails if tails.far_out > LEAST_FAR_OUT else None


def image_component(rows, flight, of_good=None) -> Component:
    """Compare the given m_g of a flight's image points with what residuals show.

    TOTAL [µm]; NaN without redundancy. It sees y-parallax only. Where the worse of the
    points have less weight, ``of_good`` is the sigma_0 of the others [mm].
    """
    sigma_0, redundancy = common_sigma_0(rows)
    sigma_0 = sigma_0 if of_good is None else of_good
    shown = SQRT2 * sigma_0 * UM_PER_MM
    if not redundancy:
        return Component(flight.m_g_um, np.nan, np.nan)
    error = shown * np.sqrt(MODELS_OF_IMAGE / (2.0 * redundancy))
    return Component(flight.m_g_um, float(shown), float(error))
