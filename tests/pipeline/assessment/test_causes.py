"""What a cause explains is told with it, and what it does not explain beside it."""

from dataclasses import replace

import pytest

from einschalt.pipeline.assessment.causes.ranked import (
    OF_BLOCK,
    OF_FLIGHT,
    OF_POINTS,
    ranked_causes,
    with_causes,
)
from einschalt.pipeline.assessment.evidence.exchanged_names import ExchangedNames
from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.assessment.findings.catalogue import ORDER
from einschalt.pipeline.summary.suggestions.catalogue import suggestions_of

EXCHANGE = ExchangedNames(
    flight="low_flight",
    coverage="2",
    model_id="2/4",
    points=("1048", "1050"),
    measured_as=("1050", "1048"),
    apart=568.5,
    m_0=197.6,
    m_0_exchanged=0.094,
    model_points=("1048", "1050", "1060"),
)


def found(code, *names):
    models = tuple(("low_flight", name) for name in names)
    return Finding(code, Subject.POINT, names=names, facts={"models": models})


def explained(*findings, is_coupled=False):
    marked = with_causes(findings, [EXCHANGE], is_coupled=is_coupled)
    assert marked[0].code == "exchanged_names"
    assert [f.code for f in marked[1:]] == [f.code for f in findings]
    return [f.code for f in marked if f.explained_by]


def test_without_a_cause_findings_stay_as_they_are():
    findings = (found("points_that_differ", "1048"),)
    assert with_causes(findings, (), is_coupled=False) == findings


def test_what_a_mirrored_photograph_makes_follows_from_its_model():
    """Two control points were told first, 78 cm off: the model was."""
    codes = "control_that_contradicts", "claim_that_does_not_stand", "no_check_points"
    over = found("models_upside_down", "2/5")
    marked = with_causes((over, *map(found, codes)), (), is_coupled=False)
    assert marked[0].facts["explains"] == codes[:2]
    assert [f.explained_by for f in marked[1:]] == ["models_upside_down"] * 2 + [""]
    assert ranked_causes(marked) == ("models_upside_down",)


def test_points_of_the_model_are_explained_and_others_are_not():
    inside = found("coverages_that_differ", "1050", "1060")
    outside = found("points_that_differ", "1050", "2001")
    assert explained(inside, outside) == ["coverages_that_differ"]


def test_in_one_adjustment_that_keeps_gross_errors_all_points_are_reached():
    outside = found("control_against_block", "1050", "2001")
    assert explained(outside) == []
    assert explained(outside, is_coupled=True) == ["control_against_block"]


def test_a_list_that_was_cut_is_not_explained():
    many = found("coverages_that_differ", *["1048"] * 100)
    assert explained(many) == []


def test_sizes_of_errors_follow_where_the_flight_is_that_of_the_exchange():
    assert explained(found("wrong_measuring_errors", "low_flight")) == [
        "wrong_measuring_errors"
    ]
    assert explained(found("wrong_measuring_errors", "high_flight")) == []
    misfit = found("high_flight_that_misfits", "high_flight")
    assert explained(misfit) == []
    assert explained(misfit, is_coupled=True) == ["high_flight_that_misfits"]


def test_other_models_and_what_no_gross_error_makes_stay():
    assert explained(found("models_with_large_m_0", "2/4")) == ["models_with_large_m_0"]
    assert explained(found("models_with_large_m_0", "2/4", "2/5")) == []
    assert explained(found("failed_models", "2/4"), found("no_check_points")) == []


@pytest.mark.parametrize("code", sorted(OF_POINTS | OF_BLOCK | OF_FLIGHT))
def test_only_findings_that_exist_are_explained(code):
    assert code in ORDER


def test_the_words_name_the_pair_first_and_the_consequences_once(faulty_result):
    findings = faulty_result.assessment.findings
    assert findings[0].code == "exchanged_names"
    first, *others = suggestions_of(findings)
    assert first.problem.startswith("Exchanged names: 1048 and 1050 in low flight")
    (consequences,) = first.details
    n_explained = sum(bool(f.explained_by) for f in findings)
    assert consequences.startswith(f"{n_explained} further findings may follow")
    assert len(others) == len(findings) - 1 - n_explained
    assert not any("1050" in str(other) for other in others)


@pytest.mark.parametrize(
    ("points", "is_slip", "words"),
    [
        (
            ("1", "2", "3"),
            False,
            "1 measured as 2, 2 measured as 3, 3 measured as 1 in",
        ),
        (
            ("1", "2", "3"),
            True,
            "the names of 3 points from 1 to 3 in low flight model",
        ),
    ],
)
def test_more_than_two_names_are_told_as_they_were_mixed(points, is_slip, words):
    exchange = replace(
        EXCHANGE,
        points=points,
        measured_as=(*points[1:], points[0]),
        is_slip=is_slip,
    )
    (cause,) = with_causes((), [exchange], is_coupled=False)
    assert cause.names == points
    (told,) = suggestions_of([cause])
    assert told.problem.startswith(f"Exchanged names: {words}")


def test_the_cause_that_explains_most_comes_first():
    def follows(cause):
        return Finding("points_that_differ", Subject.POINT, explained_by=cause)

    one, other = found("exchanged_names"), found("measurements_given_twice")
    findings = (one, other, follows(other.code), follows(one.code), follows(other.code))
    assert ranked_causes(findings) == (other.code, one.code)
    assert ranked_causes(findings[:-1]) == (one.code, other.code)
    assert ranked_causes((one, other)) == ()
