"""Rigid transformation: rotation θ and shift, the scale held at 1.

Three parameters, at least two points: E = x cos θ − y sin θ + te,
N = x sin θ + y cos θ + tn. Coordinates must already have the scale of the ground.
"""

import numpy as np

from einschalt.theory.transformation.helmert import (
    conformal,
    correlations,
    rotation_and_scale,
)
from einschalt.theory.transformation.plane_fit import (
    OTHER_SCALE,
    USABLE,
    PlaneSolution,
    assemble_fit,
    mirror_gain,
    plane_moments,
    shift_at_origin,
    without_unusable,
)

LEAST_POINTS = 2
LARGEST_SCALE = 2.0


def fit_rigid(xy, en, weights, start):
    """Fit one rotation and shift per model to all of its points.

    The rotation is that of the Helmert transformation, in closed form; the cofactors
    are linearised about it.

    Parameters
    ----------
    xy, en, weights, start
        As in :func:`einschalt.theory.transformation.affine.fit_affine`.

    Returns
    -------
    PlaneFit
        A model with fewer than two points, with all points in one place, in the model
        or on the ground, or whose scale is more than twice or less than half that of
        the ground, has NaN and a ``status`` that is not USABLE.

    Notes
    -----
    Easting and northing have different leverages; their mean n·h is 1 in the centre
    and 2.5 in the corner of an evenly filled rectangle.
    """
    moments = plane_moments(xy, en, weights, start)
    direct, turned = correlations(moments)
    strength = np.maximum(direct, turned)
    is_determined = moments.is_spread & (strength > 0.0)
    status = moments.status(LEAST_POINTS, is_determined)
    # a scale of 1000 is a wrong unit, not an error that could be adjusted
    is_other = (strength > LARGEST_SCALE * moments.polar) | (
        strength * LARGEST_SCALE < moments.polar
    )
    status = np.where((status == USABLE) & is_other, OTHER_SCALE, status)
    with np.errstate(divide="ignore", invalid="ignore"):
        rotation = without_unusable(_rotation(moments), status)
        per_angle = 1.0 / moments.polar[:, None, None]
        # ∂E/∂θ = g_E · d and ∂N/∂θ = g_N · d for a point at d from the centroid
        g_east, g_north = -rotation[:, 1, :], rotation[:, 0, :]
        cross = _outer(g_east, g_north)
        solution = PlaneSolution(
            linear=rotation,
            spread_east=_outer(g_east, g_east) * per_angle,
            spread_north=_outer(g_north, g_north) * per_angle,
            spread_cross=0.5 * (cross + np.swapaxes(cross, 1, 2)) * per_angle,
            status=status,
        )
    angle = np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])
    gain = 2.0 * (turned - direct)
    return assemble_fit(
        "rigid",
        (xy, en, weights, start),
        moments,
        solution,
        np.column_stack([angle, shift_at_origin(moments, rotation)]),
        mirror_gain(gain, direct, turned, moments.n_points > LEAST_POINTS),
    )


def rigid_cofactors(fit):
    """Cofactors (n_models, 3, 3) of θ, te, tn at the origin of the model."""
    rotation, centre = fit.linear, fit.centroid_model
    # how te and tn at the origin change with θ, the centroid being held
    arm_east = np.einsum("mi,mi->m", rotation[:, 1, :], centre)
    arm_north = -np.einsum("mi,mi->m", rotation[:, 0, :], centre)
    arm = np.column_stack([np.ones(len(centre)), arm_east, arm_north])
    with np.errstate(divide="ignore"):
        per_angle = 1.0 / fit.moments.polar
    cofactors = per_angle[:, None, None] * _outer(arm, arm)
    cofactors[:, 1, 1] += 1.0 / fit.moments.weight_sum
    cofactors[:, 2, 2] += 1.0 / fit.moments.weight_sum
    return without_unusable(cofactors, fit.status)


def _rotation(moments):
    a, b = rotation_and_scale(moments)
    # a mirror image of a square correlates with no rotation: any does, to show it
    length = np.hypot(a, b)
    a[length == 0.0] = length[length == 0.0] = 1.0
    return conformal(a / length, b / length)


def _outer(first, second):
    return first[:, :, None] * second[:, None, :]
