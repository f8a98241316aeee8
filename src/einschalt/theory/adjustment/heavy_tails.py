"""How precise the good ones are among observations of which some are much worse.

A share ε of the observations has errors k times as large as the others:

    f(e) = (1 − ε) φ(e / σ) / σ + ε φ(e / kσ) / (kσ)

σ, ε and k are those of the largest likelihood, by expectation and maximisation: with
the probability p of each observation to be one of the worse, σ² is the mean of e² with
the weights 1 − p + p / k². A median sees σ too large as soon as there are many.

Residuals are no errors: those of a small model carry some of its worse observations
over to its good ones, and a fit that gives these less weight has chosen them by the
same residuals. Where models are fitted, their parameters are drawn, given which
observations are worse, and then which are worse, given the errors from there; the
figures are of the largest likelihood of these errors, the mean over many draws. The
parameters are so taken for what they are, unknown.

Source: Tukey (1960) for the distribution; Dempster, Laird & Rubin (1977); Celeux &
Diebolt (1985) for the draws.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc, ndtr

from einschalt.foundations.batches import segment_sum
from einschalt.theory.adjustment.norms import SIGMA_PER_MEDIAN

# observations that tell a share from chance
FEWEST = 50
MOST_STEPS = 500
SETTLED = 1e-8
# the worse ones are at least so many times as wide, and never the majority
LEAST_FACTOR, MOST_FACTOR = 2.0, 1e3
MOST_SHARE = 0.5
# beyond so many standard errors an observation is far out
FAR_OUT = 3.0
FAR_OUT_BY_CHANCE = float(2.0 * ndtr(-FAR_OUT))
N_FURTHER = 2
# more observations tell the three figures no better than to one per cent
MOST_OBSERVATIONS = 20_000
MOST_DRAWN = 5000
# draws, and those of them from which on the figures have settled
N_DRAWS, N_SETTLING = 150, 50
# of the largest eigenvalue: parameters that are determined less well are held
LEAST_EIGENVALUE = 1e-12


@dataclass(frozen=True)
class HeavyTails:
    """Normal errors of which a share is much larger than the others.

    Attributes
    ----------
    sigma : float
        Standard error of the good ones, in units of the observations.
    share, factor : float
        Share of the others, and how many times as large their errors are.
    far_out : float
        Share of all observations beyond three standard errors of the good ones; 0.0027
        by chance.
    p_value : float
        Probability that errors without such a share look like these.
    """

    sigma: float
    share: float
    factor: float
    far_out: float
    p_value: float


def find_heavy_tails(errors) -> HeavyTails | None:
    """Tell good observations from a share of worse ones.

    Parameters
    ----------
    errors : array_like
        Errors of mean 0, (n,): residuals over the root of their redundancy numbers.
        Sizes will do.

    Returns
    -------
    HeavyTails or None
        None for fewer than 50 errors that are not 0.
    """
    squares = np.square(np.asarray(errors, dtype=float))
    # what fits exactly has no error of any size
    squares = squares[np.isfinite(squares) & (squares > 0.0)]
    if len(squares) < FEWEST:
        return None
    some = squares[:: 1 + (len(squares) - 1) // MOST_OBSERVATIONS]
    sigma, share, factor = _maximised(some)
    mixed = np.logaddexp(*_log_densities(some, sigma, share, factor)).sum()
    plain = -0.5 * len(some) * (np.log(some.mean()) + 1.0)
    p_value = float(chdtrc(N_FURTHER, max(2.0 * (mixed - plain), 0.0)))
    far_out = float(np.mean(squares > (FAR_OUT * sigma) ** 2))
    return HeavyTails(float(sigma), float(share), float(factor), far_out, p_value)


def find_tails_of_models(rows, misfits, start, first) -> HeavyTails:
    """Tell good observations from worse ones where models are fitted to them.

    Parameters
    ----------
    rows : ndarray, shape (n, n_parameters)
        Of the observations by the parameters of their model: misfit = row @ parameters
        + error, the errors of equal size.
    misfits : ndarray, shape (n,)
        In the unit of the errors.
    start : ndarray of int, shape (n_models + 1,)
        First row of each model; a model has more observations than parameters.
    first : HeavyTails
        By the residuals of the models, to begin with.

    Returns
    -------
    HeavyTails
        With the probability of ``first``.
    """
    rows, misfits, start = _some_models(rows, misfits, start)
    fit, rng = _Fit(rows, misfits, start), np.random.default_rng(0)
    is_worse = np.zeros(len(misfits), dtype=bool)
    errors = fit.errors(is_worse, first, None)
    tails, found = first, []
    for turn in range(N_DRAWS):
        probability = _of_being_worse(errors**2, tails.sigma, tails.share, tails.factor)
        sigma, share, factor = _improved(errors**2, probability, tails.factor)
        tails = replace(tails, sigma=sigma, share=share, factor=factor)
        is_worse = rng.random(len(errors)) < probability
        errors = fit.errors(is_worse, tails, rng)
        if turn >= N_SETTLING:
            far_out = np.mean(np.abs(errors) > FAR_OUT * tails.sigma)
            found.append((np.log(tails.sigma), tails.share, tails.factor, far_out))
    log_sigma, share, factor, far_out = map(float, np.mean(found, axis=0))
    return HeavyTails(float(np.exp(log_sigma)), share, factor, far_out, first.p_value)


def _some_models(rows, misfits, start):
    """So many models that draws take no longer than they are worth."""
    step = 1 + (len(misfits) - 1) // MOST_DRAWN
    n_points = np.diff(start)
    is_used = np.arange(len(n_points)) % step == 0
    rows_used = np.repeat(is_used, n_points)
    start = np.append(0, np.cumsum(n_points[is_used]))
    return rows[rows_used], misfits[rows_used], start


class _Fit:
    """Many small models, their parameters such that they have no correlations."""

    def __init__(self, rows, misfits, start):
        self.misfits, self.start = misfits, start
        self.model = np.repeat(np.arange(len(start) - 1), np.diff(start))
        values, vectors = np.linalg.eigh(self._normals(rows, rows))
        is_known = values > LEAST_EIGENVALUE * values[:, -1:]
        scale = np.where(is_known, np.where(is_known, values, 1.0) ** -0.5, 0.0)
        turned = vectors * scale[:, None, :]
        self.rows = np.einsum("ni,nij->nj", rows, turned[self.model])
        # what is held has no part in any misfit
        self.held = np.eye(rows.shape[1]) * ~is_known[:, None, :]

    def _normals(self, rows, others):
        return segment_sum(rows[:, :, None] * others[:, None, :], self.start)

    def errors(self, is_worse, tails, rng):
        """Errors of the observations (n,), with parameters at the best or drawn."""
        weighted = np.where(is_worse, tails.factor**-2.0, 1.0)[:, None] * self.rows
        factor = np.linalg.cholesky(self._normals(weighted, self.rows) + self.held)
        right = segment_sum(weighted * self.misfits[:, None], self.start)
        turned = np.linalg.solve(factor, right[..., None])
        if rng is not None:
            turned = turned + tails.sigma * rng.standard_normal(turned.shape)
        parameters = np.linalg.solve(np.swapaxes(factor, 1, 2), turned)[..., 0]
        return self.misfits - np.sum(self.rows * parameters[self.model], axis=1)


def _log_densities(squares, sigma, share, factor):
    """Of the good and of the others, but for a common constant, (2, n)."""
    good = np.log1p(-share) - np.log(sigma) - squares / (2.0 * sigma**2)
    wide = sigma * factor
    worse = np.log(max(share, np.finfo(float).tiny)) - np.log(wide)
    return np.stack([good, worse - squares / (2.0 * wide**2)])


def _maximised(squares):
    """The good ones' standard error, the share of the others and their factor."""
    sigma = SIGMA_PER_MEDIAN * np.sqrt(np.median(squares))
    is_far = squares > (FAR_OUT * sigma) ** 2
    share = min(max(is_far.mean(), 1.0 / len(squares)), MOST_SHARE)
    wide = np.sqrt(squares[is_far].mean()) if is_far.any() else LEAST_FACTOR * sigma
    factor = min(max(wide / sigma, LEAST_FACTOR), MOST_FACTOR)
    for _ in range(MOST_STEPS):
        probability = _of_being_worse(squares, sigma, share, factor)
        new, share, factor = _improved(squares, probability, factor)
        change, sigma = abs(np.log(new / sigma)), new
        if change < SETTLED:
            break
    return sigma, share, factor


def _of_being_worse(squares, sigma, share, factor):
    """Probability of each observation to be one of the worse, (n,)."""
    good, worse = _log_densities(squares, sigma, share, factor)
    return np.exp(worse - np.logaddexp(good, worse))


def _improved(squares, probability, factor):
    """The three figures that follow from the probabilities."""
    weight = 1.0 - probability + probability / factor**2
    sigma = np.sqrt(np.mean(weight * squares))
    share = min(probability.mean(), MOST_SHARE)
    total = probability.sum()
    if total > 0.0:
        factor = np.sqrt((probability * squares).sum() / total) / sigma
    return sigma, share, min(max(factor, LEAST_FACTOR), MOST_FACTOR)
