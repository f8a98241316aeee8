"""Scores of given coordinates, and what points follow of them, along some axes.

What :mod:`.control_heights` and :mod:`.control_in_plan` have in common.
"""

import numpy as np

from einschalt.theory.adjustment.monte_carlo import draws_in_parts


def scores_of_control(solution, away, axes):
    """Weight times correction, (n_axes n_control, n): all of the first axis first.

    ``away`` (n_points, d, n): adjusted less given [m]; of points that are no control
    anything. ``axes`` of 0, 1, 2: easting, northing, height.
    """
    known = solution.observations
    control = np.flatnonzero(known.is_control)
    weight = known.control_weight[control][:, axes]
    scores = -np.einsum("nab,nbk->ank", weight, away[control])
    return scores.reshape(-1, away.shape[-1])


def points_by_control(solution, axes):
    """Points by given coordinates of control, (n_points, n_axes, n_control, n_axes)."""
    known = solution.observations
    control = np.flatnonzero(known.is_control)
    n_rows, d = len(known.model), known.control.shape[1]
    followed = np.zeros((known.n_points, len(axes), len(control), len(axes)))
    for place, axis in enumerate(axes):
        done = 0
        for n_columns in draws_in_parts(len(control), d * n_rows):
            places = np.arange(done, done + n_columns)
            given = np.zeros((known.n_points, d, n_columns))
            given[control[places], axis, np.arange(n_columns)] = 1.0
            moved = solution.answer_to(np.zeros((n_rows, d, n_columns)), given)[0]
            followed[:, :, places, place] = moved[:, axes]
            done += n_columns
    return followed


def known_directions(covariance, least):
    """Eigenvalues and vectors of a covariance of any rank, without what is rounding.

    ``least``: of the largest eigenvalue.
    """
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2.0)
    is_known = values > least * max(values.max(initial=0.0), 0.0)
    return values[is_known], vectors[:, is_known]
