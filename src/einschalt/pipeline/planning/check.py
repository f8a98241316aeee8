"""Plans of a search held against the propagation on their own layouts."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.typesetting import wrapped
from einschalt.pipeline.planning.expected_precision import (
    ExpectedPrecision,
    expect_precision,
)
from einschalt.pipeline.planning.flight_design import FlightDesign
from einschalt.pipeline.planning.search import describe_plan
from einschalt.stages.results import Result
from einschalt.theory.measuring_error import m_g_of_mean

MOST_TRIED = 6


@dataclass(frozen=True, eq=False, repr=False)
class CheckedPlan(Result):
    """The cheapest plan that keeps what it promised, or the nearest one."""

    plan: pd.Series  # row of the search
    expected: ExpectedPrecision
    reached: float  # error at the place of the target [m]
    target: float  # [m]
    # cheaper plans that do not keep it, with what they come to
    dropped: tuple[str, ...]

    @property
    def is_kept(self):
        """Whether the target is reached on the layout too."""
        return bool(self.reached <= self.target)

    def summary(self):
        """Return which plan holds, and its expected precision."""
        found = f"{_in_cm(self.reached)} with {describe_plan(self.plan)}"
        verdict = f"Checked by propagation on a layout: {found}."
        if not self.is_kept:
            verdict += f" That is more than {_in_cm(self.target)}."
        dropped = [
            wrapped(f"Not kept: {text}", first="  ", indent="    ")
            for text in self.dropped
        ]
        lines = [wrapped(verdict, indent="  "), *dropped]
        return "\n".join([*lines, "", self.expected.summary()])


def check_plans(search, frame, *, most=MOST_TRIED) -> CheckedPlan:
    """Find the cheapest plan that reaches the target on its own layout.

    So many as ``most`` are tried, in growing precision and cost; where none is kept,
    the best of these. EinschaltError where not one can be laid out.
    """
    tried, dropped, problem = [], [], None
    for _, plan in _candidates(search, most).iterrows():
        try:
            expected = expect_precision(design_of(plan, frame))
        except EinschaltError as error:
            problem = error
            dropped.append(f"{describe_plan(plan)}: {error}")
            continue
        reached = _at_place(expected, search.where)
        found = CheckedPlan(plan, expected, reached, search.target, tuple(dropped))
        tried.append(found)
        # the nearest plan need not be looked for any further
        if found.is_kept or not len(search.feasible):
            return found
        dropped.append(f"{describe_plan(plan)}: {_in_cm(reached)}")
    if not tried:
        raise problem
    best = min(tried, key=lambda found: found.reached)
    others = (text for text in dropped if describe_plan(best.plan) not in text)
    return replace(best, dropped=tuple(others))


def _candidates(search, most):
    """Give the cheapest plan, then in steps of precision the cheapest of each step."""
    if not len(search.feasible):
        return search.plans.sort_values("reached", kind="stable").head(most)
    plans = search.feasible
    steps = search.target * (1.0 - 0.05 * np.arange(most))
    are_within = [plans["reached"].to_numpy() <= step for step in steps]
    places = [int(np.argmax(within)) for within in are_within if within.any()]
    return plans.iloc[list(dict.fromkeys(places))]


def design_of(plan, frame) -> FlightDesign:
    """Put a plan of a search down as a design of two flights."""
    m_g_um = float(m_g_of_mean(plan["m_g_um"], plan["n_settings"]))
    return FlightDesign(
        scale_number=float(plan["scale_number"]),
        spacing=float(plan["spacing"]),
        m_g_um=m_g_um,
        kind=frame.kind,
        image_format=frame.image_format,
        principal_distance=frame.principal_distance,
        forward_overlap=frame.forward_overlap,
        side_overlap=frame.side_overlap,
        n_coverages=int(plan["n_coverages"]),
        high_scale_number=float(plan["high_scale_number"]),
        high_m_g_um=frame.high_over_low_m_g * m_g_um,
        control_standard_error=frame.control_standard_error,
        control_per_model=int(plan["control_per_model"]),
    )


def _in_cm(metres):
    # so far that 5.02 and 5.00 cm differ
    return f"{100.0 * metres:.2f} cm"


def _at_place(expected, where):
    figures = expected.figures
    if expected.design.n_coverages > 1:
        return figures.mean
    single = {"centre": figures.single_centre, "edge": figures.single_edge}
    return single.get(where, max(single.values()))
