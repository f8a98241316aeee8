"""How large the errors of each source are, judged by the measurements.

Several sums of squares are formed of quantities that would vanish without errors. Each
is, on the average, a known linear combination of the variances of the sources:

    E[S_j] = Σ_k f_k tr(P_j L_jk Σ_k Lᵀ_jk),

f_k being the factor of the variances of source k against the given ones, L_jk the error
operator, and P_j the diagonal matrix of weights, one over the expected square of each
quantity: otherwise a few points of a weak model are the whole sum. The factors are
estimated by least squares, weighted by the covariances of the sums.

Source: Helmert 1907 (estimation of components from sums of squares); Rao 1971; see
docs/theory/variance_components.md.
"""

from collections import Counter
from dataclasses import dataclass
from functools import reduce
from itertools import combinations_with_replacement, pairwise, product
from operator import add

import numpy as np

from einschalt.theory.adjustment.monte_carlo import draw_errors, draws_in_parts
from einschalt.theory.adjustment.needed_errors import needed_errors
from einschalt.theory.adjustment.point_operator import PointOperator

MOST_DRAWS, FEWEST_DRAWS = 100, 15
# of all draws: in large blocks chance leaves less of the mean of each sum
NUMBERS_IN_ALL = 5_000_000
# one draw in so many besides them tells how large the numbers of the sums are
WEIGHED_BY, FEWEST_TO_WEIGH = 3, 8
# of the mean of a sum, and of the largest of these means: what has less is rounding, as
# where a model, or all of a flight, has no redundancy
LEAST_SQUARE, LEAST_MEAN = 1e-8, 1e-16
N_ITERATIONS = 20
TOLERANCE = 1e-4
LEAST_FACTOR = 1e-4
# parts of 32 MB at most, whose memory is used again; larger ones are fetched anew
NUMBERS_AT_ONCE = 2_000_000
# of those that go through the chains together, which caches hold: 1 MB; and the fewest
# draws for which a step is worth its call
NUMBERS_TOGETHER, FEWEST_TOGETHER = 125_000, 20


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


def estimate_factors(
    sums, standard_errors, seed=0, *, held=None, are_of_part=False
) -> VarianceFactors:
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
    are_of_part : bool
        Whether the sums are those of a part of the block, which many errors do not
        reach; these are not drawn.

    Returns
    -------
    VarianceFactors
        No factor is negative.

    Raises
    ------
    LinAlgError
        The sums do not tell one source from another; those that are rounding are none.

    Notes
    -----
    Means and covariances of the sums come from 100 draws of all errors (15 in blocks of
    some 20 000 models and more), which need no product of the matrices. Only the scalar
    products of the drawn parts are kept, so that no draw is repeated while the factors
    change. The standard errors are uncertain by 7 % (19 %) through that, the factors by
    a fraction of their standard errors.
    """
    sources = tuple(standard_errors)
    chains = _by_rows([part.chains for part in sums])
    if are_of_part:
        chains, standard_errors = needed_errors(chains, standard_errors)
    n_numbers = [len(part.values) for part in sums]
    drawn = _DrawnSums(chains, n_numbers, standard_errors, seed)
    told = drawn.told
    observed = drawn.of_values([part.values for part in sums])[told]
    products = drawn.products()[:, told]
    design = np.einsum("djkk->jk", products) / len(products)
    held = {name: held[name] for name in sources if name in (held or {})}
    is_free = np.array([name not in held for name in sources])
    if len(told) < is_free.sum():
        raise np.linalg.LinAlgError("fewer sums of squares than sources")
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


class _DrawnSums:
    """Sums of squares, each number over its own size, and draws of all errors.

    Sizes come from other draws than means and covariances of the sums: these would
    otherwise be too regular.
    """

    def __init__(self, chains, n_numbers, standard_errors, seed):
        self._chains, self._errors = chains, standard_errors
        self._n_numbers = n_numbers
        self._seed = seed
        self._axes = next(iter(chains[0].values())).axes
        sizes = standard_errors.values()
        self._longest = max(self._axes.size(len(each)) for each in sizes)
        n_all = NUMBERS_IN_ALL // self._longest
        self._n_all = int(np.clip(n_all, FEWEST_DRAWS, MOST_DRAWS))
        self._weights = self._inverse_squares()

    @property
    def told(self):
        """Places of the sums that are more than rounding."""
        return np.flatnonzero([weights.any() for weights in self._weights])

    def of_values(self, values):
        """Sums of squares of observed numbers, (n_sums,)."""
        pairs = zip(self._weights, values, strict=True)
        return np.array([np.sum(w * np.abs(each) ** 2) for w, each in pairs])

    def products(self):
        """Scalar products of drawn parts, (n_draws, n_sums, n_sources, n_sources)."""
        n_sums, n_sources = len(self._chains), len(self._errors)
        products = np.empty((self._n_all, n_sums, n_sources, n_sources))
        first = 0
        n_together = max(NUMBERS_TOGETHER // self._longest, FEWEST_TOGETHER)
        parts = self._parts(self._n_all, self._seed, n_together)
        for n_draws, place, drawn in parts:
            weights = self._weights[place]
            for k, m in combinations_with_replacement(range(n_sources), 2):
                of_pair = _scalar_products(drawn[k], drawn[m], weights)
                products[first : first + n_draws, place, k, m] = of_pair
                products[first : first + n_draws, place, m, k] = of_pair
            first += n_draws * (place == n_sums - 1)
        return products

    def _inverse_squares(self):
        """One over the mean square of each number; 0 where all errors cancel."""
        n_draws = max(self._n_all // WEIGHED_BY, FEWEST_TO_WEIGH)
        squares = [np.zeros(n) for n in self._n_numbers]
        for _, place, drawn in self._parts(n_draws, [self._seed, 1]):
            together = reduce(add, (part for part in drawn if part is not None))
            squares[place] += np.sum(np.abs(together) ** 2, axis=1) / n_draws
        means = np.array([each.mean() for each in squares])
        least = np.maximum(LEAST_SQUARE * means, LEAST_MEAN * means.max())
        return [
            np.divide(1.0, each, out=np.zeros(len(each)), where=each > low)
            for each, low in zip(squares, least, strict=True)
        ]

    def _parts(self, n_all, seed, n_together=MOST_DRAWS):
        """Draws of each sum in parts: their number, place of the sum, by source.

        At least ``n_together`` draws in a part, if there are as many.
        """
        rng, axes = np.random.default_rng(seed), self._axes
        for n_draws in draws_in_parts(n_all, self._longest, NUMBERS_AT_ONCE):
            errors = draw_errors(self._errors, axes, n_draws=n_draws, seed=rng)
            for columns in _even_parts(n_draws, n_together):
                some = {
                    k: np.ascontiguousarray(e[:, columns]) for k, e in errors.items()
                }
                through = _Through(self._chains, some)
                for place, of_sum in enumerate(self._chains):
                    drawn = [through.applied(name, of_sum.get(name)) for name in some]
                    yield columns.stop - columns.start, place, drawn


def _even_parts(n, least):
    """Slices of n columns, none of fewer than ``least`` unless there are fewer.

    >>> _even_parts(50, 20)
    [slice(0, 25, None), slice(25, 50, None)]
    """
    ends = np.linspace(0, n, max(n // least, 1) + 1).astype(int).tolist()
    return [slice(*pair) for pair in pairwise(ends)]


def _by_rows(chains):
    """The same chains of each sum by rows; factors that they share stay shared."""
    rows = {}

    def by_rows(one):
        for factor in one.factors:
            rows.setdefault(id(factor), factor.tocsr())
        return PointOperator(tuple(rows[id(f)] for f in one.factors), one.axes)

    return [
        {
            name: PointOperator.sum_of(map(by_rows, chain.products))
            for name, chain in part.items()
        }
        for part in chains
    ]


class _Through:
    """Drawn errors on their way through chains; what ends alike is done once."""

    def __init__(self, chains, errors):
        self._errors = errors
        self._uses = Counter(
            key
            for part in chains
            for source, chain in part.items()
            for one in chain.products
            for key in _ends(source, one)
        )
        self._done = {}

    def applied(self, source, chain):
        """What the errors of a source become; None where they do not enter."""
        if chain is None:
            return None
        return reduce(add, (self._through(source, one) for one in chain.products))

    def _through(self, source, one):
        drawn = self._errors[source]
        for factor, key in zip(one.factors[::-1], _ends(source, one), strict=True):
            self._uses[key] -= 1
            if key in self._done:
                drawn = self._done[key]
            else:
                drawn = PointOperator((factor,), one.axes).apply(drawn)
            if self._uses[key]:
                self._done[key] = drawn
            else:  # nobody needs it any more
                self._done.pop(key, None)
        return drawn


def _ends(source, one):
    """Name the factors at the end of a product, one and more: applied first."""
    parts = tuple(map(id, one.factors[::-1]))
    return [(source, *parts[:length]) for length in range(1, len(parts) + 1)]


def _scalar_products(first, second, weights):
    """Real parts of the weighted scalar products of columns, (n_draws,)."""
    if first is None or second is None:  # 0 without a source
        return 0.0
    n_draws = first.shape[1]
    # along rows first: many times quicker than along both parts of a number
    sums = np.einsum("n,nk,nk->k", weights, first.view(float), second.view(float))
    return sums.reshape(n_draws, -1).sum(axis=1)


def _covariance_of_sums(products, factors):
    size = np.sqrt(factors)
    drawn = np.einsum("djkm,k,m->dj", products, size, size)
    return np.atleast_2d(np.cov(drawn, rowvar=False))
