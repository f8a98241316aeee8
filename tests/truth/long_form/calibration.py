"""How errors compare with the covariance that is claimed for them."""

import numpy as np
from scipy.stats import chi2
from tests.truth.long_form.figures import ratio, root_of_ratio

PLANE = ["easting", "northing"]
LEVEL = 0.95
HEAD = ("squared error", "in 95 % ellipse", "claimed/true")
NORMALISED = {"low": 0.97, "high": 1.03}
INSIDE = {"low": 0.940, "high": 0.960}
ROOT_MEAN_SQUARE = {"low": 0.98, "high": 1.02}


def errors_of(points, truth):
    """Errors of points with known truth.

    Parameters
    ----------
    points : DataFrame
        point_id, easting, northing.
    truth : DataFrame

    Returns
    -------
    ndarray, shape (n_points, 2)
        [m]
    """
    true = truth.set_index("point_id").loc[points["point_id"], PLANE].to_numpy()
    return points[PLANE].to_numpy() - true


def sums_of(error, covariance):
    """What one block contributes.

    Parameters
    ----------
    error : ndarray, shape (n, 2)
    covariance : ndarray, shape (n, 2, 2)
        That is claimed.

    Returns
    -------
    ndarray, shape (5,)
        Number, normalised squared error over 2, inside the ellipse, claimed and true
        variance.
    """
    solved = np.linalg.solve(covariance, error[:, :, None])[:, :, 0]
    squares = np.sum(error * solved, axis=1)
    claimed = np.trace(covariance, axis1=1, axis2=2)
    inside = np.count_nonzero(squares < chi2.ppf(LEVEL, 2))
    return np.array(
        [len(error), squares.sum() / 2.0, inside, claimed.sum(), np.sum(error**2)]
    )


def figures_of(sums, *, judged=True):
    """Figures under :data:`HEAD` from the sums of many blocks.

    Parameters
    ----------
    sums : sequence of ndarray
    judged : bool
        Whether the bounds hold for them.

    Returns
    -------
    tuple of Figure
    """
    count, squares, inside, claimed, true = np.transpose(sums)
    bounds = (NORMALISED, INSIDE, ROOT_MEAN_SQUARE) if judged else ({}, {}, {})
    return (
        ratio(squares, count, **bounds[0]),
        ratio(inside, count, **bounds[1]),
        root_of_ratio(claimed, true, **bounds[2]),
    )
