"""Words for findings on models, made by hand."""

import pytest

from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of


def reason(k, n_models=1):
    return {
        "flight": "low_flight",
        "reason": f"reason {k}.",
        "remedy": "Measure more. " if k == 0 else "",
        "n_models": n_models,
        "models": tuple(f"{k}/{i}" for i in range(min(n_models, 10))),
    }


def failed(n_reasons):
    reasons = tuple(reason(k, 30 if k == 0 else 1) for k in range(n_reasons))
    facts = {"n_failed": 37, "n_models": 60, "n_reasons": n_reasons}
    facts["reasons"] = reasons
    return Finding("failed_models", Subject.MODEL, facts=facts)


def test_failed_models_have_a_line_for_each_reason():
    said = suggestion_of(failed(2))
    assert said.problem == "37 of 60 models failed"
    assert said.details == (
        "low flight, 30 models (0/0, 0/1, 0/2 and 27 more): reason 0. Measure more.",
        "low flight, 1 model (1/0): reason 1",
    )


def test_many_reasons_are_cut_short():
    said = suggestion_of(failed(8))
    assert len(said.details) == 6
    assert said.details[-1] == "and 3 further reasons, see failures.csv"


def test_points_without_coordinates_are_named():
    finding = Finding(
        "points_without_coordinates",
        Subject.POINT,
        names=("a", "b"),
        remedy="look_at_their_models",
        facts={"n_points": 2},
    )
    assert str(suggestion_of(finding)) == (
        "2 measured points without coordinates (a, b). Their models failed, or too few "
        "points of these models have approximate coordinates."
    )


def test_models_with_large_m_0_are_named():
    finding = Finding(
        "models_with_large_m_0",
        Subject.MODEL,
        remedy="look_at_residuals",
        facts={
            "n_models": 1,
            "models": (("low_flight", "7/8"),),
            "times_usual": 3.0,
            "largest_m_0": 5.0,
        },
    )
    assert str(suggestion_of(finding)) == (
        "1 model with m_0 more than 3 times that of the flight: low 7/8; up to 5.0 m. "
        "Check their residuals for gross errors and for wrong control."
    )


def test_mirrored_models_are_told_apart_from_mirrored_axes():
    facts = {"n_mirrored": 1, "n_affine": 30, "models": (("high_flight", "3"),)}
    one = Finding(
        "mirrored_models",
        Subject.MODEL,
        remedy="look_for_exchanged_names",
        facts=facts,
    )
    said = suggestion_of(one)
    assert said.problem == "1 of 30 affine models mirrored: high 3"
    everyone = Finding(
        "all_models_mirrored",
        Subject.BLOCK,
        remedy="exchange_axes_unless_left_handed",
        facts={"n_mirrored": 30, "n_affine": 30},
    )
    said = suggestion_of(everyone)
    assert said.problem == "All 30 models are mirrored"
    assert said.remedy.endswith("otherwise exchange easting and northing")


@pytest.mark.parametrize(
    ("code", "facts", "problem"),
    [
        (
            "points_in_one_coverage",
            {"n_points": 3, "n_in_one_model": 1},
            "3 points in one coverage only (a, b, c), 1 in one model only",
        ),
        (
            "points_in_one_model",
            {"n_points": 3},
            "3 points in one model only (a, b, c)",
        ),
    ],
)
def test_points_that_nothing_confirms_are_named(code, facts, problem):
    finding = Finding(
        code,
        Subject.POINT,
        names=("a", "b", "c"),
        remedy="nothing_confirms_them",
        facts=facts,
    )
    assert suggestion_of(finding).problem == problem
    assert suggestion_of(finding).remedy == "Nothing confirms a point in one model"


def test_models_without_redundancy_are_named():
    finding = Finding(
        "models_without_redundancy",
        Subject.MODEL,
        remedy="gross_errors_cannot_be_seen",
        facts={"n_models": 1, "models": (("low_flight", "7/8"),)},
    )
    said = suggestion_of(finding)
    assert said.problem == "1 model without redundancy: low 7/8"
