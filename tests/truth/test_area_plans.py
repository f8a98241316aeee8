"""The precision of a flight plan over an area is what the flight then has.

Three of the 36 designs; all of them: ``make truth``, part area_plans.
"""

import numpy as np
import pytest
from tests.truth.long_form.area_plans import CAMERAS_OF, DESIGNS, plan_of, true_squares

from einschalt.pipeline.planning.area.recommended import propagate


@pytest.mark.slow
@pytest.mark.parametrize("name", ["film 3", "large format 6", "UAV 3"])
def test_expected_is_true_within_3_percent_and_what_the_simulation_leaves_open(name):
    expected = propagate(plan_of(name)).mean
    squares = true_squares(name, 1, 60)
    error = 0.5 * squares.std() / squares.mean() / np.sqrt(len(squares))
    assert error < 0.02
    true = np.sqrt(squares.mean())
    # 3 % of planning, and three standard errors of this simulation
    assert expected / true == pytest.approx(1.0, abs=0.03 + 3.0 * error)


def test_there_are_twelve_designs_of_each_kind():
    assert len(DESIGNS) == 36
    assert len(CAMERAS_OF) == 3
