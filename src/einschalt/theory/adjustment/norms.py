"""Weights that robust fits give to observations with large residuals.

Both are tuned to lose 5 % of the information of clean, normally distributed points.
The residual of a point has two or three coordinates and gets one weight, so that the
limits are those of a vector's length; the usual 1.345 and 4.685 are for one coordinate.

Sources: Huber 1964; Beaton and Tukey 1974; limits for vectors from
eff = (E[ψ′ + (k − 1) ψ/r] / k)² / (E[ψ²] / k), see docs/theory/robust.md.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

# of normal errors: standard error over the median of their sizes, and median length of
# a vector in the plane over the standard error of a coordinate
SIGMA_PER_MEDIAN = 1.4826
RAYLEIGH_MEDIAN = np.sqrt(2.0 * np.log(2.0))


@dataclass(frozen=True)
class Norm:
    """One way to weigh residuals."""

    # from the length of residuals, in standard errors of one coordinate, to factors of
    # their weights, 0 to 1. ``statsmodels.robust.norms`` has many more
    weights: Callable
    consistency: float  # E[factor · length²] / k of clean points with k coordinates
    family: str = ""  # one of FAMILIES, or empty where ``weights`` is another function
    limit: float = np.nan


def huber_factors(length, limit=1.345):
    """Factor 1 up to the limit, then limit / length."""
    return limit / np.maximum(length, limit)


def tukey_factors(length, limit=4.685):
    """Factor (1 − (length / limit)²)², and 0 beyond the limit: Tukey's biweight."""
    return np.maximum(1.0 - (length / limit) ** 2, 0.0) ** 2


_FACTORS = {"huber": huber_factors, "tukey": tukey_factors}
FAMILIES = tuple(_FACTORS)


def _of(family, limit, consistency):
    factors = _FACTORS[family]
    return Norm(lambda length: factors(length, limit), consistency, family, limit)


# by the number of coordinates
HUBER = {
    1: _of("huber", 1.345, 0.8214),
    2: _of("huber", 1.501, 0.8013),
    3: _of("huber", 1.628, 0.7814),
}
TUKEY = {
    1: _of("tukey", 4.685, 0.7578),
    2: _of("tukey", 5.123, 0.7300),
    3: _of("tukey", 5.490, 0.7068),
}
