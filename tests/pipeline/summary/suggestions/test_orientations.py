"""Words for findings on relative orientations, made by hand."""

import math

import pytest

from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of


def models_of(*names):
    models = tuple(("high_flight", name) for name in names)
    return {"n_models": len(names), "models": models}


def finding(code, remedy, facts):
    return Finding(code, Subject.MODEL, remedy=remedy, facts=facts)


def test_orientations_that_did_not_converge_are_named():
    found = finding(
        "orientations_without_convergence",
        "look_for_gross_errors_of_orientation",
        models_of("7/8"),
    )
    said = suggestion_of(found)
    assert said.problem == (
        "1 model with a relative orientation that did not converge: high 7/8"
    )


@pytest.mark.parametrize(
    ("inflation", "known"),
    [
        (12.34, "up to 12.3 times as uncertain as on flat terrain"),
        (math.inf, "not determined"),
    ],
)
def test_models_near_a_dangerous_surface_are_named(inflation, known):
    facts = {"critical": models_of("b"), "weak": models_of("a", "c")}
    facts["inflation"] = inflation
    found = finding(
        "models_near_a_dangerous_surface", "measure_points_elsewhere", facts
    )
    assert str(suggestion_of(found)) == (
        "Relative orientation near a dangerous surface: 1 model critical (high b), 2 "
        f"models weak (high a, high c); omega is {known}. Measure points in them that "
        "lie higher or lower, or farther apart."
    )


def test_a_verdict_that_no_model_has_is_not_said():
    facts = {"critical": models_of(), "weak": models_of("a"), "inflation": 2.5}
    found = finding(
        "models_near_a_dangerous_surface", "measure_points_elsewhere", facts
    )
    said = suggestion_of(found).problem
    assert ": 1 model weak (high a); omega" in said


def test_pairs_that_fit_twice_are_named():
    found = finding(
        "ambiguous_orientations", "measure_more_points", models_of("a", "b")
    )
    said = suggestion_of(found).problem
    assert said.startswith("2 models with a second relative orientation that fits abou")


def test_large_sigma_0_is_said_with_the_largest():
    facts = {**models_of("a"), "times_usual": 3.0, "largest_sigma_0": 4.2e-5}
    found = finding(
        "orientations_with_large_sigma_0", "look_for_gross_errors_of_orientation", facts
    )
    said = suggestion_of(found).problem
    assert said == (
        "1 model with sigma_0 of the relative orientation more than 3 times the median "
        "of the flight: high a; up to 42 µm"
    )


@pytest.mark.parametrize(
    ("code", "remedy", "advice"),
    [
        (
            "image_points_worse_than_given",
            "give_that_m_g_or_a_larger_one",
            "Give that figure or a larger one",
        ),
        (
            "image_points_better_than_given",
            "give_a_smaller_m_g",
            "Give a figure near that one",
        ),
    ],
)
def test_both_figures_of_image_points_are_said(code, remedy, advice):
    flight = {"flight": "low_flight", "given_um": 3.3}
    flight |= {"estimated_um": 5.04, "standard_error_um": 0.21}
    found = finding(code, remedy, {"flights": (flight,)})
    said = suggestion_of(found)
    assert said.problem == (
        "m_g_um of the low flight is given as 3.3, but the residuals of the image "
        "points show 5.04 ± 0.21"
    )
    assert said.remedy.startswith(advice)


def test_parallaxes_of_the_wrong_sign_are_said():
    facts = {"m_0_corrected": 0.2, "m_0_uncorrected": 0.1}
    facts["flight"] = "low_flight"
    found = finding("corrections_that_spoil", "turn_sign_of_y_parallax", facts)
    said = str(suggestion_of(found))
    assert said.startswith(
        "The corrections by y-parallaxes make the low flight fit worse: m_0 20 cm, "
        "without them 10 cm. Change the sign of y_parallax: y of the moved bundle "
        "minus y of the fixed one"
    )


def test_mirrored_images_are_said():
    names = [f"1/{k}" for k in range(1, 24)]
    said = str(
        suggestion_of(
            finding("models_upside_down", "turn_sign_of_x_or_y", models_of(*names))
        )
    )
    assert said.startswith("23 spatial models upside down: high 1/1, high 1/2")
    assert "and 18 more" in said
    assert "Change the sign of x or y in their image" in said


def test_image_points_that_contradict_are_named():
    points = tuple(("low_flight", "7/8", f"P{k}") for k in range(6))
    found = finding(
        "image_points_that_contradict",
        "taken_out",
        {"n_points": 6, "image_points": points},
    )
    said = suggestion_of(found)
    assert said.problem == (
        "6 image points that contradict their pair, worst first (flight, model, "
        "point): low 7/8 P0, low 7/8 P1, low 7/8 P2, low 7/8 P3 and 2 more"
    )
    assert said.remedy.startswith("They were taken out of the orientation")
