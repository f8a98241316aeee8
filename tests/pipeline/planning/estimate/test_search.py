"""From the wanted precision to the cheapest flight."""

import re
from dataclasses import fields, replace

import numpy as np
import pytest
import shapely

import einschalt as es
from einschalt.foundations.errors import GeometryError, SettingsError
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.recommended import search_over
from einschalt.pipeline.planning.choice.check import CheckedPlan, check_plans
from einschalt.pipeline.planning.choice.rows import design_of
from einschalt.pipeline.planning.choice.trials import LAYOUT, Trials
from einschalt.pipeline.planning.estimate.search import (
    PlanChoices,
    PlanFrame,
    find_plans,
)
from einschalt.pipeline.planning.estimate.text import missed_in_cm
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.pipeline.planning.flights.costs import PlanCosts
from einschalt.pipeline.planning.propagation.expected_precision import (
    expect_precision,
    propagate_design,
)

CHOICES = PlanChoices(
    scale_number=(5000, 7000, 9000, 12000),
    spacing=(200, 300),
    m_g_um=(10,),
    n_coverages=(1, 2, 3),
)


@pytest.fixture(scope="module")
def found():
    return find_plans(0.05, CHOICES)


def test_every_combination_is_a_plan_and_the_feasible_are_first(found):
    # those with too few points for control, or mostly control, are left out
    assert len(found.plans) <= 4 * 2 * 5 * 3 * 3 * 2
    names = ["scale_number", "spacing", "high_scale_number"]
    names += ["n_settings", "n_coverages", "control_per_model"]
    assert not found.plans[names].duplicated().any()
    per_point = found.plans["control_points"] * found.plans["spacing"] ** 2 / 1e6
    assert per_point.max() <= 0.5
    is_feasible = found.plans["is_feasible"].to_numpy()
    assert is_feasible[: is_feasible.sum()].all()
    assert (found.feasible["reached"] <= 0.05).all()
    assert (found.plans.loc[~is_feasible, "reached"] > 0.05).all()
    assert found.feasible["cost"].is_monotonic_increasing


def test_one_coverage_is_planned_only_where_it_is_asked_for():
    """It shows no gross error, and the command leaves it out as well."""
    usual = PlanChoices(scale_number=(9000,), spacing=(300,), m_g_um=(10,))
    assert set(find_plans(0.05, usual).plans["n_coverages"]) == {2, 3}


def test_efficient_plans_are_those_that_no_other_beats(found):
    plans = found.plans
    cost, error = plans["cost"].to_numpy(), plans["reached"].to_numpy()
    better = (cost <= cost[:, None]) & (error <= error[:, None])
    strictly = better & ((cost < cost[:, None]) | (error < error[:, None]))
    beaten = strictly.any(axis=1)
    assert not beaten[plans["is_efficient"].to_numpy()].any()
    # those left out are beaten, or alike another
    alike = plans[~plans["is_efficient"].to_numpy() & ~beaten]
    efficient = plans[plans["is_efficient"]]
    for row in alike.itertuples():
        assert (
            (efficient["cost"] == row.cost) & (efficient["reached"] == row.reached)
        ).any()


def test_work_is_counted_by_hand():
    plan = find_plans(
        0.5,
        PlanChoices(
            scale_number=(8000,),
            spacing=(250,),
            m_g_um=(5,),
            high_over_low=(2,),
            n_settings=(3,),
            n_coverages=(2,),
            control_per_model=(9,),
        ),
    ).plans.iloc[0]
    low = 2 / (0.092 * 8 * 0.161 * 8)
    assert plan["images"] == pytest.approx(low + low / 4)
    models_at_a_point = 0.6 / 0.4 / 0.7 * 2 * 2
    assert plan["settings"] == pytest.approx(16 * models_at_a_point * 3)
    assert plan["control_points"] == pytest.approx(4 * low / 4)
    cost = 30 * plan["images"] + 0.5 * plan["settings"] + 100 * plan["control_points"]
    assert plan["cost"] == pytest.approx(cost)


def test_paper_columns_are_those_of_the_planning_table(found):
    row = found.plans.iloc[7]
    m_g = row["m_g_um"] / np.sqrt(row["n_settings"])
    table = es.plan_precision(row["scale_number"], row["spacing"], row["m_0"], m_g)
    for name in ("M_centre", "M_edge", "n_points", "flying_height"):
        assert table[name].iloc[0] == pytest.approx(row[name])


def test_place_and_formula_are_asked_for():
    by_place = {
        where: find_plans(0.05, CHOICES, where=where) for where in ("centre", "edge")
    }
    single = {
        where: found.plans[found.plans["n_coverages"] == 1].sort_index()
        for where, found in by_place.items()
    }
    np.testing.assert_array_equal(
        single["edge"]["reached"], single["edge"]["expected_edge"]
    )
    np.testing.assert_array_equal(
        single["centre"]["reached"], single["centre"]["expected_centre"]
    )
    paper = find_plans(0.05, CHOICES, by="paper")
    assert len(paper.feasible) > len(find_plans(0.05, CHOICES).feasible)
    assert "too good" in paper.summary()


def test_infeasible_wishes_get_the_nearest_and_its_limit():
    found = find_plans(0.002, CHOICES)
    assert found.feasible.empty
    assert found.nearest["reached"] == found.plans["reached"].min()
    text = " ".join(found.summary().split())
    assert "no plan of 669 reaches 2.0 mm" in text
    assert "It is limited by the errors of control" in text
    assert "Not tried, and would help by the closed estimate: " in text
    assert len(found.beyond.efforts) > 2
    poor = replace(CHOICES, n_settings=(1,), m_g_um=(40,))
    frame = PlanFrame(high_over_low_m_g=0.1, control_standard_error=1e-3)
    assert find_plans(0.02, poor, frame).nearest["limited_by"] == "measuring"


ONE_LAYOUT = PlanChoices(
    scale_number=(16_000,), spacing=(300,), m_g_um=(10,), n_settings=(1,)
)


def test_what_reaches_a_target_has_not_been_tried_yet():
    found = find_plans(0.04, ONE_LAYOUT)
    assert found.feasible.empty
    said = " ".join(found.verdict.split())
    (effort,) = [e for e in found.beyond.efforts if e.reached <= found.target]
    assert (effort.name, effort.value) == ("n_settings", 4)
    reaching = "Not tried, and would reach it by the closed estimate: 4 pointings each"
    assert f"{reaching} (--n-settings): 3.8 cm." in said
    tried = find_plans(0.04, replace(ONE_LAYOUT, n_settings=(1, 4)))
    assert tried.nearest["reached"] == pytest.approx(effort.reached)
    assert tried.beyond is None  # some plans reach it


@pytest.mark.parametrize(
    ("changes", "absent"),
    [
        ({"n_settings": (1, 16)}, "n_settings"),
        ({"n_coverages": (2, 4)}, "n_coverages"),
        ({"high_over_low": (1.05, 1.5)}, "high_over_low"),
        ({"control_per_model": (5, 9)}, "control_per_model"),
    ],
)
def test_choices_that_were_tried_are_not_advised(changes, absent):
    found = find_plans(0.002, replace(ONE_LAYOUT, **changes))
    names = {effort.name for effort in found.beyond.efforts}
    assert names
    assert absent not in names
    if absent != "n_settings":  # of what was not tried, more settings help here
        assert "n_settings" in names


@pytest.mark.parametrize("name", ["n_settings", "scale_number", "n_coverages"])
def test_efforts_come_to_what_a_search_with_them_finds(name):
    found = find_plans(0.002, replace(ONE_LAYOUT, n_coverages=(2,)))
    (effort,) = [one for one in found.beyond.efforts if one.name == name]
    changes = {"n_coverages": (2,), name: (effort.value,)}
    again = find_plans(0.002, replace(ONE_LAYOUT, **changes))
    assert again.nearest["reached"] == pytest.approx(effort.reached)


def test_efforts_that_exclude_each_other_are_not_added_up():
    """Lower flights with denser control would survey most of the points."""
    found = find_plans(0.002, replace(ONE_LAYOUT, scale_number=(8000,)))
    assert len(found.beyond.efforts) > 1
    together = found.beyond.together
    said = " ".join(found.verdict.split())
    assert np.isinf(together)
    assert "all of them together: " not in said
    assert "–" not in said


def test_efforts_keep_the_limit_of_height():
    choices = replace(ONE_LAYOUT, scale_number=(12_000,), high_over_low=(1.25,))

    def highest_with(max_height):
        found = find_plans(0.002, choices, PlanFrame(max_height=max_height))
        efforts = {one.name: one.value for one in found.beyond.efforts}
        flown = {"scale_number": 12_000, "high_over_low": 1.25}
        given = flown | {n: v for n, v in efforts.items() if n in flown}
        return efforts, 0.152 * given["scale_number"] * given["high_over_low"]

    efforts, height = highest_with(0.152 * 1.25 * 12_000 + 1.0)
    assert efforts
    assert height <= 0.152 * 1.25 * 12_000 + 1.0


@pytest.mark.parametrize("extent", [None, (900e3, 800e3, 720e9)])
def test_scales_that_no_layout_has_are_not_searched(extent):
    """They were estimated, and each layout refused."""
    frame = PlanFrame(extent=extent)
    few = PlanChoices(scale_number=(190_000,), spacing=(500,), m_g_um=(10,))
    with pytest.raises(GeometryError, match=r"from 190000 to 570000 .*100 to 200000"):
        find_plans(1.0, few, frame)
    found = find_plans(1.0, replace(few, scale_number=(90_000, 190_000)), frame)
    assert set(found.plans["scale_number"]) == {90_000.0}
    assert found.plans["high_scale_number"].max() <= 200_000


def test_scales_that_no_layout_has_are_not_advised():
    found = find_plans(1e-4, replace(ONE_LAYOUT, scale_number=(110,), spacing=(1,)))
    advised = [one.value for one in found.beyond.efforts if one.name == "scale_number"]
    assert all(value >= 100.0 for value in advised)
    found = find_plans(1e-4, replace(ONE_LAYOUT, scale_number=(900,), spacing=(15,)))
    advised = [one.value for one in found.beyond.efforts if one.name == "scale_number"]
    assert len(advised) == 1
    assert advised[0] >= 100.0


def test_where_nothing_helps_the_advice_says_so():
    choices = replace(
        ONE_LAYOUT,
        scale_number=(100,),
        spacing=(0.6, 2.0),
        m_g_um=(100,),
        high_over_low=(1.05,),
        n_settings=(100,),
        n_coverages=(4,),
    )
    frame = PlanFrame(control_standard_error=1e-9)
    found = find_plans(1e-4, choices, frame)
    assert found.feasible.empty
    assert found.beyond.efforts == ()
    assert "Nothing that was not tried would help by 3 % or more" in found.verdict


def test_costs_decide_the_ranking():
    dear = PlanFrame(costs=PlanCosts(control_point=1e5))
    cheap = find_plans(0.05, CHOICES, dear)
    usual = find_plans(0.05, CHOICES)
    assert cheap.nearest["control_points"] < usual.nearest["control_points"]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"scale_number": (-1,)}, "scale_number = -1"),
        ({"high_over_low": (1.0,)}, r"high_over_low = 1\.0"),
        ({"n_settings": (1.5,)}, r"n_settings = 1\.5"),
        ({"n_coverages": (0,)}, "n_coverages = 0"),
        ({"control_per_model": (7,)}, "control_per_model = 7; expected 5 or 9"),
        ({"n_settings": ()}, "n_settings is empty"),
    ],
)
def test_nonsense_is_refused(change, says):
    with pytest.raises(SettingsError, match=says):
        find_plans(0.05, replace(CHOICES, **change))


def test_one_number_is_a_choice_of_one():
    alone = PlanChoices(scale_number=8000, spacing=300, m_g_um=5, n_coverages=2)
    listed = PlanChoices(
        scale_number=(8000,), spacing=(300,), m_g_um=(5,), n_coverages=(2,)
    )
    for target in (0.05, 0.001):  # reached, and beyond all choices
        found = find_plans(target, alone)
        assert found.summary() == find_plans(target, listed).summary()


@pytest.mark.parametrize(
    ("given", "says"),
    [(({},), "choices = a dict"), ((CHOICES, {}), "frame = a dict")],
)
def test_what_is_no_choices_and_no_frame_is_refused(given, says):
    with pytest.raises(SettingsError, match=says):
        find_plans(0.05, *given)


def test_prices_of_another_kind_are_refused_with_the_kind_that_is_needed():
    with pytest.raises(SettingsError, match=r"costs = a dict.*Write costs="):
        PlanFrame(costs={"image": 12})
    assert PlanFrame(costs=replace(PlanFrame().costs, image=12)).costs.image == 12


def test_coverages_as_decimal_numbers_are_advised_beyond():
    found = find_plans(0.001, replace(CHOICES, n_coverages=(2.0,)))
    assert found.feasible.empty
    assert found.beyond is not None


def test_other_nonsense_is_refused():
    with pytest.raises(SettingsError, match=r"5 cm are 0\.05"):
        find_plans(50, CHOICES)
    with pytest.raises(SettingsError, match=r"where = 'egde' is unknown.*edge"):
        find_plans(0.05, CHOICES, where="egde")
    with pytest.raises(SettingsError, match="image = -1"):
        PlanCosts(image=-1)
    with pytest.raises(SettingsError, match="all prices are 0"):
        PlanCosts(image=0, model=0, setting=0, control_point=0)
    with pytest.raises(GeometryError, match="points lie in a model"):
        find_plans(0.05, replace(CHOICES, spacing=(2000,)))


@pytest.mark.parametrize("n_coverages", [1, 2])
def test_the_plan_that_is_proposed_keeps_the_target(n_coverages):
    found = find_plans(0.065, replace(CHOICES, n_coverages=(n_coverages,)))
    checked = check_plans(found, PlanFrame())
    assert checked.is_kept
    assert checked.plan["n_coverages"] == n_coverages
    assert checked.reached <= 0.065
    assert "Checked by propagation on a layout" in " ".join(checked.summary().split())
    # what it reaches is the error of the new points of its layout; of one coverage,
    # that of a single value where it is worst, since no mean hides a gross error
    expected = expect_precision(design_of(checked.plan, PlanFrame()))
    new = expected.points[expected.points["role"] == "new"]
    rms = float(np.sqrt((new["standard_error_total"] ** 2).mean()))
    if n_coverages == 1:
        at = ("single_centre", "single_edge", "single_corner")
        assert checked.reached == max(getattr(expected.figures, one) for one in at)
        assert checked.reached > rms
    else:
        assert checked.reached == pytest.approx(rms)


def test_plans_that_do_not_keep_it_are_named():
    # the closed estimate promises 4.7 cm, the layout has 4.99
    choices = PlanChoices(
        scale_number=(9600,),
        spacing=(300,),
        m_g_um=(10,),
        high_over_low=(1.25, 1.5),
        n_settings=(2,),
        n_coverages=(2,),
        control_per_model=(5,),
    )
    found = find_plans(0.0495, choices)
    checked = check_plans(found, PlanFrame(), most=1)
    assert not checked.is_kept
    assert "That is more than 4.95 cm" in " ".join(checked.summary().split())
    checked = check_plans(found, PlanFrame())
    assert checked.is_kept
    (dropped,) = checked.dropped
    assert dropped.startswith("low flight 1:9600, high flight 1:14400")
    assert (
        "Misses the target: low flight 1:9600, high flight 1:14400" in checked.summary()
    )


def test_a_miss_shows_by_how_much():
    choices = PlanChoices(
        scale_number=(9600,),
        spacing=(300,),
        m_g_um=(10,),
        high_over_low=(1.5,),
        n_settings=(2,),
        n_coverages=(2,),
        control_per_model=(5,),
    )
    reached = check_plans(find_plans(0.06, choices), PlanFrame()).reached
    target = reached * (1.0 - 2e-5)
    checked = check_plans(find_plans(target, choices), PlanFrame())
    said = " ".join(checked.verdict().split())
    shown = re.search(r"on a layout: (\S+) cm .* That is more than (\S+) cm", said)
    missed, wanted = map(float, shown.groups())
    assert missed > wanted
    assert missed_in_cm(reached, target) == f"{shown[1]} cm"
    # the closed estimate as well
    search = find_plans(0.06, choices)
    near = search.nearest["reached"] * (1.0 - 2e-5)
    said = find_plans(near, choices).verdict
    assert missed_in_cm(search.nearest["reached"], near) in said


@pytest.mark.parametrize("where", ["centre", "edge", "everywhere"])
def test_with_one_coverage_the_place_of_the_error_is_told(where):
    choices = replace(CHOICES, n_coverages=(1,), scale_number=(8000,), spacing=(300,))
    checked = check_plans(find_plans(0.07, choices, where=where), PlanFrame(), most=3)
    figures = checked.expected.figures
    place = "corner" if where == "everywhere" else where
    assert checked.place == place
    assert checked.reached == getattr(figures, f"single_{place}")
    if where == "everywhere":
        places = ("centre", "edge", "corner")
        assert checked.reached == max(getattr(figures, f"single_{p}") for p in places)
        assert checked.plan["reached"] == checked.plan["expected_corner"]
    said = " ".join(checked.summary().split())
    where_said = "in the corners" if place == "corner" else f"at the {place}"
    assert f" cm ({where_said} of models) with low flight" in said
    assert "(total, one coverage, mean of the models of each point)" in said
    several = check_plans(find_plans(0.07, CHOICES, where=where), PlanFrame(), most=1)
    assert several.place is None
    is_told = f"--where {where} counts with one" in " ".join(several.verdict().split())
    assert is_told == (where != "everywhere")
    assert "of models) with" not in " ".join(several.verdict().split())


def test_no_cheaper_plan_is_passed_over_because_another_one_misses():
    """The first misses by 6 %; the second keeps the target, at the same cost."""
    choices = PlanChoices(
        scale_number=(5800, 6800, 8100, 9500, 11200, 13300),
        spacing=(250,),
        m_g_um=(10,),
        n_coverages=(2, 3),
    )
    found = find_plans(0.05, choices)
    checked = check_plans(found, PlanFrame())
    assert checked.is_kept
    costs = found.feasible["cost"]
    for _, plan in found.feasible[costs < checked.plan["cost"]].iterrows():
        reached = expect_precision(design_of(plan, PlanFrame())).figures.mean
        assert reached > 0.05
    assert 1 <= (costs < checked.plan["cost"]).sum() < 5


def test_a_plan_that_the_estimate_takes_for_too_bad_is_found():
    """The estimate is too cautious with many control points in three coverages."""
    preset = CAMERAS["ultracam_xp"]
    frame = PlanFrame(
        kind="helmert",
        image_format=preset.image_format,
        principal_distance=preset.principal_distance,
        forward_overlap=preset.forward_overlap,
        side_overlap=preset.side_overlap,
    )
    choices = PlanChoices(
        scale_number=(28_000, 34_000, 40_000, 46_000),
        spacing=(400,),
        m_g_um=preset.m_g_um[:1],
    )
    target = 0.035
    found = find_plans(target, choices, frame)
    checked = check_plans(found, frame)
    assert checked.is_kept
    promised = found.feasible
    promised = promised[promised["n_coverages"] > 1]
    assert checked.plan["cost"] < 0.98 * promised["cost"].min()
    assert checked.next_best.is_kept
    assert checked.next_best.plan["cost"] >= checked.plan["cost"]


def test_settings_more_of_a_layout_are_known_from_it(found):
    trials = Trials(found.plans, 0.05, patience=3, enough=2)
    plan = found.plans[found.plans["n_settings"] == 1].iloc[0]
    design = design_of(plan, PlanFrame())
    trials.learn(CheckedPlan(plan, propagate_design(design), 0.06, 0.05, found))
    same = found.plans[list(LAYOUT)].eq(plan[list(LAYOUT)]).all(axis=1)
    same &= found.plans["m_g_um"] == plan["m_g_um"]
    (other,) = np.flatnonzero(same & (found.plans["n_settings"] == 4))
    better = propagate_design(design_of(found.plans.iloc[other], PlanFrame())).mean
    known = trials.likely()[other] / 0.06 * propagate_design(design).mean
    assert known == pytest.approx(better, rel=0.01)
    # others are expected to be as much worse, the more the nearer they are
    plain = found.plans["reached"].to_numpy()
    ratio = trials.likely() / plain
    assert trials.missed[0] > 1.0
    assert (ratio[~same] > 1.0).all()


def test_of_infeasible_plans_the_nearest_that_can_be_laid_out_is_checked():
    found = find_plans(0.002, replace(CHOICES, spacing=(300,)))
    checked = check_plans(found, PlanFrame(control_standard_error=0.03))
    assert not checked.is_kept
    nearest = found.plans.sort_values("reached").head(6)
    assert checked.plan["reached"] in nearest["reached"].to_numpy()


@pytest.mark.parametrize(
    "change", [{"control_standard_error": -0.03}, {"high_over_low_m_g": 0.0}]
)
def test_nonsense_of_what_is_at_hand_is_refused(change):
    (name,) = change
    # no name of a class before it
    with pytest.raises(SettingsError, match=f"^{name} = "):
        PlanFrame(**change)


@pytest.mark.parametrize("overlap", [{"forward_overlap": 0.4}, {"side_overlap": 0.95}])
def test_overlaps_that_no_layout_has_are_refused_by_every_search(overlap):
    ((name, value),) = overlap.items()
    with pytest.raises(SettingsError, match=f"{name} = {value}; expected 0"):
        find_plans(0.05, CHOICES, PlanFrame(**overlap))
    area = FlightArea(shapely.box(0.0, 0.0, 3000.0, 3000.0))
    with pytest.raises(SettingsError, match=f"{name} = {value}; expected 0"):
        search_over(0.05, area, CHOICES, PlanFrame(**overlap))


def test_every_price_counts(found):
    """A price that no formula knows would be taken, and change nothing."""
    usual = found.plans["cost"]
    for field in fields(PlanCosts):
        price = getattr(PlanCosts(), field.name)
        dearer = PlanFrame(costs=PlanCosts(**{field.name: 2.0 * price}))
        changed = find_plans(0.05, CHOICES, dearer).plans["cost"]
        assert (changed.sort_index() > usual.sort_index()).all(), field.name


@pytest.mark.parametrize("camera", [*CAMERAS.values()], ids=[*CAMERAS])
def test_a_pixel_on_the_ground_is_that_of_the_image_at_its_scale(camera):
    frame = PlanFrame(
        image_format=camera.image_format,
        principal_distance=camera.principal_distance,
        sampled_um=camera.sampled_um,
    )
    choices = PlanChoices(
        scale_number=camera.scale_numbers, spacing=camera.spacings[:1], m_g_um=(2.0,)
    )
    plans = find_plans(0.5, choices, frame).plans
    for name in ("", "high_"):
        expected = 1e-6 * camera.sampled_um * plans[f"{name}scale_number"]
        np.testing.assert_allclose(plans[f"{name}gsd"], expected)
