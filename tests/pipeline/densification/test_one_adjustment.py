"""What one adjustment takes out is listed; control that it sets aside is marked."""

from dataclasses import replace

import pytest

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings

FIVE = 5  # rows from the end: a new point in the middle of a model


@pytest.fixture(scope="module")
def spoilt(demo_block):
    """One control point 50 cm off, and one measurement of the low flight 1.6 m."""
    control = demo_block.control_points.copy()
    row = control.index[control["role"] == "control"][3]
    control.loc[row, "easting"] += 0.5
    low = demo_block.low_flight
    points = low.model_points.reset_index(drop=True).copy()
    new = points.index[~points["point_id"].isin(control["point_id"])][FIVE]
    points.loc[new, "x"] += 0.2
    block = replace(
        demo_block,
        control_points=control,
        low_flight=replace(low, model_points=points),
    )
    return block, control.loc[row, "point_id"], points.loc[new]


def result_of(block, outliers):
    return densify(block, Settings(method="simultaneous", outliers=outliers))


def test_snooping_lists_what_it_took_out(spoilt):
    block, control, row = spoilt
    result = result_of(block, "snoop")
    out = result.gross_measurements
    assert out["point_id"].tolist() == [row["point_id"]]
    assert out["model_id"].tolist() == [row["model_id"]]
    # told once, with the residuals
    codes = [found.code for found in result.assessment.findings]
    assert codes.count("suspect_observations") == 1
    assert "gross_measurements" not in codes
    points = result.points
    assert points.loc[points["is_set_aside"], "point_id"].tolist() == [control]


def test_what_is_kept_is_neither_listed_nor_marked(spoilt):
    result = result_of(spoilt[0], "keep")
    assert result.gross_measurements.empty
    assert "is_set_aside" not in result.points


def test_less_weight_is_not_taken_out(spoilt):
    block, control, _ = spoilt
    result = result_of(block, "huber")
    assert result.gross_measurements.empty
    points = result.points
    assert points.loc[points["is_set_aside"], "point_id"].tolist() == [control]
