"""Stage 4, rigorous: the errors of both flights and of the control, carried through.

The paper's budget takes for independent what is not. Here every final coordinate is
written as a linear function of the errors of all observations, sparsely, and its
covariance follows from theirs: L Σ Lᵀ.
"""

from collections import Counter
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from einschalt.foundations.batches import segment_sum, segments
from einschalt.foundations.errors import TableError
from einschalt.foundations.names import encode
from einschalt.theory.adjustment.propagation import (
    PairLayout,
    hat_operator,
    pair_covariances,
    point_covariances,
    selection,
    weighted_mean,
)
from einschalt.theory.transformation.sensitivity import (
    cofactors_of_rest,
    conformal_cofactors,
    conformal_sensitivity,
    sensitivity,
)

POINTS_AT_ONCE = 5000
# numbers of a full matrix: 160 MB
NUMBERS_AT_ONCE = 20_000_000
PAIRS_AT_ONCE = 20_000
# share of entries from which a product is no longer kept sparse
FULL = 0.1
UNEVEN = 2.0  # size of the fullest rows, over the mean


@dataclass(frozen=True, eq=False)
class FlightOperator:
    """How the errors of a flight's values follow from those of its observations.

    Attributes
    ----------
    measured : bsr_array, shape (n_values · n_axes, n_values · n_axes)
        From the measuring errors of all points of the flight, in ground units.
    ground : bsr_array, shape (n_values · n_axes, n_ground · n_axes)
        From the errors of the ground coordinates onto which its models were fitted.
    n_axes : int
    """

    measured: sparse.bsr_array
    ground: sparse.bsr_array
    n_axes: int


@dataclass(frozen=True, eq=False)
class GroundSources:
    """Which source of error stands behind each row of a table of ground points.

    Attributes
    ----------
    places : ndarray of int, shape (n_rows,)
    count : int
        Number of sources.
    """

    places: np.ndarray
    count: int


def flight_operator(transformation, model_points, ground, *, is_conformal):
    """Error operator of all values of a flight.

    A point that was fitted has the error (I − H) g + H e, one that was not g + H (e −
    g), with the measuring errors g and the errors e of the ground coordinates.

    Parameters
    ----------
    transformation : ModelTransformation
        Of ``model_points``.
    model_points : DataFrame
    ground : GroundSources
    is_conformal : bool
        Whether one complex coordinate stands for easting and northing.

    Returns
    -------
    FlightOperator
        Its rows in the order of ``model_points``; NaN in the rows of models that are
        not usable.
    """
    observed, fit = transformation.observed, transformation.fit
    axes = ["x", "y", "z"][: observed.source.shape[1]]
    coordinates = model_points[axes].to_numpy(dtype=float)
    n_rows, n_axes = len(coordinates), 1 if is_conformal else len(axes)
    sort = segments(observed.models.codes, len(observed.models))
    sorted_place = np.empty(n_rows, dtype=np.int64)
    sorted_place[sort.order] = np.arange(n_rows)
    layout = PairLayout(sort.start, sorted_place[observed.row_numbers])
    derive, cofactors = (
        (conformal_sensitivity, conformal_cofactors)
        if is_conformal
        else (sensitivity, cofactors_of_rest)
    )
    design = derive(fit, layout.model_of_row, coordinates[sort.order])
    weight_sum = segment_sum(observed.weights, observed.start)
    hat = hat_operator(design, cofactors(fit), weight_sum, observed.weights, layout)
    in_given_order = selection(sorted_place, n_rows, n_axes)
    hat = in_given_order @ hat
    fitted = selection(observed.row_numbers, n_rows, n_axes)
    onto = selection(ground.places[observed.ground_rows], ground.count, n_axes)
    own = selection(np.arange(n_rows), n_rows, n_axes)
    return FlightOperator(own - hat @ fitted, hat @ onto, n_axes)


def mean_operator(means, value_rows, n_values, n_axes):
    """Operator of the means of stage 5.

    Parameters
    ----------
    means : CoverageMean
    value_rows : ndarray of int
        Which row of the flight's values each value was that stage 5 was given.
    n_values, n_axes : int

    Returns
    -------
    bsr_array, shape (n_points · n_axes, n_values · n_axes)
    """
    points, used = encode(means.points["point_id"]), encode(means.used["point_id"])
    sort = segments(points.locate(used)[used.codes], len(points))
    rows = value_rows[means.row_numbers]
    return weighted_mean(
        rows[sort.order], means.weights[sort.order], sort.start, (n_values, n_axes)
    )


@dataclass(frozen=True, eq=False)
class PropagatedErrors:
    """Covariances of the final points, and where they come from.

    Attributes
    ----------
    point_ids : ndarray of object, shape (n_points,)
    parts : dict of str to ndarray, shape (n_points, n_axes, n_axes)
        Covariance from each source alone [m²].
    chains : dict of str to tuple of sparse arrays
        Error operator of each source as a product, the final points on the left.
    standard_errors : dict of str to ndarray
        Of each source's observations, per coordinate [m].
    n_axes : int
        Of the operators: 1 where one complex coordinate stands for two.
    """

    point_ids: np.ndarray
    parts: dict
    chains: dict
    standard_errors: dict
    n_axes: int

    @property
    def covariance(self):
        """Covariance of each point, shape (n_points, n_axes, n_axes) [m²]."""
        return sum(self.parts.values())

    def covariance_between(self, first, second):
        """Covariance between pairs of points.

        The variance of a coordinate difference is V_first + V_second − C − Cᵀ.

        Parameters
        ----------
        first, second : array of str, shape (n_pairs,)
            point_id of the points of each pair.

        Returns
        -------
        ndarray, shape (n_pairs, n_axes, n_axes)
            [m²].

        Raises
        ------
        TableError
            A point is not among the final points.
        """
        places = np.column_stack([self._places(first), self._places(second)])
        return self.covariance_at(places)

    def covariance_at(self, places):
        """Covariance between pairs of points, by their places among the points.

        Parameters
        ----------
        places : ndarray of int, shape (n_pairs, 2)

        Returns
        -------
        ndarray, shape (n_pairs, n_axes, n_axes)
            [m²].
        """
        n_points = min(places.size, len(self.point_ids))
        n_parts = max(
            -(-len(places) // PAIRS_AT_ONCE),
            n_ranges(self.chains, n_points, self.n_axes),
        )
        n_parts = max(1, min(n_parts, len(places)))
        parts = [self._between(part) for part in np.array_split(places, n_parts)]
        return np.concatenate(parts)

    def _between(self, places):
        points, place = np.unique(places, return_inverse=True)
        pairs = place.reshape(places.shape)
        total = 0.0
        for source, rows in _rows_of(self.chains, points, self.n_axes):
            sizes = self.standard_errors[source]
            total = total + pair_covariances(rows, sizes, pairs, self.n_axes)
        return _real_axes(total) if self.n_axes == 1 else total

    def _places(self, point_ids):
        asked = encode(np.asarray(point_ids, dtype=object))
        place = encode(self.point_ids).locate(asked)
        if (place < 0).any():
            raise TableError(
                "it is not among the densified points",
                expected="a point_id of result.points",
                point=asked.names[int(np.argmax(place < 0))],
            )
        return place[asked.codes]


def propagate(point_ids, chains, standard_errors, n_axes):
    """Covariances of the final points from all sources.

    Parameters
    ----------
    point_ids : ndarray of object, shape (n_points,)
    chains : dict of str to tuple of sparse arrays
        Error operator of each source as a product, the final points on the left.
    standard_errors : dict of str to ndarray, shape (n_sources,) or (n_sources, n_axes)
        Per coordinate [m].
    n_axes : int

    Returns
    -------
    PropagatedErrors
    """
    n_points = next(iter(chains.values()))[0].shape[0] // n_axes
    found = {source: [] for source in chains}
    # in ranges of points: the product as a whole would hold some hundred blocks a point
    for places in np.array_split(
        np.arange(n_points), n_ranges(chains, n_points, n_axes)
    ):
        for source, rows in _rows_of(chains, places, n_axes):
            part = point_covariances(rows, standard_errors[source], n_axes)
            found[source].append(_real_axes(part) if n_axes == 1 else part)
    parts = {source: np.concatenate(of_source) for source, of_source in found.items()}
    return PropagatedErrors(point_ids, parts, chains, standard_errors, n_axes)


def n_ranges(chains, n_points, n_axes):
    """Into how many ranges the points are divided, so that memory suffices.

    Parameters
    ----------
    chains : dict of str to tuple of sparse arrays
        Error operator of each source as a product, the final points on the left.
    n_points, n_axes : int

    Returns
    -------
    int
    """
    row = max(_row_size(chain) for chain in chains.values())
    by_memory = -(-n_points * n_axes * row // NUMBERS_AT_ONCE)
    return max(1, -(-n_points // POINTS_AT_ONCE), by_memory)


def _row_size(chain):
    """Numbers that a row holds at most on its way through a chain, about.

    Where it is mostly filled it becomes a full one. In large blocks it never does:
    their points depend on no more sources than those of small ones.
    """
    size, largest = 1.0, 1.0
    for matrix in chain:
        width = matrix.shape[1]
        size = min(size * matrix.nnz / matrix.shape[0], width)
        likely = UNEVEN * size
        largest = max(largest, width if likely > FULL * width else likely)
    return int(largest) + 1


def _rows_of(chains, places, n_axes):
    """Rows of some points in the product of each chain; what begins alike is shared.

    Yields
    ------
    source : str
    rows : sparse array or ndarray
    """
    n_points = next(iter(chains.values()))[0].shape[0] // n_axes
    beginnings = Counter(
        tuple(map(id, chain[:k])) for chain in chains.values() for k in _lengths(chain)
    )
    done = {(): selection(places, n_points, n_axes)}
    for source, chain in chains.items():
        known = max((k for k in _lengths(chain) if _key(chain, k) in done), default=0)
        rows = done[_key(chain, known)]
        for k in range(known, len(chain)):
            rows = _filled(_times(rows, chain[k]))
            if beginnings[_key(chain, k + 1)] > 1:
                done[_key(chain, k + 1)] = rows
        yield source, rows


def _lengths(chain):
    return range(1, len(chain) + 1)


def _key(chain, length):
    return tuple(map(id, chain[:length]))


def _times(rows, matrix):
    # models that are not usable have no part, but 0 · NaN would be NaN
    if not sparse.issparse(rows) and not np.isfinite(matrix.data).all():
        rows = sparse.csr_array(rows)
    return rows @ matrix


def _filled(rows):
    """As a full matrix where most of it is needed: it multiplies much faster."""
    is_full = sparse.issparse(rows) and rows.nnz > FULL * rows.shape[0] * rows.shape[1]
    return rows.toarray() if is_full else rows


def _real_axes(scalar):
    """Covariance of easting and northing from that of E + iN."""
    same, cross = np.real(scalar[:, 0, 0]), np.imag(scalar[:, 0, 0])
    rows = np.stack([same, -cross], -1), np.stack([cross, same], -1)
    return np.stack(rows, -2)
