"""What errors of rotation and scale make of points beyond the linear.

A model that hangs on points near one line may be turned about that line by a tenth of a
radian. Its points then leave the tangent along which linear propagation lets them
move: to the second order by

    e = δλ (ω × R d) + ½ ω × (ω × λ R d)

with the errors δλ of the scale and ω of the rotation (small angles about easting,
northing and height) and the position d in the model from its weighted centroid. With
normal errors of the covariance Σ, and e_k = ½ pᵀ H_k p for p = (δλ, ω),

    E(e_k e_l) = ¼ (tr H_k Σ · tr H_l Σ + 2 tr H_k Σ H_l Σ).

Source: Isserlis 1918, for the moments of the fourth order.
"""

import numpy as np

from einschalt.theory.transformation.sensitivity import sensitivity

# a rotation, however large, moves no point by more than its distance twice
FARTHEST = 2.0


def second_order_squares(fit, model, coordinates, covariance):
    """Mean products of the errors of the second order of points in spatial models.

    Parameters
    ----------
    fit : SpatialFit
        Of ``helmert_3d``.
    model : ndarray of int, shape (n,)
    coordinates : ndarray, shape (n, 3)
        Positions in the models.
    covariance : ndarray, shape (n_models, 4, 4)
        Of scale and rotation.

    Returns
    -------
    ndarray, shape (n, 3, 3)
        E(e eᵀ) [m²].
    """
    design = sensitivity(fit, model, coordinates)
    x = fit.scale[model][:, None] * design[:, :, 0]
    hessian = np.zeros((len(x), 3, 4, 4))
    of_both = design[:, :, 1:] / fit.scale[model][:, None, None]
    hessian[:, :, 0, 1:] = hessian[:, :, 1:, 0] = of_both
    outer = np.einsum("ki,nj->nkij", np.eye(3), x)
    hessian[:, :, 1:, 1:] = (outer + outer.swapaxes(2, 3)) / 2.0
    hessian[:, :, 1:, 1:] -= np.einsum("nk,ij->nkij", x, np.eye(3))
    turned = hessian @ covariance[model][:, None]
    trace = np.einsum("nkii->nk", turned)
    found = trace[:, :, None] * trace[:, None, :]
    found += 2.0 * np.einsum("nkij,nlji->nkl", turned, turned)
    found /= 4.0
    return found * _within_reach(found, x)[:, None, None]


def _within_reach(squares, x):
    """Factors by which squares are no larger than a rotation can make them."""
    size = np.trace(squares, axis1=1, axis2=2)
    reach = FARTHEST**2 * np.sum(x**2, axis=1)
    return np.minimum(1.0, reach / np.where(size > 0.0, size, 1.0))
