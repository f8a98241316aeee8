"""Ranges of what a planner may ask for."""

import pytest

from einschalt.pipeline.planning.flights.arguments import RANGES
from einschalt.pipeline.simulation.geometry import RANGES as BLOCK_RANGES


@pytest.mark.parametrize(
    ("asked", "laid_out"),
    [
        ("spacing", "point_spacing"),
        ("scale_number", "low_scale_number"),
        ("scale_number", "high_scale_number"),
    ],
)
def test_what_may_be_asked_for_is_what_layouts_take(asked, laid_out):
    ranges = RANGES[asked], BLOCK_RANGES[laid_out]
    assert len({(one.low, one.high) for one in ranges}) == 1
