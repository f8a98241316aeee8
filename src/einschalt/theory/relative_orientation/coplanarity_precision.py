"""Precision of an orientation from the rows of its conditions.

With the rows j, variances q of the conditions and weights w the cofactors of the five
parameters are

    C = N^-1 (sum w^2 q j j.T) N^-1,     N = sum w j j.T,

with w = 1/q just N^-1. N itself is never formed: its smallest eigenvalue, which decides
whether the points determine the orientation, would drown in the rounding of its largest
where points lie near a dangerous surface, and variances could come out negative.
Instead the rows are turned one by one into a triangle R with R.T R = N (Givens), which
has only the square root of that range, and with x = N^-1 j = R^-1 (R^-T j)

    C = sum w^2 q x x.T

is a sum of squares: no rounding makes a variance negative.

Source: G. H. Golub, C. F. Van Loan: Matrix Computations, chapter 5.
"""

import math

import numpy as np

from einschalt.foundations.kernels import compiled
from einschalt.theory.relative_orientation.coplanarity_condition import COMPILED

N_PARAMETERS = 5
# a column that the others explain but for this part of its length is nothing but them:
# far above rounding, and far below what an orientation needs that is of any use
DEPENDENT = 1e-12


@compiled(**COMPILED)
def fill_precision(rows, weights, strengths, tangents, numbers, cofactor):
    """Cofactors of base vector and turn, and redundancy numbers of the conditions.

    From the ``rows`` j (n, 5), the ``weights`` w >= 0, the ``strengths`` w^2 q and the
    derivatives of the base vector by its two parameters, ``tangents``. ``numbers`` is
    filled with ``1 - w j.T N^-1 j``, at least 0, and ``cofactor`` (6, 6) with NaN where
    the points do not determine it.
    """
    inverse = invert_triangle(triangle_of(rows, weights))
    cofactor[:], numbers[:] = 0.0, np.nan
    if math.isnan(inverse[0, 0]):
        cofactor[:] = np.nan
        return
    y, v = np.empty(N_PARAMETERS), np.empty(6)
    for i in range(len(rows)):
        square = 0.0
        for k in range(N_PARAMETERS):
            y[k] = 0.0
            for m in range(k + 1):
                y[k] += inverse[m, k] * rows[i, m]
            square += y[k] * y[k]
        # a projection is at most 1, but for rounding
        numbers[i] = max(1.0 - weights[i] * square, 0.0)
        _spread(inverse, y, tangents, v)
        for a in range(6):
            for b in range(a + 1):
                cofactor[a, b] += strengths[i] * v[a] * v[b]
    for a in range(6):
        for b in range(a):
            cofactor[b, a] = cofactor[a, b]


@compiled(**COMPILED)
def triangle_of(rows, weights):
    """Upper triangle R with R.T R = sum w j j.T, shape (5, 5)."""
    triangle, rest = np.empty((N_PARAMETERS, N_PARAMETERS)), np.empty(N_PARAMETERS)
    triangle[:] = 0.0
    for i in range(len(rows)):
        size = math.sqrt(weights[i])
        for k in range(N_PARAMETERS):
            rest[k] = size * rows[i, k]
        for k in range(N_PARAMETERS):
            old, new = triangle[k, k], rest[k]
            length = math.sqrt(old * old + new * new)
            if length == 0.0:
                continue
            cosine, sine = old / length, new / length
            for m in range(k, N_PARAMETERS):
                old, new = triangle[k, m], rest[m]
                triangle[k, m] = cosine * old + sine * new
                rest[m] = cosine * new - sine * old
    return triangle


@compiled(**COMPILED)
def invert_triangle(triangle):
    """Inverse of an upper triangle; NaN where its columns depend on each other."""
    inverse = np.empty((N_PARAMETERS, N_PARAMETERS))
    inverse[:] = 0.0
    for k in range(N_PARAMETERS):
        length = 0.0
        for m in range(k + 1):
            length += triangle[m, k] * triangle[m, k]
        # the comparison fails for NaN, too
        if not triangle[k, k] > DEPENDENT * math.sqrt(length):
            inverse[:] = np.nan
            return inverse
        inverse[k, k] = 1.0 / triangle[k, k]
        for m in range(k):
            total = 0.0
            for p in range(m, k):
                total += inverse[m, p] * triangle[p, k]
            inverse[m, k] = -total * inverse[k, k]
    return inverse


@compiled(**COMPILED)
def _spread(inverse, y, tangents, v):
    """What x = R^-1 y means for base vector and turn."""
    x = np.empty(N_PARAMETERS)
    for k in range(N_PARAMETERS):
        x[k] = 0.0
        for m in range(k, N_PARAMETERS):
            x[k] += inverse[k, m] * y[m]
    for a in range(3):
        v[a] = tangents[a] * x[0] + tangents[3 + a] * x[1]
        v[3 + a] = x[2 + a]
