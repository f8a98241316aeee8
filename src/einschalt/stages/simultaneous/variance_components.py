"""How large the errors of control and flights are, and errors that nobody knows.

Errors in plan come from m_g, those of control from its table. What a model is worse in
height, and how well its projection centres are placed in it, nobody has given: their
groups of observations get the errors that their residuals show.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations.language import mark
from einschalt.stages.simultaneous.image_drawings import ImageSizes
from einschalt.theory.block_adjustment.gross_errors import OutlierFreeBlock
from einschalt.theory.block_adjustment.group_components import group_components
from einschalt.theory.block_adjustment.observations import Part

MOST_PASSES = 20
SETTLED = 0.01
# beyond it there are gross errors, and one group would take all of them
MOST_FACTOR = 1e3
REFUTED = 3.0  # standard errors of a factor
CONTROL = "control"
# of the measured coordinates of spatial models
KINDS = (
    mark("plan"),
    mark("height"),
    mark("centres in plan"),
    mark("centres in height"),
)


@dataclass(frozen=True, eq=False)
class Groups:
    """Groups of measured coordinates."""

    # ``low_flight``, or ``low_flight, height`` and the like of spatial models
    names: list
    code: np.ndarray  # (n_rows, d)
    is_unknown: np.ndarray  # (n_groups,): nobody has given the size of their errors


def groups_of(tables, part) -> Groups:
    """Group the measured coordinates of a block."""
    observations = part.observations
    flight = observations.flight[observations.model]
    if not tables.is_spatial:
        known = np.zeros(len(tables.flights), dtype=bool)
        return Groups(list(tables.flights), np.repeat(flight[:, None], 2, 1), known)
    names = [f"{name}, {kind}" for name in tables.flights for kind in KINDS]
    is_centre = tables.is_centre[part.points][observations.point]
    plan = 4 * flight + 2 * is_centre
    is_unknown = np.tile([False, True, True, True], len(tables.flights))
    return Groups(names, np.stack([plan, plan, plan + 1], axis=1), is_unknown)


@dataclass(frozen=True, eq=False)
class Weighed:
    """A block whose groups have the errors that they show."""

    part: Part  # its observations have these errors
    block: OutlierFreeBlock
    # (n_groups + 1,): of the errors, since the block was given; the last one is that of
    # the control
    factors: np.ndarray
    # group, standard_error_m (median, of one coordinate), factor (the errors that the
    # residuals show, over those that were given; of groups whose errors nobody gave,
    # over the ones to start with), factor_standard_error (NaN where a factor is one
    # step from errors that are refuted), redundancy, is_estimated (they were adjusted
    # with it)
    table: pd.DataFrame
    image_sizes: ImageSizes


def weigh_groups(tables, part, block, *, all_of_them, factors=1.0) -> Weighed:
    """Give the groups the errors that their residuals show, where that is asked for.

    ``all_of_them`` estimates every group and the control, otherwise those that nobody
    has given only. Control that shares errors keeps what was given: residuals hardly
    show them. ``factors`` (n_groups + 1,) are those that the errors of the part have
    already; ``block`` is of the part.
    """
    groups = groups_of(tables, part)
    n_groups = len(groups.names)
    with_control = all_of_them and part.observations.shared_control is None
    is_free = np.append(groups.is_unknown | all_of_them, with_control)
    applied = np.ones(n_groups + 1) * factors
    found = group_components(block, groups.code, n_groups)
    for _ in range(MOST_PASSES):
        step = np.where(is_free & (found.factor > 0.0), found.factor, 1.0)
        step = np.clip(applied * step, 1.0 / MOST_FACTOR, MOST_FACTOR) / applied
        if (np.abs(step - 1.0) < SETTLED).all():
            break
        applied *= step
        part = replace(part, observations=_scaled(part.observations, groups, step))
        block = block.readjusted(part.observations)
        found = group_components(block, groups.code, n_groups)
    table = _table(part.observations, groups, applied, found)
    table["is_estimated"] = is_free[table.index] & table["factor"].notna()
    table = _without_errors_of_single_steps(table)
    as_given = ImageSizes.as_given(len(tables.flights))
    return Weighed(part, block, applied, table.reset_index(drop=True), as_given)


def _without_errors_of_single_steps(table):
    """Keep the standard errors of factors where the errors that were held may be right.

    The factor of a group that is held is one step towards the errors that its residuals
    show. If one of these sizes is refuted, all of these steps end short of it, by many
    of their standard errors (0.34 ± 0.01 for 0.25): these would say what is not so.
    """
    held = table[~table["is_estimated"]]
    apart = (held["factor"] - 1.0).abs()
    if not (apart > REFUTED * held["factor_standard_error"]).any():
        return table
    known = table["factor_standard_error"].where(table["is_estimated"])
    return table.assign(factor_standard_error=known)


def with_errors_as_shown(tables, part, block):
    """Part whose measurements have errors as large as the residuals of a block are.

    Of each group, by one step of :func:`weigh_groups`; control keeps its own.
    """
    groups = groups_of(tables, part)
    factor = group_components(block, groups.code, len(groups.names)).factor
    step = np.where(factor > 0.0, factor, 1.0)
    step[-1] = 1.0
    step = np.clip(step, 1.0 / MOST_FACTOR, MOST_FACTOR)
    return replace(part, observations=_scaled(part.observations, groups, step))


def _scaled(observations, groups, step):
    error = observations.standard_error
    # plane models have one standard error for both coordinates
    code = groups.code if error.ndim > 1 else groups.code[:, 0]
    bent = observations.bent
    if bent is not None:  # estimated as a share of the measuring errors
        by_axis = step[:-1][groups.code]
        bent = bent * (by_axis[:, :1] if bent.ndim == 2 else by_axis[:, :, None])
    shared = observations.shared_control
    return replace(
        observations,
        shared_control=None if shared is None else shared.scaled(step[-1]),
        standard_error=error * step[:-1][code],
        control_covariance=observations.control_covariance * step[-1] ** 2,
    )


def _table(observations, groups, applied, found):
    """Groups that have observations, and the control."""
    error = observations.standard_error.reshape(len(groups.code), -1)
    error = np.broadcast_to(error, groups.code.shape)
    is_observed = observations.is_control & ~observations.is_fixed
    variance = observations.control_covariance[is_observed]
    is_given = observations.is_given[is_observed]
    control = np.sqrt(np.diagonal(variance, axis1=1, axis2=2)[is_given])
    # a group that has come to have little redundancy keeps what it had until then
    is_told = np.isfinite(found.factor) | (applied != 1.0)
    factor = np.where(is_told, applied * np.nan_to_num(found.factor, nan=1.0), np.nan)
    sizes = [error[groups.code == k] for k in range(len(groups.names))] + [control]
    with np.errstate(divide="ignore"):
        error_of_factor = factor / np.sqrt(2.0 * found.redundancy)
    median = [np.median(size) if size.size else np.nan for size in sizes]
    table = pd.DataFrame(
        {
            "group": [*groups.names, CONTROL],
            "standard_error_m": median,
            "factor": factor,
            "factor_standard_error": error_of_factor,
            "redundancy": found.redundancy,
        }
    )
    return table[[size.size > 0 for size in sizes]]
