"""Plans that are tried beside each other."""

import numpy as np
import pytest

from einschalt.foundations import batches
from einschalt.pipeline.planning.choice.check import check_plans
from einschalt.pipeline.planning.choice.rows import design_of
from einschalt.pipeline.planning.choice.trials import LAYOUT, Trials
from einschalt.pipeline.planning.estimate.search import (
    PlanChoices,
    PlanFrame,
    find_plans,
)
from einschalt.pipeline.planning.propagation.expected_precision import propagate_design

FRAME = PlanFrame()
CHOICES = PlanChoices(
    scale_number=(6800, 8100, 9500, 11200), spacing=(250,), m_g_um=(10,)
)


@pytest.fixture(scope="module")
def found():
    return find_plans(0.05, CHOICES, FRAME)


def _trials(found):
    return Trials(found.plans, found.target, patience=3, enough=2)


def test_the_next_ones_are_those_that_come_where_all_turn_out_as_expected(found):
    one_by_one, together = _trials(found), _trials(found)
    first, second = together.next_ones(2)
    assert one_by_one.next().name == first.name
    one_by_one._expect(first)
    assert one_by_one.next().name == second.name
    assert tuple(first[list(LAYOUT)]) != tuple(second[list(LAYOUT)])


def test_expectations_are_forgotten(found):
    trials = _trials(found)
    likely, n_left = trials.likely(), trials.is_left.sum()
    plans = trials.next_ones(2)
    np.testing.assert_array_equal(trials.likely(), likely)
    assert trials.kept_costs == trials.missed == []
    assert trials.errors.shown == []
    # other settings on their layouts may still be tried
    assert trials.is_left.sum() == n_left - 2
    assert not trials.is_left[[plan.name for plan in plans]].any()


def test_no_more_than_there_are(found):
    few = Trials(found.plans.head(1), found.target, patience=3, enough=2)
    assert len(few.next_ones(2)) == 1
    assert few.next_ones(2) == []


@pytest.mark.slow
def test_the_plan_does_not_depend_on_the_cores(found, monkeypatch):
    told = []
    for n_cores in (1, 2, 5):
        monkeypatch.setattr(batches, "_n_own_cores", lambda n=n_cores: n)
        checked = check_plans(found, FRAME, at_once=2)
        told.append((checked.plan.name, checked.reached, checked.dropped))
    assert told[0] == told[1] == told[2]


@pytest.mark.slow
def test_no_more_are_tried_when_the_work_is_done_and_one_is_kept(found):
    propagated = []

    def judge(plan):
        propagated.append(plan.name)
        return propagate_design(design_of(plan, FRAME))

    def tried(**given):
        propagated.clear()
        checked = check_plans(found, FRAME, judge=judge, **given)
        return checked, len(propagated)

    first, n_first = tried(spent=lambda: 1.0)
    assert first.is_kept  # however much is spent before it
    assert first.plan.name == propagated[-1]
    # a part of it is left for values between
    more, n_more = tried(refine=["scale_number"], spent=lambda: 0.6)
    assert n_more > n_first
    assert more.plan["cost"] < first.plan["cost"]
    assert tried(refine=["scale_number"], spent=lambda: 1.0)[1] == n_first
    assert tried()[1] > n_first


def test_what_grows_from_layout_to_layout_is_expected_to_go_on(found):
    """Over a small area a high flight is the worse the smaller its scale is."""
    trials = Trials(
        found.plans, found.target, 3, 2, cost_on_layout=lambda plan: plan["cost"]
    )
    ratio = found.plans["high_scale_number"]
    ratio = ratio / found.plans["scale_number"]
    same = found.plans["scale_number"] == 8100
    for name in ("n_settings", "n_coverages", "control_per_model"):
        same &= found.plans[name] == found.plans[name].max()
    least, next_one, *others = np.flatnonzero(same)[np.argsort(ratio[same])]
    assert len(others) >= 2
    trials.errors.learn(least, 1.0)
    trials.errors.learn(next_one, 1.2)
    expected, spread = trials.errors.ratios, trials.errors.spreads
    assert expected[least] < 1.05
    # as far on as was shown, and known less well the farther that is
    assert expected[others[0]] > expected[next_one] > 1.15
    assert (np.diff(spread[[next_one, *others]]) > 0.0).all()
    assert (_trials(found).errors.sloping == 0.0).all()
    # also where no more costs are counted
    trials.count = None
    assert (trials.extended(found.plans).errors.sloping != 0.0).any()
