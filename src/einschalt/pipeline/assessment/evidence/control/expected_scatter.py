"""How far values and residuals lie apart where nothing is wrong, by the propagation.

Points of a weak model of the high flight are off by much more than others, and what
the low flight makes of them scatters with them: it is no gross error.
"""

import numpy as np

from einschalt.foundations.batches import segment_sum, segments
from einschalt.foundations.names import encode, is_among
from einschalt.stages.correlated_residuals import (
    NumberedPoints,
    design_of,
    model_covariances,
)
from einschalt.stages.error_propagation.covariances import (
    SharedCovariances,
    covariances_of_pairs,
    propagate,
)
from einschalt.stages.error_propagation.operators import mean_operator
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.point_operator import N_PLAN, selection


def expected_spread(examined, point_ids):
    """Root mean square of the ``spread_total`` that points would have by chance [m].

    (n_points,), in the order of ``point_ids``; NaN where errors are not propagated.
    """
    model = examined.propagation
    if model is None:
        return np.full(len(point_ids), np.nan)
    means = examined.means
    n_values, axes = model.low.measured.n_points, model.axes
    names = encode(means.points["point_id"])
    used = encode(means.used["point_id"])
    of_used = names.locate(used)[used.codes]
    rows = np.flatnonzero(is_among(means.used["point_id"], point_ids))
    mean = mean_operator(means, np.arange(n_values), n_values, axes)
    of_point = selection(of_used[rows], len(names), axes) @ mean
    each = selection(means.row_numbers[rows], n_values, axes)
    apart = (each - of_point.formed()).formed()
    chains = {name: apart @ chain for name, chain in model.chains_to_values.items()}
    errors = propagate(rows, chains, model.standard_errors)
    squares = np.trace(errors.covariance[:, :N_PLAN, :N_PLAN], axis1=1, axis2=2)
    sort = segments(of_used[rows], len(names))
    sums, count = segment_sum(squares[sort.order], sort.start), sort.count
    spread = np.sqrt(sums / np.where(count > 1, count - 1, np.nan))
    asked = encode(point_ids)
    return spread[names.locate(asked)[asked.codes]]


def expected_m_0(examined, flight, models):
    """Root mean square of the ``m_0`` that models would have by chance [m].

    ``models`` are places among those that were fitted; (n_models,), NaN where errors
    are not propagated, or points are too many for their covariances.
    """
    model = examined.propagation
    if model is None:
        return np.full(len(models), np.nan)
    fitted = examined.low if model.is_last(flight) else examined.high.transformation
    observed, fit = fitted.observed, fitted.fit
    chains, known = model.chains_to_fits(flight, observed), SharedCovariances()

    def covariances(pairs):
        return covariances_of_pairs(chains, model.standard_errors, pairs, known)

    of_all = np.full(len(observed.start) - 1, np.nan)
    rows = np.arange(len(observed.row_numbers))
    points = NumberedPoints.of(observed, observed.weights, rows)
    asked = np.unique(models)
    for some, own, covariance in model_covariances(points, asked, covariances):
        design = design_of(fit, some, points, own)
        mean_square = _mean_square(design, points.weights[own], covariance)
        of_all[some] = SQRT2 * np.sqrt(mean_square)
    return of_all[models]


def _mean_square(design, weights, covariance):
    """Mean of s_0² of fits with other weights than the covariances have [m²].

    Of models of as many points, stacked.
    """
    n_models, n_points, n_axes, n_parameters = design.shape
    root = np.repeat(np.sqrt(weights), n_axes, axis=1)[:, :, None]
    weighed_design = root * design.reshape(n_models, -1, n_parameters)
    basis = np.linalg.qr(weighed_design)[0]
    weighed = root * covariance * np.swapaxes(root, 1, 2)
    taken_up = np.sum(basis * (weighed @ basis), axis=(1, 2))
    redundancy = n_points * n_axes - n_parameters
    return (np.trace(weighed, axis1=1, axis2=2) - taken_up) / redundancy
