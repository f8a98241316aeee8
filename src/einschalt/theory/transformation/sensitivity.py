"""How the ground coordinates of a point move with the parameters of its model.

With the parameters taken at the weighted centroid, shift and the rest (rotation,
scale, shear) are uncorrelated, and the whole hat matrix of a model is

    H_ij = w_j (I / Σw + D_i Q D_jᵀ),

D the sensitivity of a point to the rest and Q their cofactors. It needs no more than
the fits already hold, for every kind of transformation.
"""

import numpy as np

from einschalt.theory.transformation.plane_fit import without_unusable

CONFORMAL = ("affine", "helmert")


def conformal_sensitivity(fit, model, xy):
    """The same for one complex ground coordinate E + iN, where that is enough.

    Helmert is linear in complex numbers, and affine treats easting and northing alike:
    both need a quarter of the numbers. (n, 1, n_rest), real for affine (x, y), complex
    for helmert (x + iy).
    """
    d = xy - fit.centroid_model[model]
    if fit.kind == "affine":
        return d[:, None, :]
    return (d[:, 0] + 1j * d[:, 1])[:, None, None]


def conformal_cofactors(fit):
    """Cofactors (n_models, n_rest, n_rest) for :func:`conformal_sensitivity`."""
    spread = fit.solution.spread_east
    return spread if fit.kind == "affine" else spread[:, :1, :1]


def sensitivity(fit, model, coordinates):
    """Derivatives of ground coordinates by the parameters other than the shift.

    For any points of the models ``model`` (n,): (n, n_coordinates, n_rest).
    """
    return _SENSITIVITY[fit.kind](fit, model, coordinates)


def cofactors_of_rest(fit):
    """Cofactors (n_models, n_rest, n_rest) of these parameters, at the centroid."""
    return _COFACTORS[fit.kind](fit)


def _affine(fit, model, xy):
    d = xy - fit.centroid_model[model]
    table = np.zeros((len(d), 2, 4))
    table[:, 0, :2] = table[:, 1, 2:] = d
    return table


def _affine_cofactors(fit):
    half = fit.solution.spread_east
    cofactors = np.zeros((len(half), 4, 4))
    cofactors[:, :2, :2] = cofactors[:, 2:, 2:] = half
    return cofactors


def _helmert(fit, model, xy):
    x, y = (xy - fit.centroid_model[model]).T
    return np.stack([np.stack([x, -y], -1), np.stack([y, x], -1)], -2)


def _helmert_cofactors(fit):
    return fit.solution.spread_east


def _rigid(fit, model, xy):
    d = xy - fit.centroid_model[model]
    x, y = np.einsum("nij,nj->in", fit.linear[model], d)
    return np.stack([-y, x], -1)[:, :, None]


def _rigid_cofactors(fit):
    with np.errstate(divide="ignore"):
        cofactors = 1.0 / fit.moments.polar[:, None, None]
    return without_unusable(cofactors, fit.status)


def _helmert_3d(fit, model, xyz):
    d = xyz - fit.centroid_model[model]
    turned = np.einsum("nij,nj->ni", fit.rotation[model], d)
    x, y, z = (fit.scale[model][:, None] * turned).T
    zero = np.zeros_like(x)
    # columns: scale, then small rotations about easting, northing, height
    rows = (
        [turned[:, 0], zero, z, -y],
        [turned[:, 1], -z, zero, x],
        [turned[:, 2], y, -x, zero],
    )
    return np.stack([np.stack(row, -1) for row in rows], -2)


def _helmert_3d_cofactors(fit):
    cofactors = np.zeros((len(fit.scale), 4, 4))
    cofactors[:, 0, 0] = fit.cofactor_scale
    cofactors[:, 1:, 1:] = fit.cofactor_rotation
    return cofactors


_SENSITIVITY = {
    "affine": _affine,
    "helmert": _helmert,
    "rigid": _rigid,
    "helmert_3d": _helmert_3d,
}
_COFACTORS = {
    "affine": _affine_cofactors,
    "helmert": _helmert_cofactors,
    "rigid": _rigid_cofactors,
    "helmert_3d": _helmert_3d_cofactors,
}
