"""Points of which most measurements were taken out as gross errors, and agree.

A gross error that is far larger than the others bends models, and makes the good
measurements of its point look worse than itself. Where all of these are taken out it is
alone, and no test refuses it any more.

See docs/theory/block_adjustment.md.
"""

import numpy as np

AGREES = 6.0  # standard errors of a measurement from the middle of those of its point


def outvoted(residuals, given, is_out):
    """Measurements to change sides, of points that hang on a minority of their own.

    Parameters
    ----------
    residuals : ndarray, shape (n_rows, d)
        Transformed less adjusted coordinates [m].
    given : BlockObservations or SpatialObservations
    is_out : ndarray of bool, shape (n_rows,)
        What was taken out.

    Returns
    -------
    ndarray of bool, shape (n_rows,)
        Measurements that are left, and those that were taken out and agree with each
        other. None of given points, which a contradicted measurement does not place.
    """
    point, n_points = given.point, given.n_points
    n_left = np.bincount(point[~is_out], minlength=n_points)
    n_out = np.bincount(point[is_out], minlength=n_points)
    is_asked = (n_out > np.maximum(n_left, 1)) & ~given.is_given.any(axis=1)
    rows = np.flatnonzero(is_out & is_asked[point])
    if len(rows) == 0:
        return np.zeros_like(is_out)
    rows = rows[np.argsort(point[rows], kind="stable")]
    points, place, n_each = np.unique(
        point[rows], return_inverse=True, return_counts=True
    )
    middle = np.cumsum(n_each) - n_each + n_each // 2
    residuals = residuals[rows]
    error = given.standard_error.reshape(len(point), -1)[rows]
    away = np.zeros(len(rows))
    for axis, values in enumerate(residuals.T):
        median = values[np.lexsort((values, place))][middle]
        away += ((values - median[place]) / error[:, axis % error.shape[1]]) ** 2
    agrees = np.sqrt(away) < AGREES
    n_agree = np.bincount(place[agrees], minlength=len(points))
    is_outvoted = np.zeros(n_points, dtype=bool)
    is_outvoted[points] = n_agree > np.maximum(n_left[points], 1)
    is_other = is_outvoted[point] & ~is_out
    is_other[rows[agrees]] = is_outvoted[point[rows[agrees]]]
    return is_other
