"""How large the errors of each group of observations show themselves to be.

With v the residuals and r the redundancy numbers of a group,

    s² = Σ w v² / Σ r

is 1 where its errors are as large as given (Förstner 1979). Groups whose errors are
not known are given others until it is.
"""

from dataclasses import dataclass

import numpy as np

# redundancy below which a group says nothing of its errors
LEAST_REDUNDANCY = 5.0


@dataclass(frozen=True, eq=False)
class GroupComponents:
    """Errors that groups of observations show."""

    # (n_groups,): of the standard errors that were used; NaN with too little redundancy
    factor: np.ndarray
    redundancy: np.ndarray  # (n_groups,): sum of the redundancy numbers


def group_components(block, group, n_groups) -> GroupComponents:
    """Size of the errors of each group of measurements, and last of the control.

    ``group`` (n_rows, d) is that of each measured coordinate. What was taken out of the
    block does not count.
    """
    solution = block.solution
    observations = solution.observations
    error = observations.standard_error.reshape(len(group), -1)
    is_in = ~block.is_out[:, None]
    squares = (is_in * (solution.residuals / error) ** 2).ravel()
    code = group.ravel()
    share = (is_in * (1.0 - solution.leverage)).ravel()
    is_right = ~block.is_wrong
    control = np.nan_to_num(solution.control_residuals) * is_right[:, None]
    weighted = np.einsum("na,nab,nb->", control, observations.control_weight, control)
    redundancy = np.append(
        np.bincount(code, share, n_groups),
        np.nansum(1.0 - solution.control_leverage[is_right]),
    )
    squares = np.append(np.bincount(code, squares, n_groups), weighted)
    redundancy = np.maximum(redundancy, 0.0)  # less is rounding
    is_known = redundancy > LEAST_REDUNDANCY
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.sqrt(squares / redundancy)
    return GroupComponents(np.where(is_known, factor, np.nan), redundancy)
