"""Words for drift, of findings made by hand."""

import math

from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of

FACTS = {
    "n_models": 10,
    "n_models_held": 4,
    "moved": 0.2,
    "propagated_once": 0.05,
    "propagated_now": 0.06,
}


def finding(code, remedy, **changes):
    return Finding(code, Subject.BLOCK, remedy=remedy, facts={**FACTS, **changes})


def test_a_block_that_nothing_holds_drifts():
    found = finding("drift_without_control", "one_pass_or_measure_control")
    assert str(suggestion_of(found)) == (
        "The low flight was repeated on its own coordinates without a control point to "
        "hold it: the block drifts, so far by up to 20 cm (RMS); propagated 5.0 cm "
        "after one pass, 6.0 cm now. Set iterations = 1, or measure control in the low "
        "flight."
    )
    unknown = finding(
        "drift_without_control", "one_pass_or_measure_control", propagated_now=math.nan
    )
    assert "propagated" not in suggestion_of(unknown).problem


def test_iterations_that_make_points_worse_are_told():
    said = suggestion_of(finding("iterations_that_spoil", "one_pass_or_more_control"))
    assert said.problem == (
        "The iterations make the points worse, 6.0 cm instead of 5.0 cm after one pass "
        "(propagated): only 4 of 10 models of the low flight contain control"
    )
    assert said.remedy == "Set iterations = 1, or give the low flight more control"


def test_thin_control_without_a_figure_is_told():
    said = suggestion_of(
        finding("drift_that_nothing_tells", "one_pass_or_more_control")
    )
    assert said.problem == (
        "Only 4 of 10 models of the low flight contain control: the others may have "
        "drifted by up to 20 cm (RMS), which no propagated figure shows"
    )
