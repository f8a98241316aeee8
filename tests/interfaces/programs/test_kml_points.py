"""Points of KML: names, altitudes, ExtendedData of both kinds."""

import pytest

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.new_block.looked_at import files_below
from einschalt.interfaces.programs.recognised import read_foreign


@pytest.fixture
def read(tmp_path):
    """Function of placemarks that gives what is read of them."""

    def of(*placemarks):
        text = f"""<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Folder>
{"".join(f"<Placemark>{one}</Placemark>" for one in placemarks)}
</Folder></Document></kml>"""
        (tmp_path / "a.kml").write_text(text, encoding="utf-8")
        return read_foreign(tmp_path / "a.kml")

    return of


def point(place, mode=""):
    """A point with its coordinates as programs indent them."""
    mode = mode and f"<altitudeMode>{mode}</altitudeMode>"
    return f"<Point>{mode}<coordinates>\n\t{place}\n</coordinates></Point>"


def test_altitudes_on_the_ground_are_no_heights(read):
    """Google Earth writes 0 for every point that it lays onto the ground."""
    found = read(f"<name>1</name>{point('16.37,48.2,0')}")
    table = found.tables["control_points"]
    assert table.to_dict("records") == [
        {"point_id": "1", "longitude": 16.37, "latitude": 48.2}
    ]
    assert found.crs == "EPSG:4326"
    found = read(f"<name>1</name>{point('16.37,48.2,412.5', 'absolute')}")
    assert found.tables["control_points"]["height"].tolist() == [412.5]
    assert found.notes == ("a.kml: heights are its altitudes, above sea level (EGM96)",)


def test_data_tell_heights_and_kinds_of_points(read):
    data = '<ExtendedData><Data name="{}"><value>{}</value></Data></ExtendedData>'
    simple = (
        '<ExtendedData><SchemaData schemaUrl="#a"><SimpleData name="Höhe">512.25'
        '</SimpleData><SimpleData name="Punktart">Prüfpunkt</SimpleData></SchemaData>'
        "</ExtendedData>"
    )
    found = read(
        f"<name>P1</name>{data.format('elevation', '411.5')}{point('16.5,48.25,7')}",
        f"<name>P2</name>{simple}{point('16.75,48.5,0', 'absolute')}",
    )
    table = found.tables["control_points"]
    assert table["height"].tolist() == [411.5, 512.25]
    assert table["role"].tolist() == ["control", "check"]
    assert found.notes == ("a.kml: heights are those of its data, not its altitudes",)


def test_points_without_names_are_numbered_and_other_shapes_told(read):
    line = "<LineString><coordinates>1,2 3,4</coordinates></LineString>"
    named = '<ExtendedData><Data name="Pkt.-Nr."><value>7/8</value></Data>'
    found = read(
        point("16.5,48.25"), line, f"{named}</ExtendedData>{point('16.5,48.5')}"
    )
    assert found.tables["control_points"]["point_id"].tolist() == ["1", "7/8"]
    assert found.notes == (
        "a.kml: 1 placemark without a single point left out",
        "a.kml: 1 point without a name, numbered",
    )


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("16.5;48.2", "point P1: '16.5;48.2' is no place"),
        ("16.5,48.2,x", "is no place"),
        ("512345.1,5312345.2,0", "is no longitude and latitude"),
    ],
)
def test_what_is_no_place_is_refused(read, place, said):
    with pytest.raises(EinschaltError, match=said):
        read(f"<name>P1</name>{point(place)}")


def test_a_file_without_points_is_refused(read):
    with pytest.raises(EinschaltError, match="holds no placemark with a point"):
        read("<name>a</name>")


def test_a_map_in_a_folder_is_no_table_of_a_block_unless_it_is_named(tmp_path):
    """Flight plans and results of einschalt are such maps."""
    for name in ("control.csv", "flight_plan.kml"):
        (tmp_path / name).touch()
    assert [path.name for path in files_below(tmp_path)] == ["control.csv"]
