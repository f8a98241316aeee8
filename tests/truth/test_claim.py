"""Wrong claims are called out, right ones are not: the short form.

The long form is 100 blocks of each kind; its figures stand in docs/truth.md.
"""

import pytest
from tests.given_approximations import onto_given_approximations

from einschalt.pipeline.densify import densify

pytestmark = pytest.mark.slow

N_BLOCKS = 4


@pytest.fixture
def rejected(neukirchen):
    """Number of the blocks, changed in some way, whose claim does not stand."""

    def count(change):
        blocks = [change(neukirchen(seed), seed) for seed in range(N_BLOCKS)]
        return sum(not densify(block).claim.is_supported for block in blocks)

    return count


@pytest.mark.parametrize("is_stated", [True, False])
def test_one_orientation_error_for_each_photograph_is_called_out(rejected, is_stated):
    found = rejected(
        lambda block, seed: onto_given_approximations(
            block, photograph_error=0.1, seed=seed, is_stated=is_stated
        )
    )
    assert found == N_BLOCKS


def test_independent_approximations_are_not(rejected):
    # at 0.01 a block two of four have the probability 0.0006
    found = rejected(
        lambda block, seed: onto_given_approximations(block, own_error=0.1, seed=seed)
    )
    assert found <= 1


def test_blocks_of_both_flights_are_not(rejected):
    assert rejected(lambda block, _: block) <= 1
