"""Where spatial models stand before they are adjusted: plan first, then heights.

Models stand upright but for some degrees. So helmert in plan gives their scale and
direction; with the scale known, heights are linear in a shift and two slopes,

    H = h + α x + β y + s z,

and the slopes are the tilts. Both adjust all models at once, and a block that has
little control needs no chain of models to begin with.
"""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.theory.block_adjustment.axis_coupling import Channels, reduce_models
from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.solver import build_solver

# sine of the steepest tilt that a start may have
STEEPEST = 0.9


@dataclass(frozen=True, eq=False)
class Placement:
    """Spatial models on the ground: centre + scale · rotation · (xyz − centroid)."""

    centroid: np.ndarray  # (n_models, 3): in the model
    centre: np.ndarray  # (n_models, 3): on the ground, from the origin [m]
    scale: np.ndarray  # (n_models,)
    rotation: np.ndarray  # (n_models, 3, 3)
    # (3,): easting, northing, height from which the ground is counted [m]
    origin: np.ndarray

    @property
    def matrix(self):
        """Ground from model, shape (n_models, 3, 3)."""
        return self.scale[:, None, None] * self.rotation

    def arranged(self, arrange):
        """Put the models into another order by a function of their arrays."""
        names = ("centroid", "centre", "scale", "rotation")
        return replace(self, **{name: arrange(getattr(self, name)) for name in names})


def place_models(observations) -> Placement:
    """Place all models, well enough to begin with; the block is determined in plan."""
    plan = adjust(observations.in_plan(is_affine=False))
    east_x, north_x = plan.affinities[:, :, 1].T
    scale = np.hypot(east_x, north_x)
    centroid = _centroids(observations)
    centre = plan.affinities[:, :, 0] + np.einsum(
        "nij,nj->ni", plan.affinities[:, :, 1:], centroid[:, :2]
    )
    height, slope, origin_height = _heights(
        observations, plan.ordering, scale, centroid[:, 2]
    )
    up = slope / scale[:, None]
    length = np.linalg.norm(up, axis=1)
    up *= np.minimum(1.0, STEEPEST / np.maximum(length, STEEPEST))[:, None]
    origin = np.append(centre.mean(axis=0), origin_height)
    return Placement(
        centroid=centroid,
        centre=np.column_stack([centre - origin[:2], height]),
        scale=scale,
        rotation=_tilted(east_x / scale, north_x / scale, up),
        origin=origin,
    )


def _centroids(observations):
    model, n_models = observations.model, observations.n_models
    xy, z = np.ascontiguousarray(observations.xyz[:, :2]), observations.xyz[:, 2]
    frames = reduce_models(xy, model, n_models)[1]
    first = np.zeros(n_models)
    first[model] = z
    above = np.bincount(model, z - first[model], n_models)
    count = np.bincount(model, minlength=n_models)
    return np.column_stack([frames.centroid, first + above / count])


def _heights(observations, ordering, scale, z_of_centroid):
    """Height of each centroid from a mean height, and slopes per model unit."""
    rows, points = ordering.reordered.rows, ordering.reordered.points
    incidence, order = ordering.reordered.incidence, ordering.order
    given = observations.control[points, 2]
    is_control = np.isfinite(given)
    origin = float(given[is_control].mean())
    weight = np.zeros((len(points), 2, 2))
    weight[:, 0, 0] = observations.control_weight[points, 2, 2]
    z = observations.xyz[rows, 2] - z_of_centroid[order][incidence.model]
    xy = np.ascontiguousarray(observations.xyz[rows, :2])
    reduced, frames = reduce_models(xy, incidence.model, incidence.n_models)
    solver = build_solver(
        ordering,
        reduced,
        observations.standard_error[rows, 2] ** -2.0,
        (weight, observations.is_fixed[points] & is_control),
        Channels(np.ones(incidence.n_models, dtype=bool), is_coupled=False),
    )
    found = solver.project(
        -(scale[order][incidence.model] * z)[:, None, None],
        np.where(is_control, given - origin, 0.0)[:, None, None],
    ).parameters[:, :, 0]
    height, slope = np.empty(len(order)), np.empty((len(order), 2))
    height[order] = found[:, 0]
    slope[order] = found[:, 1:] / frames.extent[:, None]
    return height, slope, origin


def _tilted(cosine, sine, up):
    """Rotations whose last row is given, as near to a direction in plan as can be.

    Cosine and sine are those of the direction of the model's x-axis on the ground, from
    easting; ``up`` (n, 2) is the first two elements of the last row.
    """
    third = np.column_stack([up, np.sqrt(1.0 - (up**2).sum(axis=1))])
    first = np.column_stack([cosine, -sine, np.zeros(len(up))])
    first -= np.sum(first * third, axis=1)[:, None] * third
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(third, first), third], axis=1)
