"""An area for a plan as users have it in Python: a table, a polygon, or its corners."""

import numpy as np
import pytest
import shapely

import einschalt as es
from einschalt.foundations.errors import FileError, GeometryError

geopandas = pytest.importorskip("geopandas", reason="geopandas is not installed")

CHOICES = es.PlanChoices(scale_number=(9000, 11000), spacing=(300,), m_g_um=(5,))
CORNERS = np.array([(57e3, 330e3), (64e3, 330e3), (64e3, 336e3), (57e3, 336e3)])
SQUARE = shapely.Polygon(CORNERS)
CRS = "EPSG:31255"


@pytest.mark.slow
def test_a_table_is_planned_as_its_file(tmp_path):
    parts = shapely.box(57e3, 330e3, 60e3, 336e3), shapely.box(60e3, 330e3, 64e3, 336e3)
    table = geopandas.GeoDataFrame(geometry=list(parts), crs=CRS)
    table.to_file(tmp_path / "area.gpkg")
    of_file = es.plan_area(0.06, tmp_path / "area.gpkg", CHOICES)
    for given in (table, table.geometry):
        plan = es.plan_area(0.06, given, CHOICES)
        assert plan.area.crs == of_file.area.crs == CRS
        assert plan.flown.cost == of_file.flown.cost
        assert "2 polygons are one area" in plan.verdict()
    in_degrees = es.plan_area(0.06, table.to_crs(4326), CHOICES, crs=CRS)
    assert in_degrees.area.square_km == pytest.approx(42.0, rel=1e-6)
    nowhere = es.plan_area(0.06, table.set_crs(None, allow_override=True), CHOICES)
    assert nowhere.area.crs is None


@pytest.mark.parametrize("given", [CORNERS, CORNERS.tolist(), SQUARE])
def test_corners_are_a_polygon(given):
    plan = es.plan_area(0.06, given, CHOICES, crs=CRS)
    assert plan.area.shape.equals(SQUARE)
    assert plan.area.crs == CRS


@pytest.mark.parametrize(
    "given",
    [
        *(CORNERS[:2], [1.0, 2.0], [("a", "b")] * 4, np.full((4, 2), np.nan)),
        *(CORNERS + 1j, CORNERS > 1.0),
    ],
)
def test_what_is_no_corners_is_refused(given):
    with pytest.raises(GeometryError, match=r"expected a polygon, .* corners"):
        es.plan_area(0.06, given, CHOICES)


def test_a_table_of_points_is_refused():
    table = geopandas.GeoSeries([shapely.Point(1.0, 2.0)])
    with pytest.raises(FileError, match="GeoSeries: holds a geometry of type Point"):
        es.plan_area(0.06, table, CHOICES)
