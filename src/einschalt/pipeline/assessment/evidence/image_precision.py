"""How precise image points are, from the residuals of relative orientation."""

import numpy as np

from einschalt.foundations.units import METRES_PER_MM, METRES_PER_UM
from einschalt.pipeline.assessment.evidence.variance_components import Component
from einschalt.theory.adjustment.least_squares import SQRT2, pool_standard_errors

UM_PER_MM = METRES_PER_MM / METRES_PER_UM
# an image point lies in two models at most of its strip: their residuals repeat it
MODELS_OF_IMAGE = 2


def common_sigma_0(rows):
    """RMS of the sigma_0 of models [mm], by redundancy, and their redundancy."""
    known = rows[np.isfinite(rows["sigma_0"].to_numpy(dtype=float))]
    redundancy = known["redundancy"].to_numpy(dtype=float)
    sigma_0 = known["sigma_0"].to_numpy(dtype=float)
    return pool_standard_errors(sigma_0, redundancy), float(redundancy.sum())


def image_component(rows, flight) -> Component:
    """Compare the given m_g of a flight's image points with what residuals show.

    TOTAL [µm]; NaN without redundancy. It sees y-parallax only.
    """
    sigma_0, redundancy = common_sigma_0(rows)
    shown = SQRT2 * sigma_0 * UM_PER_MM
    if not redundancy:
        return Component(flight.m_g_um, np.nan, np.nan)
    error = shown * np.sqrt(MODELS_OF_IMAGE / (2.0 * redundancy))
    return Component(flight.m_g_um, float(shown), float(error))
