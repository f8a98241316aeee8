"""``einschalt convert``."""

import json
import re
import tomllib
from xml.sax.saxutils import escape

import pandas as pd
import pyproj
import pytest
import xlsxwriter
from fuzz.foreign_files import VRT
from tests.interfaces.files.test_marker_files import XML

from einschalt.foundations.errors import OutputError
from einschalt.interfaces.cli.work import convert

ONE_MORE = (
    '<marker id="22" label="P3"><reference x="13.7" y="48.2" z="4" enabled="true"/>'
    "</marker>"
)
TABLE = "Punktnr;Rechtswert;Hochwert;Art\n0012;13000,25;322000,5;Passpunkt\n"


def test_markers_become_tables_and_nothing_is_written_over(invoke, tmp_path):
    (tmp_path / "m.xml").write_text(XML, encoding="utf-8")
    shown = invoke("convert", tmp_path / "m.xml", tmp_path / "out")
    assert shown.exit_code == 0, shown.output
    assert "2 points, 3 measurements in 2 images of m.xml" in shown.stdout
    assert '[control_points] crs = "EPSG:4326"' in shown.stdout
    assert len(pd.read_csv(tmp_path / "out" / "image_points.csv")) == 3
    again = invoke("convert", tmp_path / "m.xml", tmp_path / "out")
    assert again.exit_code == 2
    assert "control_points.csv: is there already" in again.stderr
    listed = invoke("convert", tmp_path / "m.xml", tmp_path / "gcp_list.txt")
    assert listed.exit_code == 0
    lines = (tmp_path / "gcp_list.txt").read_text(encoding="utf-8").splitlines()
    assert lines[1:] == [
        "13.5 48.25 411.5 1.5 2.25 A.JPG P1",
        "13.6 48.26 412 3 4 B.JPG CHK-P2",
    ]
    assert "2 points, 2 measurements in 2 images in" in listed.stdout
    assert "m.xml: 1 point without coordinates, left out: tie" in listed.stderr


def test_a_list_of_no_point_is_refused(invoke, tmp_path):
    text = re.sub("<reference x=[^>]*/>", "", XML)
    (tmp_path / "m.xml").write_text(text, encoding="utf-8")
    listed = invoke("convert", tmp_path / "m.xml", tmp_path / "gcp_list.txt")
    assert listed.exit_code == 2
    assert "no point has coordinates and was measured" in listed.stderr
    assert not (tmp_path / "gcp_list.txt").exists()


def test_points_without_a_measurement_are_told_of_a_list(invoke, tmp_path):
    text = XML.replace('<marker id="22" label="tie"/>', ONE_MORE)
    text = re.sub('<marker marker_id="22">.*?</marker>', "", text, flags=re.DOTALL)
    (tmp_path / "m.xml").write_text(text, encoding="utf-8")
    listed = invoke("convert", tmp_path / "m.xml", tmp_path / "gcp_list.txt")
    assert listed.exit_code == 0, listed.output
    assert "2 points, 2 measurements in 2 images in" in listed.stdout
    assert "m.xml: 1 point measured in no image, left out: P3" in listed.stderr


def in_system(text, crs):
    """Markers in the system of a WKT, as Metashape writes it."""
    wkt = pyproj.CRS(crs).to_wkt("WKT1_GDAL")
    return text.replace(">EPSG:4326<", f">{escape(wkt)}<")


def test_a_system_with_heights_is_named_by_the_codes_of_both(invoke, tmp_path):
    given = tmp_path / "m.xml"
    given.write_text(in_system(XML, "EPSG:25830+5782"), encoding="utf-8")
    shown = invoke("convert", given, tmp_path / "out")
    assert '[control_points] crs = "EPSG:25830+5782"  # ETRS89' in shown.stdout
    listed = invoke("convert", given, tmp_path / "gcp_list.txt")
    assert listed.exit_code == 0
    # OpenDroneMap reads a number behind EPSG
    assert (tmp_path / "gcp_list.txt").read_text().startswith("EPSG:25830\n")


def test_the_line_for_block_toml_is_toml_for_a_system_without_code(invoke, tmp_path):
    own = "+proj=lcc +lat_1=47 +lat_2=48 +lat_0=47.25 +lon_0=13 +ellps=GRS80"
    given = tmp_path / "m.xml"
    given.write_text(in_system(XML, own), encoding="utf-8")
    shown = invoke("convert", given, tmp_path / "out")
    line = re.search(r"\[control_points\] (crs = .*)", shown.stdout)[1]
    assert pyproj.CRS(tomllib.loads(line)["crs"]).is_projected


def test_markers_beside_a_calibration_become_a_list(invoke, tmp_path):
    sensor = (
        '<sensors><sensor id="0" label="FC"><resolution width="4000" height="3000"/>'
        "<calibration><f>3600</f></calibration></sensor></sensors><cameras>"
    )
    given = tmp_path / "m.xml"
    given.write_text(XML.replace("<cameras>", sensor, 1), encoding="utf-8")
    listed = invoke("convert", given, tmp_path / "list.txt")
    assert listed.exit_code == 0, listed.output
    assert len((tmp_path / "list.txt").read_text().splitlines()) == 3
    both = invoke("convert", given, tmp_path / "out")
    assert both.exit_code == 0, both.output
    assert (tmp_path / "out" / "camera.toml").is_file()


def test_a_table_becomes_a_plain_one(invoke, tmp_path):
    (tmp_path / "t.csv").write_text(TABLE, encoding="utf-8")
    shown = invoke("convert", tmp_path / "t.csv", tmp_path / "plain.csv")
    assert shown.exit_code == 0, shown.output
    assert "'Rechtswert' = easting" in shown.stderr
    assert (tmp_path / "plain.csv").read_text(encoding="utf-8") == (
        "point_id,easting,northing,role\n0012,13000.25,322000.5,control\n"
    )
    wrong = invoke("convert", tmp_path / "t.csv", tmp_path / "plain.dxf")
    assert wrong.exit_code == 2


def test_commas_of_two_meanings_are_asked_about_by_an_option(invoke, tmp_path):
    given = tmp_path / "t.csv"
    given.write_text("Punktnr;Rechtswert;Hochwert\nA;1,234;5,678\n", encoding="utf-8")
    asked = invoke("convert", given, tmp_path / "plain.csv")
    assert asked.exit_code == 2
    assert "--decimal ," in asked.stderr
    assert "block.toml" not in asked.stderr
    told = invoke("convert", given, tmp_path / "plain.csv", "--decimal", ",")
    assert told.exit_code == 0, told.output


def test_a_list_without_system_or_heights_is_refused(invoke, tmp_path):
    plain = re.sub(r"<reference>.*?</reference>", "", XML, flags=re.DOTALL)
    given, to = tmp_path / "m.xml", tmp_path / "gcp_list.txt"
    given.write_text(plain, encoding="utf-8")
    unknown = invoke("convert", given, to)
    assert unknown.exit_code == 2
    assert "system of the points is unknown" in unknown.stderr
    assert "--crs" in unknown.stderr
    said = invoke("convert", given, to, "--crs", "EPSG:4258")
    assert said.exit_code == 0, said.output
    assert to.read_text(encoding="utf-8").startswith("EPSG:4258\n")
    given.write_text(XML.replace(' z="412"', ""), encoding="utf-8")
    flat = invoke("convert", given, tmp_path / "gcp_list_2.txt")
    assert flat.exit_code == 2
    assert "1 point without height: P2" in flat.stderr
    other = invoke("convert", given, tmp_path / "new", "--crs", "EPSG:31255")
    assert other.exit_code == 2
    assert "is in WGS 84 (EPSG:4326), not in MGI / Austria" in other.stderr
    assert not (tmp_path / "gcp_list_2.txt").exists()


def test_a_layer_keeps_its_system_and_says_what_it_loses(invoke, tmp_path):
    point = {"type": "Point", "coordinates": [13.5, 48.25]}
    one = {"geometry": point, "properties": {"Punktnr": "7", "Farbe": "rot"}}
    text = json.dumps({"type": "FeatureCollection", "features": [one]})
    (tmp_path / "t.geojson").write_text(text, encoding="utf-8")
    shown = invoke("convert", tmp_path / "t.geojson", tmp_path / "plain.csv")
    assert shown.exit_code == 0, shown.output
    assert 'crs = "OGC:CRS84"' in shown.stdout
    assert "left out Farbe" in shown.stderr
    text = text.replace("48.25", "NaN")
    (tmp_path / "t.geojson").write_text(text, encoding="utf-8")
    bad = invoke("convert", tmp_path / "t.geojson", tmp_path / "bad.csv")
    assert bad.exit_code == 2
    assert not (tmp_path / "bad.csv").exists()


def test_points_of_landxml_are_in_the_unit_of_the_system_that_is_said(invoke, tmp_path):
    (tmp_path / "a.xml").write_text(
        '<LandXML><Units><Imperial linearUnit="USSurveyFoot"/></Units><CgPoints>'
        '<CgPoint name="A">212522.519 989791.457 10</CgPoint></CgPoints></LandXML>'
    )
    said = ("--crs", "EPSG:2263")
    shown = invoke("convert", tmp_path / "a.xml", tmp_path / "o", *said)
    assert shown.exit_code == 0, shown.output
    rows = (tmp_path / "o" / "control_points.csv").read_text().splitlines()
    assert rows[1].startswith("A,989791.457,212522.519,3.048")
    assert "height converted from USSurveyFoot to metres" in shown.stderr
    assert 'crs = "EPSG:2263"' in shown.stdout


LAND = """<LandXML><CgPoints>
<CgPoint name="A">322000.5 13000.25 411</CgPoint>
<CgPoint name="B">322100.5 13000.25 -9999</CgPoint>
<CgPoint name="A">322000.5 13100.25 412</CgPoint>
</CgPoints></LandXML>"""


def test_what_check_would_refuse_is_told_of_tables_that_are_written(invoke, tmp_path):
    (tmp_path / "a.xml").write_text(LAND)
    shown = invoke("convert", "--json", tmp_path / "a.xml", tmp_path / "o")
    assert shown.exit_code == 0, shown.output
    assert (tmp_path / "o" / "control_points.csv").exists()
    assert "problem: control_points.csv, row 4, point A: " in shown.stderr
    problems = json.loads(shown.stdout)["problems"]
    assert [one["row"] for one in problems] == [4]
    (tmp_path / "a.xml").write_text(
        LAND.replace('name="A">322000.5 131', 'name="C">7 131')
    )
    shown = invoke("convert", tmp_path / "a.xml", tmp_path / "p")
    assert "row 3, point B: height = -9999, as programs write" in shown.stderr


def test_markers_without_a_name_are_told(invoke, tmp_path):
    text = XML.replace('label="P2"', 'label=" "')
    (tmp_path / "m.xml").write_text(text, encoding="utf-8")
    shown = invoke("convert", tmp_path / "m.xml", tmp_path / "o")
    assert shown.exit_code == 0, shown.output
    for name in ("control_points.csv, row 3", "image_points.csv, row 3"):
        assert f"problem: {name}" in shown.stderr
    assert "point_id is missing" in shown.stderr
    listed = invoke("convert", tmp_path / "m.xml", tmp_path / "gcp_list.txt")
    assert listed.exit_code == 2
    assert "m.xml: point_id is missing" in listed.stderr
    assert not (tmp_path / "gcp_list.txt").exists()


def test_latitudes_beyond_the_pole_are_told(invoke, tmp_path):
    (tmp_path / "m.xml").write_text(XML.replace('y="48.25"', 'y="98.25"'))
    shown = invoke("convert", tmp_path / "m.xml", tmp_path / "o")
    assert shown.exit_code == 0, shown.output
    said = "control_points.csv, row 2, point P1: latitude = 98.25; expected -90 to 90"
    assert f"problem: {said}" in shown.stderr


def test_a_table_with_heights_of_none_is_refused(invoke, tmp_path):
    (tmp_path / "t.csv").write_text(
        TABLE.replace("Art", "H").replace("Passpunkt", "-9999")
    )
    shown = invoke("convert", tmp_path / "t.csv", tmp_path / "u.csv")
    assert shown.exit_code == 2
    assert "t.csv, row 2, point 0012: height = -9999" in shown.stderr
    assert not (tmp_path / "u.csv").exists()


def test_a_convert_that_fails_half_way_can_be_repeated(invoke, tmp_path, monkeypatch):
    (tmp_path / "m.xml").write_text(XML, encoding="utf-8")
    written = []

    def write(frame, path):
        if written:
            raise OutputError("no space left", file=path)
        written.append(path)
        path.write_text("half")

    with monkeypatch.context() as patched:
        patched.setattr(convert, "write_csv", write)
        failed = invoke("convert", tmp_path / "m.xml", tmp_path / "o", "--json")
    assert failed.exit_code == 2
    assert json.loads(failed.stdout)["paths"] == []
    assert written == [tmp_path / "o" / "control_points.csv"]
    assert not list((tmp_path / "o").iterdir())
    again = invoke("convert", tmp_path / "m.xml", tmp_path / "o")
    assert again.exit_code == 0, again.output


def test_tables_of_a_program_that_fail_half_way_are_removed(
    invoke, tmp_path, monkeypatch
):
    (tmp_path / "a.vrt").write_text(VRT)

    def write(frame, path):
        if path.name == "image_points.csv":
            raise OutputError("no space left", file=path)
        path.write_text("half")

    monkeypatch.setattr(convert, "write_csv", write)
    failed = invoke("convert", tmp_path / "a.vrt", tmp_path / "o")
    assert "no space left" in failed.stderr
    assert not list((tmp_path / "o").iterdir())


def test_the_folder_of_a_list_is_made_as_that_of_a_table_is(invoke, tmp_path):
    (tmp_path / "m.xml").write_text(XML, encoding="utf-8")
    listed = invoke("convert", tmp_path / "m.xml", tmp_path / "new" / "gcp_list.txt")
    assert listed.exit_code == 0, listed.output
    assert (tmp_path / "new" / "gcp_list.txt").exists()


def test_the_unit_of_a_header_is_not_lost(invoke, tmp_path):
    models = "model_id,point_id,x [µm],y [µm],z [µm]\n7,A,1000,-2500,3\n"
    (tmp_path / "m.csv").write_text(models, encoding="utf-8")
    shown = invoke("convert", tmp_path / "m.csv", tmp_path / "out.csv")
    assert "m.csv: converted from um to mm" in shown.stderr
    frame = pd.read_csv(tmp_path / "out.csv")
    assert frame[["x", "y", "z"]].to_numpy().tolist() == [[1.0, -2.5, 0.003]]
    images = "image_id,point_id,x [px],y [px]\n7,A,1000,2500\n"
    (tmp_path / "i.csv").write_text(images, encoding="utf-8")
    shown = invoke("convert", tmp_path / "i.csv", tmp_path / "images.csv")
    assert "image coordinates are pixels" in shown.stderr
    assert pd.read_csv(tmp_path / "images.csv")["x"].tolist() == [1000]


def converted(invoke, tmp_path, text, *options):
    (tmp_path / "t.csv").write_text(text, encoding="utf-8")
    (tmp_path / "out.csv").unlink(missing_ok=True)
    shown = invoke("convert", tmp_path / "t.csv", tmp_path / "out.csv", *options)
    assert shown.exit_code in (0, 2)
    return shown


@pytest.mark.parametrize(
    "text",
    ["Punkt;Breite;Länge\nA;48,2;13,5\n", "Point,Latitude,Longitude\nA,48.2,13.5"],
)
def test_degrees_under_any_name_have_the_system_that_is_said(invoke, tmp_path, text):
    shown = converted(invoke, tmp_path, text, "--crs", "EPSG:4326")
    assert shown.exit_code == 0, shown.stderr
    frame = pd.read_csv(tmp_path / "out.csv")
    assert frame[["longitude", "latitude"]].to_numpy().tolist() == [[13.5, 48.2]]
    shown = converted(invoke, tmp_path, text)
    assert "Say which by --crs, such as --crs EPSG:4326" in shown.stderr


@pytest.mark.parametrize("unit", ["ft", "US ft", "ftUS"])
def test_a_header_may_state_the_unit_of_the_system(invoke, tmp_path, unit):
    text = f"Nr,E [{unit}],N [{unit}]\nA,990000,200000\n"
    shown = converted(invoke, tmp_path, text, "--crs", "EPSG:2263")
    assert shown.exit_code == 0, shown.stderr
    assert pd.read_csv(tmp_path / "out.csv")["easting"].tolist() == [990000]
    metres = text.replace(f"[{unit}]", "[m]")
    shown = converted(invoke, tmp_path, metres, "--crs", "EPSG:2263")
    assert "is in m; expected US survey foot units" in shown.stderr
    gons = "Nr,longitude [gon],latitude [gon]\nA,2.5,50\n"
    assert not converted(invoke, tmp_path, gons, "--crs", "EPSG:4807").exit_code
    refused = converted(invoke, tmp_path, gons, "--crs", "EPSG:4326")
    assert "is in gon; expected degrees" in refused.stderr
    wrong = converted(invoke, tmp_path, "Nr,E,N\nA,1,2\n", "--crs", "EPSG:4326")
    assert "is geographic, but the columns are easting and northing" in wrong.stderr


@pytest.mark.parametrize(
    "text",
    [
        "A 1.5 2.5\nB 1.5 3.5\n",
        "Nr,X,Y\nA,1,2\n",
        "Nr,E [m],E [km],N\nA,1,2,3\n",
        "a,b\n1,2\n",
    ],
)
def test_convert_asks_for_nothing_in_a_block_that_it_has_not(invoke, tmp_path, text):
    shown = converted(invoke, tmp_path, text)
    assert shown.exit_code == 2
    assert "block.toml" not in shown.stderr


def test_tables_of_which_one_must_be_said_are_named(invoke, tmp_path):
    with xlsxwriter.Workbook(tmp_path / "t.xlsx") as book:
        for name in ("Alt", "Neu"):
            sheet = book.add_worksheet(name)
            sheet.write_row(0, 0, ["Nr", "Ost", "Nord"])
            sheet.write_row(1, 0, ["A", 1.5, 2.5])
    shown = invoke("convert", tmp_path / "t.xlsx", tmp_path / "out.csv")
    assert "holds 2 tables: Alt, Neu; expected one table" in shown.stderr


def test_a_column_without_a_name_is_left_out_by_its_place(invoke, tmp_path):
    shown = converted(invoke, tmp_path, "Nr;E;N;;x\nA;1.5;2.5;7;8\n")
    assert "note: t.csv: left out (column 4), x\n" in shown.stderr
