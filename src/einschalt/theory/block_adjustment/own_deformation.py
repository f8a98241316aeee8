"""Deformations that each model has for itself: random effects of the adjustment.

Film, lens, photographs and their orientation bend every model in its own way. Each
model m of a flight is displaced on the ground by

    Σ_k τ_d f_k(x, y) c_mk,   c_mk ~ N(0, 1) for each axis,

f_k the products of powers of the position in the model of degree d (1 at the edge); of
similarities also the mirrored position, an affinity. Heights have sizes of their own.
The coefficients are unknowns with a pseudo-observation 0 each; with ĉ and their
cofactors q the sizes follow from

    τ² ← τ² Σ ĉ² / Σ (1 − q)

until nothing changes, which is the restricted maximum likelihood; 1 − q is the
redundancy number of a pseudo-observation. Whether there are any is told by
−2 log L = f log(Ω / f) + log |N|, with one factor for all errors: it falls by more than
a mixture of χ² explains, as sizes cannot be negative.

Source: Patterson & Thompson (1971); Harville (1977) for the iteration; Self & Liang
(1987) for the mixture. See docs/theory/own_deformation.md.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc, comb

from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.common_parameters import (
    AFFINITY,
    CUBIC,
    DEGREE,
    QUADRATIC,
    positions_in_model,
)
from einschalt.theory.block_adjustment.spatial_solution import adjust_spatially

PLAN, HEIGHT = "plan", "height"
TERMS = {AFFINITY: 1, QUADRATIC: 3, CUBIC: 4}
# models of which sizes are estimated: more tell them no better than to 5 per cent
MOST_MODELS = 120
MOST_PASSES = 12
SETTLED = 0.03
# a step goes on as the steps before it did, at most so many times as far
MOST_AHEAD = 8.0
MOST_STEP = 3.0
LEAST_STEP = 1e-12
# deformations below this share of the measuring error at the edge change nothing
LEAST_SHARE = 0.2
# points that hold the sampled models are known to so many errors of measurement
LOOSE = 1e3
# directions in which they lie outermost
OUTWARD = np.array([[1, 1, 0, -1, -1, -1, 0, 1], [0, 1, 1, 1, 0, -1, -1, -1]])
# residuals beyond so many times their median size are gross errors, and no deformation
GROSS = 6.0
# deformations that are less likely to be there need no second look
LEAST_CHANCE = 0.05
EDGE = 0.75


@dataclass(frozen=True, eq=False)
class OwnDeformation:
    """Sizes of the deformations that each model of a flight has for itself."""

    flight: np.ndarray  # (n,): of each size
    family: tuple[str, ...]  # "affinity", "quadratic" or "cubic"
    axis: tuple[str, ...]  # "plan" or "height"
    size: np.ndarray  # (n,): τ on the ground [m]; 0 where nothing shows
    relative_error: np.ndarray  # (n,): standard error over size; NaN where this is 0
    p_value: float  # that chance makes such sizes, all together; NaN without a test

    def edge(self, flight, axis=PLAN):
        """Displacement at the edge of the models of a flight (RMS, in plan total) [m].

        Without what an affine transformation takes up.
        """
        along = np.linspace(-1.0, 1.0, 41)
        position = np.stack(np.meshgrid(along, along), -1).reshape(-1, 2)
        is_edge = np.abs(position).max(axis=1) > EDGE
        plane = np.column_stack([np.ones(len(position)), position])
        square = 0.0
        for k in np.flatnonzero(self._is(axis=axis) & (self.flight == flight)):
            terms = bending_terms(self.family[k], position)
            if self.family[k] != AFFINITY:
                terms = terms - plane @ np.linalg.lstsq(plane, terms.real)[0]
            each = (np.abs(terms[is_edge]) ** 2).sum(axis=1)
            square += self.size[k] ** 2 * each.mean()
        return float(np.sqrt(square * (2.0 if axis == PLAN else 1.0)))

    def without_small(self, errors):
        """Set sizes to 0 that change nothing beside ``errors`` of measuring (n,)."""
        is_small = self.size < LEAST_SHARE * errors
        return replace(
            self,
            size=np.where(is_small, 0.0, self.size),
            relative_error=np.where(is_small, np.nan, self.relative_error),
        )

    def _is(self, **wanted):
        fits = np.ones(len(self.size), dtype=bool)
        for name, value in wanted.items():
            fits &= np.array([own == value for own in getattr(self, name)])
        return fits

    def size_of(self, flight, family, axis):
        """One of the sizes [m]."""
        is_it = self._is(family=family, axis=axis) & (self.flight == flight)
        return float(self.size[is_it].sum())

    @property
    def families(self):
        """Families of which any size is not 0, tuple of str."""
        used = {family for family, _ in self.kinds}
        return tuple(family for family in TERMS if family in used)

    def displacements(self, flight, xy, model):
        """Displacements of all points of a flight by coefficients of variance 1.

        In plan (complex, one coefficient for each axis) and in height, both (n_points,
        n_terms) with the terms of ``families`` [m].
        """
        position, _ = positions_in_model(xy, model)
        terms = [bending_terms(family, position) for family in self.families]
        plan, height = (
            np.hstack(
                [
                    self.size_of(flight, family, axis) * part
                    for family, part in zip(self.families, terms, strict=True)
                ]
            )
            for axis in (PLAN, HEIGHT)
        )
        return plan, height.real

    @property
    def error_of_variance(self):
        """Standard error of the variance of all together, over this variance."""
        is_known = np.isfinite(self.relative_error) & (self.size > 0.0)
        weight = self.size[is_known] ** 2
        errors = 2.0 * self.relative_error[is_known] * weight
        return float(np.sqrt(np.sum(errors**2)) / weight.sum())

    @property
    def kinds(self):
        """Family and axis of the columns that flights share, tuple of pairs."""
        pairs = zip(self.family, self.axis, strict=True)
        used = [pair for pair, size in zip(pairs, self.size, strict=True) if size > 0.0]
        return tuple(dict.fromkeys(used))


def bending_terms(family, position):
    """Displacement by each term with the coefficient 1, (n, n_terms), complex."""
    x, y = position.T
    if family == AFFINITY:
        return (x - 1j * y)[:, None]
    degree = DEGREE[family]
    return np.stack([x ** (degree - k) * y**k for k in range(degree + 1)], -1) + 0j


def bent_columns(observations, own, is_bent=None):
    """Displacements by own deformations, as ``bent`` of the observations [m].

    None where all sizes are 0. Rows that are not ``is_bent`` have none: projection
    centres lie outside of the model.
    """
    if not own.kinds:
        return None
    is_spatial = _plane_of(observations) is not observations
    n_rows = len(observations.model)
    columns = []
    for family, axis in own.kinds:
        terms = np.zeros((n_rows, TERMS[family]), dtype=complex)
        for flight in np.unique(own.flight):
            rows, position = _positions(observations, flight, is_bent)
            size = own.size_of(flight, family, axis)
            terms[rows] = size * bending_terms(family, position)
        columns.append(_in_space(terms, axis) if is_spatial else terms)
    bent = np.concatenate(columns, axis=-1)
    is_mirrored = not is_spatial and AFFINITY in own.family
    return bent if is_mirrored else np.ascontiguousarray(bent.real)


def _in_space(terms, axis):
    """Easting, northing, height by each coefficient, (n, 3, n_columns)."""
    nil = np.zeros_like(terms.real)
    if axis == HEIGHT:
        return np.stack([nil, nil, terms.real], axis=1)
    turns = np.concatenate([terms, 1j * terms], axis=1)
    return np.stack([turns.real, turns.imag, np.concatenate([nil, nil], 1)], axis=1)


def _positions(observations, flight, is_bent=None):
    """Rows of a flight, and the positions of their points in the models."""
    is_own = observations.flight[observations.model] == flight
    if is_bent is not None:
        is_own &= is_bent
    rows = np.flatnonzero(is_own)
    xy = _plane_of(observations).xy[rows]
    if len(rows) == 0:
        return rows, xy
    return rows, positions_in_model(xy, observations.model[rows])[0]


def _plane_of(observations):
    if hasattr(observations, "in_plan"):
        return observations.in_plan(is_affine=False)
    return observations


def estimate_own_deformation(observations, places, terms=()) -> OwnDeformation:
    """Estimate how much the models of each flight are bent, each in its own way.

    Parameters
    ----------
    observations : BlockObservations or SpatialObservations
        Determined, without own deformations.
    places : ndarray, shape (n_points, 2) or (n_points, 3)
        Where the points are, by some errors of measurement; NaN where nobody knows [m].
    terms : sequence of CommonTerms
        Deformations that plane models of a flight share.

    Returns
    -------
    OwnDeformation
        For any significance; a size is 0 where it is too small to matter.
    """
    sample = sample_of_models(observations, places).observations
    if _plane_of(sample) is sample:
        plain = adjust(sample, terms)
    else:
        plain = adjust_spatially(sample)
    own = _estimated(plain, _first_guess(sample), plain)
    if not (own.kinds and own.p_value < LEAST_CHANCE):
        return own
    # residuals that the deformations explain are no gross errors
    return _estimated(plain, own, _bent(plain, own))


def _bent(plain, own):
    """The same block with own deformations."""
    observations = plain.observations
    bent = bent_columns(observations, own)
    return plain.readjusted(replace(observations, bent=bent))


def _estimated(plain, own, judged):
    """Sizes without the gross errors of a solution, beginning with those of ``own``."""
    plain = _without_gross(plain, judged)
    nothing = replace(own, size=np.zeros(len(own.size)), p_value=np.nan)
    if plain.redundancy <= len(own.size) or not plain.sum_of_squares > 0.0:
        return nothing
    errors = _measuring_errors(plain.observations, own)
    before = np.zeros(len(own.size))
    for _ in range(MOST_PASSES):
        step, redundancy = _step(_bent(plain, own), own)
        if np.abs(np.expm1(step)).max() < SETTLED:
            break
        # steps that shrink slowly are those of a geometric series
        share = np.divide(step, before, out=np.zeros(len(step)), where=before != 0.0)
        ahead = np.minimum(1.0 / (1.0 - np.clip(share, 0.0, 0.99)), MOST_AHEAD)
        before = step
        size = own.size * np.exp(np.clip(ahead * step, -MOST_STEP, MOST_STEP))
        found = replace(own, size=size, relative_error=1.0 / np.sqrt(2.0 * redundancy))
        own = found.without_small(errors)
        if not own.kinds:
            return nothing
    bent = _bent(plain, own)
    own = replace(own, p_value=_chance(_deviance(plain) - _deviance(bent), own))
    # sizes stand beside the errors of measuring; where these are smaller than given,
    # so are they
    smaller = min(bent.s_0, 1.0)
    own = replace(own, size=smaller * own.size).without_small(errors)
    return own if own.kinds else nothing


def _without_gross(plain, judged):
    """Block without the rows whose residuals in ``judged`` are gross errors."""
    error = judged.observations.standard_error
    size = judged.residuals / error.reshape(len(error), -1)
    size = np.sqrt((size**2).sum(axis=1))
    is_tested = size > 0.0
    if not is_tested.any():
        return plain
    rows = np.flatnonzero(size <= GROSS * np.median(size[is_tested]))
    if len(rows) == len(size):
        return plain
    sample = plain.observations
    sample = sample.of_rows(rows, np.arange(sample.n_models)).observations
    if _plane_of(sample) is sample:
        return adjust(sample, plain.terms)
    return adjust_spatially(sample, plain.placement)


def _first_guess(observations):
    plane = _plane_of(observations)
    is_spatial = plane is not observations
    kinds = [(family, PLAN) for family in TERMS]
    if is_spatial:
        kinds += [(QUADRATIC, HEIGHT), (CUBIC, HEIGHT)]
    sizes = [
        (flight, family, axis)
        for flight in np.unique(observations.flight)
        for family, axis in kinds
        # an affine transformation takes up the affinity
        if not (
            family == AFFINITY and plane.is_affine[observations.flight == flight].all()
        )
    ]
    flight, family, axis = zip(*sizes, strict=True)
    unknown = np.full(len(sizes), np.nan)
    own = OwnDeformation(np.array(flight), family, axis, unknown, unknown, np.nan)
    return replace(own, size=_measuring_errors(observations, own))


def _measuring_errors(observations, own):
    """Median standard error of a measured coordinate on the ground, (n,) [m]."""
    flight = observations.flight[observations.model]
    error = observations.standard_error.reshape(len(flight), -1)
    medians = {
        (k, axis): np.median(error[flight == k, 0 if axis == PLAN else -1])
        for k in np.unique(flight)
        for axis in (PLAN, HEIGHT)
    }
    pairs = zip(own.flight, own.axis, strict=True)
    return np.array([medians.get(pair, np.inf) for pair in pairs])


def _step(bent, own):
    """Change of the logarithm of each size, and its redundancy."""
    free, squares = _pseudo_observations(bent)
    n_axes = 2 if bent.observations.bent.ndim > 2 else 1
    widths = [
        TERMS[family] * (n_axes if axis == PLAN else 1) for family, axis in own.kinds
    ]
    first = dict(zip(own.kinds, np.cumsum([0, *widths]), strict=False))
    width = dict(zip(own.kinds, widths, strict=True))
    step, redundancy = np.zeros(len(own.size)), np.full(len(own.size), np.nan)
    unit = bent.sum_of_squares / bent.redundancy
    for k in np.flatnonzero(own.size):
        kind = own.family[k], own.axis[k]
        columns = np.arange(first[kind], first[kind] + width[kind])
        part = np.ix_(bent.observations.flight == own.flight[k], columns)
        redundancy[k] = max(free[part].sum(), np.finfo(float).tiny)
        share = squares[part].sum() / unit / redundancy[k]
        step[k] = 0.5 * np.log(max(share, LEAST_STEP))
    return step, redundancy


def _pseudo_observations(bent):
    """Redundancy numbers and squares of the coefficients, (n_models, n_columns)."""
    coefficients = bent.bent.reshape(len(bent.bent), bent.bent.shape[1], -1)
    n_further = coefficients[0].size
    diagonal = np.diagonal(bent.unknown_cofactors, axis1=1, axis2=2)
    free = 1.0 - diagonal[:, -n_further:].reshape(coefficients.shape)
    return free.sum(axis=2), (coefficients**2).sum(axis=2)


def _deviance(solution):
    """−2 log of the restricted likelihood, but for a constant."""
    f = solution.redundancy
    omega = max(solution.sum_of_squares, np.finfo(float).tiny)
    return f * np.log(omega / f) + solution.log_determinant


def _chance(fall, own):
    """Probability of such a fall where all sizes are 0."""
    if not fall > 0.0:
        return 1.0
    n = len(own.size)
    k = np.arange(1, n + 1)
    return float(comb(n, k) / 2.0**n @ chdtrc(k, fall))


def sample_of_models(observations, places):
    """Part with some models that lie together, or with all of a smaller block."""
    if observations.n_models <= MOST_MODELS:
        return observations.of_models(np.ones(observations.n_models, dtype=bool))
    part = observations.of_models(_are_together(observations, places))
    chosen, place = part.observations, places[part.points]
    # some points at its rim hold the sample, so loosely that they tell nothing
    known = np.flatnonzero(np.isfinite(place).all(axis=1))
    rim = known[np.unique((place[known, :2] @ OUTWARD).argmax(axis=0))]
    rim = rim[~chosen.is_control[rim]]
    control, covariance = chosen.control.copy(), chosen.control_covariance.copy()
    control[rim] = place[rim]
    error = LOOSE * np.median(chosen.standard_error)
    covariance[rim] = error**2 * np.eye(place.shape[1])
    held = replace(chosen, control=control, control_covariance=covariance)
    return replace(part, observations=held)


def _are_together(observations, places):
    """Whether each model is one of those nearest to the middle of the block."""
    point, model = observations.point, observations.model
    is_known = np.isfinite(places[point]).all(axis=1)
    point, model = point[is_known], model[is_known]
    sums = [np.bincount(model, c, observations.n_models) for c in places[point, :2].T]
    n = np.bincount(model, minlength=observations.n_models)
    with np.errstate(invalid="ignore"):
        middle = np.stack(sums, axis=1) / n[:, None]
    away = ((middle - np.nanmedian(middle, axis=0)) ** 2).sum(axis=1)
    is_in = np.zeros(observations.n_models, dtype=bool)
    is_in[np.argsort(away, kind="stable")[:MOST_MODELS]] = True
    return is_in & np.isfinite(away)
