"""Tests of single heights of spatial models.

A similarity in space shares its scale and its angles between plan and height, so that
its squares of heights belong to no whole number of degrees of freedom. But whatever it
is, heights of a model are shifted, tilted and enlarged by it, and nothing else: what is
left of its residuals in height beside a shift, two tilts and a scale are those of a
linear adjustment of heights alone, whose tests are exact.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import segment_sum
from einschalt.theory.adjustment.reliability import (
    LEAST_REDUNDANCY_NUMBER,
    prediction_p_value,
    tau_p_value,
)

HEIGHT = 2  # the axis
# of the squares of normalized columns: flat ground tells no scale of heights
LEAST_EIGENVALUE = 1e-12


@dataclass(frozen=True, eq=False)
class _HeightFit:
    """Shift, tilts and scale that the residuals in height of each model still hold."""

    centre: np.ndarray  # (n_models, 3)
    size: np.ndarray  # (n_models, 3): of the offsets from it
    parameters: np.ndarray  # (n_models, 4)
    cofactors: np.ndarray  # (n_models, 4, 4)
    sum_of_squares: np.ndarray  # (n_models,)
    redundancy: np.ndarray  # (n_models,)

    def design(self, model, ground):
        """Shift, tilts and scale at some points, (n, 4)."""
        offset = (ground - self.centre[model]) / self.size[model]
        return np.column_stack([np.ones(len(offset)), offset])

    def left(self, model, design, heights):
        """What is left of differences in height, and its cofactors by the fit."""
        left = heights - np.sum(design * self.parameters[model], axis=1)
        cofactors = np.einsum("ni,nij,nj->n", design, self.cofactors[model], design)
        return left, cofactors


def fitted_height_tests(fit, points):
    """Probability of the height of every point that was fitted: Pope's τ.

    NaN where the model has too few heights to tell, or others do not check this one.
    """
    heights = fit.residuals[:, HEIGHT]
    found, left, cofactors = _fit_heights(points, heights)
    f = np.where(found.redundancy > 0.0, found.redundancy, np.nan)[points.model]
    r = 1.0 - points.weights * cofactors
    r = np.where(r > LEAST_REDUNDANCY_NUMBER, r, np.nan)
    squares = found.sum_of_squares[points.model]
    squares = np.where(squares > 0.0, squares, np.nan)
    share = np.minimum(points.weights * left**2 / r / squares, 1.0)
    return tau_p_value(np.sqrt(share * f), f)


def other_height_tests(fit, in_fit, model, points):
    """Probability of the height of points that took no part in the fit: Student's t.

    ``in_fit`` are the points that did, ``model`` (n,) is that of each row.
    """
    missed = fit.apply(in_fit.model, in_fit.source) - in_fit.target
    found, *_ = _fit_heights(in_fit, missed[:, HEIGHT])
    missed = (fit.apply(model, points.source) - points.target)[:, HEIGHT]
    design = found.design(model, points.target)
    left, cofactors = found.left(model, design, missed)
    squares = left**2 / (cofactors + 1.0 / points.weights)
    return prediction_p_value(
        squares, found.sum_of_squares[model], found.redundancy[model]
    )


def _fit_heights(points, heights):
    """Fit shift, tilts and scale: _HeightFit, what is left, and its cofactors."""
    start, weights, model = points.start, points.weights, points.model
    count = np.maximum(np.diff(start), 1)[:, None]
    centre = segment_sum(points.target, start) / count
    squares = segment_sum((points.target - centre[model]) ** 2, start) / count
    size = np.where(squares > 0.0, np.sqrt(squares), 1.0)
    found = _HeightFit(centre, size, *(None,) * 4)
    design = found.design(model, points.target)
    weighted = weights[:, None] * design
    normal = segment_sum(weighted[:, :, None] * design[:, None, :], start)
    cofactors, rank = _inverse(normal)
    right = segment_sum(weighted * heights[:, None], start)
    parameters = np.einsum("kij,kj->ki", cofactors, right)
    found = _HeightFit(centre, size, parameters, cofactors, None, None)
    left, of_points = found.left(model, design, heights)
    sums = segment_sum(weights * left**2, start)
    redundancy = (np.diff(start) - rank).astype(float)
    found = _HeightFit(centre, size, parameters, cofactors, sums, redundancy)
    return found, left, of_points


def _inverse(normal):
    """Inverses of normal matrices of any rank (n_models, 4, 4), and these ranks."""
    values, vectors = np.linalg.eigh(normal)
    is_determined = values > LEAST_EIGENVALUE * values[:, -1:]
    inverse = np.where(is_determined, 1.0 / np.where(is_determined, values, 1.0), 0.0)
    cofactors = np.einsum("kij,kj,klj->kil", vectors, inverse, vectors)
    return cofactors, is_determined.sum(axis=1)
