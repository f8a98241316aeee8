"""How precise the identical points of a low-flight model are, for tests of residuals.

A residual holds the measuring error of the point and the error of its approximate
coordinates. Of the latter, what neighbouring points share is mostly taken up by the
model's transformation; what remains is the mean of the measuring errors of the high
flight, which is small for a point of four models and large for a point of one.

It is not taken up where the points of a low-flight model lie in different models of the
high flight and one of these has little control. Weights know nothing of it, covariances
do: by these the models are tested in which something stands out.
"""

from functools import cached_property

import numpy as np

from einschalt.foundations.batches import segment_sum, segments
from einschalt.foundations.names import encode
from einschalt.foundations.units import ground_from_image_um
from einschalt.stages.error_propagation.covariances import (
    SharedCovariances,
    covariances_of_pairs,
)
from einschalt.stages.stage4_error_propagation import (
    model_of_known_high_errors,
    obstacle_to_propagation,
)
from einschalt.theory.adjustment.correlated_mean import squared_sizes
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.point_operator import N_PLAN


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


def residual_test_covariances(block, flights, high):
    """Covariances of the errors behind the residuals of low-flight points.

    A function of pairs of rows of their table, (n_pairs, 2), that gives (n_pairs, 2, 2)
    [m²]: of the approximate coordinates, by the propagation of the high flight, and of
    the measuring errors. None where the former cannot be propagated.
    """
    if high is None or obstacle_to_propagation(block):
        return None
    return _ResidualCovariances(block, flights, high)


class _ResidualCovariances:
    """The model of the errors of means is made only where something stands out."""

    def __init__(self, block, flights, high):
        self._block, self._flights, self._high = block, flights, high

    def __call__(self, pairs):
        if self._means is None:  # a size that only the computation could tell
            return np.full((len(pairs), N_PLAN, N_PLAN), np.nan)
        chains, errors = self._means
        found = covariances_of_pairs(chains, errors, self._place[pairs], self._known)
        found = found[:, :N_PLAN, :N_PLAN]
        same = np.flatnonzero(pairs[:, 0] == pairs[:, 1])
        own = self._measured[pairs[same, 0], None, None]
        found[same] += own * np.eye(N_PLAN)
        return found

    @cached_property
    def _means(self):
        """Chains to the approximate coordinates, and errors, or None."""
        block, high = self._block, self._high
        how = self._flights["high_flight"], high.transformation
        model = model_of_known_high_errors(block, *how)
        if model is None:
            return None
        return model.with_means(high.means).chains, model.standard_errors

    @cached_property
    def _known(self):
        return SharedCovariances()

    @cached_property
    def _place(self):
        """Approximate point of each low-flight point."""
        names = encode(self._flights["low_flight"].model_points["point_id"])
        return encode(self._high.points["point_id"]).locate(names)[names.codes]

    @cached_property
    def _measured(self):
        """Variance of each low-flight measurement, of one coordinate [m²]."""
        points = self._flights["low_flight"].model_points
        return (_on_ground(self._block.low_flight, points) / SQRT2) ** 2


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
