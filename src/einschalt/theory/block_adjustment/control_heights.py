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

from einschalt.theory.adjustment.monte_carlo import draws_in_parts

HEIGHT = 2
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
        Covariance of the scores, as of :func:`scores_of`, by ``n_draws`` draws; that of
        independent observations where left out.

    Notes
    -----
    The inverse of a covariance from N draws of n numbers is too large by
    N / (N - n - 1), which is taken out of it (Hartlap, Simon and Schneider 2007).
    """
    known = solution.observations
    control = np.flatnonzero(known.is_control)
    follows = _followed(solution, control)
    missed = -follows[control]
    missed[np.diag_indices(len(control))] += 1.0
    shown = known.control_weight[control, HEIGHT, HEIGHT][:, None] * missed
    scores = scores_of(solution, solution.control_residuals[:, :, None])[:, 0]
    covariance = (shown + shown.T) / 2.0 if drawn is None else drawn
    inverse = _inverse(covariance) / max(1.0, np.nan_to_num(s_0)) ** 2
    if drawn is not None:
        inverse *= max(n_draws - len(control) - 1, 1) / n_draws
    through = shown.T @ inverse
    return HeightScores(through @ scores, through @ shown, follows)


def scores_of(solution, away):
    """Scores of the heights of control, (n_control, n), adjusted less given away.

    ``away`` (n_points, 3, n) [m]; of points that are no control anything.
    """
    known = solution.observations
    control = np.flatnonzero(known.is_control)
    weight = known.control_weight[control, HEIGHT]
    return -np.einsum("nb,nbk->nk", weight, away[control])


def _followed(solution, control):
    """Heights of all points by those of control, (n_points, n_control)."""
    known = solution.observations
    n_rows, n_axes = len(known.model), known.control.shape[1]
    followed, done = np.zeros((known.n_points, len(control))), 0
    for n_columns in draws_in_parts(len(control), n_axes * n_rows):
        places = np.arange(done, done + n_columns)
        given = np.zeros((known.n_points, n_axes, n_columns))
        given[control[places], HEIGHT, np.arange(n_columns)] = 1.0
        still = np.zeros((n_rows, n_axes, n_columns))
        followed[:, places] = solution.answer_to(still, given)[0][:, HEIGHT]
        done += n_columns
    return followed


def _inverse(covariance):
    """Inverse of a covariance of any rank."""
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2.0)
    is_known = values > LEAST_RANK * max(values.max(initial=0.0), 0.0)
    vectors = vectors[:, is_known]
    return (vectors / values[is_known]) @ vectors.T
