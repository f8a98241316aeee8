"""How much each point takes of the residual of each control point.

Every method is linear in the residuals: a sparse matrix of weights whose rows add up to
1, so that a shift common to all control points is taken whole by every point. At a
control point the weight is its own alone.

See docs/theory/residual_distribution.md.
"""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from einschalt.theory.residual_distribution.natural_neighbours import (
    natural_neighbour_weights,
)

N_NEAREST = 12
N_BASES = 30
# Hardy's constant: 0.815 of the mean distance of nearest neighbours
HARDY = 0.815
# share of the usual distance of the third neighbour within which known points are one
NEAR = 0.05
AT_ONCE = 4096


def inverse_distance_weights(known_xy, point_xy):
    """Inverse-distance weights of the nearest known points (Shepard 1968).

    With more than N_NEAREST known points the weights fall to zero at the distance of
    the next one, ((R - d) / (R d))² (Franke and Nielson 1980), so that no point takes a
    jump where its neighbours change. No two known points are at the same place.

    Examples
    --------
    >>> ends = np.array([[0.0, 0.0], [3.0, 0.0]])
    >>> inverse_distance_weights(ends, np.array([[1.0, 0.0]])).toarray()
    array([[0.8, 0.2]])
    """
    n_points, n_known = len(point_xy), len(known_xy)
    n_asked = min(n_known, N_NEAREST + 1)
    distance, columns = KDTree(known_xy).query(point_xy, np.arange(1, n_asked + 1))
    radius = np.inf
    if n_known > N_NEAREST:
        radius = distance[:, -1:]
        distance, columns = distance[:, :-1], columns[:, :-1]
    # relative to the nearest, so that no square of a small distance overflows
    nearest = distance[:, :1]
    relative = np.divide(
        nearest, distance, out=np.ones_like(distance), where=distance > 0.0
    )
    weights = (relative * (1.0 - distance / radius)) ** 2
    weights[(nearest == 0.0)[:, 0]] = 0.0
    weights[(nearest == 0.0)[:, 0], 0] = 1.0
    # where all are equally far, R is their distance too, and nothing would be left
    weights[weights.sum(axis=1) == 0.0] = 1.0
    weights /= weights.sum(axis=1, keepdims=True)
    rows = np.repeat(np.arange(n_points), columns.shape[1])
    return sparse.csr_array(
        (weights.ravel(), (rows, columns.ravel())), shape=(n_points, n_known)
    )


def multiquadric_weights(known_xy, point_xy):
    """Weights of the multiquadric interpolation (Hardy 1971) with a constant term.

    Sum of √(d² + c²) over the known points, c being 0.815 times their mean distance
    from their nearest neighbour; each point is interpolated among its N_BASES nearest.
    Known points that lie close together are one, in their middle, and share its weight:
    a slope from one to the other would go on far beyond them, and centimetres would
    become metres.

    Examples
    --------
    >>> ends = np.array([[0.0, 0.0], [2.0, 0.0]])
    >>> multiquadric_weights(ends, np.array([[1.0, 5.0]])).toarray().round(12)
    array([[0.5, 0.5]])
    """
    share = _sharing(_groups_of_near(known_xy))
    weights = sparse.csr_array(_weights_of_apart(share @ known_xy, point_xy) @ share)
    distance, nearest = KDTree(known_xy).query(point_xy)
    at_known = np.flatnonzero(distance == 0.0)
    return with_unit_rows(weights, at_known, nearest[at_known])


def with_unit_rows(weights, rows, columns):
    """Weights with rows in which one known point (of ``columns``) has the whole."""
    others = np.ones(weights.shape[0])
    others[rows] = 0.0
    own = sparse.csr_array((np.ones(len(rows)), (rows, columns)), shape=weights.shape)
    changed = sparse.csr_array(sparse.diags_array(others) @ weights + own)
    changed.eliminate_zeros()
    return changed


def _groups_of_near(known_xy):
    n_known = len(known_xy)
    tree = KDTree(known_xy)
    third = tree.query(known_xy, [min(4, n_known)])[0]
    pairs = tree.query_pairs(NEAR * np.median(third), output_type="ndarray")
    links = sparse.csr_array(
        (np.ones(len(pairs)), tuple(pairs.T)), shape=(n_known, n_known)
    )
    return connected_components(links, directed=False)[1]


def _sharing(group):
    """Mean of each group, as a matrix of shape (n_groups, n_known)."""
    share = 1.0 / np.bincount(group)[group]
    return sparse.csr_array((share, (group, np.arange(len(group)))))


def _weights_of_apart(known_xy, point_xy):
    n_points, n_known = len(point_xy), len(known_xy)
    if n_known == 1:
        return sparse.csr_array(np.ones((n_points, 1)))
    tree = KDTree(known_xy)
    constant = HARDY * tree.query(known_xy, [2])[0].mean()
    n_bases = min(n_known, N_BASES)
    columns = tree.query(point_xy, np.arange(1, n_bases + 1))[1]
    # neighbours often agree between points: each set of bases is solved once
    columns = np.sort(columns, axis=1)
    sets, which = np.unique(columns, axis=0, return_inverse=True)
    weights = np.empty((n_points, n_bases))
    order = np.argsort(which, kind="stable")
    for places in np.array_split(order, 1 + n_points // AT_ONCE):
        chosen, among = np.unique(which[places], return_inverse=True)
        inverses = _inverse_systems(known_xy[sets[chosen]], constant)
        away = point_xy[places, None] - known_xy[columns[places]]
        right = np.ones((len(places), n_bases + 1))
        right[:, :-1] = np.sqrt((away**2).sum(axis=2) + constant**2)
        solved = np.einsum("pi,pij->pj", right, inverses[among])
        weights[places] = solved[:, :-1]
    rows = np.repeat(np.arange(n_points), n_bases)
    return sparse.csr_array(
        (weights.ravel(), (rows, columns.ravel())), shape=(n_points, n_known)
    )


def _inverse_systems(bases, constant):
    """Inverses of the bordered systems of sets of bases, shape (n, k + 1, k + 1)."""
    away = bases[:, :, None] - bases[:, None]
    n_sets, n_bases = bases.shape[:2]
    system = np.zeros((n_sets, n_bases + 1, n_bases + 1))
    system[:, :-1, :-1] = np.sqrt((away**2).sum(axis=3) + constant**2)
    system[:, -1, :-1] = system[:, :-1, -1] = 1.0
    return np.linalg.inv(system)


DISTRIBUTIONS = {
    "natural_neighbour": natural_neighbour_weights,
    "inverse_distance": inverse_distance_weights,
    "multiquadric": multiquadric_weights,
}
"""Ways to distribute residuals, by their name in the settings."""


def distribution_weights(known_xy, point_xy, method):
    """Weights (n_points, n_known) of the residuals of known points for all points.

    Rows add up to 1; ``method`` is one of DISTRIBUTIONS. Several known points at the
    same place share their weight.
    """
    places, which = np.unique(known_xy, axis=0, return_inverse=True)
    weights = DISTRIBUTIONS[method](places, point_xy)
    return sparse.csr_array(weights @ _sharing(which.ravel()))
