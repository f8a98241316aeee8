"""Cores that work side by side change nothing, to the last bit."""

import numpy as np
import pytest

from einschalt.foundations import batches
from einschalt.foundations.sparse_cholesky import (
    front_branches,
    multifrontal,
    nested_dissection,
)
from einschalt.foundations.sparse_cholesky.elimination_pattern import Fronts
from einschalt.foundations.sparse_cholesky.front_branches import part_fronts
from einschalt.theory.block_adjustment import solver
from einschalt.theory.block_adjustment.block_solution import adjust


@pytest.fixture
def cores(monkeypatch):
    """Give so many cores, and branches to blocks that are too small for them."""

    def give(count):
        monkeypatch.setattr(batches, "n_cores", lambda: count)
        monkeypatch.setattr(batches, "ROWS_WORTH_A_THREAD", 0)
        monkeypatch.setattr(nested_dissection, "MODELS_WORTH_A_THREAD", 6)
        monkeypatch.setattr(solver, "MOST_AT_ONCE", 0)
        monkeypatch.setattr(front_branches, "LEAST_WORK", 0.0)
        monkeypatch.setattr(multifrontal, "BYTES_WORTH_BRANCHES", 0)

    return give


def everything(block):
    """All numbers that the solution of a block gives."""
    solution = adjust(block)
    return (
        solution.points,
        solution.residuals,
        solution.point_cofactors,
        solution.adjusted_cofactors,
        solution.parameter_cofactors,
        solution.solver.factor.is_held,
    )


@pytest.mark.parametrize("layout", ["dense grid", "strip", "ring", "two models"])
@pytest.mark.parametrize("kind", ["affine", "helmert", "mixed"])
def test_any_number_of_cores_gives_the_same_bytes(make_block, cores, layout, kind):
    block = make_block(layout, kind)
    cores(1)
    alone = everything(block)
    for count in (2, 3, 8):
        cores(count)
        for one, many in zip(alone, everything(block), strict=True):
            np.testing.assert_array_equal(one, many)


def tree(parent, n_own=4, n_boundary=6):
    """Fronts of one size, children before their parents."""
    n = len(parent)
    return Fronts(
        start=n_own * np.arange(n + 1),
        parent=np.array(parent),
        n_children=np.bincount([p for p in parent if p >= 0], minlength=n),
        boundary_start=n_boundary * np.arange(n + 1),
        boundary=np.zeros(n_boundary * n, dtype=np.int64),
    )


def test_two_cores_get_the_halves_and_the_trunk_the_rest(cores):
    cores(2)
    # two branches of three fronts at a root
    branches = part_fronts(tree([2, 2, 6, 5, 5, 6, -1]), 2)
    assert [part.root for part in branches.branches] == [2, 5]
    assert [part.fronts.tolist() for part in branches.branches] == [
        [0, 1, 2],
        [3, 4, 5],
    ]
    assert branches.trunk.fronts.tolist() == [2, 5, 6]
    assert branches.left_start[[2, 5]].tolist() == [0, 144]
    assert branches.n_left == 2 * (2 * 6) ** 2


def test_a_branch_above_its_share_is_parted_again(cores):
    cores(3)
    # nine fronts: branches of seven and one; the seven of three and three
    branches = part_fronts(tree([2, 2, 6, 5, 5, 6, 8, 8, -1]), 2)
    assert [part.root for part in branches.branches] == [2, 5, 7]
    assert branches.trunk.fronts.tolist() == [2, 5, 6, 7, 8]


def test_parts_that_do_not_hang_together_are_branches(cores):
    cores(2)
    branches = part_fronts(tree([-1, -1, -1, -1]), 2)
    assert sorted(part.root for part in branches.branches) == [0, 1, 2, 3]


def test_one_core_and_little_work_have_no_branches(cores, monkeypatch):
    fronts = tree([2, 2, 6, 5, 5, 6, -1])
    cores(1)
    whole = part_fronts(fronts, 2)
    assert whole.branches == ()
    assert whole.trunk.fronts.tolist() == list(range(7))
    cores(2)
    monkeypatch.setattr(front_branches, "LEAST_WORK", 1e8)
    assert part_fronts(fronts, 2).branches == ()


def test_only_many_right_sides_of_a_large_factor_are_parted(
    make_block, cores, monkeypatch
):
    cores(2)
    factor = adjust(make_block("dense grid", "affine")).solver.factor
    n_branches = []
    monkeypatch.setattr(
        front_branches.Branches, "each", lambda b, _: n_branches.append(len(b.branches))
    )
    worth = 2 * factor.panels.nbytes
    monkeypatch.setattr(multifrontal, "BYTES_WORTH_BRANCHES", worth)
    for n_right in (2, 3):  # each once forward, once backward
        factor.solve(np.ones((*factor.is_held.shape, n_right)))
    assert n_branches[:2] == [0, 0]
    assert min(n_branches[2:]) >= 2


def test_parts_hold_their_updates_and_their_longest_way_only(cores):
    fronts = tree([2, 2, 6, 5, 5, 6, -1])
    own, edge = 2 * 4, 2 * 6
    cores(1)
    trunk = part_fronts(fronts, 2).trunk
    # the update of front 2 waits beside those of fronts 3 and 4
    assert (trunk.stack, trunk.path) == (3 * edge**2, 3 * (own + edge) ** 2)
    cores(2)
    parted = part_fronts(fronts, 2)
    for branch in parted.branches:
        assert (branch.stack, branch.path) == (2 * edge**2, 2 * (own + edge) ** 2)
    assert (parted.trunk.stack, parted.trunk.path) == (2 * edge**2, (own + edge) ** 2)


def test_what_goes_wrong_in_a_branch_is_raised(cores):
    cores(2)

    def fail(_part):
        message = "lost"
        raise ArithmeticError(message)

    with pytest.raises(ArithmeticError, match="lost"):
        part_fronts(tree([2, 2, 6, 5, 5, 6, -1]), 2).each(fail)
