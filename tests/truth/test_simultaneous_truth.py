"""The simultaneous adjustment reaches what it claims: the short form.

The long form is a hundred blocks; its figures stand in docs/truth.md.
"""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
N_BLOCKS = 4
CASES = (
    *("affine", "affine, film", "helmert", "helmert, film"),
    "common affinity, film",
)


@pytest.fixture(scope="module")
def runs():
    """Sums over the points of four Neukirchen blocks, by case."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT)
        study = import_module("tests.truth.long_form.simultaneous").study
        blocks = [study(seed, CASES) for seed in range(N_BLOCKS)]
    return {case: np.sum([block[case] for block in blocks], axis=0) for case in CASES}


def rms_cm(sums):
    count, *_, squares = sums
    return 100.0 * np.sqrt(squares / count)


@pytest.mark.slow
def test_affine_models_reach_the_error_of_an_independent_simulation(runs):
    # 2.73 cm; one block scatters by 4 % of it
    assert rms_cm(runs["affine"]) == pytest.approx(2.73, abs=0.2)


def test_affine_models_take_up_a_film_affinity(runs):
    without = rms_cm(runs["affine"])
    assert rms_cm(runs["affine, film"]) == pytest.approx(without, rel=1e-3)


def test_one_common_affinity_takes_it_up_too(runs):
    without = rms_cm(runs["helmert"])
    assert rms_cm(runs["common affinity, film"]) == pytest.approx(without, rel=0.03)
    # left alone it accumulates, to 11.9 cm in the independent simulation
    assert rms_cm(runs["helmert, film"]) == pytest.approx(11.9, abs=1.0)


@pytest.mark.parametrize("case", ["affine", "helmert", "common affinity, film"])
def test_what_is_claimed_is_so(runs, case):
    count, squares, inside, claimed, true = runs[case]
    # the points of a block hang together: one block scatters by 0.1, four by 0.05
    assert squares / count == pytest.approx(1.0, abs=0.16)
    assert inside / count == pytest.approx(0.95, abs=0.04)
    assert np.sqrt(claimed / true) == pytest.approx(1.0, abs=0.08)
