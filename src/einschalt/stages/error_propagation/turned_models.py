"""Spatial models that may be turned by more than linear propagation allows for.

Its covariance of a value is that of the tangent at the rotation that was found. A model
on three control points near one line has values that are tens of metres wrong, and what
they leave the tangent by is metres: beside it the weights of a mean would take one
direction across the tangent for one that is known to centimetres.
"""

from dataclasses import dataclass, field

import numpy as np

from einschalt.foundations.batches import over_parts
from einschalt.stages.error_propagation.covariances import (
    covariances_of_pairs,
    identity_of,
)
from einschalt.theory.transformation.second_order import second_order_squares

# points that stand for the parameters of a model: shift; scale, two angles; the third
N_EACH, FIRST, SECOND = 3, 1, 2
ROWS_AT_ONCE = 50_000  # 50 numbers of each, twice: 40 MB


class _Kept:
    """The last covariances that were asked for.

    Matrices of chains and standard errors are told apart by their identity, as in
    ``SharedCovariances``, and must not be changed.
    """

    def __init__(self):
        self._last = None  # set as a whole: other threads leave it whole

    def covariances(self, chains, standard_errors, compute):
        """What ``compute`` gives of these, computed once."""
        sizes = [standard_errors[name] for name in chains]
        key, last = (identity_of(chains), tuple(map(id, sizes))), self._last
        if last is None or last[0] != key:
            # what the key identifies is kept, so that nothing else takes its identity
            last = key, (chains, sizes), compute(chains, standard_errors)
            self._last = last
        return last[2]


@dataclass(frozen=True, eq=False)
class TurnedModels:
    """Models of a flight that was transformed in space, and their points."""

    fit: object  # of helmert_3d
    model: np.ndarray  # (n_values,)
    coordinates: np.ndarray  # (n_values, 3), NaN in models that are not usable
    # covariances of scale and rotation, kept for weights and screening
    kept: _Kept = field(default_factory=_Kept, repr=False)

    def squares(self, chains, standard_errors, rows):
        """Mean products of what values miss the linear by, (n_rows, 3, 3) [m²].

        ``chains`` lead from the sources to the parameters of the models, as
        ``through_parameters`` has them; 0 in models that are not usable.
        """
        found = np.zeros((len(rows), 3, 3))
        is_known = np.isfinite(self.coordinates[rows]).all(axis=1)
        is_known &= np.isfinite(self.fit.scale[self.model[rows]])
        if not is_known.any():
            return found
        covariance = self.kept.covariances(chains, standard_errors, self._of_models)

        def squares(part):
            given = self.model[part], self.coordinates[part], covariance
            return second_order_squares(self.fit, *given)

        known = rows[is_known]
        parts = np.array_split(known, -(-len(known) // ROWS_AT_ONCE))
        found[is_known] = np.concatenate(over_parts(squares, parts))
        return found

    def _of_models(self, chains, standard_errors):
        """Covariances of scale and rotation of all models, (n_models, 4, 4)."""
        used = np.flatnonzero(np.isfinite(self.fit.scale))
        covariance = np.zeros((len(self.fit.scale), 4, 4))
        covariance[used] = _of_scale_and_rotation(chains, standard_errors, used)
        return covariance


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
