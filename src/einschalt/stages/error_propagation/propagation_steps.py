"""Steps of a propagation: what goes through the parameters of models, and what beside.

Values of a model depend on its parameters, of the transformation and of the relative
orientation, and these on all points of the model; a value depends on its own
measurements besides. What depends on parameters is computed once for all of it.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from operator import add

import numpy as np
from scipy import sparse

from einschalt.theory.adjustment.bundled_covariance import (
    BundledRows,
    points_in_a_bundle,
)
from einschalt.theory.adjustment.joined_bundles import joined_bundles
from einschalt.theory.adjustment.point_operator import (
    Axes,
    PointOperator,
    selection,
)
from einschalt.theory.adjustment.rows_of_chains import beginning, filled, times

PAIRS_AT_ONCE = 50_000
N_SAMPLED = 100  # points whose rows tell how full they are
ROUNDING = 1e-12  # of the variances that cancel each other
# what an entry of a sparse matrix takes, with its place and what is computed from it
SPARSE_SIZE = 3.0


@dataclass(frozen=True, eq=False)
class PropagationSteps:
    """Chains, apart in what goes through the parameters of models and what does not.

    Products that begin with the same steps, the last of which has fewer columns than
    rows: the fewest such steps that products begin with, and do not end with.
    """

    last: PointOperator | None  # from the parameters to the points
    through: dict[str, PointOperator]  # from the sources to the parameters
    direct: dict[str, PointOperator]  # from the sources to the points
    size: int = 0  # of a bundle of parameters: one for all, whatever points are asked
    # numbers of a bundle that a source reaches; all of them where it is left out
    parts: dict[str, slice] = field(default_factory=dict)

    @classmethod
    def of(cls, chains, known=None):
        """Split chains, dict of str to PointOperator.

        ``known`` keeps how bundles of parameters were put together, KnownBundles.
        """
        ways = _ways_through_parameters(chains)
        if not ways:
            return cls(None, {}, chains)
        ways, size = _joined(ways, KnownBundles() if known is None else known)
        through, direct, used = {}, {}, {}
        for name, chain in chains.items():
            for product in chain.products:
                way = next((way for way in ways if way.begins(product)), None)
                if way is None:
                    direct.setdefault(name, []).append(product)
                else:
                    through.setdefault(name, []).append(way.rest_of(product))
                    used.setdefault(name, set()).add(way)
        parts = {n: w.part for n, (w, *others) in used.items() if not others and w.part}
        through, direct = (
            {name: PointOperator.sum_of(found) for name, found in part.items()}
            for part in (through, direct)
        )
        lasts = [way.last for way in ways]
        last = lasts[0] if len(lasts) == 1 else PointOperator.sum_of(lasts).formed()
        in_row = last.factors[0].nnz / max(1, last.shape[0])
        for name in through.keys() & direct.keys():
            if all(numbers_in_row(way) <= in_row for way in direct[name].products):
                direct[name] = direct[name].formed()
            else:  # all points of a model depend on what it was fitted to anyway
                direct[name] = _with_one_beginning(chains[name])
                del through[name]
        if not through:
            return cls(None, {}, chains)
        return cls(last, through, direct, last.axes.size(size), parts)

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
        parts = np.array_split(pairs, n_parts(pairs))
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
        given = met, self.size, self.through, standard_errors
        joint = known.covariances(*given, self.parts)
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


def n_parts(pairs):
    """Into how many parts pairs of points are divided, (n_pairs, 2)."""
    return max(1, -(-len(pairs) // PAIRS_AT_ONCE))


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


@dataclass(frozen=True, eq=False)
class _Way:
    """First steps of products, from parameters of models to the points."""

    steps: tuple  # factors, the last step first
    following: object  # the factor after them in one of the products
    axes: Axes
    n_products: int  # that begin so
    onto: PointOperator | None = None  # from its parameters to joined ones, if these
    part: slice | None = None  # its numbers in a joined bundle

    @property
    def last(self):
        """From the parameters, or from joined ones, to the points."""
        own = PointOperator(self.steps, self.axes).formed()
        return own if self.onto is None else (own @ self.onto.T).formed()

    @property
    def n_together(self):
        """How many points stand for the parameters of a model.

        These follow from the same points, whatever depends on them.
        """
        return points_in_a_bundle(self.following.T, self.axes)

    def begins(self, product):
        """Whether a product begins with these steps."""
        return beginning(product, len(self.steps)) == tuple(map(id, self.steps))

    def rest_of(self, product):
        """What stands before the parameters in a product that begins so."""
        rest = PointOperator(product.factors[len(self.steps) :], self.axes)
        return rest if self.onto is None else self.onto @ rest


class KnownBundles:
    """How bundles of parameters were put together, kept for the same parameters.

    What follows from parameters is told apart by the identity of the matrices, see
    SharedCovariances: points, their means and differences must ask for the same ones.
    """

    def __init__(self):
        self._kept = None  # set as a whole, as in SharedCovariances

    def joined(self, ways):
        """Ways with bundles side by side, and how many points stand in one.

        Without those whose parameters are those of other rows.
        """
        matrices = [(way.steps[-1], way.following) for way in ways]
        key, kept = [tuple(map(id, pair)) for pair in matrices], self._kept
        if kept is None or kept[0] != key:
            axes, n_each = ways[0].axes, [way.n_together for way in ways]
            kinds = [PointOperator(pair[:1], axes) for pair in matrices]
            self._kept = kept = key, matrices, (n_each, joined_bundles(kinds, n_each))
        found, n_points = [], 0
        for way, n, onto in zip(ways, *kept[2], strict=True):
            if onto is not None:
                part = slice(*(way.axes.size(k) for k in (n_points, n_points + n)))
                found.append(replace(way, onto=onto, part=part))
                n_points += n
        return found, n_points


def _ways_through_parameters(chains):
    """First steps that products begin with, the way of most of them first: list."""
    alike = {}
    for chain in chains.values():
        for one in chain.products:
            n_first = _n_steps_to_fewer(one)
            if n_first is not None:
                alike.setdefault(beginning(one, n_first), []).append((n_first, one))
    ways = [
        _Way(one.factors[:n_first], one.factors[n_first], one.axes, len(products))
        for products in alike.values()
        for n_first, one in products[:1]
    ]
    # where as many go one way as another, through the fewest numbers
    return sorted(ways, key=lambda way: (-way.n_products, way.steps[-1].shape[1]))


def _joined(ways, known):
    """The first way, with others whose parameters are those of the same models.

    Gives the ways, and how many points stand in a bundle of all their parameters.
    """
    if len(ways) > 1:
        found, n_points = known.joined(ways)
        if len(found) > 1:
            return found, n_points
    return ways[:1], ways[0].n_together


def _n_steps_to_fewer(product):
    for n_first, matrix in enumerate(product.factors[:-1], start=1):
        if matrix.shape[1] < matrix.shape[0]:
            return n_first
    return None


def _shared(direct, through, standard_errors):
    """Covariances of points, by one way, with parameters, by the other one."""
    axes = direct.axes
    variances = np.square(axes.each(standard_errors)).ravel()
    rows = sparse.csr_array(through.matrix) * variances
    return PointOperator((sparse.csr_array(direct.matrix) @ rows.conj().T,), axes)


def numbers_in_row(product):
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
