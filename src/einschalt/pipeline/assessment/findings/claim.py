"""Whether the claimed figure stands against what was measured."""

from einschalt.pipeline.assessment.credibility import (
    MIN_REPORTED_RATIO,
    high_flight_misfit,
    largest_measured,
)
from einschalt.pipeline.assessment.evidence.claim import NEIGHBOURS, RESIDUALS
from einschalt.pipeline.assessment.finding import Finding, Gravity, Subject

KIND_OF_TEST = {NEIGHBOURS: "correlation", RESIDUALS: "residuals"}


def claim_that_does_not_stand(two_step):
    """Measurements that contradict what the claimed figure predicts."""
    rejected = two_step.claim.rejected
    if not rejected:
        return None
    worst = min(rejected, key=lambda test: test.p_value)
    is_from_high_flight = two_step.high is not None
    return Finding(
        "claim_that_does_not_stand",
        Subject.BLOCK,
        Gravity.GRAVE,
        statistic=worst.name,
        observed=float(worst.observed),
        expected=float(worst.predicted),
        probability=float(worst.p_value),
        remedy="doubt_sizes_of_errors" if is_from_high_flight else "doubt_independence",
        facts={"rejected": tuple(map(_rejected, rejected))},
    )


def _rejected(test):
    return {
        "quantity": test.name,
        "kind": KIND_OF_TEST.get(test.name, "rms"),
        "n_points": int(test.n_points),
        "observed": float(test.observed),
        "predicted": float(test.predicted),
        "p_value": float(test.p_value),
    }


def high_flight_that_misfits(examined):
    """Models of the high flight that fit worse than the given errors explain."""
    misfit = high_flight_misfit(examined)
    if misfit is None or not misfit.is_large:
        return None
    return Finding(
        "high_flight_that_misfits",
        Subject.FLIGHT,
        Gravity.GRAVE,
        names=("high_flight",),
        statistic="m_0 of the high flight",
        observed=float(misfit.m_0),
        expected=misfit.explained,
        probability=misfit.p_value,
        remedy="look_for_gross_errors_or_give_larger_ones",
        facts={
            "m_0": float(misfit.m_0),
            "explained": misfit.explained,
            "ratio": float(misfit.ratio),
        },
    )


def contradicted_propagation(two_step):
    """Measured figures that are larger than the propagated one."""
    figures = two_step.figures
    if not _exceeds_propagation(figures):
        return None
    return Finding(
        "contradicted_propagation",
        Subject.BLOCK,
        Gravity.GRAVE,
        statistic="larger one of the paper's and the internal figure",
        observed=largest_measured(figures),
        expected=float(figures.mean_within),
        remedy="raise_m_g",
        facts={
            "propagated": float(figures.mean_within),
            "paper": float(figures.mean_paper),
            "internal": float(figures.mean_internal),
        },
    )


def contradicted_budget(two_step):
    """Coverages that differ more than the budget explains."""
    figures = two_step.figures
    if _exceeds_propagation(figures):
        return None  # which says more
    # of orientations the budget knows nothing
    is_known = two_step.errors is not None and any(
        flight.is_oriented_numerically for flight in two_step.block.flights.values()
    )
    internal, paper = float(figures.mean_internal), float(figures.mean_paper)
    if is_known or not internal > MIN_REPORTED_RATIO * paper:
        return None
    return Finding(
        "contradicted_budget",
        Subject.BLOCK,
        Gravity.GRAVE,
        statistic="internal figure",
        observed=internal,
        expected=paper,
        remedy="raise_m_g",
        facts={"internal": internal, "paper": paper},
    )


def _exceeds_propagation(figures):
    return largest_measured(figures) > MIN_REPORTED_RATIO * figures.mean_within


def no_check_points(examined):
    """Nothing from outside confirms the figures."""
    if examined.figures.n_check > 0:
        return None
    return Finding(
        "no_check_points",
        Subject.BLOCK,
        Gravity.NOTE,
        untested="no_check_points",
        remedy="give_check_points",
    )


def figure_left_out(examined):
    """What is missing for the propagated figure, where it could be given."""
    block = examined.block
    if examined.errors is not None or block.high_flight is None:
        return None
    if "standard_error_m" in block.control_points:
        return None
    return Finding(
        "figure_left_out",
        Subject.BLOCK,
        Gravity.NOTE,
        untested="control_without_standard_errors",
        remedy="give_standard_errors_of_control",
    )


FOR_BOTH = (high_flight_that_misfits, no_check_points, figure_left_out)
TWO_STEP = (
    claim_that_does_not_stand,
    contradicted_propagation,
    contradicted_budget,
    *FOR_BOTH,
)
SIMULTANEOUS = FOR_BOTH
