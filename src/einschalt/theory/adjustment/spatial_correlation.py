"""Whether the errors of neighbouring points are alike.

Sources: Moran 1950 (I); the correlogram of vectors is its mean over classes of
distance. See docs/theory/claim.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.linalg import lapack
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

N_NEIGHBOURS = 6
N_CLASSES = 8
LARGEST_DISTANCE = 6.0  # in median distances of neighbours


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Pairs of points that lie near each other."""

    first: np.ndarray  # (n_pairs,), each pair once
    second: np.ndarray
    distance: np.ndarray  # (n_pairs,) [m]
    n_points: int

    def matrix(self):
        """Both ways, a one for each pair: csr_array, shape (n_points, n_points)."""
        rows = np.concatenate([self.first, self.second])
        columns = np.concatenate([self.second, self.first])
        ones = np.ones(len(rows))
        shape = (self.n_points, self.n_points)
        return sparse.csr_array((ones, (rows, columns)), shape=shape)

    def between(self, least, most):
        """Pairs whose distance lies in a range, ``most`` excluded."""
        is_in = (self.distance >= least) & (self.distance < most)
        return Neighbours(
            self.first[is_in], self.second[is_in], self.distance[is_in], self.n_points
        )


def exponential_factor(xy, length):
    """Factor of the correlations ρ = exp(−d / L), (n_points, n_points).

    Times independent errors of variance 1 it gives such correlated ones. Points at the
    same place share everything.

    >>> factor = exponential_factor(np.array([[0.0, 0.0], [500.0, 0.0]]), 1000.0)
    >>> (factor @ factor.T).round(3).tolist()
    [[1.0, 0.607], [0.607, 1.0]]
    """
    correlations = np.exp(-cdist(xy, xy) / length)
    factor, pivots, rank, _ = lapack.dpstrf(correlations, lower=1)
    factor = np.tril(factor)
    factor[:, rank:] = 0.0
    whole = np.empty_like(factor)
    whole[pivots - 1] = factor
    return whole


def nearest_neighbours(xy, n_neighbours=N_NEIGHBOURS) -> Neighbours:
    """Pair each point with its nearest ones.

    A pair stands once, though each may be a neighbour of the other. Points at the same
    place are no neighbours.
    """
    n_points = len(xy)
    nothing = np.empty(0, dtype=np.int64)
    if n_points < 2:
        return Neighbours(nothing, nothing, np.empty(0), n_points)
    distance, near = cKDTree(xy).query(xy, min(n_neighbours + 1, n_points))
    own = np.repeat(np.arange(n_points), near.shape[1])
    near, distance = near.ravel(), distance.ravel()
    is_pair = (near != own) & (distance > 0.0)
    low = np.minimum(own, near)[is_pair]
    high = np.maximum(own, near)[is_pair]
    _, place = np.unique(low * n_points + high, return_index=True)
    return Neighbours(low[place], high[place], distance[is_pair][place], n_points)


def pairs_within(xy, reach) -> Neighbours:
    """All pairs of points that lie within a distance of each other."""
    pairs = cKDTree(xy).query_pairs(reach, output_type="ndarray")
    first, second = pairs.T
    distance = np.hypot(*(xy[first] - xy[second]).T)
    return Neighbours(first, second, distance, len(xy))


def morans_i(vectors, neighbours):
    """Moran's I of vectors: the mean product of neighbours over the mean square.

    Parameters
    ----------
    vectors : ndarray, shape (n_points, 2) or (n_points, 2, n_draws)
    neighbours : Neighbours

    Returns
    -------
    float or ndarray, shape (n_draws,)
        I = (n / Σw) Σ w_ij (z_i · z_j) / Σ z_i · z_i, z less their mean; −1 / (n − 1)
        on the average without correlation; NaN without pairs.
    """
    n_pairs = len(neighbours.first)
    centred = vectors - vectors.mean(axis=0)
    flat = centred.reshape(len(centred), -1)
    products = (flat * (neighbours.matrix() @ flat)).reshape(centred.shape)
    squares = np.sum(centred**2, axis=(0, 1))
    total = np.sum(products, axis=(0, 1)) / max(2 * n_pairs, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = total / (squares / len(vectors))
    return np.where(n_pairs > 0, found, np.nan)[()]


@dataclass(frozen=True, eq=False)
class Correlogram:
    """Correlation of vectors by the distance of their points."""

    distance: np.ndarray  # (n_classes,): mean of each class [m]
    correlation: np.ndarray  # (n_classes,) or (n_classes, n_draws)
    n_pairs: np.ndarray  # (n_classes,)


def correlogram(vectors, xy, n_classes=N_CLASSES) -> Correlogram:
    """Correlation of vectors, as :func:`morans_i` takes them, in classes of distance.

    The classes are of equal width, from 0 to six times the median distance of
    neighbours; those without pairs are left out.
    """
    near = nearest_neighbours(xy)
    if len(near.first) == 0:
        nothing = np.empty(0)
        return Correlogram(nothing, nothing, np.empty(0, dtype=np.int64))
    reach = LARGEST_DISTANCE * float(np.median(near.distance))
    pairs = pairs_within(xy, reach)
    edges = np.linspace(0.0, reach, n_classes + 1)
    classes = [pairs.between(*edges[k : k + 2]) for k in range(n_classes)]
    filled = [part for part in classes if len(part.first)]
    return Correlogram(
        np.array([part.distance.mean() for part in filled]),
        np.array([morans_i(vectors, part) for part in filled]),
        np.array([len(part.first) for part in filled]),
    )
