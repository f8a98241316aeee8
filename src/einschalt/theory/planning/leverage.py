"""How far a planned model determines its own transformation: leverages before points.

The transformation error of a point is m_0 √h, h being its leverage among the points
that the model was fitted to. Before the flight these are known by their spacing only.
Two pictures of them: an even spread (n·h is a constant of the place in the model), and
a square lattice that falls on the model as it may, averaged over where it falls.

See docs/theory/precision_planning.md.
"""

from dataclasses import dataclass

import numpy as np

# what the second moments of the points count for in one coordinate of a place: n·h is
# 1 + share (x² + y²)/(v_x + v_y), and 1 + x²/v_x + y²/v_y for affine
SHARE_OF_MOMENTS = {"helmert": 1.0, "rigid": 0.5}
PLANNED_KINDS = ("affine", *SHARE_OF_MOMENTS)
LEAST_POINTS = {"affine": 3, "helmert": 2, "rigid": 2}


@dataclass(frozen=True, eq=False)
class PlannedLeverage:
    """Leverages in the middle of a model and at its edge."""

    # infinite where the transformation might not be determined at all
    centre: float | np.ndarray
    edge: float | np.ndarray


def mid_edge_factor(kind, extent):
    """n·h in the middle of the farther edge of an evenly filled rectangle.

    ``extent`` is that of the model along and across the strip.

    >>> mid_edge_factor("affine", (138.0, 230.0))
    4.0
    >>> round(mid_edge_factor("helmert", (138.0, 230.0)), 4)
    3.2059
    """
    if kind == "affine":
        return 4.0
    along, across = extent
    longer = max(along, across) ** 2 / (along**2 + across**2)
    return 1.0 + 3.0 * SHARE_OF_MOMENTS[kind] * longer


def corner_factor(kind):
    """n·h in the corner of an evenly filled rectangle.

    >>> [corner_factor(kind) for kind in PLANNED_KINDS]
    [7.0, 4.0, 2.5]
    """
    return 7.0 if kind == "affine" else 1.0 + 3.0 * SHARE_OF_MOMENTS[kind]


def lattice_leverage(kind, along, across) -> PlannedLeverage:
    """Mean leverage, over all places of a lattice, in the middle and in the corner.

    On an axis of length L = (m + f) s a lattice of the spacing s has m + 1 rows with
    the probability f and m with 1 − f. k rows have the second moment s²(k² − 1)/12, and
    their middle lies up to f s/2, or (1 − f) s/2, from that of the model, each place
    being as likely. So the mean is closed.

    Parameters
    ----------
    kind : {"affine", "helmert", "rigid"}
    along, across : ndarray
        Extent of the model in spacings.

    Returns
    -------
    PlannedLeverage
        In the middle and in the corner of the model. Infinite where a place of the
        lattice is possible that does not determine the transformation.

    Examples
    --------
    With 28.6 points in a model it is a little more than 7/n of an even spread:

    >>> edge = lattice_leverage("affine", np.array(4.14), np.array(6.9)).edge
    >>> round(float(edge * 4.14 * 6.9), 2)
    7.5
    """
    shape = np.broadcast_shapes(np.shape(along), np.shape(across))
    total = np.zeros((2, *shape))
    for first in _rows(np.asarray(along, dtype=float)):
        for second in _rows(np.asarray(across, dtype=float)):
            probability = first.probability * second.probability
            with np.errstate(divide="ignore", invalid="ignore"):
                terms = probability * _leverages(kind, first, second)
            total += np.where(probability > 0.0, terms, 0.0)
    return PlannedLeverage(*np.where(np.isnan(total), np.inf, total))


@dataclass(frozen=True, eq=False)
class _Rows:
    """One of the two numbers of rows that an axis can have; lengths in spacings."""

    count: np.ndarray
    probability: np.ndarray
    moment: np.ndarray
    offset_square: np.ndarray
    edge_square: np.ndarray


def _rows(length):
    whole = np.floor(length)
    fraction = length - whole
    for count, probability in ((whole + 1.0, fraction), (whole, 1.0 - fraction)):
        moment = (count**2 - 1.0) / 12.0
        offset_square = probability**2 / 12.0
        yield _Rows(
            count, probability, moment, offset_square, length**2 / 4.0 + offset_square
        )


def _leverages(kind, first, second):
    """Leverage in the middle and in the corner, shape (2, ...)."""
    n_points = first.count * second.count
    pairs = (
        (first.offset_square, second.offset_square),
        (first.edge_square, second.edge_square),
    )
    if kind == "affine":
        is_determined = (first.count > 1.0) & (second.count > 1.0)
        terms = [1.0 + x / first.moment + y / second.moment for x, y in pairs]
    else:
        is_determined = n_points > 1.0
        both = first.moment + second.moment
        share = SHARE_OF_MOMENTS[kind]
        terms = [1.0 + share * (x + y) / both for x, y in pairs]
    return np.where(is_determined, np.stack(terms) / n_points, np.inf)
