"""What the two ways do not have in common."""

from types import SimpleNamespace

import pandas as pd
from einschalt.pipeline.assessment.ways import adjustment_of, held_control

POINTS = pd.DataFrame(
    {"point_id": ["A", "B", "n"], "role": ["control", "control", "new"]}
)


def test_two_steps_hold_all_control():
    examined = SimpleNamespace(points=POINTS, simultaneous=None)
    assert adjustment_of(examined) is None
    assert held_control(examined)["point_id"].tolist() == ["A", "B"]


def test_an_adjustment_does_not_hold_what_it_set_aside():
    control = pd.DataFrame({"point_id": ["A", "B"], "is_set_aside": [True, False]})
    adjustment = SimpleNamespace(control=control)
    examined = SimpleNamespace(points=POINTS, simultaneous=adjustment)
    assert adjustment_of(examined) is adjustment
    assert held_control(examined)["point_id"].tolist() == ["B"]
