"""Bachmann's theory of errors: how good an optical-mechanical orientation is.

Every step of such a procedure reads the model as the step before left it, with a fresh
error. With d the turns that the bundles still need and ε the errors of reading, a pass
is d ← T d + S ε, whatever the procedure. Hence a covariance P of d becomes T P Tᵀ + S
Sᵀ σ² after one more pass, and after many passes it is the P that this leaves as it is.
It does *not* become smaller: the errors of the last pass are always there, so that the
parallaxes that remain in the model stay larger than σ in some points. That is what
Bachmann means by saying that the procedure does not converge; a mean over several
passes, or over several complete orientations, is the way out.

All covariances here are for readings of unit standard error (σ = 1), hence cofactors;
the order of the elements is ``ELEMENTS[case]``, that of the points the rows of the
design matrix.

Source: W. K. Bachmann 1943 and 1947 (doi 10.5169/seals-204738) state the principle and
the result; the formulas here are derived from it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from einschalt.theory.relative_orientation.gruber import reading
from einschalt.theory.relative_orientation.parallax_equations import N_ELEMENTS

LARGEST_RADIUS = 1.0 - 1e-6
"""What an error may keep from one pass to the next; above it a procedure diverges."""
_MOST_DOUBLINGS = 60


@dataclass(frozen=True, eq=False)
class PassMatrices:
    """What a sequence of steps does to the orientation."""

    # (..., 5, 5): turns still needed after the pass, from those before it
    T: np.ndarray
    S: np.ndarray  # (..., 5, n_readings): the same from the errors of reading
    # point number of each reading: one for every point of every step
    points: tuple[int, ...]

    @cached_property
    def eigenvalue(self):
        """Eigenvalue of T that is largest in size, ndarray of complex, shape (...).

        What an error keeps from one pass to the next: 1 - rel for Gruber's procedure in
        flat terrain; negative where each pass overshoots.
        """
        is_finite = np.isfinite(self.T).all(axis=(-1, -2))
        values = np.linalg.eigvals(np.where(is_finite[..., None, None], self.T, 0.0))
        largest = np.argmax(np.abs(values), axis=-1)
        found = np.take_along_axis(values, largest[..., None], axis=-1)[..., 0]
        return np.where(is_finite, found + 0j, np.inf)

    @property
    def spectral_radius(self):
        """Size of that eigenvalue, ndarray, shape (...)."""
        return np.abs(self.eigenvalue)

    @property
    def diverges(self):
        """Whether repeating makes errors grow, or keep, ndarray of bool (...)."""
        return self.spectral_radius > LARGEST_RADIUS

    def limit(self, parallax):
        """Elements (..., 5) that the procedure ends with on parallaxes (..., n_points).

        These are read without new errors; NaN where the procedure diverges.
        """
        parallax = np.asarray(parallax, dtype=float)
        return np.einsum(
            "...ij,...j->...i", self.solution(parallax.shape[-1]), parallax
        )

    def solution(self, n_points):
        """Coefficients (..., 5, n_points) of it in the parallaxes: (I - T)⁻¹ G."""
        by_point = np.zeros((*self.S.shape[:-1], n_points))
        for reading_number, point in enumerate(self.points):
            by_point[..., point - 1] -= self.S[..., reading_number]
        is_good = ~self.diverges[..., None, None]
        left = np.eye(N_ELEMENTS) - np.where(is_good, self.T, 0.0)
        return np.linalg.solve(left, np.where(is_good, by_point, np.nan))


def pass_matrices(procedure, design, *, steps=None):
    """Matrices T and S of one pass of any procedure.

    ``design`` (..., n_points, 5) has the coefficients of the parallaxes, for one model
    or many; ``steps`` are others than those of a pass, such as ``procedure.start``.
    Infinite or NaN where a step reads nothing of the element that it turns.

    Raises
    ------
    SettingsError
        A step observes a point that does not exist.
    """
    design = np.asarray(design, dtype=float)
    steps = procedure.steps if steps is None else steps
    shape = np.broadcast_shapes(
        design.shape[:-2], *(np.shape(step.over_correction) for step in steps)
    )
    points = tuple(point for step in steps for point in step.observed)
    state = np.zeros((*shape, N_ELEMENTS, N_ELEMENTS + len(points)))
    state[..., :N_ELEMENTS] = np.eye(N_ELEMENTS)
    done = N_ELEMENTS
    for step in steps:
        column, row = procedure.column(step), reading(design, step.observed)
        read = np.einsum("...i,...ij->...j", row, state)
        weights = np.array(list(step.observed.values()))
        read[..., done : done + len(weights)] += weights
        done += len(weights)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            gain = step.over_correction / row[..., column]
            state[..., column, :] -= np.asarray(gain)[..., None] * read
    return PassMatrices(state[..., :N_ELEMENTS], state[..., N_ELEMENTS:], points)


def covariance_after_passes(procedure, design, n_passes):
    """Covariances (n_passes + 1, ..., 5, 5) of the elements, the first after the start.

    For readings of unit standard error; ``design`` (..., n_points, 5). Only errors of
    reading are in it, not what the first passes have yet to clear of the orientation
    with which the work began.
    """
    one = pass_matrices(procedure, design)
    start = pass_matrices(procedure, design, steps=procedure.start).S
    fresh = one.S @ _transposed(one.S)
    covariances = [np.broadcast_to(start @ _transposed(start), fresh.shape)]
    for _ in range(n_passes):
        covariances.append(one.T @ covariances[-1] @ _transposed(one.T) + fresh)
    return np.stack(covariances)


def stationary_covariance(matrices):
    """Covariance (..., 5, 5) of the elements that further passes leave as it is.

    The solution of ``P = T P Tᵀ + S Sᵀ``, vec P = (I - T⊗T)⁻¹ vec S Sᵀ, as the sum of
    all ``Tᵏ S Sᵀ Tᵏᵀ``, whose number of terms is doubled until it stands still: nothing
    is subtracted, and nothing larger than 5 by 5 is solved. For readings of unit
    standard error; NaN where the procedure diverges.
    """
    is_good = ~matrices.diverges[..., None, None]
    power, fresh = (np.where(is_good, each, 0.0) for each in (matrices.T, matrices.S))
    total = fresh @ _transposed(fresh)
    for _ in range(_MOST_DOUBLINGS):
        term = power @ total @ _transposed(power)
        total = total + term
        power = power @ power
        if not np.any(np.abs(term) > np.finfo(float).eps * np.abs(total)):
            break
    return np.where(is_good, total, np.nan)


def residual_covariance(design, covariance):
    """Covariance A P Aᵀ of the parallaxes that remain, (..., n_points, n_points)."""
    design = np.asarray(design, dtype=float)
    return design @ covariance @ _transposed(design)


def covariance_of_consecutive_mean(matrices, n_passes):
    """Covariance (..., 5, 5) of the mean of the elements after each of r passes.

    The passes follow each other, counted after the errors of the start have died away:
    (1/r²) [r P + Σ (r - k) (Tᵏ P + P Tᵏᵀ)]; NaN where the procedure diverges.
    """
    covariance = stationary_covariance(matrices)
    total = n_passes * covariance
    lagged = covariance
    for lag in range(1, n_passes):
        lagged = matrices.T @ lagged
        total = total + (n_passes - lag) * (lagged + _transposed(lagged))
    return total / n_passes**2


def covariance_of_independent_mean(matrices, n_runs):
    """Covariance P/r of the mean of r complete orientations, each begun anew."""
    return stationary_covariance(matrices) / n_runs


@dataclass(frozen=True, eq=False)
class ErrorComparison:
    """Standard errors of the parallaxes that remain, in units of one reading's."""

    passes: tuple[int, ...]
    # (len(passes), n_points): after so many passes of the procedure
    after_passes: np.ndarray
    # (n_points,): however often it is repeated; NaN where it diverges
    stationary: np.ndarray
    # (n_points,): after an adjustment of one reading of every point
    least_squares: np.ndarray


def compare_errors(procedure, design, passes=(1, 2, 5, 20)):
    """Remaining parallaxes after more and more passes, beside least squares.

    ``design`` (n_points, 5) is that of one model.
    """
    covariances = covariance_after_passes(procedure, design, max(passes))
    stationary = stationary_covariance(pass_matrices(procedure, design))
    orthonormal = np.linalg.qr(design)[0]
    return ErrorComparison(
        passes=tuple(passes),
        after_passes=_standard_errors(design, covariances[list(passes)]),
        stationary=_standard_errors(design, stationary),
        least_squares=np.sqrt(np.sum(orthonormal**2, axis=-1)),
    )


def _standard_errors(design, covariance):
    variances = np.einsum("pi,...ij,pj->...p", design, covariance, design)
    # rounding may leave -1e-17 where a step has just cleared a point without error
    return np.sqrt(np.maximum(variances, 0.0))


def _transposed(matrices):
    return np.swapaxes(matrices, -1, -2)
