"""How precise the good ones are among observations of which some are much worse.

A share ε of the observations has errors k times as large as the others:

    f(e) = (1 − ε) φ(e / σ) / σ + ε φ(e / kσ) / (kσ)

σ, ε and k are those of the largest likelihood, by expectation and maximisation: with
the probability p of each observation to be one of the worse, σ² is the mean of e² with
the weights 1 − p + p / k². A median sees σ too large as soon as there are many.

Source: Tukey (1960) for the distribution; Dempster, Laird & Rubin (1977).
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, ndtr

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
        good, worse = _log_densities(squares, sigma, share, factor)
        probability = np.exp(worse - np.logaddexp(good, worse))
        weight = 1.0 - probability + probability / factor**2
        new = np.sqrt(np.mean(weight * squares))
        share = min(probability.mean(), MOST_SHARE)
        total = probability.sum()
        if total > 0.0:
            factor = np.sqrt((probability * squares).sum() / total) / new
        factor = min(max(factor, LEAST_FACTOR), MOST_FACTOR)
        change, sigma = abs(np.log(new / sigma)), new
        if change < SETTLED:
            break
    return sigma, share, factor
