"""Normal equations from which the points are eliminated, and the way back to them.

Each observation says v = T − X − l, T the model's point in the ground system, linear
in the unknowns of its model (T = G p), X the coordinates of the point; control says
v = X − c. A point occurs in its own observations only, so that its part of the normal
equations is one small block P = Σ w + W_c, and

    X = P⁻¹ (Σ w (T − l) + W_c c),
    N_ij = δ_ij Σ w Gᴴ G − w_i w_j G_iᴴ P⁻¹ G_j,
    Q_XX = P⁻¹ + P⁻¹ (Σ_ij w_i w_j G_i Z_ij G_jᴴ) P⁻¹,   Z = N⁻¹,

with only those Z_ij whose models share the point. Easting and northing are one complex
number for helmert, two right sides of one system for affine; where the control has
correlated coordinates they are two rows of each G. See docs/theory/block_adjustment.md.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import over_segments
from einschalt.foundations.kernels import compiled
from einschalt.theory.block_adjustment.model_graph import Incidence
from einschalt.theory.block_adjustment.point_projection import project_points

# rows of a point and unknowns of a model without anything that it has for itself.
# Loops over these are unrolled; each further pair would be compiled when it first comes
UNROLLED = {(1, 2), (1, 3), (2, 6), (3, 7)}


@dataclass(frozen=True, eq=False)
class PointSystem:
    """Observations of a block as the kernels take them.

    The number of rows d of a point is 1, or 2 where easting and northing are coupled.
    """

    incidence: Incidence
    # (n_rows, d, n_unknowns): G of each observation, float or complex
    design: np.ndarray
    weights: np.ndarray  # (n_rows, d): of each row [1/m²]
    # (n_points, d, d): W_c, 0 where a point is no control [1/m²]
    control_weight: np.ndarray
    # (n_points,): control that is held as it is given, or in plan alone
    is_fixed: np.ndarray
    # (n_points, d, d): P⁻¹, 0 where a coordinate is fixed [m²]
    inverse: np.ndarray

    @property
    def n_unknowns(self):
        """Unknowns of each model."""
        return self.design.shape[2]

    def project(self, parameters, shift, control):
        """Points that fit given parameters best, and residuals T − X − l.

        ``parameters`` (n_models, n_unknowns, n_right) may be None, all 0; ``shift`` l
        (n_rows, d, n_right) 0.0, likewise; ``control`` (n_points, d, n_right) is c, 0
        where a point is no control.
        """
        dtype = self.design.dtype
        points = np.empty(control.shape, dtype)
        residuals = np.empty((*self.design.shape[:2], control.shape[2]), dtype)
        project_points(
            self,
            parameters,
            (shift, np.ascontiguousarray(control, dtype)),
            (points, residuals),
        )
        return points, residuals

    def gradient(self, residuals):
        """Σ w Gᴴ v of each model, (n_models, n_unknowns, n_right)."""
        shape = (self.incidence.n_models, self.n_unknowns, residuals.shape[2])
        gradient = np.zeros(shape, dtype=self.design.dtype)
        numbers = gradient, residuals, self.design, self.weights
        over_segments(_gradient, self.incidence.model_start, *numbers)
        return gradient


def invert_point_blocks(incidence, weights, control_weight, is_fixed):
    """P⁻¹ of all points; 0 where one is fixed, or has no observation at all.

    ``is_fixed`` (n_points,) or, of single coordinates, (n_points, d).
    """
    d = control_weight.shape[1]
    sums = [
        np.bincount(incidence.point, column, incidence.n_points) for column in weights.T
    ]
    blocks = control_weight.copy()
    for c in range(d):
        blocks[:, c, c] += sums[c]
    is_some = is_fixed.reshape(len(is_fixed), -1)
    is_known = ~is_some.all(axis=1) & (sums[0] > 0.0)
    if d == 1:
        inverse = np.zeros_like(blocks)
        np.divide(1.0, blocks, out=inverse, where=is_known[:, None, None])
        return inverse
    blocks[~is_known] = np.eye(d)
    inverse = np.linalg.inv(blocks)
    inverse[~is_known] = 0.0
    if is_fixed.ndim > 1:
        # what is held has no weight, so that it is apart from the rest of its point
        inverse[is_fixed] = 0.0
    return inverse


@compiled
def _gradient(first, last, model_start, gradient, residuals, design, weights):
    _, d, u = design.shape
    for m in range(first, last):
        for row in range(model_start[m], model_start[m + 1]):
            for c in range(d):
                for a in range(u):
                    g = weights[row, c] * np.conj(design[row, c, a])
                    for r in range(residuals.shape[2]):
                        gradient[m, a, r] += g * residuals[row, c, r]


def assemble(system, pattern):
    """Blocks of the reduced normal equations on and below the diagonal.

    The models are in the order of elimination.
    """
    _, d, u = system.design.shape
    blocks = np.zeros((len(pattern.row), u, u), dtype=system.design.dtype)
    over_segments(
        _assemble_blocks,
        system.incidence.model_start,
        blocks,
        (pattern.start, pattern.row),
        system.incidence.arrays,
        (system.design, system.weights, system.inverse),
        _ranks(d, u),
    )
    return blocks


def _ranks(d, u):
    """Two of that length: tuples, which the compiler knows, or an array."""
    return (0,) * d, (0,) * u if (d, u) in UNROLLED else np.empty(u)


@compiled
def _assemble_blocks(first, last, start, blocks, pattern, incidence, numbers, ranks):
    # loops over the length of a tuple are unrolled
    d, u = len(ranks[0]), len(ranks[1])
    column, block_row = pattern
    model, point, _, point_start, rows = incidence
    design, weights, inverse = numbers
    slot = np.empty(start.size - 1, dtype=np.int64)
    half = np.empty((d, u), dtype=design.dtype)
    own = np.empty((u, u), dtype=design.dtype)
    for i in range(first, last):
        for k in range(column[i], column[i + 1]):
            slot[block_row[k]] = k
        own[:] = 0.0
        for row in range(start[i], start[i + 1]):
            p = point[row]
            for c in range(d):
                for a in range(u):
                    g = weights[row, c] * np.conj(design[row, c, a])
                    for b in range(u):
                        own[a, b] += g * design[row, c, b]
            for c in range(d):
                for b in range(u):
                    value = inverse[p, c, 0] * (weights[row, 0] * design[row, 0, b])
                    for e in range(1, d):
                        weighted = weights[row, e] * design[row, e, b]
                        value += inverse[p, c, e] * weighted
                    half[c, b] = value
            for k in range(point_start[p], point_start[p + 1]):
                other = rows[k]
                # rows of a point ascend with their models: those before are done
                if other < row:
                    continue
                s = slot[model[other]]
                for c in range(d):
                    for a in range(u):
                        g = weights[other, c] * np.conj(design[other, c, a])
                        for b in range(u):
                            blocks[s, a, b] -= g * half[c, b]
        for a in range(u):
            for b in range(u):
                blocks[column[i], a, b] += own[a, b]


@dataclass(frozen=True, eq=False)
class PointCofactors:
    """Cofactors of points and of what was adjusted, for σ_0 = 1."""

    points: np.ndarray  # (n_points, d, d): Q_XX [m²]
    transformed: np.ndarray  # (n_rows, d, d): of each model's value T of a point
    cross: np.ndarray  # (n_rows, d, d): between T and X

    def of_differences(self, point):
        """Cofactors of T − X, the adjusted observations."""
        both = self.cross + np.conj(np.swapaxes(self.cross, 1, 2))
        return self.transformed + self.points[point] - both


def point_cofactors(system, pattern, inverse) -> PointCofactors:
    """Cofactors of all points from the selected inverse, in elimination order."""
    n_rows, d, u = system.design.shape
    points = np.zeros((system.incidence.n_points, d, d), dtype=inverse.dtype)
    transformed = np.zeros((n_rows, d, d), dtype=inverse.dtype)
    cross = np.zeros_like(transformed)
    over_segments(
        _spread_inverse,
        system.incidence.point_start,
        (points, transformed, cross),
        inverse,
        (pattern.start, pattern.row),
        (system.incidence.model, system.incidence.rows),
        (system.design, system.weights, system.inverse),
        _ranks(d, u),
    )
    return PointCofactors(points, transformed, cross)


@compiled
def _spread_inverse(first, last, start, result, inverse, pattern, fan, numbers, ranks):
    d, u = len(ranks[0]), len(ranks[1])
    points, transformed, cross = result
    column, block_row = pattern
    model, rows = fan
    design, weights, point_inverse = numbers
    total = np.empty((d, d), dtype=inverse.dtype)
    product = np.empty((d, d), dtype=inverse.dtype)
    for p in range(first, last):
        total[:] = 0.0
        # rows of a point ascend with their models
        for k in range(start[p], start[p + 1]):
            row = rows[k]
            s = column[model[row]]
            for k_other in range(k, start[p + 1]):
                other = rows[k_other]
                while block_row[s] != model[other]:
                    s += 1
                for c in range(d):
                    for e in range(d):
                        w, w_other = weights[row, e], weights[other, c]
                        # covariance of T of `other` with T of `row`
                        value = 0.0 * inverse[s, 0, 0]
                        for b in range(u):
                            half = design[other, c, 0] * inverse[s, 0, b]
                            for a in range(1, u):
                                half += design[other, c, a] * inverse[s, a, b]
                            value += half * np.conj(design[row, e, b])
                        cross[row, e, c] += w_other * np.conj(value)
                        total[c, e] += w * w_other * value
                        if other == row:
                            transformed[row, c, e] = value
                        else:
                            cross[other, c, e] += w * value
                            total[e, c] += w * w_other * np.conj(value)
        for k in range(start[p], start[p + 1]):
            row = rows[k]
            for c in range(d):
                for e in range(d):
                    value = cross[row, c, 0] * point_inverse[p, 0, e]
                    for a in range(1, d):
                        value += cross[row, c, a] * point_inverse[p, a, e]
                    product[c, e] = value
            for c in range(d):
                for e in range(d):
                    cross[row, c, e] = product[c, e]
        for c in range(d):
            for e in range(d):
                value = point_inverse[p, c, 0] * total[0, e]
                for a in range(1, d):
                    value += point_inverse[p, c, a] * total[a, e]
                product[c, e] = value
        for c in range(d):
            for e in range(d):
                value = product[c, 0] * point_inverse[p, 0, e]
                for a in range(1, d):
                    value += product[c, a] * point_inverse[p, a, e]
                points[p, c, e] = point_inverse[p, c, e] + value
