"""Spatial models that may be turned by more than linear propagation allows for.

Its covariance of a value is that of the tangent at the rotation that was found. A model
on three control points near one line has values that are tens of metres wrong, and what
they leave the tangent by is metres: beside it the weights of a mean would take one
direction across the tangent for one that is known to centimetres.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.stages.error_propagation.covariances import covariances_of_pairs
from einschalt.theory.transformation.second_order import second_order_squares

# points that stand for the parameters of a model: shift; scale, two angles; the third
N_EACH, FIRST, SECOND = 3, 1, 2


@dataclass(frozen=True, eq=False)
class TurnedModels:
    """Models of a flight that was transformed in space, and their points."""

    fit: object  # of helmert_3d
    model: np.ndarray  # (n_values,)
    coordinates: np.ndarray  # (n_values, 3), NaN in models that are not usable

    def squares(self, chains, standard_errors, rows):
        """Mean products of what values miss the linear by, (n_rows, 3, 3) [m²].

        ``chains`` lead from the sources to the parameters of the models, as
        ``through_parameters`` has them; 0 in models that are not usable.
        """
        found = np.zeros((len(rows), 3, 3))
        is_known = np.isfinite(self.coordinates[rows]).all(axis=1)
        is_known &= np.isfinite(self.fit.scale[self.model[rows]])
        used, model = np.unique(self.model[rows[is_known]], return_inverse=True)
        if len(used) == 0:
            return found
        covariance = np.zeros((len(self.fit.scale), 4, 4))
        covariance[used] = _of_scale_and_rotation(chains, standard_errors, used)
        found[is_known] = second_order_squares(
            self.fit, used[model], self.coordinates[rows[is_known]], covariance
        )
        return found


def _of_scale_and_rotation(chains, standard_errors, models):
    """Covariances of scale and rotation of some models, (n, 4, 4)."""
    places = N_EACH * models[:, None] + [FIRST, SECOND]
    pairs = places[:, [[0, 0], [1, 0], [1, 1]]].reshape(-1, 2)
    blocks = covariances_of_pairs(chains, standard_errors, pairs)
    first, across, last = blocks.reshape(-1, 3, 3, 3).swapaxes(0, 1)
    found = np.empty((len(models), 4, 4))
    found[:, :3, :3], found[:, 3, 3] = first, last[:, 0, 0]
    found[:, 3, :3] = found[:, :3, 3] = across[:, 0]
    return found
