"""Ground beside an area: photographs are taken over it, and lines must not meet it."""

import numpy as np
import pytest
import shapely

import einschalt as es
from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.planning.area import recommended
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights

AREA = FlightArea(shapely.box(0.0, 0.0, 4000.0, 3000.0))
CHOICES = es.PlanChoices(
    scale_number=(12_000.0,),
    spacing=(400.0,),
    m_g_um=(10.0,),
    high_over_low=(1.5,),
    n_coverages=(2,),
)
FLYING_HEIGHT = 12_000.0 * 1.5 * 0.152  # of the high flight


def beyond(plane):
    """How far places lie beyond the sides of the area [m]."""
    return np.maximum(np.maximum(-plane, plane - [4000.0, 3000.0]), 0.0).max(axis=1)


def ground(height_at, within=4000.0):
    """Heights on a lattice, by the distance from the area."""
    axes = (np.arange(-within, side + within + 1.0, 50.0) for side in (4000.0, 3000.0))
    plane = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    return GroundHeights(plane, height_at(beyond(plane)), "ground.xyz")


def step(rise):
    """400 m in the area, and so much more beyond 550 m from it."""
    return ground(lambda away: 400.0 + rise * (away > 550.0))


def planned(heights, target=0.08):
    found, frame = recommended.search_over(target, AREA, CHOICES, es.PlanFrame())
    return recommended.plan_area(AREA, found, frame, heights=heights.over(AREA))


def test_heights_above_ground_are_those_of_the_file_beside_the_area():
    photographs = planned(ground(lambda away: 400.0 + away)).flown.photographs
    away = beyond(photographs[["easting", "northing"]].to_numpy())
    assert (away > 650.0).any()
    expected = photographs["altitude"] - (400.0 + away)
    np.testing.assert_allclose(photographs["height_above_nadir"], expected, atol=20.0)


def test_control_stands_on_the_ground():
    """Means of the nearest heights were off by 15 m on a slope of 10 %."""
    whole = ground(lambda away: away)
    slope = GroundHeights(whole.plane, 500.0 + whole.plane @ [0.1, 0.02], "slope.xyz")
    plan = planned(slope)
    control = plan.flown.control
    expected = 500.0 + control[["easting", "northing"]].to_numpy() @ [0.1, 0.02]
    np.testing.assert_allclose(control["height"], expected, atol=1e-6)


@pytest.mark.slow
def test_lines_that_come_near_to_the_ground_are_said():
    (said,) = (
        note for note in planned(step(1500.0)).notes if "come as near as" in note
    )
    least = FLYING_HEIGHT - 1500.0
    assert f"of the high flight come as near as {least:.0f} m" in said
    assert f"{FLYING_HEIGHT:.0f} m are planned" in said
    assert not any("come as near" in note for note in planned(step(500.0)).notes)


@pytest.mark.slow
def test_lines_through_the_ground_are_refused():
    with pytest.raises(
        GeometryError, match="lead through ground beside it, 264 m below"
    ):
        planned(step(3000.0))
