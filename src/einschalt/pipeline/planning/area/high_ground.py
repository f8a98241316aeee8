"""What would do where the ground is too high for every plan of a search."""

from dataclasses import replace

import numpy as np

from einschalt.pipeline.planning.estimate.search import PlanChoices
from einschalt.pipeline.planning.flights.arguments import RANGES
from einschalt.pipeline.planning.flights.points_in_models import upwards

OVERLAPS = ((0.7, 0.4), (0.8, 0.6), (0.9, 0.7))  # forward and to the side
HIGHER = (1.3, 1.7, 2.2)  # of the largest scale number
CHOSEN = ("scale_number", "spacing", "m_g_um", "n_settings", "n_coverages")


def remedy_above(search, frame, is_plan):
    """Advise overlaps or a scale number with which there is a plan.

    All else stays as given. ``is_plan(frame, choices)`` plans the area with them: what
    gives no plan that keeps the target is not advised.
    """
    choices = _choices_of(search)
    overlaps = _overlaps_that(is_plan, frame, choices)
    larger = _scale_number_that(is_plan, frame, choices)
    if overlaps and larger:
        forward, side = overlaps
        return (
            f"Give --forward-overlap {forward:g} --side-overlap {side:g}, or "
            f"--scale-number {larger}: with either there is a plan"
        )
    if overlaps:
        forward, side = overlaps
        return (
            f"Give --forward-overlap {forward:g} --side-overlap {side:g}: with them "
            "there is a plan"
        )
    if larger:
        return f"Give --scale-number {larger}: with it there is a plan"
    return "Plan parts of the area by themselves, in which the ground rises less"


def _choices_of(search):
    """The choices of a search, as far as its plans have them."""
    plans = search.plans
    ratio = (plans["high_scale_number"] / plans["scale_number"]).round(9)
    return PlanChoices(
        **{name: tuple(plans[name].unique()) for name in CHOSEN},
        control_per_model=tuple(plans["control_per_model"].unique()),
        high_over_low=tuple(ratio.unique()),
    )


def _overlaps_that(is_plan, frame, choices):
    """The least overlaps with which there is a plan, None if there are none."""
    given = frame.forward_overlap, frame.side_overlap
    for least in OVERLAPS:
        forward, side = np.maximum(least, given)
        if (forward, side) == given:
            continue
        changed = {"forward_overlap": float(forward), "side_overlap": float(side)}
        if is_plan(replace(frame, **changed), choices):
            return float(forward), float(side)
    return None


def _scale_number_that(is_plan, frame, choices):
    """Write the least scale number with which there is a plan, or ""."""
    lowest = min(choices.high_over_low) * frame.principal_distance
    for times in HIGHER:
        larger = upwards(times * max(choices.scale_number), 3)
        is_flown = float(larger) in RANGES["scale_number"]
        if frame.max_height is not None:
            is_flown &= float(larger) * lowest <= frame.max_height
        changed = replace(choices, scale_number=(float(larger),))
        if is_flown and is_plan(frame, changed):
            return larger
    return ""
