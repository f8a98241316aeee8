"""What to say of a claimed figure that does not stand, or that nothing checks."""

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import count, fixed, length

REMEDIES = {
    "doubt_independence": (
        "Approximate coordinates whose errors are independent would not show this: "
        "they share errors, as those of one orientation do, which no figure here "
        "holds. Trust check points, or densify from a high flight over control"
    ),
    "shared_errors_as_stated": (
        "Approximate coordinates whose errors are independent would not show this: "
        "they share errors, and models have taken up what the residuals do not show. "
        "The figure above holds it, as large as m_0_m of [approximate_points] says; "
        "check points, or a high flight over control, would tell more"
    ),
    "doubt_sizes_of_errors": (
        "Look for deformed models, gross errors and wrong sizes of errors; trust check "
        "points more than the figures"
    ),
    "look_for_gross_errors_or_give_larger_ones": (
        "Look for gross errors in high flight and control, or give larger errors"
    ),
    "raise_m_g": "Raise m_g_um of the low flight, or look for gross errors",
    "look_for_copies_or_lower_m_g": (
        "Look for measurements that were copied or transferred; if there are none, "
        "m_g_um is too large"
    ),
    "take_copies_out": (
        "Take the copies out: their mean is no better than one of them, and no "
        "difference between them checks anything"
    ),
    "give_check_points": 'Give some known points role = "check"',
    "give_standard_errors_of_control": (
        "Give standard_error_m, TOTAL in metres, in [control_points]"
    ),
}


def claim_that_does_not_stand(finding):
    """Every quantity that contradicts the claim."""
    said = "; ".join(map(_rejected, finding.facts["rejected"]))
    return f"The claimed figure does not stand: {said}"


def _rejected(test):
    observed, predicted = test["observed"], test["predicted"]
    if test["kind"] == "correlation":
        return (
            "residuals of neighbours are alike (correlation "
            f"{fixed(observed, 2)}, expected {fixed(predicted, 2)})"
        )
    is_residuals = test["kind"] == "residuals"
    what = "the size of the residuals" if is_residuals else f"RMS of {test['quantity']}"
    verb = "is" if observed > predicted else "is only"
    return f"{what} {verb} {length(observed)}, predicted {length(predicted)}"


def coverages_that_agree_too_well(finding):
    """What differs by less than it should."""
    said = "; ".join(map(_rejected, finding.facts["tests"]))
    return f"Coverages agree better than independent measurements would: {said}"


def measurements_given_twice(finding):
    """How many models or photographs are copies, and the first of them."""
    first, second = (
        ", ".join(printable(part).replace("_", " ") for part in names if part)
        for names in finding.facts["pairs"][0]
    )
    facts = finding.facts
    points, pairs = count(facts["n_points"], "point"), count(facts["n_pairs"], "pair")
    return (
        f"Measurements were given twice: {points} in {pairs} of models or photographs "
        f"have the same coordinates to the last digit, such as {first} and {second}"
    )


WORDS = {
    "coverages_that_agree_too_well": coverages_that_agree_too_well,
    "measurements_given_twice": measurements_given_twice,
    "claim_that_does_not_stand": claim_that_does_not_stand,
    "high_flight_that_misfits": (
        "m_0 of the high flight is {m_0:length}, {ratio:factor} the "
        "{explained:length} that m_g_um and the control points' errors explain"
    ),
    "contradicted_propagation": (
        "The measurements contradict the propagated figure, which takes the sizes of "
        "errors as given: propagated {propagated:length}, paper {paper:length}, "
        "internal {internal:length}"
    ),
    "contradicted_budget": (
        "The coverages differ more than the budget explains: internal "
        "{internal:length}, paper {paper:length}"
    ),
    "no_check_points": (
        "No check points: nothing from outside confirms the figures below"
    ),
    "figure_left_out": (
        "standard_error_total is left out: the control points have no "
        "standard_error_m. The figures that remain are too small"
    ),
}
