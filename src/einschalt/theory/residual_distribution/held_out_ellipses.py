"""Error ellipses of predicted points that held-out points confirm, tails included.

The differences of held-out points are told apart into good ones, whose distribution has
tails (Student's t), and wrong ones, which may be of any size. The ellipses are as large
as the good ones ask for: 95 in 100 of them lie within their own 95 % ellipse.

See docs/theory/collocation.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from einschalt.theory.adjustment.norms import RAYLEIGH_MEDIAN

LEVEL = 0.95
LIMIT = -2.0 * np.log(1.0 - LEVEL)  # of χ² with two degrees of freedom
LEAST_POINTS = 20  # fewer do not tell tails
WRONG = 0.5  # probability of being wrong from which a point is taken for it
# in multiples of the usual size: differences that may be those of wrong points
SEEMS_WRONG = 6.0
# gain of log-likelihood from which some points are wrong, and not tails
EVIDENCE = 10.0
FREEDOM = 1.5, 100.0  # of Student's t: the last is as good as normal
SPREAD = 0.3, 2.0  # of the logarithms of the lengths of wrong ones
MOST_WRONG = 0.5
LARGE = 700.0  # exponents beyond do not fit in a number
MOST_TRIALS = 600
N_CLASSES = 200  # of lengths, so that many points take no longer than few


@dataclass(frozen=True)
class Tails:
    """How normalised lengths of held-out differences are distributed.

    Those of good points as of Student's t in the plane, those of wrong ones
    log-normally.
    """

    size: float  # of the good ones: one is what the variances say
    freedom: float  # degrees of freedom
    share_wrong: float = 0.0
    middle: float = 1.0  # of the lengths of wrong ones
    spread: float = 1.0  # of their logarithms

    def densities(self, length):
        """Densities of good and of wrong lengths, by logarithm, with their shares."""
        scaled = length / self.size
        power = -(self.freedom + 2.0) / 2.0
        good = scaled**2 * (1.0 + scaled**2 / self.freedom) ** power
        away = np.log(length / self.middle) / self.spread
        wrong = np.exp(-(away**2) / 2.0) / (self.spread * np.sqrt(2.0 * np.pi))
        return (1.0 - self.share_wrong) * good, self.share_wrong * wrong

    def probability_wrong(self, squares):
        """Probability that points of such squared lengths are wrong, (n,)."""
        length = np.sqrt(np.maximum(squares, 1e-12 * self.size**2))
        good, wrong = self.densities(length)
        # a small difference is not wrong, however rare it is among good ones
        return np.where(
            length > self.size, wrong / np.maximum(good + wrong, 1e-300), 0.0
        )


def estimate_tails(squares):
    """Estimate how held-out differences are distributed, by maximum likelihood.

    ``squares``: (n,), squared lengths of differences over their variances; those that
    are not finite do not count.
    """
    length = np.sqrt(squares[np.isfinite(squares) & (squares > 0.0)])
    if len(length) < LEAST_POINTS:
        root = np.sqrt(np.mean(length**2) / 2.0) if len(length) else 1.0
        return Tails(float(root), FREEDOM[1])
    size = np.median(length) / RAYLEIGH_MEDIAN
    count, edges = np.histogram(np.log(np.clip(length, 1e-3 * size, None)), N_CLASSES)
    middle = np.exp((edges[1:] + edges[:-1]) / 2.0)

    def unlikely(unknowns):
        both = np.sum(_tails(unknowns).densities(middle), axis=0)
        return -(count @ np.log(np.maximum(both, 1e-300)))

    none = _least(unlikely, [np.log(size), 0.0])
    suspects = length[length > SEEMS_WRONG * size]
    if not len(suspects):
        return _tails(none.x)
    share = len(suspects) / len(length) / MOST_WRONG
    away = np.log(np.median(suspects) / (SEEMS_WRONG * size))
    of_wrong = [np.log(share / max(1.0 - share, 0.01)), float(away), 0.0]
    some = _least(unlikely, [np.log(size), 1.0, *of_wrong])
    return _tails(some.x if none.fun - some.fun > EVIDENCE else none.x)


def _least(function, start):
    corners = np.array(start) + np.vstack([np.zeros(len(start)), np.eye(len(start))])
    options = {"maxfev": MOST_TRIALS, "initial_simplex": corners}
    return minimize(function, corners[0], method="Nelder-Mead", options=options)


def _tails(unknowns):
    """Parameters from two or five unknowns that may have any value."""
    log_size, of_freedom, *of_wrong = np.clip(unknowns, -LARGE, LARGE).tolist()
    size, freedom = float(np.exp(log_size)), _between(FREEDOM, of_freedom)
    if not of_wrong:
        return Tails(size, freedom)
    share = MOST_WRONG / (1.0 + np.exp(-of_wrong[0]))
    spread = _between(SPREAD, of_wrong[2])
    middle = size * SEEMS_WRONG * np.exp(np.logaddexp(0.0, of_wrong[1]))
    return Tails(size, freedom, float(share), float(middle), spread)


def _between(bounds, unknown):
    low, high = bounds
    return float(low * (high / low) ** (1.0 / (1.0 + np.exp(-unknown))))


@dataclass(frozen=True, eq=False)
class HeldOutEllipses:
    """Covariance of predicted points per unit of variance, and what it rests on."""

    shape: np.ndarray  # (2, 2), by which the variance of a point is multiplied
    is_wrong: np.ndarray  # (n,) of bool, held-out points that are taken for wrong
    tails: Tails
    n_held_out: int
    within: float  # share of good held-out points within their 95 % ellipse
    within_all: float  # of all held-out points, those taken for wrong as well

    def covariances(self, variances):
        """Covariance matrices (n, 2, 2) of points of these variances."""
        return np.asarray(variances)[:, None, None] * self.shape


def held_out_ellipses(differences, variances, *, keep_wrong=False):
    """Ellipses that hold 95 % of held-out points.

    Parameters
    ----------
    differences : ndarray, shape (n, 2)
        Predicted minus given [m]; NaN of points that were not held out.
    variances : ndarray, shape (n,)
        What the prediction says of each coordinate [m²].
    keep_wrong : bool
        Whether points that seem wrong count like all others.
    """
    scaled = differences / np.sqrt(variances)[:, None]
    squares = (scaled**2).sum(axis=1)
    held = np.isfinite(squares)
    tails = estimate_tails(squares)
    probability = np.zeros(len(squares))
    if not keep_wrong:
        probability[held] = tails.probability_wrong(squares[held])
    weight = np.where(held, 1.0 - probability, 0.0)
    shape = _shape(scaled[held], weight[held], tails)
    distance = np.full(len(squares), np.nan)
    inverse = np.linalg.inv(shape)
    distance[held] = np.einsum("ni,ij,nj->n", scaled[held], inverse, scaled[held])
    factor = _quantile(distance[held], weight[held]) / LIMIT
    inside = distance[held] <= factor * LIMIT
    return HeldOutEllipses(
        factor * shape,
        probability > WRONG,
        tails,
        n_held_out=int(held.sum()),
        within=float(weight[held] @ inside / max(weight.sum(), 1.0)),
        within_all=float(inside.sum() / max(held.sum(), 1)),
    )


def _shape(scaled, weight, tails):
    """Covariance of the good differences, tails counting as much as they tell."""
    if len(scaled) < LEAST_POINTS:
        return np.eye(2) * max(tails.size**2, 1e-12)
    squares = (scaled**2).sum(axis=1) / tails.size**2
    tell = weight * (tails.freedom + 2.0) / (tails.freedom + squares)
    return (scaled * tell[:, None]).T @ scaled / tell.sum()


def _quantile(values, weight):
    """Of the level, so that as much of the weight lies below it, of n + 1 points."""
    if not len(values):
        return np.nan
    order = np.argsort(values, kind="stable")
    sums = np.cumsum(weight[order])
    place = np.searchsorted(sums, min(LEVEL * (sums[-1] + 1.0), sums[-1]))
    return float(values[order][min(place, len(values) - 1)])
