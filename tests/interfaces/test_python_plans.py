"""Plans of Python: the same as those of the command."""

import json
import pickle

import numpy as np
import pandas as pd
import pytest
import shapely
from typer.testing import CliRunner

import einschalt as es
from einschalt.interfaces.cli.main import app
from einschalt.pipeline.planning.choice.finer_choices import REFINED
from einschalt.pipeline.planning.flights.cameras import CAMERAS

SCALES = (6800, 8100, 9500)
CHOICES = es.PlanChoices(scale_number=SCALES, spacing=(250,), m_g_um=(10,))
FILM = ("--scale-number", "6800,8100,9500", "--spacing", 250, "--m-g-um", 10)
UAV = ("--camera", "uav_full_frame", "--kind", "rigid", "--spacing", 6)
FLOWN = ("--scale-number", "2400,2800", "--n-coverages", 2, "--n-settings", 1)


def told_by_command(*options):
    call = ["plan", "--json", *map(str, options)]
    shown = CliRunner().invoke(app, call)
    assert shown.exit_code == 0, shown.stderr
    return json.loads(shown.stdout)["figures"]


def plan_of_a_square(target, choices, **options):
    return es.plan_area(target, shapely.box(0, 0, 7000, 6000), choices, **options)


@pytest.mark.slow
def test_a_target_gives_the_plan_of_the_command():
    told = told_by_command("--target", 0.05, *FILM)
    # the command refines what is not typed
    free = [name for name in REFINED if name != "scale_number"]
    plan = es.plan_target(0.05, CHOICES, refine=free)
    for found, said in ((plan, told), (plan.next_best, told["next_best"])):
        assert found.is_kept == said["is_recommended"]
        assert found.reached == pytest.approx(said["reached_on_layout"], rel=1e-12)
        for name in ("scale_number", "high_scale_number", "n_settings", "cost"):
            assert found.plan[name] == pytest.approx(said[name], rel=1e-12), name
    assert plan.finer == {name: tuple(said) for name, said in told["finer"].items()}
    mean = told["expected_on_layout"]["mean"]
    assert plan.expected.figures.mean == pytest.approx(mean, rel=1e-12)
    assert plan.outcome().startswith("Recommended: ")
    assert isinstance(plan, es.CheckedPlan)
    assert isinstance(plan.search, es.PlanSearch)
    assert isinstance(plan.expected, es.ExpectedPrecision)
    assert plan.expected.plot.map().get_title(loc="left") == "Expected: 4.9 cm"
    assert "--" not in plan.summary()
    # and it is one that can be tried
    assert es.simulate_plan(plan, seed=1).truth is not None


@pytest.mark.slow
def test_a_camera_is_planned_as_the_command_does():
    told = told_by_command("--target", 0.025, *UAV, *FLOWN)
    camera = es.camera_preset("uav_full_frame")
    choices = es.PlanChoices(
        scale_number=(2400, 2800),
        spacing=(6,),
        m_g_um=camera.m_g_um[:1],
        n_coverages=(2,),
        n_settings=(1,),
    )
    frame = es.PlanFrame.of_camera("uav_full_frame", kind="rigid")
    assert frame == es.PlanFrame.of_camera(camera, kind="rigid")
    plan = es.plan_target(0.025, choices, frame, refine="high_over_low")
    assert plan.reached == pytest.approx(told["reached_on_layout"], rel=1e-12)
    assert plan.plan["high_flying_height"] <= camera.max_height == 120.0
    assert plan.plan["gsd"] == pytest.approx(told["gsd"], rel=1e-12)


@pytest.mark.parametrize("plan", [es.plan_target, plan_of_a_square])
def test_refine_may_be_none_and_is_refused_by_its_name(plan):
    """None was a TypeError from inside."""
    assert plan(0.07, CHOICES, refine=None).search is not None
    with pytest.raises(es.EinschaltError, match=r"^refine = 3; expected None, or a"):
        plan(0.07, CHOICES, refine=3)
    with pytest.raises(es.EinschaltError, match="refine = 'n_setings' is unknown"):
        plan(0.07, CHOICES, refine=["n_setings"])


def test_every_camera_of_the_command_is_a_preset():
    for name, camera in CAMERAS.items():
        assert es.camera_preset(name) is camera
        assert name in es.camera_preset.__doc__
        frame = es.PlanFrame.of_camera(name, max_height=90, kind="helmert")
        assert frame.image_format == camera.image_format
        assert (frame.max_height, frame.kind) == (90, "helmert")
    for wrong in ("uav", None, ["film_wide"]):
        with pytest.raises(es.EinschaltError, match=r"camera = .* is unknown"):
            es.PlanFrame.of_camera(wrong)


@pytest.mark.slow
def test_a_row_of_a_search_is_expected_as_it_is_checked():
    frame = es.PlanFrame(control_standard_error=0.02)
    found = es.find_plans(0.06, CHOICES, frame)
    expected = es.expect_precision(found.nearest, frame=frame)
    plan = es.plan_target(0.06, CHOICES, frame)
    if plan.plan.name != found.nearest.name:  # the estimate is not that exact
        expected = es.expect_precision(found.plans.loc[plan.plan.name], frame=frame)
    assert expected.figures.mean == pytest.approx(plan.reached, rel=1e-12)
    assert expected.design.control_standard_error == 0.02


def test_a_row_without_its_frame_and_what_is_none_are_refused():
    frame, found = es.PlanFrame(), es.find_plans(0.06, CHOICES)
    design = es.FlightDesign(scale_number=8000, spacing=300, m_g_um=5)
    with pytest.raises(es.EinschaltError, match=r"without the frame .* frame=frame"):
        es.expect_precision(found.nearest)
    with pytest.raises(es.EinschaltError, match=r"^design is a row without spacing"):
        es.expect_precision(found.nearest.drop("spacing"), frame=frame)
    with pytest.raises(es.EinschaltError, match="frame beside a design that is a Fli"):
        es.expect_precision(design, frame=frame)
    with pytest.raises(es.EinschaltError, match="frame = 3; expected a PlanFrame"):
        es.expect_precision(found.nearest, frame=3)
    with pytest.raises(es.EinschaltError, match="design is a int"):
        es.expect_precision(3)


def test_a_target_that_no_layout_keeps_is_said():
    plan = es.plan_target(0.012, CHOICES)
    assert not plan.is_kept
    assert plan.reached > 0.012
    assert plan.verdict().lstrip().startswith("No plan is recommended")


def require_same_tables(one, other):
    """See that two expectations, propagated in two processes, are the same."""
    for name in ("points", "values"):
        pd.testing.assert_frame_equal(getattr(one, name), getattr(other, name))
    assert one.figures == other.figures


@pytest.mark.slow
def test_a_plan_comes_whole_out_of_a_pickle():
    plan = es.plan_target(0.05, CHOICES)
    back = pickle.loads(pickle.dumps(plan))
    assert isinstance(back, es.CheckedPlan)
    assert back.summary() == plan.summary()
    pd.testing.assert_frame_equal(back.search.plans, plan.search.plans)
    require_same_tables(back.expected, plan.expected)
    require_same_tables(back.next_best.expected, plan.next_best.expected)
    assert es.simulate_plan(back, seed=1).truth.equals(
        es.simulate_plan(plan, seed=1).truth
    )


@pytest.mark.slow
def test_a_plan_over_an_area_comes_whole_out_of_a_pickle(tmp_path):
    east, north = np.meshgrid(np.arange(-1e3, 8001, 500.0), np.arange(-1e3, 7001, 500))
    ground = np.column_stack([east.ravel(), north.ravel(), 0.02 * east.ravel()])
    np.savetxt(tmp_path / "ground.xyz", ground, "%.3f")
    choices = es.PlanChoices(scale_number=(8000,), spacing=(300,), m_g_um=(5,))
    plan = es.plan_area(
        *(0.06, shapely.box(0, 0, 7000, 6000), choices),
        ground_heights=tmp_path / "ground.xyz",
    )
    back = pickle.loads(pickle.dumps(plan))
    assert isinstance(back, es.AreaPlan)
    assert back.summary() == plan.summary()
    for name in ("flight_lines", "photographs", "control", "effort"):
        pd.testing.assert_frame_equal(
            getattr(back.flown, name), getattr(plan.flown, name)
        )
    require_same_tables(back.checked.expected, plan.checked.expected)
