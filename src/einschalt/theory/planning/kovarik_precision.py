"""Precision before the flight: Kovarik's diagrams as formulas, and their turning point.

n points lie in a model, its transformation has the error m_t = m_0 √h, a transformed
point M² = (m_g · scale number)² + m_t². All errors are TOTAL, all lengths metres, m_g
too. Nothing here knows of single points.

See docs/theory/precision_planning.md.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from einschalt.theory.error_budget import total_error
from einschalt.theory.planning.leverage import (
    PlannedLeverage,
    corner_factor,
    lattice_leverage,
    mid_edge_factor,
)

EDGES = ("kovarik", "mid_edge", "corner", "lattice")
KOVARIK_FACTOR = 2.0
"""m_t at the edge over m_t in the middle that fits the printed values of 1971."""
FEW_POINTS = 12.0
"""Below so many points in a model an even spread is no picture of them."""
SEARCHED = np.geomspace(1.0, 1e4, 4001)  # image areas in spacings²
ROWS = np.arange(2.0, 101.0)
NARROWINGS = 60


@dataclass(frozen=True)
class PlannedModel:
    """A model as far as it is known before the flight."""

    kind: str = "affine"  # affine, helmert or rigid
    # one of EDGES: where a model's edge is looked at. ``kovarik`` counts the points on
    # the part that no neighbouring strip holds, the others on all of the overlap
    edge: str = "kovarik"
    image_format: tuple[float, float] = (0.23, 0.23)  # along and across the strip [m]
    forward_overlap: float = 0.60
    side_overlap: float = 0.30

    @property
    def extent(self) -> tuple[float, float]:
        """Extent on which points are counted, along and across the strip, image [m]."""
        along, across = self.image_format
        if self.edge == "kovarik":
            across = (1.0 - self.side_overlap) * across
        return self.forward_overlap * along, across

    @property
    def area(self) -> float:
        """Area on which points are counted, in the image [m²]."""
        along, across = self.extent
        return along * across

    @property
    def edge_factor(self) -> float:
        """m_t at the edge over m_t in the middle for an even spread.

        NaN for the lattice, where it depends on the number of points.
        """
        if self.edge == "kovarik":
            return KOVARIK_FACTOR
        if self.edge == "mid_edge":
            return float(np.sqrt(mid_edge_factor(self.kind, self.extent)))
        if self.edge == "corner":
            return float(np.sqrt(corner_factor(self.kind)))
        return np.nan

    def n_points(
        self, scale_number: ArrayLike, spacing: ArrayLike
    ) -> float | np.ndarray:
        """Mean number of points in a model, not rounded; spacing in metres."""
        return self.area * np.square(np.divide(scale_number, spacing))

    def leverage(self, scale_number: ArrayLike, spacing: ArrayLike) -> PlannedLeverage:
        """Leverage in the middle and at the edge."""
        if self.edge == "lattice":
            in_spacings = np.divide(scale_number, spacing)
            along, across = self.extent
            return lattice_leverage(
                self.kind, in_spacings * along, in_spacings * across
            )
        centre = 1.0 / self.n_points(scale_number, spacing)
        return PlannedLeverage(centre, self.edge_factor**2 * centre)


@dataclass(frozen=True, eq=False)
class PlannedPrecision:
    """What is to be expected of a flight after Kovarik; metres, TOTAL.

    One number of one flight, of many arrays as they were broadcast.
    """

    n_points: float | np.ndarray  # in a model
    m_g_ground: float | np.ndarray  # measuring error on the ground
    m_t_centre: float | np.ndarray  # from the transformation
    m_t_edge: float | np.ndarray
    M_centre: float | np.ndarray  # both together
    M_edge: float | np.ndarray
    # mean of two values, one from the middle of a model, one from the edge of one of
    # the other coverage
    M_double: float | np.ndarray


def planned_precision(scale_number, spacing, m_0, m_g, model) -> PlannedPrecision:
    """Precision of transformed points after Kovarik 1971.

    Parameters
    ----------
    scale_number, spacing, m_0, m_g : float or ndarray
        Broadcast against each other: denominator of the image scale, mean distance of
        points, error of the approximate coordinates, measuring error in the image [m].
    model : PlannedModel

    Notes
    -----
    Source: J. Kovarik 1971, diagrams 2 (n), 3 (m_t) and 4 a to d (M).

    Examples
    --------
    >>> planned = planned_precision(6000.0, 200.0, 0.10, 10e-6, PlannedModel())
    >>> round(float(planned.n_points), 4), round(float(planned.M_edge), 4)
    (19.9962, 0.0748)
    """
    leverage = model.leverage(scale_number, spacing)
    m_g_ground = np.multiply(m_g, scale_number)
    m_t_centre = m_0 * np.sqrt(leverage.centre)
    m_t_edge = m_0 * np.sqrt(leverage.edge)
    M_centre = total_error(m_g, scale_number, m_t_centre)
    M_edge = total_error(m_g, scale_number, m_t_edge)
    return PlannedPrecision(
        model.n_points(scale_number, spacing),
        m_g_ground,
        m_t_centre,
        m_t_edge,
        M_centre,
        M_edge,
        mean_of_coverages(M_centre, M_edge, 2),
    )


def mean_of_coverages(M_centre, M_edge, n_coverages):
    """Mean of k coverages, half of them seen from the middle, half from the edge.

    √((M_centre² + M_edge²)/(2 k)): independent errors, as the paper takes them.
    """
    return np.hypot(M_centre, M_edge) / np.sqrt(np.multiply(2.0, n_coverages))


def best_scale(spacing, m_0, m_g, model):
    """Scale number at which the edge of a model is most precise.

    A larger image scale makes the measuring error smaller, and leaves fewer points in
    a model. With M² = (m_g b)² + (k m_0 s)²/(A b²) the two balance at
    b² = k m_0 s/(m_g √A); there both parts are equal, M = √2 m_g b, and a larger scale
    loses accuracy.

    Parameters
    ----------
    spacing, m_0, m_g : float or ndarray
        Broadcast against each other [m].
    model : PlannedModel

    Returns
    -------
    ndarray

    Notes
    -----
    For the lattice the least of some 4200 sizes of a model is narrowed by golden
    sections:
    its leverage has no simple form, and several minima.

    Examples
    --------
    >>> round(float(best_scale(300.0, 0.10, 10e-6, PlannedModel())))
    6345
    """
    balance = np.divide(np.multiply(m_0, spacing), m_g)
    if model.edge != "lattice":
        return np.sqrt(model.edge_factor * balance / np.sqrt(model.area))
    spacings = np.broadcast_to(np.asarray(spacing, dtype=float), balance.shape)
    ratio, inverse = np.unique(
        np.multiply(m_g, spacing) / np.asarray(m_0, dtype=float), return_inverse=True
    )
    in_spacings = np.array([_best_size(model, weight) for weight in ratio])
    return in_spacings[inverse].reshape(balance.shape) * spacings


def _best_size(model, ratio):
    """Scale number over spacing at which (ratio · size)² + h is least."""

    def square(size):
        return (ratio * size) ** 2 + model.leverage(size, 1.0).edge

    # many minima are kinks, where a row of points comes into the model
    kinks = [ROWS / side for side in model.extent]
    sizes = np.unique(np.concatenate([np.sqrt(SEARCHED / model.area), *kinks]))
    place = int(np.argmin(square(sizes)))
    low, high = sizes[max(place - 1, 0)], sizes[min(place + 1, len(sizes) - 1)]
    golden = (np.sqrt(5.0) - 1.0) / 2.0
    for _ in range(NARROWINGS):
        inner = high - golden * (high - low), low + golden * (high - low)
        if square(inner[0]) < square(inner[1]):
            high = inner[1]
        else:
            low = inner[0]
    candidates = np.array([(low + high) / 2.0, sizes[place]])
    return candidates[np.argmin(square(candidates))]


def settings_that_balance(m_g_ground, m_t):
    """Number of settings of a point at which measuring and transformation are equal.

    The mean of k settings has m_g/√k. Up to this k a further setting gains; beyond it
    the transformation decides, and more settings are wasted: Kovarik's verdict on
    diagram 4 d. Below 1 where even one is more than the transformation deserves. m_g is
    that of ONE setting, on the ground [m].

    >>> round(float(settings_that_balance(0.08, 0.04)), 1)
    4.0
    """
    return np.square(np.divide(m_g_ground, m_t))


def spacing_that_balances(spacing, m_g_ground, m_t):
    """Mean distance of points at which measuring and transformation are equal [m].

    m_t, of the given spacing, grows with it. Down to this distance denser points gain;
    below it measuring decides.

    >>> float(spacing_that_balances(400.0, 0.03, 0.06))
    200.0
    """
    return np.multiply(spacing, np.divide(m_g_ground, m_t))
