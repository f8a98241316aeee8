"""The figures of a block: how many points and models, and how good they are."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class BlockFigures:
    """The figures of a block, metres and TOTAL unless said otherwise; NaN: not known.

    Attributes
    ----------
    m_0_high, m_0_low : float
        Standard error of unit weight of all models of a flight together, in plan.
    approximation_internal : float
        Approximate coordinates (mean of the coverages), from the differences of the
        coverages of the high flight.
    single_paper, mean_paper : float
        Root mean square of Kovarik's M over the values that were averaged, and over
        the new points.
    single_internal, mean_internal : float
        From the differences of the coverages of the low flight.
    mean_total : float
        Root mean square of the propagated ``standard_error_total`` of the new points.
    control_rms, check_rms : float
        Densified minus given coordinates.
    shared_error : float
        What all points share of ``mean_total``: the error of the operation between
        reference systems; 0 where there is none.
    n_points, n_new, n_control, n_check, n_models_high, n_models_low, n_failed : int
    """

    m_0_high: float
    m_0_low: float
    approximation_internal: float
    single_paper: float
    mean_paper: float
    mean_total: float
    single_internal: float
    mean_internal: float
    control_rms: float
    check_rms: float
    n_points: int
    n_new: int
    n_control: int
    n_check: int
    n_models_high: int
    n_models_low: int
    n_failed: int
    shared_error: float = 0.0

    @property
    def mean_within(self) -> float:
        """``mean_total`` without what all points share, which no test can see."""
        if self.shared_error == 0.0:
            return self.mean_total
        return float(np.sqrt(max(self.mean_total**2 - self.shared_error**2, 0.0)))


def two_step_figures(
    high, low, means, points, failures, shared_error=0.0
) -> BlockFigures:
    """Collect the figures of the two-step way."""
    new = points[points["role"] == "new"]
    approximation = np.nan
    if high is not None:
        by_coverages = np.sqrt(high.points["n_coverages"].to_numpy())
        approximation = _rms(high.internal_single / by_coverages)
    return BlockFigures(
        m_0_high=np.nan if high is None else high.transformation.m_0_plan,
        m_0_low=low.m_0_plan,
        approximation_internal=approximation,
        single_paper=_rms(means.used["standard_error_paper"]),
        mean_paper=_rms(new["standard_error_paper"]),
        mean_total=_rms(new.get("standard_error_total", np.nan)),
        single_internal=means.internal_single,
        mean_internal=_rms(new["standard_error_internal"]),
        n_models_high=0 if high is None else len(high.transformation.models),
        n_models_low=len(low.models),
        n_failed=len(failures),
        shared_error=shared_error,
        **_known_points(points),
    )


def _known_points(points):
    """Figures that the table of points gives by itself."""
    by_role = points["role"].value_counts()
    return {
        "control_rms": _total_rms(points[points["role"] == "control"]),
        "check_rms": _total_rms(points[points["role"] == "check"]),
        "n_points": len(points),
        "n_new": int(by_role.get("new", 0)),
        "n_control": int(by_role.get("control", 0)),
        "n_check": int(by_role.get("check", 0)),
    }


def adjusted_figures(adjusted, points, failures, shared_error=0.0) -> BlockFigures:
    """Collect the figures of a simultaneous adjustment.

    NaN for those of the paper and of the coverages, which belong to two steps.
    """
    of_flight = adjusted.models["flight"].value_counts()
    new = points[points["role"] == "new"]
    two_steps = ("approximation_internal", "single_paper", "mean_paper")
    internal = ("single_internal", "mean_internal")
    return BlockFigures(
        m_0_high=adjusted.m_0_of("high_flight"),
        m_0_low=adjusted.m_0_of("low_flight"),
        mean_total=_rms(new.get("standard_error_total", np.nan)),
        n_models_high=int(of_flight.get("high_flight", 0)),
        n_models_low=int(of_flight.get("low_flight", 0)),
        n_failed=len(failures),
        shared_error=shared_error,
        **dict.fromkeys((*two_steps, *internal), np.nan),
        **_known_points(points),
    )


def _rms(values):
    values = np.atleast_1d(np.asarray(values, dtype=float))
    values = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(values**2))) if len(values) else np.nan


def _total_rms(points):
    return _rms(np.hypot(points["difference_easting"], points["difference_northing"]))
