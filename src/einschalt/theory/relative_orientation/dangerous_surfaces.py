"""Whether the points of a model lie near a dangerous surface, and what follows.

To first order a non-zero correction leaves all parallaxes at zero when, and only when,
the points lie on the surface

    w (y² + z²) - x (y φ1 + z κ1) + (x - b)(y φ2 + z κ2) = 0,

an orthogonal ruled quadric through the base, of which every base-normal plane cuts a
circle through the base. With φ1 = φ2 and κ1 = κ2 it is a circular cylinder. Its
coefficients are the correction itself: the vector that the design matrix maps to 0.

Near such a surface the tilt omega is uncertain, and with it everything else. How much
is said by comparison with the **flat twin** of the model: every point is moved in its
base-normal plane along its ray from the base until it lies in the horizontal plane at
the depth of the middle of the model, so that it is seen where it was. The inflation

    sigma(omega) / sigma(omega) of the flat twin

does not depend on the choice of elements; in a symmetrical valley it is
``1 / |1 - depth / critical depth|``. Singular values do depend on it, and are given
relative to those of the flat twin for the same case.

Source: J. Krames 1948 (dangerous regions), H. Kasper and P. Waldhäusl 1971 (criteria);
the comparison with the flat twin is our own.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from einschalt.foundations.batches import (
    over_segments,
    segment_centred,
    segment_min_max,
    segment_sum,
)
from einschalt.foundations.kernels import compiled
from einschalt.theory.relative_orientation.base_normal_planes import (
    PlaneCriteria,
    examine_planes,
    standard_planes,
)
from einschalt.theory.relative_orientation.parallax_equations import (
    INDEPENDENT,
    N_ELEMENTS,
    design_matrix,
    independent_from_dependent,
)
from einschalt.theory.relative_orientation.surface_verdicts import (
    Figure,
    SurfaceVerdict,
    judge,
)

# the last column of a triangle then shows what only omega can explain
OMEGA_LAST = [1, 2, 3, 4, 0]
IN_ORDER = [4, 0, 1, 2, 3]
SHORTEST_BASE = 1e-12  # in depths; keeps the arithmetic finite
# points nearer to the base or farther from it, in depths, are mistakes
NEAREST, FARTHEST = 1e-9, 1e9
MIDDLE = 1.0 / 3.0
"""Part of the field of view across the base that counts as the middle."""


@dataclass(frozen=True, eq=False)
class SurfaceExamination:
    """What the positions of the points of all models allow to be known."""

    # ``verdict.names`` are safe, weak or critical, ``verdict.reasons`` say why
    verdict: SurfaceVerdict
    # (n_models,): sigma(omega) over that of the flat twin; infinite on a dangerous
    # surface, NaN where the model, or its twin, cannot be judged
    inflation: np.ndarray
    # (n_models,): of omega, for a parallax error of 1 [rad per unit of the model]
    sigma_omega: np.ndarray
    # both (n_models,): smallest one of the unit-free design matrix: root mean square
    # parallax for a correction of unit length. Compare it only between models of the
    # same case.
    singular_value: np.ndarray
    flat_singular_value: np.ndarray
    # (n_models, 5): coefficients w, φ1, φ2, κ1, κ2 of the surface to which the points
    # come nearest, [rad] for a correction of unit length; w >= 0
    surface: np.ndarray
    # (n_models,): of the middle of the model below the base: the unit of length, and
    # the depth of the flat twin
    depth: np.ndarray
    # arrays of shape (n_models, 2), for the left and the right base-normal plane; NaN
    # where there are no three points near it
    planes: PlaneCriteria

    @property
    def singular_value_ratio(self):
        """Smallest singular value over that of the flat twin, (n_models,)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.singular_value / self.flat_singular_value

    @property
    def better_plane(self):
        """The base-normal plane that determines omega better, 0 left or 1 right."""
        return np.argmax(np.nan_to_num(self.planes.weight, nan=-1.0), axis=1)


def examine_surfaces(
    xyz, base, model_start, *, case=INDEPENDENT, grows_with_depth=False
):
    """Judge for all models whether their points lie near a dangerous surface.

    Models that determine nothing are critical, with a reason. Cost: one pass,
    O(n_points), and a singular value decomposition of a 5 × 5 matrix per model and per
    twin.

    Parameters
    ----------
    xyz : ndarray, shape (n_points, 3)
        Model coordinates sorted by model, origin in the left projection centre, z < 0.
    base : ndarray, shape (n_models,)
        In the unit of the coordinates.
    model_start : ndarray of int, shape (n_models + 1,)
        Model k owns rows model_start[k]:model_start[k + 1].
    case : {"independent", "dependent_left", "dependent_right"}
        To which the singular values belong; nothing else depends on it.
    grows_with_depth : bool, optional
        Whether the error of a parallax grows with the depth of its point, as that of
        measured images does, or is equal for all points of a model. Where it grows,
        ``sigma_omega`` is for an error of 1 in the middle of the model.
    """
    base = np.asarray(base, dtype=float)
    depth = middle_depth(xyz, model_start)
    model = np.repeat(np.arange(len(base)), np.diff(model_start))
    is_behind, is_located = _mistakes(xyz, depth, model_start)
    is_sound = (depth > 0.0) & ~is_behind & is_located & (base > 0.0) & (base < np.inf)
    known = np.where(is_sound, 1.0, np.nan)
    # unit-free; models that cannot be judged take a harmless point in place of theirs
    unit = np.where(is_sound, depth, 1.0)
    bases = np.maximum(np.where(is_sound, base, 1.0) / unit, SHORTEST_BASE)
    points = np.where(is_sound[model, np.newaxis], xyz, [0.0, 0.0, -1.0])
    points = points / unit[model, np.newaxis]
    size = -1.0 / points[:, 2] if grows_with_depth else np.ones(len(points))
    own = _Equations.of(points, bases, model_start, size)
    twin = _Equations.of(flat_twin(points, 1.0), bases, model_start)
    with np.errstate(divide="ignore", invalid="ignore"):
        inflation = known * twin.omega_size / own.omega_size
        sigma_omega = known / (own.omega_size * unit)
    figure = Figure(
        n_points=np.diff(model_start),
        relative_base=base / unit,
        is_behind=is_behind,
        is_located=is_located,
        width=figure_width(points, model_start),
        inflation=inflation,
        uncertainty=own.uncertainty,
        flat_uncertainty=twin.uncertainty,
    )
    planes = standard_planes(points, bases, model_start)
    return SurfaceExamination(
        verdict=judge(figure),
        inflation=inflation,
        sigma_omega=sigma_omega,
        singular_value=known * own.singular_values(case)[:, -1],
        flat_singular_value=known * twin.singular_values(case)[:, -1],
        surface=known[:, np.newaxis] * own.surface,
        depth=known * depth,
        planes=examine_planes(planes * (known * unit)[:, *3 * [np.newaxis]]),
    )


def _mistakes(xyz, depth, model_start):
    """Which models have a point behind the base; which have all points somewhere."""
    n_points = np.diff(model_start)
    is_known = depth > 0.0
    least = np.repeat(NEAREST * np.where(is_known, depth, 0.0), n_points)
    most = np.repeat(FARTHEST * np.where(is_known, depth, np.inf), n_points)
    is_behind = segment_sum(~(xyz[:, 2] < -least), model_start) > 0
    is_lost = segment_sum(~(np.abs(xyz).max(axis=1) < most), model_start) > 0
    return is_behind, ~is_lost


@dataclass(frozen=True, eq=False)
class _Equations:
    """Parallax equations of independent pairs, made triangular, omega last."""

    triangle: np.ndarray  # (n_models, 5, 5)
    base: np.ndarray  # (n_models,): in depths, as all lengths here
    n_points: np.ndarray  # (n_models,)

    @classmethod
    def of(cls, xyz, base, model_start, size=1.0):
        """Make the equations triangular, each multiplied by its ``size``."""
        n_points = np.diff(model_start)
        rows = design_matrix(xyz, np.repeat(base, n_points), INDEPENDENT)
        rows = rows[:, OMEGA_LAST] * np.broadcast_to(size, len(xyz))[:, np.newaxis]
        triangle = np.zeros((len(base), N_ELEMENTS, N_ELEMENTS))
        over_segments(_make_triangular, model_start, rows, triangle)
        return cls(triangle, base, n_points)

    @property
    def omega_size(self):
        """Length of what only omega can explain: 1 / sigma(omega)."""
        return np.abs(self.triangle[:, -1, -1])

    @cached_property
    def _decomposed(self):
        return np.linalg.svd(self.triangle)

    @property
    def uncertainty(self):
        """Largest standard error of any correction of unit length."""
        with np.errstate(divide="ignore"):
            return 1.0 / self._decomposed.S[:, -1]

    @property
    def surface(self):
        """Correction that the parallaxes show least, in the order of the elements."""
        weakest = self._decomposed.Vh[:, -1, IN_ORDER]
        return weakest * np.where(weakest[:, :1] < 0.0, -1.0, 1.0)

    def singular_values(self, case):
        """Root mean square parallaxes of corrections of unit length, descending."""
        if case == INDEPENDENT:
            values = self._decomposed.S
        else:
            turned = independent_from_dependent(self.base, case)[:, OMEGA_LAST]
            values = np.linalg.svd(self.triangle @ turned, compute_uv=False)
        return values / np.sqrt(np.maximum(self.n_points, 1))[:, np.newaxis]


@compiled
def _make_triangular(first_model, last_model, start, rows, triangle):
    """Turn each row into the triangle of its model by plane rotations (Givens)."""
    for model in range(first_model, last_model):
        for row in rows[start[model] : start[model + 1]]:
            own = triangle[model]
            for i in range(N_ELEMENTS):
                size = np.hypot(own[i, i], row[i])
                if size == 0.0:
                    continue
                cosine, sine = own[i, i] / size, row[i] / size
                for k in range(i, N_ELEMENTS):
                    upper, lower = own[i, k], row[k]
                    own[i, k] = cosine * upper + sine * lower
                    row[k] = cosine * lower - sine * upper


def middle_depth(xyz, model_start):
    """Mean depth of the points in the middle third of the field across the base.

    Of all points of the model where none is in the middle; NaN without points, or where
    one is not below the base.
    """
    n_points = np.diff(model_start)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.abs(xyz[:, 1] / xyz[:, 2])
        widest = segment_min_max(slope, model_start)[1]
        is_middle = slope <= MIDDLE * np.repeat(widest, n_points)
        n_middle = segment_sum(is_middle.astype(float), model_start)
        has_middle = n_middle > 0.0
        is_used = is_middle | np.repeat(~has_middle, n_points)
        total = segment_sum(np.where(is_used, -xyz[:, 2], 0.0), model_start)
        return total / np.where(has_middle, n_middle, n_points)


def figure_width(xyz, model_start):
    """Standard deviation of points across their line of best fit, in their unit.

    Root of the middle eigenvalue of the covariance of the points of each model; 0 on a
    line.
    """
    n_points = np.diff(model_start)
    per_point = 1.0 / np.maximum(n_points, 1)[:, np.newaxis]
    reduced = segment_centred(xyz, model_start)
    outer = reduced[:, :, np.newaxis] * reduced[:, np.newaxis]
    covariance = segment_sum(outer, model_start) * per_point[:, np.newaxis]
    return np.sqrt(np.maximum(np.linalg.eigvalsh(covariance)[:, 1], 0.0))


def flat_twin(xyz, depth):
    """Points moved along their rays from the base into a horizontal plane.

    ``depth`` is that of the plane below the base; x and y / z stay.
    """
    x, y, z = np.moveaxis(xyz, -1, 0)
    return np.stack([x, -y / z * depth, np.broadcast_to(-depth, x.shape)], axis=-1)


def singular_values(xyz, base, model_start, depth, case):
    """Singular values of the unit-free design matrices of all models, (n_models, 5).

    Angles are multiplied by the depth, and the matrix is divided by √n: the values,
    descending, are root mean square parallaxes for corrections of unit length. They
    compare only between models of the same case. Coordinates (n_points, 3), base and
    depth (n_models,) have one unit.
    """
    unit = np.repeat(depth, np.diff(model_start))[:, np.newaxis]
    equations = _Equations.of(xyz / unit, np.divide(base, depth), model_start)
    return equations.singular_values(case)


def gaps_to_surface(xyz, base, surface):
    """Gaps of points from an orthogonal ruled quadric, along their rays from the base.

    Kasper's gap for any point: a ray in a base-normal plane meets the surface once
    more, at s times the distance of the point, and the gap is 1 - 1/s: 0 on the
    surface, positive where the surface is farther from the base than the point,
    infinite where the ray does not meet it. ``surface`` (5,) or (n_points, 5) is w, φ1,
    φ2, κ1, κ2.

    Examples
    --------
    Points of the cylinder y² + z² = -10 z, and one that is 20 % nearer to the base:

    >>> points = np.array([[0.0, 5.0, -5.0], [4.0, 0.0, -10.0], [2.0, 0.0, -8.0]])
    >>> surface = np.array([1.0, 0.0, 0.0, -2.5, -2.5])
    >>> (gaps_to_surface(points, 4.0, surface) + 0.0).round(9).tolist()
    [0.0, 0.0, 0.2]
    """
    x, y, z = np.moveaxis(np.asarray(xyz, dtype=float), -1, 0)
    w, phi_1, phi_2, kappa_1, kappa_2 = np.moveaxis(np.asarray(surface), -1, 0)
    ruled = x * (y * phi_1 + z * kappa_1) - (x - base) * (y * phi_2 + z * kappa_2)
    with np.errstate(divide="ignore", invalid="ignore"):
        return 1.0 - w * (y**2 + z**2) / ruled
