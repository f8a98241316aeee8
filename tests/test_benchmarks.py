"""The judge of the races; the races themselves are run by ``make bench``."""

import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from einschalt.foundations import batches

ROOT = Path(__file__).parents[1]


@pytest.fixture
def racing(monkeypatch):
    monkeypatch.syspath_prepend(ROOT)
    return import_module("benchmarks.racing")


@pytest.mark.parametrize(("floor", "verdict"), [(2.0, "pass"), (1000.0, "FAIL")])
def test_median_ratio_for_one_unit_is_judged(
    racing, capsys, monkeypatch, floor, verdict
):
    now = [0.0]

    def takes(seconds):
        now[0] += seconds

    monkeypatch.setattr(racing, "perf_counter", lambda: now[0])
    # the peer takes five times as long, for half as many units
    ours = racing.Contender("ours", lambda: takes(0.01), 20)
    peer = racing.Contender("peer", lambda: takes(0.05), 10, floor=floor)
    kept = racing.race("Sleep", "nap", ours, [peer], rounds=5)
    assert kept == (verdict == "pass")
    title, first, second = capsys.readouterr().out.strip().splitlines()
    assert title == "Sleep (unit = nap, 5 rounds)"
    assert first.split()[-1] == "1"
    assert second.split()[-1] == verdict
    assert f">= {floor:g}" in second


def test_contenders_run_in_turn_after_a_warm_up(racing):
    runs = []
    contenders = [
        racing.Contender(name, lambda n=name: runs.append(n), 1) for name in "abc"
    ]
    racing.race("Order", "run", contenders[0], contenders[1:], rounds=2)
    assert "".join(runs) == "abc" * 3


def test_kernels_are_kept_on_one_core(racing):
    before = batches.n_cores()
    with racing.one_core():
        assert batches.n_cores() == 1
    assert batches.n_cores() == before


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
