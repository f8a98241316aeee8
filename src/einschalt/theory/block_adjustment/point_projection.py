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
        (_as_parts(design, parts), _as_parts(parameters, parts), n_used),
        (system.weights, system.control_weight, system.is_fixed, system.inverse),
        (shift.view(np.float64), control.view(np.float64)),
        (points.view(np.float64), residuals.view(np.float64)),
        ((0,) * design.shape[1], (0,) * parts),
    )


def _as_parts(array, parts):
    """Real and imaginary parts along a last axis."""
    return array.view(np.float64).reshape(*array.shape, parts)


@compiled
def _project(first, last, start, fan, transformation, prior, right, found, ranks):
    # loops over the length of a tuple are unrolled
    d, parts = len(ranks[0]), len(ranks[1])
    model, rows = fan
    design, parameters, n_used = transformation
    weights, control_weight, is_fixed, inverse = prior
    (shift, control), (points, residuals) = right, found
    is_shifted = shift.size > 0
    most = 0
    for p in range(first, last):
        most = max(most, start[p + 1] - start[p])
    high, low = np.empty((most, d, parts)), np.empty((most, d, parts))
    total, mean = np.empty((d, parts)), np.empty((d, parts))
    for p in range(first, last):
        begin, n = start[p], start[p + 1] - start[p]
        for r in range(parameters.shape[2]):
            j = r * parts
            for c in range(d):
                for part in range(parts):
                    value = control_weight[p, c, 0] * control[p, 0, j + part]
                    for e in range(1, d):
                        value += control_weight[p, c, e] * control[p, e, j + part]
                    total[c, part] = value
            for k in range(n):
                row = rows[begin + k]
                m = model[row]
                for c in range(d):
                    real, rest, imaginary, lost = 0.0, 0.0, 0.0, 0.0
                    for a in range(n_used):
                        g, x = design[row, c, a, 0], parameters[m, a, r, 0]
                        real, rest = add_product(real, rest, g, x)
                        if parts == 2:
                            h, y = design[row, c, a, 1], parameters[m, a, r, 1]
                            real, rest = add_product(real, rest, -h, y)
                            imaginary, lost = add_product(imaginary, lost, g, y)
                            imaginary, lost = add_product(imaginary, lost, h, x)
                    high[k, c, 0], low[k, c, 0] = real, rest
                    if parts == 2:
                        high[k, c, 1], low[k, c, 1] = imaginary, lost
                    for part in range(parts):
                        fitted = high[k, c, part]
                        if is_shifted:
                            fitted -= shift[row, c, j + part]
                        total[c, part] += weights[row, c] * fitted
            for c in range(d):
                for part in range(parts):
                    value = inverse[p, c, 0] * total[0, part]
                    for e in range(1, d):
                        value += inverse[p, c, e] * total[e, part]
                    mean[c, part] = control[p, c, j + part] if is_fixed[p] else value
                    points[p, c, j + part] = mean[c, part]
            for c in range(d):
                for part in range(parts):
                    value = 0.0
                    for e in range(d):
                        away = control[p, e, j + part] - mean[e, part]
                        value += control_weight[p, c, e] * away
                    total[c, part] = value
            for k in range(n):
                row = rows[begin + k]
                for c in range(d):
                    for part in range(parts):
                        residual = (high[k, c, part] - mean[c, part]) + low[k, c, part]
                        if is_shifted:
                            residual -= shift[row, c, j + part]
                        high[k, c, part] = residual
                        total[c, part] += weights[row, c] * residual
            for c in range(d):
                for part in range(parts):
                    # 0 where the point is held: so is its inverse
                    value = inverse[p, c, 0] * total[0, part]
                    for e in range(1, d):
                        value += inverse[p, c, e] * total[e, part]
                    mean[c, part] = value
                    points[p, c, j + part] += value
            for k in range(n):
                row = rows[begin + k]
                for c in range(d):
                    for part in range(parts):
                        residual = high[k, c, part] - mean[c, part]
                        residuals[row, c, j + part] = residual
