"""How errors of measured y-parallaxes reach the points of their models.

The parallaxes of a model give five elements with errors of their own, and every point
of the model is corrected with them: all its points share five errors. Their size comes
from sigma_0 of all models together, since one model has hardly any redundancy.

See docs/theory/propagation.md.
"""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode_pairs
from einschalt.stages.relative_orientation.parallax_orientation import (
    models_frame,
    places_of_models,
)
from einschalt.theory.adjustment.least_squares import pool_standard_errors
from einschalt.theory.relative_orientation.deformation_error import (
    correction_derivatives,
    roots_of,
)


@dataclass(frozen=True, eq=False)
class OrientationErrors:
    """Errors that points of a model share by its orientation."""

    model: np.ndarray  # (n_points,): orientation of each model point
    # (n_points, 3, 5): coordinates by five independent errors of variance 1, in the
    # unit of the model points
    factors: np.ndarray
    n_models: int
    # of all parallaxes from which their size comes: its variance is known to √(2 /
    # redundancy) of itself
    redundancy: int

    def of_rows(self, is_kept: np.ndarray) -> "OrientationErrors":
        """Those of some of the points."""
        return replace(self, model=self.model[is_kept], factors=self.factors[is_kept])


def parallax_errors(orientation, machine_points) -> OrientationErrors | None:
    """Derive how the errors of the parallaxes move corrected points.

    ``machine_points`` are x, y, z as they were read, of models that were oriented, in
    the unit of the orientation. None where no model has redundancy: then the size of
    the errors is not known.
    """
    models, adjustment = orientation.models, orientation.adjustment
    is_checked = np.isfinite(adjustment.sigma_0) & (adjustment.redundancy > 0)
    if not is_checked.any():
        return None
    redundancy = adjustment.redundancy[is_checked]
    size = pool_standard_errors(adjustment.sigma_0[is_checked], redundancy)
    model = _models_of(orientation, machine_points)
    derivatives = correction_derivatives(
        values_of(machine_points, ["x", "y", "z"]),
        models["base"].to_numpy(dtype=float)[model],
        adjustment.elements[model],
        orientation.case,
    )
    # 0 where a model is not determined
    roots = size * np.nan_to_num(roots_of(adjustment.cofactor))
    factors = np.einsum("nak,nkj->naj", derivatives, roots[model])
    return OrientationErrors(model, factors, len(models), int(redundancy.sum()))


def _models_of(orientation, points):
    codes = encode_pairs(points["coverage"], points["model_id"])
    wanted = models_frame(codes.names)
    if not orientation.has_coverages:
        wanted = wanted.drop(columns="coverage")
    place, _ = places_of_models(wanted, orientation.models)
    return place[codes.codes]
