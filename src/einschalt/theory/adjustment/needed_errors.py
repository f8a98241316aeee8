"""Chains of steps to some of all quantities, and the errors that reach these.

A sum over part of a large block depends on the errors of that part and of what is
around it. Neither the others need be drawn, nor the rows of the steps between that
nothing asks for.

See docs/theory/variance_components.md.
"""

import numpy as np

from einschalt.foundations.batches import used_places
from einschalt.theory.adjustment.point_operator import PointOperator


def needed_errors(chains, standard_errors):
    """Chains without what does not reach them, and the errors that do.

    Parameters
    ----------
    chains : sequence of dict of str to PointOperator
        From the errors of each source to some quantities, all by rows.
    standard_errors : dict of str to ndarray
        Size of the errors of each source, (n_points,) or (n_points, n_axes) [m].

    Returns
    -------
    list of dict of str to PointOperator
        The same quantities from the errors that are left.
    dict of str to ndarray
        Standard errors of these.

    Examples
    --------
    >>> from scipy import sparse
    >>> from einschalt.theory.adjustment.point_operator import Axes
    >>> step = sparse.csr_array([[1.0, 0.0, 0.0], [0.0, 1.0, 1.0]])
    >>> second = PointOperator((step[1:], sparse.eye_array(3).tocsr()), Axes.COMPLEX)
    >>> (chain,), errors = needed_errors([{"own": second}], {"own": np.arange(3.0)})
    >>> chain["own"].matrix.toarray().tolist(), errors["own"].tolist()
    ([[1.0, 1.0]], [1.0, 2.0])
    """
    short = [
        {name: [_with_used_rows(one) for one in c.products] for name, c in part.items()}
        for part in chains
    ]
    kept = {
        name: _used_points([part[name] for part in short if name in part], sizes)
        for name, sizes in standard_errors.items()
    }
    chains = [
        {
            name: PointOperator.sum_of(_from_points(one, kept[name]) for one in chain)
            for name, chain in part.items()
        }
        for part in short
    ]
    return chains, {name: sizes[kept[name]] for name, sizes in standard_errors.items()}


def _with_used_rows(one):
    """The same product, without the rows of each factor that the one before leaves."""
    if not one.factors:
        return one
    before, *others = one.factors
    factors = []
    for factor in others:
        used = used_places(before.indices, before.shape[1])
        factors.append(before[:, used])
        before = factor[used]
    return PointOperator((*factors, before), one.axes)


def _used_points(chains, sizes):
    """Points of a source from which anything comes, ascending."""
    n_points = len(sizes)
    used = np.zeros(n_points, dtype=bool)
    for one in (one for products in chains for one in products):
        if not one.factors:  # every error is a quantity
            return np.arange(n_points)
        used[one.axes.count(one.factors[-1].indices)] = True
    return np.flatnonzero(used)


def _from_points(one, points):
    """A product that starts from some points of its source alone."""
    if not one.factors:
        return one
    columns = one.axes.rows(points).ravel()
    return PointOperator((*one.factors[:-1], one.factors[-1][:, columns]), one.axes)
