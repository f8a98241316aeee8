"""The precision that a plan expects is the precision that a block then has.

Three of the twelve designs, a few blocks each; all of them with more:
``make truth``, part planning.
"""

from collections import Counter

import numpy as np
import pytest
from tests.truth.long_form.planning import DESIGNS, true_squares

from einschalt.pipeline.planning.estimate.effort import flights_of
from einschalt.pipeline.planning.propagation.expected_precision import expect_precision
from einschalt.theory.planning.expected_precision import expected_parts

SHORT = ["film 1:6000, 200 m", "UltraCam 1:25000, 300 m", "UAV 36 mm 1:24000, 200 m"]
SEEDS = range(1, 7)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHORT)
def test_expected_is_true_within_5_percent(name):
    figures = expect_precision(DESIGNS[name]).figures
    squares = [true_squares(name, seed) for seed in SEEDS]
    mean, edge, centre = np.sqrt(np.mean(squares, axis=0))
    assert figures.mean == pytest.approx(mean, rel=0.05)
    assert figures.single_edge == pytest.approx(edge, rel=0.05)
    assert figures.single_centre == pytest.approx(centre, rel=0.05)
    # the formula of 1971 is not
    assert figures.paper_mean < 0.75 * mean


@pytest.mark.parametrize("name", ["film 1:8000, 300 m", "DMC III 1:20000, 200 m"])
def test_the_closed_estimate_is_near_the_propagation(name):
    design = DESIGNS[name]
    figures = expect_precision(design).figures
    parts = expected_parts(flights_of(design), design.model)
    assert float(parts.mean) == pytest.approx(figures.mean, rel=0.12)
    assert float(parts.edge) == pytest.approx(figures.single_edge, rel=0.12)
    assert float(parts.centre) == pytest.approx(figures.single_centre, rel=0.12)


def test_there_are_twelve_designs_four_of_each_kind_of_camera():
    cameras = {"film": "film", "DMC": "large format", "UltraCam": "large format"}
    kinds = Counter(cameras.get(name.split()[0], "UAV") for name in DESIGNS)
    assert kinds == {"film": 4, "large format": 4, "UAV": 4}
    assert {100, 400} <= {design.spacing for design in DESIGNS.values()}
    # as they are asked for, not thinned
    assert all(d.layout_spacing == d.spacing for d in DESIGNS.values())
