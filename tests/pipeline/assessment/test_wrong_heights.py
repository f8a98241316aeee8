"""A height measured wrong in one model: found, named, and taken out."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings

pytestmark = pytest.mark.slow

MM = 1000.0


def with_wrong_height(block, name, metres, *, is_control):
    """One height of a flight off by so much, where several models hold the point."""
    flight = getattr(block, name)
    points = flight.model_points.reset_index(drop=True).copy()
    control = block.control_points
    control = control.loc[control["role"] == "control", "point_id"]
    is_wanted = points["point_id"].isin(control) == is_control
    count = points.groupby("point_id")["model_id"].transform("count")
    row = points.index[is_wanted & (count == count[is_wanted].max())][0]
    points.loc[row, "z"] += metres * MM / flight.scale_number
    return (
        replace(block, **{name: replace(flight, model_points=points)}),
        points.loc[row, "point_id"],
    )


def height_error(result):
    new = result.points[result.points["role"] == "new"]
    truth = result.block.truth.set_index("point_id").loc[new["point_id"], "height"]
    return float(np.sqrt(np.mean((new["height"].to_numpy() - truth.to_numpy()) ** 2)))


@pytest.mark.parametrize("flight", ["high_flight", "low_flight"])
@pytest.mark.parametrize("is_control", [True, False])
def test_it_is_taken_out(spatial_block, spatial_result, flight, is_control):
    block, name = with_wrong_height(spatial_block, flight, 5.0, is_control=is_control)
    result = densify(block, Settings(outliers="snoop"))
    assert list(result.gross_measurements["point_id"]) == [name]
    assert result.gross_measurements["residual_height"].abs().iloc[0] > 3.0
    assert height_error(result) < 1.3 * height_error(spatial_result)
    (found,) = (f for f in result.assessment.findings if f.code == "gross_measurements")
    assert found.facts["largest"] > 3.0


@pytest.mark.parametrize("flight", ["high_flight", "low_flight"])
def test_one_that_takes_part_is_named_first(spatial_block, flight):
    block, name = with_wrong_height(spatial_block, flight, 5.0, is_control=True)
    judged = densify(block, Settings(outliers="keep")).assessment
    assert judged.findings[0].code == "kept_gross_measurements"
    assert judged.findings[0].names == (name,)
    assert judged.claim_is_supported is False


def test_coverages_that_differ_in_height_are_told(spatial_block, spatial_result):
    assert not spatial_result.coverages["is_suspect"].any()
    block, name = with_wrong_height(spatial_block, "low_flight", 5.0, is_control=False)
    table = densify(block).coverages.set_index("point_id")
    assert table.loc[name, "is_suspect"].all()
    assert table.loc[name, "difference_height"].abs().min() > 0.5


def test_wrong_given_heights_are_not_blamed_on_the_measurement(spatial_block):
    control = spatial_block.control_points.copy()
    row = control.index[control["role"] == "control"][4]
    control.loc[row, "height"] += 5.0
    block = replace(spatial_block, control_points=control)
    judged = densify(block, Settings(outliers="keep")).assessment
    assert "kept_gross_measurements" not in {f.code for f in judged.findings}
