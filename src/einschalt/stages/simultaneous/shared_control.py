"""Errors that control points share: stated, or as large as the adjustment shows them.

Control is weighed by all of its errors, as if each point had its own; what is shared
goes into the covariances of the adjusted points, which are drawn then.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from einschalt.foundations.frame_columns import values_of
from einschalt.stages.error_propagation.given_points import group_members
from einschalt.stages.error_propagation.group_size import LEAST_SHOWN
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.monte_carlo import draws_in_parts
from einschalt.theory.adjustment.spatial_correlation import exponential_factor
from einschalt.theory.block_adjustment.gross_errors import examine_control
from einschalt.theory.block_adjustment.observations import SharedControl

N_DRAWS = 100


@dataclass(frozen=True)
class SharedErrors:
    """What is known of the errors that control points share."""

    # TOTAL, of the shift that points of a group share [m]; None where nobody gave it
    group_error_m: float | None = None
    # [m]; 0 where errors are independent
    correlation_length_m: float = 0.0


INDEPENDENT = SharedErrors()


def shared_control(control_points, known, rows, point_rank):
    """What control points of a block share: SharedControl, or None.

    ``rows`` (n_points,) are those of the control of each point, −1 where it has none;
    its errors are drawn in the order of ``point_rank`` (n_points,). Groups of unknown
    size shift by 1 m, TOTAL.
    """
    n_points = len(rows)
    used = np.flatnonzero(rows >= 0)
    used = used[point_rank[used].argsort()]
    if control_points is None or len(used) == 0:
        return None
    members = group_members(control_points)
    if members is None and not known.correlation_length_m > 0.0:
        return None
    pick = sparse.csr_array(
        (np.ones(len(used)), (used, rows[used])), (n_points, len(control_points))
    )
    factor = None
    if known.correlation_length_m > 0.0:
        xy = values_of(control_points, ["easting", "northing"])[rows[used]]
        of_used = exponential_factor(xy, known.correlation_length_m)
        place = sparse.csr_array(
            (np.ones(len(used)), (used, np.arange(len(used)))), (n_points, len(used))
        )
        factor = place @ sparse.csr_array(of_used)
    if members is None:
        return SharedControl(factor, sparse.csr_array((n_points, 0)))
    size = (known.group_error_m or 1.0) / SQRT2
    is_unknown = known.group_error_m is None
    return SharedControl(factor, (pick @ members * size).tocsr(), is_unknown)


def with_group_sizes(tables, adjust, significance):
    """Tables whose groups of control have shifts of the size that residuals show.

    ``adjust`` makes of the tables a solution in which control has its own errors alone.
    Points that are wrong beyond the first sizes, at a ``significance``, are left out
    of the second ones. Where it does not tell, the groups stay unknown.
    """
    shared = tables.observations.shared_control
    if shared is None or not shared.is_unknown:
        return tables
    solution = adjust(tables)
    unknown = solution.observations.shared_control
    found = _size(solution, unknown.groups, solution.observations.is_control)
    if found is None:
        return tables
    sized = solution.observations.with_shared_control(_known(unknown, found))
    verdict = examine_control(solution.readjusted(sized), significance)
    if verdict.is_suspect.any():
        is_used = sized.is_control & ~verdict.is_suspect
        found = _size(verdict.without, unknown.groups, is_used) or found
    observations = tables.observations.with_shared_control(_known(shared, found))
    return replace(tables, observations=observations)


def _known(shared, size):
    return replace(shared, groups=shared.groups * size, is_unknown=False)


def _size(solution, groups, is_used):
    """Shifts of groups over those of ``groups``, by their median residuals, or None.

    Medians of points that are used: one wrong point makes no shift of its group.
    """
    observations = solution.observations
    members = _members(groups, is_used)
    d = observations.control.shape[1]
    is_given = observations.is_given[:, :, None]
    rng = np.random.default_rng(1971)
    drawn = []
    n_numbers = len(observations.model) * d
    for n_draws in draws_in_parts(N_DRAWS, n_numbers):
        errors = observations.drawn_errors(rng, n_draws, solution.linear)
        own = observations.drawn_control(rng, n_draws, with_shifts=False)
        shifts = groups @ rng.standard_normal((groups.shape[1], d * n_draws))
        shifts = shifts.reshape(-1, d, n_draws)
        shifts = shifts * is_given
        left = is_given * (solution.answer_to(errors, own)[0] - own)
        moved = solution.answer_to(np.zeros_like(errors), shifts)[0]
        left_of_shifts = is_given * (moved - shifts)
        parts = (left, left_of_shifts, shifts)
        drawn.append([_squares(each, members) for each in parts])
    noise, of_shifts, whole = map(np.concatenate, zip(*drawn, strict=True))
    if of_shifts.mean() < LEAST_SHOWN * whole.mean():
        return None
    seen = _squares(np.nan_to_num(solution.control_residuals)[:, :, None], members)[0]
    # what hides in the noise may be as large as that scatters
    return np.sqrt(max(seen - noise.mean(), noise.std()) / of_shifts.mean())


def _members(groups, is_used):
    """Points of each group that are used, as an array of places for each group."""
    by_group = groups.tocsc()
    places = np.split(by_group.indices, by_group.indptr[1:-1])
    return [rows[is_used[rows]] for rows in places if is_used[rows].any()]


def _squares(residuals, members):
    """Squares of the median of each group, times its number of points; (n_draws,)."""
    medians = np.stack([np.median(residuals[rows], axis=0) for rows in members])
    count = np.array([len(rows) for rows in members], dtype=float)
    return np.einsum("g,gan->n", count, medians**2)
