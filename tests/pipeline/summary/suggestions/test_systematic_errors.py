"""Words for affinity and strain, of findings made by hand."""

import math
from dataclasses import replace

import pytest

from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of


def test_an_affinity_is_said_with_the_way_to_take_it_up():
    numbers = {"stretch": 3e-4, "stretch_error": 1e-5, "shear": -2e-5}
    numbers |= {"shear_error": 1e-5, "bias": 0.02}
    axes = {"high": "ground", "low": "machine"}
    flights = tuple(
        {"flight": f"{name}_flight", "axes": along, **numbers}
        for name, along in axes.items()
    )
    found = Finding(
        "film_affinity",
        Subject.FLIGHT,
        remedy="set_affine",
        facts={"flights": flights},
    )
    said = suggestion_of(found)
    assert said.problem.startswith("Film or machine has an affinity: in the high flig")
    assert (
        "in the high flight models are longer to the east than to the north by 300 ± "
        "10 ppm, with a shear of -20 ± 10 ppm, however they were turned in the machine"
    ) in said.problem
    assert (
        "in the low flight x is longer than y by 300 ± 10 ppm, with a shear of -20 ± "
        "10 ppm; effect 2.0 cm (total, RMS)"
    ) in said.problem
    assert said.remedy == (
        'Set transformation = "affine" in [high_flight], [low_flight]'
    )


def test_curved_models_are_said_with_the_way_that_models_them():
    flights = ({"flight": "high_flight", "size": 0.06},)
    found = Finding(
        "curved_models",
        Subject.FLIGHT,
        remedy="adjust_or_calibrate",
        facts={"flights": flights},
    )
    said = suggestion_of(found)
    assert "in the high flight by 6.0 cm (total, RMS)" in said.problem
    assert 'method = "simultaneous"' in said.remedy


def strained(remedy="check_network", with_strain=0.13):
    return Finding(
        "strained_network",
        Subject.CONTROL,
        remedy=remedy,
        facts={
            "n_control": 30,
            "size": 0.12,
            "reach": 900.0,
            "displacements": tuple((name, 0.2, -0.1) for name in "ABCD"),
            "claimed": 0.05,
            "claimed_with_strain": with_strain,
        },
    )


def test_strain_is_said_with_what_to_reckon_with():
    assert suggestion_of(strained()).problem == (
        "The control network is strained: neighbours among the 30 control points are "
        "displaced together, by 12 cm (total, RMS) over 900 m, most at A (easting "
        "20 cm, northing -10 cm), B (easting 20 cm, northing -10 cm), C (easting "
        "20 cm, northing -10 cm); standard_error_total does not include that: allow "
        "for 13 cm, not 5.0 cm"
    )


def test_without_a_figure_nothing_is_reckoned():
    said = suggestion_of(strained(with_strain=math.nan)).problem
    assert said.endswith("standard_error_total does not include that")


@pytest.mark.parametrize(
    ("remedy", "is_said"), [("check_network_or_adjust", True), ("check_network", False)]
)
def test_the_other_way_is_named_where_it_would_help(remedy, is_said):
    said = suggestion_of(strained(remedy)).remedy
    assert ('method = "simultaneous" suffers less' in said) == is_said


def test_contradicting_control_is_counted():
    found = Finding(
        "contradicting_control",
        Subject.CONTROL,
        remedy="look_for_wrong_control_or_raise_errors",
        probability=0.0012,
        facts={"n_control": 30, "moved": 0.0, "is_beside_given": False},
    )
    assert str(suggestion_of(found)) == (
        "The 30 control points contradict each other by more than their standard "
        "errors (p 0.0012). Look for wrong ones, or raise standard_error_m."
    )
    moving = replace(found, facts=found.facts | {"moved": 0.138})
    assert "(p 0.0012), which may put the new points off by 14 cm" in str(
        suggestion_of(moving)
    )
    beside = replace(moving, facts=moving.facts | {"is_beside_given": True})
    assert str(suggestion_of(beside)).startswith(
        "The 30 control points contradict the approximate points, which agree among "
        "themselves as stated (p 0.0012); if some of control is wrong together, the "
        "new points are off by 14 cm."
    )
