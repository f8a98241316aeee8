"""A search is a grid: what lies between its values is tried, or told."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

import einschalt as es
from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.planning.area import recommended
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.choice import check
from einschalt.pipeline.planning.choice.check import check_plans
from einschalt.pipeline.planning.choice.finer_choices import (
    REFINED,
    finer_choices,
    plans_between,
    searched_with,
)
from einschalt.pipeline.planning.estimate.search import (
    PlanChoices,
    PlanFrame,
    find_plans,
)

CHOICES = PlanChoices(
    scale_number=(6800, 8100, 9500, 11200, 13300), spacing=(250,), m_g_um=(10,)
)
AREA = FlightArea(shapely.box(0.0, 0.0, 9000.0, 7000.0))


@pytest.fixture(scope="module")
def search():
    return find_plans(0.05, CHOICES, recommended.frame_over(AREA, PlanFrame()))


def _row(search, **values):
    plans = search.plans
    for name, value in values.items():
        plans = plans[np.isclose(plans[name], value)]
    return plans.iloc[0]


def test_values_lie_between_those_beside_the_plan(search):
    row = _row(search, scale_number=9500, high_scale_number=14250, n_settings=2)
    finer = finer_choices(search.plans, row)
    assert set(finer) == set(REFINED)
    assert len(finer["scale_number"]) == 7
    assert min(finer["scale_number"]) > 8100
    assert max(finer["scale_number"]) < 11200
    assert 9500 in finer["scale_number"]
    assert min(finer["high_over_low"]) > 1.25
    assert max(finer["high_over_low"]) < 1.875
    assert finer["n_settings"] == (2, 3)


def test_the_first_and_the_last_value_have_one_neighbour(search):
    row = _row(search, scale_number=6800, n_settings=1, high_scale_number=8500)
    finer = finer_choices(search.plans, row)
    assert min(finer["scale_number"]) == 6800
    assert min(finer["high_over_low"]) == 1.25
    assert "n_settings" not in finer


def test_what_was_one_value_or_lies_close_stays():
    choices = replace(CHOICES, scale_number=(9500, 9900), high_over_low=(1.5,))
    found = find_plans(0.05, choices)
    row = _row(found, n_settings=4, scale_number=9500)
    assert set(finer_choices(found.plans, row)) == {"n_settings"}


def test_plans_between_are_new_ones_of_one_kind(search):
    row = _row(search, scale_number=9500, high_scale_number=14250, n_settings=2)
    frame = recommended.frame_over(AREA, PlanFrame())
    more = plans_between(search, row, frame, list(REFINED))
    # seven scales and five ratios of four numbers of settings, but three known ones
    assert len(more) == 7 * 5 * 4 - 3
    assert not set(more.index) & set(search.plans.index)
    same = ["spacing", "n_coverages", "control_per_model", "m_g_um"]
    assert (more[same] == row[same].astype(float)).all(axis=None)
    together = searched_with(search, more)
    assert len(together.plans) == len(search.plans) + len(more)
    assert together.nearest["cost"] <= search.nearest["cost"]
    kept = together.feasible["cost"].to_numpy()
    assert (np.diff(kept) >= 0.0).all()


@pytest.mark.slow
def test_over_an_area_a_cheaper_plan_is_found_between(search):
    frame = recommended.frame_over(AREA, PlanFrame())
    plain = recommended.plan_area(AREA, search, frame)
    finer = recommended.plan_area(AREA, search, frame, refine=list(REFINED))
    assert plain.is_recommended
    assert finer.is_recommended
    assert finer.flown.cost < 0.99 * plain.flown.cost
    assert finer.checked.plan.name in finer.search.plans.index
    # what was given is all that is tried, and what lies between is said
    assert len(plain.search.plans) == len(search.plans)
    said = " ".join(plain.verdict().split())
    assert "between them it may be some per cent cheaper: --scale-number" in said
    for name, values in plain.checked.finer.items():
        assert f"{REFINED[name]} {','.join(f'{v:g}' for v in values)}" in said
    # the next best is another flight
    flights = ["scale_number", "high_scale_number"]
    two = [
        p.plan[flights].astype(float) for p in (finer.checked, finer.checked.next_best)
    ]
    assert abs(np.log(two[0] / two[1])).max() > 0.1


@pytest.mark.slow
def test_plans_lie_between_about_the_next_best_too(search, monkeypatch):
    """Which has gained more where the best was dear in what the other spares."""
    about = []

    def remembered(search, plan, *given):
        about.append(plan.name)
        return plans_between(search, plan, *given)

    monkeypatch.setattr(check, "plans_between", remembered)
    frame = recommended.frame_over(AREA, PlanFrame())

    def counted(plan):
        return plan["cost"]

    check_plans(search, frame, refine=list(REFINED))
    assert about[0] == check_plans(search, frame).plan.name
    about.clear()
    first = check_plans(search, frame, cost_on_layout=counted)
    checked = check_plans(search, frame, refine=list(REFINED), cost_on_layout=counted)
    assert about[:2] == [first.plan.name, first.next_best.plan.name]
    names = ["scale_number", "high_scale_number", "n_settings", "m_g_um", "spacing"]
    names += ["n_coverages", "control_per_model"]
    tried = checked.search.plans[names].astype(float).round(3)
    assert len(tried) > len(search.plans)
    assert not tried.duplicated().any()
    assert checked.search.plans.index.is_unique


@pytest.mark.slow
def test_the_values_that_are_told_make_a_cheaper_plan(search):
    frame = recommended.frame_over(AREA, PlanFrame())
    plain = recommended.plan_area(AREA, search, frame)
    told = replace(CHOICES, **plain.checked.finer)
    again = recommended.plan_area(AREA, find_plans(0.05, told, frame), frame)
    assert again.is_recommended
    assert again.flown.cost < plain.flown.cost


def test_what_cannot_be_refined_is_refused(search):
    with pytest.raises(SettingsError, match=r"refine = 'spacing' is unknown"):
        check_plans(search, PlanFrame(), refine=("spacing",))
    with pytest.raises(SettingsError, match=r"refine = 'scale' is unknown"):
        es.plan_area(0.05, AREA.shape, CHOICES, refine="scale")
