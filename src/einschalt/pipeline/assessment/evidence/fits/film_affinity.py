"""Affinity that the models of a flight have in common, along either axes.

Along those of the machine it is the mean of the affinities of all models. Models that
were turned in the machine, each in its own way, have that of film along the strips in
common on the ground: there it is a term of an adjustment of everything, and looks like
a strain of control.

See docs/theory/systematic_patterns.md.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy.special import chdtrc

from einschalt.foundations.key_columns import rows_among
from einschalt.theory.adjustment.significance import SYSTEMATIC_SIGNIFICANCE
from einschalt.theory.transformation.affinity import (
    affine_matrices,
    affinity_derivatives,
    model_affinities,
)

MODEL_KEY = ["coverage", "model_id"]


class FilmAxes(StrEnum):
    """Which axes the models of a flight have an affinity along."""

    MACHINE = "machine"  # x and y as they were measured
    # easting and northing: of film along the strips, whose models were turned in the
    # machine, each in its own way
    GROUND = "ground"


@dataclass(frozen=True)
class FilmAffinity:
    """Affinity that the models of a flight have in common."""

    flight: str
    # of the measured coordinates: by how much x is longer than y, and by how much the
    # right angle between them is smaller [rad]
    stretch: float
    shear: float
    # standard errors
    stretch_error: float
    shear_error: float
    p_value: float  # joint test of both
    is_absorbed: bool  # whether the transformation takes it up: affine does
    bias: float  # TOTAL error that it makes in a model otherwise, root mean square [m]
    axes: FilmAxes = FilmAxes.MACHINE  # which x and y are

    @property
    def is_significant(self) -> bool:
        """Whether chance does not explain it."""
        return bool(self.p_value < SYSTEMATIC_SIGNIFICANCE)


def film_affinity(flight, transformation, model, errors):
    """Weighted mean of the affinities of all models, with its error: FilmAffinity.

    None where no model has one.
    """
    points, moments = transformation.observed.points, transformation.fit.moments
    matrix, _ = affine_matrices(moments)
    each = model_affinities(matrix)
    derivatives = affinity_derivatives(points, moments)
    squares = np.sum(derivatives**2, axis=(1, 2))
    is_usable = transformation.models["is_usable"].to_numpy() & np.isfinite(each[:, 0])
    variance = np.bincount(points.model, squares, len(each))
    is_usable &= variance > 0.0
    # a gross error would pass for affinity
    is_sound = is_usable & ~_has_suspects(transformation)
    is_usable = is_sound if is_sound.any() else is_usable
    if not is_usable.any():
        return None
    weight = np.where(is_usable, 1.0 / np.where(is_usable, variance, 1.0), 0.0)
    weight /= weight.sum()
    mean = weight[is_usable] @ each[is_usable]
    rows = np.where(is_usable[points.model], weight[points.model], 0.0)
    functional = rows[:, None, None] * np.nan_to_num(derivatives)
    chains = model.chains_to_fits(flight, transformation.observed)
    covariance = _covariance(functional, chains, errors)
    test = mean @ np.linalg.solve(covariance, mean)
    # film that is longer makes the way from model to ground shorter
    stretch, shear = -2.0 * mean
    return FilmAffinity(
        flight,
        *(float(stretch), float(shear)),
        *(float(2.0 * np.sqrt(covariance[k, k])) for k in range(2)),
        p_value=float(chdtrc(2, test)),
        is_absorbed=transformation.kind == "affine",
        bias=_bias(mean, matrix[is_usable], transformation.fit, is_usable),
    )


def _covariance(functional, chains, standard_errors):
    """Covariance of sums over all that a flight was fitted with, (n_sums, n_sums)."""
    rows = np.swapaxes(functional, 0, 1)
    total = 0.0
    for source, chain in chains.items():
        carried = chain.of_functionals(rows)
        carried = carried * chain.axes.each(standard_errors[source]).ravel()
        total = total + np.real(carried @ carried.conj().T)
    return total


def _has_suspects(transformation):
    models, residuals = transformation.models, transformation.residuals
    is_suspect = residuals["is_suspect"].to_numpy(dtype=bool)
    suspects = {name: residuals[name].array[is_suspect] for name in MODEL_KEY}
    return rows_among(models, suspects, MODEL_KEY)


def _bias(mean, matrix, fit, is_usable):
    """What a conformal transformation leaves of an affinity, RMS over models [m].

    In a model with the second central moments v_x and v_y of its points, an elongation
    δ of x against y leaves δ √(v_x v_y / (v_x + v_y)).
    """
    moments = fit.moments
    spread = moments.model_model[is_usable] / moments.weight_sum[is_usable, None, None]
    scale = np.abs(np.linalg.det(matrix))
    polar = spread[:, 0, 0] + spread[:, 1, 1]
    arm = np.linalg.det(spread) / polar * scale
    return float(2.0 * np.hypot(*mean) * np.sqrt(np.mean(arm)))


def affinities_on_ground(found, films):
    """Affinities along the axes of the ground by flight, if chance does not make them.

    Those that are significant themselves, where all together are. ``found`` are such
    terms of an adjustment of everything (CommonTermsFound), ``films`` the fit of each
    flight, the affinity that is one of its term, and whether it has one.
    """
    with_term = {name: film for name, (*film, has_term) in films.items() if has_term}
    n = len(with_term)
    p_value = chdtrc(2 * n, found.square_of(slice(0, n))) if n else 1.0
    if not p_value < SYSTEMATIC_SIGNIFICANCE:
        return {}
    each = (
        _affinity_on_ground(found, place, name, *film)
        for place, (name, film) in enumerate(with_term.items())
    )
    return {part.flight: part for part in each if part and part.is_significant}


def _affinity_on_ground(found, place, flight, transformation, size):
    """FilmAffinity along the axes of the ground: a term of all models.

    None where no model has points enough to show what it leaves.
    """
    coefficient = size * found.coefficients[place]
    error = 2.0 * size * np.sqrt(np.real(found.covariance[place, place]))
    matrix, _ = affine_matrices(transformation.fit.moments)
    is_usable = transformation.models["is_usable"].to_numpy()
    is_usable = is_usable & np.isfinite(matrix).all(axis=(1, 2))
    if not is_usable.any():
        return None
    mean = np.array([coefficient.real, coefficient.imag])
    return FilmAffinity(
        flight,
        *(float(2.0 * part) for part in mean),
        *(float(error), float(error)),
        p_value=float(chdtrc(2, found.square_of(slice(place, place + 1)))),
        is_absorbed=False,
        bias=_bias(mean, matrix[is_usable], transformation.fit, is_usable),
        axes=FilmAxes.GROUND,
    )
