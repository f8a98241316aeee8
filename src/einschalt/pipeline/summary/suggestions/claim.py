"""What to say of a stated precision that is not supported, or that nothing checks."""

from einschalt.foundations.display_names import printable
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.typesetting import fixed, length
from einschalt.pipeline.summary.wording import FLIGHTS

REMEDIES = mark_each(
    {
        "doubt_independence": (
            "Approximate coordinates with independent errors would not show this: they "
            "share errors, such as those of one orientation, which no figure here "
            "includes. Rely on check points, or densify from a high flight over control"
        ),
        "shared_errors_as_stated": (
            "Approximate coordinates with independent errors would not show this: they "
            "share errors, which models absorb and residuals do not show. The figure "
            "above includes them with the size that m_0_m of [approximate_points] "
            "states; check points, or a high flight over control, would show more"
        ),
        "shared_errors_beyond_stated": (
            "Approximate coordinates with independent errors would not show this: they "
            "share errors, such as those of one orientation. The figure above takes "
            "all of m_0_m for shared, enlarged as residuals are; they may be larger. "
            "Rely on check points, or densify from a high flight over control"
        ),
        "doubt_sizes_of_errors": (
            "Look for deformed models, gross errors and wrongly stated errors; rely on "
            "check points rather than on the figures"
        ),
        "doubt_check_points_too": (
            "Look for gross errors and wrongly stated errors, also at the check points "
            "that are far off"
        ),
        "doubt_far_control": (
            "Single control points contradict it, the others do not: check these first"
        ),
        "look_for_gross_errors_or_give_larger_ones": (
            "Look for gross errors in high flight and control, or state larger errors"
        ),
        "raise_m_g": "Raise m_g_um of the low flight, or look for gross errors",
        "look_for_copies_or_lower_m_g": (
            "Look for measurements that were copied or transferred; if there are none, "
            "m_g_um is too large"
        ),
        "take_copies_out": (
            "Remove the copies: their mean is no better than one of them, and "
            "differences between them check nothing"
        ),
        "give_check_points": 'Give some known points role = "check"',
        "give_standard_errors_of_control": (
            "Give standard_error_m, TOTAL in metres, in [control_points]"
        ),
    }
)
NOT_SUPPORTED = mark("The stated precision is not supported: {tests}")
CORRELATED = mark(
    "residuals of neighbours are correlated ({observed}, expected {expected})"
)
OF_REGION = mark(
    "given points of a region are displaced together against the others ({observed} "
    "standard errors, expected {expected})"
)
LARGER = mark("RMS of {quantity} is {observed}, expected {expected}")
SMALLER = mark("RMS of {quantity} is only {observed}, expected {expected}")
TOO_GOOD = mark("Coverages agree better than independent measurements would: {tests}")
TWICE = mark(
    "Measurements were given twice: {n_points:point|points} in {n_pairs:pair|pairs} of "
    "models or photographs have identical coordinates to the last digit, such as "
    "{first} and {second}"
)


def claim_that_does_not_stand(finding):
    """Every quantity that contradicts the claim."""
    tests = "; ".join(map(_rejected, finding.facts["rejected"]))
    return translated(NOT_SUPPORTED, tests=tests)


def _rejected(test):
    observed, expected = test["observed"], test["predicted"]
    if test["kind"] == "correlation":
        sizes = {"observed": fixed(observed, 2), "expected": fixed(expected, 2)}
        return translated(CORRELATED, **sizes)
    if test["kind"] == "region":
        sizes = {"observed": fixed(observed, 1), "expected": fixed(expected, 1)}
        return translated(OF_REGION, **sizes)
    return translated(
        LARGER if observed > expected else SMALLER,
        quantity=translated(test["quantity"]),
        observed=length(observed),
        expected=length(expected),
    )


def coverages_that_agree_too_well(finding):
    """What differs by less than it should."""
    tests = "; ".join(map(_rejected, finding.facts["tests"]))
    return translated(TOO_GOOD, tests=tests)


def measurements_given_twice(finding):
    """How many models or photographs are copies, and the first of them."""
    facts = finding.facts
    first, second = (
        ", ".join(_part(part) for part in names if part) for names in facts["pairs"][0]
    )
    numbers = {name: facts[name] for name in ("n_points", "n_pairs")}
    return translated(TWICE, **numbers, first=first, second=second)


def _part(name):
    return translated(FLIGHTS[name]) if name in FLIGHTS else printable(name)


WORDS = mark_each(
    {
        "coverages_that_agree_too_well": coverages_that_agree_too_well,
        "measurements_given_twice": measurements_given_twice,
        "claim_that_does_not_stand": claim_that_does_not_stand,
        "high_flight_that_misfits": (
            "m_0 of the high flight is {m_0:length}, {ratio:factor} the "
            "{explained:length} that m_g_um and the control points' errors explain"
        ),
        "contradicted_propagation": (
            "The measurements contradict the propagated figure, which takes the sizes "
            "of errors as stated: propagated {propagated:length}, paper "
            "{paper:length}, internal {internal:length}"
        ),
        "contradicted_budget": (
            "The coverages differ more than the budget explains: internal "
            "{internal:length}, paper {paper:length}"
        ),
        "no_check_points": (
            "No check points: nothing from outside confirms the figures below"
        ),
        "figure_left_out": (
            "standard_error_total is missing: the control points have no "
            "standard_error_m. The remaining figures are too small"
        ),
    }
)
