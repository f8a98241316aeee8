"""Affine transformation of each model: E = a0 + a1 x + a2 y, N = b0 + b1 x + b2 y.

Six parameters, at least three points that are not on a line. It absorbs a different
film scale along and across the flight, and is Kovarik's choice for that reason.
"""

import numpy as np

from einschalt.foundations.kernels import compiled
from einschalt.theory.transformation.plane_fit import (
    PlaneSolution,
    assemble_fit,
    plane_moments,
)

LEAST_POINTS = 3
THINNEST = 1e-10


def fit_affine(xy, en, weights, start):
    """Fit one affine transformation per model to all of its points.

    Least squares on the ground coordinates, independent points, equal weight of both
    coordinates of a point. Easting and northing share one normal matrix.

    Parameters
    ----------
    xy : ndarray, shape (n_points, 2)
        Model coordinates, sorted by model.
    en : ndarray, shape (n_points, 2)
        Easting, northing [m].
    weights : ndarray, shape (n_points,)
        Positive weights.
    start : ndarray of int, shape (n_models + 1,)
        Model k owns rows ``start[k]:start[k + 1]``.

    Returns
    -------
    PlaneFit
        A model with fewer than three points, or with all points within 10⁻⁵ of its
        extent of a line or ground points in one place, has NaN and a ``status`` that
        is not USABLE.

    Notes
    -----
    Leverage n·h is 1 in the centre, 4 in the middle of an edge and 7 in the corner of
    an evenly filled rectangle (docs/theory/transformation.md).

    Examples
    --------
    Three points give a transformation, but say nothing of its precision:

    >>> xy = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    >>> fit = fit_affine(xy, 2 * xy + 5, np.ones(3), np.array([0, 3]))
    >>> fit.parameters[0].round(12).tolist(), fit.s_0.tolist()
    ([5.0, 2.0, 0.0, 5.0, 0.0, 2.0], [nan])
    """
    moments = plane_moments(xy, en, weights, start)
    # 4 det / trace² is the ratio of the two principal moments where it is small
    is_plane = 4.0 * moments.determinant > THINNEST * moments.polar**2
    status = moments.status(LEAST_POINTS, moments.is_spread & is_plane)
    inverse, linear = _solve(moments.model_model, moments.model_ground, status)
    return assemble_fit(
        "affine",
        (xy, en, weights, start),
        moments,
        PlaneSolution.alike(linear, inverse, status),
        _parameters(moments, linear),
        np.full(len(status), np.nan),
    )


def affine_cofactors(fit):
    """Cofactors (n_models, 6, 6) of a0 to b2 at the origin of the model coordinates.

    Times s_0² they are the covariance of the parameters.
    """
    half = affine_axis_cofactors(fit)
    cofactors = np.zeros((len(half), 6, 6))
    cofactors[:, :3, :3] = cofactors[:, 3:, 3:] = half
    return cofactors


def affine_axis_cofactors(fit):
    """Cofactors (n_models, 3, 3) of a0, a1, a2, which are also those of b0, b1, b2.

    The two axes share their normal matrix and are uncorrelated.
    """
    inverse, centre = fit.solution.spread_east, fit.centroid_model
    x, y = centre.T
    half = np.empty((len(x), 3, 3))
    half[:, 1:, 1:] = inverse
    to_x = -(inverse[:, 0, 0] * x + inverse[:, 0, 1] * y)
    to_y = -(inverse[:, 0, 1] * x + inverse[:, 1, 1] * y)
    half[:, 0, 1] = half[:, 1, 0] = to_x
    half[:, 0, 2] = half[:, 2, 0] = to_y
    half[:, 0, 0] = 1.0 / fit.moments.weight_sum - to_x * x - to_y * y
    return half


def _parameters(moments, linear):
    x, y = moments.centroid_model.T
    parameters = np.empty((len(x), 6))
    for axis in (0, 1):
        to_x, to_y = linear[:, axis, 0], linear[:, axis, 1]
        shift = moments.centroid_ground[:, axis] - to_x * x - to_y * y
        parameters[:, 3 * axis] = shift
        parameters[:, 3 * axis + 1], parameters[:, 3 * axis + 2] = to_x, to_y
    return parameters


@compiled(error_model="numpy")
def _solve(model_model, model_ground, status):
    """Inverse of Σ w d dᵀ and the matrix A; NaN where a model is not usable."""
    inverse, linear = np.empty_like(model_model), np.empty_like(model_model)
    for k in range(len(status)):
        xx, yy = model_model[k, 0, 0], model_model[k, 1, 1]
        x_y = model_model[k, 0, 1]
        determinant = xx * yy - x_y * x_y if status[k] == 0 else np.nan
        i_xx, i_yy, i_xy = yy / determinant, xx / determinant, -x_y / determinant
        inverse[k, 0, 0], inverse[k, 1, 1] = i_xx, i_yy
        inverse[k, 0, 1] = inverse[k, 1, 0] = i_xy
        for axis in range(2):
            s_x, s_y = model_ground[k, 0, axis], model_ground[k, 1, axis]
            linear[k, axis, 0] = i_xx * s_x + i_xy * s_y
            linear[k, axis, 1] = i_xy * s_x + i_yy * s_y
    return inverse, linear
