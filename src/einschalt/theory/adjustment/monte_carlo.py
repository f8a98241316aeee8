"""Errors drawn at random and carried through linear steps.

Sums over correlated quantities have no distribution in closed form. Their means and
variances follow from some hundred draws of all errors, pushed through the operators of
the propagation, which form no product of matrices.

Source: Satterthwaite 1946; Wilson and Hilferty 1931; see docs/theory/claim.md.
"""

import numpy as np
from scipy.special import chdtrc, stdtr  # scipy.stats takes a second to import

# draws that know the variance of a sum to a tenth
ENOUGH_DRAWS = 50
NUMBERS_AT_ONCE = 4_000_000


def draw_errors(standard_errors, axes, *, n_draws, seed):
    """Draw normal errors of all sources, packed, (n_numbers, n_draws) each [m].

    The standard errors of each source's observations are per coordinate [m], with a
    column for each axis where they differ. A generator as
    ``seed`` goes on from where it is.
    """
    rng = np.random.default_rng(seed)
    return {
        source: axes.draw(rng, sizes, n_draws)
        for source, sizes in standard_errors.items()
    }


def draws_in_parts(n_draws, n_numbers, most=NUMBERS_AT_ONCE):
    """Numbers of draws, part after part, that keep to ``most`` numbers at a time.

    ``n_numbers`` are drawn each time; a part has one draw at least.

    >>> draws_in_parts(10, 1000, 4500)
    [4, 4, 2]
    """
    at_once = max(1, min(n_draws, most // n_numbers))
    return [min(at_once, n_draws - first) for first in range(0, n_draws, at_once)]


def apply_chains(errors, chains):
    """What packed errors of each source make of quantities that are linear in them.

    A chain is the PointOperator from a source to the quantities, (n_numbers, n_draws).
    """
    return sum(chain.apply(errors[source]) for source, chain in chains.items())


def tail_of_squares(observed, drawn):
    """Probability of a sum of squares as large as this, by its draws.

    Parameters
    ----------
    observed : float
    drawn : ndarray, shape (n_draws,)
        The same sum from drawn errors.

    Returns
    -------
    float
        Upper tail of the multiple of χ² that has the mean and the variance of the
        draws (Satterthwaite 1946); NaN where they do not vary. Of fewer than 50 draws,
        which know their variance badly, Student's t of the cube roots: these are nearly
        normal (Wilson and Hilferty 1931).
    """
    if len(drawn) < ENOUGH_DRAWS:
        return tail_of_mean(np.cbrt(observed), np.cbrt(drawn))
    return _tail_by_moments(observed, np.mean(drawn), np.var(drawn, ddof=1))


def tail_of_correlated_squares(observed, covariance):
    """Probability of a sum of squares as large as this, by their covariance.

    The same of normal errors whose covariance, (n, n), is known: the sum has the mean
    tr C and the variance 2 tr C².

    >>> round(tail_of_correlated_squares(18.31, np.eye(10)), 3)
    0.05
    """
    mean, variance = np.trace(covariance), 2.0 * np.sum(covariance**2)
    return _tail_by_moments(observed, mean, variance)


def _tail_by_moments(observed, mean, variance):
    if not (mean > 0.0 and variance > 0.0):
        return np.nan
    degrees = 2.0 * mean**2 / variance
    return float(chdtrc(degrees, degrees * max(observed, 0.0) / mean))


def tail_of_mean(observed, drawn):
    """Probability of a nearly normal statistic as large as this, by its draws.

    Upper tail of Student's t, n_draws − 1 degrees of freedom, of a further value
    against the draws; NaN where they do not vary.
    """
    n_draws = len(drawn)
    spread = np.std(drawn, ddof=1) * np.sqrt(1.0 + 1.0 / n_draws)
    if not spread > 0.0:
        return np.nan
    return float(stdtr(n_draws - 1, -(observed - np.mean(drawn)) / spread))
