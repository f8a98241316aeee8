"""The affinity of models: how much longer they are along x than along y, and shear.

An affine transformation A of a model onto the ground is a rotation, a scale and a small
symmetric part without trace,

    A = s R (I + S),    S = [[p, q], [q, -p]].

Film, lens or machine give all models of a flight the same p and q; errors of measuring
and of ground coordinates scatter them. Both follow from AᵀA, and are linear in these
errors up to terms of second order.

See docs/theory/systematic_patterns.md.
"""

import numpy as np


def affine_matrices(moments):
    """Affine matrices of models, whatever kind of transformation they were given.

    A, ground from model, and the inverse of the moments Σ w d dᵀ, both
    (n_models, 2, 2); NaN where the points of the model determine none.
    """
    m = moments.model_model
    determinant = moments.determinant
    # nearly on a line, the shape of the model is unknown
    is_known = (moments.n_points >= 3) & (determinant > 1e-6 * moments.polar**2)
    safe = np.where(is_known, determinant, np.nan)
    inverse = np.empty_like(m)
    inverse[:, 0, 0], inverse[:, 1, 1] = m[:, 1, 1] / safe, m[:, 0, 0] / safe
    inverse[:, 0, 1] = inverse[:, 1, 0] = -m[:, 0, 1] / safe
    matrix = np.swapaxes(inverse @ moments.model_ground, 1, 2)
    return matrix, inverse


def model_affinities(matrix):
    """Affinity p, q (n_models, 2) of matrices A (n_models, 2, 2), ground from model.

    Examples
    --------
    >>> turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    >>> model_affinities(8.0 * turn @ [[[1.0001, 2e-5], [2e-5, 0.9999]]]).round(9)
    array([[1.e-04, 2.e-05]])
    """
    g = np.swapaxes(matrix, 1, 2) @ matrix
    trace = g[:, 0, 0] + g[:, 1, 1]
    difference = (g[:, 0, 0] - g[:, 1, 1]) / 2.0
    # all points of such a model lie in one place: it tells nothing
    trace = np.where(trace > 0.0, trace, np.nan)
    return np.stack([difference, g[:, 0, 1]], axis=1) / trace[:, None]


def affinity_derivatives(points, moments):
    """Derivatives (n_points, 2, 2) of each model's p and q by errors of its points.

    Of p and of q (first index) by ground coordinates less transformed model
    coordinates, in easting and northing (second) [1/m]. ``points`` are those that were
    fitted.
    """
    model = points.model
    matrix, inverse = affine_matrices(moments)
    back = _inverse(matrix)[model]
    d = points.source - moments.centroid_model[model]
    pull = np.einsum("nij,nj->ni", inverse[model], d) * points.weights[:, None] / 2.0
    of_p = pull[:, :1] * back[:, 0] - pull[:, 1:] * back[:, 1]
    of_q = pull[:, 1:] * back[:, 0] + pull[:, :1] * back[:, 1]
    return np.stack([of_p, of_q], axis=1)


def _inverse(matrix):
    a, b = matrix[:, 0, 0], matrix[:, 0, 1]
    c, d = matrix[:, 1, 0], matrix[:, 1, 1]
    rows = np.stack([np.stack([d, -b], -1), np.stack([-c, a], -1)], -2)
    determinant = a * d - b * c
    # points on a line: nothing to invert
    determinant = np.where(determinant != 0.0, determinant, np.nan)
    return rows / determinant[:, None, None]
