"""Whether some given points, wherever they lie, are displaced by the same vector.

As in :mod:`.displaced_regions`, but of points that no region holds, as where two lists
of another origin are mixed. Every subset is possible, so that which one it is has to be
chosen from all of its size. With the scores u, the information W and a group p

    T = |pᵀu|² / pᵀWp

is χ² with two degrees of freedom without a displacement, one of heights; where all
errors are larger than stated by one factor, T over uᵀ W⁺ u has the beta distribution.
The largest of n steps along the first principal axis of W⁺ u begins, and so does each
point by itself; points are taken in or out as long as T grows. Single errors that are
not alike are no group, and neither is what a smooth strain of the network, one point,
or larger errors of all points explain better.

See docs/theory/claim.md.
"""

import numpy as np
from scipy.special import chdtrc, gammaln

from einschalt.theory.adjustment.displaced_regions import DisplacedRegion
from einschalt.theory.adjustment.smooth_pattern import LEAST_RANK, smooth_pattern

# points of a group, and outside it: of one coordinate, and of two, in which single
# errors are not so soon alike by chance
FEWEST = {1: 4, 2: 3}
# of variances: where what is left is larger than stated by more, it is something else
MOST_LEFT = 4.0
MOST_STEPS = 1000
N_SIZES = 60  # of errors that all points may have besides
MOST_STARTS = 100  # points by themselves, those that stand out most
CLEARER = 1.0 + 1e-9  # beyond rounding


def find_displaced_group(scores, information, xy, significance, region=()):
    """Find the points that are displaced by one vector against all others.

    Parameters
    ----------
    scores : ndarray, complex or real, shape (n,)
        Weight times correction of each given point, east + i north [1/m]; or of its
        height, of which the probabilities are upper bounds then.
    information : ndarray, shape (n, n)
        What is known of the errors of either coordinate, or of heights [1/m²].
    xy : ndarray, shape (n, 2)
        Easting, northing [m].
    significance : float
        Probability with which good points have a group.
    region : sequence of int
        Points that a scan has found to be displaced together: a group must explain
        more than they do, beyond what its choice gains.

    Returns
    -------
    DisplacedRegion or None
        The smaller part; its p-value is that of all subsets of its size together.
    """
    n = len(scores)
    known = _Known(scores, information)
    if n < 2 * known.fewest:
        return None
    is_in = _clearest(known)
    if is_in is None:
        return None
    square, degrees = known.square(is_in), known.n_axes * (known.rank - 1.0)
    whole = max(known.whole, square)
    if degrees <= 0.0 or not square > 0.0:
        return None
    left = max((whole - square) / degrees, 1.0)
    # of which size there are so many groups, and so many sizes
    choice = 2.0 * (_log_choose(n, np.count_nonzero(is_in)) + np.log(n))
    # of errors of the stated sizes, and where all are larger by one factor (beta
    # distribution): twice the logarithms of the likelihoods
    if square < whole:
        gained = min(square, -degrees * np.log1p(-square / whole)) - choice
    else:
        gained = square - choice
    p_value = min(float(np.exp(-gained / 2.0)), 1.0)
    if left > MOST_LEFT or p_value > significance:
        return None
    is_region = np.isin(np.arange(n), region)
    otherwise = max(known.square(is_region) / left, known.of_strain(xy, left))
    otherwise = max(otherwise, known.of_one_point() / left - 2.0 * np.log(n))
    is_clearest = square / left - choice > otherwise
    if not is_clearest or not known.are_alike(is_in, significance, left):
        return None
    if known.beyond_larger_errors(is_in) - choice < -2.0 * np.log(significance):
        return None
    if known.chance_of_one_vector(is_in) < significance:
        return None
    return known.told(is_in, left, p_value)


class _Known:
    """What is known of the errors of given points: scores, and their information."""

    def __init__(self, scores, information):
        self.scores, self.information = scores, information
        self.n_axes = 2 if np.iscomplexobj(scores) else 1
        self.fewest = FEWEST[self.n_axes]
        values, vectors = np.linalg.eigh((information + information.T) / 2.0)
        is_known = values > LEAST_RANK * values.max(initial=0.0)
        self.rank = int(np.count_nonzero(is_known))
        vectors, values = vectors[:, is_known], values[is_known]
        self.vectors, self.values = vectors, values
        self.errors = (vectors / values) @ (vectors.T @ scores)  # the shortest ones
        self.whole = float(np.real(np.vdot(scores, self.errors)))

    def of(self, is_in):
        """Information of a part, and the sum of its scores."""
        return float(is_in @ self.information @ is_in), self.scores[is_in].sum()

    def is_part(self, size):
        """Whether so many points are a part, and the others one as well."""
        n_others = len(self.scores) - size
        return (size >= self.fewest) & (n_others >= self.fewest)

    def square(self, is_in):
        """χ² of a part."""
        return float(_square(*self.of(is_in)))

    def of_one_point(self):
        """The largest χ² of a point by itself."""
        return float(_square(np.diagonal(self.information), self.scores).max())

    def beyond_larger_errors(self, is_in):
        """Twice the logarithm of the likelihood ratio of a part, beside larger errors.

        All points may have an error of their own besides, with the variance τ², which
        those that are stated do not have: its size is the likeliest one with the part,
        and without it.
        """
        spread = np.geomspace(1e-2, 1e6, N_SIZES) / self.values.max(initial=1e-300)
        variance = 1.0 + np.append(0.0, spread)[:, None] * self.values
        shown = self.vectors.T @ self.scores
        part = self.vectors.T @ is_in.astype(float)
        whole = np.sum(np.abs(shown) ** 2 / self.values / variance, axis=1)
        known = np.sum(np.abs(part * self.values) ** 2 / self.values / variance, axis=1)
        right = np.sum(part.conj() * shown / variance, axis=1)
        without = self.n_axes * np.log(variance).sum(axis=1) + whole
        return float(without.min() - (without - _square(known, right)).min())

    def of_strain(self, xy, left):
        """Twice the logarithm of the likelihood ratio of a smooth strain."""
        parts = (self.scores.real, self.scores.imag)[: self.n_axes]
        on_axes = np.column_stack(parts) / left
        strain = smooth_pattern(on_axes, self.information / left, xy)
        return float(np.nan_to_num(strain.likelihood_ratio))

    def are_alike(self, is_in, significance, left):
        """Whether no point lies apart from where the part, or the rest, has it.

        Single errors that are not alike have a mean as well.
        """
        known, right = self.of(is_in)
        shown = self.information @ is_in
        own = np.diagonal(self.information) - shown**2 / known
        rest = self.scores - shown * (right / known)
        squares = _square(np.maximum(own, 0.0), rest) / left
        return bool(len(rest) * np.exp(-squares.max() / 2.0) > significance)

    def chance_of_one_vector(self, is_in):
        """Probability that the smaller part is off by one vector and no more.

        Against vectors of its points' own: of χ², with the variance that these leave.
        """
        part = np.flatnonzero(_smaller(is_in))
        inner, scores = self.information[np.ix_(part, part)], self.scores[part]
        own = np.linalg.pinv(inner, rcond=LEAST_RANK, hermitian=True) @ scores
        freed = float(np.real(np.vdot(scores, own)))
        degrees = self.n_axes * (self.rank - len(part))
        left = max((self.whole - freed) / degrees, 1.0) if degrees > 0 else 1.0
        more = max(freed - self.square(is_in), 0.0) / left
        return float(chdtrc(self.n_axes * (len(part) - 1), more))

    def told(self, is_in, left, p_value):
        """The smaller part, and how far it is displaced."""
        known, right = self.of(is_in)
        shift = right / known
        smaller = _smaller(is_in)
        shift = shift if smaller is is_in else -shift
        return DisplacedRegion(
            rows=np.flatnonzero(smaller),
            shift=np.array([shift.real, shift.imag]),
            standard_error=float(np.sqrt(left / known)),
            p_value=p_value,
        )


def _first(known):
    """The clearest part beyond a step along the principal axis of the errors, (n,)."""
    n = len(known.scores)
    errors = known.errors - known.errors.mean()
    # the direction in which complex errors spread most
    axis = np.exp(0.5j * np.angle(np.sum(errors**2)))
    order = np.argsort(np.real(errors * np.conj(axis)), kind="stable")
    inner = known.information[np.ix_(order, order)]
    of_parts = np.diagonal(np.cumsum(np.cumsum(inner, axis=0), axis=1))
    squares = _square(of_parts, np.cumsum(known.scores[order]))
    best = int(np.argmax(np.where(known.is_part(np.arange(1, n + 1)), squares, -1.0)))
    is_in = np.zeros(n, dtype=bool)
    is_in[order[: best + 1]] = True
    return is_in


def _clearest(known):
    """The clearest of the parts that any start grows to, (n,), or None."""
    n = len(known.scores)
    own = np.diagonal(known.information)
    alone = np.argsort(-_square(own, known.scores), kind="stable")[:MOST_STARTS]
    starts = np.vstack([_first(known), np.eye(n, dtype=bool)[alone]])
    grown, squares = _grown(known, starts)
    squares = np.where(known.is_part(grown.sum(axis=1)), squares, -1.0)
    best = int(np.argmax(squares))
    return grown[best] if squares[best] > 0.0 else None


def _grown(known, starts):
    """Parts with points taken in or out as long as that makes them clearer.

    All of them, (n_starts, n), and their χ².
    """
    is_in, own = starts.copy(), np.diagonal(known.information)
    every = np.arange(len(starts))
    for _ in range(MOST_STEPS):
        shown = is_in @ known.information
        of_part, right = np.sum(shown * is_in, axis=1), is_in @ known.scores
        squares = _square(of_part, right)
        sign = np.where(is_in, -1.0, 1.0)
        changed = of_part[:, None] + 2.0 * sign * shown + own
        further = _square(changed, right[:, None] + sign * known.scores)
        size = is_in.sum(axis=1)[:, None] + sign
        further = np.where((size > 0) & (size < is_in.shape[1]), further, -1.0)
        best = np.argmax(further, axis=1)
        grows = further[every, best] > squares * CLEARER
        if not grows.any():
            break
        is_in[every[grows], best[grows]] ^= True
    return is_in, squares


def _smaller(is_in):
    """A part, or all other points where these are fewer."""
    return ~is_in if 2 * np.count_nonzero(is_in) > len(is_in) else is_in


def _square(known, right):
    """χ² of parts; 0 where nothing is known of them."""
    known = np.asarray(known, dtype=float)
    is_known = known > 0.0
    return np.where(is_known, np.abs(right) ** 2 / np.where(is_known, known, 1.0), 0.0)


def _log_choose(n, k):
    return float(gammaln(n + 1) - gammaln(k + 1) - gammaln(n - k + 1))
