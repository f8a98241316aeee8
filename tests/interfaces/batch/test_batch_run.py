"""Batches of small blocks: what is computed, what is skipped, what the table says."""

import json
import os
import shutil
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.changed_results import Stopped

import einschalt as es
from einschalt.foundations.errors import FileError, SettingsError
from einschalt.interfaces import python_api
from einschalt.interfaces.batch import batch_run, block_run, block_search, block_task
from einschalt.interfaces.batch.batch_run import batch_folder, plan_batch, run_batch
from einschalt.interfaces.batch.block_run import run_block
from einschalt.interfaces.batch.block_state import look_at
from einschalt.interfaces.files import atomic
from einschalt.pipeline.batch.local_engine import Answer, EngineError
from einschalt.pipeline.densify import densify

N_SOUND = 2
FILES_OF_A_RESULT = {"points.csv", "points.parquet", "report.html", "provenance.json"}


class HereEngine:
    """Runs tasks in this process, so that tests need not wait for others to start."""

    def __init__(self, until=None, error=KeyboardInterrupt):
        self.until = until
        self.error = error
        self.names = []

    def answers(self, function, tasks):
        for place, task in enumerate(tasks):
            if place == self.until:
                raise self.error
            self.names.append(task.name)
            yield Answer(place, function(task))


@pytest.fixture
def run(monkeypatch, memory):
    """Run a batch in this process; gives the table and the names of what was run.

    Reports and maps, which take most of the time, are left to the runs of workers, and
    that the same block gives the same numbers is shown there.
    """
    monkeypatch.setattr("einschalt.interfaces.batch.block_run.densify", memory.densify)
    folder_of_results = "einschalt.interfaces.files.result_folder"
    monkeypatch.setattr(f"{folder_of_results}.render", lambda _result: "report")
    monkeypatch.setattr(
        f"{folder_of_results}.write_geopackage",
        lambda _result, path, **_options: atomic.write_text(
            path, "map of the result" * 100
        ),
    )

    def call(folder, output, engine=None, **options):
        from einschalt.interfaces.batch.block_search import find_blocks

        engine = engine or HereEngine()
        with batch_folder(output) as made:
            plan = plan_batch(find_blocks(folder, output), made, **options)
            table = run_batch(plan, engine)
        return table.set_index("block"), engine.names

    return call


@pytest.fixture(scope="module")
def mixed(tmp_path_factory, make_blocks, breakages):
    """Sound blocks and ten broken ones, run once with two processes."""
    root = tmp_path_factory.mktemp("mixed")
    make_blocks(root / "blocks", N_SOUND, breakages)
    table = es.densify_many(root / "blocks", root / "out", workers=2)
    # later runs in this folder add what they compare with the run before
    shutil.copytree(root / "out", root / "first_out")
    return root, table.set_index("block")


@pytest.mark.slow
def test_sound_blocks_are_done_and_have_their_files(mixed):
    root, table = mixed
    done = table[table["outcome"] == "done"]
    assert list(done.index) == [f"block_{k:02d}" for k in range(N_SOUND)]
    for name in done.index:
        names = {path.name for path in (root / "out" / name).iterdir()}
        assert names >= FILES_OF_A_RESULT
        assert "failure.json" not in names


def test_figures_are_those_of_the_block_alone(mixed):
    root, table = mixed
    result = es.densify(es.read_block(root / "blocks" / "block_01"))
    new = result.points[result.points["role"] == "new"]
    row = table.loc["block_01"]
    assert row["n_points"] == len(result.points) == 9
    for kind in ("total", "paper", "internal"):
        name = f"standard_error_{kind}"
        assert row[name] == pytest.approx(np.sqrt(np.mean(new[name] ** 2)), rel=1e-12)
    assert (row["n_suspects"], row["n_failed_models"]) == (0, 0)


@pytest.mark.slow
@pytest.mark.usefixtures("in_this_process")
def test_a_batch_computes_no_method_that_nobody_asked_for(tmp_path, good_result):
    es.simulate_block("demo", seed=1).write(tmp_path / "blocks" / "demo")
    es.densify_many(tmp_path / "blocks", tmp_path / "out", workers=1)
    told = json.loads((tmp_path / "out" / "demo" / "assessment.json").read_text())
    assert told["is_untried"] is True
    assert told["better"] is None
    assert good_result.assessment.better is not None


def test_every_broken_block_has_its_reason(mixed, breakages):
    root, table = mixed
    for name, (_, stage, reason, remedy) in breakages.items():
        row = table.loc[name]
        assert row["outcome"] == "failed", name
        assert row["stage"] == stage, name
        assert reason in row["reason"], name
        assert remedy in row["remedy"], name
        assert "Traceback" not in row["reason"]
        failure = json.loads((root / "out" / name / "failure.json").read_text("utf-8"))
        assert failure["reason"] == row["reason"]
        assert "traceback" not in failure
        assert not (root / "out" / name / "points.csv").exists()


def test_tables_say_the_same_in_three_formats(mixed):
    root, table = mixed
    written = pd.read_parquet(root / "out" / "blocks.parquet").set_index("block")
    assert list(written.index) == list(table.index)
    for name in table:
        assert written[name].fillna(-1).tolist() == table[name].fillna(-1).tolist()
    read = pd.read_csv(root / "out" / "blocks.csv").set_index("block")
    assert list(read["outcome"]) == list(table["outcome"])
    assert list(read.columns)[:8] == [
        *("outcome", "stage", "reason", "remedy", "n_points", "standard_error_total"),
        *("standard_error_paper", "standard_error_internal"),
    ]
    page = (root / "out" / "blocks.html").read_text(encoding="utf-8")
    assert all(name in page for name in table.index)
    assert 'href="block_00/report.html"' in page


def test_nothing_hidden_is_left(mixed):
    root, _ = mixed
    assert not [p for p in (root / "out").rglob("*") if p.name.startswith(".")]


def test_second_run_skips_what_is_unchanged_and_tries_failures_again(
    mixed, run, breakages
):
    root, first = mixed
    table, names = run(root / "blocks", root / "out")
    assert set(names) == set(breakages)
    skipped = table[table["outcome"] == "skipped"]
    assert list(skipped["reason"]) == ["unchanged"] * N_SOUND
    columns = ["n_points", "standard_error_total", "standard_error_paper"]
    same = (skipped[columns] == first.loc[skipped.index, columns]).all().all()
    assert same
    assert (table.loc[list(breakages), "outcome"] == "failed").all()


BROKEN = ["no_number"]


@pytest.fixture
def folder(tmp_path, make_blocks):
    return make_blocks(tmp_path / "blocks", 2, BROKEN)


@pytest.fixture(scope="module")
def kept():
    """What a first run of such a folder has left, once there was one."""
    return []


@pytest.fixture
def first_run(kept, run, make_blocks, tmp_path_factory):
    """Put into a folder what the first run of the blocks leaves: files tell no path."""

    def call(out):
        if not kept:
            root = tmp_path_factory.mktemp("first")
            run(make_blocks(root / "blocks", 2, BROKEN), root / "out")
            kept.append(root / "out")
        shutil.copytree(kept[0], out)

    return call


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "old", "new", "why"),
    [
        ("control_points.csv", "13000.00", "13000.20", "control_points.csv changed"),
        ("low_flight.csv", "20.0000", "20.0001", "low_flight.csv changed"),
        ("block.toml", "5.0", "6.0", "block.toml changed"),
    ],
)
def test_exactly_the_block_whose_input_changed_runs(
    folder, tmp_path, run, first_run, file, old, new, why
):
    first_run(tmp_path / "out")
    path = folder / "block_01" / file
    path.write_text(path.read_text("utf-8").replace(old, new, 1), encoding="utf-8")
    plan = plan_batch([folder / "block_00", folder / "block_01"], tmp_path / "out")
    assert plan.reasons == {"block_01": why}
    table, names = run(folder, tmp_path / "out")
    assert names == ["block_01", "no_number"]
    assert list(table["outcome"]) == ["skipped", "done", "failed"]


def test_a_touched_file_is_no_changed_file(folder, tmp_path, run, first_run):
    """A clock that jumps spoils nothing either: times play no part."""
    first_run(tmp_path / "out")
    for path in (folder / "block_00").iterdir():
        os.utime(path, (4e9, 4e9))
    for path in (tmp_path / "out" / "block_01").iterdir():
        os.utime(path, (0, 0))
    assert run(folder, tmp_path / "out")[1] == ["no_number"]


@pytest.mark.slow
def test_clock_that_jumps_while_a_batch_runs(folder, tmp_path, run, monkeypatch, left):
    run(folder, tmp_path / "calm")
    jumps = iter([10**6 * (-1) ** k for k in range(10**6)])
    honest = time.time
    monkeypatch.setattr(time, "time", lambda: honest() + next(jumps))
    run(folder, tmp_path / "jumping")
    assert left(tmp_path / "jumping") == left(tmp_path / "calm")


@pytest.mark.slow
def test_settings_and_version_count(folder, tmp_path, run, first_run, monkeypatch):
    out = tmp_path / "out"
    first_run(out)
    given = {"coverage_mean": "most_central"}
    assert set(run(folder, out, given=given)[1]) == {
        "block_00",
        "block_01",
        "no_number",
    }
    assert run(folder, out, given=given)[1] == ["no_number"]
    monkeypatch.setattr(
        "einschalt.interfaces.batch.block_task.metadata.version", lambda _: "99.0"
    )
    plan = plan_batch([folder / "block_00"], out, given=given)
    assert plan.reasons["block_00"].startswith("computed by version 0.")


@pytest.mark.parametrize("changed", ["numpy", "EPSG", "PROJ-data"])
def test_libraries_and_data_of_proj_count(folder, tmp_path, run, first_run, changed):
    out = tmp_path / "out"
    first_run(out)
    known = block_task.libraries()
    assert known[changed]
    with pytest.MonkeyPatch.context() as patch:
        other = {**known, changed: "0.1"}
        patch.setattr(block_task, "libraries", lambda: other)
        plan = plan_batch([folder / "block_00", folder / "no_number"], out)
    said = f"computed with {changed} {known[changed]}, not 0.1"
    assert plan.reasons["block_00"] == said
    assert "no_number" in plan.reasons
    (row,) = (run_block(task) for task in plan.to_run if task.name == "block_00")
    assert (
        f"has {changed}, version {known[changed]}; expected version 0.1"
        in row["reason"]
    )


def test_results_of_a_former_word_are_not_computed_again(
    folder, tmp_path, run, first_run
):
    """What was called "pipeline" is "two_step": the result is of the same settings."""
    out = tmp_path / "out"
    first_run(out)
    for file in [*out.glob("*/provenance.json"), *out.glob("*/failure.json")]:
        text = file.read_text(encoding="utf-8")
        assert '"method": "two_step"' in text
        former = text.replace('"method": "two_step"', '"method": "pipeline"')
        file.write_text(former, encoding="utf-8")
    plan = plan_batch([folder / "block_00", folder / "no_number"], out)
    assert plan.rows["block_00"]["outcome"] == "skipped"
    broken = look_at("no_number", folder / "no_number", out / "no_number", {})
    assert broken.failure is not None


@pytest.mark.parametrize("name", ["points.csv", "block.gpkg"])
def test_a_result_that_is_not_whole_is_computed_again(
    folder, tmp_path, run, first_run, left, name
):
    out = tmp_path / "out"
    first_run(out)
    before = {
        name: data
        for name, data in left(out / "block_00").items()
        if name not in {"changes.csv", "previous_points.parquet"}
    }
    (out / "block_00" / name).unlink()
    table, names = run(folder, out)
    assert set(names) == {"block_00", "no_number"}
    assert table.loc["block_00", "outcome"] == "done"
    assert left(out / "block_00") == before


@pytest.mark.parametrize("name", ["points.csv", "assessment.json"])
def test_a_result_that_somebody_changed_is_his(folder, tmp_path, run, first_run, name):
    out = tmp_path / "out"
    first_run(out)
    file = out / "block_00" / name
    file.write_bytes(file.read_bytes()[:100])
    table, names = run(folder, out)
    assert names == ["no_number"]  # nobody waits for what cannot be written
    row = table.loc["block_00"]
    assert row["outcome"] == "failed"
    assert f"{name}, changed since einschalt wrote it" in row["reason"]
    assert file.stat().st_size == 100
    file.unlink()
    assert run(folder, out)[0].loc["block_00", "outcome"] == "done"


def spoil(folder, how):
    """What crashes, full disks, tidy users and other programs do to a result."""
    provenance, package = folder / "provenance.json", folder / "block.gpkg"
    if how == "no provenance":
        provenance.unlink()
    elif how == "cut provenance":
        provenance.write_bytes(provenance.read_bytes()[:100])
    elif how == "half-written":
        provenance.rename(folder / ".einschalt-coming.json")
        (folder / "points.csv").write_bytes(b"point_id,eas")
    elif how == "empty file":
        (folder / "points.csv").write_bytes(b"")
    else:
        package.write_bytes(package.read_bytes() + b"opened")
        (folder / "block.gpkg-wal").write_bytes(b"not of the next one")


SPOILT = ("no provenance", "cut provenance", "half-written", "empty file", "opened")


@pytest.mark.parametrize("how", SPOILT)
def test_a_result_of_the_batch_that_was_spoilt_is_computed_again(
    folder, tmp_path, run, first_run, left, how
):
    out = tmp_path / "out"
    first_run(out)
    before = left(out / "block_00")
    (out / "block_00" / "iterations.csv").write_text("of an older run\n")
    if how in {"empty file", "opened"}:  # nothing but listed files is removed
        (out / "block_00" / "iterations.csv").unlink()
    spoil(out / "block_00", how)
    table, names = run(folder, out)
    assert set(names) == {"block_00", "no_number"}
    assert table.loc["block_00", "outcome"] == "done"
    after = left(out / "block_00")
    assert {name: after[name] for name in before} == before
    assert set(after) - set(before) <= {"changes.csv", "previous_points.parquet"}


@pytest.mark.parametrize("how", SPOILT[:3])
def test_a_file_of_somebody_in_a_half_written_result_is_not_lost(
    folder, tmp_path, run, first_run, how
):
    """Nor one in a folder of which the batch knows nothing."""
    out = tmp_path / "out"
    first_run(out)
    spoil(out / "block_00", how)
    (out / "block_00" / "notes.txt").write_text("the user's own\n")
    spoil(out / "block_01", how)
    (out / "block_01" / "models.csv").unlink()
    (out / "block_01" / "models.csv").symlink_to(folder / "block_01" / "block.toml")
    shutil.copytree(out / "block_00", tmp_path / "other" / "block_00")
    (tmp_path / "other" / "block_00" / "notes.txt").unlink()
    for place, name in ((out, "block_00"), (out, "block_01"), ("other", "block_00")):
        before = sorted((tmp_path / place / name).iterdir())
        table, names = run(folder, tmp_path / place)
        assert name not in names
        assert table.loc[name, "outcome"] == "failed"
        assert before == sorted((tmp_path / place / name).iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["previous_points.parquet", "changes.csv"])
@pytest.mark.parametrize("data", [b"", b"point_id\n\xff", b"PAR1PAR1"])
def test_spoilt_comparison_with_the_run_before_is_none(
    folder, tmp_path, run, first_run, name, data
):
    """It is no part of the result, and costs nobody his block."""
    out = tmp_path / "out"
    first_run(out)
    run(folder, out, which="all")
    assert (out / "block_00" / name).exists()
    (out / "block_00" / name).write_bytes(data)
    table, _ = run(folder, out)
    assert table.loc["block_00", "outcome"] == "skipped"
    (out / "block_00" / "points.csv").unlink()
    table, _ = run(folder, out)
    if data:  # an empty file is nobody's
        assert f"{name}, changed since" in table.loc["block_00", "reason"]
        (out / "block_00" / name).unlink()
        table, _ = run(folder, out)
    assert table.loc["block_00", "outcome"] == "done"
    # a result that is not whole is compared with what was kept before it
    moved = 0 if name == "changes.csv" else None
    assert table["n_moved"].isna()["block_00"] == (moved is None)
    assert (out / "block_00" / "changes.csv").exists() == (moved is not None)


def test_failure_that_was_mended_is_done(folder, tmp_path, run, first_run, left):
    out = tmp_path / "out"
    first_run(out)
    broken, sound = (folder / n / "low_flight.csv" for n in ("no_number", "block_00"))
    shutil.copy(sound, broken)
    table, names = run(folder, out, which="failed")
    assert names == ["no_number"]
    assert table.loc["no_number", ["outcome", "reason"]].tolist() == ["done", ""]
    assert not (out / "no_number" / "failure.json").exists()


def test_a_result_that_was_sound_stays_when_its_block_breaks(
    folder, tmp_path, run, first_run
):
    out = tmp_path / "out"
    first_run(out)
    (folder / "block_00" / "low_flight.csv").unlink()
    table, _ = run(folder, out)
    assert table.loc["block_00", "outcome"] == "failed"
    assert (out / "block_00" / "points.csv").exists()
    note = json.loads((out / "block_00" / "failure.json").read_text("utf-8"))["note"]
    assert "are of an earlier run" in note


def test_only_failed_leaves_the_others(folder, tmp_path, run, first_run):
    out = tmp_path / "out"
    first_run(out)
    (folder / "block_00" / "control_points.csv").write_text("spoilt")
    table, names = run(folder, out, which="failed")
    assert names == ["no_number"]
    said = "only blocks that failed were asked for"
    assert table.loc["block_00", ["outcome", "reason"]].tolist() == ["skipped", said]


def test_all_computes_what_is_unchanged(folder, tmp_path, run, first_run):
    first_run(tmp_path / "out")
    assert len(run(folder, tmp_path / "out", which="all")[1]) == 3


@pytest.mark.parametrize("is_listed", [False, True])
def test_a_block_that_cannot_be_read_fails_alone(
    folder, tmp_path, run, first_run, closed, is_listed
):
    """Its row vanished, with status 0, or asked for a report of the program's fault."""
    out = tmp_path / "out"
    first_run(out)
    closed(folder / "block_00", is_listed=is_listed)
    plan = plan_batch(block_search.find_blocks(folder, out), out)
    assert "block_00" in plan.reasons
    table, _ = run(folder, out)
    row = table.loc["block_00"]
    assert row["outcome"] == "failed"
    said = f"{folder / 'block_00'}: cannot be read: permission denied"
    assert row["reason"] == said
    assert row["remedy"] == "See to the permissions of the folder"
    assert table.loc["block_01", "outcome"] == "skipped"
    assert (out / "block_00" / "points.csv").exists()


def test_a_block_file_that_is_a_folder_fails_alone(folder, tmp_path, run):
    (folder / "f" / "block.toml").mkdir(parents=True)
    row = run(folder, tmp_path / "out")[0].loc["f"]
    assert row["outcome"] == "failed"
    assert row["reason"] == "block.toml: is a folder; expected a file"
    assert row["remedy"] == "Rename that folder, or remove it"


def test_a_block_called_like_the_table_does_not_stop_the_others(folder, tmp_path, run):
    """It ended the whole batch, also where the table of an earlier run is there."""
    shutil.copytree(folder / "block_00", folder / "blocks.csv")
    for outcome in ("done", "skipped"):
        table, names = run(folder, tmp_path / "out")
        assert table.loc["block_00", "outcome"] == outcome
        row = table.loc["blocks.csv"]
        assert row[["outcome", "remedy"]].tolist() == ["failed", "Rename the folder"]
        assert "blocks.csv" not in names
    assert (tmp_path / "out" / "blocks.csv").is_file()


def test_blocks_that_differ_in_case_only_do_not_stop_the_others(folder, tmp_path, run):
    if (folder / "BLOCK_00").exists():
        pytest.skip("names that differ in case only are one name here")
    for name in ("good", "Good"):
        shutil.copytree(folder / "block_00", folder / name)
    table, names = run(folder, tmp_path / "out")
    assert table.loc[["good", "Good"], "outcome"].tolist() == ["failed"] * 2
    said = f"the blocks {folder / 'Good'} and {folder / 'good'} differ in case only"
    assert said in table.loc["good", "reason"]
    assert table.loc["good", "remedy"] == "Rename one of the folders"
    assert table.loc["block_00", "outcome"] == "done"
    assert not {"good", "Good"} & {*names}
    assert not (tmp_path / "out" / "good").exists()


@pytest.mark.slow
def test_points_that_moved_are_listed(folder, tmp_path, run, first_run):
    """A control point corrected by 20 m takes the points near it along."""
    out = tmp_path / "out"
    first_run(out)
    before = pd.read_parquet(out / "block_01" / "points.parquet")
    path = folder / "block_01" / "control_points.csv"
    text = path.read_text("utf-8")
    path.write_text(text.replace("13000.00", "12980.00", 1), encoding="utf-8")
    table, _ = run(folder, out)
    after = pd.read_parquet(out / "block_01" / "points.parquet")
    both = after.merge(before, on="point_id", suffixes=("", "_before"))
    move = np.hypot(
        both["easting"] - both["easting_before"],
        both["northing"] - both["northing_before"],
    )
    claimed = both["standard_error_total"].fillna(both["standard_error_paper"])
    moved = both.loc[move > claimed, "point_id"]
    assert len(moved)
    changes = pd.read_csv(out / "block_01" / "changes.csv", dtype={"point_id": str})
    assert set(changes["point_id"]) == set(moved)
    row = table.loc["block_01"]
    assert row["n_moved"] == len(moved)
    assert row["largest_move"] == pytest.approx(move.max(), abs=1e-4)
    assert pd.isna(table.loc["block_00", "n_moved"])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("which", "until", "error"),
    [
        ("changed", 0, KeyboardInterrupt),
        ("changed", 1, EngineError("it is gone")),
        ("unfinished", 1, KeyboardInterrupt),
        ("unfinished", 2, EngineError("it is gone")),
    ],
)
def test_interrupted_run_is_continued(
    folder, tmp_path, run, first_run, left, which, until, error
):
    """Whatever was changed before, and wherever it was interrupted."""
    ends = {}
    for how in ("calm", "interrupted"):
        out = tmp_path / how
        first_run(out)
        path = folder / "block_01" / "control_points.csv"
        text = path.read_text("utf-8")
        path.write_text(text.replace("13000.00", "12980.00", 1), encoding="utf-8")
        toml = folder / "block_00" / "block.toml"
        toml_text = toml.read_text("utf-8")
        toml.write_text(f"{toml_text}\n# seen\n", encoding="utf-8")
        if how == "interrupted":
            with pytest.raises((KeyboardInterrupt, EngineError)):
                run(folder, out, HereEngine(until, error))
            table, names = run(folder, out, which=which)
        else:
            table, names = run(folder, out)
        ends[how] = left(out)
        path.write_text(text, encoding="utf-8")
        toml.write_text(toml_text, encoding="utf-8")
    assert ends["interrupted"] == ends["calm"]
    assert list(table["outcome"]) == ["done", "done", "failed"]
    # the largest first; what failed is tried again unless the run is resumed
    ran = ["block_00", "block_01"][until:] + ["no_number"] * (which == "changed")
    assert names == ran


@pytest.mark.slow
def test_interruption_of_a_run_of_all_is_resumed_where_it_was(
    folder, tmp_path, run, first_run, monkeypatch
):
    """Also where both computations took the same time, within the same second."""

    def always_as_fast(*args, **options):
        return replace(densify(*args, **options), stopwatch=Stopped(0.125))

    monkeypatch.setattr("einschalt.interfaces.batch.block_run.densify", always_as_fast)
    out = tmp_path / "out"
    first_run(out)
    with pytest.raises(KeyboardInterrupt):
        run(folder, out, HereEngine(until=1), which="all")
    table, names = run(folder, out, which="unfinished")
    assert names == ["block_01"]
    assert list(table["outcome"]) == ["done", "done", "failed"]


def test_what_is_there_is_said_when_a_run_is_interrupted(folder, tmp_path, run):
    with pytest.raises(KeyboardInterrupt):
        run(folder, tmp_path / "out", HereEngine(until=1))
    assert len(pd.read_csv(tmp_path / "out" / "blocks.csv")) == 1


def test_two_batches_in_one_folder(folder, tmp_path, run):
    # a thread of its own: one that has the folder may enter it again
    with (
        ThreadPoolExecutor(1) as other,
        batch_folder(tmp_path / "out"),
        pytest.raises(FileError, match=r"another run writes.*; process .*Wait until"),
    ):
        other.submit(run, folder, tmp_path / "out").result()
    run(folder, tmp_path / "out")


def test_results_do_not_fall_among_the_blocks(folder, tmp_path, run):
    with pytest.raises(FileError, match="the results would fall among the blocks"):
        run(folder, folder)
    with pytest.raises(FileError, match="the folder holds a block, whose tables would"):
        run(folder, folder / "block_00")


def test_results_below_the_blocks_are_no_blocks(folder, run):
    run(folder, folder / "results")
    assert run(folder, folder / "results")[1] == ["no_number"]


def test_unknown_choice(folder, tmp_path):
    with pytest.raises(
        SettingsError, match="which = 'some'; expected changed or unfin"
    ):
        plan_batch([folder / "block_00"], tmp_path, which="some")
    with pytest.raises(SettingsError, match=r"\[settings\] coverage_mean = 'few'"):
        es.densify_many([folder], tmp_path, settings={"coverage_mean": "few"})


def test_given_folders_that_hold_no_block_are_rows(folder, tmp_path, in_this_process):
    (tmp_path / "empty").mkdir()
    table = es.densify_many([tmp_path / "empty"], tmp_path / "out")
    assert table["outcome"].tolist() == ["failed"]
    assert "the folder holds no block.toml" in table["reason"][0]


def test_other_version_on_a_worker_is_said(folder, tmp_path, run, monkeypatch):
    plan = plan_batch([folder / "block_00"], tmp_path / "out")
    monkeypatch.setattr(
        "einschalt.interfaces.batch.block_run.metadata.version", lambda _: "99.0"
    )
    with batch_folder(tmp_path / "out"):
        table = run_batch(plan, HereEngine())
    assert (
        "the worker has einschalt, version 99.0; expected version 0."
        in table["reason"][0]
    )
    assert table["remedy"][0] == "Install the same versions everywhere"


def test_fault_of_the_program_is_a_row_with_its_traceback(
    folder, tmp_path, run, monkeypatch
):
    def fail(*_args, **_options):
        return 1 / 0

    monkeypatch.setattr("einschalt.interfaces.batch.block_run.densify", fail)
    table, _ = run(folder, tmp_path / "out")
    row = table.loc["block_00"]
    assert row["reason"] == "ZeroDivisionError: division by zero"
    assert "please report it with failure.json" in row["remedy"]
    kept = (tmp_path / "out" / "block_00" / "failure.json").read_text("utf-8")
    assert "Traceback" in kept


@pytest.mark.usefixtures("run")
def test_expected_end_goes_by_size(folder, tmp_path):
    news = []
    with batch_folder(tmp_path / "out"):
        plan = plan_batch(sorted(folder.iterdir()), tmp_path / "out")
        run_batch(plan, HereEngine(), progress=news.append)
    assert [n.n_done for n in news] == [1, 2, 3]
    assert [n.row["block"] for n in news] == [task.name for task in plan.to_run]
    assert news[0].seconds_left > news[1].seconds_left > news[2].seconds_left == 0.0


def test_marks_of_a_run_are_hidden_and_go(folder, tmp_path, run):
    with pytest.raises(KeyboardInterrupt):
        run(folder, tmp_path / "out", HereEngine(until=1))
    assert (tmp_path / "out" / batch_run.MARKS).exists()
    run(folder, tmp_path / "out")
    assert not (tmp_path / "out" / batch_run.MARKS).exists()


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_same_bytes_for_any_number_of_workers(mixed, left):
    root, _ = mixed  # with two
    es.densify_many(root / "blocks", root / "alone", workers=1)
    assert left(root / "alone") == left(root / "first_out")


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_an_output_that_cannot_be_written_is_said(folder, tmp_path, monkeypatch):
    def refuse(_descriptor):
        raise OSError(30, os.strerror(30))

    monkeypatch.setattr(atomic.os, "fsync", refuse)
    with pytest.raises(FileError, match=r"read-only file system\. Choose a folder"):
        es.densify_many([folder / "block_00"], tmp_path / "out", workers=1)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="bytes as names of POSIX")
def test_names_of_folders_may_be_anything(
    tmp_path, make_block, monkeypatch, engine_here
):
    """Bytes that are no Unicode, what GDAL parts zip archives by, and line ends."""
    names = [os.fsdecode(b"b\xff"), "=cmd|'calc'!A1", "new\nline", "<b>"]
    for name in names:
        make_block(tmp_path / "blocks" / name)
    out = tmp_path / os.fsdecode(b"out\xff")
    table = es.densify_many(tmp_path / "blocks", out, workers=1)
    assert table["outcome"].tolist() == ["done"] * len(names)
    assert sorted(table["block"]) == sorted(["b\\udcff", *names[1:]])
    assert "'=cmd|'calc'!A1,done" in (out / "blocks.csv").read_text("utf-8")
    assert "<b>" not in (out / "blocks.html").read_text("utf-8")
    for name in table["block"]:
        assert (out / name / "block.gpkg").exists()
    (tmp_path / "blocks" / names[0] / "low_flight.csv").unlink()
    monkeypatch.setattr(python_api, "chosen_engine", lambda *_: engine_here)
    again = es.densify_many(tmp_path / "blocks", out, which="changed")
    assert (again["outcome"] == "failed").sum() == 1


@pytest.mark.slow
def test_a_failure_for_which_the_disk_had_no_room_is_one(
    folder, tmp_path, run, monkeypatch
):
    """Only failed blocks are asked for: half a result tells of a failure as well."""
    out = tmp_path / "out"
    with monkeypatch.context() as full:

        def refuse(_descriptor):
            raise OSError(28, os.strerror(28))

        def run_on_a_full_disk(task):
            full.setattr(atomic.os, "fsync", refuse)
            try:
                return block_run.run_block(task)
            finally:
                full.undo()

        full.setattr(batch_run, "run_block", run_on_a_full_disk)
        table, _ = run(folder, out)
    assert table.loc["block_00", "stage"] == "writing"
    assert not (out / "block_00" / "failure.json").exists()
    table, names = run(folder, out, which="failed")
    assert set(names) == {"block_00", "block_01", "no_number"}
    assert table.loc["block_00", "outcome"] == "done"


@pytest.mark.slow
def test_a_block_whose_input_was_being_written_is_tried_again(
    folder, tmp_path, run, monkeypatch
):
    """What an interrupted run has seen fail in the middle of a copy is not final."""
    out = tmp_path / "out"
    path = folder / "block_00" / "low_flight.csv"
    whole = path.read_bytes()
    honest = batch_run.run_block

    def run_while_it_is_copied(task):
        if task.name == "block_00":
            path.write_bytes(whole[: len(whole) // 2])
        row = honest(task)
        path.write_bytes(whole)
        return row

    monkeypatch.setattr(batch_run, "run_block", run_while_it_is_copied)
    with pytest.raises(KeyboardInterrupt):
        run(folder, out, HereEngine(until=2))
    monkeypatch.undo()
    table, names = run(folder, out, which="unfinished")
    assert "block_00" in names
    assert table.loc["block_00", "outcome"] == "done"


@pytest.mark.slow
def test_a_clock_that_was_wrong_leaves_nothing_behind(folder, tmp_path, run, left):
    """Results, marks and leftovers from the year 2100, found by a run of today."""
    out = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt):
        run(folder, out, HereEngine(until=1))
    leftover = out / f"{atomic._own_prefix()}-00000000-blocks.csv"
    leftover = leftover.with_name(
        leftover.name.replace(f"-{os.getpid()}-", "-4194400-")
    )
    leftover.write_text("half a tab")
    for path in [*out.rglob("*"), *folder.rglob("*")]:
        os.utime(path, (4_102_444_800, 4_102_444_800))
    run(folder, out)
    run(folder, tmp_path / "calm")
    assert left(out) == left(tmp_path / "calm")
    assert not leftover.exists()
