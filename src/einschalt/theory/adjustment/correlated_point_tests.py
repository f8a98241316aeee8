"""Tests of the points of one model whose errors have covariances.

Points that hang on the same few others are wrong together, where these are. Taken for
independent, the first of them, or the first that is not, stands out as a gross error.

Source: Baarda 1968 (observations with any covariance); see docs/theory/reliability.md.
"""

import numpy as np

from einschalt.theory.adjustment.reliability import (
    AXES_OF_A_POINT,
    LEAST_REDUNDANCY_NUMBER,
    PointTests,
)


def correlated_point_tests(residuals, design, covariance) -> PointTests:
    """Test both coordinates of each point together, in the fit of least variance.

    As :func:`~einschalt.theory.adjustment.reliability.joint_point_tests`, which this is
    where the covariance is a multiple of the unit matrix: only the proportions of the
    covariance count, its size is taken from the model.

    Parameters
    ----------
    residuals : ndarray, shape (n_points, 2)
        Of any fit of the model: what the parameters can take up makes no difference.
    design : ndarray, shape (n_points, 2, n_parameters)
        Derivatives of both coordinates by all parameters.
    covariance : ndarray, shape (2 n_points, 2 n_points)
        Of the errors behind the residuals, in any unit; positive definite.

    Returns
    -------
    PointTests
        NaN where the redundancy is 2 or less, where a point is not checked by others,
        and where all residuals vanish.
    """
    n_points, n_parameters = len(residuals), design.shape[2]
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))
    basis = np.linalg.qr(whiten @ design.reshape(-1, n_parameters))[0]
    # rows of what is left of whitened observations beside the parameters
    left = whiten - basis @ (basis.T @ whiten)
    rest = left @ residuals.ravel()
    omega, f = float(rest @ rest), AXES_OF_A_POINT * n_points - n_parameters
    w = np.full(n_points, np.nan)
    if f <= AXES_OF_A_POINT or omega <= 0.0:
        return PointTests(w, w.copy())
    by_point = left.reshape(len(left), n_points, AXES_OF_A_POINT)
    alone = whiten.reshape(by_point.shape)
    weight = np.einsum("kni,knj->nij", by_point, by_point)
    weight_alone = np.einsum("kni,knj->nij", alone, alone)
    numbers = np.linalg.eigvals(np.linalg.solve(weight_alone, weight)).real
    is_checked = numbers.min(axis=1) > LEAST_REDUNDANCY_NUMBER
    errors = np.einsum("kni,k->ni", by_point, rest)[is_checked]
    solved = np.linalg.solve(weight[is_checked], errors[:, :, None])[:, :, 0]
    share = np.minimum(np.sum(errors * solved, axis=1) / omega, 1.0)
    w[is_checked] = np.sqrt(share * f)
    p_value = np.full(n_points, np.nan)
    p_value[is_checked] = (1.0 - share) ** (0.5 * (f - AXES_OF_A_POINT))
    return PointTests(w, p_value)
