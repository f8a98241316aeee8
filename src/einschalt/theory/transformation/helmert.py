"""Plane Helmert transformation: E = a x − b y + te, N = b x + a y + tn.

Four parameters (rotation, one scale, shift), at least two points. In complex numbers
it is z ↦ (a + ib) z + t, which is why easting and northing are uncorrelated.
"""

import numpy as np

from einschalt.theory.transformation.plane_fit import (
    PlaneSolution,
    assemble_fit,
    mirror_gain,
    plane_moments,
    shift_at_origin,
    without_unusable,
)

LEAST_POINTS = 2


def fit_helmert(xy, en, weights, start):
    """Fit one plane Helmert transformation per model to all of its points.

    Parameters
    ----------
    xy, en, weights, start
        As in :func:`einschalt.theory.transformation.affine.fit_affine`.

    Returns
    -------
    PlaneFit
        A model with fewer than two points, or with all points in one place, in the
        model or on the ground, has NaN and a ``status`` that is not USABLE.

    Notes
    -----
    Leverage n·h is 1 in the centre and 4 in the corner of an evenly filled rectangle.

    Examples
    --------
    >>> xy = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    >>> en = xy @ np.array([[0.0, 2.0], [-2.0, 0.0]])
    >>> fit = fit_helmert(xy, en, np.ones(3), np.array([0, 3]))
    >>> (fit.parameters[0].round(12) + 0.0).tolist()
    [0.0, 2.0, 0.0, 0.0]
    """
    moments = plane_moments(xy, en, weights, start)
    status = moments.status(LEAST_POINTS, moments.is_spread)
    linear = without_unusable(conformal(*rotation_and_scale(moments)), status)
    direct, turned = correlations(moments)
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = without_unusable(np.eye(2) / moments.polar[:, None, None], status)
        gain = (turned**2 - direct**2) / moments.polar
    shift = shift_at_origin(moments, linear)
    return assemble_fit(
        "helmert",
        (xy, en, weights, start),
        moments,
        PlaneSolution.alike(linear, spread, status),
        np.column_stack([linear[:, 0, 0], linear[:, 1, 0], shift]),
        mirror_gain(gain, direct, turned, moments.n_points > LEAST_POINTS),
    )


def rotation_and_scale(moments):
    """Parameters a, b (n_models,) of the best conformal map about the centroids."""
    s = moments.model_ground
    with np.errstate(divide="ignore", invalid="ignore"):
        a = (s[:, 0, 0] + s[:, 1, 1]) / moments.polar
        b = (s[:, 0, 1] - s[:, 1, 0]) / moments.polar
    return a, b


def correlations(moments):
    """How well the centred figures correlate as they are, and turned over.

    Largest Σ w D·(R d) over all rotations R, and over all reflections R, (n_models,).
    """
    s = moments.model_ground
    direct = np.hypot(s[:, 0, 0] + s[:, 1, 1], s[:, 0, 1] - s[:, 1, 0])
    turned = np.hypot(s[:, 0, 0] - s[:, 1, 1], s[:, 0, 1] + s[:, 1, 0])
    return direct, turned


def conformal(a, b):
    """Matrix [[a, −b], [b, a]] of each model, shape (n_models, 2, 2)."""
    return np.stack([np.stack([a, -b], -1), np.stack([b, a], -1)], -2)


def helmert_cofactors(fit):
    """Cofactors (n_models, 4, 4) of a, b, te, tn at the origin of the model."""
    x, y = fit.centroid_model.T
    per_scale = fit.solution.spread_east[:, 0, 0]
    cofactors = np.zeros((len(x), 4, 4))
    cofactors[:, 0, 0] = cofactors[:, 1, 1] = per_scale
    # shift at the origin = shift at the centroid − A · centroid
    cofactors[:, 0, 2] = cofactors[:, 2, 0] = -per_scale * x
    cofactors[:, 1, 3] = cofactors[:, 3, 1] = -per_scale * x
    cofactors[:, 1, 2] = cofactors[:, 2, 1] = per_scale * y
    cofactors[:, 0, 3] = cofactors[:, 3, 0] = -per_scale * y
    shift = 1.0 / fit.moments.weight_sum + per_scale * (x**2 + y**2)
    cofactors[:, 2, 2] = cofactors[:, 3, 3] = shift
    return cofactors
