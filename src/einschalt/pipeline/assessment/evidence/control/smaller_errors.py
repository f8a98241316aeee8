"""Control that is better than it was given, by what one adjustment leaves of it.

Errors that are stated much too large take the weight of control: nothing contradicts
such a figure, and the points become worse. Centimetres that were typed as metres do it.
"""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations.errors import GeometryError, SettingsError, TableError
from einschalt.pipeline.assessment.evidence.variance_components import Component
from einschalt.pipeline.densification.simultaneous import (
    adjust_flights,
    require_adjustable,
)
from einschalt.stages.error_propagation.given_points import PLAN
from einschalt.theory.adjustment.global_tests import ratio_limits
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

STATED = "standard_error_m"
LEAST_RATIO = 2.0  # stated errors that are too large by less do little to the points
# each pass takes most of what is left; residuals of no redundancy tell no size
MOST_PASSES, NEAR, LEAST_REDUNDANCY = 8, 0.93, 5.0


@dataclass(frozen=True)
class PlanOfControl:
    """How large the residuals of control are in plan, by its stated errors."""

    factor: float  # RMS; 1 where errors are as stated
    redundancy: float

    @property
    def is_small(self):
        """Whether chance does not explain it."""
        limits = ratio_limits(self.redundancy, FINDING_SIGNIFICANCE)
        return bool(self.redundancy > LEAST_REDUNDANCY and self.factor < limits[0])


def size_of_control(examined) -> Component | None:
    """Errors of control in plan, where these are surely much smaller than stated.

    TOTAL [m], root mean squares. None where chance explains it, where control shares
    errors or has none that are stated, and in large blocks.
    """
    block = examined.block
    if not _is_tried(examined) or not _looks_small(examined):
        return None
    try:
        require_adjustable(block)
        factor, found = _as_residuals_show(examined)
    except (GeometryError, TableError, SettingsError):  # what the figure does not need
        return None
    control = block.control_points
    is_held = (control["role"] != "check").to_numpy()
    stated = control.loc[is_held, STATED].to_numpy(dtype=float)
    given = float(np.sqrt(np.nanmean(stated**2)))
    shown = factor * given
    error = shown / np.sqrt(2.0 * max(found.redundancy, 1.0))
    component = Component(given, shown, float(error))
    is_surely = component.is_contradicted and given > LEAST_RATIO * shown
    return component if is_surely else None


def _is_tried(examined):
    control = examined.block.control_points
    if control is None or STATED not in control or "covariance_en" in control:
        return False
    # one adjustment knows how large its block is by the two steps beside it
    is_small = examined.two_step.is_possible and examined.is_small
    return is_small and not examined.shares_control_errors


def _looks_small(examined):
    """Whether control agrees too well, by the way that was computed."""
    if examined.two_step is not examined:
        return _plan_of(examined.adjustment).is_small
    left_out = examined.left_out_control
    if left_out is None:
        return False
    ratio = np.sqrt(left_out.normalized_square)
    # their differences depend on each other
    limits = ratio_limits(len(left_out.squares), FINDING_SIGNIFICANCE)
    return bool(ratio < limits[0])


def _as_residuals_show(examined):
    """Factor of stated errors with which residuals are as large as they should be."""
    block, control = examined.block, examined.block.control_points
    flights = dict(examined.all_in_two_steps.solution.flights)
    settings = examined.settings.updated({"variance_components": "given"})
    factor = 1.0
    for _ in range(MOST_PASSES):
        scaled = control.assign(**{STATED: control[STATED] * factor})
        adjusted = adjust_flights(
            replace(block, control_points=scaled), settings, flights
        )
        found = _plan_of(adjusted)
        if found.redundancy < LEAST_REDUNDANCY or found.factor > NEAR:
            break
        factor *= found.factor
    return factor, found


def _plan_of(adjustment):
    """Residuals of control in plan by their stated errors, and their redundancy."""
    control = adjustment.control
    control = control[~control["is_set_aside"].to_numpy(dtype=bool)]
    error = control["standard_error_given"].to_numpy(dtype=float) / SQRT2
    columns = [f"difference_{axis}" for axis in PLAN]
    scaled = control[columns].to_numpy(dtype=float) / error[:, None]
    is_known = np.isfinite(scaled).all(axis=1) & (error > 0.0)
    number = control["redundancy_number"].to_numpy(dtype=float)[is_known]
    redundancy = len(PLAN) * float(number.sum())
    if not redundancy > 0.0:
        return PlanOfControl(np.nan, 0.0)
    return PlanOfControl(
        float(np.sqrt(np.sum(scaled[is_known] ** 2) / redundancy)), redundancy
    )
