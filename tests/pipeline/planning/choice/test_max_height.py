"""Cameras of a plan over terrain: none above the limit over the ground below it."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

import einschalt as es
from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.planning.area import recommended, tried_layouts
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.flight_plan import flight_plan, require_overlap
from einschalt.pipeline.planning.area.layout import lay_out
from einschalt.pipeline.planning.choice.rows import design_of
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights

UAV = CAMERAS["uav_full_frame"]
LIMIT = 120.0
FRAME = es.PlanFrame(
    image_format=UAV.image_format,
    principal_distance=UAV.principal_distance,
    forward_overlap=0.8,
    side_overlap=0.6,
    max_height=LIMIT,
)
AREA = FlightArea(shapely.box(0.0, 0.0, 600.0, 400.0))
CHOICES = es.PlanChoices(
    scale_number=(2500.0,),
    spacing=(15.0,),
    m_g_um=(2.0,),
    high_over_low=(110.0 / 0.035 / 2500.0,),  # 110 m above ground
    n_settings=(1,),
    n_coverages=(2,),
    control_per_model=(5,),
)


def valley(east, north):
    return 500.0 + np.minimum(0.8 * np.abs(east - 300.0), 40.0)


def slope(east, north):
    return 500.0 + 0.1 * east


def heights_of(terrain):
    axes = np.arange(-100.0, 701.0, 10.0), np.arange(-100.0, 501.0, 10.0)
    plane = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    return GroundHeights(plane, terrain(*plane.T), "ground.xyz").over(AREA)


def laid_out():
    found, frame = recommended.search_over(0.05, AREA, CHOICES, FRAME)
    plan = found.plans.iloc[0]
    layout = lay_out(
        AREA, tried_layouts.design_over(AREA, design_of(plan, frame), np.inf)
    )
    return layout, plan, frame


@pytest.mark.parametrize("follows", [True, False])
@pytest.mark.parametrize("terrain", [valley, slope])
def test_no_camera_is_above_the_limit(terrain, follows):
    layout, plan, frame = laid_out()
    heights = heights_of(terrain)
    given = (layout, plan, frame, heights)
    photographs = flight_plan(*given, follows=follows).photographs
    inside = photographs[photographs["easting"].between(-90, 690)]
    inside = inside[inside["northing"].between(-90, 490)]
    assert len(inside) > 50
    above = inside["altitude"] - terrain(inside["easting"], inside["northing"])
    assert above.max() <= LIMIT + 1e-6
    np.testing.assert_allclose(inside["height_above_nadir"], above, atol=1e-6)
    np.testing.assert_allclose(
        photographs["altitude"] - photographs["ground"], photographs["flying_height"]
    )
    free = replace(frame, max_height=None)
    unlimited = flight_plan(layout, plan, free, heights, follows=follows).photographs
    if terrain is valley or not follows:  # it is the limit that lowers them
        assert unlimited["height_above_nadir"].max() > LIMIT + 2.0
    else:  # over an even slope what follows it keeps 110 m
        np.testing.assert_allclose(
            photographs["altitude"], unlimited["altitude"], atol=1e-9
        )


def ditches(east, north):
    """Cuts of 30 m, narrower than photographs of the low flight are apart."""
    return 500.0 - 30.0 * (np.abs((east - 5.0) % 60.0 - 30.0) < 4.0) + 0.0 * north


@pytest.mark.parametrize("follows", [True, False])
def test_the_limit_holds_between_photographs_too(follows):
    layout, plan, frame = laid_out()
    axes = np.arange(-100.0, 701.0, 2.0), np.arange(-100.0, 501.0, 10.0)
    plane = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    heights = GroundHeights(plane, ditches(*plane.T), "ground.xyz").over(AREA)
    flown = flight_plan(layout, plan, frame, heights, follows=follows).photographs
    worst = 0.0
    for _, line in flown.groupby("line_id"):
        names = ["easting", "northing", "altitude"]
        place = line[names].to_numpy()
        way = np.arange(0.0, len(line) - 1.0, 0.01)
        east, north, altitude = (
            np.interp(way, np.arange(len(line)), part) for part in place.T
        )
        is_known = (np.abs(east - 300.0) < 390.0) & (np.abs(north - 200.0) < 290.0)
        above = altitude - heights.straight_below(np.column_stack([east, north]))
        worst = max(worst, above[is_known].max(initial=0.0))
    assert worst > LIMIT - 1.0
    # half a metre from what was looked at: the line falls by up to 0.9 m in each metre
    assert worst < LIMIT + 0.5


def test_a_line_that_is_lowered_keeps_one_altitude_and_its_own_scale():
    layout, plan, frame = laid_out()
    flown = flight_plan(layout, plan, frame, heights_of(slope), follows=False)
    high = flown.photographs[flown.photographs["flight"] == "high_flight"]
    assert (high.groupby("line_id")["altitude"].std().dropna() < 1e-6).all()
    lines = flown.flight_lines.set_index("flight").loc["high_flight"]
    lowered = lines["flying_height"] / plan["high_flying_height"]
    assert lowered.max() < 0.95
    np.testing.assert_allclose(lines["gsd"], plan["high_gsd"] * lowered)


def test_what_is_lowered_counts_as_lost_overlap():
    """Over a deep cut the cameras come too near to the ground beside it."""
    layout, plan, frame = laid_out()

    def cut(east, north):
        return 500.0 + np.minimum(5.0 * np.abs(east - 300.0), 100.0)

    heights = heights_of(cut)
    free = replace(frame, max_height=None)
    flown = flight_plan(layout, plan, free, heights, follows=True)
    assert "overlaps left" in require_overlap(flown.photographs, plan, layout, heights)
    flown = flight_plan(layout, plan, frame, heights, follows=True)
    with pytest.raises(GeometryError, match="max-height leaves no room"):
        require_overlap(flown.photographs, plan, layout, heights)


@pytest.mark.slow
def test_photographs_follow_the_ground_where_heights_are_limited(tmp_path):
    choices = replace(CHOICES, spacing=(12.0,))
    file = tmp_path / "ground.xyz"
    east, north = np.meshgrid(np.arange(-100, 701, 10.0), np.arange(-100, 501, 10.0))
    table = np.column_stack([east.ravel(), north.ravel(), slope(east, north).ravel()])
    np.savetxt(file, table, "%.3f")
    found = es.plan_area(0.05, AREA.shape, choices, FRAME, ground_heights=file)
    photographs = found.flown.photographs
    assert photographs["height_above_nadir"].max() <= LIMIT + 1e-6
    high = photographs[photographs["flight"] == "high_flight"]
    assert (high.groupby("line_id")["altitude"].std() > 5.0).all()
    fixed = es.plan_area(
        0.05, AREA.shape, choices, FRAME, ground_heights=file, follows_terrain=False
    )
    assert fixed.flown.photographs["height_above_nadir"].max() <= LIMIT + 1e-6
    assert "none is more than 120 m above the ground" in " ".join(fixed.notes)


def test_heights_in_one_line_are_those_of_the_nearest():
    plane = np.column_stack([np.arange(6) * 10.0, np.arange(6) * 5.0])
    heights = GroundHeights(plane, np.arange(6.0), "line.xyz")
    assert heights.straight_below([[21.0, 9.0]]).tolist() == [2.0]
