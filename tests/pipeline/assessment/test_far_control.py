"""A control point that is 100 m off bends all models around it: it is named itself."""

from dataclasses import replace

import pytest

from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import simulate_block

pytestmark = pytest.mark.slow

FAR = [
    (8307, "1055", (60.0, -80.0)),
    (8311, "1005", (-80.0, 60.0)),
    (8311, "1005", (0.0, 100.0)),
]


@pytest.mark.parametrize(("seed", "name", "shift"), FAR)
@pytest.mark.parametrize(
    ("method", "code"),
    [
        ("two_step", "control_that_contradicts"),
        ("simultaneous", "control_against_block"),
    ],
)
def test_a_far_control_point_is_the_cause(seed, name, shift, method, code):
    """Another target in the low flight, or a neighbour, was named instead."""
    block = simulate_block("demo", seed=seed)
    control = block.control_points.copy()
    row = control.index[control["point_id"] == name][0]
    for axis, metres in zip(("easting", "northing"), shift, strict=True):
        control.loc[row, axis] += metres
    block = replace(block, control_points=control)
    judged = densify(block, block.settings.updated({"method": method})).assessment
    assert judged.causes == (code,)
    (cause,) = [found for found in judged.findings if found.code == code]
    assert cause.names[0] == name
    assert "other_targets" not in {found.code for found in judged.findings}
    others = [found for found in judged.findings if found.code != code]
    grave = [found for found in others if found.gravity is Gravity.GRAVE]
    assert {found.explained_by for found in grave} == {code}
