"""Points and residuals that follow from the parameters of the models.

Everything that belongs to a point is done while it is at hand: what its models make of
it, the mean, the residuals, and what rounding has left of their mean. Complex numbers
are pairs of columns, since all weights are real.
"""

import numpy as np

from einschalt.foundations.batches import over_segments
from einschalt.foundations.exact_sums import add_product
from einschalt.foundations.kernels import compiled


def project_points(system, parameters, right, found):
    """Fill points and residuals; see ``PointSystem.project``.

    Where little control holds a large block, its weak motions amplify the rounding of
    the residuals, small differences of coordinates of thousands of metres. So points
    are transformed with twice the digits.
    """
    (shift, control), (points, residuals) = right, found
    design, incidence = system.design, system.incidence
    parts = 2 if np.iscomplexobj(design) else 1
    n_used = 0 if parameters is None else system.n_unknowns
    if parameters is None:
        parameters = np.empty((0, 0, control.shape[2]))
    if np.ndim(shift) == 0:
        shift = np.empty((0, 0, 0))
    parameters, shift = (
        np.ascontiguousarray(values, design.dtype) for values in (parameters, shift)
    )
    over_segments(
        _project,
        incidence.point_start,
        (incidence.model, incidence.rows),
        (_as_parts(design, parts), parameters.view(np.float64), n_used),
        (system.weights, system.control_weight, system.is_fixed, system.inverse),
        (shift.view(np.float64), control.view(np.float64)),
        (points.view(np.float64), residuals.view(np.float64)),
        (0,) * design.shape[1],
    )


def _as_parts(array, parts):
    """Real and imaginary parts along a last axis."""
    return array.view(np.float64).reshape(*array.shape, parts)


@compiled
def _project(first, last, start, fan, transformation, prior, right, found, axes):
    # loops over the length of a tuple are unrolled; those over right sides are the
    # innermost ones, of numbers that lie together: several at once. Complex numbers
    # are told by a number, not by a type: there would be a case more to compile
    model, rows = fan
    design, parameters, n_used = transformation
    d, parts = len(axes), design.shape[3]
    weights, control_weight, is_fixed, inverse = prior
    (shift, control), (points, residuals) = right, found
    is_shifted = shift.size > 0
    width = control.shape[2]
    most = 0
    for p in range(first, last):
        most = max(most, start[p + 1] - start[p])
    high, low = np.empty((most, d, width)), np.empty((most, d, width))
    total, mean = np.empty((d, width)), np.empty((d, width))
    for p in range(first, last):
        begin, n = start[p], start[p + 1] - start[p]
        for c in range(d):
            for j in range(width):
                value = control_weight[p, c, 0] * control[p, 0, j]
                for e in range(1, d):
                    value += control_weight[p, c, e] * control[p, e, j]
                total[c, j] = value
        for k in range(n):
            row = rows[begin + k]
            m = model[row]
            for c in range(d):
                for j in range(width):
                    high[k, c, j], low[k, c, j] = 0.0, 0.0
                for a in range(n_used):
                    g = design[row, c, a, 0]
                    if parts == 1:
                        for j in range(width):
                            high[k, c, j], low[k, c, j] = add_product(
                                high[k, c, j], low[k, c, j], g, parameters[m, a, j]
                            )
                    else:
                        h = design[row, c, a, 1]
                        for j in range(0, width, 2):
                            x, y = parameters[m, a, j], parameters[m, a, j + 1]
                            real, rest = high[k, c, j], low[k, c, j]
                            real, rest = add_product(real, rest, g, x)
                            real, rest = add_product(real, rest, -h, y)
                            high[k, c, j], low[k, c, j] = real, rest
                            real, rest = high[k, c, j + 1], low[k, c, j + 1]
                            real, rest = add_product(real, rest, g, y)
                            real, rest = add_product(real, rest, h, x)
                            high[k, c, j + 1], low[k, c, j + 1] = real, rest
                w = weights[row, c]
                if is_shifted:
                    for j in range(width):
                        total[c, j] += w * (high[k, c, j] - shift[row, c, j])
                else:
                    for j in range(width):
                        total[c, j] += w * high[k, c, j]
        for c in range(d):
            for j in range(width):
                value = inverse[p, c, 0] * total[0, j]
                for e in range(1, d):
                    value += inverse[p, c, e] * total[e, j]
                # what is held has no inverse, and what is not given is 0 there
                mean[c, j] = control[p, c, j] + value if is_fixed[p] else value
                points[p, c, j] = mean[c, j]
        for c in range(d):
            for j in range(width):
                value = 0.0
                for e in range(d):
                    away = control[p, e, j] - mean[e, j]
                    value += control_weight[p, c, e] * away
                total[c, j] = value
        for k in range(n):
            row = rows[begin + k]
            for c in range(d):
                w = weights[row, c]
                for j in range(width):
                    residual = (high[k, c, j] - mean[c, j]) + low[k, c, j]
                    if is_shifted:
                        residual -= shift[row, c, j]
                    high[k, c, j] = residual
                    total[c, j] += w * residual
        for c in range(d):
            for j in range(width):
                # 0 where it is held: so is its inverse
                value = inverse[p, c, 0] * total[0, j]
                for e in range(1, d):
                    value += inverse[p, c, e] * total[e, j]
                mean[c, j] = value
                points[p, c, j] += value
        for k in range(n):
            row = rows[begin + k]
            for c in range(d):
                for j in range(width):
                    residuals[row, c, j] = high[k, c, j] - mean[c, j]
