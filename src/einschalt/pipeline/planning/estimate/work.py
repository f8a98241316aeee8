"""What plans take for each km², what that costs, and which of them are efficient."""

from dataclasses import replace

import numpy as np

from einschalt.pipeline.planning.flights.costs import COLUMN_OF_ITEM, cost_of
from einschalt.pipeline.planning.flights.flight_design import (
    NODES_IN_A_MODEL,
    usable_model,
)
from einschalt.pipeline.planning.flights.points_in_models import (
    MOST_ON_THE_GROUND,
    too_much_control,
)
from einschalt.pipeline.simulation.layout import FEW_STRIPS, least_strips
from einschalt.theory.planning.expected_precision import models_per_point

M2_PER_KM2 = 1e6
CONTROL_PER_NEAT_MODEL = {5: 2, 9: 4}
"""Corners and sides are shared with neighbours of the same coverage; another coverage
has its own, since flights do not repeat to the metre."""
CONTROL_IN_A_MODEL = NODES_IN_A_MODEL | {9: 11.0}
"""In the whole overlap of a model of the high flight, where control is set for all of
them together: between what layouts over areas take of film, and where images overlap
much. Of five places the nodes of their lattice lie between (film takes 0.7, drones 1.4
times as much); of nine both take more than the nodes, which leave places unserved."""
OUTSIDE = 0.5
"""Of models: what of two opposite ones may lie beyond the border of an area."""
AT_THE_BORDER = 1.5
"""Of steps of control: a row stands on the border, and models beyond it want more."""
ON_LAYOUTS = 0.8
"""Of the most control, where spacings are advised: layouts over areas take more control
than the estimate, and would refuse them."""


def work_for_each_km2(columns, frame, model):
    """What has to be done for each km²."""
    along, across = model.image_format
    base, strip = (
        (1.0 - model.forward_overlap) * along,
        (1.0 - model.side_overlap) * across,
    )
    whole = np.array([model.forward_overlap * along, across])
    coverages = columns["n_coverages"]
    scales = [columns[f"{flight}scale_number"] for flight in ("", "high_")]
    low, high = (
        coverages * _models(frame, model, (base, strip), whole, scale)
        for scale in scales
    )
    ends = 0.0  # a strip has one image more than models
    if frame.extent is not None:
        _, width, size = frame.extent
        n_strips = sum(_strips(width, model, strip, scale) for scale in scales)
        ends = coverages * n_strips * M2_PER_KM2 / size
    points = M2_PER_KM2 / columns["spacing"] ** 2
    values = 2.0 * models_per_point(model) * coverages
    settings = points * values * columns["n_settings"]
    control = _control(columns, frame, high, whole)
    amounts = {
        "image": low + high + ends,
        "model": low + high,
        "setting": settings,
        "control_point": control,
    }
    columns = {COLUMN_OF_ITEM[item]: amount for item, amount in amounts.items()}
    return columns | {"cost": cost_of(amounts, frame.costs)}


def _models(frame, model, apart, whole, scale):
    """Count models of one coverage for each km², of an overlap ``whole`` [m]."""
    usual = _for_each_km2(frame, apart, whole * OUTSIDE, scale)
    if frame.extent is None:
        return usual
    _, width, size = frame.extent
    n_strips = _least_strips(width, model, apart[1], scale)
    in_a_strip = (size / width + whole[0] * OUTSIDE * scale) / (apart[0] * scale)
    few = n_strips * in_a_strip * M2_PER_KM2 / size
    return np.where(n_strips <= FEW_STRIPS, np.minimum(few, usual), usual)


def _strips(width, model, apart, scale):
    """Number of strips of a coverage over a width [m], in the mean of all."""
    least = _least_strips(width, model, apart, scale)
    usual = width / (apart * scale) + OUTSIDE
    return np.where(least <= FEW_STRIPS, least, usual)


def _least_strips(width, model, apart, scale):
    return least_strips(width, usable_model(model)[1] * scale, apart * scale)


def _control(columns, frame, high, whole):
    """Control points for each km²; ``high`` models, of a ``whole`` overlap [m]."""
    is_nine = columns["control_per_model"] == 9
    five, nine = CONTROL_PER_NEAT_MODEL.values()
    control = np.where(is_nine, nine, five) * high
    if not frame.shares_control:
        return control
    steps = [whole / np.sqrt(n) for n in CONTROL_IN_A_MODEL.values()]
    five, nine = (
        _for_each_km2(frame, step, AT_THE_BORDER * step, columns["high_scale_number"])
        for step in steps
    )
    return np.minimum(control, np.where(is_nine, nine, five))


def _for_each_km2(frame, apart, beyond, scale):
    """Count places of a lattice by km², the border of the ground included.

    ``apart``: distances along and across the strips; ``beyond``: what the ground is
    longer and wider by as far as places count [both m in the image].
    """
    within = np.ones_like(scale)
    if frame.extent is not None:
        length, width, size = frame.extent
        more = scale * beyond[0], scale * beyond[1]
        within = 1.0 + (more[0] * width + more[1] * length + more[0] * more[1]) / size
    return M2_PER_KM2 * within / (apart[0] * apart[1] * scale**2)


def are_densified(columns, part=1.0):
    """Which plans take less than the most control, or a part of it."""
    return _share_of_control(columns) < part * MOST_ON_THE_GROUND


def _share_of_control(columns):
    """How many control points there are for each point."""
    return columns["control_points"] * columns["spacing"] ** 2 / M2_PER_KM2


def without_control_alone(columns, frame, model, does):
    """Leave out plans that survey so many points that few are left to be densified.

    GeometryError where none is left, which names an area as remedy where over one there
    are plans.
    """
    is_plan = are_densified(columns)
    if not is_plan.any():
        sharing = replace(frame, shares_control=True)
        shared = columns | work_for_each_km2(columns, sharing, model)
        is_shared = are_densified(shared, ON_LAYOUTS).any()
        raise too_much_control(
            _share_of_control(columns),
            columns["spacing"],
            frame.max_height,
            does,
            over_area=not frame.shares_control and bool(is_shared),
        )
    return {name: values[is_plan] for name, values in columns.items()}


def is_efficient(cost, error):
    """Whether no other plan is at least as cheap and at least as good.

    Of twins the first one is.
    """
    order = np.lexsort((error, cost))
    best = np.minimum.accumulate(error[order])
    before = np.concatenate([[np.inf], best[:-1]])
    result = np.empty(len(cost), dtype=bool)
    result[order] = error[order] < before
    return result
