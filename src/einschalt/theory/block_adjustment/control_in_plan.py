"""What an adjustment of everything knows of the places of its control in plan.

As :mod:`.control_heights`, of easting and northing at once: given coordinates that are
wrong by s leave the scores u = W (I - C) s = M s. Their covariance V is M where
observations have the errors that they are weighed with, and was drawn where they share
errors. With V = U Λ Uᵀ the numbers Λ^(-1/2) Uᵀ u are independent and of variance 1, and
Λ^(-1/2) Uᵀ M is what errors of given coordinates make of them. The block as a whole may
move, turn and change its scale: so many directions are left out.

See docs/theory/claim.md.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.theory.block_adjustment.control_scores import (
    known_directions,
    points_by_control,
    scores_of_control,
)

N_AXES = 2
IN_PLAN = [0, 1]
# of the largest eigenvalue of a covariance of scores: what is smaller is rounding, as
# of an affinity of the whole block, which affine models follow to eight digits
LEAST_RANK = 1e-6


@dataclass(frozen=True, eq=False)
class PlanScores:
    """Scores of control in plan as independent numbers, and what they tell of."""

    observed: np.ndarray  # (n,): of variance 1 if all errors are as large as given
    # (n, n_control, 2): what errors of given easting and northing make of them [1/m]
    shown: np.ndarray
    # (n_points, 2, n_control, 2): what these do to all points in plan
    follows: np.ndarray


def plan_scores(solution, s_0, drawn=None, n_draws=0) -> PlanScores:
    """Scores of all control points of a block, in the order of its points.

    Parameters
    ----------
    solution : BlockSolution or SpatialSolution
        Without control that is held.
    s_0 : float
        Larger than 1 where errors are larger than stated, by the whole block.
    drawn : ndarray, shape (2 n_control, 2 n_control), optional
        Covariance of the scores, as of :func:`scores_of_control`, by ``n_draws`` draws;
        that of independent observations where left out.

    Notes
    -----
    The inverse of a covariance from N draws of n numbers is too large by
    N / (N - n - 1), which is taken out of it (Hartlap, Simon and Schneider 2007).
    """
    known = solution.observations
    control = np.flatnonzero(known.is_control)
    n = N_AXES * len(control)
    follows = points_by_control(solution, IN_PLAN)
    # easting of all control points, then northing of all
    missed = np.eye(n) - follows[control].transpose(1, 0, 3, 2).reshape(n, n)
    shown = _weights(known, control) @ missed
    away = np.nan_to_num(solution.control_residuals)
    scores = scores_of_control(solution, away[:, :, None], IN_PLAN)[:, 0]
    covariance = (shown + shown.T) / 2.0 if drawn is None else drawn
    values, vectors = known_directions(covariance, LEAST_RANK)
    size = np.sqrt(values) * max(1.0, np.nan_to_num(s_0))
    if drawn is not None:
        size /= np.sqrt(max(n_draws - n - 1, 1) / n_draws)
    whitening = (vectors / size).T
    of_axes = (whitening @ shown).reshape(-1, N_AXES, len(control))
    return PlanScores(whitening @ scores, np.swapaxes(of_axes, 1, 2), follows)


def _weights(known, control):
    """Of the given coordinates in plan, (2 n_control, 2 n_control)."""
    n = len(control)
    weights = np.zeros((N_AXES, n, N_AXES, n))
    places = np.arange(n)
    weights[:, places, :, places] = known.control_weight[control, :N_AXES, :N_AXES]
    return weights.reshape(N_AXES * n, N_AXES * n)
