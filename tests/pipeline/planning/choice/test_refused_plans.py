"""Plans that cannot be laid out: the next ones are tried, and the answer stands."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import shapely

from einschalt.foundations.errors import GeometryError, SettingsError
from einschalt.pipeline.planning.area import recommended, tried_layouts
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.choice.check import MOST_REFUSED, check_plans
from einschalt.pipeline.planning.choice.rows import design_of
from einschalt.pipeline.planning.choice.trials import LAYOUT
from einschalt.pipeline.planning.estimate.possible_layouts import (
    MOST_MODELS,
    models_over,
)
from einschalt.pipeline.planning.estimate.search import (
    PlanChoices,
    PlanFrame,
    find_plans,
)
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.pipeline.planning.flights.costs import PlanCosts
from einschalt.pipeline.planning.flights.points_in_models import downwards
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights
from einschalt.pipeline.planning.propagation.expected_precision import propagate_design

CHOICES = PlanChoices(
    scale_number=(5800, 6800, 8100, 9500, 11200),
    spacing=(250,),
    m_g_um=(10,),
    n_coverages=(2, 3),
)
TARGET = 0.05
FRAME = PlanFrame()


@pytest.fixture(scope="module")
def found():
    return find_plans(TARGET, CHOICES)


# what a design comes to does not change, and these tests ask for most of them often
propagated_once = cache(propagate_design)


def propagated(plan):
    return propagated_once(design_of(plan, FRAME))


def layout_of(plan):
    return tuple(plan[list(LAYOUT)])


@pytest.mark.slow
def test_refused_plans_do_not_use_up_those_that_are_tried(found):
    cheapest = found.feasible[list(LAYOUT)].drop_duplicates().head(12)
    bad, judged = set(map(tuple, cheapest.to_numpy())), []

    def judge(plan):
        judged.append(layout_of(plan))
        if layout_of(plan) in bad:
            raise GeometryError("the ground is too high")
        return propagated(plan)

    checked = check_plans(found, FRAME, judge=judge)
    assert checked.is_kept
    # no settings more are tried of a layout that was refused
    refused = [layout for layout in judged if layout in bad]
    assert len(refused) == len(set(refused)) == len(bad)
    said = " ".join(checked.verdict().split())
    # the reason is told once, and not as if their precision missed the target
    assert said.count("the ground is too high") == 1
    assert f"Not recommended: {len(bad)} plans such as low flight 1:" in said
    assert said.count("Misses the target") == min(3, len(checked.missed))
    assert len(checked.refused) == len(bad)
    assert len(checked.dropped) == len(checked.missed) + len(bad)


@pytest.mark.slow
def test_many_that_miss_are_counted(found):
    checked = check_plans(found, FRAME, judge=_too_bad, most=12, patience=12)
    said = " ".join(checked.verdict().split())
    assert len(checked.missed) > 5
    costs = [float(cost) for cost in re.findall(r"estimated cost (\S+) per km²", said)]
    assert len(costs) == said.count("Misses the target: ") == 3
    cheapest = sorted(float(plan["cost"]) for plan, _ in checked.missed)[:3]
    assert costs == pytest.approx(cheapest, rel=5e-3)
    assert f"{len(checked.missed) - 3} more plans miss the target." in said


def test_plans_of_too_many_models_are_told_once_and_not_tried():
    area = FlightArea(shapely.box(0.0, 0.0, 121_000.0, 100_000.0))
    choices = replace(CHOICES, scale_number=(9000, 11_000, 14_000), spacing=(400,))
    found, frame = recommended.search_over(0.06, area, choices, FRAME)
    fitting, (note,) = recommended._that_fit(area, found, frame)
    n_models = models_over(area.shape.area, found.model, *LARGEST.T)
    largest = area.square_km * MOST_MODELS / n_models.max()
    assert set(fitting.plans["scale_number"]) == {11_000, 14_000}
    three = fitting.plans[fitting.plans["n_coverages"] == 3]
    assert set(three["scale_number"]) == {14_000}
    assert note.startswith(f"{len(found.plans) - len(fitting.plans)} of ")
    assert f"parts of at most {downwards(largest)} km²" in note
    assert recommended._that_fit(_cut(area, largest), found, frame)[1] == []


LARGEST = np.array([[9000.0, 3.0]])


def _cut(area, square_km):
    side = 0.999 * 1e3 * np.sqrt(square_km)
    return FlightArea(shapely.box(0.0, 0.0, side, side))


def test_an_area_too_large_for_all_plans_says_how_large_its_parts_may_be():
    area = FlightArea(shapely.box(0.0, 0.0, 300_000.0, 250_000.0))
    found, frame = recommended.search_over(0.06, area, CHOICES, FRAME)
    with pytest.raises(GeometryError, match="models of the low flight at 1:11200") as e:
        recommended.plan_area(area, found, frame)
    square_km = float(re.search(r"which cover (\S+) km²", e.value.expected)[1])
    n_parts = int(re.search(r"into (\d+) parts or more", e.value.remedy)[1])
    assert (n_parts - 1) * square_km < area.square_km <= 1.1 * n_parts * square_km
    fitting, _ = recommended._that_fit(_cut(area, square_km), found, frame)
    assert set(fitting.plans["scale_number"]) == {11_200}


UAV = CAMERAS["uav_one_inch"]
OF_UAV = PlanFrame(
    image_format=UAV.image_format,
    principal_distance=UAV.principal_distance,
    forward_overlap=0.8,
    side_overlap=0.6,
)
LITTLE_LEFT = PlanChoices(
    scale_number=(10_900,),
    spacing=(25,),
    m_g_um=(1,),
    high_over_low=(1.25,),
    n_settings=(1,),
    n_coverages=(2,),
    control_per_model=(9,),
)


@pytest.mark.parametrize("is_part", [False, True])
def test_a_plan_of_control_alone_is_not_recommended(is_part, monkeypatch):
    """The estimate has 49.8 % of the points as control, the layout 55 %."""
    if is_part:
        monkeypatch.setattr(tried_layouts, "FEWEST_IN_A_MODEL", 1e9)
    area = FlightArea(shapely.box(0.0, 0.0, 600.0, 500.0))
    found, frame = recommended.search_over(0.05, area, LITTLE_LEFT, OF_UAV)
    with pytest.raises(GeometryError, match="are 55 % of all points") as caught:
        recommended.plan_area(area, found, frame)
    assert "less than 50 %" in caught.value.expected
    # the models cost nothing: the plan of more control would be the cheapest
    choices = replace(LITTLE_LEFT, high_over_low=(1.25, 2.5))
    cheap = replace(OF_UAV, costs=PlanCosts(image=0, model=0, control_point=0))
    found, frame = recommended.search_over(0.05, area, choices, cheap)
    plan = recommended.plan_area(area, found, frame)
    assert plan.is_recommended
    assert plan.checked.plan["high_scale_number"] == 2.5 * 10_900
    assert len(plan.layout.control) < 0.5 * area.shape.area / 25.0**2


@pytest.mark.parametrize(
    ("max_height", "is_advised"),
    [(None, True), (120, False), (130, False), (133, True)],
)
def test_larger_scales_are_advised_as_far_as_they_may_be_flown(max_height, is_advised):
    """The high flight is 119.9 m above ground; 132.6 m are needed."""
    area = FlightArea(shapely.box(0.0, 0.0, 600.0, 500.0))
    below = replace(OF_UAV, max_height=max_height)
    found, frame = recommended.search_over(0.05, area, LITTLE_LEFT, below)
    with pytest.raises(GeometryError, match="are 55 % of all points") as caught:
        recommended.plan_area(area, found, frame)
    remedy = caught.value.remedy
    assert remedy.startswith("Give spacings of at most 22 m")
    assert ("larger scale numbers" in remedy) == is_advised
    assert ("cannot be larger below --max-height" in remedy) != is_advised


def test_refusals_come_to_an_end(found):
    judged = []

    def judge(plan):
        judged.append(layout_of(plan))
        raise GeometryError(f"refused {len(judged)}")

    with pytest.raises(GeometryError, match=r"refused \d+"):
        check_plans(found, FRAME, judge=judge)
    assert 20 < len(judged) <= MOST_REFUSED
    assert len(set(judged)) == len(judged)


@pytest.mark.parametrize("target", [TARGET, 0.001])
def test_a_plan_whose_costs_cannot_be_told_is_dropped(target):
    found = find_plans(target, CHOICES)
    usual = check_plans(found, FRAME, judge=propagated)

    def cost(plan):
        if layout_of(plan) == layout_of(usual.plan):
            raise GeometryError("the ground is too high")
        return plan["cost"]

    checked = check_plans(found, FRAME, judge=propagated, cost=cost)
    assert checked.is_kept == usual.is_kept == (target == TARGET)
    assert layout_of(checked.plan) != layout_of(usual.plan)
    assert any("the ground is too high" in text for text in checked.dropped)


def test_of_plans_that_miss_the_nearest_whose_costs_can_be_told_is_given():
    found = find_plans(0.049, replace(CHOICES, scale_number=(11_200,)))
    usual = check_plans(found, FRAME, most=2, judge=_too_bad)
    assert not usual.is_kept

    def cost(plan):
        if plan.name == usual.plan.name:
            raise GeometryError("the ground is too high")
        return plan["cost"]

    checked = check_plans(found, FRAME, most=2, judge=_too_bad, cost=cost)
    assert not checked.is_kept
    assert checked.plan.name != usual.plan.name
    with pytest.raises(GeometryError, match="never"):
        check_plans(found, FRAME, most=2, judge=_too_bad, cost=_never)


def _too_bad(plan):
    """Whatever it is, it is measured so badly that it misses."""
    return propagated_once(replace(design_of(plan, FRAME), m_g_um=60.0))


def _never(plan):
    raise GeometryError("never")


@pytest.fixture(scope="module")
def hill():
    """A hill of 400 m in an area of 11.8 x 8.1 km."""
    area = FlightArea(shapely.box(0.0, 0.0, 11_800.0, 8_100.0))
    axes = np.arange(-1500.0, 13_400.0, 100.0), np.arange(-1200.0, 9400.0, 100.0)
    plane = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    away = np.hypot(*(plane - [5900.0, 4050.0]).T)
    height = 400.0 + 400.0 * np.exp(-((away / 1000.0) ** 2) / 2.0)
    return area, GroundHeights(plane, height, "hill.xyz").over(area)


@pytest.mark.slow
@pytest.mark.parametrize("is_part", [False, True])
def test_a_plan_is_found_over_a_hill(is_part, hill, monkeypatch):
    """Whether precisions are propagated on the whole area or on a part of it."""
    if is_part:
        monkeypatch.setattr(tried_layouts, "FEWEST_IN_A_MODEL", 1e9)
    area, heights = hill
    scales = (11_000, 13_000) if is_part else tuple(range(5000, 15_001, 1000))
    choices = PlanChoices(
        scale_number=scales, spacing=(250,), m_g_um=(10,), n_coverages=(2, 3)
    )
    found, frame = recommended.search_over(TARGET, area, choices, FRAME)
    plan = recommended.plan_area(area, found, frame, heights=heights)
    assert plan.is_recommended
    assert any("the ground rises" in text for text in plan.checked.dropped)
    assert any("overlaps left on the highest" in text for text in plan.notes)


@pytest.mark.parametrize("n_common", [7, 13])
def test_the_commonest_reason_is_told_and_how_common_it_is(n_common, found):
    judged = []

    def judge(plan):
        judged.append(layout_of(plan))
        is_common = len(judged) <= n_common
        if is_common:
            raise GeometryError(f"rise {len(judged)}", expected="overlaps")
        raise GeometryError(f"{len(judged)} % are control", expected="less than 50 %")

    with pytest.raises(GeometryError) as caught:
        check_plans(found, FRAME, judge=judge)
    n_all = len(judged)
    n, of = max((n_common, "rise 1"), (n_all - n_common, f"{n_common + 1} % are"))
    said = f"{n} of {n_all} layouts that were tried are refused alike: {of}"
    assert str(caught.value).startswith(said)


def _slope(area, rise):
    axes = (np.arange(-500.0, 4600.0, 100.0),) * 2
    plane = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    return GroundHeights(plane, 400.0 + rise * plane[:, 1], "slope.xyz").over(area)


SLOPING = FlightArea(shapely.box(0.0, 0.0, 4000.0, 3500.0))
OF_SLOPE = PlanChoices(
    scale_number=(7000, 9000),
    spacing=(250,),
    m_g_um=(10,),
    high_over_low=(1.5,),
    n_coverages=(2,),
    control_per_model=(5,),
)


@pytest.mark.slow
@pytest.mark.parametrize("max_height", [None, 2100.0])
def test_numbers_advised_on_high_ground_give_a_plan(max_height):
    """Overlaps and scale numbers, with the other options as given."""
    frame = PlanFrame(max_height=max_height)
    heights = _slope(SLOPING, 0.45)
    found, over = recommended.search_over(0.06, SLOPING, OF_SLOPE, frame)
    with pytest.raises(GeometryError, match="the ground rises") as caught:
        recommended.plan_area(SLOPING, found, over, heights=heights, follows=False)
    said = str(caught.value)
    overlaps = re.search(r"--forward-overlap (\S+) --side-overlap ([\d.]+)", said)
    larger = re.search(r"--scale-number (\d+)", said)
    assert larger is None or max_height is None
    names = ("forward_overlap", "side_overlap")
    overlaps = dict(zip(names, map(float, overlaps.groups()), strict=True))
    tried = [(OF_SLOPE, replace(frame, **overlaps))]
    if larger:
        tried.append((replace(OF_SLOPE, scale_number=(float(larger[1]),)), frame))
    for choices, given in tried:
        found, over = recommended.search_over(0.06, SLOPING, choices, given)
        ground = {"heights": heights, "follows": False}
        assert recommended.plan_area(SLOPING, found, over, **ground).is_recommended


def test_ground_that_reaches_the_cameras_leaves_no_overlap():
    heights = _slope(SLOPING, 2.0)
    found, over = recommended.search_over(0.06, SLOPING, OF_SLOPE, FRAME)
    with pytest.raises(GeometryError) as caught:
        recommended.plan_area(SLOPING, found, over, heights=heights)
    assert "overlaps of 0 and 0 % are left" in str(caught.value)
    assert "Plan parts of the area by themselves" in str(caught.value)


def test_overlaps_that_leave_gaps_are_no_plan_that_was_tried():
    frame = replace(PlanFrame(), forward_overlap=0.51)
    found = find_plans(0.05, CHOICES, frame)
    with pytest.raises(SettingsError, match=r"^forward_overlap = 0.51; expected 0.522"):
        check_plans(found, frame)
