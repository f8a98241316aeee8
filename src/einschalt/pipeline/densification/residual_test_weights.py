"""How precise the identical points of a low-flight model are, for tests of residuals.

A residual holds the measuring error of the point and the error of its approximate
coordinates. Of the latter, what neighbouring points share is taken up by the model's
transformation; what remains is the mean of the measuring errors of the high flight,
which is small for a point of four models and large for a point of one.
"""

import numpy as np

from einschalt.foundations.batches import segment_sum, segments
from einschalt.foundations.names import encode
from einschalt.foundations.units import ground_from_image_um
from einschalt.theory.adjustment.correlated_mean import squared_sizes


def residual_test_weights(block, flights, high):
    """Weight of each low-flight point in the tests of residuals.

    Shape (n_model_points,), in proportion to 1 / σ², their mean 1; None where nothing
    tells the points apart.
    """
    if high is None:
        return None
    low_points = flights["low_flight"].model_points
    low = _on_ground(block.low_flight, low_points)
    approximate = _noise_of_means(block, flights["high_flight"].model_points, high)
    names = encode(high.points["point_id"])
    points = encode(low_points["point_id"])
    place = names.locate(points)[points.codes]
    # a point without approximate coordinates is not fitted: its weight is not used
    variance = low**2 + np.where(place >= 0, approximate[place], approximate.mean())
    weight = 1.0 / variance
    return weight / weight.mean()


def _noise_of_means(block, model_points, high):
    """Variance of each approximate point from the measuring errors of its values."""
    means = high.means
    error = _on_ground(block.high_flight, model_points)[means.row_numbers]
    points = encode(means.points["point_id"])
    used = encode(means.used["point_id"])
    sort = segments(points.locate(used)[used.codes], len(points))
    weights = means.weights[sort.order]
    squares = segment_sum(squared_sizes(weights) * error[sort.order] ** 2, sort.start)
    if weights.ndim > 1:
        return squares
    return squares / segment_sum(weights, sort.start) ** 2


def _on_ground(flight, model_points):
    m_g_um = flight.m_g_um_of(model_points)
    return ground_from_image_um(m_g_um, flight.scale_number)
