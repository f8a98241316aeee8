"""``einschalt check``."""

from einschalt.interfaces.cli.work import check as work


def test_a_sound_block_has_nothing_wrong(invoke, block_folder):
    shown = invoke("check", block_folder)
    assert shown.exit_code == 0
    assert shown.stdout.split("\n")[-2] == f"{block_folder}: nothing wrong"


def test_everything_wrong_is_said_at_once_and_can_be_searched(spawn, spoilt_folder):
    done = spawn("check", spoilt_folder)
    assert done.returncode == 2
    assert done.stderr == ""
    lines = done.stdout.strip().split("\n")
    number = [line for line in lines if "low_flight.csv, row 5" in line]
    assert len(number) == 1
    assert number[0].startswith("problem: low_flight.csv, row 5, point ")
    assert "'n/a' is not a number; expected millimetres. Give" in number[0]
    assert lines[-1].startswith(f"{spoilt_folder}: ")
    assert "problem" in lines[-1]


def test_notes_are_listed_and_are_nothing_wrong(invoke, block_folder, tmp_path):
    import shutil

    folder = tmp_path / "noted"
    shutil.copytree(block_folder, folder)
    file = folder / "control_points.csv"
    lines = file.read_text(encoding="utf-8").strip().split("\n")
    text = "\n".join([f"{lines[0]},colour", *(f"{line},red" for line in lines[1:])])
    file.write_text(text + "\n", encoding="utf-8")
    shown = invoke("check", folder)
    assert shown.exit_code == 0
    assert "note: control_points.csv: ignored column colour" in shown.stdout


def test_a_missing_block_is_a_problem(invoke, tmp_path):
    shown = invoke("check", tmp_path / "nowhere")
    assert shown.exit_code == 2
    assert "nowhere: there is no such folder or file" in shown.stdout


def test_a_terminal_gets_a_table(invoke, spoilt_folder, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setattr(work, "_is_terminal", lambda: True)
    shown = invoke("check", spoilt_folder)
    assert shown.exit_code == 2
    assert "│ low_flight.csv" in shown.stdout
    assert "problem: " not in shown.stdout


def test_control_of_another_datum_needs_its_grid_or_a_word(
    invoke, block_folder, tmp_path, monkeypatch
):
    import shutil

    import pandas as pd
    import pyproj

    folder = tmp_path / "block"
    shutil.copytree(block_folder, folder)
    control = pd.read_csv(folder / "control_points.csv", dtype={"point_id": str})
    way = pyproj.Transformer.from_crs("EPSG:31255", "EPSG:25833", always_xy=True)
    plane = way.transform(control["easting"], control["northing"])
    control["easting"], control["northing"] = plane
    control.to_csv(folder / "control_points.csv", index=False)
    toml = folder / "block.toml"
    text = toml.read_text(encoding="utf-8")
    section = "[control_points]\n"
    assert section in text
    toml.write_text(
        text.replace(section, f'{section}crs = "EPSG:25833"\n'), encoding="utf-8"
    )
    output = ("--output", tmp_path / "out")
    for command in (("check", folder), ("densify", folder, *output)):
        refused = invoke(*command)
        assert refused.exit_code == 2
        said = refused.stdout + refused.stderr
        assert "ETRS89 / UTM zone 33N (EPSG:25833) to MGI / Austria GK" in said
        assert "MGI to ETRS89 (8) (0.14 m, needs at_bev_AT_GIS_GRID_2021_0" in said
        assert "set crs_accuracy_m = 1" in said
    allowed = ("--crs-accuracy-m", "2")
    noted = invoke("check", folder, *allowed)
    assert noted.exit_code == 0
    assert "by Inverse of MGI to ETRS89" in noted.stdout
    done = invoke("densify", folder, *output, *allowed)
    assert done.exit_code == 0
    points = pd.read_csv(tmp_path / "out" / "points.csv")
    assert points["standard_error_total"].min() > 0.99
    sources = pd.read_csv(tmp_path / "out" / "error_sources.csv")
    assert set(sources["standard_error_reference_system"].round(6)) <= {1.0, 1.5}
    nowhere = invoke("check", folder, "--grids", tmp_path / "nowhere")
    assert nowhere.exit_code == 2
    assert "is no folder" in nowhere.stdout
    # from where the user stands, not from the folder of the block
    (tmp_path / "mine").mkdir()
    monkeypatch.chdir(tmp_path)
    assert "is missing" in invoke("check", folder, "--grids", "mine").stdout


def test_a_system_for_the_results_that_cannot_be_reached_is_a_problem(
    invoke, block_folder
):
    shown = invoke("check", block_folder, "--output-crs", "EPSG:25833")
    assert shown.exit_code == 2
    assert "no operation is good enough" in shown.output
    shown = invoke("check", block_folder, "--output-crs", "EPSG:31287")
    assert shown.exit_code == 0
    assert "MGI / Austria Lambert (EPSG:31287)" in shown.output


def test_check_explains_without_a_block(invoke):
    shown = invoke("check", "--explain", "Hochwert")
    assert (shown.exit_code, shown.stdout[:18]) == (0, "Hochwert: northing")
    assert invoke("check", "--explain", "nothing at all").exit_code == 2
