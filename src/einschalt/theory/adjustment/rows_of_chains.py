"""Some rows of chains of steps from several sources of errors.

What chains begin with alike is multiplied once; see PointOperator for the steps.

See docs/theory/propagation.md.
"""

from collections import Counter
from functools import reduce
from operator import add

import numpy as np
from scipy import sparse

from einschalt.theory.adjustment.block_products import Product, sum_of_two
from einschalt.theory.adjustment.point_operator import PointOperator

# share of entries from which a product is no longer kept sparse
FULL = 0.1


def rows_of_chains(chains, picked, full=FULL, within=None):
    """Picked rows in the product of each chain; what begins alike is shared.

    Parameters
    ----------
    chains : dict of str to PointOperator
    picked : sparse array
        Picks the rows, or sums of them, from those of the products.
    full : float
        The share of entries up to which they are kept sparse.
    within : slice, optional
        What is picked, if that is a slice: it is taken out of the first factor without
        a product.

    Yields
    ------
    tuple of str and PointOperator
        Each source, and its rows.
    """
    rows = _Rows(chains, {(): picked}, full, within)
    for source, chain in chains.items():
        yield source, PointOperator((rows.of_sum(chain.products),), chain.axes)


class _Rows:
    """Rows of products, as far as they are done, by what these begin with."""

    def __init__(self, chains, done, full, within):
        self.done, self.full, self.within = done, full, within
        self.beginnings = Counter(
            beginning(one, n_steps)
            for chain in chains.values()
            for one in chain.products
            for n_steps in _lengths(one)
        )

    def of_sum(self, products):
        """Rows of a sum of products."""
        if len(products) == 2 and not any(map(self._is_shared, products)):
            before = [self.of_product(one, len(one.factors) - 1) for one in products]
            if all(map(_stands_in_blocks, before)):
                last = (one.factors[-1] for one in products)
                both = map(Product.of, before, last)
                return filled(sum_of_two(*both), self.full)
        return reduce(add, map(self.of_product, products))

    def of_product(self, one, n_steps=None):
        """Rows after so many steps of a product, all of them by default."""
        n_steps = len(one.factors) if n_steps is None else n_steps
        known = (n for n in range(n_steps + 1) if beginning(one, n) in self.done)
        n_known = max(known)
        rows = self.done[beginning(one, n_known)]
        for n, matrix in enumerate(one.factors[n_known:n_steps], start=n_known):
            is_cut = n == 0 and self.within is not None and matrix.format == "csr"
            rows = matrix[self.within] if is_cut else times(rows, matrix)
            rows = filled(rows, self.full)
            if self.beginnings[beginning(one, n + 1)] > 1:
                self.done[beginning(one, n + 1)] = rows
        return rows

    def _is_shared(self, one):
        """Whether another chain has the whole product as well."""
        return self.beginnings[beginning(one, len(one.factors))] > 1


def beginning(one, n_steps):
    """What tells the first steps of a product apart: the identity of their matrices."""
    return tuple(map(id, one.factors[:n_steps]))


def _lengths(one):
    return range(1, len(one.factors) + 1)


def times(rows, matrix):
    """Take one more step."""
    # models that are not usable have no part, but 0 · NaN would be NaN
    if not sparse.issparse(rows) and not np.isfinite(matrix.data).all():
        rows = sparse.csr_array(rows)
    return rows @ matrix


def _stands_in_blocks(rows):
    """Whether several rows stand in a block, each with as many columns as a point."""
    is_of_blocks = getattr(rows, "format", "") == "bsr"
    return is_of_blocks and rows.blocksize[0] > rows.blocksize[1]


def filled(rows, full=FULL):
    """As a full matrix where most of it is needed: it multiplies much faster."""
    is_full = sparse.issparse(rows) and rows.nnz > full * rows.shape[0] * rows.shape[1]
    # by rows: from small matrices scipy would go through a list of all entries
    return rows.tocsr().toarray() if is_full else rows
