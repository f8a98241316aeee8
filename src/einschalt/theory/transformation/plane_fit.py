"""What affine, helmert and rigid transformations of a plane share.

Each is E, N = c_ground + A (xy − c_model) about the weighted centroids, with a 2 × 2
matrix A per model. They differ only in how A follows from the moments of the points,
and in the quadratic forms K by which its uncertainty grows away from the centroid:

    q_E(d) = 1/Σw + dᵀ K_E d,    leverage h = w q,    m_t² = m_0² q.

Source: Kovarik 1971 (m_t = m_0 √h); see docs/theory/transformation.md.
"""

from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter

import numpy as np

from einschalt.foundations.batches import over_segments
from einschalt.foundations.kernels import compiled
from einschalt.theory.adjustment.least_squares import (
    standard_error_of_unit_weight,
    total_from_coordinate,
)

USABLE, TOO_FEW, UNDETERMINED, OTHER_SCALE, SAME_GROUND = range(5)
FINEST = 1e-12  # of a coordinate: what lies closer together lies in one place
# breadth over length of what a map makes of a circle, if it has an inverse
FLATTEST = 1e-10
MIRROR_RATIO = 100.0
PARAMETER_NAMES = {
    "affine": ("a0", "a1", "a2", "b0", "b1", "b2"),
    "helmert": ("a", "b", "te", "tn"),
    "rigid": ("theta", "te", "tn"),
}
CLEARLY_LONGER = 1.001  # points on a line fit as well when they are turned over


@dataclass(frozen=True, eq=False)
class PlaneMoments:
    """Centroids and second moments of the points of each model."""

    n_points: np.ndarray  # of int, (n_models,)
    weight_sum: np.ndarray  # (n_models,): NaN for a model without points
    centroid_model: np.ndarray  # both (n_models, 2): weighted centroids
    centroid_ground: np.ndarray
    # (n_models, 2, 2): Σ w d dᵀ of the centred model coordinates d
    model_model: np.ndarray
    # (n_models, 2, 2): Σ w d Dᵀ with the centred ground coordinates D
    model_ground: np.ndarray
    ground_polar: np.ndarray  # (n_models,): Σ w |D|²

    @property
    def polar(self):
        """Polar second moment Σ w |d|², shape (n_models,)."""
        return self.model_model[:, 0, 0] + self.model_model[:, 1, 1]

    @property
    def determinant(self):
        """Determinant of Σ w d dᵀ, shape (n_models,)."""
        m = self.model_model
        return m[:, 0, 0] * m[:, 1, 1] - m[:, 0, 1] * m[:, 1, 0]

    @property
    def is_spread(self):
        """Whether the points lie apart, by more than the rounding of coordinates."""
        return is_spread(self.polar, self.weight_sum, self.centroid_model)

    def status(self, least, is_determined):
        """Status of each model (n_models,), as :func:`status_of`."""
        spread = is_spread(self.ground_polar, self.weight_sum, self.centroid_ground)
        return status_of(self.n_points, least, is_determined, spread)


@dataclass(frozen=True, eq=False)
class PlaneSolution:
    """What one kind of transformation makes of the moments."""

    # (n_models, 2, 2): the matrix A, NaN where the model is not determined
    linear: np.ndarray
    # all (n_models, 2, 2): quadratic forms K of the cofactors q_EE, q_NN, q_EN
    spread_east: np.ndarray
    spread_north: np.ndarray
    spread_cross: np.ndarray
    status: np.ndarray  # of int, (n_models,): USABLE, TOO_FEW … as of status_of

    @classmethod
    def alike(cls, linear, spread, status):
        """Easting and northing have the same cofactors, and are uncorrelated."""
        return cls(linear, spread, spread, np.zeros_like(spread), status)


class CentredFit:
    """What plane and spatial fits share: ground = c_ground + A (xyz − c_model)."""

    @cached_property
    def s_0(self):
        """Standard error of unit weight per coordinate [m], shape (n_models,)."""
        return standard_error_of_unit_weight(self.sum_of_squares, self.redundancy)

    @property
    def m_0(self):
        """TOTAL standard error of unit weight in plan, √2 s_0 [m], (n_models,)."""
        return total_from_coordinate(self.s_0)

    @property
    def is_mirrored(self):
        """Whether the model fits a hundred times better turned over (inside out)."""
        squares = self.sum_of_squares
        return squares > MIRROR_RATIO * (squares - self.mirror_gain)

    def apply(self, model, coordinates):
        """Ground coordinates (n, n_axes) [m] of points, each of its ``model`` (n,)."""
        offset = coordinates - self.centroid_model[model]
        turned = np.einsum("nij,nj->ni", self.linear[model], offset)
        return self.centroid_ground[model] + turned

    def invert(self, model, ground):
        """Model coordinates (n, n_axes) of points on the ground [m]."""
        offset = ground - self.centroid_ground[model]
        turned = np.einsum("nij,nj->ni", self.inverse[model], offset)
        return self.centroid_model[model] + turned

    def homogeneous(self, model):
        """Matrix and shift of one model: ground = matrix · xyz + shift."""
        matrix = self.linear[model]
        return matrix, self.centroid_ground[model] - matrix @ self.centroid_model[model]


@dataclass(frozen=True, eq=False)
class PlaneFit(CentredFit):
    """Plane transformations of all models of a flight."""

    kind: str
    moments: PlaneMoments
    solution: PlaneSolution
    residuals: np.ndarray  # (n_points, 2): transformed minus given [m]
    # (n_points, 2): diagonal of the hat matrix; redundancy number = 1 − h
    leverage: np.ndarray
    sum_of_squares: np.ndarray  # (n_models,): Σ w |v|² [m²]
    # of int, (n_models,): 2 n less the parameters; 0 where a model is not determined
    redundancy: np.ndarray
    parameter_names: tuple[str, ...]
    parameters: np.ndarray  # (n_models, n_parameters)
    # (n_models,): by how much the sum of squares would be smaller if the model were
    # turned over [m²]; NaN where that cannot be told, and for affine, which takes a
    # mirror image as it comes
    mirror_gain: np.ndarray

    n_points = property(attrgetter("moments.n_points"))
    centroid_model = property(attrgetter("moments.centroid_model"))
    centroid_ground = property(attrgetter("moments.centroid_ground"))
    linear = property(attrgetter("solution.linear"))
    status = property(attrgetter("solution.status"))

    @property
    def inverse(self):
        """Inverse of the matrix of each model, shape (n_models, 2, 2).

        NaN where an affine transformation puts the whole plane on a line, as ground
        points on a line make it.
        """
        return _inverse_2x2(self.linear)

    def point_cofactors(self, model, xy):
        """Cofactors (n, 2, 2) of transformed points, from the transformation alone.

        Of any points, fitted or not, without error of their own; times s_0² they are
        the covariance of easting and northing [m²].
        """
        d = xy - self.centroid_model[model]
        base = 1.0 / self.moments.weight_sum[model]
        q = np.empty((len(xy), 2, 2))
        part = self.solution
        q[:, 0, 0] = base + _quadratic(d, part.spread_east[model])
        q[:, 1, 1] = base + _quadratic(d, part.spread_north[model])
        q[:, 0, 1] = q[:, 1, 0] = _quadratic(d, part.spread_cross[model])
        return q


def as_floats(*arrays):
    """Arrays as the compiled loops take them."""
    return [np.ascontiguousarray(array, dtype=float) for array in arrays]


def plane_moments(xy, en, weights, start):
    """Centroids and second moments of all models, in one pass over the points.

    Sums run over differences to the first point of each model, then to the centroid:
    without that, coordinates of 5·10⁶ m lose seven digits. Arguments as in
    :func:`einschalt.theory.transformation.affine.fit_affine`.
    """
    n_models = len(start) - 1
    moments = PlaneMoments(
        np.diff(start),
        np.full(n_models, np.nan),
        np.zeros((n_models, 2)),
        np.zeros((n_models, 2)),
        np.zeros((n_models, 2, 2)),
        np.zeros((n_models, 2, 2)),
        np.zeros(n_models),
    )
    over_segments(
        _sum_moments,
        start,
        *as_floats(xy, en, weights),
        *(moments.weight_sum, moments.centroid_model, moments.centroid_ground),
        *(moments.model_model, moments.model_ground, moments.ground_polar),
    )
    return moments


@compiled(error_model="numpy")
def _sum_moments(
    first, last, start, xy, en, weights, w_sum, c_xy, c_en, s_mm, s_mg, s_gg
):
    for k in range(first, last):
        low, high = start[k], start[k + 1]
        if high == low:
            continue
        x0, y0, e0, n0 = xy[low, 0], xy[low, 1], en[low, 0], en[low, 1]
        w = x = y = e = n = 0.0
        for i in range(low, high):
            p = weights[i]
            w += p
            x += p * (xy[i, 0] - x0)
            y += p * (xy[i, 1] - y0)
            e += p * (en[i, 0] - e0)
            n += p * (en[i, 1] - n0)
        x0, y0, e0, n0 = x0 + x / w, y0 + y / w, e0 + e / w, n0 + n / w
        xx = xy_ = yy = xe = xn = ye = yn = gg = 0.0
        for i in range(low, high):
            p = weights[i]
            dx, dy = xy[i, 0] - x0, xy[i, 1] - y0
            de, dn = en[i, 0] - e0, en[i, 1] - n0
            xx += p * dx * dx
            xy_ += p * dx * dy
            yy += p * dy * dy
            xe += p * dx * de
            xn += p * dx * dn
            ye += p * dy * de
            yn += p * dy * dn
            gg += p * (de * de + dn * dn)
        w_sum[k] = w
        c_xy[k, 0], c_xy[k, 1], c_en[k, 0], c_en[k, 1] = x0, y0, e0, n0
        s_mm[k, 0, 0], s_mm[k, 1, 1] = xx, yy
        s_mm[k, 0, 1] = s_mm[k, 1, 0] = xy_
        s_gg[k] = gg
        s_mg[k, 0, 0], s_mg[k, 0, 1], s_mg[k, 1, 0], s_mg[k, 1, 1] = xe, xn, ye, yn


def assemble_fit(kind, points, moments, solution, parameters, gain):
    """Put the fit of one kind together from its solution, in one pass over the points.

    ``points`` are xy, en, weights, start; ``gain`` is that of :func:`mirror_gain`.
    """
    *arrays, start = points
    residuals = np.empty((len(arrays[0]), 2))
    # where both axes have one leverage it is computed and kept once
    n_leverages = 1 if solution.spread_north is solution.spread_east else 2
    leverage = np.empty((len(residuals), n_leverages))
    sum_of_squares = np.zeros(len(start) - 1)
    over_segments(
        _point_by_point,
        start,
        *as_floats(*arrays),
        *(moments.weight_sum, moments.centroid_model, moments.centroid_ground),
        *(solution.linear, solution.spread_east, solution.spread_north),
        *(residuals, leverage, sum_of_squares),
    )
    spare = 2 * moments.n_points - len(PARAMETER_NAMES[kind])
    return PlaneFit(
        kind=kind,
        moments=moments,
        solution=solution,
        residuals=residuals,
        leverage=np.broadcast_to(leverage, residuals.shape),
        sum_of_squares=sum_of_squares,
        redundancy=np.where(solution.status == USABLE, spare, 0),
        parameter_names=PARAMETER_NAMES[kind],
        parameters=parameters,
        mirror_gain=gain,
    )


@compiled(error_model="numpy")
def _point_by_point(
    first, last, start, xy, en, weights, w_sum, c_xy, c_en, a, k_e, k_n, v, h, vv
):
    for k in range(first, last):
        base, total = 1.0 / w_sum[k], 0.0
        x0, y0, e0, n0 = c_xy[k, 0], c_xy[k, 1], c_en[k, 0], c_en[k, 1]
        a_ex, a_ey, a_nx, a_ny = a[k, 0, 0], a[k, 0, 1], a[k, 1, 0], a[k, 1, 1]
        e_xx, e_xy, e_yy = k_e[k, 0, 0], 2.0 * k_e[k, 0, 1], k_e[k, 1, 1]
        n_xx, n_xy, n_yy = k_n[k, 0, 0], 2.0 * k_n[k, 0, 1], k_n[k, 1, 1]
        for i in range(start[k], start[k + 1]):
            p, dx, dy = weights[i], xy[i, 0] - x0, xy[i, 1] - y0
            v_e = a_ex * dx + a_ey * dy - (en[i, 0] - e0)
            v_n = a_nx * dx + a_ny * dy - (en[i, 1] - n0)
            xx, x_y, yy = dx * dx, dx * dy, dy * dy
            v[i, 0], v[i, 1] = v_e, v_n
            h[i, 0] = p * (base + e_xx * xx + e_xy * x_y + e_yy * yy)
            if h.shape[1] == 2:
                h[i, 1] = p * (base + n_xx * xx + n_xy * x_y + n_yy * yy)
            total += p * (v_e * v_e + v_n * v_n)
        vv[k] = total


def is_spread(polar, weight_sum, centroid):
    """Whether points lie apart, by more than the rounding of their coordinates.

    ``polar`` is Σ w |d|² of the centred coordinates d, (n_models,); False for a model
    without points.
    """
    rounding = FINEST * np.abs(centroid).max(axis=1)
    return polar > weight_sum * rounding**2


def mirror_gain(gain, direct, turned, is_overdetermined):
    """Keep the gain of turning a model over [m²] where it can be told.

    ``direct`` and ``turned`` say how well the two figures correlate as they are, and
    turned over. NaN for points on a line, and for too few points: a mirror image of the
    fewest fits as well as the points themselves.
    """
    is_clear = is_overdetermined & (turned > CLEARLY_LONGER * direct)
    return np.where(is_clear, gain, np.nan)


def status_of(n_points, least, is_determined, is_ground_spread):
    """Whether each model can be transformed, and if not, why: (n_models,).

    TOO_FEW: fewer points than ``least``. SAME_GROUND: their ground coordinates are the
    same to rounding; the model would shrink to a point. UNDETERMINED otherwise.
    """
    status = np.where(is_determined, USABLE, UNDETERMINED)
    status = np.where(is_ground_spread, status, SAME_GROUND)
    return np.where(n_points < least, TOO_FEW, status)


def shift_at_origin(centred, linear):
    """Shift (n_models, n_axes) that belongs to the origin of the model coordinates."""
    turned = np.einsum("mij,mj->mi", linear, centred.centroid_model)
    return centred.centroid_ground - turned


def without_unusable(values, status):
    """Put NaN where a model is not usable; ``values`` has the shape (n_models, ...)."""
    values = np.array(values, dtype=float)
    values[status != USABLE] = np.nan
    return values


def _quadratic(d, form):
    return np.einsum("ni,nij,nj->n", d, form, d)


def _inverse_2x2(matrix):
    a, b, c, d = matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 1, 0], matrix[:, 1, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        flipped = np.stack([np.stack([d, -b], -1), np.stack([-c, a], -1)], -2)
        determinant, size = a * d - b * c, a * a + b * b + c * c + d * d
        determinant[np.abs(determinant) <= FLATTEST * size] = np.nan
        return flipped / determinant[:, None, None]
