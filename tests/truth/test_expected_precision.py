"""The precision that a plan expects is the precision that a block then has.

Three of the twelve designs, a few runs each; all of them with 30 runs:
``python -m benchmarks.planned_precision``.
"""

import pytest
from benchmarks.planned_precision import DESIGNS, estimate, simulated_truth

from einschalt.pipeline.expected_precision import expect_precision

SHORT = ["film, 200 m", "UltraCam, 300 m", "UAV 36 mm, 200 m"]
SEEDS = range(1, 7)


@pytest.mark.parametrize("name", SHORT)
def test_expected_is_true_within_5_percent(name):
    design = DESIGNS[name]
    figures = expect_precision(design).figures
    truth = simulated_truth(design, SEEDS)
    assert figures.mean == pytest.approx(truth.mean, rel=0.05)
    assert figures.single_edge == pytest.approx(truth.edge, rel=0.05)
    assert figures.single_centre == pytest.approx(truth.centre, rel=0.05)
    # the formula of 1971 is not
    assert figures.paper_mean < 0.75 * truth.mean


@pytest.mark.parametrize("name", ["film, 300 m, as Neukirchen", "DMC III, 200 m"])
def test_the_closed_estimate_is_near_the_propagation(name):
    figures = expect_precision(DESIGNS[name]).figures
    parts = estimate(DESIGNS[name])
    assert float(parts.mean) == pytest.approx(figures.mean, rel=0.12)
    assert float(parts.edge) == pytest.approx(figures.single_edge, rel=0.12)
    assert float(parts.centre) == pytest.approx(figures.single_centre, rel=0.12)
