"""Thirty blocks: one hangs, one explodes, one loses its process, one is too large."""

import os
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.interfaces import python_api
from einschalt.pipeline.batch import local_engine
from einschalt.pipeline.batch.dask_engine import DaskEngine
from einschalt.pipeline.batch.local_engine import LocalEngine

ROOT = Path(__file__).parents[3]
LIMITS = {"memory_gb": 1.0, "time_limit_s": 20.0}
LONG = pytest.mark.skipif("EINSCHALT_LONG" not in os.environ, reason="make faults")
SAID = {
    "hanging": ("not done within 20 s", "Raise the time limit"),
    "exploding": ("needs more memory than there is", "on a larger computer"),
    "killed": ("ended without an answer (signal 9)", "with more memory"),
    "huge": ("the block needs about", "Take fewer points of a model"),
}

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals and limits of POSIX")


@pytest.fixture
def thirty(tmp_path, make_blocks, make_block, monkeypatch):
    monkeypatch.setenv(
        "PYTHONPATH", os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    )
    blocks = make_blocks(tmp_path / "blocks", 30 - len(SAID))
    for name in SAID:
        make_block(blocks / name)
    with_huge_model(blocks / "huge", 300_000)
    return blocks


def with_huge_model(block, n_points):
    """A cloud of matched points in one model of the low flight."""
    known = pd.read_csv(block / "low_flight.csv", dtype={"point_id": str})
    x, y = np.random.default_rng(1).uniform(0.0, 90.0, (2, n_points))
    first = known.iloc[0][["coverage", "model_id"]].to_dict()
    names = np.char.add("m", np.arange(n_points).astype(str))
    cloud = pd.DataFrame({**first, "point_id": names, "x": x, "y": y})
    cloud = cloud.astype({"coverage": str})
    pd.concat([known.astype({"coverage": str}), cloud]).to_parquet(
        block / "low_flight.parquet"
    )
    toml = block / "block.toml"
    toml.write_text(toml.read_text().replace("low_flight.csv", "low_flight.parquet"))


@pytest.fixture
def cluster(tmp_path, thirty, benchmark_module):
    pytest.importorskip("distributed", reason="the extra cluster is not installed")
    faults = benchmark_module("faults")
    running = faults.Cluster(tmp_path / "scheduler.json")
    yield running.address
    running.end()


def assert_ends_and_says_why(table, seconds):
    assert seconds < 20.0 * LIMITS["time_limit_s"]
    table = table.set_index("block")
    assert len(table) == 30
    failed = table[table["outcome"] == "failed"]
    assert set(failed.index) == set(SAID)
    assert (table.drop(index=list(SAID))["outcome"] == "done").all()
    for name, (reason, remedy) in SAID.items():
        assert reason in failed.loc[name, "reason"]
        assert remedy in failed.loc[name, "remedy"]


def run(monkeypatch, engine, blocks, output):
    monkeypatch.setattr(python_api, "chosen_engine", lambda *_: engine)
    started = time.monotonic()
    table = es.densify_many(blocks, output)
    return table, time.monotonic() - started


@pytest.mark.slow
def test_the_batch_ends_and_says_which_and_why(
    thirty, tmp_path, monkeypatch, benchmark_module
):
    """The sound ones are not computed here; ``make faults`` computes them."""
    monkeypatch.setattr(local_engine, "TRIES_ALONE", 1)
    night = benchmark_module("bad_night")
    is_long = "EINSCHALT_LONG" in os.environ
    engine = night.BadNight(
        LocalEngine(2, **LIMITS), None if is_long else night.not_computed
    )
    found = run(monkeypatch, engine, thirty, tmp_path / "out")
    assert_ends_and_says_why(*found)
    if is_long:
        assert len(list((tmp_path / "out").glob("block_*/provenance.json"))) == 26
    assert "hanging" in (tmp_path / "out" / "blocks.csv").read_text()


@LONG
def test_so_does_one_on_a_cluster(
    thirty, tmp_path, monkeypatch, benchmark_module, cluster
):
    engine = benchmark_module("bad_night").BadNight(DaskEngine(cluster, **LIMITS))
    assert_ends_and_says_why(*run(monkeypatch, engine, thirty, tmp_path / "out"))
