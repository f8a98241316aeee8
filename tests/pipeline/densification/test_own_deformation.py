"""What models are bent by for themselves, beside known points that are wrong."""

from dataclasses import replace

import pytest
from tests.given_approximations import beside_control

from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block


def beside_wrong_control(kind, column, *, is_stated=True):
    """Two of the given points are 3 m off, and take no part in the two steps."""
    geometry = replace(PRESETS["demo"].geometry, transformation=kind)
    axes = ("easting", "northing", *(["height"] if kind == "helmert_3d" else []))
    block = beside_control(simulate_block("demo", seed=5, geometry=geometry), axes)
    if not is_stated:
        block = replace(block, approximate_m_0_m=None)
    control = block.control_points.copy()
    rows = control.index[control["role"] == "control"][[1, 2]]
    control.loc[rows, column] += 3.0
    return block, replace(block, control_points=control)


@pytest.mark.parametrize("is_stated", [True, False])
def test_wrong_control_bends_no_model(is_stated):
    good, wrong = beside_wrong_control("affine", "easting", is_stated=is_stated)
    expected, found = densify(good), densify(wrong)
    assert found.solution.own_deformation is None
    told = found.assessment.credible.value, expected.assessment.credible.value
    assert told[0] == pytest.approx(told[1], rel=1e-6)


def test_wrong_control_heights_bend_no_model():
    _, wrong = beside_wrong_control("helmert_3d", "height")
    own = densify(wrong).solution.own_deformation
    heights = [] if own is None else own.size[[axis == "height" for axis in own.axis]]
    assert max(heights, default=0.0) < 0.02
