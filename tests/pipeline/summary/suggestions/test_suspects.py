"""Words for gross errors and wrong sizes of errors, of findings made by hand."""

import pytest

from einschalt.pipeline.assessment.finding import Finding, Subject
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of

ROWS = tuple(("low_flight", "1", "7/8", f"P{k}") for k in range(6))


def finding(code, remedy, names=(), **facts):
    return Finding(code, Subject.POINT, names=names, remedy=remedy, facts=facts)


def test_suspect_observations_are_named_worst_first():
    found = finding(
        "suspect_observations",
        "measure_again_or_snoop",
        n_observations=6,
        observations=ROWS,
        largest=0.4,
    )
    said = suggestion_of(found)
    assert said.problem == (
        "6 residuals of up to 40 cm that chance does not explain, worst first (flight, "
        "coverage, model, point): low 1 7/8 P0, low 1 7/8 P1, low 1 7/8 P2, low 1 7/8 "
        "P3 and 2 more"
    )
    assert said.remedy == 'Measure them again, or set outliers = "snoop"'


def test_gross_measurements_stand_in_their_file():
    found = finding(
        "gross_measurements",
        "measure_rejected_again",
        n_observations=1,
        observations=ROWS[:1],
        largest=0.4,
        n_undecided=0,
    )
    said = suggestion_of(found)
    assert said.problem == (
        "1 measurement, off by up to 40 cm compared with the other models of the "
        "flight, excluded, worst first (flight, coverage, model, point): low 1 7/8 P0"
    )
    assert said.remedy == (
        "Measure them again; gross_measurements.csv lists all of them"
    )


def test_coverages_that_differ_stand_in_their_file():
    found = finding(
        "coverages_that_differ",
        "measure_again_see_coverages",
        names=("P0",),
        n_points=1,
        largest=0.4,
    )
    said = suggestion_of(found)
    assert said.problem == (
        "1 point with coverages that differ significantly, by up to 40 cm: P0"
    )
    assert "coverages.csv" in said.remedy


def test_scattered_values_are_said_beside_the_usual_ones():
    found = finding(
        "points_that_differ",
        "look_for_gross_errors_and_exchanged_names",
        names=("P0",),
        n_points=1,
        times_usual=5.0,
        median=0.03,
        largest=9.0,
    )
    assert suggestion_of(found).problem == (
        "1 point with values more than 5 times as widely scattered as the median of "
        "3.0 cm (spread_total): P0; up to 9.0 m"
    )


def test_control_that_the_others_miss_is_named():
    found = finding(
        "control_that_contradicts",
        "check_worst_control",
        names=("worse", "bad"),
        n_points=2,
        largest=0.4,
    )
    said = suggestion_of(found)
    assert said.problem == (
        "2 control points, each predicted without itself, off by up to 40 cm, more "
        "than chance explains, worst first: worse, bad"
    )
    assert "a wrong one spoils the others" in said.remedy


@pytest.mark.parametrize(("n", "verb"), [(1, "contradicts"), (2, "contradict")])
def test_control_against_the_block_is_named(n, verb):
    found = finding(
        "control_against_block",
        "check_control_or_snoop",
        names=("A", "B")[:n],
        n_points=n,
        largest=0.4,
    )
    said = suggestion_of(found).problem
    assert f" {verb} the block, by up to 40 cm: A" in said
    assert said.endswith(
        "If kept, they make the new points near them worse than stated"
    )


def test_control_that_was_set_aside_is_named():
    found = finding(
        "control_set_aside",
        "check_control",
        names=("A",),
        n_points=1,
        largest=0.4,
        are_alike=False,
        are_many=False,
    )
    assert str(suggestion_of(found)) == (
        "1 control point set aside for contradicting the block, by up to 40 cm: A. "
        "Check the coordinates and names."
    )


def test_control_set_aside_in_one_direction_may_be_right():
    found = finding(
        "control_set_aside",
        "check_all_control",
        names=("A", "B"),
        n_points=2,
        largest=0.4,
        are_alike=True,
    )
    said = suggestion_of(found)
    assert "of the control around them" in said.remedy
    (detail,) = said.details
    assert "nothing measured tells which" in detail


def test_where_many_are_set_aside_it_is_said_of_how_many():
    found = finding(
        "control_set_aside",
        "check_all_control",
        names=("A", "B"),
        n_points=2,
        n_control=4,
        largest=0.4,
        are_alike=False,
        are_many=True,
    )
    (detail,) = suggestion_of(found).details
    assert detail.startswith("These are 2 of 4 control points")


@pytest.mark.parametrize(
    ("code", "remedy", "what", "says"),
    [
        (
            "wrong_measuring_errors",
            "give_that_m_g",
            "the measurements show",
            "Give that figure, if no gross error made it",
        ),
        (
            "wrong_measuring_errors",
            "look_for_gross_errors",
            "the measurements show",
            "Look for gross errors",
        ),
        (
            "settings_that_scatter",
            "give_at_least_that_m_g",
            "repeated settings scatter by",
            "Give at least that figure, if no gross error made it",
        ),
    ],
)
def test_both_figures_of_each_flight_are_said(code, remedy, what, says):
    figures = {"given_um": 7.5, "estimated_um": 5.04, "standard_error_um": 0.21}
    flights = tuple({"flight": f"{f}_flight", **figures} for f in ("high", "low"))
    said = suggestion_of(finding(code, remedy, flights=flights))
    one = "m_g_um of the {} flight is given as 7.5, but {} 5.04 ± 0.21"
    assert said.problem == "; ".join(one.format(f, what) for f in ("high", "low"))
    assert said.remedy == says


def test_points_whose_settings_scatter_are_named():
    found = finding(
        "scattered_points",
        "set_again",
        n_points=1,
        observations=ROWS[:1],
        widest_um=35.0,
    )
    said = suggestion_of(found)
    assert said.problem == (
        "1 point with settings up to 35 µm apart in the image (total, one setting), "
        "which chance does not explain, worst first (flight, coverage, model, point): "
        "low 1 7/8 P0"
    )
    assert said.remedy == "Set them again: their mean is wrong"
