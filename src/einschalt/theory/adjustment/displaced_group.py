"""Whether some given points, wherever they lie, are displaced by the same vector.

As in :mod:`.displaced_regions`, but of points that no region holds, as where two lists
of another origin are mixed. Every subset is possible, so that which one it is has to be
chosen from all of its size. With the scores u, the information W and a group p

    T = |pᵀu|² / pᵀWp

is χ² with two degrees of freedom without a displacement; where all errors are larger
than stated by one factor, T over uᵀ W⁺ u has the beta distribution. The largest of n
steps along the first principal axis of W⁺ u begins, and points are taken in or out as
long as T grows. Single errors that are not alike are no group, and neither is what a
smooth strain of the network explains better.

See docs/theory/claim.md.
"""

import numpy as np
from scipy.special import gammaln

from einschalt.theory.adjustment.displaced_regions import DisplacedRegion
from einschalt.theory.adjustment.smooth_pattern import LEAST_RANK, smooth_pattern

FEWEST = 3  # points of a group, and outside it
# of variances: where what is left is larger than stated by more, it is something else
MOST_LEFT = 4.0
MOST_STEPS = 1000
CLEARER = 1.0 + 1e-9  # beyond rounding


def find_displaced_group(scores, information, xy, significance, region=()):
    """Find the points that are displaced by one vector against all others.

    Parameters
    ----------
    scores : ndarray, complex, shape (n,)
        Weight times correction of each given point, east + i north [1/m].
    information : ndarray, shape (n, n)
        What is known of the errors of either coordinate [1/m²].
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
    if n < 2 * FEWEST:
        return None
    known = _Known(scores, information)
    is_in = _grown(known, _first(known))
    square, degrees = known.square(is_in), 2.0 * (known.rank - 1)
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
    is_clearest = square / left - choice > otherwise
    if not is_clearest or not known.are_alike(is_in, significance, left):
        return None
    return known.told(is_in, left, p_value)


class _Known:
    """What is known of the errors of given points: scores, and their information."""

    def __init__(self, scores, information):
        self.scores, self.information = scores, information
        values, vectors = np.linalg.eigh((information + information.T) / 2.0)
        is_known = values > LEAST_RANK * values.max(initial=0.0)
        self.rank = int(np.count_nonzero(is_known))
        vectors, values = vectors[:, is_known], values[is_known]
        self.errors = (vectors / values) @ (vectors.T @ scores)  # the shortest ones
        self.whole = float(np.real(np.vdot(scores, self.errors)))

    def of(self, is_in):
        """Information of a part, and the sum of its scores."""
        return float(is_in @ self.information @ is_in), self.scores[is_in].sum()

    def square(self, is_in):
        """χ² of a part."""
        return float(_square(*self.of(is_in)))

    def of_strain(self, xy, left):
        """Twice the logarithm of the likelihood ratio of a smooth strain."""
        on_axes = np.column_stack([self.scores.real, self.scores.imag]) / left
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

    def told(self, is_in, left, p_value):
        """The smaller part, and how far it is displaced."""
        known, right = self.of(is_in)
        shift = right / known
        if 2 * np.count_nonzero(is_in) > len(is_in):
            is_in, shift = ~is_in, -shift
        return DisplacedRegion(
            rows=np.flatnonzero(is_in),
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
    best = int(np.argmax(np.where(_is_part(np.arange(1, n + 1), n), squares, -1.0)))
    is_in = np.zeros(n, dtype=bool)
    is_in[order[: best + 1]] = True
    return is_in


def _grown(known, is_in):
    """The part with points taken in or out as long as that makes it clearer, (n,)."""
    is_in, own = is_in.copy(), np.diagonal(known.information)
    for _ in range(MOST_STEPS):
        of_part, right = known.of(is_in)
        sign = np.where(is_in, -1.0, 1.0)
        changed = of_part + 2.0 * sign * (known.information @ is_in) + own
        squares = _square(changed, right + sign * known.scores)
        is_allowed = _is_part(np.count_nonzero(is_in) + sign, len(is_in))
        squares = np.where(is_allowed, squares, -1.0)
        best = int(np.argmax(squares))
        if not squares[best] > float(_square(of_part, right)) * CLEARER:
            break
        is_in[best] = not is_in[best]
    return is_in


def _is_part(size, n):
    """Whether so many of n points are a part, and the others one as well."""
    return (size >= FEWEST) & (n - size >= FEWEST)


def _square(known, right):
    """χ² of parts; 0 where nothing is known of them."""
    known = np.asarray(known, dtype=float)
    is_known = known > 0.0
    return np.where(is_known, np.abs(right) ** 2 / np.where(is_known, known, 1.0), 0.0)


def _log_choose(n, k):
    return float(gammaln(n + 1) - gammaln(k + 1) - gammaln(n - k + 1))
