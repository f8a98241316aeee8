"""Bad nights: killed processes, full disks, memory that is not there.

``make faults`` kills 50 times, on this computer and on a cluster; here it is a few.
"""

import json
import os
import resource
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from pyarrow import parquet

import einschalt as es
from einschalt.interfaces.batch.batch_run import batch_folder, plan_batch, run_batch
from einschalt.pipeline.batch import local_engine
from einschalt.pipeline.batch.local_engine import LocalEngine

pytestmark = pytest.mark.slow

LINUX = pytest.mark.skipif(not Path("/proc").exists(), reason="asks /proc")


STARTING = 0.4  # of a run, while processes only import what they need


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory, benchmark_module, make_blocks):
    """A sound block and a broken one, and what a calm run of them has left."""

    def make(folder, n_blocks):
        make_blocks(folder, n_blocks)
        (folder / f"block_{n_blocks - 1:02d}" / "low_flight.csv").unlink()

    faults = benchmark_module("faults")
    root = tmp_path_factory.mktemp("faults")
    seconds = faults.undisturbed(root, n_blocks=2, make=make)
    return faults, partial(
        faults.setting_in, root, seconds, shortest=STARTING * seconds
    )


@LINUX
def test_killed_runs_end_with_the_same_bytes(undisturbed):
    """Of a killed runner, in the midst of its blocks; workers are killed below."""
    faults, setting_with = undisturbed
    setting = setting_with(seed=7)
    faults.disturb(setting, faults.LocalRun, n_kills=1)
    assert setting.killed.total() == 1
    assert setting.n_ends >= 1


@LINUX
def test_killed_cluster_ends_with_the_same_bytes(undisturbed):
    pytest.importorskip("distributed", reason="the extra cluster is not installed")
    faults, setting_with = undisturbed
    setting = setting_with(seed=1)
    faults.disturb(setting, faults.ClusterRun, n_kills=1)
    assert setting.killed.total() == 1


def batch(blocks, output, *options, **more):
    call = [sys.executable, "-m", "einschalt", "batch", blocks, "-o", output, *options]
    return subprocess.run(
        [str(part) for part in call],
        capture_output=True,
        text=True,
        check=False,
        timeout=1200,
        **more,
    )


@pytest.fixture
def blocks(tmp_path, make_blocks):
    return make_blocks(tmp_path / "blocks", 2)


@pytest.fixture(scope="module")
def calm(tmp_path_factory, make_blocks, engine_here):
    """What is left of such blocks that nothing disturbs, not even other processes."""
    root = tmp_path_factory.mktemp("calm")
    plan = plan_batch(sorted(make_blocks(root / "blocks", 2).iterdir()), root / "out")
    with batch_folder(root / "out"):
        run_batch(plan, engine_here)
    return root / "out"


def only_small_files():
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, 30_000))


@pytest.mark.skipif(os.name == "nt", reason="limits of POSIX")
def test_full_disk(blocks, tmp_path, calm, left, in_this_process):
    """Blocks fail with the reason, nothing is half-written, the next run mends all."""
    out = tmp_path / "out"
    said = batch(blocks, out, "--workers", "1", preexec_fn=only_small_files)
    assert said.returncode == 1
    assert "block.gpkg: cannot be written" in said.stdout
    assert "See that the disk has space, raise a limit on the size" in said.stdout
    assert "Traceback" not in said.stdout + said.stderr
    table = pd.read_csv(out / "blocks.csv")
    assert table["stage"].tolist() == ["writing"] * 2
    for path in out.rglob("failure.json"):  # tables that were small enough are new
        assert "may be of this run" in json.loads(path.read_text())["note"]
    assert not list(out.glob("*/provenance.json"))
    assert not [path for path in out.rglob(".*") if path.is_file()]
    again = es.densify_many(blocks, out)
    assert again["outcome"].tolist() == ["done"] * 2
    assert left(out) == left(calm)


def large_table(block, n_rows):
    text, number = pa.repeat("1", n_rows), pa.repeat(1.0, n_rows)
    # packed so little that nobody takes it for a file that is to fill the memory
    various = np.random.default_rng(1).integers(0, 64, n_rows).astype(float)
    names = ["coverage", "model_id", "point_id", "x", "y"]
    table = pa.table([text] * 3 + [pa.array(various), number], names=names)
    parquet.write_table(table, block / "low_flight.parquet")
    toml = block / "block.toml"
    toml.write_text(toml.read_text().replace("low_flight.csv", "low_flight.parquet"))


@pytest.mark.skipif(os.name == "nt", reason="limits of POSIX")
def test_a_block_that_needs_more_memory_than_there_is(blocks, tmp_path, monkeypatch):
    """A table of 10 million points beside a block of nine: one row with the reason."""
    monkeypatch.setattr(local_engine, "TRIES_ALONE", 1)
    large_table(blocks / "block_00", 10_000_000)
    options = {"workers": 1, "memory_gb": 1.0}
    table = es.densify_many(blocks, tmp_path / "out", **options).set_index("block")
    assert table["outcome"].tolist() == ["failed", "done"]
    row = table.loc["block_00"]
    assert row["reason"] == "needs more memory than there is"
    assert row["stage"] == "reading"
    failure = json.loads((tmp_path / "out" / "block_00" / "failure.json").read_text())
    assert not failure["is_final"]  # with more memory it may be sound
    assert "traceback" not in failure


@LINUX
def test_a_block_for_which_the_system_kills_its_process(
    blocks, tmp_path, calm, left, benchmark_module
):
    """As Linux does without memory: SIGKILL to who has most, whenever he has too much.

    The block falls; its neighbours are computed, as if it had not been there.
    """
    large_table(blocks / "block_00", 6_000_000)
    is_over = threading.Event()
    killed = []
    asked = (benchmark_module("faults").children, 7e8, killed, is_over)
    killer = threading.Thread(target=kill_the_large, args=asked)
    killer.start()
    try:
        table = es.densify_many(blocks, tmp_path / "out", workers=2)
    finally:
        is_over.set()
        killer.join()
    assert len(killed) == 3  # once beside another one, twice alone
    assert table["outcome"].tolist() == ["failed", "done"]
    assert "ended without an answer (signal 9)" in table["reason"][0]
    assert "on a computer with more memory" in table["remedy"][0]
    assert left(tmp_path / "out" / "block_01") == left(calm / "block_01")


def kill_the_large(children, limit, killed, is_over):
    """Kill every worker of this process that takes more memory than allowed [B].

    Until it becomes a program of its own a new process has the memory of this one.
    """
    own = Path("/proc/self/cmdline").read_bytes()
    while not is_over.wait(0.005):
        for pid in children(os.getpid()):
            with suppress(OSError):
                if Path(f"/proc/{pid}/cmdline").read_bytes() == own:
                    continue
                pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
                if pages * resource.getpagesize() > limit:
                    os.kill(pid, signal.SIGKILL)
                    killed.append(pid)
                    is_over.wait(0.5)  # until its memory is free


@LINUX
def test_a_task_that_outlives_its_runner_keeps_others_out(blocks, tmp_path):
    """On a cluster a killed runner leaves tasks behind: the next one waits for them."""
    from einschalt.interfaces.batch.block_run import run_block
    from einschalt.interfaces.files.folder_lock import locked

    plan = plan_batch([blocks / "block_00"], tmp_path / "out")
    (task,) = plan.to_run
    task.folder.mkdir(parents=True)
    answers = LocalEngine(1).answers(run_block, [task])
    with locked(task.folder):
        come = []
        waiting = threading.Thread(target=lambda: come.extend(answers))
        waiting.start()
        waiting.join(3.0)
        assert not come
    waiting.join()
    assert come[0].value["outcome"] == "done"
