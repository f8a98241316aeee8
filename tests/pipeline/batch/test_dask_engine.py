"""A real scheduler with two worker processes."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress

import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.batch.dask_engine import DaskEngine
from einschalt.pipeline.batch.local_engine import (
    EngineError,
    ProcessEndedError,
    TimeLimitError,
    run_in_order,
)

pytestmark = pytest.mark.slow

pytest.importorskip("distributed", reason="the extra cluster is not installed")

OWN_PID = "__import__('os').getpid()"


def run_dask(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


class Cluster:
    def __init__(self, folder):
        self.file = folder / "scheduler.json"
        address = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        file = ("--scheduler-file", str(self.file))
        self.scheduler = run_dask("scheduler", *address, *file)
        options = ("--nthreads", "1", "--no-nanny", "--no-dashboard")
        self.workers = [run_dask("worker", *options, *file) for _ in range(2)]

    @property
    def address(self):
        while self.scheduler.poll() is None:
            with suppress(FileNotFoundError, json.JSONDecodeError):  # not whole yet
                return json.loads(self.file.read_text())["address"]
            time.sleep(0.05)
        pytest.fail("the scheduler has ended")

    def wait_for_workers(self, n_workers):
        """On a busy computer one may have done all the work before another comes."""
        import distributed

        with distributed.Client(self.address, set_as_default=False) as client:
            client.wait_for_workers(n_workers)

    def end(self):
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path):
    running = Cluster(tmp_path)
    yield running
    running.end()


def test_tasks_run_on_both_workers(cluster):
    slow = f"__import__('time').sleep(0.3) or {OWN_PID}"
    cluster.wait_for_workers(2)
    pids = run_in_order(DaskEngine(cluster.address), eval, [slow] * 8)
    assert set(pids) == {worker.pid for worker in cluster.workers}
    values = run_in_order(DaskEngine(cluster.address), eval, list("1234"))
    assert values == [1, 2, 3, 4]


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_deaths(cluster, tmp_path, caplog):
    """A worker that is killed is replaced by the other; then no worker is left."""
    engine = DaskEngine(cluster.address)
    mark = tmp_path / "mark"
    task = (
        f"__import__('os').path.exists({str(mark)!r}) and 'value' or "
        f"(__import__('pathlib').Path({str(mark)!r}).touch(), "
        f"__import__('os').kill({OWN_PID}, 9))"
    )
    assert run_in_order(engine, eval, [task, "1"]) == ["value", 1]
    answers = engine.answers(eval, ["1", "__import__('time').sleep(600)"])
    assert next(answers).value == 1
    cluster.scheduler.send_signal(signal.SIGKILL)
    with pytest.raises(EngineError, match=r"the scheduler at tcp://.* is gone.*Start"):
        next(answers)
    # what is said is said once, without a traceback of Dask's
    assert not [one for one in caplog.records if one.name == "distributed.client"]


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_task_that_kills_every_worker_is_an_answer(cluster):
    for _ in range(3):
        options = ("--nthreads", "1", "--no-nanny", "--no-dashboard")
        file = ("--scheduler-file", str(cluster.file))
        cluster.workers.append(run_dask("worker", *options, *file))
    end = f"__import__('os').kill({OWN_PID}, 9)"
    (answer,) = DaskEngine(cluster.address).answers(eval, [end])
    with pytest.raises(ProcessEndedError, match="the workers that computed it ended"):
        raise answer.error


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "no address", ""])
def test_nobody_answers(address, monkeypatch):
    monkeypatch.setattr("einschalt.pipeline.batch.dask_engine.SECONDS_TO_CONNECT", 1)
    with pytest.raises(SettingsError, match=r"no scheduler answers at .*dask schedule"):
        list(DaskEngine(address).answers(eval, ["1"]))


def test_dask_is_an_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(SettingsError, match=r"pip install '\.\[cluster\]'"):
        list(DaskEngine("tcp://127.0.0.1:1").answers(eval, ["1"]))


def test_a_task_that_hangs_is_ended_on_its_worker(cluster):
    engine = DaskEngine(cluster.address, time_limit_s=3.0)
    answers = list(engine.answers(eval, ["1", "__import__('time').sleep(600)", "2"]))
    values = {answer.place: answer.value for answer in answers}
    assert values == {0: 1, 1: None, 2: 2}
    (late,) = (answer.error for answer in answers if answer.error is not None)
    assert isinstance(late, TimeLimitError)
    assert "not done within 3 s" in str(late)
