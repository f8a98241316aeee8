"""What can be asked of each way's solution, and that it is computed once."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment import examination
from einschalt.pipeline.assessment.examination import (
    NothingExamined,
    SimultaneousExamination,
    TwoStepExamination,
    examine,
)
from einschalt.pipeline.densification.two_steps import WithoutTwoSteps

POINTS = pd.DataFrame(
    {"point_id": ["A", "B", "n"], "role": ["control", "control", "new"]}
)


def test_every_solution_is_examined_in_its_own_way(
    good_result, simultaneous_result, given_approximations_result
):
    assert type(good_result.examination) is TwoStepExamination
    assert type(given_approximations_result.examination) is TwoStepExamination
    adjusted = simultaneous_result.examination
    assert type(adjusted) is SimultaneousExamination
    assert type(adjusted.two_step) is TwoStepExamination
    assert adjusted.two_step.solution is simultaneous_result.solution.two_step


def test_where_the_two_steps_are_not_possible_nothing_shows():
    examined = examine(WithoutTwoSteps(None, {}, "too little control"))
    assert type(examined) is NothingExamined
    assert not examined.is_possible
    assert examined.components is None
    assert examined.patterns.affinities == ()
    assert examined.patterns.strain is None


def test_two_steps_hold_all_control():
    examined = TwoStepExamination(SimpleNamespace(points=POINTS))
    assert examined.held_control["point_id"].tolist() == ["A", "B"]


def test_an_adjustment_does_not_hold_what_it_set_aside():
    control = pd.DataFrame({"point_id": ["A", "B"], "is_set_aside": [True, False]})
    adjustment = SimpleNamespace(control=control)
    solution = SimpleNamespace(points=POINTS, adjustment=adjustment)
    examined = SimultaneousExamination(solution)
    assert examined.adjustment is adjustment
    assert examined.held_control["point_id"].tolist() == ["B"]


@pytest.mark.parametrize("once", [0.05, np.nan])
def test_the_figure_of_one_pass_is_that_of_new_points(once):
    points = pd.DataFrame(
        {"point_id": ["a", "b", "K"], "role": ["new", "new", "control"]}
    )
    examined = TwoStepExamination(SimpleNamespace(points=points))
    # the control point is far worse, and does not count
    sizes = np.array([once, once, 9.0])
    errors = SimpleNamespace(
        point_ids=points["point_id"].to_numpy(dtype=object),
        covariance=np.eye(2) * (sizes**2 / 2.0)[:, None, None],
    )
    vars(examined)["errors_of_one_pass"] = errors if np.isfinite(once) else None
    assert examined.total_of_one_pass == pytest.approx(once, nan_ok=True)


def test_without_iteration_there_is_no_figure_of_one_pass(good_result):
    assert good_result.examination.errors_of_one_pass is None
    assert np.isnan(good_result.examination.total_of_one_pass)


@pytest.mark.parametrize("name", ["credible", "checked", "known_check"])
def test_each_judgement_is_made_once(good_result, name):
    examined = examine(good_result.solution)
    assert name not in vars(examined)
    assert getattr(examined, name) is getattr(examined, name)


@pytest.mark.parametrize(
    ("name", "function"),
    [
        ("claim", "examine_claim"),
        ("components", "estimate_components"),
        ("patterns", "find_patterns"),
        ("left_out_control", "leave_out_control"),
        ("repeated_settings", "m_g_of_repeated_settings"),
    ],
)
def test_each_is_computed_when_asked_and_once(monkeypatch, good_result, name, function):
    calls = []
    compute = getattr(examination, function)

    def counted(*arguments):
        calls.append(name)
        return compute(*arguments)

    monkeypatch.setattr(examination, function, counted)
    examined = examine(good_result.solution)
    assert calls == []
    first = getattr(examined, name)
    assert getattr(examined, name) is first
    assert calls == [name]


def test_reliability_of_the_adjustment_is_that_of_its_residuals(simultaneous_result):
    found = simultaneous_result.examination.reliability
    rows = simultaneous_result.solution.adjustment.residuals
    pd.testing.assert_frame_equal(found, rows[list(found)])


def test_the_adjustment_has_the_findings_of_the_two_steps(
    good_result, simultaneous_result
):
    examined = simultaneous_result.examination
    assert examined.components == good_result.examination.components
    assert examined.patterns is examined.two_step.patterns
    assert not examined.claim.tests
    assert examined.left_out_control is None
