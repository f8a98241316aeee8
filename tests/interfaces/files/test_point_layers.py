"""GeoJSON with and without a system: degrees or metres."""

import json

import numpy as np
import pytest

from einschalt.foundations.errors import TableError
from einschalt.foundations.tables import CONTROL_POINTS
from einschalt.interfaces.files.tables_by_suffix import understand_table

METRES, DEGREES = [(999_604.58, 112_344.44), (999_900.0, 112_400.0)], [(7.7, 48.6)] * 2
PLANE, GEOGRAPHIC = ["easting", "northing"], ["longitude", "latitude"]


def read(folder, places, **more):
    features = [
        {
            "type": "Feature",
            "properties": {"name": name},
            "geometry": {"type": "Point", "coordinates": place},
        }
        for name, place in zip("ABC", places, strict=False)
    ]
    text = json.dumps({"type": "FeatureCollection", "features": features, **more})
    (folder / "t.geojson").write_text(text, encoding="utf-8")
    return understand_table(folder / "t.geojson", CONTROL_POINTS)


def named(crs):
    return {"crs": {"type": "name", "properties": {"name": crs}}}


@pytest.mark.parametrize("more", [{}, {"crs": None}])
def test_metres_without_a_system_are_metres_and_told(tmp_path, more):
    table = read(tmp_path, METRES, **more)
    assert table.crs is None
    np.testing.assert_array_equal(table.frame[PLANE], METRES)
    told = "t.geojson: names no system (crs), and its coordinates are no degrees"
    assert table.notes[0].startswith(told)


def test_degrees_without_a_system_are_those_of_the_standard(tmp_path):
    table = read(tmp_path, DEGREES)
    assert table.crs == "OGC:CRS84"
    np.testing.assert_array_equal(table.frame[GEOGRAPHIC], DEGREES)
    assert not [note for note in table.notes if "names no system" in note]


def test_one_wrong_point_makes_no_metres_of_degrees(tmp_path):
    table = read(tmp_path, [*DEGREES, (7.7e6, 48.6)])
    assert table.crs == "OGC:CRS84"


def test_older_files_name_their_system(tmp_path):
    table = read(tmp_path, METRES, **named("urn:ogc:def:crs:EPSG::27561"))
    assert table.crs == "urn:ogc:def:crs:EPSG::27561"
    np.testing.assert_array_equal(table.frame[PLANE], METRES)


def test_metres_that_are_said_to_be_degrees_are_refused(tmp_path):
    said = (
        r"row 1: the layer has longitudes and latitudes \(EPSG:4326\), but x = 999604"
    )
    with pytest.raises(TableError, match=said):
        read(tmp_path, METRES, **named("EPSG:4326"))
