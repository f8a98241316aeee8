"""``einschalt init``: from files to a block.toml that check accepts."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyogrio
import pyproj
import pytest
import shapely
import xlsxwriter
from typer.testing import CliRunner

from einschalt.interfaces.cli.main import app
from einschalt.interfaces.cli.work import init as work
from einschalt.interfaces.files.block_folder import find_problems
from einschalt.interfaces.files.block_writing import write_block
from einschalt.interfaces.files.camera_toml import camera_of
from einschalt.interfaces.files.understood_tables import Said
from einschalt.interfaces.new_block.looked_at import look_at
from einschalt.interfaces.new_block.proposal import propose
from einschalt.interfaces.new_block.questions import answered
from einschalt.interfaces.programs.block_tables import read_block
from einschalt.interfaces.programs.recognised import read_foreign
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

FLIGHTS = ("high_flight.csv", "low_flight.csv")
ONE_ERROR = {"standard_error_m": 0.0283}
EACH_ERROR = {"standard_error_easting": 0.02, "standard_error_northing": 0.02}
KINDS = {"control": "Passpunkt", "check": "Kontrollpunkt"}
EXAMPLES = Path(__file__).parents[3] / "data_examples"
PITCH_UM, SIDE = 12.0, 20_000
KNOWN = ("--high-m-g-um", "7.5", "--low-m-g-um", "5", "--control-error-m", "0.03")


@pytest.fixture(scope="module")
def export(tmp_path_factory, block_folder):
    """What an Austrian office hands over: German names, decimal commas, cp1252."""
    folder = tmp_path_factory.mktemp("export")
    for name in FLIGHTS:
        shutil.copy(block_folder / name, folder / name)
    control = pd.read_csv(block_folder / "control_points.csv", dtype={"point_id": str})
    table = pd.DataFrame(
        {
            "Punktnummer": control["point_id"],
            "Rechtswert": control["easting"],
            "Hochwert": control["northing"],
            "Höhe": 411.25,
            "Art": control["role"].map(KINDS),
        }
    )
    options = {"sep": ";", "decimal": ",", "encoding": "cp1252", "index": False}
    table.to_csv(folder / "Punkte.csv", **options)
    columns = [table[name].tolist() for name in table]
    sheet = pa.table(columns, names=list(table))
    pyogrio.write_arrow(
        sheet, folder / "Punkte.xlsx", driver="XLSX", geometry_name=None
    )
    shapes = shapely.to_wkb(shapely.points(control[["easting", "northing"]]))
    layer = sheet.select(["Punktnummer", "Art"]).append_column("g", [shapes.tolist()])
    pyogrio.write_arrow(
        layer,
        folder / "Punkte.gpkg",
        driver="GPKG",
        geometry_name="g",
        geometry_type="Point",
        crs="EPSG:31255",
    )
    return folder


def files_of(folder):
    return ["--from", *(folder / name for name in ("Punkte.csv", *FLIGHTS))]


def test_a_system_named_by_its_number_alone_is_told(invoke, export, tmp_path):
    given = (*files_of(export), "--crs", "31255", *KNOWN)
    shown = invoke("init", tmp_path / "new", *given)
    assert shown.exit_code in (0, 2), shown.output
    assert "[block] crs = 31255: " in shown.stdout


def test_a_column_that_is_not_used_is_told(invoke, export, tmp_path):
    as_written = {"sep": ";", "encoding": "cp1252"}
    table = pd.read_csv(export / "Punkte.csv", dtype=str, **as_written)
    table["Standardabweichung"] = "0,02"
    table.to_csv(tmp_path / "Punkte.csv", index=False, **as_written)
    flights = files_of(export)[2:]
    files = ("--from", tmp_path / "Punkte.csv", *flights)
    given = (*files, "--crs", "EPSG:31255", *KNOWN)
    shown = invoke("init", tmp_path / "new", *given)
    assert shown.exit_code == 0, shown.output
    notes = [one for one in shown.stdout.split("\n") if one.startswith("note: ")]
    assert len(notes) == 1
    assert notes[0].endswith("Punkte.csv: ignored column Standardabweichung")


@pytest.mark.parametrize("scale", ["8000", "1:8000", "15000", "1:15000"])
def test_a_scale_that_the_models_do_not_have_is_told(invoke, export, tmp_path, scale):
    """1:8000 was taken without a word, and m_g held to be wrong for it later."""
    given = (*files_of(export), "--crs", "EPSG:31255", *KNOWN, "--high-scale", scale)
    shown = invoke("init", tmp_path / "new", *given)
    assert shown.exit_code == 0, shown.output
    note = "Note: 7 models against the ground: 1:15000, and not 1:8000. m_g counts"
    assert (note in shown.stdout) == scale.endswith("8000")
    block = find_problems(tmp_path / "new").block
    assert block.high_flight.scale_number == float(scale.removeprefix("1:"))


@pytest.mark.parametrize("suffix", [".csv", ".xlsx", ".gpkg"])
def test_files_make_a_block_that_check_accepts(
    invoke, export, block_folder, tmp_path, suffix
):
    """The same control, whatever it came in; no file is edited by hand."""
    folder = tmp_path / "new"
    names = (str(one) for one in files_of(export))
    files = [name.replace("Punkte.csv", f"Punkte{suffix}") for name in names]
    shown = invoke("init", folder, *files, "--crs", "EPSG:31255", *KNOWN)
    assert shown.exit_code == 0, shown.output
    assert "scale_number = 15000: 7 models against the ground: 1:15000" in shown.stdout
    if suffix != ".gpkg":
        assert "'Rechtswert' = easting" in shown.stdout
    assert "nothing wrong" in shown.stdout
    plain, block = (find_problems(one).block for one in (block_folder, folder))
    for name, flight in block.flights.items():  # coverages share names of models
        n_rows = len(flight.model_points)
        said = f"{name}.csv (model points: {n_rows} rows, {flight.n_models} models,"
        assert said in shown.stdout
    plane = ["easting", "northing"]
    one, other = (b.control_points.set_index("point_id") for b in (plain, block))
    np.testing.assert_allclose(one[plane], other[plane], rtol=0, atol=1e-9)
    assert one["role"].equals(other["role"])
    for name in ("high_flight", "low_flight"):
        one, other = (getattr(b, name) for b in (plain, block))
        assert (one.scale_number, one.m_g_um) == (other.scale_number, other.m_g_um)
    again = invoke("init", folder, *files_of(export), "--yes")
    assert again.exit_code == 2
    assert "the folder holds block.toml already" in again.stderr


def test_what_no_file_tells_is_named_where_nobody_can_be_asked(
    invoke, export, tmp_path
):
    refused = invoke("init", tmp_path / "new", *files_of(export), "--low-m-g-um", "5")
    assert refused.exit_code == 2
    assert "expected --crs, --control-error-m, --high-m-g-um. Give" in refused.stderr
    assert "such as EPSG:31255" in refused.stderr
    assert not (tmp_path / "new").exists()
    taken = invoke("init", tmp_path / "new", *files_of(export), "--yes")
    assert taken.exit_code == 0
    text = (tmp_path / "new" / "block.toml").read_text(encoding="utf-8")
    assert "m_g_um = 7.5  # assumed, since no file tells: correct it" in text
    assert "# crs = …" in text
    assert "left out, so no errors are propagated, and no ellipses" in taken.stdout


@pytest.mark.parametrize("name", ["Punkte.csv", "low_flight.csv"])
def test_a_bad_cell_is_said_before_anything_is_guessed(invoke, export, tmp_path, name):
    for path in export.glob("*.csv"):
        lines = path.read_text(encoding="cp1252").splitlines()
        if path.name == name:
            cells = lines[1].split(";" if name == "Punkte.csv" else ",")
            cells[-2] = "abc"
            lines[1] = (";" if name == "Punkte.csv" else ",").join(cells)
        (tmp_path / path.name).write_text("\n".join(lines), encoding="cp1252")
    refused = invoke("init", tmp_path / "new", *files_of(tmp_path), "--yes")
    assert refused.exit_code == 2
    assert f"{name}, row 2" in refused.stderr
    assert "'abc'" in refused.stderr
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("text", "said", "option"),
    [
        ("Punkt;Rechtswert;Hochwert\nA;1,234;322,001\n", "1.234 or 1234?", "decimal ,"),
        ("point_id,x,y\n7,3,4\n", "which of them is the easting?", "easting and --n"),
        ("1971; A8\nModell;Punkt;x;y\n1;A;1,234;2\n", "1.234 or 1234?", "decimal ,"),
        ("A 3.5 4.5\nB 4.5 5.5\n", "which of 'column 2' and", "easting and --n"),
    ],
)
def test_questions_name_the_options_that_answer_them(
    invoke, tmp_path, text, said, option
):
    (tmp_path / "P.csv").write_text(text)
    refused = invoke("init", tmp_path / "new", "--from", tmp_path / "P.csv", "--yes")
    assert refused.exit_code == 2
    assert said in refused.stderr
    assert f"Give --{option}" in refused.stderr
    assert "block.toml" not in refused.stderr


def test_a_terminal_is_asked(export, tmp_path, monkeypatch):
    monkeypatch.setattr(work, "_is_terminal", lambda: True)
    call = ["init", tmp_path / "new", *files_of(export), "--high-m-g-um", "7.5"]
    answers = "EPSG:99999\nEPSG:31255\n\nfive\n6\n"
    shown = CliRunner().invoke(app, [str(word) for word in call], input=answers)
    assert shown.exit_code == 0, shown.output
    assert "'EPSG:99999' is unknown" in shown.output
    block = find_problems(tmp_path / "new").block
    assert (block.crs, block.low_flight.m_g_um) == ("EPSG:31255", 6.0)


def test_the_template_is_a_block_where_its_tables_are(invoke, small_block):
    (small_block.path / "block.toml").unlink()
    assert invoke("init", small_block.path, "--template").exit_code == 0
    assert find_problems(small_block.path).problems == ()


def test_flights_are_told_apart_by_their_scales_and_units(invoke, small_block):
    (small_block.path / "block.toml").unlink()
    for old, new in (("high_flight", "b"), ("low_flight", "a")):
        table = pd.read_csv(small_block.path / f"{old}.csv", dtype=str)
        table = table.astype({"x": float, "y": float})
        table[["x", "y"]] /= 10.0
        table.to_csv(small_block.path / f"{new}.csv", index=False)
        (small_block.path / f"{old}.csv").unlink()
    shown = invoke("init", small_block.path, "--yes", "--crs", "EPSG:31255")
    assert shown.exit_code == 0, shown.output
    block = find_problems(small_block.path).block
    assert block.sources["high_flight.model_points"] == "b.csv"
    assert (block.high_flight.model_unit, block.low_flight.scale_number) == ("cm", 8e3)


def test_files_that_make_no_block_are_refused_in_words(invoke, export, tmp_path):
    for files, said in (
        (["Punkte.csv"], "no files hold measurements of a flight"),
        (["high_flight.csv", "low_flight.csv"], "no file holds control points"),
    ):
        named = [export / name for name in files]
        refused = invoke("init", tmp_path / "new", "--from", *named, "--yes")
        assert refused.exit_code == 2
        assert said in refused.stderr


@pytest.mark.parametrize("columns", [ONE_ERROR, EACH_ERROR], ids=["total", "by axis"])
def test_a_flight_of_images_goes_onto_its_control(invoke, tmp_path, columns):
    """As unmanned aircraft fly it: once, over targets that were surveyed."""
    source = EXAMPLES / "sxb_strasbourg"
    control = pd.read_csv(source / "control_points.csv", dtype={"point_id": str})
    del control["standard_error_m"]
    control.assign(**columns).to_csv(tmp_path / "control.csv", index=False)
    files = [tmp_path / "control.csv", source / "image_points.csv"]
    files += [source / "models.csv"]
    asked = ["--principal-distance-mm", "123.9392", "--low-scale", "14400"]
    shown = invoke("init", tmp_path / "b", "--from", *files, *asked, "--yes")
    assert shown.exit_code == 0, shown.output
    found = find_problems(tmp_path / "b")
    assert not found.problems
    block = found.block
    assert len(block.approximate_points) == len(block.control_points) == 16
    assert block.low_flight.transformation == "helmert_3d"
    assert block.approximate_m_0_m == pytest.approx(0.0283, abs=1e-4)
    error = block.control_points["standard_error_m"]
    np.testing.assert_allclose(error, 0.0283, rtol=0, atol=1e-4)


def test_an_answer_about_control_holds_where_models_go_onto_it(invoke, tmp_path):
    source = EXAMPLES / "sxb_strasbourg"
    control = pd.read_csv(source / "control_points.csv", dtype={"point_id": str})
    del control["standard_error_m"]
    control.to_csv(tmp_path / "control.csv", index=False)
    files = [tmp_path / "control.csv", source / "image_points.csv"]
    asked = ["--principal-distance-mm", "123.9392", "--control-error-m", "0.04"]
    files, more = [*files, source / "models.csv"], ["--low-scale", "14400", "--yes"]
    shown = invoke("init", tmp_path / "b", "--from", *files, *asked, *more)
    assert shown.exit_code == 0, shown.output
    assert find_problems(tmp_path / "b").block.approximate_m_0_m == 0.04


def test_init_writes_the_schema_beside(invoke, tmp_path):
    assert invoke("init", tmp_path / "b", "--template", "--schema").exit_code == 0
    text = (tmp_path / "b" / "block.toml").read_text(encoding="utf-8")
    assert text.startswith("#:schema block.schema.json\n")
    assert json.loads((tmp_path / "b" / "block.schema.json").read_text())["properties"]


@pytest.fixture(scope="module")
def of_images(tmp_path_factory):
    """Files of a block of photographs in pixels, with a camera of OpenSfM."""
    folder = tmp_path_factory.mktemp("images")
    geometry = replace(PRESETS["demo"].geometry, measurement="images")
    block = simulate_block("demo", seed=3, geometry=geometry)
    write_block(block, folder / "mm")
    distance = block.low_flight.principal_distance_mm
    assert distance == block.high_flight.principal_distance_mm
    kinds = {"projection_type": "perspective", "k1": -0.01, "k2": 0.0}
    focal = distance / PITCH_UM * 1e3 / SIDE
    models = {"c": {**kinds, "width": SIDE, "height": SIDE, "focal": focal}}
    (folder / "camera_models.json").write_text(json.dumps(models))
    camera = read_foreign(folder / "camera_models.json").cameras["c"]
    camera = camera_of({**camera, "pixel_size_um": PITCH_UM})
    for path in (folder / "mm").glob("*.csv"):
        table = pd.read_csv(path, dtype={"point_id": str})
        if {"image_id", "x"} <= set(table):
            table[["x", "y"]] = camera.measured_from_xy(table[["x", "y"]].to_numpy())
        table.to_csv(folder / path.name, index=False)
    return folder


@pytest.mark.slow
def test_a_camera_without_the_size_of_a_pixel_is_asked_for_it(
    invoke, of_images, tmp_path
):
    files = [p for p in sorted(of_images.iterdir()) if p.is_file()]
    given = ("--from", *files, "--yes")
    shown = invoke("init", tmp_path / "b", *given)
    assert shown.exit_code == 2
    assert "--pixel-size-um" in shown.stderr
    assert "-scale" not in shown.stderr  # which the size of a pixel tells
    shown = invoke("init", tmp_path / "b", *given, "--pixel-size-um", str(PITCH_UM))
    assert shown.exit_code == 0, shown.output
    # photographs of 1:8000 and 1:15000, tilted and over hills
    assert "images against the ground: 1:8063" in shown.stdout
    assert "images against the ground: 1:15165" in shown.stdout
    block, whole = read_block(tmp_path / "b"), read_block(of_images / "mm")
    assert block.high_flight.camera.given["pixel_size_um"] == PITCH_UM
    assert not find_problems(tmp_path / "b").problems
    for flight in ("high_flight", "low_flight"):
        own, expected = (getattr(b, flight).image_points for b in (block, whole))
        camera = getattr(block, flight).camera
        xy = camera.xy_from_measured(own[["x", "y"]].to_numpy())
        np.testing.assert_allclose(xy, expected[["x", "y"]], atol=1e-9)


def test_the_size_of_a_pixel_that_is_answered_tells_the_scale(of_images):
    files = [p for p in sorted(of_images.iterdir()) if p.is_file()]
    proposal = propose([one for path in files for one in look_at(path, Said())], {})
    of_low = [q for q in proposal.questions if q.section == "low_flight"]
    (pitch,) = (question for question in of_low if question.key == "pixel_size_um")
    assert "scale_number" not in {question.key for question in of_low}
    told = answered(proposal, pitch, PITCH_UM, "as you say")
    assert told.values["low_flight", "scale_number"].reason.endswith("ground: 1:8063")
    # without two control points in one photograph it does not
    control = proposal.tables["control_points", "file"]
    one = replace(control, frame=control.frame[:1])
    proposal.tables["control_points", "file"] = one
    untold = answered(proposal, pitch, PITCH_UM, "as you say").questions[-1]
    assert (untold.section, untold.option) == ("low_flight", "--low-scale")


def test_the_size_of_a_pixel_is_refused_where_no_camera_lacks_it(
    invoke, export, tmp_path
):
    given = (*files_of(export), "--yes", "--pixel-size-um", "12")
    shown = invoke("init", tmp_path / "b", *given)
    assert shown.exit_code == 2
    assert "is of no camera that these files hold" in shown.stderr
    given = (*files_of(export), "--yes", "--pixel-size-um", "-1")
    shown = invoke("init", tmp_path / "b", *given)
    assert "expected 0.2 to 1000 (micrometres)" in shown.stderr


def test_two_cameras_are_not_chosen_between_in_silence(invoke, of_images, tmp_path):
    shutil.copy(of_images / "camera_models.json", tmp_path / "cameras.json")
    files = [p for p in sorted(of_images.iterdir()) if p.is_file()]
    given = ("--from", *files, tmp_path / "cameras.json", "--yes")
    shown = invoke("init", tmp_path / "b", *given)
    assert shown.exit_code == 2
    assert "camera_models.json, cameras.json hold a camera each" in shown.stderr
    models = json.loads((of_images / "camera_models.json").read_text())
    both = json.dumps({**models, "d": models["c"]})
    (tmp_path / "cameras.json").write_text(both)
    tables = [path for path in files if path.suffix == ".csv"]
    given = ("--from", *tables, tmp_path / "cameras.json", "--pixel-size-um", "12")
    shown = invoke("init", tmp_path / "b", *given, "--yes")
    assert shown.exit_code == 2
    assert "cameras.json: holds several cameras; expected one camera." in shown.stderr
    assert not (tmp_path / "b").exists()


@pytest.mark.slow
def test_a_sheet_or_a_layer_can_be_named_behind_its_file(invoke, export, tmp_path):
    """Two tables of control: which of them is meant is asked, and can be answered."""
    columns = pyogrio.read_dataframe(export / "Punkte.xlsx")
    for file, driver, title in (
        ("P.xlsx", "XLSX", "Blatt"),
        ("P.gpkg", "GPKG", "Punkte"),
    ):
        for part in (f"{title} 1", f"{title} 2"):
            pyogrio.write_arrow(
                pa.table({name: columns[name].tolist() for name in columns}),
                tmp_path / file,
                layer=part,
                driver=driver,
                geometry_name=None,
                append=(tmp_path / file).exists(),
            )
        flights = [export / name for name in FLIGHTS]
        rest = [*flights, "--crs", "EPSG:31255", *KNOWN]
        both = invoke("init", tmp_path / file[2:], "--from", tmp_path / file, *rest)
        assert both.exit_code == 2
        assert "could all be the control points" in both.stderr
        assert "FILE:NAME" in both.stderr
        one = f"{tmp_path / file}:{title} 2"
        shown = invoke("init", tmp_path / file[2:], "--from", one, *rest)
        assert shown.exit_code == 0, shown.stderr
        assert f"{file}, {title} 2 (ground points" in shown.stdout


def test_points_of_a_package_are_found_beside_areas(invoke, export, tmp_path):
    shutil.copy(export / "Punkte.gpkg", tmp_path / "P.gpkg")
    area = pa.table({"name": ["a"], "g": [shapely.to_wkb(shapely.box(0, 0, 1, 1))]})
    options = {"geometry_name": "g", "geometry_type": "Polygon", "crs": "EPSG:31255"}
    pyogrio.write_arrow(
        area, tmp_path / "P.gpkg", layer="area", driver="GPKG", append=True, **options
    )
    flights = [export / name for name in FLIGHTS]
    shown = invoke(
        "init", tmp_path / "new", "--from", tmp_path / "P.gpkg", *flights, *KNOWN
    )
    assert shown.exit_code == 0, shown.stderr
    assert "P.gpkg, Punkte (ground points" in shown.stdout


def test_points_in_degrees_give_scales_and_need_a_system(invoke, export, tmp_path):
    layer = pyogrio.read_dataframe(export / "Punkte.gpkg").to_crs("EPSG:4326")
    layer.to_file(tmp_path / "P.geojson", driver="GeoJSON")
    rest = [*(export / name for name in FLIGHTS), *KNOWN, "--crs", "EPSG:31255"]
    shown = invoke("init", tmp_path / "new", "--from", tmp_path / "P.geojson", *rest)
    assert "scale_number = 15000: 7 models against the ground" in shown.stdout
    assert "scale_number = 8000: " in shown.stdout
    table = layer[["Punktnummer"]].assign(lon=layer.geometry.x, lat=layer.geometry.y)
    table.to_csv(tmp_path / "P.csv", index=False)
    refused = invoke("init", tmp_path / "old", "--from", tmp_path / "P.csv", *rest)
    assert refused.exit_code == 2
    assert "P.csv: holds longitudes and latitudes, and nothing tells" in refused.stderr


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        (
            "P.zip",
            b"PK\x03\x04",
            "is a zip archive; expected CSV, .xlsx or .gpkg. Unpack",
        ),
        ("P.xls", b"\xd0\xcf\x11\xe0", "is an old Excel workbook"),
        ("P.koo", b"A 1 2\n", "suffix '.koo' is unknown; expected .csv, .txt"),
    ],
)
def test_files_that_are_no_tables_are_told_by_what_they_are(
    invoke, tmp_path, name, data, said
):
    (tmp_path / name).write_bytes(data)
    refused = invoke("init", tmp_path / "new", "--from", tmp_path / name, "--yes")
    assert refused.exit_code == 2
    assert said in refused.stderr


def test_a_folder_is_to_be_converted_first(invoke, tmp_path):
    refused = invoke("init", tmp_path / "new", "--from", tmp_path, "--yes")
    assert refused.exit_code == 2
    assert "is a folder; expected files. Convert a folder of COLMAP" in refused.stderr


def test_why_a_file_is_refused_is_told_and_not_its_kind(invoke, tmp_path):
    """It is what its suffix says, so that nobody should be told to rename it."""
    path, new = tmp_path / "P.parquet", tmp_path / "new"
    lists = pd.DataFrame({"model_id": ["1"], "point_id": ["A"], "y": [1.0]})
    lists.assign(x=[[1.0, 2.0]]).to_parquet(path)
    refused = invoke("init", new, "--from", path, "--yes")
    assert refused.exit_code == 2
    assert "P.parquet: column 'x' holds lists or structures" in refused.stderr
    pd.DataFrame({"a": [1.0]}).to_parquet(path)
    refused = invoke("init", new, "--from", path, "--yes")
    said = "P.parquet: holds no table that a block could have; its columns are 'a'"
    assert said in refused.stderr


@pytest.mark.parametrize(
    ("option", "value", "expected"),
    [
        ("--high-scale", "-15000", "100 to 200000 (the denominator)"),
        ("--low-scale", "0", "100 to 200000 (the denominator)"),
        ("--high-m-g-um", "0.0000075", "0.1 to 1000 (micrometres in the image)"),
        ("--principal-distance-mm", "0.153", "1 to 5000 (millimetres)"),
        ("--control-error-m", "-0.03", "a number above 0, at most 10 metres"),
    ],
)
def test_impossible_numbers_are_refused_and_nothing_is_written(
    option, value, expected, invoke, export, tmp_path
):
    """They were written into block.toml, and only then refused."""
    new = tmp_path / "new"
    refused = invoke("init", new, *files_of(export), "--yes", f"{option}={value}")
    assert refused.exit_code == 2
    assert f"{option} = {float(value):g}; expected {expected}." in refused.stderr
    assert not new.exists()


def test_coordinates_in_feet_are_told(invoke, tmp_path):
    unit, table = "ft", tmp_path / "control.csv"
    table.write_text(f"Nr;Rechtswert [{unit}];Hochwert [{unit}]\n1;13,0025;322,5\n")
    for words in (("init", tmp_path / "new", "--from", table), ("convert", table)):
        out = () if words[0] == "init" else (tmp_path / "out.csv",)
        refused = invoke(*words, *out)
        assert refused.exit_code == 2
        said = f"column 'easting' is missing; 'Rechtswert [{unit}]' is in {unit}; "
        assert f"{said}expected metres. Give it in metres, or" in refused.stderr


MODEL_UNITS = {
    "x [m]": ("m", 1e-3),
    "x [µm]": ("um", 1e3),
    "x_mm": ("mm", 1.0),
    "X in cm": ("cm", 0.1),
    "x (Millimeter)": ("mm", 1.0),
}


def with_header(folder, files, names, factor):
    """Copies of flights with other names of their columns, in another unit."""
    folder.mkdir()
    for file in files:
        frame = pd.read_csv(file, dtype={"point_id": str})
        frame[["x", "y"]] *= factor
        columns = dict(zip("xy", names, strict=True))
        frame.rename(columns=columns).to_csv(folder / file.name, index=False)
    return [folder / file.name for file in files]


@pytest.mark.parametrize("name", MODEL_UNITS)
def test_the_unit_in_a_header_is_that_of_the_models(invoke, export, tmp_path, name):
    unit, factor = MODEL_UNITS[name]
    option, *files = files_of(export)
    control, flights = files[:-2], files[-2:]
    names = name, name.replace("x", "y").replace("X", "Y")
    changed = with_header(tmp_path / "files", flights, names, factor)
    given = (option, *control, *changed, "--crs", "EPSG:31255", *KNOWN)
    shown = invoke("init", tmp_path / "new", *given)
    assert shown.exit_code == 0, shown.output
    said = f"model_unit = {unit}: the header of {FLIGHTS[0]} says so"
    assert said in shown.stdout
    found = find_problems(tmp_path / "new")
    assert found.block.high_flight.model_unit == unit
    assert found.block.high_flight.scale_number == 15000.0
    toml = tmp_path / "new" / "block.toml"
    other = "mm" if unit == "um" else "um"
    text = toml.read_text(encoding="utf-8")
    text = text.replace(f'model_unit = "{unit}"', f'model_unit = "{other}"')
    toml.write_text(text, encoding="utf-8")
    fault = find_problems(tmp_path / "new").problems[0]
    assert f"column '{name}' is in {unit}, but model_unit of the flight" in fault.found
    assert fault.remedy.startswith(f"Set model_unit = '{unit}'")


@pytest.mark.parametrize(("unit", "metres"), [("km", 1e3), ("cm", 0.01), ("mm", 0.001)])
def test_control_in_another_unit_without_a_word_is_told(
    unit, metres, invoke, export, tmp_path, block_folder
):
    control = pd.read_csv(block_folder / "control_points.csv")
    control[["easting", "northing"]] /= metres
    table = tmp_path / "control.csv"
    control.to_csv(table, index=False)
    flights = [export / name for name in FLIGHTS]
    refused = invoke("init", tmp_path / "new", "--yes", "--from", table, *flights)
    assert refused.exit_code == 2
    assert f"as if their coordinates were in {unit}" in refused.stderr
    assert not (tmp_path / "new").exists()
    # and the remedy works
    names = {n: f"{n} [{unit}]" for n in ("easting", "northing")}
    control.rename(columns=names).to_csv(table, index=False)
    shown = invoke("init", tmp_path / "new", "--yes", "--from", table, *flights)
    assert shown.exit_code == 0, shown.output


def test_model_coordinates_in_feet_are_told(invoke, export, tmp_path):
    option, *files = files_of(export)
    changed = with_header(tmp_path / "f", files[-2:], ("x [ft]", "y [ft]"), 1.0)
    refused = invoke("init", tmp_path / "new", "--yes", option, *files[:-2], *changed)
    assert refused.exit_code == 2
    assert "column 'x' is missing; 'x [ft]' is in ft" in refused.stderr


OF_MODELS = "Block;{};Punkt;x;y\n1;1/2;101;1,23;2,34\n1;2/3;101;3,14;2,55\n"


def test_a_table_of_image_pairs_holds_model_points(tmp_path):
    file = tmp_path / "paare.csv"
    file.write_text(OF_MODELS.format("Bildpaar"), "utf-8")
    (table,) = look_at(file, Said())
    assert table.kind == "model_points"
    assert list(table.frame["model_id"]) == ["1/2", "2/3"]


def test_a_table_that_was_taken_for_ground_points_is_told_so(invoke, tmp_path):
    """Its model points were to be deleted, since each stands in several models."""
    file = tmp_path / "paare.csv"
    file.write_text(OF_MODELS.format("Gespann"), "utf-8")
    refused = invoke("init", tmp_path / "new", "--from", file, "--yes")
    assert refused.exit_code == 2
    assert "taken for ground points, the row repeats row 2" in refused.stderr
    said = "to model_id: one of 'Block', 'Gespann'. Otherwise delete one of the two"
    assert said in " ".join(refused.stderr.split())


def write_as_book(frame, path):
    with xlsxwriter.Workbook(path) as book:
        sheet = book.add_worksheet()
        for k, row in enumerate([list(frame), *frame.values.tolist()]):
            sheet.write_row(k, 0, row)


def test_a_workbook_of_model_points_names_their_column_as_a_text_does(invoke, tmp_path):
    """Names like 1.1 had the remedy of two points of which numbers were made."""
    names = [1.1, 1.2, 1.3, 1.4]
    points = {"Punkt": names * 2, "Ost": range(8), "Nord": range(8), "Höhe": 100.0}
    table = pd.DataFrame({"Stereopaar": ["1/2"] * 4 + ["2/3"] * 4, **points})
    told = []
    for name in ("paare.xlsx", "paare.csv"):
        if name.endswith(".xlsx"):
            write_as_book(table, tmp_path / name)
        else:
            table.to_csv(tmp_path / name, index=False)
        from_file = ("--from", tmp_path / name, "--yes")
        refused = invoke("init", tmp_path / "new", *from_file)
        assert refused.exit_code == 2
        told.append(" ".join(refused.stderr.split()).replace(name, "paare"))
    assert told[0] == told[1]
    said = "to model_id: one of 'Stereopaar'. Otherwise delete one of the two"
    assert said in told[0]


@pytest.mark.parametrize(
    ("suffix", "remedy"),
    [
        ("xlsx", "A spreadsheet makes '1.1' of '1.10': give the column of names the"),
        ("csv", "Rename the points in one of them"),
    ],
)
def test_names_of_which_a_workbook_made_numbers_are_told(
    invoke, tmp_path, suffix, remedy
):
    block = simulate_block("demo", seed=2)
    known = list(block.control_points["point_id"])
    typed = {name: f"{k}.10" for k, name in enumerate(known, 1)}
    made = [float(typed[name]) for name in known]
    control = block.control_points.assign(point_id=made)
    path = tmp_path / f"control.{suffix}"
    if suffix == "xlsx":
        write_as_book(control, path)
    else:
        control.to_csv(path, index=False)
    for name, flight in (("high", block.high_flight), ("low", block.low_flight)):
        points = flight.model_points
        names = points["point_id"].map(lambda one: typed.get(one, f"N{one}"))
        points.assign(point_id=names).to_csv(tmp_path / f"{name}.csv", index=False)
    result = invoke("init", tmp_path, "--yes")
    assert result.exit_code == 2
    assert remedy in " ".join(result.output.split())


def test_names_written_otherwise_are_told_before_a_scale_is_asked(invoke, tmp_path):
    block = simulate_block("demo", seed=2)
    control, high = block.control_points, block.high_flight.model_points
    first = control["point_id"].iloc[0]
    named = control.assign(point_id=control["point_id"] + ".0")
    named.to_csv(tmp_path / "control.csv", index=False)
    high.to_csv(tmp_path / "high.csv", index=False)
    block.low_flight.model_points.to_csv(tmp_path / "low.csv", index=False)
    result = invoke("init", tmp_path, "--yes")
    assert result.exit_code == 2
    said = f"control.csv has '{first}.0', high.csv has '{first}', and they share no"
    assert said in " ".join(result.output.split())
    assert not (tmp_path / "block.toml").exists()


@pytest.mark.parametrize("scale", [(), ("--low-scale", "14400")])
def test_names_that_are_all_others_are_told_before_anything_is_asked(
    invoke, tmp_path, scale
):
    source = EXAMPLES / "sxb_strasbourg"
    control = pd.read_csv(source / "control_points.csv", dtype=str)
    control["point_id"] = [f"GCP{chr(65 + n)}" for n in range(len(control))]
    control.to_csv(tmp_path / "control.csv", index=False)
    files = ("--from", tmp_path / "control.csv", source / "image_points.csv")
    refused = invoke("init", tmp_path / "b", *scale, *files)
    assert refused.exit_code == 2
    said = (
        "image_points.csv holds none of the points of control.csv: its points are "
        "called 317, 333, 375 and 378 more, those of control.csv GCPA, GCPB, GCPC and "
        "13 more"
    )
    assert said in " ".join(refused.stderr.split())
    assert "--low-m-g-um" not in refused.stderr
    assert not (tmp_path / "b").exists()


def test_two_flights_that_share_points_with_each_other_alone_are_refused(
    invoke, tmp_path
):
    block = simulate_block("demo", seed=2)
    control = block.control_points
    named = control.assign(point_id=[f"GCP{chr(65 + n)}" for n in range(len(control))])
    named.to_csv(tmp_path / "control.csv", index=False)
    for name in ("high", "low"):  # names that do not tell which is the high one
        points = getattr(block, f"{name}_flight").model_points
        points.to_csv(tmp_path / f"{name[0]}.csv", index=False)
    refused = invoke("init", tmp_path, "--yes")
    assert refused.exit_code == 2
    said = "h.csv holds none of the points of control.csv"
    assert said in " ".join(refused.output.split())


def test_scales_are_those_of_the_points_in_one_system(invoke, tmp_path):
    block = simulate_block("demo", seed=2)
    control = block.control_points.copy()
    control[["easting", "northing"]] += [2.6e6, 0.9e6]
    control.loc[control.index[::2], ["easting", "northing"]] -= [2e6, 1e6]
    control.to_csv(tmp_path / "control.csv", index=False)
    for name in ("high", "low"):
        points = getattr(block, f"{name}_flight").model_points
        points.to_csv(tmp_path / f"{name}.csv", index=False)
    result = invoke("init", tmp_path, "--yes", "--crs", "EPSG:2056")
    output = " ".join(result.output.split())
    assert result.exit_code == 2
    assert "[high_flight] scale_number = 15000" in output
    assert "is given as LV03" in output
    assert "expected 100 to" not in output


@pytest.mark.slow
def test_photographs_and_control_alone_make_a_block(invoke, tmp_path):
    source = EXAMPLES / "sxb_strasbourg"
    given = ("--from", source / "control_points.csv", source / "image_points.csv")
    given += ("--yes", "--principal-distance-mm", "123.9392", "--low-m-g-um", "10")
    shown = invoke("init", tmp_path / "b", *given)
    assert shown.exit_code == 0, shown.output
    assert "chosen: each photograph with its best partners" in shown.stdout
    block = read_block(tmp_path / "b")
    assert block.low_flight.transformation == "helmert_3d"
    result = densify(block, Settings(method="simultaneous"))
    found = result.solution.points.set_index("point_id")
    bundle = pd.read_csv(source / "published_bundle.csv", dtype={"point_id": str})
    bundle = bundle[bundle["role"] == "check"].set_index("point_id")
    names = ["easting", "northing"]
    away = (found.loc[bundle.index, names] - bundle[names]).to_numpy()
    assert np.hypot(*away.T).max() < 0.06
    again = invoke("init", tmp_path / "b", *given)
    assert again.exit_code == 2
    (tmp_path / "b" / "block.toml").unlink()
    again = invoke("init", tmp_path / "b", *given)
    assert "is there already" in again.stderr
    assert not (tmp_path / "b" / "block.toml").exists()


@pytest.mark.slow
def test_models_on_little_control_are_adjusted_together(invoke, tmp_path):
    """Of nine models one alone shows three of six control points."""
    source = EXAMPLES / "sxb_strasbourg"
    control = pd.read_csv(source / "control_points.csv")[::3]
    control.to_csv(tmp_path / "control.csv", index=False)
    given = ("--from", tmp_path / "control.csv", source / "image_points.csv")
    given += ("--yes", "--principal-distance-mm", "100.5", "--low-m-g-um", "10")
    shown = invoke("init", tmp_path / "b", *given)
    assert shown.exit_code == 0, shown.output
    why = "fewer than 3 control points in 8 of 9 models: one adjustment ties these"
    assert f"[settings] method = auto: {why}" in shown.stdout
    assert f'[settings]\nmethod = "auto"  # {why}' in (
        tmp_path / "b" / "block.toml"
    ).read_text("utf-8")
    assert "nothing wrong" in shown.stdout
    checked = invoke("check", tmp_path / "b")
    assert checked.exit_code == 0, checked.output
    result = densify(read_block(tmp_path / "b"))
    assert result.choice.method == "simultaneous"
    assert result.failures.empty
    # of the sixteen as well one model shows two
    given = ("--from", source / "control_points.csv", *given[2:])
    of_all = invoke("init", tmp_path / "c", *given)
    assert "fewer than 3 control points in 1 of 9 models" in of_all.stdout


@pytest.mark.slow
def test_machine_models_and_control_alone_make_a_block(invoke, tmp_path):
    """Independent models over control, as they are adjusted elsewhere."""
    geometry = replace(PRESETS["demo"].geometry, n_check=0)
    block = simulate_block("demo", seed=3, geometry=geometry)
    known = block.truth.sample(6, random_state=1).assign(standard_error_m=0.03)
    known.to_csv(tmp_path / "control.csv", index=False)
    block.low_flight.model_points.to_csv(tmp_path / "models.csv", index=False)
    files = (tmp_path / "control.csv", tmp_path / "models.csv")
    shown = invoke("init", tmp_path / "b", "--from", *files, "--yes")
    assert shown.exit_code == 0, shown.output
    assert "fewer than 3 control points in 22 of 23 models" in shown.stdout
    assert "nothing wrong" in shown.stdout
    result = densify(read_block(tmp_path / "b"))
    assert result.choice.method == "simultaneous"
    new = result.points[result.points["role"] == "new"].set_index("point_id")
    assert len(new) == 94
    true = block.truth.set_index("point_id").loc[new.index, ["easting", "northing"]]
    away = new[["easting", "northing"]].to_numpy() - true.to_numpy()
    rms = np.sqrt(np.mean(np.sum(away**2, axis=1)))
    assert 0.5 < result.examination.credible.value / rms < 2.0


@pytest.mark.slow
def test_what_is_written_again_is_kept_beside(invoke, tmp_path):
    source, folder = EXAMPLES / "sxb_strasbourg", tmp_path / "b"
    given = ("--from", source / "control_points.csv", source / "image_points.csv")
    given += ("--yes", "--principal-distance-mm", "123.9392")
    for m_g, kept in (("10", set()), ("11", {"1"}), ("12", {"1", "2"})):
        before = {path.name: path.read_bytes() for path in folder.glob("*")}
        shown = invoke("init", folder, *given, "--low-m-g-um", m_g, "--again")
        assert shown.exit_code == 0, shown.output
        assert read_block(folder).low_flight.m_g_um == float(m_g)
        for name in ("block.toml", "low_flight_models.csv"):
            found = {path.name.split(".")[-2] for path in folder.glob(f"{name}.*.bak")}
            assert found == kept
            if kept:
                newest = folder / f"{name}.{max(kept)}.bak"
                assert newest.read_bytes() == before[name]
                assert f"kept as {newest.name}" in shown.stdout
    refused = invoke("init", folder, *given)
    assert refused.exit_code == 2
    assert "write it anew with --again" in refused.stderr


@pytest.mark.slow
def test_a_height_that_lacks_is_told(invoke, tmp_path):
    source = EXAMPLES / "sxb_strasbourg"
    control = pd.read_csv(source / "control_points.csv", dtype=str)
    lacking = control.index[control["role"] == "control"][4]
    control.loc[lacking, "height"] = ""
    control.to_csv(tmp_path / "control.csv", index=False)
    given = ("--from", tmp_path / "control.csv", source / "image_points.csv")
    given += ("--yes", "--principal-distance-mm", "123.9392")
    shown = invoke("init", tmp_path / "b", *given)
    assert shown.exit_code == 0, shown.output
    said = f"transformation = affine: in plan, without heights: 1 point has none \
({control['point_id'][lacking]}); with all heights it is helmert_3d"
    assert said in shown.stdout
    assert read_block(tmp_path / "b").low_flight.transformation == "affine"


def test_heights_that_are_all_zero_are_none(invoke, tmp_path):
    source = EXAMPLES / "sxb_strasbourg"
    control = pd.read_csv(source / "control_points.csv", dtype=str)
    control.assign(height="0.000").to_csv(tmp_path / "control.csv", index=False)
    given = ("--from", tmp_path / "control.csv", source / "image_points.csv")
    given += ("--yes", "--principal-distance-mm", "123.9392")
    shown = invoke("init", tmp_path / "b", *given)
    assert shown.exit_code == 0, shown.output
    assert "affine: in plan: all heights are 0, as programs write" in shown.stdout
    assert read_block(tmp_path / "b").low_flight.transformation == "affine"


def test_a_fault_of_control_is_told_once_where_it_stands_for_others(invoke, tmp_path):
    source = EXAMPLES / "sxb_strasbourg"
    control = pd.read_csv(source / "control_points.csv", dtype={"point_id": str})
    control.loc[3, ["easting", "northing", "height"]] = 0.0
    control.to_csv(tmp_path / "control.csv", index=False)
    given = ("--from", tmp_path / "control.csv", source / "image_points.csv")
    given += ("--yes", "--principal-distance-mm", "123.9392")
    shown = invoke("init", tmp_path / "b", *given)
    assert shown.exit_code == 2
    assert shown.stdout.count("easting 0.000, northing 0.000 lies 1006 km") == 1
    assert "block.toml: 1 problem\n" in shown.stdout
    assert shown.stdout.count("heights are 0, the others") == 1


@pytest.mark.slow
@pytest.mark.parametrize("what", ["y downwards", "axes exchanged"])
def test_photographs_like_a_mirror_are_told_before_anything_is_computed(
    invoke, tmp_path, what
):
    source = EXAMPLES / "sxb_strasbourg"
    images = pd.read_csv(source / "image_points.csv", dtype={"point_id": str})
    control = pd.read_csv(source / "control_points.csv", dtype={"point_id": str})
    if what == "y downwards":
        images["y"] *= -1.0
    else:
        names = {"easting": "northing", "northing": "easting"}
        control = control.rename(columns=names)
    images.to_csv(tmp_path / "image_points.csv", index=False)
    control.to_csv(tmp_path / "control.csv", index=False)
    given = ("--from", tmp_path / "control.csv", tmp_path / "image_points.csv")
    given += ("--yes", "--principal-distance-mm", "123.9392")
    shown = invoke("init", tmp_path / "b", *given)
    assert shown.exit_code == 2
    output = " ".join(shown.output.split())
    assert "5 of 5 photographs with enough known points are mirrored" in output
    assert "Change the sign of y of the image points, or exchange" in output
    assert "write it anew with --again" in output
    refused = invoke("densify", tmp_path / "b", "--output", tmp_path / "r")
    assert refused.exit_code == 2
    assert "are mirrored against" in refused.stderr


def test_nothing_but_check_points_is_told(invoke, tmp_path):
    source = EXAMPLES / "sxb_strasbourg"
    control = pd.read_csv(source / "control_points.csv", dtype={"point_id": str})
    control.assign(role="check").to_csv(tmp_path / "control.csv", index=False)
    given = ("--from", tmp_path / "control.csv", source / "image_points.csv")
    given += ("--yes", "--principal-distance-mm", "123.9392")
    shown = invoke("init", tmp_path / "b", *given)
    assert shown.exit_code == 2
    assert "all points are check points, onto which no model is fitted" in shown.output
    # its columns are read, as those of control
    assert "ignored column" not in shown.output


def test_models_are_asked_for_where_no_pair_of_photographs_makes_one(invoke, tmp_path):
    source = EXAMPLES / "sxb_strasbourg"
    points = pd.read_csv(source / "image_points.csv", dtype=str)
    points = (
        points[points["image_id"].isin(("8936", "9111"))].groupby("image_id").head(5)
    )
    points.to_csv(tmp_path / "image_points.csv", index=False)
    given = ("--from", source / "control_points.csv", tmp_path / "image_points.csv")
    given += ("--yes", "--principal-distance-mm", "123.9392", "--low-scale", "14400")
    shown = invoke("init", tmp_path / "b", *given)
    assert shown.exit_code != 0
    said = "two photographs have 1 point in common at most: a model needs 8, and a"
    assert said in shown.stdout
    assert "models is missing" in shown.output


@pytest.fixture(params=[("lon", "lat"), ("longitude", "latitude")])
def receiver(tmp_path, block_folder, request):
    """Control of a receiver: longitudes and latitudes, of a system that is not said."""
    control = pd.read_csv(block_folder / "control_points.csv", dtype={"point_id": str})
    to_degrees = pyproj.Transformer.from_crs(31255, 4312, always_xy=True)
    lon, lat = to_degrees.transform(control["easting"], control["northing"])
    east, north = request.param
    table = pd.DataFrame({"Name": control["point_id"], north: lat, east: lon})
    table.assign(role=control["role"]).to_csv(tmp_path / "receiver.csv", index=False)
    return tmp_path / "receiver.csv"


def test_longitudes_and_latitudes_are_asked_about_and_not_guessed(
    invoke, receiver, block_folder, tmp_path
):
    flights = [block_folder / name for name in FLIGHTS]
    call = ("init", tmp_path / "b", "--crs", "EPSG:31255", *KNOWN)
    files = ("--from", receiver, *flights)
    refused = invoke(*call, *files)
    assert refused.exit_code == 2
    assert "Give --points-crs EPSG:4326, or the system of the rec" in refused.stderr
    plane = invoke(*call, *files, "--points-crs", "EPSG:25833")
    assert plane.exit_code == 2
    assert "holds longitudes and latitudes, and nothing tells" in plane.stderr
    done = invoke(*call, *files, "--points-crs", "EPSG:4312")
    assert done.exit_code == 0, done.output
    block = read_block(tmp_path / "b")
    given = pd.read_csv(block_folder / "control_points.csv", dtype={"point_id": str})
    axes = ["easting", "northing"]
    there = block.control_points[axes].to_numpy()
    np.testing.assert_allclose(there, given[axes], rtol=0, atol=1e-5)


def test_degrees_of_another_program_are_asked_about_as_well(
    invoke, receiver, block_folder, tmp_path
):
    table = pd.read_csv(receiver, dtype={"Name": str})
    names = dict(zip(table, ["#Label", "Y/Latitude", "X/Longitude"], strict=False))
    control = table[table["role"] == "control"].drop(columns="role")
    control = control.rename(columns=names)[["#Label", "X/Longitude", "Y/Latitude"]]
    control.to_csv(tmp_path / "reference.csv", index=False)
    flights = [block_folder / name for name in FLIGHTS]
    call = ("init", tmp_path / "b", "--crs", "EPSG:31255", *KNOWN)
    files = ("--from", tmp_path / "reference.csv", *flights)
    refused = invoke(*call, *files)
    assert refused.exit_code == 2
    assert "Give --points-crs EPSG:4326, or the system of the rec" in refused.stderr
    done = invoke(*call, *files, "--points-crs", "EPSG:4312")
    assert done.exit_code == 0, done.output
    points = read_block(tmp_path / "b").control_points.set_index("point_id")
    given = pd.read_csv(block_folder / "control_points.csv", dtype={"point_id": str})
    axes = ["easting", "northing"]
    there = given.set_index("point_id").loc[points.index, axes]
    np.testing.assert_allclose(points[axes], there, rtol=0, atol=1e-5)


@pytest.mark.parametrize("said", ["EPSG:4326", "EPSG:4312"])
def test_a_system_that_contradicts_the_file_is_refused(
    invoke, receiver, block_folder, tmp_path, said
):
    table = pd.read_csv(receiver, dtype={"Name": str})
    north, east = list(table)[1:3]
    points = shapely.to_wkb(shapely.points(table[[east, north]].to_numpy()))
    columns = {"geometry_type": "Point", "crs": "EPSG:4312", "layer": "P"}
    values = [table[name].to_numpy(dtype=object) for name in ("Name", "role")]
    path = tmp_path / "P.gpkg"
    pyogrio.raw.write(path, points, values, ["Name", "role"], driver="GPKG", **columns)
    files = ("--from", path, *(block_folder / name for name in FLIGHTS))
    call = ("init", tmp_path / "b", "--crs", "EPSG:31255", *KNOWN, *files)
    result = invoke(*call, "--points-crs", said)
    assert (result.exit_code == 0) is (said == "EPSG:4312"), result.output
    if said == "EPSG:4326":
        refused = " ".join(result.stderr.split())
        states = "= WGS 84 (EPSG:4326), but the file states MGI (EPSG:4312)"
        assert f"P.gpkg: --points-crs {states}" in refused
        assert not (tmp_path / "b").exists()


def test_a_system_of_degrees_that_no_file_holds_is_refused(
    invoke, block_folder, tmp_path
):
    files = [block_folder / n for n in ("control_points.csv", *FLIGHTS)]
    call = ("init", tmp_path / "b", "--from", *files, "--crs", "EPSG:31255", *KNOWN)
    refused = invoke(*call, "--points-crs", "EPSG:4326")
    assert refused.exit_code == 2
    assert "--points-crs is about longitudes and latitudes, which no" in refused.stderr


def test_control_in_feet_has_a_system_of_its_own(invoke, export, tmp_path):
    """An American list: feet in the points, metres in the block."""
    folder, block = export, tmp_path / "block"
    control = pd.read_csv(
        folder / "Punkte.csv", sep=";", decimal=",", encoding="cp1252", dtype=str
    )
    feet = 1200.0 / 3937.0
    place = [
        control[name].str.replace(",", ".").astype(float)
        for name in ("Rechtswert", "Hochwert")
    ]
    shifts = 1_990_000.0, 300_000.0  # into the first zone of California
    numbers = [(p + s) / feet for p, s in zip(place, shifts, strict=True)]
    table = pd.DataFrame(
        {
            "Point #": control["Punktnummer"],
            "Northing (USft)": numbers[1],
            "Easting (USft)": numbers[0],
            "Elev (USft)": 411.25 / feet,
        }
    )
    table.to_csv(tmp_path / "control.csv", index=False, float_format="%.4f")
    files = [str(tmp_path / "control.csv"), *(str(folder / name) for name in FLIGHTS)]
    call = ("init", str(block), "--from", *files, *KNOWN)
    refused = invoke(*call, "--crs", "EPSG:2225")
    assert refused.exit_code == 2
    assert "and this one by --points-crs" in refused.stderr
    of_block = ("--crs", "EPSG:26910+5703")
    done = invoke(*call, *of_block, "--points-crs", "EPSG:2225+6360")
    assert done.exit_code == 0, done.output
    assert 'crs = "EPSG:2225+6360"' in (block / "block.toml").read_text("utf-8")
    found = read_block(block)
    np.testing.assert_allclose(found.control_points["height"], 411.25, atol=1e-3)
    low, high = (found.control_points["easting"].agg(one) for one in ("min", "max"))
    assert 2e5 < low < high < 8e5  # metres of UTM
    assert found.low_flight.scale_number == pytest.approx(8000, rel=0.02)


@pytest.mark.parametrize(
    ("renamed", "said", "meant"),
    [
        ({"Punktnummer": "LFP3-Nummer"}, "known to name the points", "LFP3-Nummer"),
        ({"Punktnummer": "Nr", "Art": "Name"}, "'Nr' and 'Name' could both", "Nr"),
    ],
)
def test_the_column_of_names_can_be_named(
    invoke, export, tmp_path, renamed, said, meant
):
    table = pd.read_csv(export / "Punkte.csv", sep=";", encoding="cp1252", dtype=str)
    table = table.rename(columns=renamed)
    table.to_csv(tmp_path / "Punkte.csv", sep=";", index=False)
    files = [tmp_path / "Punkte.csv", *(export / name for name in FLIGHTS)]
    call = ("init", str(tmp_path / "b"), "--from", *map(str, files), *KNOWN)
    refused = invoke(*call, "--crs", "EPSG:31255")
    assert refused.exit_code == 2
    assert said in refused.stderr
    assert "Give --point-id, the name of " in refused.stderr
    done = invoke(*call, "--crs", "EPSG:31255", "--point-id", meant)
    assert done.exit_code == 0, done.output
    assert f'point_id = "{meant}"' in (tmp_path / "b" / "block.toml").read_text("utf-8")
