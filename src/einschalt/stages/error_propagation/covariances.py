"""Covariances of points from the errors of all observations: L Σ Lᵀ.

Operators lead from every source of errors to the points. Most go through the parameters
of models, of which there are far fewer than values: what these share is computed once,
for all that depends on them.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property, partial, reduce
from operator import add
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from einschalt.foundations.batches import numbered, over_parts
from einschalt.foundations.errors import TableError
from einschalt.foundations.names import encode
from einschalt.theory.adjustment.bundled_covariance import (
    BundledRows,
    points_in_a_bundle,
)
from einschalt.theory.adjustment.joint_covariance import BundlePairs, joint_covariance
from einschalt.theory.adjustment.point_operator import Axes, PointOperator, selection
from einschalt.theory.adjustment.rows_of_chains import (
    beginning,
    filled,
    rows_of_chains,
    times,
)
from einschalt.theory.adjustment.through_models import joint_through_models

# numbers of a full matrix: 80 MB for each range of points, 160 MB for those at once
NUMBERS_OF_RANGE, RANGES_AT_ONCE = 10_000_000, 2
PAIRS_AT_ONCE = 50_000
# what an entry of a sparse matrix takes, with its place and what is computed from it
SPARSE_SIZE = 3.0
UNEVEN = 2.0  # size of the fullest rows, over the mean
N_SAMPLED = 100  # points whose rows tell how full they are
ROUNDING = 1e-12  # of the variances that cancel each other


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

    def steps_of(self, chains):
        """Steps of chains, which several questions about the same points need."""
        key, kept = identity_of(chains), self._steps
        if kept is None or kept[0] != key:
            # chains are kept, so that another matrix cannot have the identity of theirs
            self._steps = kept = key, chains, _Steps.of(chains)
        return kept[2]

    def covariances(self, met, size, chains, standard_errors):
        """Covariances of pairs of parameters from each source, (n_met, size, size).

        ``met`` are the BundlePairs; ``chains`` lead to the parameters, of which
        ``size`` numbers stand in a bundle.
        """
        sizes = [standard_errors[name] for name in chains]
        key, kept = (size, identity_of(chains), tuple(map(id, sizes))), self._kept
        is_same = kept is not None and kept.key == key
        places = kept.met.places_of(met) if is_same else None
        if places is not None:
            return {name: blocks[places] for name, blocks in kept.joint.items()}
        bundles, met_of_these = met.alone()
        joint = self._through_models(chains, size, bundles, met_of_these, sizes)
        others = {name: one for name, one in chains.items() if name not in joint}
        n = _n_parameters(chains)
        for source, rows in _rows_to_bundles(others, size, bundles, n):
            each = standard_errors[source]
            joint[source] = joint_covariance(rows, met_of_these, size, each)
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
        n_parts = max(_n_parts(pairs), n_ranges(steps.shared, len(used)))
        parts = np.array_split(pairs, max(1, min(n_parts, len(pairs))))
        work = partial(_between, steps.shared, standard_errors)
        found += np.concatenate(over_parts(work, parts, most_at_once=RANGES_AT_ONCE))
    if steps.unshared:
        same = np.flatnonzero(pairs[:, 0] == pairs[:, 1])
        ways = steps.unshared.items()
        of_points = sum(way.covariances(standard_errors[name]) for name, way in ways)
        found[same] += of_points[pairs[same, 0]]
    return found


def _n_parts(pairs):
    return max(1, -(-len(pairs) // PAIRS_AT_ONCE))


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


@dataclass(frozen=True, eq=False)
class _Steps:
    """Chains, apart in what goes through the parameters of models and what does not.

    Products that begin with the same steps, the last of which has fewer columns than
    rows: the fewest such steps that products begin with, and do not end with.
    """

    last: PointOperator | None  # from the parameters to the points
    through: dict[str, PointOperator]  # from the sources to the parameters
    direct: dict[str, PointOperator]  # from the sources to the points
    size: int = 0  # of a bundle of parameters: one for all, whatever points are asked

    @classmethod
    def of(cls, chains):
        """Split chains, dict of str to PointOperator."""
        alike = {}
        for chain in chains.values():
            for one in chain.products:
                n_first = _n_steps_to_fewer(one)
                if n_first is not None:
                    alike.setdefault(beginning(one, n_first), []).append((n_first, one))
        if not alike:
            return cls(None, {}, chains)
        # where as many go one way as another, through the fewest numbers
        key = max(alike, key=lambda key: (len(alike[key]), -_width(*alike[key][0])))
        n_first, one = alike[key][0]
        through, direct = {}, {}
        for name, chain in chains.items():
            for product in chain.products:
                if beginning(product, n_first) == key:
                    rest = PointOperator(product.factors[n_first:], product.axes)
                    through.setdefault(name, []).append(rest)
                else:
                    direct.setdefault(name, []).append(product)
        through, direct = (
            {name: PointOperator.sum_of(found) for name, found in part.items()}
            for part in (through, direct)
        )
        last = PointOperator(one.factors[:n_first], one.axes).formed()
        in_row = last.factors[0].nnz / max(1, last.shape[0])
        for name in through.keys() & direct.keys():
            if all(_numbers_in_row(way) <= in_row for way in direct[name].products):
                direct[name] = direct[name].formed()
            else:  # errors of images, which all points of a model depend on anyway
                direct[name] = _with_one_beginning(chains[name])
                del through[name]
        if not through:
            return cls(None, {}, chains)
        # parameters of a model follow from the same points, whatever depends on them
        n_together = points_in_a_bundle(one.factors[n_first].T, one.axes)
        return cls(last, through, direct, one.axes.size(n_together))

    @property
    def axes(self):
        """Of the operators."""
        known = self.last, *self.direct.values()
        return next(one.axes for one in known if one is not None)

    @cached_property
    def unshared(self):
        """What of it goes from each source to one point at most."""
        ways = self.direct.items()
        return {name: way for name, way in ways if _is_unshared(way)}

    @cached_property
    def shared(self):
        """What of it reaches several points."""
        ways = self.direct.items()
        return {name: way for name, way in ways if name not in self.unshared}

    def of_points(self, places, n_points):
        """The same steps to some of the points."""
        picked = selection(places, n_points, self.axes)
        direct = {name: picked @ chain for name, chain in self.direct.items()}
        for name in self.unshared:
            direct[name] = direct[name].formed()
        last = None if self.last is None else (picked @ self.last).formed()
        return replace(self, last=last, direct=direct)

    def through_parameters(self, pairs, standard_errors, known):
        """What parameters make of the covariances of pairs of points [m²].

        Between them, and between them and what does not go through them.
        """
        if self.last is None:
            n_coordinates = len(self.axes.names)
            return np.zeros((len(pairs), n_coordinates, n_coordinates))
        rows, met, joint = self._joint(pairs, standard_errors, known)
        joint = reduce(add, joint.values())
        beside = self._beside(rows, standard_errors).values()
        parts = np.array_split(pairs, _n_parts(pairs))
        found = [rows.covariances(part, met, joint, beside) for part in parts]
        return np.concatenate(found)

    def variances(self, of_direct, standard_errors, known):
        """Covariance of each point from every source that goes through parameters.

        ``of_direct`` are those of what goes beside them. Where both, or errors of
        several parameters, cancel each other, no rounding is left.
        """
        if self.last is None:
            return {}
        pairs, found = np.column_stack([np.arange(self.last.n_points)] * 2), {}
        rows, met, joint = self._joint(pairs, standard_errors, known)
        beside = self._beside(rows, standard_errors)
        for name, part in joint.items():
            whole = rows.variances(met, part)
            size = rows.independent_variances(met, part)
            if name in of_direct:
                whole += rows.covariances_with(beside[name], pairs)
                whole += of_direct[name]
                size += np.trace(of_direct[name], axis1=1, axis2=2)
            whole[np.trace(whole, axis1=1, axis2=2) < ROUNDING * size] = 0.0
            found[name] = whole
        return found

    def _joint(self, pairs, standard_errors, known):
        """Rows of points by bundles of parameters, and what these share by the source.

        Gives BundledRows, the BundlePairs that meet in pairs of points, and their
        covariances.
        """
        rows = BundledRows.of(self.last, self.size)
        met = rows.neighbours(pairs)
        joint = known.covariances(met, self.size, self.through, standard_errors)
        return rows, met, joint

    def _beside(self, rows, standard_errors):
        """Covariances of points with parameters, of sources that go both ways."""
        return {
            name: BundledRows.of(
                _shared(self.direct[name], self.through[name], standard_errors[name]),
                rows.size,
            )
            for name in self.through.keys() & self.direct.keys()
        }


def _is_unshared(way):
    """Whether it is one step in which no source reaches two points."""
    if len(way.products) > 1 or len(way.factors) != 1:
        return False
    size = (way.axes.value, way.axes.value)
    sources = sparse.bsr_array(way.factors[0], blocksize=size).indices
    return bool(np.bincount(sources, minlength=1).max() <= 1)


def _with_one_beginning(chain):
    """Form the sum of what products begin with, as far as they do not end alike."""
    factors = [one.factors for one in chain.products]
    n_last, least = 0, min(map(len, factors))
    while n_last < least - 1 and len({id(f[-1 - n_last]) for f in factors}) == 1:
        n_last += 1
    if n_last == 0:
        return chain
    first = (PointOperator(f[:-n_last], chain.axes) for f in factors)
    last = PointOperator(factors[0][-n_last:], chain.axes)
    return PointOperator.sum_of(first).formed() @ last


def _n_steps_to_fewer(product):
    for n_first, matrix in enumerate(product.factors[:-1], start=1):
        if matrix.shape[1] < matrix.shape[0]:
            return n_first
    return None


def _width(n_first, product):
    return product.factors[n_first - 1].shape[1]


def _shared(direct, through, standard_errors):
    """Covariances of points, by one way, with parameters, by the other one."""
    axes = direct.axes
    variances = np.square(axes.each(standard_errors)).ravel()
    rows = sparse.csr_array(through.matrix) * variances
    return PointOperator((sparse.csr_array(direct.matrix) @ rows.conj().T,), axes)


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


def _rows_to_bundles(chains, size, bundles, n_columns):
    """Product of each chain for some bundles, in blocks of rows with the same gaps.

    Yields the name of each source, and its rows as a PointOperator; ``n_columns`` are
    the numbers that stand in all bundles.
    """
    each = np.tile(np.eye(size), (len(bundles), 1, 1))
    pointer = np.arange(len(bundles) + 1)
    shape = len(bundles) * size, n_columns
    unit = sparse.bsr_array((each, bundles, pointer), shape=shape)
    yield from rows_of_chains(chains, unit, full=1.0)


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
    return min(UNEVEN * SPARSE_SIZE * _numbers_in_row(product), widest)


def _numbers_in_row(product):
    """Numbers that a row holds at most on its way through a product, on the average.

    As the rows of some points show, that lie all over the block.
    """
    n_all = product.n_points
    sampled = np.unique(np.linspace(0, n_all - 1, min(N_SAMPLED, n_all)).astype(int))
    rows, largest = selection(sampled, n_all, product.axes).matrix, 0
    for matrix in product.factors:
        rows = filled(times(rows, matrix))
        is_sparse = sparse.issparse(rows)
        largest = max(largest, rows.nnz if is_sparse else rows.size / SPARSE_SIZE)
    return largest / max(1, product.axes.size(len(sampled)))


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
