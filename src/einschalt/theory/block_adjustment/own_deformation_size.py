"""Sizes of the deformations that each model has for itself, and whether there are any.

The coefficients are unknowns with a pseudo-observation 0 each; with ĉ and their
cofactors q the sizes follow from

    τ² ← τ² Σ ĉ² / Σ (1 − q)

until nothing changes, which is the restricted maximum likelihood; 1 − q is the
redundancy number of a pseudo-observation. Whether there are any is told by
−2 log L = f log(Ω / f) + log |N|, with one factor for all errors: it falls by more than
a mixture of χ² explains, as sizes cannot be negative.

All this is only done where the residuals v of the block without deformations call for
it: of Σ |Fᵀ P v|² over the models, F the terms of a size, over Ω, half is the
derivative of log L where the size is 0. What chance makes of these sums is told by
errors that are drawn.

Source: Patterson & Thompson (1971); Harville (1977) for the iteration; Self & Liang
(1987) for the mixture; Rao (1948) for the score. See docs/theory/own_deformation.md.
"""

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.special import chdtrc, comb

from einschalt.theory.adjustment.monte_carlo import draws_in_parts
from einschalt.theory.block_adjustment.common_parameters import (
    AFFINITY,
    CUBIC,
    QUADRATIC,
)
from einschalt.theory.block_adjustment.own_deformation import (
    HEIGHT,
    PLAN,
    TERMS,
    OwnDeformation,
    bent_columns,
    columns_of_sizes,
)

# models of which sizes are estimated: more tell them no better than to 5 per cent
MOST_MODELS = 120
MOST_PASSES = 12
SETTLED = 0.03
# a step goes on as the steps before it did, at most so many times as far
MOST_AHEAD = 8.0
MOST_STEP = 3.0
LEAST_STEP = 1e-12
# points that hold the sampled models are known to so many errors of measurement
LOOSE = 1e3
# directions in which they lie outermost
OUTWARD = np.array([[1, 1, 0, -1, -1, -1, 0, 1], [0, 1, 1, 1, 0, -1, -1, -1]])
# residuals beyond so many times their median size are gross errors, and no deformation
GROSS = 6.0
# beyond so many times the stated errors names, control or units are wrong
NO_DEFORMATION = 100.0
# deformations that are less likely to be there need no second look
LEAST_CHANCE = 0.05
# and residuals that are as likely as this without any are not looked at further
WORTH_A_LOOK = 0.1
N_DRAWS = 79
NUMBERS_AT_ONCE = 2_000_000


def estimate_own_deformation(plain) -> OwnDeformation:
    """Estimate how much the models of each flight are bent, each in its own way.

    Parameters
    ----------
    plain : BlockSolution or SpatialSolution
        Without own deformations; its terms are what models of a flight share.

    Returns
    -------
    OwnDeformation
        For any significance; a size is 0 where it is too small to matter, and all of
        them where the residuals show nothing that is worth an estimate, or more than
        deformations can be.
    """
    guess = _first_guess(plain.observations)
    if not _has_residuals(plain, guess):
        return _nothing(guess)
    # the largest residual alone would be the pattern
    good = _without_gross(plain, plain)
    if not _has_residuals(good, guess) or good.s_0 > NO_DEFORMATION:
        return _nothing(guess)
    p_value = chance_of_residuals(good, guess)
    if not p_value < WORTH_A_LOOK:
        return _nothing(guess, p_value)
    return _estimated_twice(plain, good, guess)


def chance_with_other_errors(plain, own, limit):
    """Probability of what residuals show, by other errors of measuring than before.

    ``own`` was estimated with these; at least as large as it is below the ``limit``:
    sizes that were not estimated from these residuals explain them less well.
    """
    good = _without_gross(plain, plain)
    bound = _chance(_deviance(good) - _deviance(_bent(good, own)), own)
    if bound < limit:
        return bound
    return _estimated_twice(plain, good, own).p_value


def _estimated_twice(plain, good, begin):
    """Sizes from a block without gross errors, which they tell from deformations."""
    own, bent = _estimated(good, begin)
    if not (own.kinds and own.p_value < LEAST_CHANCE):
        return own
    # residuals that the deformations explain are no gross errors
    judged = bent if good is plain else _bent(plain, own)
    again = _without_gross(plain, judged)
    return own if again is good else _estimated(again, own)[0]


def chance_of_residuals(plain, own):
    """Probability of residuals that ask for deformations as much as these do.

    ``own`` says which deformations; what their sizes are does not matter.
    """
    observations = plain.observations
    score = _Score(observations, own)
    residuals = plain.residuals.reshape(*plain.residuals.shape, 1)
    rng = np.random.default_rng(1971)
    parts = draws_in_parts(N_DRAWS, residuals.size, NUMBERS_AT_ONCE)
    drawn = [score.of(_drawn_residuals(plain, rng, n_draws)) for n_draws in parts]
    seen = score.of(residuals)
    every = np.concatenate([seen, *drawn], axis=1)
    spread = every.std(axis=1, keepdims=True)
    away = np.divide(
        every - every.mean(axis=1, keepdims=True),
        spread,
        out=np.zeros_like(every),
        where=spread > 0.0,
    )
    # only sizes above 0 are possible
    asked = (np.maximum(away, 0.0) ** 2).sum(axis=0)
    return float(np.mean(asked >= asked[0]))


def _drawn_residuals(plain, rng, n_draws):
    """Residuals of errors as they were given, (n_rows, d, n_draws)."""
    observations = plain.observations
    control = observations.drawn_control(rng, n_draws)
    errors = observations.drawn_errors(rng, n_draws, plain.linear)
    return plain.answer_to(errors, control, is_rough=True)[1]


class _Score:
    """How much residuals of a block ask for each size of its own deformations."""

    def __init__(self, observations, own):
        columns = bent_columns(observations, own)
        self.n_columns = columns.shape[-1]
        n_rows = columns.size // self.n_columns
        self.is_in_space = observations.is_in_space
        self.weight = observations.standard_error.reshape(len(columns), -1, 1) ** -2.0
        self.parts = columns_of_sizes(own, observations)
        # rows are points in plan, as complex numbers, or coordinates in space
        model = np.repeat(observations.model, n_rows // len(columns))
        row = np.repeat(np.arange(n_rows), self.n_columns)
        column = (model[:, None] * self.n_columns + np.arange(self.n_columns)).ravel()
        shape = (n_rows, observations.n_models * self.n_columns)
        terms = sparse.csc_array((columns.ravel(), (row, column)), shape)
        self.terms = terms.conj().T

    def of(self, residuals):
        """Σ |Fᵀ P v|² / Ω, (n_sizes, n_draws), of residuals (n_rows, d, n_draws)."""
        weighted = residuals * self.weight
        omega = (weighted * residuals).sum(axis=(0, 1))
        n_draws = residuals.shape[2]
        if not self.is_in_space:
            weighted = weighted[:, 0] + 1j * weighted[:, 1]
        projected = self.terms @ weighted.reshape(-1, n_draws)
        squares = (np.abs(projected) ** 2).reshape(-1, self.n_columns, n_draws)
        sums = [squares[part].sum(axis=(0, 1)) for part in self.parts.values()]
        return np.array(sums) / omega


def _bent(solution, own):
    """The same block with own deformations."""
    observations = solution.observations
    bent = bent_columns(observations, own)
    return solution.readjusted(replace(observations, bent=bent), is_rough=True)


def _nothing(own, p_value=np.nan):
    nil = np.zeros(len(own.size))
    return replace(own, size=nil, relative_error=nil * np.nan, p_value=p_value)


def _estimated(plain, own):
    """Sizes of a block without gross errors, beginning with those of ``own``.

    And the block as it is bent by them.
    """
    nothing = _nothing(own), plain
    if not _has_residuals(plain, own):
        return nothing
    errors = _measuring_errors(plain.observations, own)
    before = np.zeros(len(own.size))
    bent = plain
    for _ in range(MOST_PASSES):
        bent = _bent(bent, own)
        step, redundancy = _step(bent, own)
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
    else:
        bent = _bent(bent, own)
    own = replace(own, p_value=_chance(_deviance(plain) - _deviance(bent), own))
    # sizes stand beside the errors of measuring; where these are smaller than given,
    # so are they
    smaller = min(bent.s_0, 1.0)
    own = replace(own, size=smaller * own.size).without_small(errors)
    return (own, bent) if own.kinds else nothing


def _has_residuals(plain, own):
    """Whether the residuals of a block can tell sizes at all."""
    return plain.redundancy > len(own.size) and plain.sum_of_squares > 0.0


def _without_gross(plain, judged):
    """Block without the rows whose residuals in ``judged`` are gross errors."""
    observations = judged.observations
    error = observations.standard_error
    size = judged.residuals / error.reshape(len(error), -1)
    size = np.sqrt((size**2).sum(axis=1))
    # the only measurement of a point has no residual but rounding
    n_held = np.bincount(observations.point, minlength=observations.n_points)
    is_tested = (n_held + observations.is_control)[observations.point] > 1
    is_tested &= size > 0.0
    if not is_tested.any():
        return plain
    rows = np.flatnonzero(size <= GROSS * np.median(size[is_tested]))
    if len(rows) == len(size):
        return plain
    sample = plain.observations
    sample = sample.of_rows(rows, np.arange(sample.n_models)).observations
    # where all control is far off nothing is left that holds the block
    return plain.adjusted_anew(sample) if sample.is_control.any() else plain


def _first_guess(observations):
    kinds = [(family, PLAN) for family in TERMS]
    if observations.is_in_space:
        kinds += [(QUADRATIC, HEIGHT), (CUBIC, HEIGHT)]
    flights = np.unique(observations.flight)
    # an affine transformation takes up the affinity
    of_flight = {k: observations.flight == k for k in flights}
    is_affine = {k: observations.is_affine[of_flight[k]].all() for k in flights}
    sizes = [
        (flight, family, axis)
        for flight in flights
        for family, axis in kinds
        if not (family == AFFINITY and is_affine[flight])
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
    step, redundancy = np.zeros(len(own.size)), np.full(len(own.size), np.nan)
    unit = bent.sum_of_squares / bent.redundancy
    for k, part in columns_of_sizes(own, bent.observations).items():
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
    held = replace(
        chosen, control=control, control_covariance=covariance, shared_control=None
    )
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
