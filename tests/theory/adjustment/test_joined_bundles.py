"""Bundles of parameters of several kinds beside each other."""

import numpy as np
import pytest
from scipy import sparse

from einschalt.theory.adjustment.joined_bundles import joined_bundles
from einschalt.theory.adjustment.point_operator import Axes, PointOperator


def _kind(bundle_of_row, n_bundles, n_each, axes):
    """Operator in which each row of points uses one bundle; -1 uses none."""
    used = np.flatnonzero(bundle_of_row >= 0)
    size = axes.size(n_each)
    blocks = np.ones((len(used), axes.value, size))
    pointer = np.append(0, np.cumsum(bundle_of_row >= 0))
    shape = axes.size(len(bundle_of_row)), size * n_bundles
    matrix = sparse.bsr_array((blocks, bundle_of_row[used], pointer), shape)
    return PointOperator((sparse.csr_array(matrix),), axes)


def _places(onto, n_each, width):
    """In which joined bundle each bundle stands."""
    blocks = onto.tocsr().matrix.T.tocsr()
    blocks.eliminate_zeros()
    assert (np.diff(blocks.indptr) == 1).all()
    row = blocks.indices[:: onto.axes.size(n_each)]
    return onto.axes.count(row) // width


@pytest.mark.parametrize("axes", list(Axes), ids=lambda axes: axes.name)
def test_bundles_of_the_same_rows_stand_together(axes):
    rows = np.array([0, 0, 1, 1, 1, 2, 2, 2])
    other = np.array([2, 0, 1])[rows]  # the same models in another order
    kinds = [_kind(rows, 3, 3, axes), _kind(other, 3, 2, axes)]
    first, second = joined_bundles(kinds, [3, 2])
    assert first.n_points == second.n_points == 3 * 5
    np.testing.assert_array_equal(_places(first, 3, 5), [0, 1, 2])
    np.testing.assert_array_equal(_places(second, 2, 5), [1, 2, 0])


def test_a_model_that_only_one_kind_has_stands_alone():
    rows = np.array([0, 0, -1, -1, 1, 1])
    other = np.array([0, 0, 1, 1, 2, 2])
    axes = Axes.SPACE
    kinds = [_kind(rows, 2, 3, axes), _kind(other, 3, 2, axes)]
    first, second = joined_bundles(kinds, [3, 2])
    np.testing.assert_array_equal(_places(first, 3, 5), [0, 1])
    np.testing.assert_array_equal(_places(second, 2, 5), [0, 2, 1])


def test_models_with_the_same_points_take_one_place_each():
    axes, both = Axes.PLANE, []
    for n_each in (3, 2):  # two models of each point
        one = _kind(np.array([0, 0, 0]), 1, n_each, axes).matrix
        both.append(PointOperator((sparse.csr_array(sparse.hstack([one, one])),), axes))
    first, second = joined_bundles(both, [3, 2])
    assert sorted(_places(second, 2, 5)) == sorted(_places(first, 3, 5)) == [0, 1]


@pytest.mark.parametrize("n_rows", [8, 9])
def test_bundles_of_other_rows_are_not_joined(n_rows):
    """As what high and low flight were fitted with."""
    axes, rows = Axes.PLANE, np.arange(8) // 2
    other = (np.arange(n_rows) // 3) % 4
    kinds = [_kind(rows, 4, 3, axes), _kind(other, 4, 3, axes)]
    first, second = joined_bundles(kinds, [3, 3])
    assert second is None
    assert first.n_points == 4 * 3
