"""One transformation that is published, whatever result it comes from."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
import pyproj
from scipy.spatial import ConvexHull

from einschalt.foundations.published_systems import (
    affine_method,
    affine_step,
    pipeline_method,
)
from einschalt.theory.residual_distribution.shift_grid import ShiftGrid
from einschalt.theory.triangulation.triangle_net import TriangleNet

LEAST_WIDTH = 1e-6  # of the length of a set of points: those of less lie in a line


@dataclass(frozen=True, eq=False)
class PublishedOperation:
    """A transformation from a plane frame of its own into a plane system.

    In plan it is affine, or its residuals are distributed: linear in triangles, or by a
    grid of shifts on top of the affine part. In space it is affine.
    """

    code: str  # by which files and databases name it
    title: str  # what people read
    model: str  # the model that it transforms, empty where there is only one
    matrix: np.ndarray  # both of the affine part: ground = matrix · xyz + shift
    shift: np.ndarray
    # source, target: (n, 2) or (n, 3), identical points
    source: np.ndarray
    target: np.ndarray
    accuracy_m: float  # TOTAL, of held-out points, or propagated where that is more
    n_held_out: int
    frame: pyproj.CRS  # from which it leads
    system: pyproj.CRS  # into which, easting before northing
    area: tuple | None  # west, south, east, north [degrees]
    given_net: TriangleNet | None = None
    grid: ShiftGrid | None = None
    left_out: pd.DataFrame | None = None
    # TOTAL, of held-out points, where ``accuracy_m`` may be another [m]
    missed_m: float | None = None

    @property
    def error_at_held_out(self):
        """By how much it misses points that were held out, TOTAL [m]."""
        return self.accuracy_m if self.missed_m is None else self.missed_m

    @property
    def is_distributed(self):
        """Whether residuals are distributed."""
        return self.given_net is not None or self.grid is not None

    @property
    def is_plane(self):
        """Whether it is a transformation in plan."""
        return self.matrix.shape == (2, 2)

    @cached_property
    def net(self):
        """Triangles that hold its domain: TriangleNet, None in space and of a grid.

        Of an affine transformation those of the hull of its points, all alike; None
        where these lie in a line.
        """
        if self.is_distributed or not self.is_plane:
            return self.given_net
        away = self.source - self.source.mean(axis=0)
        along, across = np.linalg.svd(away, compute_uv=False)
        if not across > LEAST_WIDTH * along:
            return None
        hull = self.source[ConvexHull(away).vertices]
        after = np.arange(1, len(hull) - 1)
        fan = np.column_stack([np.zeros_like(after), after, after + 1])
        return TriangleNet(hull, self.affine(hull), fan)

    @property
    def affine_step(self):
        """Step of a PROJ pipeline for the affine part."""
        return affine_step(self.matrix, self.shift)

    def affine(self, xyz):
        """The affine part, of points (n, 2) or (n, 3)."""
        return xyz @ self.matrix.T + self.shift

    def apply(self, xyz):
        """Target coordinates of points; NaN outside of its triangles or grid."""
        if self.grid is not None:
            return self.grid.apply(xyz)
        if self.given_net is not None:
            return self.given_net.apply(xyz)
        return self.affine(xyz)

    @property
    def unit_m(self):
        """What a unit of the source is in the target [m]."""
        return float(np.abs(np.linalg.det(self.matrix)) ** (1.0 / len(self.matrix)))

    def method(self, step):
        """Method and parameters, as WKT has them; ``step`` of a PROJ pipeline."""
        if self.is_plane and not self.is_distributed:
            return affine_method(self.matrix, self.shift)
        return pipeline_method(step)
