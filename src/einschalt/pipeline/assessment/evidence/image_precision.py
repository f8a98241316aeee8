"""How precise image points are, from the residuals of relative orientation."""

import numpy as np

from einschalt.foundations.tables import with_coverage
from einschalt.foundations.units import METRES_PER_MM, METRES_PER_UM
from einschalt.pipeline.assessment.evidence.variance_components import Component
from einschalt.stages.relative_orientation.shown_errors import MODELS_OF_IMAGE
from einschalt.stages.stage2_relative_orientation import image_pairs
from einschalt.theory.adjustment.heavy_tails import find_heavy_tails
from einschalt.theory.adjustment.least_squares import SQRT2, pool_standard_errors
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

UM_PER_MM = METRES_PER_MM / METRES_PER_UM
WEIGHED_DOWN = ("huber", "tukey")
IMAGE_RESIDUALS = [
    f"residual_{name}" for name in ("x_left", "y_left", "x_right", "y_right")
]


def error_of_orientations(orientations, flight):
    """What errors of orientations leave in a model of a flight, RMS [µm]; 0 without."""
    rows = orientations["flight"] == flight
    errors = orientations.loc[rows, "m_g_orientation_um"].to_numpy(dtype=float)
    errors = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(errors**2))) if len(errors) else 0.0


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
        name: _tails_of_flight(flight)
        for name, flight in examined.block.flights.items()
        if flight.has_images and _may_have_tails(rows[rows["flight"] == name])
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


def _may_have_tails(rows):
    """Whether residuals look like it, however the models were oriented."""
    if rows.empty:
        return False
    length = np.sqrt((rows[IMAGE_RESIDUALS].to_numpy(dtype=float) ** 2).sum(axis=1))
    number = rows["redundancy_number"].to_numpy(dtype=float)
    is_free = number > 0.0
    return _is_sure(find_heavy_tails(length[is_free] / np.sqrt(number[is_free])))


def _tails_of_flight(flight):
    """Tails of the image points by orientations in which all of them weigh alike."""
    # imported where photographs are oriented: other blocks do not wait for it
    from einschalt.stages.relative_orientation.orient_from_images import (  # noqa: PLC0415
        orient_from_images,
    )
    from einschalt.theory.relative_orientation.tails_of_pairs import (  # noqa: PLC0415
        LEAST_FAR_OUT,
        find_tails_of_pairs,
    )

    oriented = orient_from_images(
        image_pairs(flight.image_coordinates(), with_coverage(flight.models)),
        flight.principal_distance_mm,
    )
    tails = find_tails_of_pairs(oriented.points, oriented.pairs.orientation)
    return tails if _is_sure(tails) and tails.far_out > LEAST_FAR_OUT else None


def _is_sure(tails):
    return tails is not None and tails.p_value < FINDING_SIGNIFICANCE


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
