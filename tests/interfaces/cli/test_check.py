"""``einschalt check``."""

from pathlib import Path

from einschalt.interfaces.cli.work import check as work
from einschalt.pipeline.settings import Settings

EXAMPLES = Path(__file__).parents[3] / "data_examples"


def test_a_sound_block_has_nothing_wrong(invoke, block_folder):
    shown = invoke("check", block_folder)
    assert shown.exit_code == 0
    assert shown.stdout.split("\n")[-2] == f"{block_folder}: nothing wrong"


def test_everything_wrong_is_said_at_once_and_can_be_searched(invoke, spoilt_folder):
    done = invoke("check", spoilt_folder)
    assert done.exit_code == 2
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


def test_what_the_command_line_decides_is_judged_as_densify_would(invoke, tmp_path):
    import shutil

    folder = tmp_path / "sxb"
    shutil.copytree(EXAMPLES / "sxb_strasbourg", folder)
    file = folder / "block.toml"
    text = file.read_text(encoding="utf-8")
    assert "method" not in text  # it stands on the command line alone
    shown = invoke("check", folder)
    assert (shown.exit_code, shown.stdout.count("model: models.csv")) == (2, 2)
    shown = invoke("check", folder, "--method", "simultaneous")
    assert (shown.exit_code, shown.stdout.count("model: models.csv")) == (0, 0)
    assert "nothing wrong" in shown.stdout


def test_check_has_every_setting_of_densify(invoke, monkeypatch):
    monkeypatch.setenv("COLUMNS", "300")
    shown = invoke("check", "--help")
    options = {f"--{name.replace('_', '-')}" for name in Settings.model_fields}
    assert {one for one in options if one not in shown.stdout} == set()
