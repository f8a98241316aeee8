"""Spatial Helmert transformation: ground = t + s R · model, seven parameters.

R = R_x(ω) R_y(φ) R_z(κ), right-handed. At least three points that are not on a line.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from einschalt.foundations.batches import over_segments
from einschalt.foundations.kernels import compiled
from einschalt.foundations.rotations import (
    GIMBAL_COSINE,
    angle_rates,
    angles_from_rotation,
    cross_matrix,
)
from einschalt.theory.transformation.plane_fit import (
    CentredFit,
    as_floats,
    is_spread,
    mirror_gain,
    shift_at_origin,
    status_of,
    without_unusable,
)

PARAMETER_NAMES = ("te", "tn", "th", "scale", "omega", "phi", "kappa")
LEAST_POINTS = 3
THINNEST = 1e-10


@dataclass(frozen=True, eq=False)
class SpatialFit(CentredFit):
    """Spatial Helmert transformations of all models of a flight."""

    n_points: np.ndarray  # all of int, (n_models,)
    redundancy: np.ndarray
    status: np.ndarray
    weight_sum: np.ndarray  # (n_models,): NaN for a model without points
    centroid_model: np.ndarray  # both (n_models, 3)
    centroid_ground: np.ndarray
    scale: np.ndarray  # (n_models,)
    rotation: np.ndarray  # (n_models, 3, 3)
    cofactor_scale: np.ndarray  # (n_models,)
    # (n_models, 3, 3): of small rotations about the ground axes
    cofactor_rotation: np.ndarray
    residuals: np.ndarray  # (n_points, 3): transformed minus given [m]
    leverage: np.ndarray  # (n_points, 3): of easting, northing, height
    sum_of_squares: np.ndarray  # (n_models,): Σ w |v|² over the three coordinates [m²]
    # (n_models,): by how much it would be smaller if the model were turned inside out
    # [m²]; NaN where that cannot be told
    mirror_gain: np.ndarray

    kind = "helmert_3d"
    parameter_names = PARAMETER_NAMES

    @cached_property
    def parameters(self):
        """Parameters te, tn, th, scale, ω, φ, κ, shape (n_models, 7)."""
        shift = shift_at_origin(self, self.linear)
        return np.column_stack([shift, self.scale, angles_of(self.rotation)])

    @property
    def linear(self):
        """Scale times rotation, shape (n_models, 3, 3)."""
        return self.scale[:, None, None] * self.rotation

    @property
    def inverse(self):
        """Inverse of scale times rotation, shape (n_models, 3, 3)."""
        return np.swapaxes(self.rotation, 1, 2) / self.scale[:, None, None]

    def point_cofactors(self, model, xyz):
        """Cofactors (n, 3, 3) of transformed points, from the transformation alone.

        Times s_0² they are the covariance of easting, northing, height [m²].
        """
        offset = xyz - self.centroid_model[model]
        arm = np.einsum("nij,nj->ni", self.linear[model], offset)
        turn = cross_matrix(-arm)
        radial = arm / self.scale[model][:, None]
        q = turn @ self.cofactor_rotation[model] @ np.swapaxes(turn, 1, 2)
        per_scale = self.cofactor_scale[model][:, None, None]
        q += per_scale * radial[:, :, None] * radial[:, None, :]
        q += np.eye(3) / self.weight_sum[model][:, None, None]
        return q


def fit_helmert_3d(xyz, enh, weights, start):
    """Fit one spatial Helmert transformation per model to all of its points.

    The rotation is the closed solution by singular values (Umeyama 1991), proper
    even where the points lie in a plane; cofactors are linearised about it.

    Parameters
    ----------
    xyz : ndarray, shape (n_points, 3)
        Model coordinates, sorted by model.
    enh : ndarray, shape (n_points, 3)
        Easting, northing, height [m].
    weights : ndarray, shape (n_points,)
        Positive weights, the same for the three coordinates of a point.
    start : ndarray of int, shape (n_models + 1,)

    Returns
    -------
    SpatialFit
        A model with fewer than three points, or with all points on a line or all
        ground points in one place, has NaN and a ``status`` that is not USABLE.
    """
    xyz, enh, weights = as_floats(xyz, enh, weights)
    fit = _solve(_sums(xyz, enh, weights, start), np.diff(start), xyz.shape)
    over_segments(
        _point_by_point,
        start,
        *(xyz, enh, weights),
        *(fit.weight_sum, fit.centroid_model, fit.centroid_ground),
        *(fit.scale, fit.rotation, fit.cofactor_scale, fit.cofactor_rotation),
        *(fit.residuals, fit.leverage, fit.sum_of_squares),
    )
    return fit


def helmert_3d_cofactors(fit):
    """Cofactors of te, tn, th, scale, ω, φ, κ at the origin of the model coordinates.

    (n_models, 7, 7); NaN where φ = ±90°, at which ω and κ cannot be told apart.
    """
    n_models = len(fit.scale)
    centred = np.zeros((n_models, 7, 7))
    centred[:, range(3), range(3)] = (1.0 / fit.weight_sum)[:, None]
    centred[:, 3, 3] = fit.cofactor_scale
    centred[:, 4:, 4:] = fit.cofactor_rotation
    step = parameters_from_step(fit.scale, fit.rotation, fit.centroid_model)
    return step @ centred @ np.swapaxes(step, 1, 2)


def parameters_from_step(scale, rotation, centroid):
    """How te, tn, th, scale, ω, φ, κ change with a small step about the centroid.

    Jacobian (n_models, 7, 7) by shift of the centroid, scale, and a turn about the
    ground axes; NaN where φ = ±90°. ``centroid`` (n_models, 3) is the point, in model
    coordinates, that the shift of the step moves.
    """
    turned = np.einsum("mij,mj->mi", rotation, centroid)
    step = np.zeros((len(scale), 7, 7))
    step[:, range(4), range(4)] = 1.0
    step[:, :3, 3] = -turned
    step[:, :3, 4:] = cross_matrix(turned * scale[:, None])
    step[:, 4:, 4:] = _angles_from_small_turn(rotation)
    return step


@dataclass(frozen=True, eq=False)
class _Sums:
    """Centroids and second moments Σ w d dᵀ, Σ w D dᵀ of the points of each model."""

    weight_sum: np.ndarray
    centroid_model: np.ndarray
    centroid_ground: np.ndarray
    model_model: np.ndarray
    ground_model: np.ndarray
    ground_polar: np.ndarray  # (n_models,): Σ w |D|²


def _solve(sums, n_points, shape):
    """All of the fit but its residuals, NaN where a model is not determined."""
    polar = np.trace(sums.model_model, axis1=1, axis2=2)
    rotation, strength = _best_rotation(sums.ground_model)
    direct = strength.sum(axis=1)
    turned = direct - 2.0 * strength[:, 2]
    is_determined = (
        is_spread(polar, sums.weight_sum, sums.centroid_model)
        & _is_no_line(sums.model_model)
        # where the two smaller ones cancel, a turn about the longest axis is free
        & (strength[:, 1] + strength[:, 2] > THINNEST * strength[:, 0])
    )
    ground_spread = is_spread(sums.ground_polar, sums.weight_sum, sums.centroid_ground)
    status = status_of(n_points, LEAST_POINTS, is_determined, ground_spread)
    rotation = without_unusable(rotation, status)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = without_unusable(direct / polar, status)
        cofactor_scale = without_unusable(1.0 / polar, status)
        gain = (turned**2 - direct**2) / polar
    cofactor_rotation = _rotation_cofactors(sums.model_model, scale, rotation, status)
    return SpatialFit(
        n_points=n_points,
        redundancy=np.where(status == 0, 3 * n_points - 7, 0),
        status=status,
        weight_sum=sums.weight_sum,
        centroid_model=sums.centroid_model,
        centroid_ground=sums.centroid_ground,
        scale=scale,
        rotation=rotation,
        cofactor_scale=cofactor_scale,
        cofactor_rotation=cofactor_rotation,
        residuals=np.empty(shape),
        leverage=np.empty(shape),
        sum_of_squares=np.zeros(len(n_points)),
        mirror_gain=mirror_gain(gain, direct, turned, n_points > LEAST_POINTS),
    )


def _sums(xyz, enh, weights, start):
    n_models = len(start) - 1
    sums = _Sums(
        np.full(n_models, np.nan),
        np.zeros((n_models, 3)),
        np.zeros((n_models, 3)),
        np.zeros((n_models, 3, 3)),
        np.zeros((n_models, 3, 3)),
        np.zeros(n_models),
    )
    over_segments(
        _sum_moments,
        start,
        *(xyz, enh, weights),
        *(sums.weight_sum, sums.centroid_model, sums.centroid_ground),
        *(sums.model_model, sums.ground_model, sums.ground_polar),
    )
    return sums


@compiled(error_model="numpy")
def _sum_moments(
    first, last, start, xyz, enh, weights, w_sum, c_m, c_g, s_mm, s_gm, s_gg
):
    d, big_d = np.empty(3), np.empty(3)
    for k in range(first, last):
        low, high = start[k], start[k + 1]
        if high == low:
            continue
        # twice: from the first point, then from the centroid, to keep all digits
        w, d[:], big_d[:] = 0.0, 0.0, 0.0
        for i in range(low, high):
            w += weights[i]
            for c in range(3):
                d[c] += weights[i] * (xyz[i, c] - xyz[low, c])
                big_d[c] += weights[i] * (enh[i, c] - enh[low, c])
        w_sum[k] = w
        for c in range(3):
            c_m[k, c] = xyz[low, c] + d[c] / w
            c_g[k, c] = enh[low, c] + big_d[c] / w
        for i in range(low, high):
            for c in range(3):
                d[c], big_d[c] = xyz[i, c] - c_m[k, c], enh[i, c] - c_g[k, c]
            for c in range(3):
                s_gg[k] += weights[i] * big_d[c] * big_d[c]
                for b in range(3):
                    s_mm[k, c, b] += weights[i] * d[c] * d[b]
                    s_gm[k, c, b] += weights[i] * big_d[c] * d[b]


@compiled(error_model="numpy")
def _point_by_point(
    first, last, start, xyz, enh, weights, w_sum, c_m, c_g, s, r, q_s, q_r, v, h, vv
):
    arm = np.empty(3)
    for k in range(first, last):
        total = 0.0
        for i in range(start[k], start[k + 1]):
            p = weights[i]
            x, y = xyz[i, 0] - c_m[k, 0], xyz[i, 1] - c_m[k, 1]
            z = xyz[i, 2] - c_m[k, 2]
            for c in range(3):
                arm[c] = r[k, c, 0] * x + r[k, c, 1] * y + r[k, c, 2] * z
                v[i, c] = s[k] * arm[c] - (enh[i, c] - c_g[k, c])
                total += p * v[i, c] * v[i, c]
            for c in range(3):
                # the two axes about which a turn moves this coordinate
                a, b = (c + 1) % 3, (c + 2) % 3
                q = q_r[k, a, a] * arm[b] ** 2 + q_r[k, b, b] * arm[a] ** 2
                q -= 2.0 * q_r[k, a, b] * arm[a] * arm[b]
                q = s[k] ** 2 * q + q_s[k] * arm[c] ** 2
                h[i, c] = p * (1.0 / w_sum[k] + q)
        vv[k] = total


def _is_no_line(spread):
    principal = np.linalg.eigvalsh(spread)
    return principal[:, 1] > THINNEST * principal[:, 2]


def nearest_rotations(cross):
    """Rotations that put points best onto others, (n, 3, 3).

    ``cross`` (n, 3, 3) are sums of products of their centred coordinates, those of the
    others first (Kabsch 1976).
    """
    return _best_rotation(cross)[0]


def _best_rotation(cross):
    left, singular, right = np.linalg.svd(cross)
    is_inside_out = np.linalg.det(left @ right) < 0.0
    left[is_inside_out, :, 2] *= -1.0
    singular[is_inside_out, 2] *= -1.0
    return left @ right, singular


def _rotation_cofactors(spread, scale, rotation, status):
    turned = rotation @ spread @ np.swapaxes(rotation, 1, 2)
    turned *= scale[:, None, None] ** 2
    normal = np.trace(turned, axis1=1, axis2=2)[:, None, None] * np.eye(3) - turned
    normal[status != 0] = np.eye(3)
    return without_unusable(np.linalg.inv(normal), status)


def angles_of(rotation):
    """Angles ω, φ, κ (n, 3) of R = R_x(ω) R_y(φ) R_z(κ), (n, 3, 3)."""
    # the right-handed product R_x R_y R_z is the transpose of the camera's matrix
    return angles_from_rotation(np.swapaxes(rotation, 1, 2))


def _angles_from_small_turn(rotation):
    """Change of ω, φ, κ with a small rotation about the ground axes."""
    omega, phi, _ = angles_of(rotation).T
    rates = angle_rates(omega, phi)
    rates[np.abs(np.cos(phi)) < GIMBAL_COSINE] = np.nan
    return rates
