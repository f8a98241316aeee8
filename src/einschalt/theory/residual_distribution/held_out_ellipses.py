"""Error ellipses of predicted points that held-out points confirm, tails included.

The differences of held-out points are told apart into good ones, whose distribution has
tails (Student's t), and wrong ones, which may be of any size. The ellipses are as large
as the good ones ask for: 95 in 100 of them lie within their own 95 % ellipse.

See docs/theory/collocation.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

LEVEL = 0.95
LIMIT = -2.0 * np.log(1.0 - LEVEL)  # of χ² with two degrees of freedom
LEAST_POINTS = 20  # fewer do not tell tails
WRONG = 0.5  # probability of being wrong from which a point is taken for it
# in multiples of the usual size: differences from which a point may be wrong
NEAREST_WRONG = 4.0
# gain of log-likelihood from which some points are wrong, and not tails
EVIDENCE = 10.0
MOST_FREEDOM = 100.0
LEAST_FREEDOM = 1.5
LARGE = 700.0  # exponents beyond do not fit in a number
MOST_TRIALS = 400
N_CLASSES = 200  # of lengths, so that many points take no longer than few


@dataclass(frozen=True)
class Tails:
    """How squared normalised differences of held-out points are distributed."""

    size: float  # of the good ones: one is what the variances say
    freedom: float  # degrees of freedom of Student's t, MOST_FREEDOM if normal
    share_wrong: float
    largest: float  # length up to which wrong ones were seen

    def probability_wrong(self, squares):
        """Probability that each point is wrong, (n,)."""
        good, wrong = _densities(
            np.sqrt(squares), self.size, self.freedom, self.largest
        )
        wrong = self.share_wrong * wrong
        return wrong / np.maximum(wrong + (1.0 - self.share_wrong) * good, 1e-300)


def _densities(length, size, freedom, largest):
    """Densities of the length of good and of wrong differences."""
    scaled = length / size
    good = scaled / size * (1.0 + scaled**2 / freedom) ** (-(freedom + 2.0) / 2.0)
    # any order of magnitude is as likely as any other
    low = NEAREST_WRONG * size
    span = np.log(max(largest / low, np.e))
    wrong = np.where(length > low, 1.0 / np.maximum(length, low) / span, 0.0)
    return good, wrong


def estimate_tails(squares):
    """Estimate how held-out differences are distributed, by maximum likelihood.

    ``squares``: (n,), squared lengths of differences over their variances; those that
    are not finite do not count.
    """
    length = np.sqrt(squares[np.isfinite(squares) & (squares > 0.0)])
    if len(length) < LEAST_POINTS:
        root = np.sqrt(np.mean(length**2) / 2.0) if len(length) else 1.0
        return Tails(float(root), MOST_FREEDOM, 0.0, 1.0)
    size = np.median(length) / np.sqrt(2.0 * np.log(2.0))
    # beyond: as wrong as can be, and no more
    largest = float(length.max()) * 1.01
    count, edges = np.histogram(np.log(np.clip(length, 1e-3 * size, None)), N_CLASSES)
    middle = np.exp((edges[1:] + edges[:-1]) / 2.0)

    def unlikely(unknowns):
        trial = _tails([*unknowns, -np.inf][:3], largest)
        good, wrong = _densities(middle, trial.size, trial.freedom, largest)
        both = (1.0 - trial.share_wrong) * good + trial.share_wrong * wrong
        return -(count @ np.log(np.maximum(both, 1e-300)))

    start = np.array([np.log(size), 0.0, -3.0])
    options = {"maxfev": MOST_TRIALS}
    none = minimize(unlikely, start[:2], method="Nelder-Mead", options=options)
    some = minimize(unlikely, start, method="Nelder-Mead", options=options)
    if none.fun - some.fun < EVIDENCE:
        return _tails([*none.x, -np.inf], largest)
    return _tails(some.x, largest)


def _tails(unknowns, largest):
    """Parameters from unknowns that may have any value."""
    log_size, of_freedom, of_wrong = np.clip(unknowns, -LARGE, LARGE)
    share = 1.0 / (1.0 + np.exp(-of_freedom))
    freedom = LEAST_FREEDOM * (MOST_FREEDOM / LEAST_FREEDOM) ** share
    wrong = 0.5 / (1.0 + np.exp(-of_wrong))
    return Tails(float(np.exp(log_size)), float(freedom), float(wrong), largest)


@dataclass(frozen=True, eq=False)
class HeldOutEllipses:
    """Covariance of predicted points per unit of variance, and what it rests on."""

    shape: np.ndarray  # (2, 2), by which the variance of a point is multiplied
    is_wrong: np.ndarray  # (n,) of bool, held-out points that are taken for wrong
    tails: Tails
    n_held_out: int
    within: float  # share of good held-out points within their 95 % ellipse

    def covariances(self, variances):
        """Covariance matrices (n, 2, 2) of points of these variances."""
        return np.asarray(variances)[:, None, None] * self.shape


def held_out_ellipses(differences, variances, *, keep_wrong=False):
    """Ellipses that hold 95 % of held-out points.

    Parameters
    ----------
    differences : ndarray, shape (n, 2)
        Predicted less given [m]; NaN of points that were not held out.
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
    within = weight[held] @ (distance[held] <= factor * LIMIT) / max(weight.sum(), 1.0)
    return HeldOutEllipses(
        factor * shape, probability > WRONG, tails, int(held.sum()), float(within)
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
