"""Points of KML: names, altitudes, ExtendedData of both kinds."""

import struct

import numpy as np
import pyogrio.raw
import pytest

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import written_in
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


def data(**texts):
    """ExtendedData of names and texts."""
    pairs = (
        f'<Data name="{name}"><value>{text}</value></Data>'
        for name, text in texts.items()
    )
    return f"<ExtendedData>{''.join(pairs)}</ExtendedData>"


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
    simple = (
        '<ExtendedData><SchemaData schemaUrl="#a"><SimpleData name="Höhe">512.25'
        '</SimpleData><SimpleData name="Punktart">Prüfpunkt</SimpleData></SchemaData>'
        "</ExtendedData>"
    )
    found = read(
        f"<name>P1</name>{data(elevation='411.5')}{point('16.5,48.25,7')}",
        f"<name>P2</name>{simple}{point('16.75,48.5,0', 'absolute')}",
    )
    table = found.tables["control_points"]
    assert table["height"].tolist() == [411.5, 512.25]
    assert table["role"].tolist() == ["control", "check"]
    assert found.notes[-1] == "a.kml: heights are those of its data, not its altitudes"


def test_points_without_names_are_numbered_and_other_shapes_told(read):
    line = "<LineString><coordinates>1,2 3,4</coordinates></LineString>"
    named = '<ExtendedData><Data name="Pkt.-Nr."><value>7/8</value></Data>'
    found = read(
        point("16.5,48.25"), line, f"{named}</ExtendedData>{point('16.5,48.5')}"
    )
    assert found.tables["control_points"]["point_id"].tolist() == ["1", "7/8"]
    assert found.notes == (
        "a.kml: 1 placemark without exactly one point left out",
        "a.kml: 1 point without a name, numbered",
    )


GAUSS_KRUEGER = {"R": "4512345.1", "H": "5312345.2"}


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (GAUSS_KRUEGER, {"point_id": "1"}),  # its H is a Hochwert
        (
            {"id": "5", "Punktnr": "7/8", **GAUSS_KRUEGER, "Hoehe": "512.3"},
            {"point_id": "7/8", "height": 512.3},
        ),
        ({"id": "5", "Höhe [m]": "512.3"}, {"point_id": "5", "height": 512.3}),
        ({"Pkt": "5", "Höhe": "411,5"}, {"point_id": "5", "height": 411.5}),
        ({"Pkt": "5", "Höhe": "1.411,5"}, {"point_id": "5", "height": 1411.5}),
    ],
)
def test_data_have_the_words_of_columns(read, texts, expected):
    """The first of any meaning was taken: northings for heights, an id for a name."""
    found = read(data(**texts) + point("16.5,48.25"))
    place = {"longitude": 16.5, "latitude": 48.25}
    table = found.tables["control_points"].to_dict("records")
    assert table == [{**expected, **place}]


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        ([{"H": "5312345.2"}], "height 5312345.2 of point P0 is none"),
        ([{"height": "411.5 m"}], "height '411.5 m' of point P0 is no number"),
        ([{"height": "nan"}], "height 'nan' of point P0 is no number"),
        ([{"height": "12.5"}, {"height": "13,5"}], "height '13,5' of point P1"),
        (
            [{"height": "1,234"}],
            "a.kml, point P0: height .1,234.: is it 1.234 or.*Write decimal points",
        ),
        ([{"Höhe [m]": "1"}, {"Höhe [mm]": "1"}], "of its data are in m, mm"),
        ([{"role": "tie"}], "role 'tie' of point P0 is unknown"),
        ([{"Art": "Passpunkt"}, {"Art": "Bolzen"}], "role 'Bolzen' of point P1"),
        ([{"Höhe": "1", "Quota": "2"}], "could both be height.*Rename the one"),
    ],
)
def test_data_that_are_not_understood_are_refused(read, texts, said):
    """Heights gave way to altitudes in silence, and tie points became control."""
    with pytest.raises(EinschaltError, match=rf"(?s){said}"):
        read(
            *(
                f"<name>P{k}</name>{data(**one)}{point('16.5,48.25,0', 'absolute')}"
                for k, one in enumerate(texts)
            )
        )


def test_what_data_leave_open_is_told(read):
    found = read(
        f"<name>1</name>{data(height='411.5', Typ='Bolzen')}{point('16.5,48.25')}",
        f"<name>2</name>{data(standard_error_m='0.05')}"
        f"{point('16.5,48.5,400', 'absolute')}",
    )
    table = found.tables["control_points"]
    assert table["height"].isna().tolist() == [False, True]
    assert found.notes == (
        "a.kml: heights are those of its data, not its altitudes",
        "a.kml: without heights, since their data have none: 2",
        "a.kml: kinds not understood, taken for control: Bolzen",
        "a.kml: data of precision not used: standard_error_m",
    )
    # no altitude, no word on altitudes
    found = read(f"<name>1</name>{data(height='411.5')}{point('16.5,48.25,0')}")
    assert found.notes == ()


def test_new_points_of_a_map_are_no_control(read):
    """As our own results call them; they were points of a role that nothing knows."""
    found = read(
        f"<name>1</name>{data(role='new')}{point('16.5,48.25')}",
        f"<name>2</name>{data(role='check', height='5.5')}{point('16.75,48.5')}",
    )
    assert found.tables["control_points"].to_dict("records") == [
        {
            "point_id": "2",
            "longitude": 16.75,
            "latitude": 48.5,
            "height": 5.5,
            "role": "check",
        }
    ]
    assert "1 row of role new left out" in found.notes[0]


def test_a_placemark_of_two_points_is_told(read):
    two = f"<MultiGeometry>{point('1,2')}{point('1,3')}</MultiGeometry>"
    found = read(f"<name>1</name>{two}", f"<name>2</name>{point('1,4')}")
    assert found.tables["control_points"]["point_id"].tolist() == ["2"]
    said = "a.kml: 1 placemark without exactly one point left out"
    assert found.notes == (said,)
    with written_in("de"):
        told = "a.kml: 1 Ortsmarke ohne genau einen Punkt weggelassen"
        assert retold(said) == told


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


@pytest.mark.parametrize(
    ("driver", "options"),
    [("KML", {"AltitudeMode": "absolute"}), ("KML", {}), ("LIBKML", {})],
)
def test_what_gdal_writes_is_read(tmp_path, driver, options):
    """It writes the KML of QGIS, too: data in a SchemaData, names as name."""
    if "w" not in pyogrio.list_drivers().get(driver, ""):
        pytest.skip(f"this GDAL cannot write {driver}")
    places = [(16.5, 48.25, 400.0), (16.75, 48.5, 500.5)]
    wkb = np.array([struct.pack("<BI3d", 1, 1001, *place) for place in places], object)
    texts = [["P 1", "7/8"], ["411,5", "512,25"], ["Passpunkt", "Prüfpunkt"]]
    fields = [np.array(one, dtype=object) for one in texts]
    tables = []
    for n_fields in (1, 3):
        pyogrio.raw.write(
            tmp_path / "a.kml",
            wkb,
            fields[:n_fields],
            ["Name", "Höhe", "Art"][:n_fields],
            geometry_type="Point Z",
            crs="EPSG:4326",
            driver=driver,
            dataset_options=options,
        )
        tables.append(read_foreign(tmp_path / "a.kml").tables["control_points"])
        (tmp_path / "a.kml").unlink()
        assert tables[-1]["point_id"].tolist() == ["P 1", "7/8"]
        found = tables[-1][["longitude", "latitude"]].to_numpy().tolist()
        assert found == [list(place[:2]) for place in places]
    bare, full = tables
    assert full["height"].tolist() == [411.5, 512.25]
    assert full["role"].tolist() == ["control", "check"]
    # without a mode the points lie on the ground
    assert list(bare.get("height", [])) == ([400.0, 500.5] if options else [])
