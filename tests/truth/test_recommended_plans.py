"""A plan that is recommended keeps the target on a layout of its own.

A few random requests; 250 of them: ``make truth``, part recommended_plans.
"""

import numpy as np
import pytest
from tests.truth.long_form.area_plans import CAMERAS_OF
from tests.truth.long_form.recommended_plans import (
    WITH_OTHER_POINTS,
    Outcome,
    _row,
    outcome_of,
    outcome_over_area,
    random_request,
)

# requests that nearly use up their target, quickly searched, five of them below a limit
# of height: of a search that takes the target for 3 per cent larger three fail, for 5
# per cent four
OF_REQUESTS = (46, 78, 84, 126, 160, 195)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("study", "seeds"), [(outcome_of, OF_REQUESTS), (outcome_over_area, range(3))]
)
def test_no_recommended_plan_fails_on_its_own_layout(study, seeds):
    outcomes = [study(seed) for seed in seeds]
    recommended = [one for one in outcomes if one.what == "recommended"]
    assert len(recommended) >= len(outcomes) / 2
    assert not [one for one in outcomes if one.what == "refused"]
    for one in recommended:
        assert one.other <= WITH_OTHER_POINTS
        assert not one.is_single  # the search had others


@pytest.mark.parametrize(
    ("outcome", "is_out"),
    [
        (Outcome("film", "recommended", 0.99, 1.01), False),
        (Outcome("film", "recommended", 0.99, 1.03), True),
        (Outcome("film", "refused"), True),
        (Outcome("film", "none"), False),
    ],
)
def test_the_long_form_is_judged_by_other_points_and_by_refusals(outcome, is_out):
    cells = _row("film", [Outcome("film", "recommended", 0.99, 1.0), outcome])
    assert any("**out**" in str(cell) for cell in cells) is is_out


def test_where_nothing_is_recommended_there_is_no_largest_error():
    assert _row("UAV", [Outcome("UAV", "none")])[-2:] == ("–", "–")


def test_requests_are_limited_in_height_as_planners_are():
    requests = [random_request(seed) for seed in range(60)]
    limits = {kind: [] for kind in CAMERAS_OF}
    for request in requests:
        limits[request.kind].append(request.frame.max_height)
    assert set(limits.pop("UAV")) == {120.0}
    others = [limit for of_kind in limits.values() for limit in of_kind]
    assert 0.3 < np.mean([limit is not None for limit in others]) < 0.7
    assert {request.frame.kind for request in requests} >= {"rigid"}
    assert {request.judged["by"] for request in requests} == {"expected", "paper"}
    assert len({request.judged["where"] for request in requests}) == 3
