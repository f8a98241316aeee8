"""How precise the points of an adjustment with a robust norm are.

Weights that residuals have chosen are no weights of errors that could be drawn: a large
error has a small weight because it is large. The asymptotic covariance of an M-estimate
(Huber 1981, ch. 7) asks for many observations for each unknown; models have two or
three. So the estimate itself is repeated with drawn errors, linear about the adjusted
block, and its variance is compared with that of least squares by the same errors.

Huber's modified residuals (1981, ch. 7.8) need no other weights than those of least
squares: with residuals v, what is adjusted next are the fitted values plus ψ(v), and
as |ψ'| ≤ 1 each step lowers the sum of ρ(v).
"""

import numpy as np
from scipy.special import chdtri

MOST_STEPS = 60
# of the root mean square of the points, by which the last step may still move them
SETTLED = 1e-2


def variances_by_norm(solution, errors, control_errors, norms, is_in):
    """Sums of squared errors of points by least squares, and by a norm.

    Parameters
    ----------
    solution : AdjustedBlock
        By least squares, the gross errors taken out.
    errors, control_errors : ndarray
        (n_rows, d, n_draws), (n_points, d, n_draws) [m].
    norms : sequence of Norm
        One after the other begins where the last one ends.
    is_in : ndarray of bool, shape (n_rows,)
        What was not taken out.

    Returns
    -------
    tuple of float
        [m²].
    """
    points, residuals = solution.answer_to(errors, control_errors, is_rough=True)
    plain = float(np.sum(points**2))
    given = solution.observations.standard_error.reshape(len(errors), -1, 1)
    # residuals are those of errors, or of their opposites
    sign = np.sign(np.sum(residuals * errors / given**2))
    d = errors.shape[1]
    share = solution.redundancy / (d * np.count_nonzero(is_in))
    of_median = np.sqrt(chdtri(d, 0.5) * share)
    for norm in norms:
        for _ in range(MOST_STEPS):
            length = np.sqrt(((residuals / given) ** 2).sum(axis=1))
            scale = np.median(length[is_in], axis=0) / of_median
            factors = np.where(is_in[:, None], norm.weights(length / scale), 1.0)
            wanted = factors[:, None] * residuals
            modified = errors + sign * (wanted - residuals)
            before = points
            points, found = solution.answer_to(modified, control_errors, is_rough=True)
            residuals = residuals - wanted + found
            step = np.sum((points - before) ** 2)
            if step <= SETTLED**2 * np.sum(points**2):
                break
    return plain, float(np.sum(points**2))
