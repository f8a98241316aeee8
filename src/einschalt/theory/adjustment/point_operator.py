"""Operators on rows of points, and what stands for a point in them.

A point is easting and northing, or easting, northing and height, in the rows and
columns of an operator; or it is one complex number E + iN, where both coordinates are
treated alike: a quarter of the numbers. Nobody else needs to know which.

Steps that follow each other are a product that is not formed: mostly some of its rows
are wanted, or what it makes of some columns.
"""

from dataclasses import dataclass
from enum import Enum
from functools import reduce
from operator import add, matmul

import numpy as np
from scipy import sparse

from einschalt.foundations.batches import over_segments, segment_sum, used_places
from einschalt.foundations.kernels import compiled

GROUND_NAMES = ("easting", "northing", "height")
N_PLAN = 2
# of the rows of pairs, which stay in the cache of a processor
NUMBERS_IN_CACHE = 100_000


class Axes(Enum):
    """Numbers that stand for a point in an operator."""

    COMPLEX = 1  # E + iN, where easting and northing are treated alike
    PLANE = 2  # easting, northing
    SPACE = 3  # easting, northing, height

    @property
    def names(self):
        """Coordinates of a point, tuple of str."""
        return GROUND_NAMES[: max(self.value, N_PLAN)]

    def rows(self, places):
        """Rows that belong to points, along one axis more, the last one."""
        return np.asarray(places)[..., None] * self.value + np.arange(self.value)

    def count(self, n_numbers):
        """Count the points that so many numbers stand for."""
        return n_numbers // self.value

    def size(self, n_points):
        """Count the numbers that stand for so many points."""
        return n_points * self.value

    def packed(self, vectors):
        """Numbers that stand for vectors of points, (n_points, n_coordinates)."""
        if self is Axes.COMPLEX:
            return vectors @ [1.0, 1j]
        return vectors.ravel()

    def unpacked(self, numbers):
        """Vectors of points that numbers stand for, (n_points, n_coordinates, …)."""
        if self is Axes.COMPLEX:
            return np.stack([numbers.real, numbers.imag], axis=1)
        return numbers.reshape(-1, self.value, *numbers.shape[1:])

    def plan(self, numbers):
        """Easting and northing alone, as :meth:`unpacked`."""
        return self.unpacked(numbers)[:, :N_PLAN]

    def each(self, sizes):
        """Sizes of errors by coordinate, (n_points, n_axes); one may stand for all."""
        columns = np.reshape(sizes, (len(sizes), -1))
        return np.broadcast_to(columns, (len(sizes), self.value))

    def blocks_of(self, shares):
        """Blocks of an operator that multiplies points by shares, (n, n_axes, n_axes).

        Shares are numbers (n,) or matrices (n, n_coordinates, n_coordinates); under
        complex operators those that turn and scale.
        """
        if shares.ndim == 1:
            return shares[:, None, None] * np.eye(self.value)
        if self is Axes.COMPLEX:
            same, cross = shares[:, :1, :1], shares[:, 1:2, :1]
            # affine models turn nothing: all that follows stays real, half the numbers
            return same + 1j * cross if cross.any() else same
        return shares

    def draw(self, rng, sizes, n_draws):
        """Draw normal errors of points, (n_numbers, n_draws).

        Standard errors are per coordinate, (n_points,) or (n_points, n_axes).
        """
        each = self.each(sizes).reshape(-1, 1)
        shape = (len(each), n_draws)
        if self is not Axes.COMPLEX:
            return each * rng.standard_normal(shape)
        drawn = np.empty(shape, dtype=complex)
        drawn.real = each * rng.standard_normal(shape)
        drawn.imag = each * rng.standard_normal(shape)
        return drawn


@dataclass(frozen=True, eq=False)
class PointOperator:
    """Linear operator from rows of points to rows of points.

    ``@`` puts one after another without multiplying, ``+`` adds without forming the
    products, ``formed`` multiplies. Without any factor it leaves everything as it is.
    """

    # sparse arrays: their product is the operator, the last step on the left
    factors: tuple
    axes: Axes
    added: tuple["PointOperator", ...] = ()  # products that are added to this one

    @classmethod
    def sum_of(cls, products):
        """Add operators, each of which is one product."""
        first, *others = products
        return cls(first.factors, first.axes, tuple(others))

    @property
    def products(self):
        """Operators without any sum that it is the sum of, the first one first."""
        return PointOperator(self.factors, self.axes), *self.added

    @property
    def shape(self):
        """Rows and columns of the product, in numbers."""
        return self.factors[0].shape[0], self.factors[-1].shape[1]

    @property
    def n_points(self):
        """Number of points that it gives."""
        return self.axes.count(self.shape[0])

    @property
    def n_sources(self):
        """Number of points that it takes."""
        return self.axes.count(self.shape[1])

    def __matmul__(self, other):
        """Take another step before: the product is not formed."""
        self._require_same_axes(other)
        if self.factors and other.factors and self.shape[1] != other.shape[0]:
            raise ValueError(f"operators of {self.shape} and {other.shape} numbers")
        return PointOperator.sum_of(
            PointOperator((*one.factors, *two.factors), self.axes)
            for one in self.products
            for two in other.products
        )

    def __neg__(self):
        return PointOperator.sum_of(
            PointOperator((-one.factors[0], *one.factors[1:]), self.axes)
            for one in self.products
        )

    def __add__(self, other):
        """Sum of products, none of which is formed."""
        self._require_same_axes(other)
        both = (*self.products, *other.products)
        if all(len(one.factors) == 1 for one in both):
            return PointOperator((sum(one.factors[0] for one in both),), self.axes)
        return PointOperator.sum_of(both)

    def __sub__(self, other):
        return self + -other

    def _require_same_axes(self, other):
        if self.axes is not other.axes:
            raise ValueError(f"operators of {self.axes} and of {other.axes}")

    @property
    def matrix(self):
        """The product, a sparse array."""
        return reduce(add, (reduce(matmul, one.factors) for one in self.products))

    def blocks_at(self, rows, columns):
        """Small matrices by which points depend on others, (n_pairs, n_axes, n_axes).

        ``rows`` has the places of the points that are given, ``columns`` of those that
        they are taken from.
        """
        matrix, n_axes = self.matrix.tocsr(), self.axes.value
        found = np.empty((len(rows), n_axes, n_axes), dtype=matrix.dtype)
        for a in range(n_axes):
            for b in range(n_axes):
                entries = matrix[rows * n_axes + a, columns * n_axes + b]
                found[:, a, b] = np.asarray(entries).ravel()
        return found

    def masked(self, pairs):
        """Keep only how some points depend on some others.

        ``pairs`` (n_points, n_sources) is sparse: 1 where they are kept.
        """
        whole = np.ones((self.axes.value, self.axes.value))
        mask = sparse.kron(pairs, whole, format="csr")
        return PointOperator((self.matrix.tocsr().multiply(mask),), self.axes)

    def finite(self):
        """Put 0 in the place of what is no number."""
        matrix = self.matrix.tocsr(copy=True)
        matrix.data = np.nan_to_num(matrix.data)
        return PointOperator((matrix,), self.axes)

    def row_sums(self):
        """What becomes of a shift that all points share: on the diagonal, row sums."""
        n_axes = self.axes.value
        every = np.tile(np.eye(n_axes), (self.n_sources, 1))
        return on_diagonal((self.matrix @ every).reshape(-1, n_axes, n_axes))

    @property
    def used_sources(self):
        """Points on which any point depends, ascending, ndarray of int."""
        used = self.axes.count(self.matrix.tocsr().indices)
        return used_places(used, self.n_sources)

    def depends_on(self, sources):
        """Tell which points depend on any of some others."""
        chosen = np.zeros(self.shape[1])
        chosen[self.axes.rows(sources).ravel()] = 1.0
        share = abs(self.matrix.tocsr()) @ chosen
        return (share.reshape(-1, self.axes.value) > 0.0).any(axis=1)

    @property
    def T(self):  # noqa: N802
        """Transposed, not conjugated."""
        return PointOperator.sum_of(
            PointOperator(tuple(part.T for part in one.factors[::-1]), self.axes)
            for one in self.products
        )

    def formed(self):
        """Multiply its factors: the same operator with one factor."""
        return PointOperator((self.matrix,), self.axes)

    def tocsr(self):
        """As :meth:`formed`, by rows."""
        return PointOperator((self.matrix.tocsr(),), self.axes)

    @property
    def last_step(self):
        """The factor on the left alone, the same in all products."""
        return PointOperator(self.factors[:1], self.axes)

    def with_last_step(self, last_step):
        """Take another last step, of the same values, in place of its own."""
        return PointOperator.sum_of(
            PointOperator((*last_step.factors, *one.factors[1:]), self.axes)
            for one in self.products
        )

    def apply(self, numbers):
        """What becomes of packed vectors, or of columns of them."""
        if numbers.ndim == 1:
            return self.apply(numbers[:, None])[:, 0]
        return _applied([one.factors for one in self.products], numbers)

    def of_vectors(self, vectors):
        """What becomes of vectors of points, (n_sources, n_coordinates)."""
        return self.axes.unpacked(self.apply(self.axes.packed(vectors)))

    def of_functionals(self, rows):
        """Weighted sums of what it gives, as sums over what it takes.

        From ``rows`` (n_sums, n_points, n_coordinates) to (n_sums, n_numbers). A sum is
        the real part of a row times packed vectors.
        """
        if self.axes is Axes.COMPLEX:
            rows = rows @ np.array([1.0, -1j])
        rows = rows.reshape(len(rows), -1)
        return sum(reduce(matmul, one.factors, rows) for one in self.products)

    def covariances(self, standard_errors):
        """Covariance of each point, (…, n_coordinates, n_coordinates) [m²].

        Independent standard errors are per coordinate, (n_sources,) or (n_sources,
        n_axes) [m]. Equal and uncorrelated ones stay so under complex operators.
        """
        matrix, each = self.matrix, self.axes.each(standard_errors)
        if not sparse.issparse(matrix):
            if self.axes is Axes.COMPLEX:
                variances = _squares(matrix) @ np.square(each)
                return of_real_axes(variances[..., None])
            scaled = matrix * each.ravel()
            every = np.arange(self.n_points)
            return self._products_of(scaled, np.column_stack([every, every]))
        size = (self.axes.value, self.axes.value)
        blocks = sparse.bsr_array(matrix, blocksize=size)
        start = blocks.indptr.astype(np.int64)
        found = np.zeros((len(start) - 1, *size), dtype=blocks.dtype)
        variances = np.square(each)
        over_segments(
            _sum_of_products, start, blocks.indices, blocks.data, variances, found
        )
        return of_real_axes(found) if self.axes is Axes.COMPLEX else found

    def covariances_between(self, pairs, standard_errors):
        """Covariances between pairs of points, (n_pairs, 2), from independent errors.

        As :meth:`covariances`; rows belong to the first point.
        """
        n_axes, pairs = self.axes.value, np.ascontiguousarray(pairs, dtype=np.int64)
        if not sparse.issparse(self.matrix):
            scaled = self.matrix * self.axes.each(standard_errors).ravel()
            return self._products_of(scaled, pairs)
        rows = sparse.csr_array(self.matrix)
        rows.sort_indices()
        out = np.zeros((len(pairs), n_axes, n_axes), dtype=rows.dtype)
        variances = np.square(self.axes.each(standard_errors)).ravel()
        entries = (rows.indptr, rows.indices, rows.data)
        _multiply_rows(*entries, variances, pairs, out)
        return of_real_axes(out) if self.axes is Axes.COMPLEX else out

    def _products_of(self, scaled, pairs):
        """Sums of products of the full rows of pairs of points, as covariances."""
        rows = scaled.reshape(-1, self.axes.value, scaled.shape[1])
        n_parts = -(-len(pairs) * rows[:1].size // NUMBERS_IN_CACHE)
        parts = np.array_split(pairs, max(1, n_parts))
        products = [
            np.einsum("pin,pjn->pij", rows[part[:, 0]], rows[part[:, 1]].conj())
            for part in parts
        ]
        found = np.concatenate(products)
        return of_real_axes(found) if self.axes is Axes.COMPLEX else found


def unchanged(axes):
    """Leave all points as they are, however many they are."""
    return PointOperator((), axes)


def of_blocks(blocks, columns, pointer, n_columns):
    """Operator of small matrices, each from one point to another.

    ``blocks`` (n_blocks, n_axes, n_axes) are sorted by the point that they lead to:
    point k has those from ``pointer[k]``. Each leads from the point ``columns[i]``, one
    of ``n_columns``.
    """
    axes = Axes(blocks.shape[1])
    shape = (axes.size(len(pointer) - 1), axes.size(n_columns))
    return PointOperator((sparse.bsr_array((blocks, columns, pointer), shape),), axes)


def on_diagonal(blocks):
    """Operator of a small matrix for each point, shape (n_points, n_axes, n_axes)."""
    places = np.arange(len(blocks) + 1)
    return of_blocks(blocks, places[:-1], places, len(blocks))


def sums(shares, columns, pointer, n_columns, axes):
    """Weighted sums of points, sum k from ``pointer[k]``.

    ``shares`` are numbers (n_values,), the same in every coordinate, or matrices
    (n_values, n_coordinates, n_coordinates); ``columns`` has the point that each
    belongs to, one of ``n_columns``.
    """
    return of_blocks(axes.blocks_of(shares), columns, pointer, n_columns)


def selection(columns, n_columns, axes):
    """Pick points: row i of the result is the point ``columns[i]``."""
    one = np.ones(len(columns))
    return sums(one, columns, np.arange(len(columns) + 1), n_columns, axes)


def weighted_mean(rows, weights, start, n_all, axes):
    """Weighted mean of the values of each point, of ``n_all`` values.

    ``rows`` has the values, sorted by point; the weights are numbers, or matrices whose
    sum is the unit matrix at every point.
    """
    if weights.ndim > 1:
        return sums(weights, rows, start, n_all, axes)
    share = weights / np.repeat(segment_sum(weights, start), np.diff(start))
    return sums(share, rows, start, n_all, axes)


def zero(n_points, n_sources, axes):
    """Operator of which nothing comes."""
    shape = (axes.size(n_points), axes.size(n_sources))
    return PointOperator((sparse.csr_array(shape),), axes)


def by_coordinate(matrix, axes, *, is_plan_only=False):
    """Operator of a sparse matrix that has one row and one column for each point.

    ``is_plan_only`` leaves heights out: 0 comes of them.
    """
    is_used = np.arange(axes.value) < (N_PLAN if is_plan_only else axes.value)
    each = np.diag(is_used.astype(float))
    return PointOperator((sparse.kron(matrix, each, format="csr"),), axes)


def stacked(rows):
    """Operator of operators beside each other in a row, and rows above each other."""
    beside = [sparse.hstack([part.matrix.tocsr() for part in row]) for row in rows]
    return PointOperator((sparse.vstack(beside, format="csr"),), rows[0][0].axes)


def _applied(products, numbers):
    """Sum of what products make of columns; last steps that they share are taken once.

    ``products`` are the steps of each, the last one first.
    """
    alike, out = {}, None
    for steps in products:
        if steps:
            alike.setdefault(id(steps[0]), []).append(steps)
        else:
            out = numbers.copy() if out is None else out + numbers
    for parts in alike.values():
        inner = _applied([steps[1:] for steps in parts], numbers)
        out = _add_product(parts[0][0], inner, out)
    return out


def _add_product(matrix, columns, out=None):
    """Product of a sparse matrix and columns, added to ``out`` if that is given."""
    dtype = np.result_type(matrix.dtype, columns.dtype)
    if out is None:
        out = np.zeros((matrix.shape[0], columns.shape[1]), dtype)
    elif out.dtype != dtype:
        out = out.astype(np.result_type(out, dtype))
    rows, numbers = sparse.csr_array(matrix), out
    columns = np.ascontiguousarray(columns, dtype=out.dtype)
    if np.iscomplexobj(out) and not np.iscomplexobj(rows):
        # two real columns for each complex one: half the work
        columns, numbers = columns.view(float), out.view(float)
    over_segments(
        _add_rows,
        rows.indptr.astype(np.int64),
        rows.indices.astype(np.int64),
        rows.data,
        columns,
        numbers,
    )
    return out


def _squares(numbers):
    """Squares of the lengths of complex numbers; a root of them is not drawn."""
    if np.iscomplexobj(numbers):
        return np.square(numbers.real) + np.square(numbers.imag)
    return np.square(numbers)


def of_real_axes(scalar):
    """Covariance of easting and northing from that of E + iN."""
    found = np.empty((len(scalar), N_PLAN, N_PLAN))
    found[:, 0, 0] = found[:, 1, 1] = np.real(scalar[:, 0, 0])
    found[:, 1, 0] = np.imag(scalar[:, 0, 0])
    found[:, 0, 1] = -found[:, 1, 0]
    return found


@compiled
def _add_rows(first, last, start, column, value, columns, out):
    for row in range(first, last):
        for k in range(start[row], start[row + 1]):
            factor, given = value[k], columns[column[k]]
            for j in range(len(given)):
                out[row, j] += factor * given[j]


@compiled
def _sum_of_products(first, last, start, columns, blocks, variances, out):
    n_axes = out.shape[1]
    for row in range(first, last):
        for k in range(start[row], start[row + 1]):
            for a in range(n_axes):
                for b in range(n_axes):
                    for c in range(n_axes):
                        product = blocks[k, a, c] * np.conj(blocks[k, b, c])
                        out[row, a, b] += variances[columns[k], c] * product


@compiled
def _multiply_rows(pointer, column, value, variances, pairs, out):
    n_axes = out.shape[1]
    for p in range(len(pairs)):
        for a in range(n_axes):
            row_a = pairs[p, 0] * n_axes + a
            for b in range(n_axes):
                row_b = pairs[p, 1] * n_axes + b
                i, last_i = pointer[row_a], pointer[row_a + 1]
                j, last_j = pointer[row_b], pointer[row_b + 1]
                while i < last_i and j < last_j:
                    if column[i] < column[j]:
                        i += 1
                    elif column[i] > column[j]:
                        j += 1
                    else:
                        product = value[i] * np.conj(value[j])
                        out[p, a, b] += variances[column[i]] * product
                        i += 1
                        j += 1
