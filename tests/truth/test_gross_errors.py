"""Gross errors do no harm once they are looked for: the short form.

The long form has more blocks and all treatments; its figures stand in docs/truth.md.
"""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import poisson

ROOT = Path(__file__).parents[2]
N_BLOCKS = 3
MODE = "most_central"  # a point has one value of each coverage: the harder case


@pytest.fixture(scope="module", params=["high", "low"])
def runs(request):
    """Three blocks with 1 % gross errors of 50 µm in one flight."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT)
        study = import_module("tests.truth.long_form.gross").study
        return [
            study(request.param, seed, modes=(MODE,), ways=("keep", "snoop"))
            for seed in range(N_BLOCKS)
        ]


def loss(runs, way, part):
    """RMS of the final points over that without gross errors."""
    with_errors, without = np.sum([run[MODE, way][part] for run in runs], axis=0)
    return np.sqrt(with_errors / without)


@pytest.mark.slow
def test_points_with_the_redundancy_to_find_them_lose_little(runs):
    everything, checked = 0, 1
    assert loss(runs, "snoop", checked) < 1.05
    # left as they are they do harm
    assert loss(runs, "keep", everything) > 1.05


def test_what_was_missed_lies_below_its_minimal_detectable_bias(runs):
    names = ("gross", "found", "missed", "expected")
    gross, found, missed, expected = (sum(run[name] for run in runs) for name in names)
    assert missed <= poisson.isf(0.001, expected)
    assert found > 0.98 * (found + missed)
    # the others are one of two measurements of a point, or beside another gross error
    assert found + missed > 0.75 * gross
