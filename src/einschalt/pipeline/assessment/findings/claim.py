"""Whether the claimed figure stands against what was measured."""

import numpy as np

from einschalt.pipeline.assessment.credibility import (
    Reason,
    beyond_stated,
    largest_measured,
)
from einschalt.pipeline.assessment.evidence.claim import (
    COVERAGES,
    KNOWN,
    NEIGHBOURS,
    REGIONS,
    RESIDUALS,
)
from einschalt.pipeline.assessment.findings.kinds import finding
from einschalt.pipeline.assessment.known_points import (
    far_control,
    few_contradicting_points,
)
from einschalt.theory.adjustment.significance import MIN_REPORTED_RATIO

DOUBT = "doubt_independence"
MOST_PAIRS = 10
KIND_OF_TEST = {
    NEIGHBOURS: "correlation",
    REGIONS: "region",
    RESIDUALS: "residuals",
}


def claim_that_does_not_stand(two_step):
    """Measurements that contradict what the claimed figure predicts."""
    rejected = two_step.claim.rejected
    if not rejected:
        return None
    worst = min(rejected, key=lambda test: test.p_value)
    names = {test.name for test in rejected}
    # coverages have what approximate points share in common: it makes no differences
    is_shared = two_step.high is None and names != {COVERAGES}
    is_shared = is_shared and not _are_only_larger(rejected)
    remedy = DOUBT if is_shared else "doubt_sizes_of_errors"
    if len(few_contradicting_points(two_step)):
        remedy = "doubt_check_points_too"
    elif names == {KNOWN["control"]} and len(far_control(two_step)):
        remedy = "doubt_far_control"
    if two_step.credible.reason is Reason.STATED:
        remedy = "shared_errors_as_stated"
    elif remedy == DOUBT and beyond_stated(two_step) > 1.0:
        remedy = "shared_errors_beyond_stated"
    return finding(
        "claim_that_does_not_stand",
        statistic=worst.name,
        observed=worst.observed,
        expected=worst.predicted,
        probability=worst.p_value,
        remedy=remedy,
        facts={"rejected": tuple(map(_rejected, rejected))},
    )


def _are_only_larger(rejected):
    """Whether all that tests show is that points are worse, each by itself.

    Residuals say so, those of neighbours are not alike, and nothing exceeds what was
    predicted by more than they do.
    """
    ratios = {
        test.name: test.observed / test.predicted for test in rejected if test.is_length
    }
    of_residuals = ratios.get(RESIDUALS, 0.0)
    is_alike = len(ratios) < len(rejected)
    largest = max(ratios.values(), default=np.inf)
    is_explained = largest <= MIN_REPORTED_RATIO * of_residuals
    return of_residuals > 1.0 and is_explained and not is_alike


def _rejected(test):
    numbers = ("observed", "predicted", "p_value")
    return {
        "quantity": test.name,
        "kind": KIND_OF_TEST.get(test.name, "rms"),
        "n_points": int(test.n_points),
        **{name: float(getattr(test, name)) for name in numbers},
    }


def coverages_that_agree_too_well(two_step):
    """Coverages that differ by less than independent measurements would."""
    found = [
        test
        for test in two_step.claim.too_small
        if test.observed < test.predicted / MIN_REPORTED_RATIO
    ]
    if not found:
        return None
    worst = max(found, key=lambda test: test.p_value)
    return finding(
        "coverages_that_agree_too_well",
        statistic=worst.name,
        observed=worst.observed,
        expected=worst.predicted,
        probability=1.0 - worst.p_value,
        remedy="look_for_copies_or_lower_m_g",
        facts={"tests": tuple(map(_rejected, found))},
    )


def measurements_given_twice(examined):
    """Models or photographs that are copies of others."""
    copies = examined.copies
    if not copies.pairs:
        return None
    largest = sorted(copies.pairs, key=lambda pair: -pair.n_equal)
    return finding(
        "measurements_given_twice",
        names=[pair.second[2] for pair in largest],
        statistic="points with the same coordinates to the last digit",
        observed=largest[0].n_equal,
        expected=0.0,
        remedy="take_copies_out",
        facts={
            "n_pairs": len(copies.pairs),
            "n_points": sum(pair.n_equal for pair in copies.pairs),
            "pairs": tuple((pair.first, pair.second) for pair in largest[:MOST_PAIRS]),
            "enlargement": copies.enlargement,
        },
    )


def high_flight_that_misfits(examined):
    """Models of the high flight that fit worse than the given errors explain."""
    misfit = examined.misfit
    if misfit is None or not misfit.is_large:
        return None
    shown = ("m_0", "explained", "ratio")
    return finding(
        "high_flight_that_misfits",
        names=("high_flight",),
        statistic="m_0 of the high flight",
        observed=misfit.m_0,
        expected=misfit.explained,
        probability=misfit.p_value,
        remedy="look_for_gross_errors_or_give_larger_ones",
        facts={name: float(getattr(misfit, name)) for name in shown},
    )


def contradicted_propagation(two_step):
    """Measured figures that are larger than the propagated one."""
    figures = two_step.figures
    if not _exceeds_propagation(two_step):
        return None
    return finding(
        "contradicted_propagation",
        statistic="larger one of the paper's and the internal figure",
        observed=largest_measured(two_step),
        expected=figures.mean_within,
        remedy="raise_m_g",
        facts={
            "propagated": float(figures.mean_within),
            "paper": float(figures.mean_paper),
            "internal": float(two_step.internal_of_good),
        },
    )


def contradicted_budget(two_step):
    """Coverages that differ more than the budget explains."""
    figures = two_step.figures
    if _exceeds_propagation(two_step):
        return None  # which says more
    # of orientations the budget knows nothing
    is_known = two_step.errors is not None and any(
        flight.is_oriented_numerically for flight in two_step.block.flights.values()
    )
    internal, paper = two_step.internal_of_good, float(figures.mean_paper)
    if is_known or not internal > MIN_REPORTED_RATIO * paper:
        return None
    return finding(
        "contradicted_budget",
        statistic="internal figure",
        observed=internal,
        expected=paper,
        remedy="raise_m_g",
        facts={"internal": internal, "paper": paper},
    )


def _exceeds_propagation(two_step):
    largest = largest_measured(two_step)
    return largest > MIN_REPORTED_RATIO * two_step.figures.mean_within


def no_check_points(examined):
    """Nothing from outside confirms the figures."""
    if examined.figures.n_check > 0:
        return None
    why = "no_check_points"
    return finding("no_check_points", untested=why, remedy="give_check_points")


def figure_left_out(examined):
    """What is missing for the propagated figure, where it could be given."""
    block = examined.block
    if examined.errors is not None or block.high_flight is None:
        return None
    if "standard_error_m" in block.control_points:
        return None
    return finding(
        "figure_left_out",
        untested="control_without_standard_errors",
        remedy="give_standard_errors_of_control",
    )


FOR_BOTH = (
    measurements_given_twice,
    high_flight_that_misfits,
    no_check_points,
    figure_left_out,
)
TWO_STEP = (
    claim_that_does_not_stand,
    contradicted_propagation,
    contradicted_budget,
    coverages_that_agree_too_well,
    *FOR_BOTH,
)
SIMULTANEOUS = FOR_BOTH
