"""Errors drawn at random and carried through linear steps.

Sums over correlated quantities have no distribution in closed form. Their means and
variances follow from some hundred draws of all errors, pushed through the operators of
the propagation, which form no product of matrices.

Source: Satterthwaite 1946; see docs/theory/claim.md.
"""

import numpy as np
from scipy.special import chdtrc, stdtr  # scipy.stats takes a second to import

from einschalt.theory.adjustment.propagation import by_axis


def draw_errors(standard_errors, n_axes, *, n_draws, seed):
    """Draw normal errors of all sources.

    Parameters
    ----------
    standard_errors : dict of str to ndarray
        Of each source's observations, per coordinate [m]; shape (n,), or (n, n_axes)
        where the axes differ.
    n_axes : int
        1 where one complex number stands for two coordinates.
    n_draws, seed : int

    Returns
    -------
    dict of str to ndarray, shape (n · n_axes, n_draws)
        [m]; complex where one number stands for easting and northing.
    """
    rng = np.random.default_rng(seed)
    drawn = {}
    for source, sizes in standard_errors.items():
        of_axes = by_axis(sizes, n_axes).reshape(-1, 1)
        shape = (len(of_axes), n_draws)
        values = rng.standard_normal(shape)
        if n_axes == 1:
            values = values + 1j * rng.standard_normal(shape)
        drawn[source] = of_axes * values
    return drawn


def apply_chains(errors, chains):
    """What errors make of quantities that are linear in them.

    Parameters
    ----------
    errors : dict of str to ndarray, shape (n_sources · n_axes, n_draws)
    chains : dict of str to tuple of sparse arrays
        Operators of each source as a product, the quantities on the left.

    Returns
    -------
    ndarray, shape (n_quantities · n_axes, n_draws)
    """
    total = 0.0
    for source, chain in chains.items():
        part = errors[source]
        for matrix in reversed(chain):
            part = _applied(matrix.tocsr(), part)
        total = total + part
    return total


def _applied(matrix, columns):
    if np.iscomplexobj(columns) and not np.iscomplexobj(matrix):
        # two real columns for each complex one: half the work
        columns = np.ascontiguousarray(columns)
        return (matrix @ columns.view(float)).view(complex)
    return matrix @ columns


def plan_of(columns, n_axes):
    """Easting and northing of drawn quantities.

    Parameters
    ----------
    columns : ndarray, shape (n · n_axes, n_draws)
    n_axes : int

    Returns
    -------
    ndarray, shape (n, 2, n_draws)
    """
    if n_axes == 1:
        return np.stack([columns.real, columns.imag], axis=1)
    return columns.reshape(-1, n_axes, columns.shape[1])[:, :2]


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
        draws (Satterthwaite 1946); NaN where they do not vary.
    """
    mean, variance = np.mean(drawn), np.var(drawn, ddof=1)
    if not (mean > 0.0 and variance > 0.0):
        return np.nan
    degrees = 2.0 * mean**2 / variance
    return float(chdtrc(degrees, degrees * max(observed, 0.0) / mean))


def tail_of_mean(observed, drawn):
    """Probability of a nearly normal statistic as large as this, by its draws.

    Parameters
    ----------
    observed : float
    drawn : ndarray, shape (n_draws,)

    Returns
    -------
    float
        Upper tail of Student's t, n_draws − 1 degrees of freedom, of a further value
        against the draws; NaN where they do not vary.
    """
    n_draws = len(drawn)
    spread = np.std(drawn, ddof=1) * np.sqrt(1.0 + 1.0 / n_draws)
    if not spread > 0.0:
        return np.nan
    return float(stdtr(n_draws - 1, -(observed - np.mean(drawn)) / spread))
