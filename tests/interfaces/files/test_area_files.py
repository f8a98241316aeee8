"""Areas of flight plans, as they may come."""

import json

import numpy as np
import pandas as pd
import pytest
import shapely

from einschalt.foundations.errors import EinschaltError, ProjectionError
from einschalt.interfaces.files.area_files import read_area
from einschalt.interfaces.files.geopackage import write_layers
from einschalt.interfaces.files.map_layers import Layer
from einschalt.interfaces.files.map_shapes import shapes as as_wkb

UTM, LOCAL = "EPSG:32633", "EPSG:31255"
CENTRE = [500_000.0, 5_300_000.0]


def write(path, *geometries, crs=UTM):
    features = [
        {"type": "Feature", "properties": {}, "geometry": one} for one in geometries
    ]
    given = {"type": "FeatureCollection", "features": features}
    if crs is not None:
        given["crs"] = {"type": "name", "properties": {"name": crs}}
    path.write_text(json.dumps(given), "utf-8")
    return path


def box(width, height, east=CENTRE[0], north=CENTRE[1]):
    corners = [(0, 0), (width, 0), (width, height), (0, height), (0, 0)]
    return {
        "type": "Polygon",
        "coordinates": [[[east + x, north + y] for x, y in corners]],
    }


def bow():
    east, north = CENTRE
    ring = [(0, 0), (5000, 5000), (5000, 0), (0, 5000), (0, 0)]
    return {
        "type": "Polygon",
        "coordinates": [[[east + x, north + y] for x, y in ring]],
    }


@pytest.mark.parametrize(
    ("geometries", "says"),
    [
        ([bow()], "crosses or touches itself at .*'Fix geometries'"),
        ([], "no polygon: it is empty"),
        ([None], "no polygon: it is empty"),
        ([{"type": "Polygon", "coordinates": []}], "no polygon: it is empty"),
        ([{"type": "Point", "coordinates": CENTRE}], "holds a geometry of type Point"),
        ([box(900_000, 900_000)], "900 km long"),
        ([box(0.1, 0.1, 13.6, 48.0)], "in kilometres or degrees"),
        ([{"type": "Polygon", "coordinates": [[[0, 0], [1]]]}], "damaged, or none"),
        ([{"type": "Polygon", "coordinates": [[[10**400, 0]]]}], "damaged, or none"),
    ],
)
def test_what_no_flight_covers_is_refused_in_a_sentence(geometries, says, tmp_path):
    with pytest.raises(EinschaltError, match=f"area.geojson: .*{says}"):
        read_area(write(tmp_path / "area.geojson", *geometries))


def test_a_crossing_in_degrees_is_told_with_the_system_of_its_place(tmp_path):
    """The place is that in UTM, of which the file with degrees knows nothing."""
    ring = [(13.6, 48.0), (13.7, 48.1), (13.7, 48.0), (13.6, 48.1), (13.6, 48.0)]
    path = tmp_path / "a.geojson"
    write(path, {"type": "Polygon", "coordinates": [ring]}, crs=None)
    said = r"at 39\d{4}\.\d\d, 53\d+.* \(WGS 84 / UTM zone 33N \(EPSG:32633\)\)"
    with pytest.raises(EinschaltError, match=said):
        read_area(path)


def test_degrees_are_brought_into_utm_or_the_system_of_the_plan(tmp_path):
    path = write(tmp_path / "a.geojson", box(0.1, 0.05, 13.6, 48.0), crs=None)
    area = read_area(path)
    assert area.crs == "EPSG:32633"
    assert "UTM zone 33N" in area.notes[0]
    # a tenth of a degree of longitude, a twentieth of latitude
    assert area.square_km == pytest.approx(7.46 * 5.56, rel=0.01)
    area = read_area(path, crs="EPSG:31255")
    assert area.crs == "EPSG:31255"
    assert "was transformed from" in area.notes[0]
    with pytest.raises(EinschaltError, match="a plane system in metres"):
        read_area(path, crs="EPSG:4326")
    write(path, box(5000, 4000), crs=None)
    for asked in (None, "EPSG:25833"):
        with pytest.raises(EinschaltError, match="a corner is 505000, 5304000"):
            read_area(path, crs=asked)
    with pytest.raises(EinschaltError, match="340° of longitude"):
        read_area(write(path, box(340, 120, -170, -60), crs=None))


def test_several_polygons_are_one_area_and_holes_stay(tmp_path):
    two = [box(3000, 4000), box(2000, 4000, CENTRE[0] + 3000)]
    area = read_area(write(tmp_path / "a.geojson", *two))
    assert area.shape.geom_type == "Polygon"
    assert area.extent == pytest.approx((5000, 4000))
    assert "2 polygons" in area.notes[0]
    ring = box(3000, 3000)["coordinates"][0]
    hole = box(500, 500, CENTRE[0] + 1000, CENTRE[1] + 1000)["coordinates"][0]
    holed = {"type": "Polygon", "coordinates": [ring, hole]}
    area = read_area(write(tmp_path / "a.geojson", holed))
    assert area.square_km == pytest.approx(8.75)
    middle = area.to_local(np.add(CENTRE, [[1250, 1250], [2000, 2500]]))
    assert area.holds(middle).tolist() == [False, True]


def test_a_layer_of_geojson_is_refused(tmp_path):
    path = tmp_path / "area.geojson"
    path.write_text('{"type": "Point", "coordinates": [0.0, 0.0]}', encoding="utf-8")
    with pytest.raises(EinschaltError, match=r"no layers, .*'east'.*--area"):
        read_area(path, layer="east")


def test_layers_of_a_geopackage(tmp_path):
    path = tmp_path / "area.gpkg"
    shape = shapely.box(*CENTRE, CENTRE[0] + 4000, CENTRE[1] + 3000)

    def layer(name):
        one = pd.DataFrame({"name": [name]})
        return Layer(name, one, as_wkb([shape]), "Polygon", "an area")

    write_layers([layer("east"), layer("west")], UTM, path)
    with pytest.raises(EinschaltError, match=r"expected east, west.*--area-layer east"):
        read_area(path)
    assert read_area(path, layer="west").shape.equals(shape)
    write_layers([layer("alone")], None, path)
    area = read_area(path)
    assert area.crs is None
    assert "without KML" in area.notes[0]
    assert read_area(path, crs=UTM).crs == UTM
    with pytest.raises(EinschaltError, match="axes in degree"):
        read_area(path, crs="EPSG:4326")


def test_degrees_without_a_system_are_told_of_the_system_first(tmp_path):
    path = tmp_path / "area.gpkg"
    degrees = as_wkb([shapely.box(13.6, 48.0, 13.7, 48.1)])
    names = pd.DataFrame({"name": ["a"]})
    write_layers([Layer("a", names, degrees, "Polygon", "an area")], None, path)
    with pytest.raises(EinschaltError, match="Export it with its system"):
        read_area(path)
    with pytest.raises(EinschaltError, match="axes in degree"):
        read_area(path, crs="EPSG:4326")


@pytest.mark.parametrize("name", ["a.gpkg", "a.shp", "a.geojson", "a.kmz"])
def test_files_of_other_kinds_are_refused(name, tmp_path):
    (tmp_path / name).write_text("no", "utf-8")
    with pytest.raises(EinschaltError, match=name):
        read_area(tmp_path / name)


def test_systems_that_stretch_the_area_are_no_metres(tmp_path):
    drawn = box(9000, 6000, 1_510_000, 6_100_000)  # on a map of the web, at 48 degrees
    area = read_area(write(tmp_path / "a.geojson", drawn, crs="EPSG:3857"))
    assert area.crs == "EPSG:32633"
    assert "where a metre on the ground is 1.49 m" in area.notes[0]
    assert area.square_km == pytest.approx(54.0 / 1.49**2, rel=0.01)
    degrees = write(tmp_path / "b.geojson", box(0.1, 0.05, 13.6, 48.0), crs=None)
    with pytest.raises(EinschaltError, match=r"on the ground is 1\.49 m"):
        read_area(degrees, crs="EPSG:3857")


@pytest.mark.slow
def test_areas_far_from_where_their_system_is_used_are_asked_about(tmp_path):
    """Exchanged easting and northing, or longitude and latitude."""
    usual = write(tmp_path / "a.geojson", box(5000, 4000, 20_000, 320_000), crs=LOCAL)
    assert read_area(usual).notes == ()
    path = write(tmp_path / "b.geojson", box(4000, 5000, 320_000, 20_000), crs=LOCAL)
    (note,) = read_area(path).notes
    assert "far from where this system is used: are its coordinates exchanged" in note
    path = write(tmp_path / "c.geojson", box(0.05, 0.1, 48.0, 13.6), crs=None)
    with pytest.raises(EinschaltError, match=r"\(longitude comes first\)"):
        read_area(path, crs=LOCAL)


def test_a_file_that_was_cut_off_is_told_with_the_place(tmp_path):
    path = tmp_path / "area.geojson"
    path.write_text('{"type": "Polygon",\n "coordinates": [[[1, 2], [3', "utf-8")
    with pytest.raises(EinschaltError, match="is no JSON from line 2, column 29 on"):
        read_area(path)


@pytest.mark.parametrize(
    ("crs", "corner", "target", "says"),
    [
        # of the datum there is no way that is good enough
        (
            "EPSG:24878",
            (500_000, 8_700_000, 4000),
            "EPSG:32718",
            (
                r"no operation is good enough; PSAD56 to WGS 84 \(\d\): 16 m.* "
                r"expected an accuracy of 5 m, .*Name a plane system with the datum "
                r"of PSAD56"
            ),
        ),
        # nor, without its grid, of this one
        (
            "EPSG:4267",
            (-156.0, 64.0, 0.03),
            "EPSG:26905",
            (
                r"needs us_noaa_\S+\.tif, which is missing.* PROJ looks for it in the "
                r"folders that PROJ_DATA names. Or: Name a plane system"
            ),
        ),
        # these are exchanged
        ("EPSG:24878", (8_700_000, 500_000, 4000), "EPSG:32718", "exchanged"),
        ("EPSG:4326", (48.0, 13.0, 0.03), "EPSG:31255", "exchanged"),
    ],
)
def test_why_an_area_is_not_brought_into_a_system(tmp_path, crs, corner, target, says):
    east, north, side = corner
    path = write(tmp_path / "a.geojson", box(side, side, east, north), crs=crs)
    with pytest.raises(ProjectionError, match=says) as refused:
        read_area(path, crs=target)
    said = str(refused.value)
    assert ("exchanged" in said) == (says == "exchanged")
    assert "--grids" not in said
    assert "crs_accuracy_m" not in said
