"""Items that have a price are the same wherever plans are priced."""

import inspect
from dataclasses import fields

import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.interfaces.cli import plan_layouts, typed_options
from einschalt.interfaces.cli.plan import plan as plan_command
from einschalt.interfaces.cli.plan_values import costs_of
from einschalt.interfaces.local_page import plan_pages
from einschalt.pipeline.planning.area.recommended import ITEM_TEXT
from einschalt.pipeline.planning.estimate.search import (
    PlanChoices,
    PlanFrame,
    find_plans,
)
from einschalt.pipeline.planning.flights.costs import (
    COLUMN_OF_ITEM,
    PlanCosts,
    cost_of,
)

ITEMS = [field.name for field in fields(PlanCosts)]


def test_all_prices_are_of_items_that_plans_count():
    for named in (
        COLUMN_OF_ITEM,
        ITEM_TEXT,
        plan_layouts.PRICES,
        typed_options.PRICES,
    ):
        assert list(named) == ITEMS
    # whoever plans on the local page sees what makes the cost
    assert set(COLUMN_OF_ITEM.values()) <= set(plan_pages.WORK)


def test_usual_prices_of_the_command_are_those_of_python():
    usual = inspect.signature(plan_command).parameters["costs"].default
    assert costs_of(usual) == PlanCosts()


@pytest.mark.parametrize("item", ITEMS)
def test_every_price_counts(item):
    amounts = dict.fromkeys(ITEMS, 3.0)
    free = dict.fromkeys(ITEMS, 0.0)
    assert cost_of(amounts, PlanCosts(**free | {item: 7.0})) == 21.0
    choices = PlanChoices(scale_number=(8000,), spacing=(250,), m_g_um=(10,))
    frame = PlanFrame(costs=PlanCosts(**free | {item: 7.0}))
    plans = find_plans(0.05, choices, frame).plans
    assert plans["cost"].tolist() == (7.0 * plans[COLUMN_OF_ITEM[item]]).tolist()


@pytest.mark.parametrize(
    "extent",
    [
        (1000.0, 0.0, 1000.0),
        (1.0, 2.0),
        "abc",
        (1000.0, float("nan"), 10.0),
        (-5.0, 3.0, 2.0),
        (100.0, 100.0, 10_001.0),
    ],
)
def test_an_extent_is_that_of_an_area(extent):
    with pytest.raises(SettingsError, match=r"extent = "):
        PlanFrame(extent=extent)
    assert PlanFrame(extent=(100.0, 100.0, 1e4)).extent == (100.0, 100.0, 1e4)
