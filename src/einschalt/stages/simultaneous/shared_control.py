"""Errors that control points share: stated, or as large as the adjustment shows them.

Control is weighed by all of its errors, as if each point had its own; what is shared
goes into the covariances of the adjusted points, which are drawn then.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from einschalt.stages.error_propagation.given_points import group_members
from einschalt.stages.error_propagation.group_size import LEAST_SHOWN
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.spatial_correlation import exponential_factor
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


def shared_control(control_points, known, rows, n_points):
    """What control points of a block share: SharedControl, or None.

    ``rows`` (n_points,) are those of the control of each point, −1 where it has none.
    Groups of unknown size shift by 1 m, TOTAL.
    """
    used = np.flatnonzero(rows >= 0)
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
        xy = control_points[["easting", "northing"]].to_numpy(float)[rows[used]]
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


def with_group_sizes(tables, adjust):
    """Tables whose groups of control have shifts of the size that residuals show.

    ``adjust`` makes of the tables a solution in which control has its own errors alone.
    Where it does not tell, the groups stay unknown.
    """
    shared = tables.observations.shared_control
    if shared is None or not shared.is_unknown:
        return tables
    part, solution = adjust(tables)
    found = _size(solution, part.observations.shared_control.groups)
    if found is None:
        return tables
    groups = shared.groups * found
    sized = replace(shared, groups=groups, is_unknown=False)
    return replace(tables, observations=tables.observations.with_shared_control(sized))


def _size(solution, groups):
    """Shifts of groups over those of ``groups``, by their mean residuals, or None."""
    observations = solution.observations
    is_used = observations.is_control
    count = np.maximum(np.asarray((groups[is_used] != 0).sum(axis=0)), 1)
    mean = (groups != 0).T.astype(float).tocsr()
    mean = sparse.diags_array(1.0 / np.sqrt(count)) @ mean[:, np.flatnonzero(is_used)]

    def squares(residuals):
        n = residuals.shape[1] * residuals.shape[2]
        means = mean @ residuals[is_used].reshape(is_used.sum(), n)
        return (means.reshape(-1, *residuals.shape[1:]) ** 2).sum(axis=(0, 1))

    rng = np.random.default_rng(1971)
    shape = (observations.control.shape[1], N_DRAWS)
    errors = observations.drawn_errors(rng, N_DRAWS, solution.linear)
    own = observations.drawn_control(rng, N_DRAWS)
    shifts = groups @ rng.standard_normal((groups.shape[1], shape[0] * N_DRAWS))
    shifts = shifts.reshape(-1, *shape)
    noise, of_shifts = (
        squares(solution.answer_to(measured, given)[0] - given)
        for measured, given in ((errors, own), (np.zeros_like(errors), shifts))
    )
    if of_shifts.mean() < LEAST_SHOWN * squares(shifts).mean():
        return None
    seen = squares(np.nan_to_num(solution.control_residuals)[:, :, None])[0]
    # what hides in the noise may be as large as that scatters
    return np.sqrt(max(seen - noise.mean(), noise.std()) / of_shifts.mean())
