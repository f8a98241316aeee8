"""Gross errors and wrong sizes of errors, from tables made by hand.

That they are found in whole blocks is shown in test_outliers, test_coverage_screening,
test_leave_one_out, test_variance_components and test_repeated_settings.
"""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings import suspects as judges


def residuals(p_values, *, flight="low_flight", n=200):
    """The first of n observations are suspects, with such probabilities."""
    n_suspects = len(p_values)
    return pd.DataFrame(
        {
            "flight": flight,
            "coverage": "1",
            "model_id": "7/8",
            "point_id": [f"P{k}" for k in range(n)],
            "residual_easting": [0.3] * n_suspects + [0.01] * (n - n_suspects),
            "residual_northing": [-0.4] * n_suspects + [0.01] * (n - n_suspects),
            "p_value": [*p_values, *np.linspace(0.1, 0.9, n - n_suspects)],
            "is_suspect": [True] * n_suspects + [False] * (n - n_suspects),
        }
    )


def examined_with(rows, outliers="keep", gross=None):
    gross = rows.iloc[:0] if gross is None else gross
    return SimpleNamespace(
        residuals=rows,
        gross_measurements=gross,
        named_measurements=gross,
        # every point is measured twice
        model_points={
            flight: pd.concat([rows, rows]) for flight in set(rows["flight"])
        },
        settings=SimpleNamespace(outliers=outliers),
        snooped_flights=("low_flight",),
    )


def test_suspect_observations_come_worst_first():
    found = judges.suspect_observations(examined_with(residuals([1e-7, 1e-9])))
    assert found.names == ("P1", "P0")
    assert found.facts["n_observations"] == 2
    assert found.facts["observations"][0] == ("low_flight", "1", "7/8", "P1")
    assert found.observed == found.facts["largest"] == pytest.approx(0.5)
    assert found.probability == pytest.approx(200 * 1e-9)


@pytest.mark.parametrize(
    ("flight", "outliers", "remedy"),
    [
        ("low_flight", "keep", "measure_again_or_snoop"),
        ("high_flight", "keep", "measure_again"),
        ("low_flight", "snoop", "measure_excluded_again"),
        ("high_flight", "snoop", "measure_again"),
        ("low_flight", "tukey", "measure_again"),
    ],
)
def test_snooping_is_named_where_it_would_help(flight, outliers, remedy):
    rows = residuals([1e-9], flight=flight)
    assert judges.suspect_observations(examined_with(rows, outliers)).remedy == remedy


def test_the_worst_of_many_must_stand_out_of_all():
    # 200 tests at 0.001: 5e-6
    assert judges.suspect_observations(examined_with(residuals([6e-6]))) is None
    assert judges.suspect_observations(examined_with(residuals([4e-6]))) is not None


def test_what_was_named_once_is_not_named_again():
    rows = residuals([1e-9, 1e-8])
    examined = examined_with(rows, gross=rows.iloc[[1, 0]])
    first = judges.gross_measurements(examined)
    assert first.names == ("P0", "P1")
    assert first.observed == pytest.approx(0.5)
    assert judges.suspect_observations(examined) is None


def adjusted_with(**is_set_aside):
    """An adjustment with two control points that contradict it, and one good one."""
    control = pd.DataFrame(
        {
            "point_id": ["good", "bad", "worse"],
            "strain_easting": [0.01, 0.3, 0.6],
            "strain_northing": [0.01, 0.4, 0.8],
            "p_value": [0.5, 1e-5, 1e-9],
            "is_suspect": [False, True, True],
            "is_set_aside": [False, False, False],
        }
    ).assign(**is_set_aside)
    return SimpleNamespace(
        adjustment=SimpleNamespace(control=control), set_aside_may_be_right=False
    )


def test_kept_control_against_the_block_is_grave():
    found = judges.control_against_block(adjusted_with())
    assert found.code == "control_against_block"
    assert found.gravity is Gravity.GRAVE
    assert found.names == ("worse", "bad")
    assert found.facts == {"n_points": 2, "largest": pytest.approx(1.0)}
    assert found.probability == 1e-9


def test_control_that_was_set_aside_is_a_warning():
    aside = adjusted_with(is_set_aside=[False, True, True])
    found = judges.control_against_block(aside)
    assert found.code == "control_set_aside"
    assert found.gravity is Gravity.WARNING
    assert found.remedy == "check_control"


def test_control_that_was_set_aside_and_may_be_right_is_grave():
    aside = adjusted_with(is_set_aside=[False, True, True])
    aside.set_aside_may_be_right = True
    found = judges.control_against_block(aside)
    assert found.code == "control_set_aside"
    assert found.gravity is Gravity.GRAVE
    assert found.remedy == "check_all_control"
    assert found.facts["are_alike"]
    # two of three: more than data snooping is made for
    assert found.facts["are_many"]
    assert found.facts["n_control"] == 3


def test_control_that_fits_is_not_named():
    good = adjusted_with(is_suspect=False)
    assert judges.control_against_block(good) is None


def test_exchanged_names_show_as_points_that_differ(faulty_result):
    found = judges.points_that_differ(faulty_result.examination)
    models = faulty_result.block.low_flight.model_points
    last = models[models["model_id"] == models["model_id"].iloc[-1]]
    assert set(last["point_id"]) & set(found.names)
    assert found.facts["n_points"] == len(found.names)
    assert found.observed > judges.LARGE_SPREAD * found.expected > 0.0


@pytest.mark.parametrize("judge", judges.TWO_STEP)
def test_a_good_block_has_none(good_result, judge):
    assert judge(good_result.examination) is None
