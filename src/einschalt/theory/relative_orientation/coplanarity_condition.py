"""The coplanarity condition of two rays, its normal equations and one Gauss step.

Image coordinates are divided by the principal distance of the left camera, so that
the rays are ``u = (x', y', -1)`` and ``v = R (x", y", -c"/c')``, both in the system of
the left image. ``R = M.T`` turns the rays of the right camera into the left system;
e is the unit vector of the base from left to right. The condition is

    F = e . (u x v) = 0,     dF/de = u x v,     dF/dw = v x (e x u),

w being a small right-handed turn of the right camera. Where observations are adjusted,
F is taken at the corrected coordinates (Gauss-Helmert model), with

    dF/d(x', y') = (v x e)_12,     dF/d(x", y") = [R.T (e x u)]_12.

What travels between the functions are tuples, which the compiler keeps in registers:

pose
    ``(e, R)``: 3 floats, and 9 floats row by row.
frame
    ``(base, tangents, R)``: base vector, its derivatives along the two parameters of
    its direction (6 floats), and R.
sums
    21 floats: lower triangle of the 5 x 5 normal matrix (15), gradient (5), sum of
    squares. The five parameters are two of the direction of the base, then w.

Source: any text-book on relative orientation. The minimal parameters on the sphere and
on the rotation group spare the choice of a base component that must not vanish.
"""

import math
from typing import NamedTuple

from einschalt.foundations.kernels import compiled

# sums may be regrouped; NaN and infinity keep their meaning
FAST = {"reassoc", "contract", "arcp", "nsz"}
COMPILED = {
    "error_model": "numpy",
    # a callee that is not inlined exists twice, its own copy and the caller's, and
    # with FAST they differ in the last bits: the run that compiles would call the one,
    # the runs that load from the cache the other
    "forceinline": True,
}
NO_SUMS = (0.0,) * 21
DIAGONAL = (0, 2, 5, 9, 14)
GRADIENT = 15
SQUARES = 20
COS_45 = math.sqrt(0.5)


class Mode(NamedTuple):
    """What is minimised."""

    # conditions have the weight of their image coordinates, otherwise 1
    is_weighted: bool
    # 1 where the observations are corrected, 0 where the condition is linearised at the
    # observations as measured
    keep: float
    # the x of the base is fixed, not its length, where the base is within 45° of x
    fixes_x: bool


# corrected observations; first-order weights only (Sampson); lecture notes
GAUSS_HELMERT = Mode(True, 1.0, False)
FIRST_ORDER = Mode(True, 0.0, False)
DETERMINANTS = Mode(False, 0.0, True)


@compiled(**COMPILED)
def frame_of(pose, fixes_x):
    """Base vector with its two derivatives, and rotation, of a pose.

    The tangents are the orthonormal basis of Duff et al. 2017 (Building an Orthonormal
    Basis, Revisited; Journal of Computer Graphics Techniques 6(1)). With ``fixes_x``
    the base is scaled so that its x is 1, where it lies within 45 degrees of x: the
    unweighted determinants depend on which length is fixed, and lecture notes fix bx.
    """
    base, rotation = pose
    x, y, z = base
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    s0, s1, s2 = 1.0 + sign * x * x * a, sign * x * y * a, -sign * x
    t0, t1, t2 = x * y * a, sign + y * y * a, -y
    if fixes_x and x >= COS_45:
        y, z = y / x, z / x
        s1, s2 = (s1 - y * s0) / x, (s2 - z * s0) / x
        t1, t2 = (t1 - y * t0) / x, (t2 - z * t0) / x
        x = 1.0
        s0 = t0 = 0.0
    return (x, y, z), (s0, s1, s2, t0, t1, t2), rotation


@compiled(**COMPILED)
def moved(pose, step):
    """Pose after a step of its five parameters.

    The rotation is Cayley's: that of a turn by w up to the third order of w, and
    orthogonal at any length of w.
    """
    (x, y, z), (s0, s1, s2, t0, t1, t2), r = frame_of(pose, False)
    p, q = step[0], step[1]
    x, y, z = x + p * s0 + q * t0, y + p * s1 + q * t1, z + p * s2 + q * t2
    length = math.sqrt(x * x + y * y + z * z)
    half = (0.5 * step[2], 0.5 * step[3], 0.5 * step[4])
    return (x / length, y / length, z / length), product(cayley(half), r)


@compiled(**COMPILED)
def cayley(half):
    """Rotation matrix of the quaternion (1, half), not normalised before."""
    a, b, c = half
    f = 2.0 / (1.0 + a * a + b * b + c * c)
    top = 1.0 - f * (b * b + c * c), f * (a * b - c), f * (a * c + b)
    middle = f * (a * b + c), 1.0 - f * (a * a + c * c), f * (b * c - a)
    bottom = f * (a * c - b), f * (b * c + a), 1.0 - f * (a * a + b * b)
    return top + middle + bottom


@compiled(**COMPILED)
def product(first, second):
    """Product of two 3 x 3 matrices, row by row."""
    a, b, c, d, e, f, g, h, i = first
    j, k, m, n, o, p, q, r, s = second
    top = a * j + b * n + c * q, a * k + b * o + c * r, a * m + b * p + c * s
    middle = d * j + e * n + f * q, d * k + e * o + f * r, d * m + e * p + f * s
    bottom = g * j + h * n + i * q, g * k + h * o + i * r, g * m + h * p + i * s
    return top + middle + bottom


@compiled(fastmath=FAST, **COMPILED)
def right_ray(x, y, z, rotation):
    """Ray of the right camera in the system of the left image."""
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = rotation
    return (
        r00 * x + r01 * y + r02 * z,
        r10 * x + r11 * y + r12 * z,
        r20 * x + r21 * y + r22 * z,
    )


@compiled(fastmath=FAST, **COMPILED)
def coplanarity(point, zr, base, rotation):
    """Condition of one point and all its derivatives.

    ``point`` is x', y', x", y" over the left principal distance, ``zr`` the z of the
    right image plane, -c"/c'. Gives F, dF/de (3), dF/dw (3), dF/d(x', y', x", y") (4).
    """
    xl, yl, xr, yr = point
    b0, b1, b2 = base
    r00, r01, _, r10, r11, _, r20, r21, _ = rotation
    v0, v1, v2 = right_ray(xr, yr, zr, rotation)
    # a = u x v and m = e x u, with u = (xl, yl, -1)
    a0, a1, a2 = yl * v2 + v1, -v0 - xl * v2, xl * v1 - yl * v0
    m0, m1, m2 = -b1 - b2 * yl, b2 * xl + b0, b0 * yl - b1 * xl
    by_turn = (v1 * m2 - v2 * m1, v2 * m0 - v0 * m2, v0 * m1 - v1 * m0)
    by_image = (
        v1 * b2 - v2 * b1,
        v2 * b0 - v0 * b2,
        r00 * m0 + r10 * m1 + r20 * m2,
        r01 * m0 + r11 * m1 + r21 * m2,
    )
    return b0 * a0 + b1 * a1 + b2 * a2, (a0, a1, a2), by_turn, by_image


@compiled(fastmath=FAST, **COMPILED)
def parameter_row(by_base, by_turn, tangents):
    """dF/d(five parameters) from dF/de and dF/dw."""
    a0, a1, a2 = by_base
    s0, s1, s2, t0, t1, t2 = tangents
    along_first = s0 * a0 + s1 * a1 + s2 * a2
    along_second = t0 * a0 + t1 * a1 + t2 * a2
    return along_first, along_second, by_turn[0], by_turn[1], by_turn[2]


@compiled(fastmath=FAST, **COMPILED)
def add_condition(sums, row, f, weight):
    """Sums with one more condition, of the misclosure f."""
    a, b, c, d, e = row
    wa, wb, wc, wd, we = weight * a, weight * b, weight * c, weight * d, weight * e
    to_b = sums[0] + wa * a, sums[1] + wb * a, sums[2] + wb * b
    of_c = sums[3] + wc * a, sums[4] + wc * b, sums[5] + wc * c
    of_d = sums[6] + wd * a, sums[7] + wd * b, sums[8] + wd * c, sums[9] + wd * d
    of_e = sums[10] + we * a, sums[11] + we * b, sums[12] + we * c, sums[13] + we * d
    more = sums[14] + we * e, sums[15] + wa * f, sums[16] + wb * f, sums[17] + wc * f
    last = sums[18] + wd * f, sums[19] + we * f, sums[20] + weight * f * f
    return to_b + of_c + of_d + of_e + more + last


@compiled(fastmath=FAST, **COMPILED)
def form_normals(image, corrections, zr, frame, mode):
    """The 21 sums of all points of a pair at one pose.

    ``image`` (4, n) is x', y', x", y" over the left principal distance. ``corrections``
    (4, n), at which the condition is linearised, are replaced, times ``mode.keep``, by
    those of the smallest length that close the linearised condition.
    """
    base, tangents, rotation = frame
    sums = NO_SUMS
    for i in range(image.shape[1]):
        c0, c1 = corrections[0, i], corrections[1, i]
        c2, c3 = corrections[2, i], corrections[3, i]
        point = image[0, i] + c0, image[1, i] + c1, image[2, i] + c2, image[3, i] + c3
        f, by_base, by_turn, by_image = coplanarity(point, zr, base, rotation)
        d0, d1, d2, d3 = by_image
        inverse = 1.0 / (d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3)
        misclosure = f - (d0 * c0 + d1 * c1 + d2 * c2 + d3 * c3)
        row = parameter_row(by_base, by_turn, tangents)
        weight = inverse if mode.is_weighted else 1.0
        sums = add_condition(sums, row, misclosure, weight)
        closing = -mode.keep * inverse * misclosure
        corrections[0, i] = closing * d0
        corrections[1, i] = closing * d1
        corrections[2, i] = closing * d2
        corrections[3, i] = closing * d3
    return sums


@compiled(**COMPILED)
def factorise(sums, damping):
    """Cholesky factor of the normal matrix with its diagonal times 1 + damping.

    Lower triangle row by row (15 floats), with the RECIPROCALS of the diagonal. NaN
    where the matrix is not positive definite.
    """
    more = 1.0 + damping
    l00 = 1.0 / math.sqrt(sums[0] * more)
    l10 = sums[1] * l00
    l11 = 1.0 / math.sqrt(sums[2] * more - l10 * l10)
    l20 = sums[3] * l00
    l21 = (sums[4] - l20 * l10) * l11
    l22 = 1.0 / math.sqrt(sums[5] * more - l20 * l20 - l21 * l21)
    l30 = sums[6] * l00
    l31 = (sums[7] - l30 * l10) * l11
    l32 = (sums[8] - l30 * l20 - l31 * l21) * l22
    l33 = 1.0 / math.sqrt(sums[9] * more - l30 * l30 - l31 * l31 - l32 * l32)
    l40 = sums[10] * l00
    l41 = (sums[11] - l40 * l10) * l11
    l42 = (sums[12] - l40 * l20 - l41 * l21) * l22
    l43 = (sums[13] - l40 * l30 - l41 * l31 - l42 * l32) * l33
    rest = sums[14] * more - l40 * l40 - l41 * l41 - l42 * l42 - l43 * l43
    l44 = 1.0 / math.sqrt(rest)
    return l00, l10, l11, l20, l21, l22, l30, l31, l32, l33, l40, l41, l42, l43, l44


@compiled(**COMPILED)
def reduce_side(factor, right_side):
    """L^-1 times a right side: its square is that of N^-1, and never negative."""
    l00, l10, l11, l20, l21, l22, l30, l31, l32, l33, l40, l41, l42, l43, l44 = factor
    y0 = right_side[0] * l00
    y1 = (right_side[1] - l10 * y0) * l11
    y2 = (right_side[2] - l20 * y0 - l21 * y1) * l22
    y3 = (right_side[3] - l30 * y0 - l31 * y1 - l32 * y2) * l33
    y4 = (right_side[4] - l40 * y0 - l41 * y1 - l42 * y2 - l43 * y3) * l44
    return y0, y1, y2, y3, y4


@compiled(**COMPILED)
def solve(factor, right_side):
    """Solution of the normal equations with a factorised matrix."""
    l00, l10, l11, l20, l21, l22, l30, l31, l32, l33, l40, l41, l42, l43, l44 = factor
    y0, y1, y2, y3, y4 = reduce_side(factor, right_side)
    x4 = y4 * l44
    x3 = (y3 - l43 * x4) * l33
    x2 = (y2 - l42 * x4 - l32 * x3) * l22
    x1 = (y1 - l41 * x4 - l31 * x3 - l21 * x2) * l11
    x0 = (y0 - l40 * x4 - l30 * x3 - l20 * x2 - l10 * x1) * l00
    return x0, x1, x2, x3, x4


@compiled(**COMPILED)
def square_of(side):
    """Sum of the squares of five numbers."""
    a, b, c, d, e = side
    return a * a + b * b + c * c + d * d + e * e


@compiled(**COMPILED)
def descent_step(sums, damping):
    """Damped Gauss-Newton step, and by how much it should lessen the sum of squares.

    The latter is gradient times step: the square of the step in units of its standard
    error, times the variance of unit weight. NaN where the normal matrix is singular.
    """
    factor = factorise(sums, damping)
    downhill = -sums[15], -sums[16], -sums[17], -sums[18], -sums[19]
    return solve(factor, downhill), square_of(reduce_side(factor, downhill))
