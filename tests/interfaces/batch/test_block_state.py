"""What a batch reads again may have been damaged: it counts as not there."""

import json
import os
import re
from dataclasses import replace

import pytest
from tests.moved_block import moved_block
from tests.ntv2_grids import write_ntv2

from einschalt.interfaces.batch import block_run
from einschalt.interfaces.batch.batch_run import MARKS, plan_batch
from einschalt.interfaces.batch.block_run import run_block
from einschalt.interfaces.batch.block_state import (
    FAILURE,
    PROVENANCE,
    look_at,
    read_failure,
    result_since,
    whole_result,
)
from einschalt.interfaces.files.written_files import sealed_text

SOUND = {
    "inputs": [{"table": "block", "file": "block.toml", "sha256": "0" * 64}],
    "outputs": {},
    "figures": {"n_points": 9, "mean_total": None},
    "seconds": 0.1,
}


@pytest.mark.parametrize(
    "change",
    [
        {"inputs": ["block.toml"]},
        {"inputs": [{"table": "block"}]},
        {"inputs": [{"table": 1, "file": [], "sha256": None}]},
        {"outputs": ["points.csv"]},
        {"outputs": {"/dev/zero": "0" * 64}},
        {"outputs": {"../points.csv": "0" * 64}},
        {"figures": {"n_points": "nine"}},
        {"figures": {"n_points": 1e300}},
        {"figures": {"n_points": 9.5}},
        {"figures": [9]},
        {"seconds": None},
    ],
    ids=str,
)
def test_provenance_that_was_changed_is_no_whole_result(tmp_path, change):
    (tmp_path / PROVENANCE).write_text(json.dumps(SOUND))
    assert whole_result(tmp_path) == SOUND
    (tmp_path / PROVENANCE).write_text(json.dumps({**SOUND, **change}))
    assert whole_result(tmp_path) is None


@pytest.mark.parametrize("text", ["[" * 10_000, '"text"', "{", "9" * 5000, "\udcff"])
def test_what_is_no_json_of_ours(tmp_path, text):
    for name in (PROVENANCE, FAILURE):
        (tmp_path / name).write_bytes(text.encode("utf-8", "surrogateescape"))
    assert whole_result(tmp_path) is None
    assert read_failure(tmp_path) is None


def test_marks_that_were_changed_are_none(small_block, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / MARKS).write_text('{"blocks": ["nine_points"]}')
    assert not plan_batch([small_block.path], out).is_continued
    (out / MARKS).write_text('{"blocks": {"nine_points": 7}}')
    assert plan_batch([small_block.path], out).is_continued


def test_failure_without_a_reason_is_none(tmp_path):
    failure = {"stage": "reading", "reason": "it is gone", "remedy": ""}
    (tmp_path / FAILURE).write_text(json.dumps(failure))
    assert read_failure(tmp_path) == failure
    (tmp_path / FAILURE).write_text(json.dumps({**failure, "reason": {}}))
    assert read_failure(tmp_path) is None


@pytest.mark.skipif(os.name == "nt", reason="devices of POSIX")
@pytest.mark.parametrize("file", ["/dev/zero", "a" * 5000, "a\\u0000b", ".", "pipe"])
def test_a_block_that_names_what_never_ends_is_looked_at(small_block, tmp_path, file):
    """A checksum of /dev/zero would be waited for for ever, with all other blocks."""
    os.mkfifo(small_block.path / "pipe")
    small_block.replace("block.toml", '"low_flight.csv"', f'"{file}"')
    state = look_at("block", small_block.path, tmp_path / "out")
    assert state.task.signature["inputs"]["low_flight.model_points"] is None
    assert state.why == "no result yet"


@pytest.mark.slow
def test_a_result_whose_worker_was_killed_is_taken_for_the_one_asked_for(
    small_block, tmp_path, monkeypatch
):
    folder = tmp_path / "out"
    task = look_at("a", small_block.path, folder).task
    row = run_block(task)
    # the worker had not come to take it away
    (folder / FAILURE).write_text(sealed_text({}))
    with monkeypatch.context() as patch:
        patch.setattr(block_run, "densify", None)
        again = run_block(task)
    assert again == row
    assert row["outcome"] == "done"
    assert not (folder / FAILURE).exists()
    assert not (folder / "changes.csv").exists()


@pytest.mark.slow
def test_a_result_of_before_is_computed_again_where_it_is_asked_for(
    small_block, tmp_path
):
    folder = tmp_path / "out"
    run_block(look_at("a", small_block.path, folder).task)
    task = look_at("a", small_block.path, folder).task
    assert result_since(task) is None
    run_block(task)
    assert (folder / "changes.csv").exists()
    # and a newer one of other input is none
    small_block.replace("low_flight.csv", ",10.0000,", ",10.0010,", count=1)
    assert result_since(replace(task, former=None)) is None


@pytest.mark.slow
def test_results_in_another_system_are_not_compared(small_block, tmp_path):
    folder = tmp_path / "out"
    for crs in ('crs = "EPSG:31255"', 'crs = "EPSG:31256"'):
        toml = re.sub(r"(?m)^crs = .*\n", "", small_block.read("block.toml"))
        small_block.write("block.toml", toml.replace("[block]", f"[block]\n{crs}"))
        row = run_block(look_at("a", small_block.path, folder).task)
        assert row["outcome"] == "done", row
    assert "that was in EPSG:31255, this one is in EPSG:31256" in row["reason"]
    assert "n_moved" not in row
    assert not (folder / "changes.csv").exists()


@pytest.mark.slow
def test_a_block_whose_grid_changed_is_computed_again(small_block, tmp_path):
    settings = 'grids = "grids"\ncrs_accuracy_m = 2.0'
    lucerne = (8.0, 47.0)
    moved_block(small_block, "EPSG:25832", lucerne, "EPSG:21781", settings=settings)
    grids, grid = small_block.path / "grids", "ch_swisstopo_CHENyx06_ETRS.tif"
    grids.mkdir()
    folder = tmp_path / "out"

    def look():
        return look_at("a", small_block.path, folder)

    assert run_block(look().task)["outcome"] == "done"  # by seven parameters
    assert look().why == ""
    for east_shift in (-3.5, -3.6):  # it comes, and is written anew
        write_ntv2(grids / grid, -1.5, east_shift)
        assert look().why == f"{grid} changed"
        assert run_block(look().task)["outcome"] == "done"
        assert look().why == ""
    (grids / "readme.txt").write_text("from the national survey")
    assert look().why == ""
    (grids / grid).unlink()
    assert look().why == f"{grid} changed"
