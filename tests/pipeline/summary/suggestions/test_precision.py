"""Words for imprecise points and for a block that shrinks, of findings made by hand."""

import pytest

from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of


def imprecise(models=(), n_models=0):
    return Finding(
        "imprecise_points",
        Subject.POINT,
        names=("b", "a"),
        remedy="measure_more_control_there",
        facts={
            "n_points": 2,
            "times_usual": 3.0,
            "median": 0.04,
            "largest": 0.3,
            "rms_of_others": 0.04,
            "n_models": n_models,
            "models": models,
        },
    )


def test_the_worst_come_first_and_the_others_have_their_figure():
    assert str(suggestion_of(imprecise())) == (
        "2 new points with standard errors of more than 3 times the median of 4.0 cm, "
        "up to 30 cm (b, a); the others have 4.0 cm (total, RMS). Measure more control "
        "there, spread over the model, or do without these points."
    )


@pytest.mark.parametrize(
    ("models", "said"), [(("7/8",), "1 model: 7/8"), (("7/8", "9"), "2 models: 7/8, 9")]
)
def test_models_most_of_whose_points_they_are_are_named(models, said):
    problem = suggestion_of(imprecise(models, len(models))).problem
    assert problem.endswith(f". They are most points of low-flight {said}")


def test_a_block_that_shrinks_is_said_with_its_worst_point():
    facts = {"moved": 0.03, "largest": 0.08, "worst": "a\nb", "ratio_to_claimed": 1.2}
    finding = Finding(
        "block_that_shrinks",
        Subject.BLOCK,
        remedy="give_control_on_the_far_side",
        facts=facts,
    )
    said = suggestion_of(finding)
    assert said.problem == (
        "Control does not keep the block from shrinking: errors of the model "
        "coordinates move the new points by about 3.0 cm (total, RMS), up to 8.0 cm at "
        "a\\nb, 1.2 times the standard errors, which do not include that"
    )


@pytest.mark.parametrize(
    ("unit", "said"),
    [
        ("", ""),
        ("centimetres", ", as if they were centimetres"),
        ("millimetres", ", as if they were millimetres"),
    ],
)
def test_control_errors_that_are_too_large_have_both_figures(unit, said):
    facts = {"stated": 3.0, "shown": 0.031, "error_of_shown": 0.004, "unit": unit}
    finding = Finding(
        "wrong_control_errors",
        Subject.CONTROL,
        remedy="give_that_standard_error",
        facts=facts,
    )
    assert suggestion_of(finding).problem == (
        "The standard errors of control in plan are given as 3.0 m, but the residuals "
        f"show 3.1 cm (total, RMS; ± 4.0 mm){said}"
    )
