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
    residuals : ndarray, shape (..., n_points, 2)
        Of any fit of the model: what the parameters can take up makes no difference.
    design : ndarray, shape (..., n_points, 2, n_parameters)
        Derivatives of both coordinates by all parameters, finite.
    covariance : ndarray, shape (..., 2 n_points, 2 n_points)
        Of the errors behind the residuals, in any unit; positive definite. Models of as
        many points may be stacked.

    Returns
    -------
    PointTests
        NaN where the redundancy is 2 or less, where a point is not checked by others,
        and where all residuals vanish.
    """
    n_points, n_axes, n_parameters = design.shape[-3:]
    flat = (*design.shape[:-3], n_points * n_axes)
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))
    basis = np.linalg.qr(whiten @ design.reshape(*flat, n_parameters))[0]
    # rows of what is left of whitened observations beside the parameters
    left = whiten - basis @ (np.swapaxes(basis, -1, -2) @ whiten)
    rest = (left @ residuals.reshape(*flat, 1))[..., 0]
    omega = np.sum(rest**2, axis=-1, keepdims=True)
    f = n_axes * n_points - n_parameters
    w = np.full((*flat[:-1], n_points), np.nan)
    p_value = w.copy()
    if f <= AXES_OF_A_POINT:
        return PointTests(w, p_value)
    by_point = (*flat, n_points, n_axes)
    left, alone = left.reshape(by_point), whiten.reshape(by_point)
    weight = np.einsum("...kni,...knj->...nij", left, left)
    weight_alone = np.einsum("...kni,...knj->...nij", alone, alone)
    numbers = np.linalg.eigvals(np.linalg.solve(weight_alone, weight)).real
    is_checked = (numbers.min(axis=-1) > LEAST_REDUNDANCY_NUMBER) & (omega > 0.0)
    errors = np.einsum("...kni,...k->...ni", left, rest)[is_checked]
    solved = np.linalg.solve(weight[is_checked], errors[:, :, None])[:, :, 0]
    of_model = np.broadcast_to(omega, is_checked.shape)[is_checked]
    share = np.minimum(np.sum(errors * solved, axis=1) / of_model, 1.0)
    w[is_checked] = np.sqrt(share * f)
    p_value[is_checked] = (1.0 - share) ** (0.5 * (f - AXES_OF_A_POINT))
    return PointTests(w, p_value)
