"""Krames' extended formulas with their factors, as the paper has them."""

from dataclasses import dataclass

import numpy as np

from einschalt.theory.relative_orientation.krames import elements_of_planes
from einschalt.theory.relative_orientation.parallax_equations import (
    DEPENDENT_LEFT,
    INDEPENDENT,
    N_ELEMENTS,
)
from einschalt.theory.relative_orientation.six_points import N_SIX


@dataclass(frozen=True, eq=False)
class ExtendedFormulas:
    """Krames' formulas a)-k) as (5): element = Σ (s + K t) p."""

    # (..., 5, 6): the element without its factor; each plane's G with that plane's dω
    s: np.ndarray
    t: np.ndarray  # (..., 6): the contradiction: Δω = Σ t p
    # (..., 5): K of each: A, B1, B2, C1, C2 of an independent pair, or D to H
    factors: np.ndarray

    @property
    def solution(self):
        """Coefficients s + K t of the elements, ndarray, shape (..., 5, 6)."""
        return self.s + self.factors[..., :, None] * self.t[..., None, :]

    @property
    def cofactor(self):
        """Q = s·s - (s·t)²/t·t of all pairs of elements, ndarray (..., 5, 5)."""
        s_t = np.einsum("...ij,...j->...i", self.s, self.t)
        t_t = np.sum(self.t**2, axis=-1)[..., None, None]
        products = self.s @ np.swapaxes(self.s, -1, -2)
        return products - s_t[..., :, None] * s_t[..., None, :] / t_t


def extended_formulas(planes, base, case):
    """Krames' extended formulas with the factors of (7), for any terrain.

    Infinite or NaN where a plane is critical (N = 0), and inaccurate near it;
    :func:`solve_krames` is not.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        m, u, v = (row / planes.N[..., None] for row in (planes.m, planes.u, planes.v))
        t = of_six(m * np.array([[1.0], [-1.0]]))
        values = np.zeros((*t.shape[:-1], N_ELEMENTS, N_SIX))
        values[..., 0, :] = of_six(m) / 2.0
        for plane in range(2):
            own = slice(3 * plane, 3 * plane + 3)
            values[..., 1 + 2 * plane, own] = u[..., plane, :]
            values[..., 2 + 2 * plane, own] = v[..., plane, :]
        s = elements_of_planes(base, case) @ values
        s_t = np.einsum("...ij,...j->...i", s, t)
        return ExtendedFormulas(s, t, -s_t / np.sum(t**2, axis=-1)[..., None])


def flat_factors(half_width, base, height, case):
    """Factors of the flat six-point model in closed form, a')-k'), (5,).

    A, B1, B2, C1, C2 or D, E, F, G, H, from a, b and h of the flat model. The paper
    prints G and H of the right bundle only.
    """
    c = (2.0 * half_width**2 + 3.0 * height**2) / (6.0 * height)
    if case == INDEPENDENT:
        return np.array([0.0, 0.0, 0.0, -c / base, c / base])
    shift = c if case == DEPENDENT_LEFT else -c
    return np.array([0.0, 0.0, -2.0 * c / base, shift, 0.0])


def of_six(by_plane):
    """Values of three points in each of two planes, in one row."""
    return by_plane.reshape(*by_plane.shape[:-2], N_SIX)
