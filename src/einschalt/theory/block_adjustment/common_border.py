"""Unknowns that all models of a flight share, at the border of the normal equations."""

from dataclasses import dataclass

import numpy as np

# share of a term that models and other terms must leave of it
LEAST_LEFT = 1e-8


class UndeterminedTermsError(np.linalg.LinAlgError):
    """The points of the models do not determine the common terms."""


@dataclass(frozen=True, eq=False)
class Bordered:
    """What the common parameters add, in the order of elimination; d coordinates."""

    cofactors: np.ndarray  # (n_terms, n_terms)
    # how each moves with each term
    points: np.ndarray  # (n_points, d, n_terms)
    residuals: np.ndarray  # (n_rows, d, n_terms)
    unknowns: np.ndarray  # (n_models, n_unknowns, n_terms)

    def with_spread(self, own, motion):
        """Cofactors with what follows from those of the common parameters."""
        if len(self.cofactors) == 0:
            return own
        return own + motion @ self.cofactors @ np.swapaxes(motion, 1, 2)


def normals_of_common(on_ground, weights, residuals):
    """Normal equations of common terms, and what they are before models take part.

    Parameters
    ----------
    on_ground : ndarray, shape (n_rows, d, n_terms)
        What each term does to the observations [m].
    weights : ndarray, shape (n_rows, d or 1)
    residuals : ndarray, shape (n_rows, d, n_terms)
        What is left of that after the block has taken up what it can [m].

    Returns
    -------
    normals : ndarray, shape (n_terms, n_terms)
    whole : ndarray, shape (n_terms,)
        Diagonal of them if models took up nothing.
    """
    weighted = on_ground * weights[:, :, None]
    normals = np.tensordot(weighted, residuals, axes=((0, 1), (0, 1)))
    return (normals + normals.T) / 2.0, np.einsum("ncj,ncj->j", weighted, on_ground)


def inverse_of_common(normals, whole):
    """Cofactors of common terms, of which the models have left this much.

    ``whole`` is the diagonal before the models took up what they can. An
    UndeterminedTermsError where they have left nothing.
    """
    size = np.sqrt(np.where(whole > 0.0, whole, 1.0))
    scaled = normals / np.outer(size, size)
    # eigenvalues of what is no number are an error of another kind
    is_finite = np.isfinite(scaled).all()
    if not is_finite or np.linalg.eigvalsh(scaled)[0] <= LEAST_LEFT:
        raise UndeterminedTermsError("the points do not determine the common terms")
    return np.linalg.inv(scaled) / np.outer(size, size)
