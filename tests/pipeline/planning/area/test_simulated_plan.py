"""A plan that is tried: its block has what was planned, on the ground that is there."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import shapely

import einschalt as es
from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.layout import FLIGHTS, lay_out
from einschalt.pipeline.planning.area.recommended import plan_area, search_over
from einschalt.pipeline.planning.area.simulated_plan import (
    PlannedBlock,
    another_row,
    camera_of,
    planned_block,
    simulate_plan,
)
from einschalt.pipeline.planning.estimate.search import (
    PlanChoices,
    PlanFrame,
    find_plans,
)
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights

RING = np.array([(0, 0), (7200, 900), (8000, 4200), (3800, 6600), (600, 5000)], float)
CORNER = np.array([500_000.0, 5_300_000.0])
AREA = FlightArea(shapely.Polygon(RING + CORNER), "EPSG:32633")
DESIGN = FlightDesign(
    scale_number=11_000,
    spacing=300,
    m_g_um=5,
    high_scale_number=16_500,
    width=8000,
    height=6600,
)


def heights_of(rise):
    """A plane that rises so much from west to east, at 400 m in the middle."""
    x, y = np.meshgrid(np.arange(-10, 100) * 100.0, np.arange(-10, 90) * 100.0)
    plane = np.column_stack([x.ravel(), y.ravel()]) + CORNER
    middle = AREA.to_ground(np.zeros((1, 2)))[0]
    height = 400.0 + rise * (plane[:, 0] - middle[0])
    return GroundHeights(plane, height, "ground.xyz")


@pytest.fixture(scope="module")
def planned():
    return PlannedBlock(DESIGN, 0.05, AREA)


def test_points_and_models_are_those_of_the_layout(planned):
    layout, flown = lay_out(AREA, DESIGN), planned.flown
    middle = AREA.to_ground(np.zeros((1, 2)))
    np.testing.assert_allclose(
        flown.position + middle, AREA.to_ground(layout.position), atol=1e-6
    )
    np.testing.assert_array_equal(flown.is_control, layout.is_control)
    for flight in FLIGHTS:
        wanted, found = layout.oriented(flight), flown.flights[flight]
        np.testing.assert_array_equal(found.model, wanted.model)
        np.testing.assert_array_equal(found.point, wanted.point)


def test_models_lie_along_the_strips_of_the_plan(planned):
    block = planned.simulated()
    low = block.low_flight.model_points
    fit = es.transform_models(low, block.truth, kind="helmert").parameters
    turned = np.arctan2(fit["b"], fit["a"])
    # as every machine is turned a little, by 3 degrees at most
    assert np.abs(turned - AREA.direction).max() < 0.06


def test_thinned_layouts_get_their_points_back_and_keep_control():
    thin = PlannedBlock(replace(DESIGN, spacing=120, most_work=1e5), 0.05, AREA)
    layout, flown = lay_out(AREA, thin.design), thin.flown
    assert layout.geometry.point_spacing > 1.5 * 120
    expected = AREA.shape.area / 120**2
    assert len(flown.position) == pytest.approx(expected, rel=0.05)
    middle = AREA.to_ground(np.zeros((1, 2)))
    control = AREA.to_ground(layout.position[layout.is_control])
    np.testing.assert_allclose(flown.position[flown.is_control] + middle, control)
    names = flown.point_id[flown.is_control]
    assert list(names) == [f"C{k + 1}" for k in range(len(control))]
    assert len(set(flown.point_id)) == len(flown.point_id)
    for flight in FLIGHTS:
        # of at least as many models as were laid out, none of another place
        places = {tuple(one) for one in np.round(layout.flights[flight].centre, 3)}
        assert flown.flights[flight].n_models >= layout.oriented(flight).n_models
        assert flown.flights[flight].n_models <= len(places)


def test_on_level_ground_all_is_as_without_heights(planned):
    on_ground = replace(planned, heights=heights_of(0.0))
    level, flat = on_ground.simulated(3), planned.simulated(3)
    pd.testing.assert_frame_equal(level.truth, flat.truth)
    for flight in FLIGHTS:
        one, other = (getattr(b, flight).model_points for b in (level, flat))
        names = ["coverage", "model_id", "point_id"]
        pd.testing.assert_frame_equal(one[names], other[names])
        np.testing.assert_allclose(one[["x", "y"]], other[["x", "y"]], atol=1e-9)


def test_high_ground_shows_less_of_it_with_smaller_errors(planned):
    on_slope = replace(planned, heights=heights_of(0.04))
    flat, slope = planned.flown.flights["low_flight"], on_slope.flown
    low = slope.flights["low_flight"]
    middle = np.median(slope.position[:, 0])
    on_high = {
        name: np.mean(slope.position[one.point, 0] > middle)
        for name, one in (("flat", flat), ("slope", low))
    }
    assert on_high["slope"] < on_high["flat"]
    # film keeps the altitude of a line: each model is as far above the ground as it is
    scene = on_slope.simulated(3)
    level = planned.simulated(3)
    truth = {b: b.truth.set_index("point_id") for b in (scene, level)}
    errors = []
    for block in (scene, level):
        points = block.low_flight.model_points
        fit = es.transform_models(points, block.truth, kind="affine")
        size = fit.residuals[["residual_easting", "residual_northing"]]
        east = truth[block].loc[fit.residuals["point_id"], "easting"].to_numpy()
        errors.append((east, (size**2).sum(axis=1).to_numpy()))
    ratios = []
    for side in (0.15, 0.85):
        (east, square), (_, plain) = errors
        limit = np.quantile(east, side)
        is_in = east < limit if side < 0.5 else east > limit
        flat_in = errors[1][0] < limit if side < 0.5 else errors[1][0] > limit
        ratios.append(np.sqrt(square[is_in].mean() / plain[flat_in].mean()))
    # some 100 m below and above cameras at 1670 m
    assert ratios[0] > 1.03
    assert ratios[1] < 0.97


def test_cameras_stand_at_their_altitudes(planned):
    on_slope = replace(planned, heights=heights_of(0.03), follows=True)
    low = on_slope.flown.flights["low_flight"]
    geometry = on_slope.flown.geometry
    above = low.camera_altitude(geometry) - on_slope.flown.terrain.height(low.centre)
    is_inside = AREA.holds(lay_out(AREA, DESIGN).oriented("low_flight").centre)
    assert above[is_inside] == pytest.approx(0.152 * 11_000, abs=25.0)
    images = on_slope.simulated(1, measurement="images", transformation="helmert_3d")
    assert {"height"} <= set(images.truth)
    oriented = es.relative_orientation(images.low_flight).model_points
    fit = es.transform_models(oriented, images.truth, kind="helmert_3d")
    # 5 µm at 1:11000, in height by the ratio of height and base
    assert 0.05 < fit.models["m_0"].median() < 0.20
    heights = images.truth["height"]
    assert np.ptp(heights) == pytest.approx(0.03 * np.ptp(RING[:, 0]), rel=0.1)


@pytest.mark.slow
def test_the_row_of_a_plan_has_its_control_where_points_are_thinned():
    """Laid out anew with all points, it had other control than the plan tells."""
    camera = CAMERAS["uav_one_inch"]
    frame = PlanFrame(
        image_format=camera.image_format,
        principal_distance=camera.principal_distance,
        forward_overlap=camera.forward_overlap,
        side_overlap=camera.side_overlap,
    )
    choices = PlanChoices(scale_number=(10_000,), spacing=(10,), m_g_um=camera.m_g_um)
    area = FlightArea(shapely.box(*CORNER, *(CORNER + 600.0)))
    found, frame = search_over(0.05, area, choices, frame)
    plan = plan_area(area, found, frame)
    planned = planned_block(plan)
    assert planned.design.layout_spacing > 1.2 * planned.design.spacing
    again = another_row(planned, plan.checked.plan, frame)
    assert again.expected == pytest.approx(planned.expected, rel=1e-12)
    one, other = (
        flown.position[flown.is_control] for flown in (planned.flown, again.flown)
    )
    np.testing.assert_array_equal(one, other)


def test_all_kinds_of_plans_are_simulated():
    expected = es.expect_precision(replace(DESIGN, width=4000, height=4000))
    choices = PlanChoices(scale_number=(8000,), spacing=(300,), m_g_um=(5,))
    found = find_plans(0.05, choices)
    blocks = [simulate_plan(plan) for plan in (expected.design, expected)]
    pd.testing.assert_frame_equal(blocks[0].truth, blocks[1].truth)
    of_row = simulate_plan(found.nearest, frame=PlanFrame(), title="Row")
    assert of_row.name == "Row"
    assert of_row.low_flight.scale_number == 8000
    assert planned_block(expected).expected == expected.figures.mean
    with pytest.raises(SettingsError, match="frame=frame"):
        simulate_plan(found.nearest)
    with pytest.raises(SettingsError, match="plan is"):
        simulate_plan("plan.json")
    with pytest.raises(SettingsError, match="width cannot be changed in a plan"):
        simulate_plan(expected, width=9000)


ROW = {
    "scale_number": 8000.0,
    "high_scale_number": 15_000.0,
    "spacing": 300.0,
    "n_coverages": 2,
    "control_per_model": 5,
    "m_g_um": 5.0,
    "n_settings": 1,
}


@pytest.mark.parametrize(
    ("plan", "given", "says"),
    [
        (DESIGN, {"noise": 3}, "noise = 3; expected a BlockNoise"),
        (DESIGN, {"frame": PlanFrame()}, "frame beside a plan that is a FlightDesign"),
        (ROW, {"frame": {}}, "frame = a dict of length 0; expected a PlanFrame"),
        ({"spacing": 3}, {}, "a row without scale_number, high_scale_number, n_cov"),
        ({**ROW, "spacing": "x"}, {}, "spacing = 'x'; expected a number"),
        ({**ROW, "n_coverages": None}, {}, "n_coverages = None; expected a number"),
        ({**ROW, "n_coverages": 2.6}, {}, "n_coverages = 2.6; expected a whole number"),
        ("plan.json", {"frame": PlanFrame()}, "plan is 'plan.json'; expected a Flight"),
    ],
)
def test_what_cannot_be_simulated_is_named(plan, given, says):
    if isinstance(plan, dict):
        plan, given = pd.Series(plan, dtype=object), {"frame": PlanFrame()} | given
    with pytest.raises(SettingsError) as caught:
        simulate_plan(plan, **given)
    assert says in str(caught.value)


def test_check_points_and_other_errors(planned):
    noise = es.BlockNoise(control_standard_error=0.1, low_m_g_um=20)
    block = planned.simulated(noise=noise, n_check=12)
    roles = block.control_points["role"].value_counts()
    assert roles["check"] == 12
    assert (block.control_points["standard_error_m"] == 0.1).all()
    assert block.low_flight.m_g_um == 20


@pytest.mark.parametrize("name", CAMERAS)
def test_cameras_are_known_by_their_images(name):
    camera = CAMERAS[name]
    design = FlightDesign(
        scale_number=camera.scale_numbers[1],
        spacing=camera.spacings[0],
        m_g_um=camera.m_g_um[0],
        image_format=camera.image_format,
        principal_distance=camera.principal_distance,
        forward_overlap=camera.forward_overlap,
        side_overlap=camera.side_overlap,
    )
    assert camera_of(design.geometry()) == name
    assert PlannedBlock(design, 0.05).title.startswith(f"{name}, 1:")


def test_a_camera_of_one_s_own_has_no_name():
    design = replace(DESIGN, principal_distance=0.2, width=8000, height=8000)
    assert PlannedBlock(design, 0.05, name="north").title == (
        "north, 1:11000 and 1:16500, 300 m (simulated)"
    )


def test_presets_of_one_camera_are_told_apart_by_their_overlaps(monkeypatch):
    """It was the first of them, whatever its overlaps."""
    usual = CAMERAS["uav_one_inch"]
    monkeypatch.setitem(CAMERAS, "uav_denser", replace(usual, side_overlap=0.7))

    def name_with(side_overlap):
        design = FlightDesign(
            scale_number=10_000,
            spacing=10,
            m_g_um=1,
            image_format=usual.image_format,
            principal_distance=usual.principal_distance,
            forward_overlap=usual.forward_overlap,
            side_overlap=side_overlap,
        )
        return camera_of(design.geometry())

    assert name_with(0.6) == "uav_one_inch"
    assert name_with(0.7) == "uav_denser"
    assert name_with(0.5) == ""  # either may be meant
    monkeypatch.delitem(CAMERAS, "uav_denser")
    assert name_with(0.5) == "uav_one_inch"  # no other camera has such images
