"""The judge of the races; the races themselves are run by ``make bench``."""

import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from einschalt.foundations import batches

ROOT = Path(__file__).parents[1]


@pytest.fixture
def racing(monkeypatch):
    monkeypatch.syspath_prepend(ROOT)
    return import_module("benchmarks.racing")


@pytest.fixture
def record(racing, monkeypatch, tmp_path):
    module = import_module("benchmarks.record")
    monkeypatch.setattr(module, "FOLDER", tmp_path / "bench")
    return module


@pytest.mark.parametrize(
    ("floor", "goal", "verdict"),
    [
        (2.0, None, "pass"),
        (2.0, 9.0, "pass"),
        (2.0, 11.0, "pass, goal missed"),
        (1000.0, 2000.0, "FAIL"),
    ],
)
def test_median_ratio_for_one_unit_is_judged(
    racing, capsys, monkeypatch, floor, goal, verdict
):
    now = [0.0]

    def takes(seconds):
        now[0] += seconds

    monkeypatch.setattr(racing, "perf_counter", lambda: now[0])
    # the peer takes five times as long, for half as many units
    ours = racing.Contender("ours", lambda: takes(0.01), 20)
    bound = racing.at_least(floor, goal)
    peer = racing.Contender("peer", lambda: takes(0.05), 10, bound)
    race = racing.race("Sleep", "nap", ours, [peer], rounds=5)
    assert race.is_kept == verdict.startswith("pass")
    assert race.outcomes[1].is_reached == (verdict == "pass")
    title, first, second = capsys.readouterr().out.strip().splitlines()
    assert title == "Sleep (unit = nap, 5 rounds)"
    assert first.split()[-1] == "1"
    assert second.endswith(f"  {verdict}")
    assert f">= {floor:g}" in second
    np.testing.assert_allclose(race.outcomes[1].ratio, 10.0)


def test_what_grows_is_bounded_from_above(racing):
    bound = racing.at_most(3.0, goal=2.0)
    ratios = [1.5, 2.5, 3.5]
    assert [bound.keeps(ratio) for ratio in ratios] == [True, True, False]
    assert [bound.reaches(ratio) for ratio in ratios] == [True, False, False]
    assert bound.text == "<= 3 (2)"


def test_contenders_run_in_turn_after_a_warm_up(racing):
    runs = []
    contenders = [
        racing.Contender(name, lambda n=name: runs.append(n), 1) for name in "abc"
    ]
    racing.race("Order", "run", contenders[0], contenders[1:], rounds=2)
    assert "".join(runs) == "abc" * 3


def test_a_copy_of_the_same_memory_takes_part(racing):
    ours = racing.Contender("ours", lambda: None, 1)
    race = racing.race("Copy", "block", ours, [], rounds=1, n_bytes=8_000_000)
    assert race.outcomes[-1].name == "memory copy of the same 8 MB"


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells")
def test_the_peak_of_memory_is_that_of_the_work(racing):
    def passing():
        assert np.ones(12_500_000).sum() > 0.0  # 100 MB, given back

    passing()
    for_later = [np.ones(12_500) for _ in range(2000)]  # 200 MB, which may be kept
    del for_later
    assert 80.0 < racing.peak_mb(passing) < 200.0


def test_kernels_are_kept_on_one_core(racing):
    before = batches.n_cores()
    with racing.one_core():
        assert batches.n_cores() == 1
    assert batches.n_cores() == before


def test_a_run_is_kept_with_its_machine(racing, record, capsys):
    outcomes = (
        racing.Outcome("ours", "1 s", 1.0),
        racing.Outcome("quick enough", "2 s", 2.0, racing.at_least(1.0, 3.0)),
        racing.Outcome("too much", "9 GiB", 9.0, racing.at_most(6.0)),
    )
    growth = {1000: 0.1, 10_000: 1.2}
    races = {"sprint": [racing.Race("Sprint: growth", outcomes, growth)]}
    assert record.keep(races, 61.0) == 1
    out = capsys.readouterr().out
    assert "1 of 2 floors kept, 0 goals reached, in 1.0 min" in out
    kept = json.loads((record.FOLDER / "races.json").read_text())
    assert kept["machine"]["n_cores"] >= 1
    assert kept["versions"]["numpy"] == np.__version__
    ours, quick, large = kept["races"]["sprint"][0]["rows"]
    assert ours["bound"] is None
    assert ours["peak_mb"] is None
    assert (quick["is_kept"], quick["is_reached"]) == (True, False)
    assert large["is_kept"] is False
    assert (record.FOLDER / "growth.png").stat().st_size > 5_000


def test_a_run_that_keeps_every_floor_ends_well(racing, record):
    row = racing.Outcome("quick", "2 s", 2.0, racing.at_least(1.0))
    assert record.keep({"sprint": [racing.Race("Sprint", (row,))]}, 1.0) == 0


def test_unknown_race():
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", "sprint"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout.startswith("unknown race sprint; expected transformation, ")
