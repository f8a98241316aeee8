"""``einschalt densify``."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pyogrio
import pytest

from einschalt.interfaces.cli.work import densify as work
from einschalt.interfaces.files.block_writing import write_block
from einschalt.pipeline.settings import Settings, words_of
from einschalt.pipeline.summary.suggestions.catalogue import suggestions_of

pytestmark = pytest.mark.usefixtures("computed_once")

ROOT = Path(__file__).parents[3]
# progress from the first moment, which is none of a second
IMPATIENT = """
from einschalt.interfaces.cli import main, progress
progress.PATIENCE = 0.0
main.run()
"""
FILES = {
    *("points.csv", "models.csv", "residuals.csv", "orientations.csv", "failures.csv"),
    *("points.parquet", "models.parquet", "residuals.parquet"),
    *("orientations.parquet", "block.gpkg", "report.html", "summary.txt"),
    "provenance.json",
}


@pytest.mark.parametrize("is_to_spare", [True, False])
def test_freed_memory_is_kept_where_there_is_enough(
    invoke, block_folder, tmp_path, monkeypatch, is_to_spare
):
    kept = []
    monkeypatch.setattr(work, "keep_freed_memory", lambda: kept.append(1))
    monkeypatch.setattr(work, "has_memory_to_spare", lambda _block: is_to_spare)
    done = invoke("densify", block_folder, "-o", tmp_path / "out", "--no-report")
    assert done.exit_code == 0
    assert len(kept) == is_to_spare


@pytest.mark.parametrize("command", ["densify", "batch"])
@pytest.mark.parametrize("name", Settings.model_fields)
def test_every_setting_is_an_option_with_its_words_and_its_help(invoke, command, name):
    shown = " ".join(invoke(command, "--help").output.split())
    option = f"--{name.replace('_', '-')} <{'|'.join(words_of(name))}"
    assert option in shown
    assert f"> {Settings.model_fields[name].description} [default: (that of" in shown


def test_the_former_word_of_a_method_is_understood(invoke, block_folder, tmp_path):
    options = ["--output", tmp_path, "--quiet", "--method"]
    shown = invoke("densify", block_folder, *options, "pipeline")
    assert shown.exit_code == 0
    assert shown.stderr == "einschalt: method pipeline is now called two_step\n"
    provenance = (tmp_path / "provenance.json").read_text(encoding="utf-8")
    assert '"method": "two_step"' in provenance
    shown = invoke("densify", block_folder, *options, "one_step")
    assert shown.exit_code == 2
    said = "--method = 'one_step'; expected two_step, simultaneous or auto."
    assert said in " ".join(shown.stderr.split())


@pytest.mark.slow
def test_results_are_written_and_said(block_folder, tmp_path):
    output = tmp_path / "out"
    words = ("densify", block_folder, "--output", output)
    done = subprocess.run(
        [sys.executable, "-c", IMPATIENT, *map(str, words)],
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    assert done.returncode == 0
    assert {path.name for path in output.iterdir()} >= FILES
    assert done.stdout.startswith("Demo (simulated): 77 new points, ")
    assert f"Results in {output}, report in {output / 'report.html'}" in done.stdout
    # progress is no part of the answer
    assert "model transformation" in done.stderr
    assert "model transformation" not in done.stdout
    assert "\x1b" not in done.stdout + done.stderr
    parts = [int(part) for part in re.findall(r"^ *(\d+)%", done.stderr, re.MULTILINE)]
    assert parts == sorted(parts)
    assert parts.count(100) == 1  # when its results are written
    assert done.stderr.splitlines()[-1] == "100%  done"


def test_summary_is_the_file_summary(invoke, block_folder, tmp_path):
    shown = invoke("densify", block_folder, "--output", tmp_path)
    written = (tmp_path / "summary.txt").read_text(encoding="utf-8")
    assert written.strip() in shown.stdout


@pytest.mark.parametrize(
    ("deformation", "is_said"), [("tested", True), ("ignored", False)]
)
def test_deformation_of_the_models_is_an_option(
    invoke, block_folder, tmp_path, deformation, is_said
):
    options = ["--method", "simultaneous", "--model-deformation", deformation]
    shown = invoke("densify", block_folder, "--output", tmp_path, *options)
    assert shown.exit_code == 0
    title = "Deformation common to the models of a flight"
    assert (title in shown.stdout) == is_said
    assert (title in (tmp_path / "report.html").read_text("utf-8")) == is_said


def test_an_unknown_deformation_is_refused(invoke, block_folder, tmp_path):
    options = ["--method", "simultaneous", "--model-deformation", "bent"]
    shown = invoke("densify", block_folder, "--output", tmp_path, *options)
    assert shown.exit_code == 2
    said = "--model-deformation = 'bent'; expected modelled, tested or ignored."
    assert said in " ".join(shown.stderr.split())


def test_quiet_prints_nothing(invoke, block_folder, tmp_path):
    shown = invoke("densify", block_folder, "--output", tmp_path, "--quiet")
    assert (shown.exit_code, shown.stdout, shown.stderr) == (0, "", "")
    assert (tmp_path / "points.csv").exists()


def test_everything_but_the_report_is_written(invoke, block_folder, tmp_path):
    assert invoke("densify", block_folder, "-o", tmp_path, "-q").exit_code == 0
    shown = invoke("densify", block_folder, "-o", tmp_path, "--no-report")
    assert shown.stdout.endswith(f"Results in {tmp_path}\n")
    # nor does that of the run before stay
    assert {path.name for path in tmp_path.iterdir()} >= FILES - {"report.html"}
    assert not (tmp_path / "report.html").exists()


def test_a_print_of_no_report_is_refused_before_the_work(
    invoke, block_folder, tmp_path
):
    options = ["--no-report", "--pdf", "a4"]
    shown = invoke("densify", block_folder, "-o", tmp_path / "out", *options)
    assert (shown.exit_code, shown.stdout) == (2, "")
    assert "a PDF of the report is asked for, and no report" in shown.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_options_go_before_the_settings_of_the_block(invoke, block_folder, tmp_path):
    folder = tmp_path / "block"
    shutil.copytree(block_folder, folder)
    with (folder / "block.toml").open("a", encoding="utf-8") as file:
        file.write('\n[settings]\ncoverage_mean = "most_central"\n')
    said = invoke("densify", folder, "-o", tmp_path / "a").stdout
    assert "Settings: coverage_mean = most_central, others default." in said
    options = ["--coverage-mean", "all", "--weighting", "weighted"]
    said = invoke("densify", folder, "-o", tmp_path / "b", *options).stdout
    assert "Settings: weighting = weighted, others default." in said


@pytest.mark.slow
def test_outliers_and_significance_are_options(invoke, block_folder, tmp_path):
    options = ["--outliers", "snoop", "--significance", "0.01"]
    said = invoke("densify", block_folder, "-o", tmp_path, *options).stdout
    assert "outliers = snoop, significance = 0.01" in " ".join(said.split())
    header = (tmp_path / "residuals.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header.endswith("leverage,redundancy_number,w,p_value,is_suspect")


@pytest.mark.slow
def test_failed_models_are_said_and_the_status_is_0(invoke, block_folder, tmp_path):
    folder = tmp_path / "block"
    shutil.copytree(block_folder, folder)
    points = pd.read_csv(folder / "low_flight.csv", dtype={"coverage": str})
    keys = ["coverage", "model_id"]
    first = (points[keys] == points.loc[0, keys]).all(axis=1)
    points = points[~first | (points.index < 2)]
    points.to_csv(folder / "low_flight.csv", index=False)
    shown = invoke("densify", folder, "--output", tmp_path / "out")
    assert shown.exit_code == 0
    assert "; 1 of 30 models failed" in shown.stdout
    assert len(pd.read_csv(tmp_path / "out" / "failures.csv")) == 1


@pytest.mark.slow
def test_a_user_error_is_a_message_without_traceback(spawn, spoilt_folder, tmp_path):
    done = spawn("densify", spoilt_folder, "--output", tmp_path / "out")
    assert done.returncode == 2
    assert done.stdout == ""
    assert "low_flight.csv, row 5" in done.stderr
    assert "'n/a' is not a number" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_missing_block_is_said(invoke, tmp_path):
    shown = invoke("densify", tmp_path / "nowhere", "--output", tmp_path)
    assert shown.exit_code == 2
    assert "nowhere: there is no such folder or file" in shown.stderr


def test_an_output_that_is_a_file_is_said(invoke, block_folder, tmp_path):
    file = tmp_path / "taken"
    file.write_text("x", encoding="utf-8")
    shown = invoke("densify", block_folder, "--output", file, "--quiet")
    assert shown.exit_code == 2
    assert "taken" in shown.stderr
    assert "Traceback" not in shown.stderr


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_an_interruption_ends_with_130(tmp_path):
    # a block that takes long enough to be interrupted
    block = ROOT / "data_examples" / "neukirchen"
    for _ in range(10):
        done = subprocess.Popen(
            [sys.executable, "-m", "einschalt", "densify", block, "-o", tmp_path],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        # the first line of progress: the command is at work
        assert done.stderr.readline()
        done.send_signal(signal.SIGINT)
        _, said = done.communicate()
        if done.returncode != 0:  # on a busy computer it may have been quicker
            break
    assert done.returncode == 130
    assert "interrupted" in said
    assert "Traceback" not in said


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="needs a shell with pipes")
def test_a_reader_that_goes_away_is_no_fault(small_block, tmp_path):
    folders = f'"{small_block.path}" -o "{tmp_path / "out"}"'
    call = f'"{sys.executable}" -m einschalt densify {folders}'
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", f"{call} | true"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0
    assert "Broken" not in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_a_console_without_the_characters_does_not_stop_a_run(
    spawn, block_folder, tmp_path
):
    environment = {**os.environ, "PYTHONIOENCODING": "latin-1"}
    call = ("densify", block_folder, "-o", tmp_path)
    done = spawn(*call, env=environment, encoding="latin-1")
    assert done.returncode == 0
    assert "?(?_E² + ?_N²)" in done.stdout


@pytest.mark.slow
def test_a_tolerance_is_an_option_and_stands_in_the_tables(
    invoke, block_folder, tmp_path
):
    call = ("densify", block_folder, "-o", tmp_path, "--tolerance")
    said = invoke(*call, "vermv_1994").stdout
    assert "Tolerance 7.0 cm (total; VermV 1994 § 7, densification points)" in said
    for points in (
        pd.read_csv(tmp_path / "points.csv"),
        pd.read_parquet(tmp_path / "points.parquet"),
        pyogrio.read_arrow(tmp_path / "block.gpkg", layer="points")[1].to_pandas(),
    ):
        is_suspect = points["is_suspect"].astype(bool)
        passes = (points["standard_error_checked"] <= 0.07) & ~is_suspect
        assert points["is_within_tolerance"].astype(bool).tolist() == passes.tolist()
    assert "Tolerance 7.0 cm" in (tmp_path / "report.html").read_text(encoding="utf-8")
    shown = invoke(*call, "-1")
    assert shown.exit_code == 2
    assert "einschalt: --tolerance = '-1'; expected none, vermv_1994" in shown.stderr


@pytest.fixture
def refuted_folder(tmp_path, block_folder):
    """The demo block with check points that lie two metres off."""
    folder = tmp_path / "refuted"
    shutil.copytree(block_folder, folder)
    file = folder / "control_points.csv"
    control = pd.read_csv(file, dtype={"point_id": str})
    control.loc[control["role"] == "check", "easting"] += 2.0
    control.to_csv(file, index=False)
    return folder


@pytest.mark.slow
def test_strict_ends_with_3_where_the_claim_does_not_stand(
    invoke, block_folder, refuted_folder, tmp_path
):
    output = tmp_path / "out"
    done = invoke("densify", refuted_folder, "-o", output, "--strict", "--quiet")
    assert (done.exit_code, done.stdout) == (3, "")
    assert "or worse" in done.stderr
    assert {path.name for path in output.iterdir()} >= FILES
    assert "or worse" in (output / "summary.txt").read_text(encoding="utf-8")
    points = pd.read_csv(output / "points.csv").set_index("role")
    figure = points.loc["new", "standard_error_checked"]
    assert (figure > 10.0 * points.loc["new", "standard_error_total"]).all()
    again = invoke("densify", refuted_folder, "-o", output, "--quiet")
    assert again.exit_code == 0
    sound = invoke("densify", block_folder, "-o", tmp_path / "b", "--strict", "--quiet")
    assert sound.exit_code == 0


@pytest.mark.slow
def test_what_is_found_is_in_the_object(invoke, faulty_result, tmp_path):
    write_block(faulty_result.block, tmp_path / "block")
    words = ("densify", tmp_path / "block", "--output", tmp_path / "out", "--json")
    shown = invoke(*words)
    assert shown.exit_code == 0
    problems = json.loads(shown.stdout)["problems"]
    told = suggestions_of(faulty_result.assessment.findings)
    assert len(problems) == len(told) > 2
    for problem, suggestion in zip(problems, told, strict=True):
        assert problem["found"].startswith(suggestion.problem)
        assert problem["remedy"] == (suggestion.remedy or None)
