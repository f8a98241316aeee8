"""Kasper's criteria in one plane at right angles to the base, from three points.

The plane goes through one projection centre, the origin of its coordinates y, z. Of its
three points the first, i, is near the plumb line; the others, j and l, lie in the
wings, and l is the one whose parallax is over-corrected. The tilt omega cannot be
found from this plane when the centre and the three points lie on a circle.

k and n are easily confused, so both are stored:

n
    factor on the turn that would just clear point l, after which the parallaxes of all
    points can be cleared at once;
k = n - 1
    the over-correction: the parallax p of point l is driven to -k p.

Both are negative for points beyond the dangerous circle, where the bundle must be
turned the other way; k alone is negative where the wings lie wider than the model is
deep (super-wide cameras).

Source: H. Kasper, graphical method, as quoted by P. Waldhäusl 1971 (figure 1).
"""

from dataclasses import dataclass

import numpy as np

NEAR_PLANE = 0.15
"""How far from the plane a point may lie, in parts of the base."""


@dataclass(frozen=True, eq=False)
class PlaneCriteria:
    """How well three points of a base-normal plane determine the tilt."""

    # (...): N = det [y, z, y² + z²] over the points i, j, l; 0 where the tilt is
    # undetermined. Its sign is that of the order of j and l.
    determinant: np.ndarray
    # (...): N² / q of the tilt from this plane alone, for parallaxes of unit weight.
    # The least-squares tilt of six points is the mean of both planes with these
    # weights.
    weight: np.ndarray
    # both (...): signed; infinite on the dangerous circle
    over_correction_n: np.ndarray
    over_correction_k: np.ndarray
    # (...): of point i from the circle through the centre, j and l, in parts of the ray
    # to the circle: 0 on the circle, a² / (a² + h²) in flat terrain
    gap: np.ndarray
    # (..., 2): (Y, Z) of the point opposite the centre on the circle through the
    # centre, i and j; infinite or NaN where these lie on one ray
    circle_end: np.ndarray
    intersection: np.ndarray  # (..., 2): second point of that circle on the ray of l

    @property
    def sigma_omega(self):
        """Standard error of the tilt from this plane alone, for unit parallax error.

        [rad per unit of length]; infinite where it is undetermined.
        """
        with np.errstate(divide="ignore"):
            return 1.0 / np.sqrt(self.weight)

    @property
    def circle_radius(self):
        """Radius of the circle through the centre, i and j, ndarray, shape (...)."""
        return np.hypot(*np.moveaxis(self.circle_end, -1, 0)) / 2.0


def examine_planes(yz):
    """Apply Kasper's criteria to three points in each of many planes.

    Parameters
    ----------
    yz : ndarray, shape (..., 3, 2)
        y, z of the points i (near the plumb line), j and l (wings), origin in the
        projection centre.

    Returns
    -------
    PlaneCriteria
        Arrays of shape (...); NaN where a coordinate is NaN.

    Notes
    -----
    With c_ij = y_i z_j - z_i y_j and r² = y² + z²,

        N = r_i² c_jl + r_j² c_li + r_l² c_ij,   n = r_l² c_ij / N,
        gap_i = N / (N - r_i² c_jl),             q = Σ (z_i c_jl)²,

    so that a plane on the dangerous circle divides nothing by zero but n.

    Examples
    --------
    A flat wide-angle plane, h = 152, a = 95: n = (1 + h²/a²) / 2.

    >>> plane = examine_planes(np.array([[0, -152.0], [95, -152], [-95, -152]]))
    >>> float(plane.over_correction_n.round(9)), float(plane.over_correction_k.round(9))
    (1.78, 0.78)
    """
    yz = np.asarray(yz, dtype=float)
    y, z = yz[..., 0], yz[..., 1]
    squares = y**2 + z**2
    crosses = _opposite_crosses(y, z)
    terms = squares * crosses
    determinant = terms.sum(axis=-1)
    q = np.sum((z * crosses) ** 2, axis=-1)
    # a dangerous circle has an infinite n, and three points on one ray no circle
    with np.errstate(divide="ignore", invalid="ignore"):
        circle_end = _circle_end(y, z, squares, crosses[..., 2])
        on_ray = np.sum(yz[..., 2, :] * circle_end, axis=-1) / squares[..., 2]
        over_correction_n = terms[..., 2] / determinant
        return PlaneCriteria(
            determinant=determinant,
            weight=np.where(q == 0.0, 0.0, determinant**2 / q),
            over_correction_n=over_correction_n,
            over_correction_k=over_correction_n - 1.0,
            gap=determinant / (determinant - terms[..., 0]),
            circle_end=circle_end,
            intersection=yz[..., 2, :] * on_ray[..., np.newaxis],
        )


def _opposite_crosses(y, z):
    """Cross products c_jl, c_li, c_ij, each in the place of the third point."""
    following, last = [1, 2, 0], [2, 0, 1]
    return y[..., following] * z[..., last] - z[..., following] * y[..., last]


def _circle_end(y, z, squares, cross):
    along_y = squares[..., 0] * z[..., 1] - squares[..., 1] * z[..., 0]
    along_z = y[..., 0] * squares[..., 1] - y[..., 1] * squares[..., 0]
    return np.stack([along_y, along_z], axis=-1) / cross[..., np.newaxis]


def standard_planes(xyz, base, model_start):
    """Choose three points below each projection centre: y, z, (n_models, 2, 3, 2).

    In the planes of the left and of the right centre i is seen nearest to the plumb
    line, j farthest to the side of +y, l to that of -y. NaN where there are no three
    such points within 15 % of the base. ``xyz`` (n_points, 3) is sorted by model, its
    origin in the left projection centre, z < 0.
    """
    n_models = len(base)
    chosen = np.full((n_models, 2, 3, 2), np.nan)
    model = np.repeat(np.arange(n_models), np.diff(model_start))
    slope = -xyz[:, 1] / xyz[:, 2]
    for side in (0, 1):
        from_plane = np.abs(xyz[:, 0] - side * base[model])
        near = np.flatnonzero(from_plane <= NEAR_PLANE * base[model])
        triple = np.stack(
            [
                _first_of_each(near, measure[near], model[near], n_models)
                for measure in (np.abs(slope), -slope, slope)
            ],
            axis=1,
        )
        i, j, last = triple.T
        is_found = (i >= 0) & (i != j) & (i != last) & (j != last)
        chosen[is_found, side] = xyz[triple[is_found], 1:]
    return chosen


def _first_of_each(rows, measure, model, n_models):
    """Row with the smallest measure in each model, -1 where a model has none."""
    order = np.lexsort((measure, model))
    models, first = np.unique(model[order], return_index=True)
    found = np.full(n_models, -1)
    found[models] = rows[order[first]]
    return found


def base_system(base, upwards):
    """Axes of the base-normal planes: x along the base, z as far upwards as can be.

    Rows x, y, z (n_pairs, 3, 3) from vectors (n_pairs, 3) of any length in any one
    system: the base from the left to the right centre, and the direction away from the
    scene, for images the sum of both optical axes. NaN where there is no base, or it
    points upwards itself.

    Examples
    --------
    A base towards -y of vertical images:

    >>> axes = base_system(np.array([[0.0, -2.0, 0.0]]), np.array([[0.0, 0.0, 1.0]]))
    >>> (axes @ np.array([0.0, -2.0, -5.0]) + 0.0).tolist()
    [[2.0, 0.0, -5.0]]
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        x = base / np.linalg.norm(base, axis=-1, keepdims=True)
        z = upwards - np.sum(upwards * x, axis=-1, keepdims=True) * x
        z = z / np.linalg.norm(z, axis=-1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=-2)
