"""Confidence ellipses of points in plan.

With normally distributed errors of the covariance C a point lies with the probability
p inside the ellipse d.T C⁻¹ d = k², k² = -2 ln(1 - p) being the quantile of χ² with two
degrees of freedom. Its semi-axes are k times the roots of the eigenvalues of C: for
k = 1 (p = 0.393) it is the mean error ellipse.

See docs/theory/ellipses.md.
"""

from typing import NamedTuple

import numpy as np


class Ellipses(NamedTuple):
    """Ellipses about points."""

    semi_major: np.ndarray  # (n,) [m]
    semi_minor: np.ndarray  # (n,) [m]
    azimuth: np.ndarray  # of the major axis, clockwise from north, 0 to π [rad]


def confidence_ellipses(covariance, confidence) -> Ellipses:
    """Ellipses that hold the true point with a given probability.

    Parameters
    ----------
    covariance : ndarray, shape (n, 2, 2)
        Of easting and northing [m²].
    confidence : float
        Between 0 and 1.

    Examples
    --------
    The mean error ellipse of a point that is known worse along north-east:

    >>> found = confidence_ellipses(np.array([[[5.0, 3.0], [3.0, 5.0]]]), 0.39346934)
    >>> [float(part[0].round(6)) for part in found]
    [2.828427, 1.414214, 0.785398]
    """
    factor = np.sqrt(-2.0 * np.log1p(-confidence))
    east, north = covariance[:, 0, 0], covariance[:, 1, 1]
    both = covariance[:, 0, 1]
    middle, half = (east + north) / 2.0, np.hypot((east - north) / 2.0, both)
    # a vanishing variance may come out as a little less than 0
    smaller = np.sqrt(np.maximum(middle - half, 0.0))
    azimuth = np.mod(0.5 * np.arctan2(2.0 * both, north - east), np.pi)
    return Ellipses(factor * np.sqrt(middle + half), factor * smaller, azimuth)


def ellipse_outlines(centres, ellipses, n_vertices=36):
    """Vertices of ellipses, anticlockwise, the first not repeated: (n, n_vertices, 2).

    ``centres`` (n, 2) are easting, northing.
    """
    turn = 2.0 * np.pi * np.arange(n_vertices) / n_vertices
    along = ellipses.semi_major[:, None] * np.cos(turn)
    # to the left of the major axis, so that the outline runs anticlockwise
    across = ellipses.semi_minor[:, None] * np.sin(turn)
    sin, cos = np.sin(ellipses.azimuth)[:, None], np.cos(ellipses.azimuth)[:, None]
    offset = np.stack([along * sin - across * cos, along * cos + across * sin], -1)
    return centres[:, None, :] + offset
