"""Hallert's numerical method: elements by least squares from any number of parallaxes.

Every measured y-parallax gives one equation, and at least five of them give the
elements with their cofactors; from the sixth on there is a sigma_0 as well. All
models are adjusted at once: their rows lie in one long table, model by model.

The flat model with six points (1, 3, 5 under the left centre at y = 0, +a, -a; 2, 4, 6
under the right one) has closed solutions, at the end of this module. Everywhere in it
the points follow each other as **1, 3, 5, 2, 4, 6**.

Source: B. Hallert 1944, as quoted by J. Krames 1951 and in the ISPRS archives.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import over_segments, segment_sum
from einschalt.foundations.kernels import compiled
from einschalt.theory.adjustment.least_squares import standard_error_of_unit_weight
from einschalt.theory.relative_orientation.parallax_equations import (
    DEPENDENT_LEFT,
    INDEPENDENT,
    N_ELEMENTS,
    design_matrix,
    element_scale,
)

LARGEST_CONDITION = 1e5
"""Beyond it a parallax error of 5 µm turns a bundle by half a right angle."""


@dataclass(frozen=True, eq=False)
class ParallaxAdjustment:
    """Elements of all models, and how well they are known."""

    # (n_models, 5): in the order of ``ELEMENTS[case]`` [rad, unit of the model]; NaN
    # where the points do not determine them
    elements: np.ndarray
    # (n_models, 5, 5): weight coefficients Q; the covariance is sigma_0² Q
    cofactor: np.ndarray
    # (n_models,): standard error of one parallax, in its unit; NaN without redundancy
    sigma_0: np.ndarray
    residuals: np.ndarray  # (n_points,): v = A x - p: adjusted minus measured parallax
    # (n_points,): share of an error of this parallax that shows in its residual, 0 to 1
    redundancy_numbers: np.ndarray
    n_points: np.ndarray  # of int, (n_models,)
    # (n_models,): Frobenius condition number of the scaled equations; infinite where
    # singular or short of points. Compare it only between models of the same case.
    condition: np.ndarray

    @property
    def redundancy(self):
        """Points beyond five, ndarray of int (n_models,); 0 where not determined."""
        return np.where(self.is_determined, self.n_points - N_ELEMENTS, 0)

    @property
    def is_determined(self):
        """Whether the points determine the elements, ndarray of bool (n_models,)."""
        return self.condition <= LARGEST_CONDITION


def adjust_parallaxes(xyz, y_parallax, base, model_start, *, case):
    """Adjust the elements of all models to their y-parallaxes, with equal weights.

    Angles are scaled by the mean height, so that all columns are of one order, and
    the equations of each model are then made orthogonal (modified Gram-Schmidt, the
    parallaxes carried along as a sixth column): no normal equations are formed, whose
    condition would be the square.

    Parameters
    ----------
    xyz : ndarray, shape (n_points, 3)
        Model coordinates sorted by model, origin in the left projection centre, z < 0.
    y_parallax : ndarray, shape (n_points,)
        ``y(moved) - y(fixed)`` in the unit of the coordinates: y_left - y_right, but
        **y_right - y_left** for ``dependent_right``.
    base : ndarray, shape (n_models,)
        In the unit of the coordinates.
    model_start : ndarray of int, shape (n_models + 1,)
        Model k owns rows model_start[k]:model_start[k + 1].
    case : {"independent", "dependent_left", "dependent_right"}

    Returns
    -------
    ParallaxAdjustment
        A model with fewer than five points, or with points in a position that
        determines nothing, has NaN and never stops the others.

    Notes
    -----
    Cost: one pass, O(n_points); the result of a model does not depend on the others.
    """
    n_points = np.diff(model_start)
    height = segment_sum(-xyz[:, 2], model_start) / np.maximum(n_points, 1)
    scale = element_scale(height, case)
    rows = np.empty((len(xyz), N_ELEMENTS + 1))
    rows[:, :-1] = design_matrix(xyz, np.repeat(base, n_points), case)
    rows[:, :-1] /= np.repeat(scale, n_points, axis=0)
    rows[:, -1] = y_parallax
    size = np.sqrt(segment_sum(np.sum(rows[:, :-1] ** 2, axis=1), model_start))
    triangle = np.zeros((len(n_points), N_ELEMENTS, N_ELEMENTS + 1))
    inverse = np.full((len(n_points), N_ELEMENTS, N_ELEMENTS), np.nan)
    over_segments(_orthogonalise, model_start, rows, triangle, inverse)
    condition = size * np.sqrt(np.sum(inverse**2, axis=(1, 2)))
    inverse[~(condition <= LARGEST_CONDITION)] = np.nan
    unscaled = inverse / scale[:, :, np.newaxis]
    return _adjustment(rows, triangle[:, :, -1], unscaled, condition, model_start)


def _adjustment(rows, projected, inverse, condition, model_start):
    """Gather the results of all models from what orthogonalising left."""
    n_points = np.diff(model_start)
    is_determined = condition <= LARGEST_CONDITION
    is_used = np.repeat(is_determined, n_points)
    misclosure = rows[:, -1]
    leverage = np.einsum("ni,ni->n", rows[:, :-1], rows[:, :-1])
    sum_of_squares = segment_sum(misclosure**2, model_start)
    redundancy = np.where(is_determined, n_points - N_ELEMENTS, 0)
    return ParallaxAdjustment(
        elements=np.einsum("mij,mj->mi", inverse, projected),
        cofactor=inverse @ inverse.swapaxes(1, 2),
        sigma_0=standard_error_of_unit_weight(sum_of_squares, redundancy),
        residuals=np.where(is_used, -misclosure, np.nan),
        redundancy_numbers=np.where(is_used, np.maximum(1.0 - leverage, 0.0), np.nan),
        n_points=n_points,
        condition=np.where(np.isnan(condition), np.inf, condition),
    )


@compiled
def _orthogonalise(first_model, last_model, start, rows, triangle, inverse):
    """Split the rows [A p] of each model into Q, which takes their place, and R."""
    for model in range(first_model, last_model):
        own = rows[start[model] : start[model + 1]]
        is_full = len(own) >= N_ELEMENTS and _gram_schmidt(own, triangle[model])
        if is_full:
            _invert_upper(triangle[model], inverse[model])


@compiled
def _gram_schmidt(rows, triangle):
    for column in range(N_ELEMENTS):
        length = 0.0
        for row in range(rows.shape[0]):
            length += rows[row, column] ** 2
        length = np.sqrt(length)
        if length == 0.0:
            return False
        triangle[column, column] = length
        for row in range(rows.shape[0]):
            rows[row, column] /= length
        for other in range(column + 1, N_ELEMENTS + 1):
            share = 0.0
            for row in range(rows.shape[0]):
                share += rows[row, column] * rows[row, other]
            triangle[column, other] = share
            for row in range(rows.shape[0]):
                rows[row, other] -= share * rows[row, column]
    return True


@compiled
def _invert_upper(triangle, inverse):
    inverse[:] = 0.0
    for column in range(N_ELEMENTS):
        inverse[column, column] = 1.0 / triangle[column, column]
        for row in range(column - 1, -1, -1):
            total = 0.0
            for inner in range(row + 1, column + 1):
                total += triangle[row, inner] * inverse[inner, column]
            inverse[row, column] = -total / triangle[row, row]


def flat_six_points(half_width, base, height):
    """Six points (6, 3) of the flat model, in the order 1, 3, 5, 2, 4, 6.

    Points 3 to 6 lie ``half_width`` a beside the base b; the plane lies h below it.
    """
    y = [0.0, half_width, -half_width]
    return np.array(
        [[x, y_point, -height] for x in (0.0, float(base)) for y_point in y]
    )


def flat_cofactor(half_width, base, height, case):
    """Hallert's weight and correlation coefficients of the flat six-point model.

    Q (5, 5) in the order of ``ELEMENTS[case]``, for parallaxes of unit weight; a, b and
    h are those of :func:`flat_six_points`.

    Notes
    -----
    With u = (9 h⁴ + 12 a² h² + 8 a⁴) / (12 a⁴). All coefficients that are not set
    vanish: the tips are uncorrelated with the swings.
    """
    a, b, h = half_width, base, height
    u = (9 * h**4 + 12 * a**2 * h**2 + 8 * a**4) / (12 * a**4)
    tilt_shift = -h * (2 * a**2 + 3 * h**2) / (4 * a**4)
    q = np.zeros((N_ELEMENTS, N_ELEMENTS))
    if case == INDEPENDENT:
        q[0, 3] = q[0, 4] = tilt_shift / b
        q[3, 4] = (2 * a**2 + 3 * h**2) ** 2 / (12 * a**4 * b**2)
        tip = h**2 / (2 * a**2 * b**2)
        diagonal = (0.75 * h**2 / a**4, tip, tip, u / b**2, u / b**2)
    else:
        sign = 1.0 if case == DEPENDENT_LEFT else -1.0
        q[0, 3] = tilt_shift
        q[1, 4] = sign * h**2 / (2 * a**2 * b)
        q[2, 3] = -sign / (3 * b)
        tip = h**2 / (a**2 * b**2)
        diagonal = (0.75 * h**2 / a**4, tip, 2 / (3 * b**2), u, h**2 / (2 * a**2))
    return q + q.T + np.diag(diagonal)
