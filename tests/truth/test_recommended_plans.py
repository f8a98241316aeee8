"""A plan that is recommended keeps the target on a layout of its own.

A few random requests; 250 of them: ``make truth``, part recommended_plans.
"""

import pytest
from tests.truth.long_form.recommended_plans import (
    WITH_OTHER_POINTS,
    outcome_of,
    outcome_over_area,
)


@pytest.mark.parametrize(
    ("study", "seeds"), [(outcome_of, range(10)), (outcome_over_area, range(3))]
)
def test_no_recommended_plan_fails_on_its_own_layout(study, seeds):
    outcomes = [study(seed) for seed in seeds]
    recommended = [one for one in outcomes if one.what == "recommended"]
    assert len(recommended) >= len(outcomes) / 2
    for one in recommended:
        assert one.own <= 1.0
        assert one.other <= WITH_OTHER_POINTS
        assert not one.is_single  # the search had others
