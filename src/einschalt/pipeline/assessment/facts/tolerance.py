"""Which points keep the tolerance, and by which figure."""

from dataclasses import dataclass

import numpy as np

from einschalt.pipeline.assessment.tolerance import CheckedFigure, Tolerance

ROLES = ("new", "control", "check")
MOST_NAMED = 100


@dataclass(frozen=True)
class RoleOutcome:
    """Points of one role against the tolerance."""

    role: str
    n_pass: int
    n_fail: int
    largest: float  # figure, TOTAL [m]


@dataclass(frozen=True)
class ToleranceFacts:
    """The outcome of a tolerance."""

    tolerance: Tolerance
    figure: CheckedFigure  # that decided
    roles: tuple[RoleOutcome, ...]
    # the first of the points that do not pass however good their figure is
    suspects: tuple[str, ...]
    n_suspects: int
    # control points that are missed by more than is allowed there; None where the
    # tolerance allows everything, or there is no control
    n_control_beyond: int | None
    n_control: int


def tolerance_facts(points, tolerance, figure) -> ToleranceFacts | None:
    """Count the points of each role that pass and fail; None without a tolerance."""
    if tolerance is None or points.empty:
        return None
    by_role = {role: points[points["role"] == role] for role in ROLES}
    suspects = points.loc[points["is_suspect"], "point_id"]
    control = by_role["control"]
    is_limited = np.isfinite(tolerance.control) and len(control) > 0
    miss = np.hypot(control["difference_easting"], control["difference_northing"])
    return ToleranceFacts(
        tolerance=tolerance,
        figure=figure,
        roles=tuple(_outcome(role, p) for role, p in by_role.items() if len(p)),
        suspects=tuple(suspects.head(MOST_NAMED)),
        n_suspects=len(suspects),
        n_control_beyond=int((miss > tolerance.control).sum()) if is_limited else None,
        n_control=len(control),
    )


def _outcome(role, points):
    passes = points["is_within_tolerance"]
    largest = float(points["standard_error_checked"].max())
    return RoleOutcome(role, int(passes.sum()), int((~passes).sum()), largest)
