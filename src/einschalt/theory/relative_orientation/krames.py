"""Krames' formulas: the elements from two planes at right angles to the base.

Three points in the plane x = 0, or three in x = b, give by themselves a differential
tilt dω and a fundamental point G = (Y, Z), as

    y Y + z Z + p z / dω = y² + z²                                               (1)

holds for each of them. With determinants over the three points of a plane

    M = |y  z  pz|,   N = |y  z  y²+z²|,   U = |y²+z²  z  pz|,   V = |y  y²+z²  pz|

it is dω = M/N, Y = U/M, Z = V/M (2)-(4). Six parallaxes with errors give two tilts,
dω⁰ and dωᵇ, that contradict each other by Δω = dω⁰ - dωᵇ. Krames' extended formulas
a)-k) take every element as ``own value + factor · Δω`` and choose the factor that
makes its standard error smallest (7). As there are six observations for five unknowns,
nothing else is left to choose: the result is that of least squares, for any terrain.

What to use when: :func:`solve_krames` for the elements, which divides by none of M, N,
and gives what the factors A to H of the paper give (the tests have them);
:func:`fundamental_points` for the construction on paper, in which G may lie at
infinity. Everywhere in this module the
points follow each other as **1, 3, 5, 2, 4, 6**; conventions, cases and signs are those
of :mod:`einschalt.theory.relative_orientation.parallax_equations`.

Source: J. Krames 1951, doi 10.5169/seals-208362. In the line after his (4) the
numerators must be V, not those of Y.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.theory.relative_orientation.hallert import LARGEST_CONDITION
from einschalt.theory.relative_orientation.parallax_equations import (
    DEPENDENT_LEFT,
    INDEPENDENT,
    N_ELEMENTS,
    design_matrix,
    element_scale,
)
from einschalt.theory.relative_orientation.six_points import N_SIX

_ROUNDING = 16.0 * np.finfo(float).eps
_SQRT_12 = np.sqrt(12.0)


@dataclass(frozen=True, eq=False)
class PlaneDeterminants:
    """Three points in each of two planes, and their determinants.

    The last axis counts the points of a plane, the one before it the planes x = 0 and
    x = b. A determinant that is linear in the parallaxes is kept as its coefficients:
    ``M = Σ m p``, and so with U and V.
    """

    # both (..., 2, 3): coordinates in the plane, from the projection centre
    y: np.ndarray
    z: np.ndarray
    # (..., 2): 0 where the points lie on a circle with the projection centre: the plane
    # by itself then knows nothing of dω
    N: np.ndarray
    m: np.ndarray  # all (..., 2, 3): coefficients of M, U and V
    u: np.ndarray
    v: np.ndarray

    @property
    def q(self):
        """Sum of the squared coefficients of M, ndarray, shape (..., 2).

        N²/q is the weight of the plane's own dω.
        """
        return np.sum(self.m**2, axis=-1)


def plane_determinants(xyz):
    """Form the determinants of both planes from points 1, 3, 5, 2, 4, 6.

    ``xyz`` (..., 6, 3), of which x is not looked at.

    Examples
    --------
    >>> from einschalt.theory.relative_orientation.hallert import flat_six_points
    >>> planes = plane_determinants(flat_six_points(95.0, 92.0, 152.0))
    >>> planes.N.tolist() == [2 * 95.0**3 * 152.0] * 2
    True
    """
    xyz = np.asarray(xyz, dtype=float)
    yz = xyz[..., 1:].reshape(*xyz.shape[:-2], 2, 3, 2)
    y, z = yz[..., 0], yz[..., 1]
    square = y**2 + z**2
    cross = np.cross(y, z)
    return PlaneDeterminants(
        y=y,
        z=z,
        N=_sum(cross * square),
        m=z * cross,
        u=z * np.cross(square, z),
        v=z * np.cross(y, square),
    )


def _sum(terms):
    """Sum over the last axis; exactly 0 where only rounding errors remain."""
    total = np.sum(terms, axis=-1)
    size = np.sum(np.abs(terms), axis=-1)
    return np.where(np.abs(total) <= _ROUNDING * size, 0.0, total)


def _by_plane(parallax):
    parallax = np.asarray(parallax, dtype=float)
    return parallax.reshape(*parallax.shape[:-1], 2, 3)


@dataclass(frozen=True, eq=False)
class FundamentalPoints:
    """What each plane says by itself; the last axis is x = 0, x = b."""

    # both (..., 2): the points G⁰ and Gᵇ opposite the projection centre on the circle
    # of zero parallax; infinite or NaN where M = 0 (no parallax that a tilt would
    # explain), although all elements are then finite
    Y: np.ndarray
    Z: np.ndarray
    d_omega: np.ndarray  # (..., 2): dω⁰ and dωᵇ [rad]; infinite or NaN where N = 0
    M: np.ndarray  # (..., 2): 0 where dω is 0 in this plane

    @property
    def delta_omega(self):
        """Contradiction Δω = dω⁰ - dωᵇ [rad], ndarray, shape (...)."""
        with np.errstate(invalid="ignore"):
            return self.d_omega[..., 0] - self.d_omega[..., 1]


def fundamental_points(planes, parallax):
    """Find G⁰, Gᵇ and the differential tilts of both planes, (2) to (4).

    ``parallax`` (..., 6) is ``y(moved) - y(fixed)`` in points 1, 3, 5, 2, 4, 6. For the
    construction and for reports; never for computing the elements.
    """
    p = _by_plane(parallax)
    M, U, V = (_sum(row * p) for row in (planes.m, planes.u, planes.v))
    with np.errstate(divide="ignore", invalid="ignore"):
        return FundamentalPoints(Y=U / M, Z=V / M, d_omega=M / planes.N, M=M)


@dataclass(frozen=True, eq=False)
class KramesSolution:
    """Elements of six-point models, and how well they are known."""

    # (..., 5): in the order of ``ELEMENTS[case]`` [rad, unit of the model]; NaN where
    # both planes are critical
    elements: np.ndarray
    # (..., 5, 5): weight coefficients Q; the covariance is sigma_0² Q
    cofactor: np.ndarray
    # (...): w, in the unit of the parallaxes; 2 p1 - p3 - p5 - 2 p2 + p4 + p6 in flat
    # terrain, and in any terrain so scaled that sigma_0 is |w|/√12
    contradiction: np.ndarray
    residuals: np.ndarray  # (..., 6): adjusted minus measured parallax
    redundancy_numbers: np.ndarray  # (..., 6): they sum to 1
    # (...): as that of Hallert's adjustment; infinite where both planes are critical
    condition: np.ndarray

    @property
    def sigma_0(self):
        """Standard error of one parallax, in its unit, ndarray, shape (...)."""
        return np.abs(self.contradiction) / _SQRT_12


def solve_krames(xyz, parallax, base, case):
    """Orient six-point models by their two planes, without normal equations.

    The factors of a)-k) remove from every element its share in the contradiction. That
    is one projection for all elements; written with the coefficients of N⁰ Nᵇ Δω = M⁰
    Nᵇ - Mᵇ N⁰ it divides neither by N nor by M, so that one critical plane does no
    harm. The result is that of least squares with equal weights.

    Parameters
    ----------
    xyz : ndarray, shape (..., 6, 3)
        Model coordinates of points 1, 3, 5 in the plane x = 0, and of 2, 4, 6 in the
        plane x = base; z < 0.
    parallax : ndarray, shape (..., 6)
        ``y(moved) - y(fixed)``: y_left - y_right, but **y_right - y_left** for
        ``dependent_right``.
    base : float or ndarray, shape (...)
    case : {"independent", "dependent_left", "dependent_right"}
    """
    xyz, parallax = np.asarray(xyz, dtype=float), np.asarray(parallax, dtype=float)
    planes = plane_determinants(xyz)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        direction, unexplained = _unexplained(planes, parallax)
        by_plane = _best_values_of_planes(planes, direction)
        solution = elements_of_planes(base, case) @ by_plane
        condition = _condition(xyz, solution, base, case)
        condition = np.where(np.isnan(condition), np.inf, condition)
    is_determined = condition <= LARGEST_CONDITION
    solution = np.where(is_determined[..., None, None], solution, np.nan)
    direction = np.where(is_determined[..., None], direction, np.nan)
    unexplained = np.where(is_determined, unexplained, np.nan)
    return KramesSolution(
        elements=np.einsum("...ij,...j->...i", solution, parallax),
        cofactor=solution @ np.swapaxes(solution, -1, -2),
        contradiction=_SQRT_12 * unexplained,
        residuals=-unexplained[..., None] * direction,
        redundancy_numbers=direction**2,
        condition=condition,
    )


def _unexplained(planes, parallax):
    """Unit vector along t, which no orientation can clear, and its part of p."""
    other_n = planes.N[..., ::-1] * np.array([1.0, -1.0])
    direction = _flat(planes.m * other_n[..., None])
    direction = direction / np.sqrt(np.sum(direction**2, axis=-1, keepdims=True))
    return direction, _sum(direction * parallax)


def _best_values_of_planes(planes, direction):
    """Coefficients, in the parallaxes, of dω, Y⁰dω, Z⁰dω, Yᵇdω, Zᵇdω.

    dω is the mean of both planes' values with their weights N²/q. Parallaxes from
    which the contradiction has been taken then leave with this dω, in each plane,
    three equations y (Y dω) + z (Z dω) = (y² + z²) dω - p z for two unknowns, and no
    misclosure.
    """
    best_tilt = _flat((planes.N / planes.q)[..., None] * planes.m)
    best_tilt = best_tilt / np.sum(planes.N**2 / planes.q, axis=-1)[..., None]
    y, z = planes.y, planes.z
    cross = np.cross(y, z)
    # shape (..., plane, Y or Z, point)
    towards = np.stack([np.cross(z, cross), np.cross(cross, y)], axis=-2)
    tilt = np.sum((y**2 + z**2)[..., None, :] * towards, axis=-1)
    free = np.eye(N_SIX) - direction[..., :, None] * direction[..., None, :]
    cleared = (z[..., None, :] * towards) @ free.reshape(*free.shape[:-2], 2, 3, N_SIX)
    shares = tilt[..., None] * best_tilt[..., None, None, :] - cleared
    shares = shares / np.sum(cross**2, axis=-1)[..., None, None]
    shares = shares.reshape(*shares.shape[:-3], 4, N_SIX)
    return np.concatenate([best_tilt[..., None, :], shares], axis=-2)


def _flat(by_plane):
    return by_plane.reshape(*by_plane.shape[:-2], N_SIX)


def _condition(xyz, solution, base, case):
    """Frobenius condition number of the equations with scaled columns."""
    scale = element_scale(-xyz[..., 2].mean(axis=-1), case)
    bases = np.broadcast_to(np.asarray(base, dtype=float)[..., None], xyz.shape[:-1])
    design = design_matrix(xyz, bases, case) / scale[..., None, :]
    inverse = solution * scale[..., :, None]
    return np.sqrt(np.sum(design**2, axis=(-1, -2)) * np.sum(inverse**2, axis=(-1, -2)))


def contradiction(planes, parallax):
    """Contradiction w of parallaxes (..., 6), which no orientation can clear.

    In the unit of the parallaxes, in points 1, 3, 5, 2, 4, 6; proportional to Δω and so
    scaled that sigma_0 is |w|/√12 in any terrain. In flat terrain it is 2 p1 - p3 - p5
    - 2 p2 + p4 + p6. NaN where both planes are critical.
    """
    parallax = np.asarray(parallax, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        return _SQRT_12 * _unexplained(planes, parallax)[1]


def elements_of_planes(base, case):
    """Matrix from dω, Y⁰dω, Z⁰dω, Yᵇdω, Zᵇdω to the elements: a)-k) without factors.

    Its shape is (..., 5, 5), that of ``base`` being (...).
    """
    base = np.asarray(base, dtype=float)
    matrix = np.zeros((*base.shape, N_ELEMENTS, N_ELEMENTS))
    matrix[..., 0, 0] = 1.0
    if case == INDEPENDENT:
        for element, value in ((1, 3), (2, 1), (3, 4), (4, 2)):
            matrix[..., element, value] = 1.0 / base
        return matrix
    for element, value in ((1, 1), (2, 2)):
        matrix[..., element, value] = -1.0 / base
        matrix[..., element, value + 2] = 1.0 / base
    own = 1 if case == DEPENDENT_LEFT else 3
    matrix[..., 3, own + 1] = 1.0
    matrix[..., 4, own] = -1.0
    return matrix


def trial_swing(planes, parallax, base):
    """Swing d_kappa of the right bundle [rad] after (9), tried before his factors.

    From ``y_right - y_left`` in points 1, 3, 5, 2, 4, 6, (..., 6). In flat terrain it
    is (p1 - p2)/b, whatever the other parallaxes: its standard error is √3 times that
    of least squares. In hilly terrain it is not even linear. NaN or infinite where it
    fails.
    """
    p = _by_plane(parallax)
    M, V = (_sum(row * p) for row in (planes.m, planes.v))
    p1, p2 = p[..., 0, 0], p[..., 1, 0]
    crossed = M[..., ::-1] * planes.N
    numerator = (p1 - p2) * (V[..., 1] * M[..., 0] - V[..., 0] * M[..., 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        return numerator / (base * (p1 * crossed[..., 0] - p2 * crossed[..., 1]))
