"""Values between those of a search, of which one may make a cheaper plan."""

from dataclasses import replace

import numpy as np
import pandas as pd

from einschalt.foundations.language import translated
from einschalt.pipeline.planning.estimate.search import PlanChoices, find_plans
from einschalt.pipeline.planning.estimate.work import is_efficient

BETWEEN = {"scale_number": 3, "high_over_low": 2}
"""Values between two that were tried, of each choice that can have any value."""
LEAST_STEP = 0.1
"""Of logarithms: between values that are closer to each other little is to be saved."""
REFINED = {
    "scale_number": "--scale-number",
    "high_over_low": "--high-over-low",
    "n_settings": "--n-settings",
}
"""Options of the choices that can be refined."""


def finer_choices(plans, plan) -> dict[str, tuple[float, ...]]:
    """Give values about those of a plan, between those that a search has tried.

    ``plans``: table of the search, ``plan``: row of it. The keys are those of
    ``PlanChoices``; a choice of which the search had but one value stays as it was
    asked for, and so does one whose values are close to each other.
    """
    low, high = plans["scale_number"], plans["high_scale_number"]
    tried = {"scale_number": low, "high_over_low": (high / low).round(4)}
    taken = {
        "scale_number": plan["scale_number"],
        "high_over_low": plan["high_scale_number"] / plan["scale_number"],
    }
    finer = {
        name: _about(taken[name], np.unique(tried[name]), BETWEEN[name])
        for name in tried
    }
    settings = np.unique(plans["n_settings"])
    finer["n_settings"] = _whole_about(plan["n_settings"], settings)
    return {name: values for name, values in finer.items() if len(values) > 1}


def _about(value, tried, n):
    """A value with those between it and its neighbours, in like ratios."""
    finer = [float(value)]
    for beside in _neighbours(value, tried):
        step = np.log(beside / value)
        if abs(step) > LEAST_STEP:
            between = np.exp(step * np.arange(1, n + 1) / (n + 1))
            finer += [float(f"{one:.3g}") for one in value * between]
    return tuple(sorted(finer))


def _whole_about(value, tried):
    """The same of whole numbers: all between it and its neighbours."""
    finer = {int(value)}
    for beside in _neighbours(value, tried):
        low, high = sorted([int(value), int(beside)])
        finer |= set(range(low + 1, high))
    return tuple(sorted(finer))


def _neighbours(value, tried):
    at = int(np.argmin(np.abs(tried - value)))
    return [tried[k] for k in (at - 1, at + 1) if 0 <= k < len(tried)]


def plans_between(search, plan, frame, names) -> pd.DataFrame:
    """Plans with values about those of a plan, as rows of its search.

    ``names`` are those of choices that may have any value. What is measured may be
    measured otherwise; the number of coverages, the spacing and the pattern of control
    stay. Rows are numbered on from those of the search.
    """
    plans = search.plans
    finer = finer_choices(plans, plan)
    finer = {name: finer[name] for name in names if name in finer}
    if not finer:
        return plans.iloc[:0]
    choices = PlanChoices(
        **{
            "scale_number": float(plan["scale_number"]),
            "high_over_low": float(plan["high_scale_number"] / plan["scale_number"]),
        }
        | finer
        | {"n_settings": (*plans["n_settings"].unique(), *finer.get("n_settings", ()))},
        spacing=float(plan["spacing"]),
        m_g_um=tuple(plans["m_g_um"].unique()),
        n_coverages=int(plan["n_coverages"]),
        control_per_model=int(plan["control_per_model"]),
    )
    given = {"where": search.where, "by": search.by}
    found = find_plans(search.target, choices, frame, **given).plans
    found = found[~is_among(found, plans)]
    first = plans.index.max() + 1
    return found.set_axis(range(first, first + len(found)))


def is_among(found, plans):
    """Whether plans are among others, (n_found,)."""
    names = ["scale_number", "high_scale_number", "n_settings", "m_g_um"]
    names += ["spacing", "n_coverages", "control_per_model"]
    both = pd.concat([plans[names], found[names]]).astype(float).round(3)
    return both.duplicated().to_numpy()[len(plans) :]


def searched_with(search, more):
    """Give a search with further rows, in the order of its plans."""
    if not len(more):
        return search
    plans = pd.concat([search.plans, more])
    cost, reached = plans["cost"].to_numpy(), plans["reached"].to_numpy()
    plans["is_efficient"] = is_efficient(cost, reached)
    order = np.lexsort((reached, cost, ~plans["is_feasible"].to_numpy()))
    return replace(search, plans=plans.iloc[order])


def describe_finer(finer) -> str:
    """Say which values, of one choice or more, may make a plan cheaper."""
    asked = " ".join(
        f"{REFINED[name]} {','.join(f'{value:g}' for value in values)}"
        for name, values in finer.items()
    )
    return translated(
        "It is the cheapest of the values that were tried; between them it may be some "
        "per cent cheaper: {asked}",
        asked=asked,
    )
