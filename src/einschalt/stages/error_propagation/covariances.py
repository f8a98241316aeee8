"""Covariances of points from the errors of all observations: L Σ Lᵀ.

Operators lead from every source of errors to the points. Most go through the parameters
of models, of which there are far fewer than values: what these share is computed once,
for all that depends on them.
"""

from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from einschalt.foundations.batches import numbered, over_parts
from einschalt.foundations.errors import TableError
from einschalt.foundations.names import encode
from einschalt.stages.error_propagation.propagation_steps import (
    SPARSE_SIZE,
    KnownBundles,
    PropagationSteps,
    n_parts,
    numbers_in_row,
)
from einschalt.theory.adjustment.joint_covariance import BundlePairs, joint_covariance
from einschalt.theory.adjustment.point_operator import Axes, PointOperator, selection
from einschalt.theory.adjustment.rows_of_chains import (
    beginning,
    rows_of_chains,
)
from einschalt.theory.adjustment.through_models import joint_through_models

# numbers of a full matrix: 80 MB for each range of points, 160 MB for those at once
NUMBERS_OF_RANGE, RANGES_AT_ONCE = 10_000_000, 2
UNEVEN = 2.0  # size of the fullest rows, over the mean


class SharedCovariances:
    """Covariances of parameters of models, kept for all that depends on them.

    Values, their means and differences of means depend on the same parameters: their
    covariances are computed when the first of these asks for them. Matrices of chains
    and standard errors are told apart by their identity, and must not be changed.
    ``through_models``: errors of points on which models are fitted go through these,
    where joint_through_models can; it pays where they are many times the parameters.
    """

    def __init__(self, *, through_models: bool = False) -> None:
        self._is_through_models = through_models
        # each is set as a whole: other threads and interruptions leave it whole
        self._steps = self._kept = None
        self._bundles = KnownBundles()

    def steps_of(self, chains):
        """Steps of chains, which several questions about the same points need."""
        key, kept = identity_of(chains), self._steps
        if kept is None or kept[0] != key:
            # chains are kept, so that another matrix cannot have the identity of theirs
            self._steps = kept = key, chains, PropagationSteps.of(chains, self._bundles)
        return kept[2]

    def covariances(self, met, size, chains, standard_errors, parts=None):
        """Covariances of pairs of parameters from each source, (n_met, size, size).

        ``met`` are the BundlePairs; ``chains`` lead to the parameters, of which
        ``size`` numbers stand in a bundle; ``parts`` are those of them, slices, that
        some of the sources reach alone.
        """
        sizes = [standard_errors[name] for name in chains]
        key, kept = (size, identity_of(chains), tuple(map(id, sizes))), self._kept
        is_same = kept is not None and kept.key == key
        places = kept.met.places_of(met) if is_same else None
        if places is not None:
            return {name: blocks[places] for name, blocks in kept.joint.items()}
        bundles, met_of_these = met.alone()
        joint = self._through_models(chains, size, bundles, met_of_these, sizes)
        n, parts = _n_parameters(chains), parts or {}
        alike = {}
        for name, chain in chains.items():
            if name not in joint:
                part = parts.get(name, slice(size))
                alike.setdefault((part.start, part.stop), {})[name] = chain
        for edges, some in alike.items():
            part = slice(*edges)
            for source, rows in _rows_to_bundles(some, size, bundles, n, part):
                each = standard_errors[source]
                joint[source] = _of_part(rows, met_of_these, size, part, each)
        joint = {name: joint[name] for name in chains}
        if not (is_same and len(met) < len(kept.met)):
            self._kept = _Kept(key, (chains, sizes), met, joint)
        return joint

    def _through_models(self, chains, size, bundles, met, sizes):
        """Covariances from the sources whose errors go through models they move."""
        if not self._is_through_models:
            return {}

        def rows_of(product):
            n, one = product.shape[0], {"": product}
            return next(_rows_to_bundles(one, size, bundles, n))[1].factors[0]

        found = {
            name: joint_through_models(rows_of, chain, met, size, each)
            for (name, chain), each in zip(chains.items(), sizes, strict=True)
        }
        return {name: joint for name, joint in found.items() if joint is not None}


class _Kept(NamedTuple):
    """Covariances of parameters, and what they follow from."""

    key: tuple
    behind: tuple  # what the key is the identity of
    met: BundlePairs
    joint: dict[str, np.ndarray]


def identity_of(chains):
    """What tells chains apart: names, and matrices of each product."""
    return tuple(
        (name, tuple(beginning(one, len(one.factors)) for one in chain.products))
        for name, chain in chains.items()
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
    known: SharedCovariances = field(default_factory=SharedCovariances, repr=False)

    @property
    def axes(self) -> Axes:
        """Of the operators."""
        return next(iter(self.chains.values())).axes

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of each point, (n_points, n_coordinates, n_coordinates) [m²]."""
        return sum(self.parts.values())

    def covariance_between(self, first: ArrayLike, second: ArrayLike) -> np.ndarray:
        """Covariance between pairs of points.

        (n_pairs, n_coordinates, n_coordinates) [m²], of point_ids. The variance of a
        coordinate difference is V_first + V_second − C − Cᵀ.
        """
        places = np.column_stack([self._places(first), self._places(second)])
        return self.covariance_at(places)

    def covariance_at(self, places: np.ndarray) -> np.ndarray:
        """Covariance between pairs of points, by their places among the points.

        ``places`` (n_pairs, 2); gives (n_pairs, n_coordinates, n_coordinates) [m²].
        """
        return covariances_of_pairs(
            self.chains, self.standard_errors, places, self.known
        )

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


def covariances_of_pairs(chains, standard_errors, places, known=None):
    """Covariances between pairs of the points that chains lead to.

    ``places`` (n_pairs, 2): pairs that share points stand best near each other;
    ``known`` are SharedCovariances. Gives (n_pairs, n_coordinates, n_coordinates) [m²].
    """
    known = SharedCovariances() if known is None else known
    n_points = next(iter(chains.values())).n_points
    steps, pairs = known.steps_of(chains), places
    used, among = numbered(places)
    if len(used) < n_points:
        steps, pairs = steps.of_points(used, n_points), among
    found = steps.through_parameters(pairs, standard_errors, known)
    if steps.shared:
        n_all = max(n_parts(pairs), n_ranges(steps.shared, len(used)))
        parts = np.array_split(pairs, max(1, min(n_all, len(pairs))))
        work = partial(_between, steps.shared, standard_errors)
        found += np.concatenate(over_parts(work, parts, most_at_once=RANGES_AT_ONCE))
    if steps.unshared:
        same = np.flatnonzero(pairs[:, 0] == pairs[:, 1])
        ways = steps.unshared.items()
        of_points = sum(way.covariances(standard_errors[name]) for name, way in ways)
        found[same] += of_points[pairs[same, 0]]
    return found


def propagate(point_ids, chains, standard_errors, known=None) -> PropagatedErrors:
    """Covariances of the final points from all sources.

    ``standard_errors`` of each source are per coordinate [m], with a column for each
    axis where they differ; ``known`` are SharedCovariances.
    """
    n_points = next(iter(chains.values())).n_points
    known = SharedCovariances() if known is None else known
    steps = known.steps_of(chains)
    direct = _by_rows(steps.direct, standard_errors, n_points) if steps.direct else {}
    through = steps.variances(direct, standard_errors, known)
    parts = {name: (direct | through)[name] for name in chains}
    return PropagatedErrors(point_ids, parts, chains, standard_errors, known)


def _by_rows(chains, standard_errors, n_points):
    """Covariance of each point from each source, by its row of the whole product."""

    def covariances(places):
        rows = _rows_of(chains, places)
        return {source: of.covariances(standard_errors[source]) for source, of in rows}

    # in ranges of points: the product as a whole would hold some hundred blocks a point
    ranges = np.array_split(np.arange(n_points), n_ranges(chains, n_points))
    found = over_parts(covariances, ranges, most_at_once=RANGES_AT_ONCE)
    return {name: np.concatenate([part[name] for part in found]) for name in chains}


def _n_parameters(chains):
    """How many numbers chains lead to; the parameters may be a source themselves."""
    known = (one for chain in chains.values() for one in chain.products if one.factors)
    return next(known).shape[0]


def _rows_to_bundles(chains, size, bundles, n_columns, part=slice(None)):
    """Product of each chain for some bundles, in blocks of rows with the same gaps.

    Yields the name of each source, and its rows as a PointOperator; ``n_columns`` are
    the numbers that stand in all bundles, ``part`` those of a bundle that are wanted.
    """
    one = np.eye(size)[part]
    each, pointer = np.tile(one, (len(bundles), 1, 1)), np.arange(len(bundles) + 1)
    shape = len(bundles) * len(one), n_columns
    unit = sparse.bsr_array((each, bundles, pointer), shape=shape)
    yield from rows_of_chains(chains, unit, full=1.0)


def _of_part(rows, met, size, part, standard_errors):
    """Covariances of pairs of bundles of which errors reach a part only."""
    width = len(range(size)[part])
    found = joint_covariance(rows, met, width, standard_errors)
    if width == size:
        return found
    whole = np.zeros((len(met), size, size), dtype=found.dtype)
    whole[:, part, part] = found
    return whole


def _between(chains, standard_errors, places):
    points, pairs = numbered(places)
    return sum(
        rows.covariances_between(pairs, standard_errors[source])
        for source, rows in _rows_of(chains, points)
    )


def n_ranges(chains, n_points) -> int:
    """Into how many ranges the points are divided, so that memory suffices.

    As few as possible: a product of sparse matrices takes time for every column of the
    last one, however few rows the first one has.
    """
    numbers = max(
        one.axes.size(n_points) * _row_size(one, n_points)
        for chain in chains.values()
        for one in chain.products
    )
    return max(1, int(-(-numbers // NUMBERS_OF_RANGE)))


def _row_size(product, n_points):
    """Numbers that a row holds at most on its way through a product, about."""
    widest = max((matrix.shape[1] for matrix in product.factors), default=1)
    if product.axes.size(n_points) * widest <= NUMBERS_OF_RANGE:
        return widest  # all of them fit, even full ones
    return min(UNEVEN * SPARSE_SIZE * numbers_in_row(product), widest)


def _rows_of(chains, places):
    """Rows of some points in the product of each chain.

    Yields the name of each source, and its rows as a PointOperator.
    """
    any_chain = next(iter(chains.values()))
    picked = selection(places, any_chain.n_points, any_chain.axes)
    within = _slice_of(places, picked.axes)
    yield from rows_of_chains(chains, picked.matrix, within=within)


def _slice_of(places, axes):
    """Rows of points that follow each other, a slice; None of others."""
    if not len(places) or places[-1] - places[0] != len(places) - 1:
        return None
    if (np.diff(places) != 1).any():
        return None
    return slice(axes.size(int(places[0])), axes.size(int(places[-1]) + 1))
