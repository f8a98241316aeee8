"""What a spatial adjustment of everything knows of the heights of its control.

Given heights that are wrong by s leave the scores (weight times correction)

    u = W (I - C) s = M s,

where C is what the adjusted heights of control follow given ones by. M is also the
covariance of the scores, P - P Q P, where observations have the errors that they are
weighed with. Models from images share theirs: then the covariance V of the scores was
drawn, and Mᵀ V⁻¹ u stands for the scores, whose covariance and information are both
Mᵀ V⁻¹ M.

See docs/theory/claim.md.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.theory.block_adjustment.control_scores import (
    known_directions,
    points_by_control,
    scores_of_control,
)

HEIGHT = 2
IN_HEIGHT = [HEIGHT]
# of the largest eigenvalue of a covariance of scores: what is smaller is rounding
LEAST_RANK = 1e-8


@dataclass(frozen=True, eq=False)
class HeightScores:
    """Scores of the heights of control, and what they tell of."""

    scores: np.ndarray  # (n_control,) [1/m]
    information: np.ndarray  # (n_control, n_control); their covariance as well [1/m²]
    # (n_points, n_control): what given heights do to those of all points
    follows: np.ndarray


def height_scores(solution, s_0, drawn=None, n_draws=0) -> HeightScores:
    """Scores of all control points of a spatial block, in the order of its points.

    Parameters
    ----------
    solution : SpatialSolution
    s_0 : float
        Larger than 1 where errors are larger than stated, by the whole block.
    drawn : ndarray, shape (n_control, n_control), optional
        Covariance of the scores, as of :func:`scores_of_control`, by ``n_draws`` draws;
        that of independent observations where left out.

    Notes
    -----
    The inverse of a covariance from N draws of n numbers is too large by
    N / (N - n - 1), which is taken out of it (Hartlap, Simon and Schneider 2007).
    """
    known = solution.observations
    control = np.flatnonzero(known.is_control)
    follows = points_by_control(solution, IN_HEIGHT)[:, 0, :, 0]
    missed = -follows[control]
    missed[np.diag_indices(len(control))] += 1.0
    shown = known.control_weight[control, HEIGHT, HEIGHT][:, None] * missed
    away = solution.control_residuals[:, :, None]
    scores = scores_of_control(solution, away, IN_HEIGHT)[:, 0]
    covariance = (shown + shown.T) / 2.0 if drawn is None else drawn
    values, vectors = known_directions(covariance, LEAST_RANK)
    inverse = (vectors / values) @ vectors.T / max(1.0, np.nan_to_num(s_0)) ** 2
    if drawn is not None:
        inverse *= max(n_draws - len(control) - 1, 1) / n_draws
    through = shown.T @ inverse
    return HeightScores(through @ scores, through @ shown, follows)
