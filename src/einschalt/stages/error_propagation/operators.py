"""Stage 4, rigorous: the errors of both flights and of the control, carried through.

The paper's budget takes for independent what is not. Here every final coordinate is
written as a linear function of the errors of all observations, sparsely, and its
covariance follows from theirs: L Σ Lᵀ.
"""

from collections import Counter
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy import sparse

from einschalt.foundations.batches import over_parts, segment_sum, segments
from einschalt.foundations.errors import TableError
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode
from einschalt.theory.adjustment.point_operator import (
    Axes,
    PointOperator,
    selection,
    weighted_mean,
)
from einschalt.theory.adjustment.propagation import PairLayout, hat_operator
from einschalt.theory.transformation.sensitivity import (
    cofactors_of_rest,
    conformal_cofactors,
    conformal_sensitivity,
    sensitivity,
)

# numbers of a full matrix: 80 MB for each range of points, 160 MB for those at once
NUMBERS_OF_RANGE, RANGES_AT_ONCE = 10_000_000, 2
NUMBERS_AT_ONCE = NUMBERS_OF_RANGE * RANGES_AT_ONCE
PAIRS_AT_ONCE = 50_000
NUMBERS_PER_PAIR = 30  # of a covariance of all points: with more, pairs are quicker
# share of entries from which a product is no longer kept sparse
FULL = 0.1
# what an entry of a sparse matrix takes, with its place and what is computed from it
SPARSE_SIZE = 3.0
UNEVEN = 2.0  # size of the fullest rows, over the mean
N_SAMPLED = 100  # points whose rows tell how full they are


@dataclass(frozen=True, eq=False)
class FlightOperator:
    """How the errors of a flight's values follow from those of its observations."""

    # from the measuring errors of all points of the flight, in ground units
    measured: PointOperator
    # from the errors of the ground coordinates onto which its models were fitted
    ground: PointOperator

    def selections(self, places, observed):
        """Pick what the flight was fitted with.

        Operators of the ground coordinates, and of the measured points. ``places`` says
        which source stands in each row of the table of ground coordinates.
        """
        ground, measured = self.ground, self.measured
        rows = observed.row_numbers
        return (
            selection(places[observed.ground_rows], ground.n_sources, ground.axes),
            selection(rows, measured.n_sources, measured.axes),
        )


@dataclass(frozen=True, eq=False)
class GroundSources:
    """Which source of error stands behind each row of a table of ground points."""

    places: np.ndarray  # (n_rows,)
    count: int  # number of sources


def flight_operator(transformation, model_points, ground, axes) -> FlightOperator:
    """Error operator of all values of a flight.

    Rows are in the order of ``model_points``; see :func:`operator_of_fit`.
    """
    observed = transformation.observed
    names = ["x", "y", "z"][: observed.source.shape[1]]
    coordinates = values_of(model_points, names)
    return operator_of_fit(transformation.fit, observed, coordinates, ground, axes)


def operator_of_fit(fit, observed, coordinates, ground, axes) -> FlightOperator:
    """Error operator of points in the models of a fit.

    A point that was fitted has the error (I − H) g + H e, one that was not g + H (e −
    g), with the measuring errors g and the errors e of the ground coordinates.
    ``coordinates`` (n_rows, n_axes) are those of all points, of which ``observed`` were
    fitted; NaN in the rows of models that are not usable.
    """
    n_rows = len(coordinates)
    sort = segments(observed.models.codes, len(observed.models))
    sorted_place = np.empty(n_rows, dtype=np.int64)
    sorted_place[sort.order] = np.arange(n_rows)
    layout = PairLayout(sort.start, sorted_place[observed.row_numbers])
    derive, cofactors = sensitivity, cofactors_of_rest
    if axes is Axes.COMPLEX:
        derive, cofactors = conformal_sensitivity, conformal_cofactors
    design = derive(fit, layout.model_of_row, coordinates[sort.order])
    weight_sum = segment_sum(observed.weights, observed.start)
    hat = hat_operator(design, cofactors(fit), weight_sum, observed.weights, layout)
    hat = (selection(sorted_place, n_rows, axes) @ hat).formed()
    fitted = selection(observed.row_numbers, n_rows, axes)
    onto = selection(ground.places[observed.ground_rows], ground.count, axes)
    own = selection(np.arange(n_rows), n_rows, axes)
    return FlightOperator(own - (hat @ fitted).formed(), (hat @ onto).formed())


def mean_operator(means, value_rows, n_values, axes) -> PointOperator:
    """Operator of the means of stage 5.

    ``value_rows`` says which row of the flight's values each value was that stage 5 was
    given.
    """
    points, used = encode(means.points["point_id"]), encode(means.used["point_id"])
    sort = segments(points.locate(used)[used.codes], len(points))
    rows = value_rows[means.row_numbers]
    return weighted_mean(
        rows[sort.order], means.weights[sort.order], sort.start, n_values, axes
    )


@dataclass(frozen=True, eq=False)
class PropagatedErrors:
    """Covariances of the final points, and where they come from."""

    point_ids: np.ndarray  # (n_points,)
    # (n_points, n_coordinates, n_coordinates): from each source alone [m²]
    parts: dict[str, np.ndarray]
    # from the errors of each source to the final points
    chains: dict[str, PointOperator]
    # of each source's observations, per coordinate [m]
    standard_errors: dict[str, np.ndarray]

    @property
    def axes(self):
        """Of the operators."""
        return next(iter(self.chains.values())).axes

    @property
    def covariance(self):
        """Covariance of each point, (n_points, n_coordinates, n_coordinates) [m²]."""
        return sum(self.parts.values())

    def covariance_between(self, first, second):
        """Covariance between pairs of points.

        (n_pairs, n_coordinates, n_coordinates) [m²], of point_ids. The variance of a
        coordinate difference is V_first + V_second − C − Cᵀ.
        """
        places = np.column_stack([self._places(first), self._places(second)])
        return self.covariance_at(places)

    def covariance_at(self, places):
        """Covariance between pairs of points, by their places among the points.

        ``places`` (n_pairs, 2); gives (n_pairs, n_coordinates, n_coordinates) [m²].
        """
        return covariances_of_pairs(self.chains, self.standard_errors, places)

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


def covariances_of_pairs(chains, standard_errors, places):
    """Covariances between pairs of the points that chains lead to.

    ``places`` (n_pairs, 2): pairs that share points stand best near each other. Gives
    (n_pairs, n_coordinates, n_coordinates) [m²].
    """
    through = _through_few_points(chains, len(places))
    found = _through(through, standard_errors, places) if through else 0.0
    apart = {name: chain for name, chain in chains.items() if name not in through}
    if not apart:
        return found
    n_points = min(places.size, next(iter(apart.values())).n_points)
    n_parts = max(-(-len(places) // PAIRS_AT_ONCE), n_ranges(apart, n_points))
    n_parts = max(1, min(n_parts, len(places)))
    parts = np.array_split(places, n_parts)
    work = partial(_between, apart, standard_errors)
    between = over_parts(work, parts, most_at_once=RANGES_AT_ONCE)
    return found + np.concatenate(between)


def _through_few_points(chains, n_pairs):
    """Chains that begin with the same step, if it leads from few points to many.

    Then a covariance of all of these is quicker than long rows of every pair.
    """
    alike = {}
    for name, chain in chains.items():
        if len(chain.factors) > 1:
            alike.setdefault(_key(chain, 1), {})[name] = chain
    found = max(alike.values(), key=len, default={})
    if not found:
        return {}
    n_numbers = next(iter(found.values())).factors[0].shape[1]
    if n_numbers**2 > min(NUMBERS_PER_PAIR * n_pairs, NUMBERS_AT_ONCE):
        return {}
    rest = _without_first_step(found)
    n_points = next(iter(rest.values())).n_points
    widest = max(_row_size(chain, n_points) for chain in rest.values())
    return found if n_numbers * widest <= NUMBERS_AT_ONCE else {}


def _without_first_step(chains):
    return {n: PointOperator(c.factors[1:], c.axes) for n, c in chains.items()}


def _through(chains, standard_errors, places):
    """Covariances between pairs, from the covariance of what their chains share."""
    any_chain = next(iter(chains.values()))
    step = PointOperator(any_chain.factors[:1], any_chain.axes)
    rest = _without_first_step(chains)
    joint = sum(
        rows.joint_covariance(standard_errors[source])
        for source, rows in _rows_of(rest, np.arange(step.n_sources))
    )
    return step.covariances_of(joint, places)


def _between(chains, standard_errors, places):
    points, place = np.unique(places, return_inverse=True)
    pairs = place.reshape(places.shape)
    return sum(
        rows.covariances_between(pairs, standard_errors[source])
        for source, rows in _rows_of(chains, points)
    )


def propagate(point_ids, chains, standard_errors) -> PropagatedErrors:
    """Covariances of the final points from all sources.

    ``standard_errors`` of each source are per coordinate [m], with a column for each
    axis where they differ.
    """
    n_points = next(iter(chains.values())).n_points

    def covariances(places):
        rows = _rows_of(chains, places)
        return {source: of.covariances(standard_errors[source]) for source, of in rows}

    # in ranges of points: the product as a whole would hold some hundred blocks a point
    ranges = np.array_split(np.arange(n_points), n_ranges(chains, n_points))
    found = over_parts(covariances, ranges, most_at_once=RANGES_AT_ONCE)
    parts = {name: np.concatenate([part[name] for part in found]) for name in chains}
    return PropagatedErrors(point_ids, parts, chains, standard_errors)


def n_ranges(chains, n_points) -> int:
    """Into how many ranges the points are divided, so that memory suffices.

    As few as possible: a product of sparse matrices takes time for every column of the
    last one, however few rows the first one has.
    """
    numbers = max(
        chain.axes.size(n_points) * _row_size(chain, n_points)
        for chain in chains.values()
    )
    return max(1, int(-(-numbers // NUMBERS_OF_RANGE)))


def _row_size(chain, n_points):
    """Numbers that a row holds at most on its way through a chain, about.

    As the rows of some points show, that lie all over the block.
    """
    widest = max((matrix.shape[1] for matrix in chain.factors), default=1)
    if chain.axes.size(n_points) * widest <= NUMBERS_OF_RANGE:
        return widest  # all of them fit, even full ones
    n_all = chain.n_points
    sampled = np.unique(np.linspace(0, n_all - 1, min(N_SAMPLED, n_all)).astype(int))
    rows, largest = selection(sampled, n_all, chain.axes).matrix, 0
    for matrix in chain.factors:
        rows = _filled(_times(rows, matrix))
        is_sparse = sparse.issparse(rows)
        largest = max(largest, SPARSE_SIZE * rows.nnz if is_sparse else rows.size)
    return min(UNEVEN * largest / chain.axes.size(len(sampled)), widest)


def _rows_of(chains, places):
    """Rows of some points in the product of each chain; what begins alike is shared.

    Yields the name of each source, and its rows as a PointOperator.
    """
    any_chain = next(iter(chains.values()))
    picked = selection(places, any_chain.n_points, any_chain.axes)
    beginnings = Counter(
        _key(chain, k) for chain in chains.values() for k in _lengths(chain)
    )
    done = {(): picked.matrix}
    for source, chain in chains.items():
        known = max((k for k in _lengths(chain) if _key(chain, k) in done), default=0)
        rows = done[_key(chain, known)]
        for k in range(known, len(chain.factors)):
            rows = _filled(_times(rows, chain.factors[k]))
            if beginnings[_key(chain, k + 1)] > 1:
                done[_key(chain, k + 1)] = rows
        yield source, PointOperator((rows,), chain.axes)


def _lengths(chain):
    return range(1, len(chain.factors) + 1)


def _key(chain, length):
    return tuple(map(id, chain.factors[:length]))


def _times(rows, matrix):
    # models that are not usable have no part, but 0 · NaN would be NaN
    if not sparse.issparse(rows) and not np.isfinite(matrix.data).all():
        rows = sparse.csr_array(rows)
    return rows @ matrix


def _filled(rows):
    """As a full matrix where most of it is needed: it multiplies much faster."""
    is_full = sparse.issparse(rows) and rows.nnz > FULL * rows.shape[0] * rows.shape[1]
    # by rows: from small matrices scipy would go through a list of all entries
    return rows.tocsr().toarray() if is_full else rows
