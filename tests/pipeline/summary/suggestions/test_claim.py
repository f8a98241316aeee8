"""Words for figures that the measurements contradict, of findings made by hand."""

from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of


def finding(code, remedy, **facts):
    return Finding(code, Subject.BLOCK, remedy=remedy, facts=facts)


def rejected(kind, quantity, observed, predicted):
    return {
        "kind": kind,
        "quantity": quantity,
        "observed": observed,
        "predicted": predicted,
    }


def test_every_rejected_quantity_is_said():
    tests = (
        rejected("rms", "coverage differences", 0.12, 0.08),
        rejected("residuals", "residuals of the low flight", 0.03, 0.05),
        rejected("correlation", "correlation of neighbouring residuals", 0.21, -0.02),
    )
    found = finding("claim_that_does_not_stand", "doubt_independence", rejected=tests)
    said = suggestion_of(found)
    assert said.problem == (
        "The stated precision is not supported: RMS of coverage differences is 12 cm, "
        "expected 8.0 cm; RMS of residuals of the low flight is only 3.0 cm, expected "
        "5.0 cm; residuals of neighbours are correlated (0.21, expected -0.02)"
    )
    assert "they share errors, such as those of one orientation" in said.remedy


def test_behind_a_high_flight_the_sizes_of_errors_are_in_doubt():
    test = rejected("rms", "coverage differences", 0.12, 0.08)
    found = finding(
        "claim_that_does_not_stand", "doubt_sizes_of_errors", rejected=(test,)
    )
    remedy = suggestion_of(found).remedy
    assert "deformed models, gross errors and wrongly stated errors" in remedy


def test_a_high_flight_that_fits_worse_than_its_errors():
    found = finding(
        "high_flight_that_misfits",
        "look_for_gross_errors_or_give_larger_ones",
        m_0=0.5,
        explained=0.1164,
        ratio=4.295,
    )
    said = suggestion_of(found)
    assert said.problem == (
        "m_0 of the high flight is 50 cm, 4.3 times the 12 cm that m_g_um and the "
        "control points' errors explain"
    )


def test_figures_that_the_measurements_contradict():
    figures = {"propagated": 0.05, "paper": 0.2, "internal": 0.3}
    found = finding("contradicted_propagation", "raise_m_g", **figures)
    said = suggestion_of(found)
    assert said.problem == (
        "The measurements contradict the propagated figure, which takes the sizes of "
        "errors as stated: propagated 5.0 cm, paper 20 cm, internal 30 cm"
    )
    assert said.remedy.startswith("Raise m_g_um of the low flight, or look for gross")


def test_coverages_that_differ_more_than_the_budget():
    found = finding("contradicted_budget", "raise_m_g", paper=0.02, internal=0.04)
    assert suggestion_of(found).problem == (
        "The coverages differ more than the budget explains: internal 4.0 cm, paper "
        "2.0 cm"
    )


def test_what_is_missing_is_said_with_the_way_to_it():
    said = suggestion_of(finding("no_check_points", "give_check_points"))
    assert 'role = "check"' in said.remedy
    found = finding("figure_left_out", "give_standard_errors_of_control")
    said = str(suggestion_of(found))
    assert "standard_error_total is missing: the control points have no stand" in said
    assert "Give standard_error_m, TOTAL in metres, in [control_points]." in said
