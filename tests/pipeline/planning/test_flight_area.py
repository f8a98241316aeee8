"""Areas that Python draws: what no flight can be planned over is told in a sentence."""

import pytest
import shapely

from einschalt.foundations.errors import GeometryError, ProjectionError
from einschalt.pipeline.planning.area.flight_area import FlightArea

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
