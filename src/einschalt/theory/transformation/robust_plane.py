"""Robust fits of plane transformations, each model in one go.

The same iteration as :func:`einschalt.theory.adjustment.robust.fit_robustly`, which
takes any norm and any kind; here all steps of a model follow each other in one compiled
loop over its points, which is an order of magnitude faster.

Source: Huber 1981, ch. 7; see docs/theory/robust.md.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from einschalt.foundations.batches import over_segments
from einschalt.foundations.kernels import compiled
from einschalt.theory.adjustment.norms import FAMILIES
from einschalt.theory.adjustment.robust import (
    LEAST_FACTOR,
    MOST_ITERATIONS,
    TOLERANCE,
    RobustFit,
    usual_length,
)
from einschalt.theory.transformation.plane_fit import as_floats

ROBUST_KINDS = ("affine", "helmert", "rigid")
AFFINE, RIGID = ROBUST_KINDS.index("affine"), ROBUST_KINDS.index("rigid")
TUKEY = FAMILIES.index("tukey")
THINNEST = 1e-10
INSERTED = 64  # more points than that are sorted by numpy, once

_compiled = partial(
    compiled,
    error_model="numpy",
    fastmath={"reassoc", "contract", "arcp", "nsz"},
    # with free sums a callee must exist once: see coplanarity_condition
    forceinline=True,
)


def fit_plane_robustly(points, fit_of, norm, start_weights=None):
    """Iteratively reweighted least squares of all models at once.

    ``fit_of`` fits CommonPoints by one of ROBUST_KINDS, ``norm`` is of one of FAMILIES.
    ``start_weights`` (n_points,) are the weights to begin with; a norm that gives the
    weight 0 needs good ones. The result is that of ``fit_robustly``.
    """
    plain = fit_of(points)
    source, target, given = as_floats(points.source, points.target, points.weights)
    begun = given if start_weights is None else start_weights
    weights = np.where(plain.redundancy[points.model] > 0, begun, given)
    is_converged = np.ones(len(points.start) - 1, dtype=bool)
    over_segments(
        _reweigh,
        points.start,
        *(source, target, given),
        *(plain.redundancy, usual_length(plain, points)),
        np.array([ROBUST_KINDS.index(plain.kind), FAMILIES.index(norm.family)]),
        *(np.array([norm.limit]), weights, is_converged),
    )
    fit = fit_of(replace(points, weights=weights))
    consistent = replace(fit, sum_of_squares=fit.sum_of_squares / norm.consistency)
    return RobustFit(consistent, weights, is_converged)


@_compiled()
def _reweigh(
    first, last, start, xy, en, given, spare, usual, codes, limit, weights, converged
):
    most = 0
    for k in range(first, last):
        most = max(most, start[k + 1] - start[k])
    own = np.empty((7, most))  # x, y, E, N, given weight, factor, length
    order = np.empty(most, dtype=np.int64)
    for k in range(first, last):
        low, n = start[k], start[k + 1] - start[k]
        if spare[k] <= 0:
            continue
        _centre(xy[low : low + n], en[low : low + n], own)
        for i in range(n):
            own[4, i] = given[low + i]
            own[5, i] = weights[low + i] / given[low + i]
            order[i] = i
        converged[k] = _iterate(own, order[:n], usual[k], codes, limit[0])
        for i in range(n):
            weights[low + i] = own[5, i] * given[low + i]


@_compiled()
def _iterate(own, order, usual, codes, limit):
    """Find the factors of one model; say whether they came to rest."""
    n = len(order)
    length, is_sorted = own[6][:n], False
    for _ in range(MOST_ITERATIONS):
        _lengths(own, n, codes[0])
        scale = _median(length, order, is_sorted) / usual
        is_sorted = True
        # where half of the points fit exactly there is no scale: nothing is changed
        bound = limit * scale if scale > 0.0 else np.inf
        if _weigh(length, own[5][:n], bound, codes[1]) == 0:
            return True
    return False


@_compiled()
def _centre(xy, en, own):
    n = len(xy)
    x0, y0, e0, n0 = xy[0, 0], xy[0, 1], en[0, 0], en[0, 1]
    x = y = e = north = 0.0
    for i in range(n):
        x += xy[i, 0] - x0
        y += xy[i, 1] - y0
        e += en[i, 0] - e0
        north += en[i, 1] - n0
    x0, y0, e0, n0 = x0 + x / n, y0 + y / n, e0 + e / n, n0 + north / n
    for i in range(n):
        own[0, i], own[1, i] = xy[i, 0] - x0, xy[i, 1] - y0
        own[2, i], own[3, i] = en[i, 0] - e0, en[i, 1] - n0


@_compiled()
def _lengths(own, count, kind):
    """Lengths of the residuals of the weighted fit, over the given standard errors."""
    x, y, e, n = own[0][:count], own[1][:count], own[2][:count], own[3][:count]
    given, factor, length = own[4][:count], own[5][:count], own[6][:count]
    w = sx = sy = se = sn = 0.0
    xx = xy = yy = xe = xn = ye = yn = 0.0
    for i in range(count):
        p = given[i] * factor[i]
        px, py = p * x[i], p * y[i]
        w, sx, sy = w + p, sx + px, sy + py
        se, sn = se + p * e[i], sn + p * n[i]
        xx, xy, yy = xx + px * x[i], xy + px * y[i], yy + py * y[i]
        xe, xn = xe + px * e[i], xn + px * n[i]
        ye, yn = ye + py * e[i], yn + py * n[i]
    sx, sy, se, sn = sx / w, sy / w, se / w, sn / w
    xx, xy, yy = xx - w * sx * sx, xy - w * sx * sy, yy - w * sy * sy
    xe, xn = xe - w * sx * se, xn - w * sx * sn
    ye, yn = ye - w * sy * se, yn - w * sy * sn
    to_e, to_n, is_determined = _matrix(xx, xy, yy, xe, xn, ye, yn, kind)
    for i in range(count):
        dx, dy = x[i] - sx, y[i] - sy
        v_e = to_e[0] * dx + to_e[1] * dy - (e[i] - se)
        v_n = to_n[0] * dx + to_n[1] * dy - (n[i] - sn)
        length[i] = np.sqrt(given[i] * (v_e * v_e + v_n * v_n))
    if not is_determined:  # too many points have lost their weight
        length[:] = 0.0


@_compiled()
def _matrix(xx, xy, yy, xe, xn, ye, yn, kind):
    """Rows of the transformation's matrix, and whether the points determine it."""
    if kind == AFFINE:
        d = xx * yy - xy * xy
        to_e = (yy * xe - xy * ye) / d, (xx * ye - xy * xe) / d
        to_n = (yy * xn - xy * yn) / d, (xx * yn - xy * xn) / d
        return to_e, to_n, 4.0 * d > THINNEST * (xx + yy) ** 2
    a, b = xe + yn, xn - ye
    size = np.sqrt(a * a + b * b) if kind == RIGID else xx + yy
    return (a / size, -b / size), (b / size, a / size), size > 0.0


@_compiled()
def _median(values, order, is_sorted):
    """Median; the places in the middle are mostly those of the last time."""
    n = len(values)
    low, high = values[order[(n - 1) // 2]], values[order[n // 2]]
    if is_sorted:
        n_below = n_above = 0
        for i in range(n):
            n_below += values[i] < low
            n_above += values[i] > high
        if low <= high and n_below == (n - 1) // 2 == n_above:
            return 0.5 * (low + high)
    if n > INSERTED and not is_sorted:
        order[:] = np.argsort(values)
    else:
        _insert(values, order)
    return 0.5 * (values[order[(n - 1) // 2]] + values[order[n // 2]])


@_compiled()
def _insert(values, order):
    for i in range(1, len(order)):
        row = order[i]
        value, j = values[row], i
        while j > 0 and values[order[j - 1]] > value:
            order[j] = order[j - 1]
            j -= 1
        order[j] = row


@_compiled()
def _weigh(length, factor, bound, family):
    """Find new factors; count those that have moved."""
    n_moved = 0
    for i in range(len(length)):
        if family == TUKEY:
            part = length[i] / bound
            rest = max(1.0 - part * part, 0.0)
            new = rest * rest
        else:
            new = bound / max(length[i], bound) if bound < np.inf else 1.0
        new = max(new, LEAST_FACTOR)
        n_moved += abs(new - factor[i]) > TOLERANCE
        factor[i] = new
    return n_moved
