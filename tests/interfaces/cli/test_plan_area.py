"""``einschalt plan --area``: a flight plan over a polygon."""

import json
import re
from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd
import pyogrio
import pytest
import shapely
from numpy.testing import assert_allclose

from einschalt.foundations import projections
from einschalt.interfaces.programs import flight_plan_kml

UTM = "EPSG:32633"
RING = [(0, 0), (8200, 900), (9000, 5200), (4800, 7600), (600, 6000), (0, 0)]
HOLE = [(3000, 3000), (4200, 3000), (4200, 4200), (3000, 4200), (3000, 3000)]
CENTRE = np.array([500_000.0, 5_300_000.0])
SMALL = ("--scale-number", 11_000, "--spacing", 300, "--n-settings", "2,4")
MODEL = (0.60 * 0.23 - 0.01, 0.23 - 0.01)  # measurable, without the rim


def polygon(*rings, crs=UTM):
    moved = [[list(CENTRE + corner) for corner in ring] for ring in rings]
    named = {"type": "name", "properties": {"name": crs}}
    return {"type": "Polygon", "coordinates": moved, "crs": named}


def heights_of(x, y):
    return 400.0 + 0.02 * (x - CENTRE[0]) + 10.0 * np.sin(y / 700.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("area")
    (folder / "area.geojson").write_text(json.dumps(polygon(RING, HOLE)), "utf-8")
    x, y = np.meshgrid(np.arange(-5, 96) * 100.0, np.arange(-5, 96) * 100.0)
    x, y = x.ravel() + CENTRE[0], y.ravel() + CENTRE[1]
    np.savetxt(folder / "ground.xyz", np.column_stack([x, y, heights_of(x, y)]), "%.2f")
    return folder


@pytest.fixture(scope="module")
def flown(folder):
    from typer.testing import CliRunner

    from einschalt.interfaces.cli.main import app

    arguments = ("plan", "--target", "5cm", "--area", folder / "area.geojson", *SMALL)
    given = ("--ground-heights", folder / "ground.xyz", "--n-coverages", 2)
    output = ("--output", folder / "plan", "--costs", "control_point=300")
    words = [str(word) for word in (*arguments, *given, *output)]
    shown = CliRunner().invoke(app, words)
    assert shown.exit_code == 0, shown.stderr
    return shown.stdout, folder / "plan"


def layer(folder, name):
    meta, table = pyogrio.read_arrow(folder / "flight_plan.gpkg", layer=name)
    shapes = shapely.from_wkb(table[meta["geometry_name"]].to_pylist())
    assert meta["crs"] == UTM
    return table.to_pandas(), shapes


@pytest.mark.slow
def test_the_headline_is_a_plan_that_holds(flown):
    said, folder = flown
    assert said.startswith("Recommended: ")
    assert float(said.split()[1]) <= 5.0
    assert "Next best: " in said
    assert "with 1 hole where no point is wanted" in said
    assert "m above ground, GSD" in said
    assert "overlaps left on the highest" in said
    effort = pd.read_csv(folder / "effort.csv").set_index("item")
    assert effort.loc["control_point", "price"] == 300
    assert effort.loc["image", "price"] == 10  # the default of what was not named
    assert (effort["cost"] == effort["amount"] * effort["price"]).all()
    photographs = pd.read_csv(folder / "photographs.csv")
    assert effort.loc["image", "amount"] == len(photographs)


@pytest.mark.parametrize("flight", ["low_flight", "high_flight"])
def test_every_coverage_holds_the_whole_area(flown, flight):
    _, folder = flown
    (area,) = layer(folder, "area")[1]
    table, places = layer(folder, "photographs")
    plans = pd.read_csv(folder / "plans.csv")
    lines, _ = layer(folder, "flight_lines")
    height = lines.loc[lines["flight"] == flight, "flying_height"].iloc[0]
    scale = height / 0.152
    assert scale > plans["scale_number"].min() - 1.0
    heading = np.radians(90.0 - table["azimuth"].iloc[0])
    turned = [[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]]
    along, across = scale * np.array(MODEL) / 2.0
    corners = [(-along, -across), (along, -across), (along, across), (-along, across)]
    model = np.array(corners) @ np.array(turned).T
    for coverage in ("1", "2"):
        is_in = (table["flight"] == flight) & (table["coverage"] == coverage)
        held = []
        for _, photographs in table[is_in].groupby("line_id"):
            centres = shapely.get_coordinates(places[photographs.index])
            bases = np.hypot(*np.diff(centres, axis=0).T)
            # 60 % forward, or a little more
            assert bases.max() <= 0.40 * 0.23 * scale * (1 + 1e-6)
            assert bases.min() > 0.30 * 0.23 * scale
            middles = (centres[1:] + centres[:-1]) / 2.0
            held += [shapely.Polygon(middle + model) for middle in middles]
        left = area.difference(shapely.union_all(held))
        assert left.area < 1e-3 * model_area(along, across)


def model_area(along, across):
    return 4.0 * along * across


def test_control_lies_in_the_area_and_in_every_model(flown):
    _, folder = flown
    (area,) = layer(folder, "area")[1]
    control, places = layer(folder, "control")
    assert shapely.intersects(area.buffer(1e-6), places).all()
    assert (control["n_models"] >= 1).all()
    assert control["point_id"].is_unique
    assert set(control["standard_error_m"]) == {0.03}


def test_cameras_are_above_the_ground_below(flown):
    _, folder = flown
    table, _ = layer(folder, "photographs")
    np.testing.assert_allclose(
        table["altitude"] - table["ground"], table["flying_height"]
    )
    ground = heights_of(table["easting"], table["northing"])
    of_line = ground.groupby(table["line_id"]).mean()
    said = table.groupby("line_id")["ground"].first()
    assert np.abs(said - of_line).max() < 25.0  # means of what lies in the models
    # film keeps its altitude along a line
    assert (table.groupby("line_id")["altitude"].std() < 1e-6).all()


def test_planned_points_are_in_the_system_of_the_area(flown):
    _, folder = flown
    given, planned = (
        pd.read_csv(folder / f"{name}.csv") for name in ("control", "expected_points")
    )
    control = planned[planned["role"] == "control"]
    for axis in ("easting", "northing"):  # in the system of the area, as all others
        assert_allclose(sorted(control[axis]), sorted(given[axis]), atol=1e-6)


def test_kml_shows_the_same(flown):
    _, folder = flown
    root = ET.parse(folder / "flight_plan.kml").getroot()
    space = {"k": "http://www.opengis.net/kml/2.2"}
    (told,) = root.findall("k:Document/k:description", space)
    assert told.text.startswith("Recommended: ")
    checked, _, by = told.text.partition("Checked by propagation on a layout. ")
    assert checked
    assert by == "Brought to WGS 84 by change of map projection (0 m)."
    folders = root.findall(".//k:Folder", space)
    marks = {
        f.find("k:name", space).text: f.findall("k:Placemark", space) for f in folders
    }
    photographs = pd.read_csv(folder / "photographs.csv")
    assert len(marks["Flight lines"]) == photographs["line_id"].nunique()
    assert len(marks["Control"]) == len(pd.read_csv(folder / "control.csv"))
    point = marks["Photographs, low flight"][0].find(".//k:coordinates", space).text
    longitude, latitude, altitude = map(float, point.split(","))
    assert 14.9 < longitude < 15.2
    assert 47.7 < latitude < 48.0
    first = photographs[photographs["flight"] == "low_flight"].iloc[0]
    assert altitude == pytest.approx(first["altitude"], abs=0.1)
    hole = root.find(".//k:innerBoundaryIs", space)
    assert hole is not None


def test_an_area_without_a_target_is_told(invoke, folder):
    shown = invoke("plan", "--area", folder / "area.geojson")
    assert shown.exit_code == 2
    assert "Write --target 5cm as well" in shown.stderr


def test_options_of_areas_are_named_where_there_is_none(invoke):
    shown = invoke("plan", "--crs", UTM)
    assert "Not used for the tables: --crs." in shown.stdout


@pytest.mark.slow
def test_a_limit_over_ground_without_heights_is_told(invoke, folder):
    asked = ("plan", "--target", "8cm", "--area", folder / "area.geojson", *SMALL)
    asked = (*asked, "--n-coverages", 2, "--json")
    level = "The ground was taken to be level: to keep 3000 m above it over relief"
    for options, is_told in (
        (("--max-height", 3000), True),
        ((), False),
        (("--max-height", 3000, "--ground-heights", folder / "ground.xyz"), False),
    ):
        shown = invoke(*asked, *options)
        assert shown.exit_code == 0, shown.stderr
        assert (level in " ".join(shown.stderr.split())) == is_told
        problems = json.loads(shown.stdout)["problems"]
        found = [problem["found"] for problem in problems]
        assert ("the ground was taken to be level" in found) == is_told
        assert len(found) == is_told
    shown = invoke(*asked[:-1], "--max-height", 3000, "--language", "de")
    said = " ".join(shown.stdout.split())
    assert "Das Gelände wurde als eben angenommen: damit 3000 m darüber" in said


@pytest.mark.slow
def test_ground_that_is_too_high_is_refused(invoke, folder, tmp_path):
    table = np.loadtxt(folder / "ground.xyz")
    table[:, 2] += 0.3 * (table[:, 0] - CENTRE[0])
    np.savetxt(tmp_path / "high.xyz", table, "%.1f")
    shown = invoke(
        *("plan", "--target", "5cm", "--area", folder / "area.geojson", *SMALL),
        *("--ground-heights", tmp_path / "high.xyz", "--n-coverages", 2),
    )
    assert shown.exit_code == 2
    assert "the ground rises" in shown.stderr
    assert "expected more than 50 % forward" in " ".join(shown.stderr.split())


def _rectangle(folder, crs, east, north):
    """An area of 4 x 3 km in a plane system, as GeoJSON."""
    corners = [(0, 0), (4000, 0), (4000, 3000), (0, 3000), (0, 0)]
    ring = [[east + x, north + y] for x, y in corners]
    system = {"type": "name", "properties": {"name": crs}}
    text = json.dumps({"type": "Polygon", "coordinates": [ring], "crs": system})
    (folder / "area.geojson").write_text(text, "utf-8")
    return folder / "area.geojson"


@pytest.mark.slow
def test_kml_is_for_a_look_in_systems_of_old_datums_too(tmp_path, invoke):
    """PSAD56 of Peru is good to 16 m: no KML, and a remedy that plans have not."""
    area = _rectangle(tmp_path, "EPSG:24878", 500_000, 8_700_000)
    options = ("--target", "6cm", "--spacing", 250, "--scale-number", 9000)
    shown = invoke("plan", *options, "--area", area, "--output", tmp_path / "plan")
    assert shown.exit_code == 0, shown.stderr
    assert "crs_accuracy_m" not in shown.stdout + shown.stderr
    told = (tmp_path / "plan" / "flight_plan.kml").read_text("utf-8")
    by = re.search(r"Brought to WGS 84 by (PSAD56 to WGS 84 .*)\.</description>", told)
    assert re.fullmatch(r"PSAD56 to WGS 84 \(\d+\) \(\d\d m\)", by[1])


@pytest.mark.slow
def test_kml_is_written_by_the_operation_that_it_names(tmp_path, invoke, monkeypatch):
    """Chosen once, of all that is drawn: pieces near a border might have another."""
    asked = []

    def reproject(points, *given):
        asked.append(len(points))
        return projections.reproject(points, *given)

    monkeypatch.setattr(flight_plan_kml, "reproject", reproject)
    area = _rectangle(tmp_path, "EPSG:31255", 10_000, 320_000)
    options = ("--target", "6cm", "--spacing", 250, "--scale-number", 9000)
    shown = invoke("plan", *options, "--area", area, "--output", tmp_path / "plan")
    assert shown.exit_code == 0, shown.stderr
    tables = {
        name: len(pd.read_csv(tmp_path / "plan" / f"{name}.csv"))
        for name in ("flight_lines", "photographs", "control")
    }
    lines = tables.pop("flight_lines")
    assert asked == [5 + 2 * lines + sum(tables.values())]


@pytest.mark.slow
def test_a_plan_that_has_no_place_in_degrees_is_written_without_kml(tmp_path, invoke):
    """Exchanged easting and northing: all was computed, and nothing written."""
    area = _rectangle(tmp_path, "EPSG:31255", 320_000, 10_000)
    options = ("--target", "6cm", "--spacing", 250, "--scale-number", 9000)
    output = ("--output", tmp_path / "plan")
    shown = invoke("plan", *options, "--area", area, *output)
    assert shown.exit_code == 0, shown.stderr
    assert "flight_plan.kml was left out: " in shown.stderr
    assert "are its coordinates exchanged" in " ".join(shown.stdout.split())
    assert (tmp_path / "plan" / "flight_plan.gpkg").exists()
    assert not (tmp_path / "plan" / "flight_plan.kml").exists()
    told = invoke("plan", *options, "--area", area, *output, "--overwrite", "--json")
    problems = json.loads(told.stdout)["problems"]
    (left_out,) = [one for one in problems if "flight_plan.kml" in one["found"]]
    assert left_out["found"].startswith("flight_plan.kml was left out: ")


def test_a_file_that_cannot_be_written_is_refused_before_the_search(
    invoke, tmp_path, monkeypatch
):
    monkeypatch.setattr("einschalt.interfaces.cli.work.plan._answer", _never)
    output = ("--output", tmp_path / "plan.gpkg")
    shown = invoke("plan", "--target", "6cm", "--spacing", 250, *output)
    assert shown.exit_code == 2
    assert "suffix '.gpkg' is unknown; expected .csv, .parquet" in shown.stderr


def _never(_):
    raise AssertionError("it was computed")
