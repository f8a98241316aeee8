"""No input is an output, and no file of the user is replaced or removed."""

import json
import os
import shutil
import threading
from contextlib import suppress
from pathlib import Path

import pandas as pd
import pytest
from typer.testing import CliRunner

import einschalt as es
from einschalt.foundations.errors import FileError, OutputError
from einschalt.interfaces.cli.main import app
from einschalt.interfaces.files import output_folder
from einschalt.interfaces.files.folder_lock import LOCK, locked
from einschalt.interfaces.files.output_folder import InputFiles
from einschalt.interfaces.files.result_folder import output_of
from einschalt.interfaces.reports import figure_files

pytestmark = pytest.mark.usefixtures("computed_once")

MODEL = "model_id,point_id,x,y\n" + "".join(
    f"1,{k},{x},{y}\n" for k, (x, y) in enumerate([(0, 0), (9, 0), (0, 9), (9, 9)])
)
GROUND = "point_id,easting,northing\n" + "".join(
    f"{k},{e},{n}\n" for k, (e, n) in enumerate([(0, 0), (90, 1), (0, 90), (90, 91)])
)
PARALLAXES = "model_id,point_id,x,y,z,y_parallax\n" + "".join(
    f"1,{k},{x},{y},-150,0.0{k}\n"
    for k, (x, y) in enumerate(
        [(0, 0), (92, 0), (0, 90), (92, 90), (0, -90), (92, -90), (46, 5)]
    )
)
MINE = "the user's own\n"


def run(*arguments):
    done = CliRunner().invoke(app, [str(argument) for argument in arguments])
    is_known = done.exception is None or isinstance(done.exception, SystemExit)
    assert is_known, done.exception
    return done


def refused(*arguments):
    """One sentence with a remedy, and status 2; give the sentence."""
    done = run(*arguments)
    assert done.exit_code == 2, done.output
    sentence = done.stderr.rstrip().split("\n")[-1]
    assert sentence.startswith("einschalt: ")
    assert sentence.endswith(".")
    return sentence


def snapshot(folder):
    """Bytes of all files below a folder, and where links lead."""
    return {
        path.relative_to(folder).as_posix(): path.readlink()
        if path.is_symlink()
        else path.read_bytes()
        for path in sorted(Path(folder).rglob("*"))
        if path.is_symlink() or path.is_file()
    }


@pytest.fixture
def job(tmp_path, make_block):
    """A block in job/config whose tables lie in job/data."""
    block = make_block(tmp_path / "job" / "config")
    data = tmp_path / "job" / "data"
    data.mkdir()
    for table, new in (("low_flight", "models"), ("high_flight", "residuals")):
        (block.path / f"{table}.csv").rename(data / f"{new}.csv")
        block.replace("block.toml", f'"{table}.csv"', f'"../data/{new}.csv"')
    return block


@pytest.fixture
def tables(tmp_path):
    """A folder with tables for transform and orient, called as results are."""
    folder = tmp_path / "tables"
    folder.mkdir()
    (folder / "models.csv").write_text(MODEL)
    (folder / "points.csv").write_text(GROUND)
    (folder / "parameters.csv").write_text(PARALLAXES)
    return folder


@pytest.mark.parametrize("more", [[], ["--overwrite"]])
def test_densify_does_not_replace_its_inputs(job, tmp_path, more):
    before = snapshot(tmp_path)
    said = refused("densify", job.path, "-o", tmp_path / "job" / "data", *more)
    assert "models.csv: the run reads this file, and would write it" in said
    assert snapshot(tmp_path) == before


def test_python_does_not_replace_its_inputs(job, tmp_path):
    before = snapshot(tmp_path)
    block = es.read_block(job.path)
    for overwrite in (False, True):
        with pytest.raises(FileError, match=r"the run reads this file"):
            es.densify(block).write(tmp_path / "job" / "data", overwrite=overwrite)
    assert snapshot(tmp_path) == before


def test_folder_of_the_user_is_refused_before_the_work(
    small_block, tmp_path, monkeypatch
):
    folder = tmp_path / "mine"
    folder.mkdir()
    for name in ("points.csv", "coverages.csv", "neighbours.parquet", "notes.txt"):
        (folder / name).write_text(MINE)
    before = snapshot(folder)

    def compute(*_, **__):
        raise AssertionError("computed before it was refused")

    with monkeypatch.context() as patched:
        patched.setattr("einschalt.interfaces.python_api.densify", compute)
        said = refused("densify", small_block.path, "-o", folder)
    assert "coverages.csv, neighbours.parquet, points.csv" in said
    assert "--overwrite" in said
    assert snapshot(folder) == before
    assert run("densify", small_block.path, "-o", folder, "--overwrite").exit_code == 0
    assert (folder / "points.csv").read_text() != MINE
    assert (folder / "notes.txt").read_text() == MINE


def test_any_folder_that_is_not_ours_is_refused(small_block, tmp_path):
    folder = tmp_path / "photographs"
    folder.mkdir()
    (folder / "notes.txt").write_text(MINE)
    assert "holds notes.txt" in refused("densify", small_block.path, "-o", folder)
    assert list(folder.iterdir()) == [folder / "notes.txt"]


def test_transform_and_orient_do_not_replace_their_inputs(tables, monkeypatch):
    monkeypatch.chdir(tables)
    before = snapshot(tables)
    for more in ([], ["--overwrite"]):
        refused("transform", "models.csv", "points.csv", "-o", ".", *more)
        refused("orient", "parameters.csv", "--base", "92", "-o", ".", *more)
        refused("orient", "parameters.csv", "--base", "92", "-o", "../tables", *more)
    assert snapshot(tables) == before


def test_block_file_of_another_name_is_a_block(small_block):
    (small_block.path / "block.toml").rename(small_block.path / "other.toml")
    before = snapshot(small_block.path)
    for more in ([], ["--overwrite"]):
        other = small_block.path / "other.toml"
        said = refused("densify", other, "-o", small_block.path, *more)
        assert "the folder holds a block" in said
    assert snapshot(small_block.path) == before


@pytest.mark.parametrize("way", [".", "new/..", "../nine_points/./", "../link"])
def test_no_way_leads_into_the_folder_of_a_block(
    small_block, tmp_path, way, monkeypatch
):
    (tmp_path / "link").symlink_to(small_block.path)
    monkeypatch.chdir(small_block.path)
    before = snapshot(tmp_path)
    assert "holds a block" in refused("densify", ".", "-o", way, "--overwrite")
    assert snapshot(tmp_path) == before
    assert not (small_block.path / "new").exists()


def test_a_folder_by_another_way_is_the_same(small_block, tmp_path, monkeypatch):
    (tmp_path / "link").symlink_to(small_block.path)
    assert run("densify", small_block.path, "-o", tmp_path / "out").exit_code == 0
    monkeypatch.chdir(small_block.path)
    assert run("densify", "../link", "-o", "../link/../out").exit_code == 0


@pytest.mark.slow
def test_links_in_a_result_folder_are_not_followed(small_block, tmp_path):
    out, target = tmp_path / "out", tmp_path / "target.txt"
    target.write_text(MINE)
    assert run("densify", small_block.path, "-o", out).exit_code == 0
    (out / "points.csv").unlink()
    (out / "points.csv").symlink_to(target)
    assert "points.csv" in refused("densify", small_block.path, "-o", out)
    assert run("densify", small_block.path, "-o", out, "--overwrite").exit_code == 0
    assert target.read_text() == MINE
    assert not (out / "points.csv").is_symlink()


@pytest.mark.parametrize("kind", ["symbolic", "hard", "own"])
def test_a_lock_truncates_nothing(small_block, tmp_path, kind):
    out, target = tmp_path / "out", tmp_path / "target.txt"
    out.mkdir()
    target.write_text(MINE)
    if kind == "symbolic":
        (out / LOCK).symlink_to(target)
    elif kind == "hard":
        (out / LOCK).hardlink_to(target)
    else:
        (out / LOCK).write_text(MINE)
    before = snapshot(tmp_path)
    said = refused("densify", small_block.path, "-o", out, "--overwrite")
    assert "is no lock of einschalt" in said
    with pytest.raises(OutputError, match="no lock of einschalt"), locked(out):
        pass
    assert snapshot(tmp_path) == before


@pytest.mark.slow
def test_results_of_the_same_block_are_replaced(small_block, tmp_path):
    out = tmp_path / "out"
    assert run("densify", small_block.path, "-o", out).exit_code == 0
    (out / "notes.txt").write_text(MINE)  # beside the results nothing happens to it
    small_block.replace("control_points.csv", "13000.00", "13000.05")
    before = (out / "points.csv").read_bytes()
    options = ("--method", "simultaneous")
    assert run("densify", small_block.path, "-o", out, *options).exit_code == 0
    assert (out / "points.csv").read_bytes() != before
    assert (out / "notes.txt").read_text() == MINE
    outputs = json.loads((out / "provenance.json").read_text())["outputs"]
    assert {p.name for p in out.iterdir()} == {
        *outputs,
        *("provenance.json", "notes.txt"),
    }


@pytest.mark.slow
def test_tables_that_a_result_no_longer_has_are_removed(small_block, tmp_path):
    out = tmp_path / "out"
    block = es.read_block(small_block.path)
    es.densify(block, es.Settings(iterations=3)).write(out)
    assert (out / "iterations.csv").exists()
    es.densify(block).write(out)
    assert not (out / "iterations.csv").exists()


@pytest.mark.slow
def test_results_of_another_block_are_refused(small_block, tmp_path, make_block):
    out = tmp_path / "out"
    assert run("densify", small_block.path, "-o", out).exit_code == 0
    other = make_block(tmp_path / "elsewhere" / "nine_points")  # of the same name
    other.replace("low_flight.csv", ",10.0000,", ",10.0010,")
    before = snapshot(out)
    said = refused("densify", other.path, "-o", out)
    assert "results of another block, 'Nine points'" in said
    assert snapshot(out) == before
    assert run("densify", other.path, "-o", out, "--overwrite").exit_code == 0


def test_a_moved_block_that_is_the_same_may_be_computed_again(small_block, tmp_path):
    out = tmp_path / "out"
    assert run("densify", small_block.path, "-o", out).exit_code == 0
    moved = tmp_path / "archive" / "nine_points"
    shutil.copytree(small_block.path, moved)
    assert run("densify", moved, "-o", out).exit_code == 0


@pytest.mark.parametrize("name", ["summary.txt", "points.csv", "provenance.json"])
def test_a_result_that_was_changed_is_the_users(small_block, tmp_path, name):
    out = tmp_path / "out"
    assert run("densify", small_block.path, "-o", out).exit_code == 0
    text = (out / name).read_text()
    (out / name).write_text(text.replace("0", "1", 1))
    before = snapshot(out)
    assert name in refused("densify", small_block.path, "-o", out)
    assert snapshot(out) == before


@pytest.mark.usefixtures("in_this_process")
def test_a_batch_refuses_what_is_not_its_own(small_block, make_block, tmp_path):
    blocks, out = tmp_path / "blocks", tmp_path / "out"
    for name in ("one", "two"):
        make_block(blocks / name)
    out.mkdir()
    (out / "blocks.csv").write_text(MINE)
    assert "blocks.csv" in refused("batch", blocks, "-o", out)
    (out / "blocks.csv").unlink()
    (out / "one").mkdir()
    (out / "one" / "points.csv").write_text(MINE)
    table = es.densify_many(blocks, out, workers=1).set_index("block")
    assert table["outcome"].to_dict() == {"one": "failed", "two": "done"}
    assert "points.csv, not written by einschalt" in table.loc["one", "reason"]
    assert snapshot(out / "one") == {"points.csv": MINE.encode()}
    again = es.densify_many(blocks, out, workers=1, overwrite=True)
    assert again["outcome"].tolist() == ["done", "skipped"]


@pytest.mark.usefixtures("in_this_process")
def test_a_batch_writes_no_input_of_another_block(make_block, tmp_path):
    blocks, out = tmp_path / "blocks", tmp_path / "out"
    make_block(blocks / "one")
    es.densify_many(blocks, out, workers=1)
    two = make_block(blocks / "two")
    two.replace("block.toml", '"control_points.csv"', '"../../out/one/points.csv"')
    before = snapshot(out / "one")
    table = es.densify_many(blocks, out, workers=1, which="all", overwrite=True)
    assert "the run reads this file" in table.set_index("block").loc["one", "reason"]
    assert snapshot(out / "one") == before


def test_two_runs_do_not_mix(small_block, tmp_path):
    """The second is told at once, and who the first is."""
    out = tmp_path / "out"
    out.mkdir()
    is_held, is_over = threading.Event(), threading.Event()

    def hold():
        with locked(out):
            is_held.set()
            is_over.wait(60)

    thread = threading.Thread(target=hold)
    thread.start()
    try:
        assert is_held.wait(60)
        said = refused("densify", small_block.path, "-o", out)
    finally:
        is_over.set()
        thread.join()
    assert f"another run writes into this folder; process {os.getpid()} on" in said
    assert list(out.iterdir()) == []


def test_waiting_for_a_lock_is_bounded_and_said(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("einschalt.interfaces.files.folder_lock.PATIENCE_SECONDS", 0.2)
    failures = []

    def second():
        try:
            with locked(tmp_path, waits=True):
                pass
        except OutputError as error:
            failures.append(str(error))

    with locked(tmp_path):
        thread = threading.Thread(target=second)
        thread.start()
        thread.join(60)
    assert "waited 0.2 s for it to end" in failures[0]
    assert "waiting for at most 0.2 s" in capsys.readouterr().err


def test_what_was_computed_is_written_beside(small_block, tmp_path, monkeypatch):
    out = tmp_path / "out"
    from einschalt.interfaces import python_api

    compute = python_api.densify

    def meanwhile(*arguments, **options):
        result = compute(*arguments, **options)
        (out / "points.csv").write_text(MINE)
        return result

    monkeypatch.setattr(python_api, "densify", meanwhile)
    said = refused("densify", small_block.path, "-o", out)
    assert f"The results of this run are in {tmp_path / 'out-2'}" in said
    assert snapshot(out) == {"points.csv": MINE.encode()}
    assert (tmp_path / "out-2" / "provenance.json").exists()
    assert len(pd.read_csv(tmp_path / "out-2" / "points.csv")) == 9


def test_a_failed_run_leaves_no_empty_folder(small_block, tmp_path):
    small_block.replace("block.toml", "model_points", "model_pints")
    assert run("densify", small_block.path, "-o", tmp_path / "out").exit_code == 2
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.parametrize("at", range(1, 30, 4))
def test_a_run_that_ends_anywhere_leaves_a_folder_that_is_ours(
    small_block, tmp_path, monkeypatch, at
):
    """Cut off after so many renames and removals; the next run knows its files."""
    out = tmp_path / "out"
    result = es.densify(es.read_block(small_block.path))
    result.write(out)
    other = es.densify(es.read_block(small_block.path), es.Settings(iterations=2))
    replace, count = Path.replace, 0

    def cut(path, target):
        nonlocal count
        count += Path(target).parent == out
        if count > at:
            raise KeyboardInterrupt
        return replace(path, target)

    with monkeypatch.context() as patched:
        patched.setattr(Path, "replace", cut)
        with suppress(KeyboardInterrupt):
            other.write(out)
    output_folder.require_free(out, output_of(result.block))
    result.write(out)
    es.densify(es.read_block(small_block.path)).write(tmp_path / "calm")
    names = {path.name for path in (tmp_path / "calm").iterdir()}
    assert {path.name for path in out.iterdir()} == names


@pytest.mark.slow
def test_plan_replaces_only_its_own(tmp_path, monkeypatch):
    # only what is written counts here
    monkeypatch.setattr(figure_files, "figure_bytes", lambda *_: {"svg": b"<svg/>"})
    own = ("plan", "--scale-number", "6000", "--spacing", "200", "-o")
    other = ("plan", "--scale-number", "8000", "--spacing", "200", "-o")
    for name in ("plan.csv", "folder"):
        assert run(*own, tmp_path / name).exit_code == 0
        assert run(*own, tmp_path / name).exit_code == 0
        before = snapshot(tmp_path)
        refused(*other, tmp_path / name)
        assert snapshot(tmp_path) == before
        assert run(*other, tmp_path / name, "--overwrite").exit_code == 0
        assert snapshot(tmp_path) != before


@pytest.mark.slow
def test_plan_does_not_replace_its_terrain(tmp_path):
    terrain = tmp_path / "terrain.csv"
    terrain.write_text("model_id,h1,h2,h3,h4,h5,h6\n1,500,500,500,500,500,500\n")
    before = snapshot(tmp_path)
    for name in ("terrain.csv", "./../" + tmp_path.name + "/terrain.csv"):
        options = ("--terrain", terrain, "-o", tmp_path / name, "--overwrite")
        assert "reads this file" in refused("plan", "--scale-number", "6000", *options)
    assert snapshot(tmp_path) == before


def test_a_block_is_not_written_over_itself(small_block):
    block = es.read_block(small_block.path)
    before = snapshot(small_block.path)
    with pytest.raises(FileError, match="the run reads this file"):
        block.write(small_block.path, overwrite=True)
    assert snapshot(small_block.path) == before


def test_simulate_does_not_follow_a_link(tmp_path):
    (tmp_path / "block").mkdir()
    target = tmp_path / "elsewhere.toml"
    (tmp_path / "block" / "block.toml").symlink_to(target)  # leads nowhere yet
    call = ("simulate", "--preset", "demo", "-o", tmp_path / "block")
    assert "holds block.toml already" in refused(*call)
    assert not target.exists()
    assert run(*call, "--overwrite").exit_code == 0
    assert not target.exists()


@pytest.mark.slow
def test_a_block_without_control_points_is_computed(tmp_path, make_block):
    """All of it hangs on approximate points: nothing in it needs control."""
    block = make_block(tmp_path / "block")
    text = block.read("block.toml")
    start, end = text.index("[control_points]"), text.index("[low_flight]")
    given = '[approximate_points]\nfile = "control_points.csv"\nm_0_m = 0.1\n\n'
    block.write("block.toml", text[:start] + given + text[end:])
    result = es.densify(es.read_block(block.path))
    assert "9 new points" in result.summary()
    result.write(tmp_path / "out")
    assert (tmp_path / "out" / "summary.txt").exists()


@pytest.mark.parametrize("where", ["block", "parent", "elsewhere", "changed", "broken"])
def test_no_export_replaces_what_a_block_reads(small_block, tmp_path, where):
    """Known by its block.toml, or by the result that was computed from it."""
    table = small_block.path / "low_flight.csv"
    result = es.densify(es.read_block(small_block.path))
    result.write(tmp_path / "out")
    if where == "parent":
        (small_block.path / "tables").mkdir()
        table = table.rename(small_block.path / "tables" / "low_flight.csv")
        small_block.replace("block.toml", '"low_flight', '"tables/low_flight')
    elif where == "elsewhere":
        table = table.rename(tmp_path / "moved.csv")
    elif where == "broken":
        small_block.write("block.toml", small_block.read("block.toml") + "[[[")
    is_by_content = where in {"block", "elsewhere"}
    if not is_by_content:
        table.write_text(table.read_text() + "\n")
    before = snapshot(tmp_path)
    said = "computed from this file" if is_by_content else "is an input of the block"
    told = refused("export", tmp_path / "out", "--to", table, "--overwrite")
    assert said in told
    assert "inputs are never overwritten" in told
    with pytest.raises(OutputError, match=said):
        es.export(tmp_path / "out", table, overwrite=True)
    assert snapshot(tmp_path) == before


@pytest.mark.parametrize("damage", ["{", "[]", '{"inputs": [{}]}', '{"inputs": 3}'])
def test_a_damaged_list_of_inputs_names_none(small_block, tmp_path, damage):
    (tmp_path / "provenance.json").write_text(damage)
    table = small_block.path / "low_flight.csv"
    assert not InputFiles([tmp_path / "provenance.json"]).were_read(table)


def test_plan_replaces_no_input_of_a_block(small_block, tmp_path, monkeypatch):
    monkeypatch.setattr(figure_files, "figure_bytes", lambda *_: {"svg": b"<svg/>"})
    place = small_block.path / "low_flight.csv"
    call = ("plan", "--scale-number", "6000", "--spacing", "200", "-o", place)
    before = snapshot(tmp_path)
    assert f"input of the block {small_block.path}" in refused(*call, "--overwrite")
    assert snapshot(tmp_path) == before


def test_tables_below_a_block_are_not_replaced(small_block, tables, tmp_path):
    """A folder without a block.toml of its own, that the one above it names."""
    place = small_block.path / "tables"
    place.mkdir()
    table = (small_block.path / "low_flight.csv").rename(place / "models.csv")
    small_block.replace("block.toml", '"low_flight.csv"', '"tables/models.csv"')
    before = table.read_bytes()
    given = ("transform", tables / "models.csv", tables / "points.csv", "-o", place)
    assert "models.csv: is an input of the block" in refused(*given, "--overwrite")
    assert table.read_bytes() == before
