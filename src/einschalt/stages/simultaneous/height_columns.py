"""What spatial models add to the tables of a simultaneous adjustment: heights."""

import numpy as np
import pandas as pd

from einschalt.theory.adjustment.reliability import (
    external_reliability,
    minimal_detectable_bias,
    redundancy_numbers,
)

CENTRE_COLUMNS = [
    *("flight", "image_id", "easting", "northing", "height"),
    *("standard_error_easting", "standard_error_northing", "standard_error_height"),
    "n_models",
]


def with_heights_of_points(points, solution, covariance) -> pd.DataFrame:
    """Points with heights, their standard errors and covariances."""
    points = points.assign(
        standard_error_height=np.sqrt(covariance[:, 2, 2]),
        covariance_eh=covariance[:, 0, 2],
        covariance_nh=covariance[:, 1, 2],
        difference_height=solution.control_residuals[:, 2],
    )
    points.insert(3, "height", solution.points[:, 2])
    return points


def with_heights_of_residuals(residuals, solution, observations) -> pd.DataFrame:
    """Residuals in height, and what stays undetected there.

    ``observations`` have the standard errors that were given.
    """
    r = redundancy_numbers(solution.leverage[:, 2])
    bias = minimal_detectable_bias(observations.standard_error[:, 2], r)
    residuals = residuals.assign(
        redundancy_number_height=r,
        minimal_detectable_bias_height=bias,
        external_reliability_height=remaining_bias(bias, r),
    )
    place = residuals.columns.get_loc("residual_northing") + 1
    residuals.insert(place, "residual_height", solution.residuals[:, 2])
    return residuals


def remaining_bias(bias, r):
    """What of a gross error that stays undetected goes into the point itself.

    ``bias`` is the minimal detectable one [m], ``r`` the redundancy number.
    """
    # where nothing checks an observation, all of its error stays
    finite = np.where(np.isfinite(bias), bias, 0.0)
    return np.where(np.isfinite(bias), external_reliability(finite, r), np.inf)


def centre_table(points, is_centre) -> pd.DataFrame:
    """Adjusted projection centres.

    flight, image_id, easting, northing, height, standard errors, n_models [m].
    """
    if not is_centre.any():
        return pd.DataFrame(columns=CENTRE_COLUMNS)
    names = points.loc[is_centre, "point_id"].str.partition(" ")
    centres = points[is_centre].assign(flight=names[0], image_id=names[2])
    return centres[CENTRE_COLUMNS].reset_index(drop=True)
