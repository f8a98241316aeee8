"""What print(result) shows."""

from dataclasses import replace

import numpy as np
import pytest
from tests.changed_results import changed

from einschalt.foundations.language import written_in
from einschalt.foundations.typesetting import length
from einschalt.pipeline.assessment.causes.kept_gross_errors import OF_CONTROL
from einschalt.pipeline.assessment.choice import ChoiceReason, MethodChoice
from einschalt.pipeline.assessment.facts.precision_of_points import SpreadFacts
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.summary.sections.precision import caution
from einschalt.pipeline.summary.summary import sections, summarize
from einschalt.pipeline.summary.verdict import CAUSES, verdict

# (a) without faults (b) failed models and a blunder (c) approximate points given
# (d) nothing from outside
RESULTS = ("good", "faulty", "given_approximations", "unchecked")


@pytest.mark.parametrize("name", RESULTS)
def test_summary_is_the_golden_text(name, request, golden):
    result = request.getfixturevalue(f"{name}_result")
    golden(summarize(result), f"summary_{name}.txt")


@pytest.mark.parametrize("name", RESULTS)
def test_verdict_comes_first_then_problems_then_numbers(name, request):
    result = request.getfixturevalue(f"{name}_result")
    lines = summarize(result).split("\n")
    assert lines[0] == verdict(result.assessment)
    headings = [line for line in lines if line and not line.startswith(" ")]
    assert headings[1] == "Problems and suggestions"
    assert headings[2].startswith("Precision of the new points")


@pytest.mark.parametrize("name", RESULTS)
def test_total_and_coordinate_errors_are_told_apart(name, request):
    text = summarize(request.getfixturevalue(f"{name}_result"))
    assert "All figures are total point errors" in text
    assert "the error of one coordinate is" in text


def test_printing_a_result_shows_its_summary(good_result):
    assert str(good_result) == summarize(good_result)


def test_why_the_paper_figure_is_too_small(good_result, given_approximations_result):
    assert "share the high flight's transformation error, and both" in caution(
        good_result.assessment.precision
    )
    said = caution(given_approximations_result.assessment.precision)
    assert "both coverages share the approximate coordinates; more so if" in said
    assert "not known here" in said


def test_one_coverage_of_given_points_is_too_small_only_conditionally(
    given_approximations_result,
):
    result = given_approximations_result
    points = result.block.low_flight.model_points
    low = replace(
        result.block.low_flight, model_points=points[points["coverage"] == "1"]
    )
    narrow = changed(result, block=replace(result.block, low_flight=low))
    said = caution(narrow.assessment.precision)
    assert said.startswith("The figure of the paper is too small if")


def test_verdict_gives_the_propagated_figure_where_there_is_one(good_result):
    figures = replace(good_result.figures, mean_total=0.0537, mean_paper=0.0367)
    assert verdict(changed(good_result, figures=figures).assessment).startswith(
        "Demo (simulated): 77 new points, 5.4 cm (total, mean of two coverages; 3.7 cm "
        "by Kovarik's budget); "
    )
    figures = replace(figures, mean_total=np.nan)
    assert verdict(changed(good_result, figures=figures).assessment) == (
        "Demo (simulated): 77 new points, 3.7 cm by Kovarik's budget (total, mean "
        "of two coverages)"
    )


def test_verdict_of_a_block_without_new_points(good_result):
    figures = replace(
        good_result.figures, n_new=0, mean_paper=np.nan, mean_total=np.nan
    )
    said = verdict(changed(good_result, figures=figures).assessment)
    # 23 of them: what check points are missed by says more than what was fitted
    assert said.startswith("Demo (simulated): 2")
    assert "known points, no new ones; check points: " in said
    assert said.endswith(" cm (total, RMS)")


def test_verdict_says_failed_models(faulty_result):
    assert "; 3 of 30 models failed" in verdict(faulty_result.assessment)


def test_verdict_says_what_most_points_have_where_a_few_dominate(good_result):
    told = replace(good_result.assessment, spread=SpreadFacts(0.30, 0.051, 0.62))
    assert (
        "budget); a few points dominate: median 5.1 cm, 95th percentile 62 cm; a sim"
        in verdict(told)
    )
    bound = replace(told.credible, is_lower_bound=True)
    assert "dominate" not in verdict(replace(told, credible=bound))


def test_verdict_names_the_better_way_with_its_command(good_result):
    figure = replace(good_result.assessment.credible, value=0.046)
    choice = MethodChoice("two_step", ChoiceReason.SUPPORTED, figure, figure, "")
    told = replace(good_result.assessment, better=choice)
    assert verdict(told).endswith(
        "; the two steps are better: 4.6 cm (--method two_step)"
    )
    bound = replace(figure, is_lower_bound=True)
    told = replace(told, better=replace(choice, two_step=bound))
    assert "are better: 4.6 cm or worse (--method" in verdict(told)


@pytest.mark.parametrize(
    ("method", "reason", "expected"),
    [
        ("two_step", ChoiceReason.SUPPORTED, "support the figure of the two steps"),
        (
            "simultaneous",
            ChoiceReason.SUPPORTED,
            "the measurements support the figure of a simultaneous adjustment",
        ),
        (
            "simultaneous",
            ChoiceReason.WRONG_CONTROL,
            "a simultaneous adjustment shows what a wrong control point does",
        ),
    ],
)
def test_verdict_calls_no_larger_figure_the_better_one(
    good_result, method, reason, expected
):
    """Beside "2.7 cm or worse" the reader must see why 3.9 cm is preferred."""
    figure = replace(good_result.assessment.credible, value=0.046)
    bound = replace(figure, value=0.027, is_lower_bound=True)
    figures = (figure, bound) if method == "two_step" else (bound, figure)
    told = replace(
        good_result.assessment,
        credible=bound,
        better=MethodChoice(method, reason, *figures, ""),
    )
    assert f"{expected}: 4.6 cm (--method {method})" in verdict(told)
    assert "better" not in verdict(told)
    with written_in("de"):
        assert expected not in verdict(told)
        assert f"4,6 cm (--method {method})" in verdict(told)


def test_verdict_names_what_one_adjustment_would_give(good_result):
    """As the adjustment itself has it, and with the command that makes it."""
    adjusted = densify(good_result.block, Settings(method="simultaneous"))
    figure = length(adjusted.assessment.credible.value)
    better = f"a simultaneous adjustment is better: {figure} (--method simultaneous)"
    assert verdict(good_result.assessment).endswith(f"; {better}")
    assert good_result.assessment.better.method == "simultaneous"
    assert verdict(adjusted.assessment).count("--method") == 0


def test_verdict_says_what_to_mend_first(faulty_result):
    told = faulty_result.assessment
    assert "; correct the exchanged names first; 3 of 30" in verdict(told)
    assert "exchanged names first" not in verdict(replace(told, causes=()))


def test_every_cause_has_words(faulty_result):
    explained = {f.explained_by for f in faulty_result.assessment.findings} - {""}
    assert (
        explained
        <= CAUSES.keys()
        == {
            "exchanged_control",
            "strained_network",
            "exchanged_names",
            "wrong_control_height",
            "broken_heights",
            "other_targets",
            "kept_gross_measurements",
            "displaced_region",
            "wrong_approximate_points",
            "models_in_another_unit",
            "exchanged_image_names",
            "measurements_given_twice",
            "lone_wrong_check_point",
            "film_affinity",
            "models_upside_down",
            *OF_CONTROL,
        }
    )


def test_table_of_flights_counts_usable_models(faulty_result):
    low = sections(faulty_result.assessment)["flights"].rows[-1]
    assert low[0] == "low flight"
    assert (low[3], low[4]) == ("23", "20")


def test_heights_are_said_not_to_be_judged(good_result):
    points = good_result.points.assign(height=500.0)
    assert "their precision is not assessed" in summarize(
        changed(good_result, points=points)
    )
    assert "Heights" not in summarize(good_result)


def test_a_name_cannot_add_lines(good_result):
    block = replace(good_result.block, name="a\nb")
    assert verdict(changed(good_result, block=block).assessment).startswith("a\\nb: ")


def test_a_claim_that_explains_the_budget_is_nothing_to_mend_first(faulty_result):
    """It stands first among the causes where approximate points share errors."""
    told = faulty_result.assessment
    credible = replace(told.credible, is_lower_bound=True)
    causes = ("claim_that_does_not_stand",)
    alone = replace(told, credible=credible, findings=(), causes=causes)
    assert verdict(alone) == verdict(replace(alone, causes=()))
