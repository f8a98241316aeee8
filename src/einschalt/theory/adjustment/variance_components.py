"""How large the errors of each source are, judged by the measurements.

Several sums of squares are formed of quantities that would vanish without errors. Each
is, on the average, a known linear combination of the variances of the sources:

    E[S_j] = Σ_k f_k tr(L_jk Σ_k Lᵀ_jk),

f_k being the factor of the variances of source k against the given ones, and L_jk the
error operator. The factors are estimated by least squares, weighted by the covariances
of the sums.

Source: Helmert 1907 (estimation of components from sums of squares); Rao 1971; see
docs/theory/variance_components.md.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from einschalt.theory.adjustment.monte_carlo import draw_errors, draws_in_parts

MOST_DRAWS, FEWEST_DRAWS = 100, 30
# of all draws: in large blocks chance leaves less of the mean of each sum
NUMBERS_IN_ALL = 15_000_000
N_ITERATIONS = 20
TOLERANCE = 1e-4
LEAST_FACTOR = 1e-4
NUMBERS_AT_ONCE = 4_000_000


@dataclass(frozen=True, eq=False)
class SumOfSquares:
    """One sum of squares, and how it comes from the errors of all sources."""

    # (n_numbers,): observed quantities that vanish without errors, packed [m]
    values: np.ndarray
    # of PointOperator, from the errors of each source; one that has none does not enter
    chains: dict


@dataclass(frozen=True, eq=False)
class VarianceFactors:
    """Factors of the given variances of all sources."""

    sources: tuple[str, ...]
    factors: np.ndarray  # (n_sources,), 1 where the data agree with what was given
    covariance: np.ndarray  # (n_sources, n_sources): of the factors

    def scaled(self, source, given):
        """Standard error of a source, and how well it is known, in any unit.

        A value of 0 has the standard error to which one standard error of its factor
        leads.
        """
        place = self.sources.index(source)
        factor, error = self.factors[place], np.sqrt(self.covariance[place, place])
        value = float(np.sqrt(factor))
        # σ = √f: half of the error of f where that is small, √ of it where f vanishes
        spread = float(np.sqrt(factor + error)) - value
        slope = error / (2.0 * value) if factor > error else spread
        return float(given * value), float(given * slope)


def estimate_factors(sums, standard_errors, seed=0, *, held=None) -> VarianceFactors:
    """Estimate the factors of the variances of all sources from sums of squares.

    Parameters
    ----------
    sums : sequence of SumOfSquares
        At least as many as there are sources that are not held.
    standard_errors : dict of str to ndarray
        Given size of the errors of each source, per coordinate [m]; with a column for
        each axis where they differ.
    seed : int
        Of the draws from which means and covariances of the sums are taken.
    held : dict of str to float, optional
        Sources whose errors have the size that was given, and how well that is known:
        the standard error of the factor of their variances.

    Returns
    -------
    VarianceFactors
        No factor is negative.

    Notes
    -----
    Means and covariances of the sums come from 100 draws of all errors (30 in blocks of
    some 20 000 models and more), which need no product of the matrices. Only the scalar
    products of the drawn parts are kept, so that no draw is repeated while the factors
    change. The standard errors are uncertain by 7 % (13 %) through that, the factors by
    a fraction of their standard errors.
    """
    sources = tuple(standard_errors)
    observed = np.array([np.sum(np.abs(part.values) ** 2) for part in sums])
    products = _drawn_products(sums, standard_errors, seed)
    design = np.einsum("djkk->jk", products) / len(products)
    held = {name: held[name] for name in sources if name in (held or {})}
    is_free = np.array([name not in held for name in sources])
    unexplained = observed - design[:, ~is_free].sum(axis=1)
    factors = np.ones(len(sources))
    for _ in range(N_ITERATIONS):
        covariance = _covariance_of_sums(products, np.maximum(factors, LEAST_FACTOR))
        root = np.linalg.inv(np.linalg.cholesky(covariance))
        before, factors = factors, factors.copy()
        factors[is_free] = nonnegative_factors(
            root @ design[:, is_free], root @ unexplained
        )
        if np.max(np.abs(factors - before)) < TOLERANCE:
            break
    cofactors = np.linalg.pinv(root @ design[:, is_free])
    # what a wrong size of those that are held makes of the others
    spread = cofactors @ root @ design[:, ~is_free] * list(held.values())
    covariance = np.zeros((len(sources), len(sources)))
    covariance[np.ix_(is_free, is_free)] = cofactors @ cofactors.T + spread @ spread.T
    return VarianceFactors(sources, factors, covariance)


def nonnegative_factors(design, observed):
    """Least squares with no negative unknown, of which there are a few.

    Of all choices of those that are not 0 the best one. scipy.optimize has the same for
    many unknowns, and takes as long to be imported as blocks take to be computed.

    Parameters
    ----------
    design : ndarray, shape (n_observed, n_unknowns)
    observed : ndarray, shape (n_observed,)

    Returns
    -------
    ndarray, shape (n_unknowns,)

    Examples
    --------
    >>> nonnegative_factors(np.eye(2), np.array([3.0, -1.0])).tolist()
    [3.0, 0.0]
    """
    n_unknowns = design.shape[1]
    best, least = np.zeros(n_unknowns), observed @ observed
    for choice in product([True, False], repeat=n_unknowns):
        is_in = np.array(choice, dtype=bool)
        found = np.zeros(n_unknowns)
        found[is_in] = np.linalg.lstsq(design[:, is_in], observed)[0]
        rest = observed - design @ found
        if (found >= 0.0).all() and rest @ rest < least:
            best, least = found, rest @ rest
            if is_in.all():  # nothing fits better
                break
    return best


def _drawn_products(sums, standard_errors, seed):
    """Scalar products of drawn parts, shape (n_draws, n_sums, n_sources, n_sources)."""
    rng = np.random.default_rng(seed)
    n_sources = len(standard_errors)
    axes = next(iter(sums[0].chains.values())).axes
    longest = max(axes.size(len(sizes)) for sizes in standard_errors.values())
    n_all = int(np.clip(NUMBERS_IN_ALL // longest, FEWEST_DRAWS, MOST_DRAWS))
    products = np.empty((n_all, len(sums), n_sources, n_sources))
    chains = [
        {name: chain.by_rows() for name, chain in part.chains.items()} for part in sums
    ]
    first = 0
    for n_draws in draws_in_parts(n_all, longest, NUMBERS_AT_ONCE):
        errors = draw_errors(standard_errors, axes, n_draws=n_draws, seed=rng)
        for place, part in enumerate(sums):
            of_part = chains[place], len(part.values)
            stacked = np.stack([_drawn(*of_part, name, errors) for name in errors])
            products[first : first + n_draws, place] = np.real(
                np.einsum("knd,mnd->dkm", stacked.conj(), stacked)
            )
        first += n_draws
    return products


def _drawn(chains, n_values, source, errors):
    """What the errors of a source make of the values; zero where they do not enter."""
    drawn = errors[source]
    if source not in chains:
        return np.zeros((n_values, drawn.shape[1]), dtype=drawn.dtype)
    return chains[source].apply(drawn)


def _covariance_of_sums(products, factors):
    size = np.sqrt(factors)
    drawn = np.einsum("djkm,k,m->dj", products, size, size)
    return np.atleast_2d(np.cov(drawn, rowvar=False))
