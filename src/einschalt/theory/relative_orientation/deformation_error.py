"""What of an orientation's error no plane transformation of the model takes up.

An error of the orientation moves all points of a model together. The affine
transformation of stage 3 takes up the part that is linear in x and y; the rest bends
the model, and belongs to the error m_g of its points. With the derivatives G of the
plan coordinates by the orientation and the projector P = I - A (A.T A)^-1 A.T of the
columns A = (1, x, y)

    m² = mean over the points of the trace of (P G) C (P G).T,

C being the covariance of the orientation.

See docs/theory/relative_orientation/model_precision.md.
"""

import numpy as np

from einschalt.foundations.batches import segment_sum
from einschalt.theory.relative_orientation.model_correction import correct_model
from einschalt.theory.relative_orientation.parallax_equations import ELEMENTS

# of central differences [rad, bases]: the error is its square, and rounding over it
STEP = 1e-5
# an affine transformation takes up all that three points show
N_AFFINE = 3


def deformation_variance(derivatives, cofactor, xy, start):
    """Mean variance in plan, of x and y together, that an affine transformation leaves.

    ``derivatives`` (n_points, 2, n_parameters) are those of x and y by the parameters
    of the model's orientation, whose cofactors are (n_models, n_parameters,
    n_parameters). NaN where a model has fewer than three points, or all of them on a
    line.
    """
    count = np.diff(start)
    model = np.repeat(np.arange(len(count)), count)
    bent = _without_affine_part(derivatives, xy, start, model)
    # of a root: what an affine transformation takes up leaves rounding, and a product
    # with C may then be less than 0
    spread = np.sum((bent @ roots_of(cofactor)[model]) ** 2, axis=(1, 2))
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = segment_sum(spread, start) / count
    return np.where(count >= N_AFFINE, mean, np.nan)


def roots_of(cofactor):
    """Matrices R with R Rᵀ = Q; NaN where a model is not determined.

    What rounding has made of eigenvalues that are 0 counts as 0.
    """
    roots = np.full(np.shape(cofactor), np.nan)
    is_known = np.isfinite(cofactor).all(axis=(1, 2))
    values, vectors = np.linalg.eigh(cofactor[is_known])
    roots[is_known] = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    return roots


def _without_affine_part(derivatives, xy, start, model):
    n_models = len(start) - 1
    count = np.maximum(np.diff(start), 1)[:, None]
    centred = xy - (segment_sum(xy, start) / count)[model]
    size = np.sqrt(segment_sum((centred**2).sum(axis=1), start) / count[:, 0])
    with np.errstate(invalid="ignore", divide="ignore"):
        columns = np.column_stack([np.ones(len(xy)), centred / size[model][:, None]])
    normals = segment_sum(columns[:, :, None] * columns[:, None, :], start)
    flat = derivatives.reshape(len(xy), np.prod(derivatives.shape[1:]))
    right = segment_sum(columns[:, :, None] * flat[:, None, :], start)
    solved = np.full((n_models, N_AFFINE, flat.shape[1]), np.nan)
    is_good = np.isfinite(normals).all(axis=(1, 2))
    # the columns have the size 1: an eigenvalue near 0 means points on a line
    least = np.zeros(n_models)
    least[is_good] = np.linalg.eigvalsh(normals[is_good])[:, 0] / count[is_good, 0]
    is_good &= least > np.sqrt(np.finfo(float).eps)
    solved[is_good] = np.linalg.solve(normals[is_good], right[is_good])
    taken = np.einsum("nc,ncp->np", columns, solved[model])
    return (flat - taken).reshape(derivatives.shape)


def correction_derivatives(xyz, base, elements, case):
    """Derivatives (n_points, 3, 5) of corrected model points by the elements.

    By central differences, from machine coordinates ``xyz`` (n_points, 3) and base
    (n_points,) and elements (n_points, 5) of the model of each point.
    """
    elements = np.asarray(elements, dtype=float)
    columns = []
    for place, name in enumerate(ELEMENTS[case]):
        # shifts of a centre are lengths
        step = STEP * (base if name.startswith("d_b") else np.ones(len(xyz)))
        change = np.zeros_like(elements)
        change[:, place] = step
        more, less = (
            correct_model(xyz, base, elements + sign * change, case)
            for sign in (1.0, -1.0)
        )
        columns.append((more - less) / (2.0 * step[:, None]))
    return np.stack(columns, axis=2)
