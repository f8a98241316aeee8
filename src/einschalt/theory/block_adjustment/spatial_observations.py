"""What is adjusted in space: measured points of spatial models, and control."""

from dataclasses import dataclass

import numpy as np

from einschalt.theory.block_adjustment.observations import (
    BlockObservations,
    ObservedBlock,
)


@dataclass(frozen=True, eq=False)
class SpatialObservations(ObservedBlock):
    """Observations of a block of spatial models, sorted by model.

    Attributes
    ----------
    model, point : ndarray of int64, shape (n_rows,)
        Every point from 0 to n_points − 1 occurs.
    xyz : ndarray, shape (n_rows, 3)
        Model coordinates, in any unit; z points up, by some degrees.
    standard_error : ndarray, shape (n_rows, 3)
        Of measured easting, northing, height on the ground [m].
    flight : ndarray of int64, shape (n_models,)
    control : ndarray, shape (n_points, 3)
        Given easting, northing, height [m]; NaN where a point is no control.
    control_covariance : ndarray, shape (n_points, 3, 3)
        Of the given coordinates [m²]; 0 where they are to be held.
    """

    model: np.ndarray
    point: np.ndarray
    xyz: np.ndarray
    standard_error: np.ndarray
    flight: np.ndarray
    control: np.ndarray
    control_covariance: np.ndarray

    _by_row = ("xyz", "standard_error")
    _by_model = ("flight",)

    @property
    def is_control(self):
        """Which points have given coordinates."""
        return np.isfinite(self.control).all(axis=1)

    @property
    def is_fixed(self):
        """Which of them are held."""
        return self.is_control & ~self.control_covariance.any(axis=(1, 2))

    def in_plan(self, *, is_affine):
        """Easting and northing alone.

        Parameters
        ----------
        is_affine : bool
            Whether the models are to be affine in plan, or helmert.

        Returns
        -------
        BlockObservations
        """
        return BlockObservations(
            model=self.model,
            point=self.point,
            xy=np.ascontiguousarray(self.xyz[:, :2]),
            standard_error=self.standard_error[:, 0],
            is_affine=np.full(self.n_models, is_affine),
            flight=self.flight,
            control=np.ascontiguousarray(self.control[:, :2]),
            control_covariance=np.ascontiguousarray(self.control_covariance[:, :2, :2]),
        )
