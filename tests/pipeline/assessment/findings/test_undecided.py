"""Two measurements that contradict each other: excluded both, and that is told."""

from dataclasses import replace

import pytest

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings

MM = 1000.0


def gross_of(block, n_measured, outliers="snoop", code="gross_measurements"):
    """The finding, where one of so many measurements of a new point is 2 m off."""
    flight = block.high_flight
    points = flight.model_points.reset_index(drop=True).copy()
    count = points.groupby("point_id")["model_id"].transform("count")
    is_new = ~points["point_id"].isin(block.control_points["point_id"])
    row = points.index[is_new & (count == n_measured)][0]
    points.loc[row, "x"] += 2.0 * MM / flight.scale_number
    block = replace(block, high_flight=replace(flight, model_points=points))
    result = densify(block, Settings(outliers=outliers))
    found = [f for f in result.assessment.findings if f.code == code]
    return points.loc[row, "point_id"], found[0], " ".join(result.summary().split())


@pytest.mark.slow
def test_of_two_nothing_tells_which(demo_block):
    name, found, summary = gross_of(demo_block, 2)
    assert found.facts["n_observations"] == 2
    assert found.facts["undecided"] == (name,)
    assert f"nothing tells which of them is wrong: {name}." in summary


@pytest.mark.slow
def test_of_two_that_are_kept_nothing_tells_which(demo_block):
    """Both were told to be gross errors."""
    name, found, summary = gross_of(demo_block, 2, "keep", "kept_gross_measurements")
    assert found.facts["n_observations"] == 2
    assert found.facts["undecided"] == (name,)
    assert f"nothing tells which of them is wrong: {name}." in summary


@pytest.mark.slow
@pytest.mark.parametrize("n_measured", [3, 4])
def test_of_several_the_others_tell(demo_block, n_measured):
    name, found, summary = gross_of(demo_block, n_measured)
    assert found.names == (name,)
    assert found.facts["n_undecided"] == 0
    assert "nothing tells which" not in summary
