"""``einschalt batch``."""

import json
import os
import shutil
import signal
import subprocess
import sys
from datetime import UTC, datetime

import pandas as pd
import pytest

from einschalt.interfaces.cli.progress import batch_line
from einschalt.interfaces.cli.work.batch import facts_of_block
from einschalt.interfaces.files.folder_lock import locked
from einschalt.pipeline.batch.block_table import blocks_table


@pytest.fixture(scope="module")
def blocks(tmp_path_factory, make_block):
    """Two sound blocks and one without a table."""
    folder = tmp_path_factory.mktemp("blocks")
    for name in ("north", "south", "west"):
        make_block(folder / name)
    (folder / "west" / "low_flight.csv").unlink()
    return folder


@pytest.fixture(scope="module")
def first(tmp_path_factory, blocks, spawn):
    """The first run of the command."""
    output = tmp_path_factory.mktemp("results")
    return output, spawn("batch", blocks, "--output", output, "--workers", 1)


@pytest.mark.slow
def test_status_1_where_a_block_failed(first):
    output, done = first
    assert done.returncode == 1
    assert done.stdout.startswith("3 blocks: 2 done, 1 failed (")
    assert "west: low_flight.csv: the file does not exist" in done.stdout
    assert f"Table of all blocks in {output / 'blocks.csv'}" in done.stdout
    assert "Traceback" not in done.stdout + done.stderr
    assert len(pd.read_csv(output / "blocks.csv")) == 3


@pytest.fixture(scope="module")
def failed_block(invoke, make_block, tmp_path_factory):
    """A batch of one block with two values that are no numbers, told as JSON."""
    folder = tmp_path_factory.mktemp("failed")
    make_block(folder / "blocks" / "north")
    file = folder / "blocks" / "north" / "low_flight.csv"
    lines = file.read_text("utf-8").splitlines()
    for row in (12, 14):
        lines[row - 1] = lines[row - 1].rpartition(",")[0] + ",n/a"
    file.write_text("\n".join(lines) + "\n", "utf-8")
    output = folder / "out"
    call = ("batch", folder / "blocks", "-o", output, "--workers", 1, "--json")
    return output, json.loads(invoke(*call).stdout)


@pytest.mark.slow
def test_json_names_block_file_and_row_of_each_fault(failed_block):
    _, outcome = failed_block
    assert outcome["status"] == 1
    assert outcome["figures"] == {"failed": 1}
    assert [one["row"] for one in outcome["problems"]] == [12, 14]
    for one in outcome["problems"]:
        assert one["file"] == "north/low_flight.csv"
        assert "'n/a'" in one["found"]
        assert "more problem" not in one["found"]
        assert one["expected"]
        assert one["remedy"]


@pytest.mark.parametrize(
    "spoilt",
    [
        {"facts": "x"},
        {"facts": []},
        {"facts": [{}]},
        {"reason": "of another run"},
        None,
    ],
)
def test_what_nobody_can_read_is_told_by_the_table(failed_block, tmp_path, spoilt):
    output = shutil.copytree(failed_block[0], tmp_path / "out")
    file = output / "north" / "failure.json"
    content = json.loads(file.read_text("utf-8"))
    text = "no JSON" if spoilt is None else json.dumps(content | spoilt)
    file.write_text(text, "utf-8")
    row = {"block": "north", "reason": content["reason"], "remedy": ""}
    (one,) = facts_of_block(row, output / "north")
    assert one == {"found": content["reason"], "remedy": None, "file": "north"}


def test_progress_with_the_expected_end(first):
    _, done = first
    lines = done.stderr.splitlines()
    assert [line.split()[0] for line in lines] == ["1/3", "2/3", "3/3"]
    assert "(ETA " in lines[0]
    assert "until" not in lines[2]


def test_dry_run_says_why_and_writes_nothing(first, invoke, blocks, tmp_path):
    output, _ = first
    before = {path: path.stat().st_mtime_ns for path in output.rglob("*")}
    said = invoke("batch", blocks, "-o", output, "--dry-run")
    assert said.exit_code == 0
    reason = (
        "low_flight.csv: the file does not exist; expected the table of [low_flight] "
        "model_points"
    )
    assert said.stdout.splitlines() == [
        "keep  north: unchanged",
        "keep  south: unchanged",
        f"run   west: no result yet; the last run failed: {reason}",
        "1 of 3 blocks would be computed; nothing was written",
    ]
    assert {path: path.stat().st_mtime_ns for path in output.rglob("*")} == before
    invoke("batch", blocks, "-o", tmp_path / "new", "--dry-run")
    assert not (tmp_path / "new").exists()


def test_status_0_where_nothing_failed(first, invoke, blocks):
    output, _ = first
    said = invoke("batch", blocks / "north", "-o", output, "--quiet")
    assert (said.exit_code, said.stdout, said.stderr) == (0, "", "")


def test_settings_are_options(first, invoke, blocks):
    output, _ = first
    options = ["--coverage-mean", "most_central", "--dry-run"]
    said = invoke("batch", blocks, "-o", output, *options).stdout
    assert "run   north: the settings changed" in said


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--resume", "--all"], "--resume and --all exclude each other"),
        (["--workers", "0"], "workers = 0; expected a whole number from 1 to 1024"),
        (["--memory", "-1"], "--memory = -1; expected a number above 0"),
        (["--memory", "inf"], "--memory = inf; expected a number above 0"),
        (["--significance", "2"], "significance = 2.0"),
        (
            ["--scheduler", "tcp://a:1", "--workers", "2"],
            "workers are given beside a scheduler",
        ),
    ],
)
def test_wrong_calls_end_with_2(invoke, blocks, tmp_path, options, said):
    shown = invoke("batch", blocks, "-o", tmp_path / "out", *options)
    assert shown.exit_code == 2
    assert said in shown.stderr
    assert not (tmp_path / "out" / "blocks.csv").exists()


@pytest.mark.usefixtures("in_this_process")
def test_quiet_tells_of_blocks_that_failed_and_of_nothing_else(first, invoke, blocks):
    output, _ = first
    shown = invoke("batch", blocks, "-o", output, "--quiet", "--workers", 1)
    assert shown.exit_code == 1
    assert not shown.stdout
    assert "west: low_flight.csv: the file does not exist" in shown.stderr
    shown = invoke("batch", blocks / "north", "-o", output, "--quiet")
    assert shown.exit_code == 0
    assert not shown.output


def test_a_plan_that_could_not_be_carried_out_is_none(invoke, blocks):
    shown = invoke("batch", blocks, "-o", blocks / "north/block.toml", "--dry-run")
    assert shown.exit_code == 2
    assert "block.toml: is no folder; expected a folder for the results" in shown.stderr


@pytest.mark.parametrize(
    "call",
    [
        ("batch", "BLOCKS", "--output", ""),
        ("batch", "", "--output", "out"),
        ("densify", "BLOCKS/north", "--output", ""),
        ("simulate", "--preset", "demo", "--output", ""),
        ("transform", "a.csv", "b.csv", "--output", ""),
        ("orient", "a.csv", "--base", "92", "--output", ""),
    ],
)
def test_an_empty_path_is_not_the_present_folder(
    invoke, blocks, tmp_path, monkeypatch, call
):
    """A script says ``--output "$OUT"``, and OUT is not set."""
    monkeypatch.chdir(tmp_path)
    shown = invoke(*(word.replace("BLOCKS", str(blocks)) for word in call))
    assert shown.exit_code == 2
    assert "the path is empty; expected a file or folder" in shown.stderr
    assert not list(tmp_path.iterdir())


def test_no_blocks(invoke, tmp_path):
    shown = invoke("batch", tmp_path, "-o", tmp_path / "out")
    assert shown.exit_code == 2
    assert "the folder holds no block" in shown.stderr


@pytest.mark.slow
@pytest.mark.usefixtures("in_this_process")  # what goes on; what ends is a process
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_an_interruption_ends_with_130_and_is_continued(blocks, tmp_path, invoke):
    call = [sys.executable, "-m", "einschalt", "batch", blocks, "-o", tmp_path]
    (tmp_path / "south").mkdir()
    # the second block waits for the lock of its folder: the batch cannot be quicker
    with locked(tmp_path / "south"):
        done = subprocess.Popen(
            [*call, "--workers", "1"], stderr=subprocess.PIPE, text=True
        )
        assert done.stderr.readline().startswith("1/3  north done")
        done.send_signal(signal.SIGINT)
        _, said = done.communicate()
    assert done.returncode == 130
    assert "interrupted" in said
    assert "Traceback" not in said
    again = invoke("batch", blocks, "-o", tmp_path, "--resume", "--workers", "1")
    assert again.exit_code == 1
    table = pd.read_csv(tmp_path / "blocks.csv")
    assert table["outcome"].tolist() == ["done", "done", "failed"]


def test_line_of_progress():
    from types import SimpleNamespace as News

    row = {"block": "west", "outcome": "failed", "reason": "is gone"}
    line = batch_line(News(row=row, n_done=2, n_all=3, seconds_left=None))
    assert line == "2/3  west failed: is gone"
    now = datetime(2026, 11, 21, 23, 0, 0, tzinfo=UTC)
    for seconds, until in (
        (60.0, "23:01:00"),
        (7200.0, "2026-11-22 01:00"),
        (1e30, None),  # bytes before terabytes: no such date
    ):
        news = News(
            row={**row, "block": "a\nb"}, n_done=2, n_all=3, seconds_left=seconds
        )
        said = f"  (ETA {until})" if until else ""
        assert batch_line(news, now) == f"2/3  a\\nb failed: is gone{said}"


@pytest.mark.parametrize(
    ("outcomes", "claims", "status"),
    [
        (["done", "done"], [True, True], 0),
        (["done", "skipped"], [True, False], 3),
        (["done", "skipped"], [True, None], 0),
        # a failure is told before a claim
        (["failed", "done"], [None, False], 1),
    ],
)
def test_strict_ends_with_3_where_a_claim_does_not_stand(
    invoke, monkeypatch, tmp_path, blocks, outcomes, claims, status
):
    rows = (
        {"block": f"b{k}", "outcome": outcome, "claim_is_supported": claim}
        | {"standard_error_credible": 1.5}
        for k, (outcome, claim) in enumerate(zip(outcomes, claims, strict=True))
    )
    table = blocks_table(rows)
    python_api = "einschalt.interfaces.python_api.densify_many"
    monkeypatch.setattr(python_api, lambda *_args, **_options: table)
    done = invoke("batch", blocks, "-o", tmp_path / "out", "--strict")
    assert done.exit_code == status
    is_untested = ("done", None) in set(zip(outcomes, claims, strict=True)) or (
        ("skipped", None) in set(zip(outcomes, claims, strict=True))
    )
    assert ("not tested: b1" in done.stderr) == is_untested
    is_refuted = False in claims
    assert ("b1: 1.5 m or worse (total)" in done.stdout) == is_refuted
    if status == 3:
        assert invoke("batch", blocks, "-o", tmp_path / "out").exit_code == 0
        quiet = invoke("batch", blocks, "-o", tmp_path / "out", "--strict", "-q")
        assert (quiet.exit_code, quiet.stdout) == (3, "")
        assert "b1: 1.5 m or worse (total)" in quiet.stderr
