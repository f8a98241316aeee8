"""Plans over ground that is not level: it is covered, and its precision is judged."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from einschalt.foundations.errors import GeometryError
from einschalt.pipeline.densify import densify
from einschalt.pipeline.planning.area import on_the_ground, recommended
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.simulated_plan import planned_block
from einschalt.pipeline.planning.estimate.search import PlanChoices, PlanFrame
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights
from einschalt.pipeline.simulation.repetitions import true_errors

LOW = np.array([420_000.0, 330_000.0])
FIELD = shapely.box(*LOW, 426_000.0, 335_000.0)
TURNED = shapely.affinity.rotate(FIELD, 30.0)
NOTCHED = FIELD - shapely.box(423_000.0, 332_500.0, 426_000.0, 335_000.0)
FILM = PlanFrame()
CHOICES = PlanChoices(
    scale_number=(9500,),
    spacing=(250,),
    m_g_um=(10,),
    high_over_low=(1.5,),
    n_settings=(2,),
    n_coverages=(2,),
    control_per_model=(5,),
)
RIM = 0.005


def to_north(plane):
    return 400.0 + 0.25 * (plane - LOW)[:, 1]


def gently(plane):
    """To the east and the north."""
    return 400.0 + 0.05 * (plane - LOW).sum(axis=1)


def ridge(plane):
    return 900.0 - 0.2 * np.abs((plane - LOW)[:, 1] - 5000.0)


def heights_of(terrain, area):
    axes = (np.arange(low - 900.0, low + 7000.0, 100.0) for low in LOW)
    plane = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    return GroundHeights(plane, terrain(plane), "ground.xyz").over(area)


def plan_over(shape, terrain, choices=CHOICES, frame=FILM, **given):
    area = FlightArea(shape)
    found, frame = recommended.search_over(0.06, area, choices, frame)
    heights = heights_of(terrain, area)
    return recommended.plan_area(area, found, frame, heights=heights, **given)


def shown_by(photographs, scale_number, places, ground, frame=FILM):
    """Tell which places pairs of photographs show: by the images, not by models."""
    rim = RIM / 0.23 * frame.image_format
    is_shown = np.zeros(len(places), dtype=bool)
    for _, line in photographs.groupby("line_id"):
        way = np.radians(90.0 - line["azimuth"].iloc[0])
        cos, sin = np.cos(way), np.sin(way)
        cameras = line[["easting", "northing", "altitude"]].to_numpy()
        away = places - cameras[:, None, :2]
        turned = np.stack(
            [
                cos * away[..., 0] + sin * away[..., 1],
                cos * away[..., 1] - sin * away[..., 0],
            ],
            axis=-1,
        )
        depth = cameras[:, 2, None] - ground
        in_image = frame.principal_distance * turned / depth[..., None]
        reach = frame.image_format / 2.0 - rim + 1e-4 * frame.image_format
        is_in = (np.abs(in_image) <= reach).all(axis=-1) & (depth > 0.0)
        is_shown |= (is_in[:-1] & is_in[1:]).any(axis=0)
    return is_shown


@pytest.mark.parametrize("follows", [False, True])
@pytest.mark.parametrize(
    ("terrain", "shape"),
    [
        (to_north, FIELD),
        (gently, FIELD),
        (gently, TURNED),
        (gently, NOTCHED),
        (ridge, FIELD),
        (ridge, NOTCHED),
    ],
)
def test_every_coverage_shows_all_of_the_ground(terrain, shape, follows):
    plan = plan_over(shape, terrain, follows=follows)
    inside = plan.area.places(4000)
    border = shapely.get_coordinates(shapely.segmentize(shape, 50.0))
    places = np.concatenate([inside, border])
    ground, photographs = terrain(places), plan.flown.photographs
    for (flight, _), of_coverage in photographs.groupby(["flight", "coverage"]):
        scale = plan.layout.flights[flight].scale_number
        is_shown = shown_by(of_coverage, scale, places, ground)
        assert is_shown.mean() > 0.998
    assert plan.layout.n_left_out == 0
    said = " ".join(plan.notes)
    assert "every coverage of both flights shows the whole area" in said


def test_level_ground_takes_no_model_more():
    area = FlightArea(FIELD)
    level = plan_over(FIELD, lambda plane: np.full(len(plane), 400.0))
    found, frame = recommended.search_over(0.06, area, CHOICES, FILM)
    plain = recommended.plan_area(area, found, frame)
    assert level.flown.cost == plain.flown.cost
    assert level.checked.reached == pytest.approx(plain.checked.reached, rel=1e-6)
    rising = plan_over(FIELD, gently)
    n_images = [p.flown.effort["amount"].iloc[0] for p in (level, rising)]
    assert n_images[1] > n_images[0]
    assert rising.flown.cost > level.flown.cost


@pytest.mark.parametrize("scale_number", [7500, 8600, 9500])
@pytest.mark.parametrize("rise", [1e-4, 0.002])
def test_strips_move_rather_than_become_more(rise, scale_number):
    """Models flush with the border of an area show no more of it where ground rises."""
    choices = replace(CHOICES, scale_number=(scale_number,))
    given = {"choices": choices, "shape": NOTCHED}
    level = plan_over(terrain=lambda plane: np.full(len(plane), 400.0), **given)
    tilted = plan_over(terrain=lambda plane: 400 + (plane - LOW) @ (rise, 0.0), **given)
    assert tilted.flown.cost == pytest.approx(level.flown.cost, rel=0.01)
    assert tilted.checked.reached == pytest.approx(level.checked.reached, rel=0.01)


def test_ground_that_no_model_shows_is_refused(monkeypatch):
    """Here by not adding any."""
    monkeypatch.setattr(on_the_ground, "MOST_ROUNDS", 0)
    with pytest.raises(GeometryError, match="of the area lie in no model"):
        plan_over(FIELD, to_north)


@pytest.mark.slow
@pytest.mark.parametrize("terrain", [to_north, ridge])
def test_the_precision_is_that_of_the_ground(terrain):
    """Expected and true errors of the flight over it agree."""
    plan = plan_over(FIELD, terrain)
    planned, squares = planned_block(plan), []
    for seed in range(12):
        block = planned.simulated(seed)
        points = densify(block).solution.points
        errors = true_errors(points[points["role"] == "new"], block.truth)
        squares.append((errors**2).sum(axis=1).mean())
    true = np.sqrt(np.mean(squares))
    assert plan.checked.reached / true == pytest.approx(1.0, abs=0.06)
