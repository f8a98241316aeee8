"""How the high flight fits the control points, and what explains it."""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.units import ground_from_image_um
from einschalt.pipeline.assessment.evidence.image_precision import (
    error_of_orientations,
)
from einschalt.stages.error_propagation.error_model import HIGH
from einschalt.stages.error_propagation.group_size import sum_of_residuals
from einschalt.theory.adjustment.global_tests import ratio_limits, ratio_p_value
from einschalt.theory.adjustment.monte_carlo import apply_chains, draw_errors
from einschalt.theory.adjustment.significance import (
    FINDING_SIGNIFICANCE,
    MIN_REPORTED_RATIO,
)

N_DRAWS = 100


@dataclass(frozen=True)
class HighFlightMisfit:
    """How the high flight fits the control points, and how it should."""

    m_0: float  # of all models of the high flight together, TOTAL [m]
    # what measuring errors, orientations and control points explain of it [m]
    explained: float
    # redundancy of the models; fewer where control or photographs share errors
    degrees: float

    @property
    def ratio(self) -> float:
        """The first by the second."""
        return self.m_0 / self.explained

    @property
    def is_large(self) -> bool:
        """Whether chance does not explain the misfit."""
        limits = ratio_limits(self.degrees, FINDING_SIGNIFICANCE, MIN_REPORTED_RATIO)
        return bool(self.ratio > limits[1])

    @property
    def p_value(self) -> float:
        """Probability of a misfit this large if the given errors are right."""
        return float(ratio_p_value(self.ratio, self.degrees))


def high_flight_misfit(examined) -> HighFlightMisfit | None:
    """Compare m_0 of the high flight with what the given errors explain.

    None without a high flight, without redundancy, and where the control points have no
    standard errors.
    """
    block = examined.block
    if block.high_flight is None or "standard_error_m" not in block.control_points:
        return None
    high = examined.models[examined.models["flight"] == "high_flight"]
    degrees = int(high.loc[high["is_usable"].astype(bool), "redundancy"].sum())
    if degrees == 0:
        return None
    # errors of a photograph are in all points of its models: fewer degrees of freedom
    is_shared = examined.shares_control_errors or block.high_flight.has_images
    if is_shared and examined.propagation is not None:
        return _drawn_misfit(examined)
    # the models of one adjustment share photographs: what it makes of them was drawn
    if examined is not examined.two_step and HIGH in examined.adjustment.drawn.fits:
        drawn = examined.adjustment.drawn.fits[HIGH]
        return HighFlightMisfit(examined.figures.m_0_high, drawn.m_0, drawn.degrees)
    scale = block.high_flight.scale_number
    m_g = ground_from_image_um(block.high_flight.m_g_counted_um, scale)
    control = block.control_points["standard_error_m"].to_numpy(dtype=float)
    bent = ground_from_image_um(
        error_of_orientations(examined.orientations, HIGH), scale
    )
    explained = np.hypot.reduce([m_g, np.sqrt(np.mean(control**2)), bent])
    return HighFlightMisfit(examined.figures.m_0_high, float(explained), degrees)


def _drawn_misfit(examined):
    """As :func:`high_flight_misfit`, where single points do not tell what to expect."""
    model, m_0 = examined.propagation, examined.figures.m_0_high
    fit = sum_of_residuals(model, HIGH, examined.high.transformation)
    errors = draw_errors(model.standard_errors, model.axes, n_draws=N_DRAWS, seed=0)
    drawn = np.sum(np.abs(apply_chains(errors, fit.chains)) ** 2, axis=0)
    ratio = np.sqrt(np.sum(np.abs(fit.values) ** 2) / np.mean(drawn))
    degrees = 2.0 * np.mean(drawn) ** 2 / np.var(drawn, ddof=1)
    return HighFlightMisfit(m_0, float(m_0 / ratio), float(degrees))
