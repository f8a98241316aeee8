"""A control point measured wrong in the high flight: the measurement is named."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings

pytestmark = pytest.mark.slow

MM = 1000.0
KEEP = Settings(outliers="keep")


def measurements_of_control(block):
    """Rows of the high flight on control, and how often each point is measured."""
    points = block.high_flight.model_points.reset_index(drop=True)
    control = block.control_points
    control = control.loc[control["role"] == "control", "point_id"]
    count = points.groupby("point_id")["model_id"].transform("count")
    return points, count.where(points["point_id"].isin(control))


def with_wrong_measurement(block, row, metres=2.0):
    flight = block.high_flight
    points, _ = measurements_of_control(block)
    points.loc[row, "x"] += metres * MM / flight.scale_number
    flight = replace(flight, model_points=points)
    return replace(block, high_flight=flight), points.loc[row, "point_id"]


@pytest.mark.parametrize("is_single", [True, False])
def test_the_measurement_is_named_and_control_not_blamed(demo_block, is_single):
    _, count = measurements_of_control(demo_block)
    is_wanted = (count == 1) if is_single else (count > 1)
    row = np.flatnonzero(is_wanted)[0]
    block, name = with_wrong_measurement(demo_block, row)
    findings = densify(block, KEEP).assessment.findings
    assert findings[0].code == "kept_gross_measurements"
    assert findings[0].names == (name,)
    blamed = [f for f in findings if "control" in f.code and not f.explained_by]
    assert not blamed


def test_wrong_given_coordinates_are_no_wrong_measurement(demo_block):
    points, count = measurements_of_control(demo_block)
    name = points.loc[np.flatnonzero(count == 1)[0], "point_id"]
    control = demo_block.control_points.copy()
    control.loc[control["point_id"] == name, "easting"] += 2.0
    block = replace(demo_block, control_points=control)
    findings = densify(block, KEEP).assessment.findings
    assert "kept_gross_measurements" not in {found.code for found in findings}
    told = next(f for f in findings if f.code == "control_that_contradicts")
    assert told.names[0] == name
