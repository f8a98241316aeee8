"""The expected precision of two flights in closed form: an estimate for many plans.

Kovarik's formula takes the approximate coordinates for independent of each other. They
share the transformations of the high flight, and this part does not average out over
the points of a low-flight model. Here it is counted; what remains to the propagation on
a layout is where models and points lie.

See docs/theory/planned_expectation.md.
"""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.theory.planning.kovarik_precision import FEW_POINTS
from einschalt.theory.planning.leverage import SHARE_OF_MOMENTS

# mean of n·h over a model that is filled evenly: the number of parameters by two
MEAN_FACTOR = {"affine": 3.0, "helmert": 2.0, "rigid": 1.5}
# second moment of four corners and the middle, of 3 x 3 places, in side²
MOMENT_OF_CONTROL = {5: 1.0 / 5.0, 9: 1.0 / 6.0}
MOMENT_OF_AREA = 1.0 / 12.0
KEPT_OF_NOISE = 0.7
"""Part of the approximations' own noise that the mean of overlapping models keeps: they
are fitted to the same points in part."""


@dataclass(frozen=True, eq=False)
class FlightsToExpect:
    """Two flights, arrays that broadcast; metres, TOTAL."""

    scale_number: np.ndarray
    high_scale_number: np.ndarray
    spacing: np.ndarray
    # measuring error in the image, of the mean of a point's settings
    m_g: np.ndarray
    high_m_g: np.ndarray
    n_coverages: np.ndarray  # of both flights
    control_error: float
    control_per_model: int = 5  # or 9


@dataclass(frozen=True, eq=False)
class ExpectedParts:
    """Variances by their origin, and the errors that they make [m², m]; TOTAL."""

    # parts of the variance of the mean of all values of a point: measuring in the low
    # flight; noise of single approximate coordinates; transformations of the high
    # flight; errors of control
    measuring: np.ndarray
    noise: np.ndarray
    transformation: np.ndarray
    control: np.ndarray
    approximate: np.ndarray  # error of the approximate coordinates
    centre: np.ndarray  # error of one model's value in its middle
    edge: np.ndarray  # the same at its edge, in the middle of its sides
    corner: np.ndarray  # and in its corners
    mean: np.ndarray  # error of the mean of all values of a point


@dataclass(frozen=True, eq=False)
class BreakEven:
    """Where more of an effort leaves the greater part of the variance as it is."""

    # settings of a point in the low flight, as many times as planned
    settings: np.ndarray
    n_coverages: np.ndarray  # of both flights
    spacing: np.ndarray  # mean distance of points [m]; denser ones gain little


def models_per_point(model):
    """How many models of one coverage hold a point, on average.

    >>> from einschalt.theory.planning.kovarik_precision import PlannedModel
    >>> round(models_per_point(PlannedModel()), 2)
    2.14
    """
    held = model.forward_overlap / (1.0 - model.forward_overlap)
    return held / (1.0 - model.side_overlap)


def control_leverage(kind, control_per_model):
    """Mean leverage, over the neat model, of a high-flight model's control.

    Five control points lie in the corners and the middle of the neat model, nine at 3 x
    3 places in it.

    >>> round(control_leverage("affine", 5), 3)
    0.367
    """
    per_axis = MOMENT_OF_AREA / MOMENT_OF_CONTROL[control_per_model]
    share = 2.0 if kind == "affine" else SHARE_OF_MOMENTS[kind]
    return (1.0 + share * per_axis) / control_per_model


def expected_parts(flights, model) -> ExpectedParts:
    """Estimate the precision that two flights will give.

    Parameters
    ----------
    flights : FlightsToExpect
    model : PlannedModel
        Of both flights; ``edge`` is not used: the edge is that of the whole overlap,
        with points evenly spread, and on a lattice where fewer than 12 lie in a model.

    Notes
    -----
    With μ models of each of C coverages at a point, h the leverage in a low-flight
    model, h̄ its mean, h_c that of the control, g and g_h the measuring errors on the
    ground and σ_c that of the control,

        one model:  (1 − h) g² + h g_h²/(μC) + h_c g_h²/(μC) + h_c σ_c²/√μ
        mean:       (1 − h̄) g²/(μC) + (h_c + 0.7 h̄) g_h²/(μC) + h_c σ_c²/√μ

    Own derivation; 0.7 and √μ from propagation on layouts of film, digital and UAV
    flights, with which it agrees to some 10 % (tests/truth/test_expected_precision.py).
    """
    leverage = _leverages(flights, model)
    multiplicity = models_per_point(model)
    n_values = multiplicity * np.asarray(flights.n_coverages, dtype=float)
    ground = np.square(np.multiply(flights.m_g, flights.scale_number))
    noise = np.square(np.multiply(flights.high_m_g, flights.high_scale_number))
    noise = noise / n_values
    of_control = control_leverage(model.kind, flights.control_per_model)
    transformation = of_control * noise
    control = of_control * flights.control_error**2 / np.sqrt(multiplicity)
    shared = transformation + control

    def of_one_model(h):
        return np.sqrt(np.maximum(1.0 - h, 0.0) * ground + h * noise + shared)

    h_mean = np.minimum(leverage["mean"], 1.0)
    measuring = (1.0 - h_mean) * ground / n_values
    kept = KEPT_OF_NOISE * h_mean * noise
    mean = np.sqrt(measuring + kept + shared)
    parts = np.broadcast_arrays(measuring, kept, transformation, control)
    errors = np.broadcast_arrays(
        np.sqrt(noise + shared),
        of_one_model(leverage["centre"]),
        of_one_model(leverage["edge"]),
        of_one_model(leverage["corner"]),
        mean,
    )
    return ExpectedParts(*parts, *errors)


def break_even(parts, flights) -> BreakEven:
    """Find where more settings, coverages or points stop paying.

    Each reduces some parts of the variance of the mean and leaves the others; it pays
    until both are equal, and beyond that at most by √2. Settings of the low flight
    divide ``measuring``, coverages everything but ``control``, the square of the
    spacing multiplies ``noise``.
    """
    whole = parts.measuring + parts.noise + parts.transformation + parts.control
    with np.errstate(divide="ignore"):
        settings = parts.measuring / (whole - parts.measuring)
        coverages = (whole - parts.control) / parts.control
        denser = np.sqrt((whole - parts.noise) / parts.noise)
    return BreakEven(
        settings,
        np.multiply(flights.n_coverages, coverages),
        np.multiply(flights.spacing, denser),
    )


def _leverages(flights, model):
    evenly, cornered, lattice = (
        replace(model, edge=edge) for edge in ("mid_edge", "corner", "lattice")
    )
    where = flights.scale_number, flights.spacing
    n_points = evenly.n_points(*where)
    is_few = n_points < FEW_POINTS
    even, single = evenly.leverage(*where), lattice.leverage(*where)
    return {
        "mean": MEAN_FACTOR[model.kind] / n_points,
        "centre": np.where(is_few, single.centre, even.centre),
        "edge": np.where(is_few, single.edge, even.edge),
        "corner": np.maximum(single.edge * is_few, cornered.leverage(*where).edge),
    }
