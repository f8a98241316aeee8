"""What is adjusted in space: measured points of spatial models, and control."""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.theory.block_adjustment.observations import (
    BlockObservations,
    ObservedBlock,
)


@dataclass(frozen=True, eq=False, kw_only=True)
class SpatialObservations(ObservedBlock):
    """Observations of a block of spatial models."""

    # (n_rows, 3): model coordinates, in any unit; z points up, by some degrees
    xyz: np.ndarray
    # (n_rows, 3): of measured easting, northing, height on the ground [m]
    standard_error: np.ndarray

    # (n_rows, 3, n_terms): model coordinates by coefficients of 1 of bends that models
    # of a flight share [model units], see shared_bend; None where there are none
    shared_bend: np.ndarray | None = None

    _by_row = ("xyz", "standard_error", "bent", "shared_bend")
    _by_model = ("flight", "model_rank")

    @property
    def xy_in_model(self):
        """Model coordinates in plan, (n_rows, 2)."""
        return self.xyz[:, :2]

    @property
    def is_affine(self):
        """No spatial model is: in plan it is similar to the ground, (n_models,)."""
        return np.zeros(self.n_models, dtype=bool)

    def ties_in_plan(self):
        """Affine models in plan, held by control that has heights as well.

        Models that it determines stand in space: control without a height tells no
        tilt.
        """
        has_height = np.isfinite(self.control[:, 2:])
        control = np.where(has_height, self.control, np.nan)
        return replace(self, control=control).in_plan(is_affine=True)

    def in_plan(self, *, is_affine):
        """Easting and northing alone, in affine models or helmert ones."""
        return BlockObservations(
            model=self.model,
            point=self.point,
            xy=np.ascontiguousarray(self.xyz[:, :2]),
            standard_error=self.standard_error[:, 0],
            is_affine=np.full(self.n_models, is_affine),
            flight=self.flight,
            model_rank=self.model_rank,
            point_rank=self.point_rank,
            control=np.ascontiguousarray(self.control[:, :2]),
            control_covariance=np.ascontiguousarray(self.control_covariance[:, :2, :2]),
        )
