"""Areas that Python draws: what no flight can be planned over is told in a sentence."""

import re

import numpy as np
import pytest
import shapely

from einschalt.foundations.errors import GeometryError, ProjectionError
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.layout import (
    lay_out,
    require_one_model,
    require_rows,
)
from einschalt.pipeline.planning.estimate.possible_layouts import FEWEST_POINTS
from einschalt.pipeline.planning.estimate.search import PlanFrame
from einschalt.pipeline.planning.flights.arguments import flown_model
from einschalt.pipeline.planning.flights.flight_design import FlightDesign

SQUARE = shapely.box(0.0, 0.0, 5000.0, 4000.0)


@pytest.mark.parametrize(
    ("shape", "found"),
    [
        (None, "the area is None; expected a polygon"),
        ([(0, 0), (1, 1)], "expected a polygon"),
        (shapely.Point(1.0, 2.0), "the area is a Point; expected a polygon"),
        (shapely.Polygon(), "the area is empty; expected a polygon"),
    ],
)
def test_what_is_no_polygon_is_named(shape, found):
    with pytest.raises(GeometryError, match=found):
        FlightArea(shape)


@pytest.mark.parametrize(
    ("outer", "inner", "found"),
    [
        # a bow, whose sides cross in the middle
        (
            [(0, 0), (800, 600), (800, 0), (0, 600)],
            [],
            "crosses or .* at 400.00, 300.00",
        ),
        # a hole that lies elsewhere
        (
            [(0, 0), (800, 0), (800, 600)],
            [[(900, 900), (950, 900), (950, 950)]],
            "the border of the area is faulty at 900.00, 900.00; expected rings",
        ),
    ],
)
def test_a_faulty_border_is_told_with_its_place(outer, inner, found):
    with pytest.raises(GeometryError, match=found):
        FlightArea(shapely.Polygon(outer, inner))


@pytest.mark.parametrize(
    ("crs", "found"),
    [("nonsense", "nonsense"), ("EPSG:4326", "axes in degree")],
)
def test_the_system_of_an_area_is_plane_and_in_metres(crs, found):
    with pytest.raises(ProjectionError, match=found):
        FlightArea(SQUARE, crs)
    assert FlightArea(SQUARE, "EPSG:31255").square_km == 20.0


def test_places_are_spread_evenly_over_an_area():
    hole = shapely.box(1000.0, 1000.0, 2000.0, 2000.0)
    area = FlightArea(shapely.affinity.rotate(SQUARE.difference(hole), 30.0))
    places = area.places(2000)
    assert 1900 < len(places) < 2100
    assert shapely.intersects_xy(area.shape, *places.T).all()
    nearest = shapely.STRtree(shapely.points(places)).query_nearest(
        shapely.points(shapely.get_coordinates(area.shape)), return_distance=True
    )[1]
    assert nearest.max() < 100.0


@pytest.mark.parametrize("side", [300.0, 3000.0])
@pytest.mark.parametrize("turned", [0.0, 20.0, 45.0, -30.0])
@pytest.mark.parametrize("moved", [0.0, 0.1, 1.0 / 3.0, 5_300_000.1])
@pytest.mark.parametrize("factors", [(1.0, 1.0), (1.0 + 1e-9, 1.0), (1.0, 1.0 + 1e-9)])
def test_strips_of_a_square_do_not_hang_on_its_last_digits(
    factors, moved, turned, side
):
    square = shapely.affinity.scale(shapely.box(0.0, 0.0, side, side), *factors)
    square = shapely.affinity.rotate(square, turned)
    area = FlightArea(shapely.affinity.translate(square, moved, moved))
    assert area.azimuth == pytest.approx(90.0 - turned, abs=1e-4)
    assert area.extent == pytest.approx((side, side), abs=1e-4)
    # its local axes are those of the strips, whatever is the longer side
    assert np.abs(area.to_local(area.border)).max() == pytest.approx(side / 2, abs=1e-4)


def test_an_area_tells_where_on_the_earth_it_lies():
    near_linz = shapely.box(4e5, 5.32e6, 4.05e5, 5.325e6)
    said = FlightArea(near_linz, "EPSG:32633").describe()
    assert "about latitude 48.048°, longitude 13.692°" in said
    assert "latitude" not in FlightArea(near_linz).describe()


@pytest.mark.parametrize("width", [299.9999, 300.0, 301.0])
def test_what_a_narrow_area_is_advised_can_be_laid_out(width):
    """A third of 299.9999 m is told as 100 m, and was refused then."""
    area = FlightArea(shapely.box(0.0, 0.0, 22_200.0, width))
    with pytest.raises(GeometryError) as refused:
        require_one_model(area, flown_model(PlanFrame()), 8000.0)
    advised = re.search(
        r"at most (\d+), with points at most (\d+) m", str(refused.value)
    )
    scale_number, spacing = map(float, advised.groups())
    require_one_model(area, flown_model(PlanFrame()), scale_number)
    require_rows(area, spacing)
    with pytest.raises(GeometryError):
        require_rows(area, 1.02 * spacing)


@pytest.mark.parametrize("side", [20.0, 30.0, 60.0])
def test_what_a_tiny_area_is_advised_has_points_enough(side):
    """Of a lattice that is scattered fewer lie in a small area."""
    area = FlightArea(shapely.box(0.0, 0.0, side, side))
    with pytest.raises(GeometryError) as refused:
        require_one_model(area, flown_model(PlanFrame()), 8000.0)
    advised = re.search(
        r"at most (\S+), with points at most (\S+) m", str(refused.value)
    )
    scale_number, spacing = map(float, advised.groups())
    design = FlightDesign(scale_number=scale_number, spacing=spacing, m_g_um=5.0)
    for seed in range(10):
        assert len(lay_out(area, design, seed=seed).position) >= FEWEST_POINTS


def test_several_parts_are_told_by_their_middle():
    parts = [shapely.box(x, 5.3e6, x + 4000.0, 5.304e6) for x in (440e3, 560e3 - 4e3)]
    area = FlightArea(shapely.MultiPolygon(parts), "EPSG:25832")
    assert "longitude 9.000°" in area.describe()
    assert "longitude 8.2" in FlightArea(parts[0], "EPSG:25832").describe()
