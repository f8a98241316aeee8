"""Kill what runs a batch, again and again: in the end the bytes must be the same.

``make faults`` kills 50 times; the tests do it a few times. Victims are the runner and
its workers, or the runner, the workers and the scheduler of a Dask cluster.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory, mkdtemp

import einschalt as es
from benchmarks.result_trees import tree
from einschalt.interfaces.batch.batch_run import MARKS

N_BLOCKS = 8
N_KILLS = 50
FINISHED = (0, 1)  # some blocks may have failed
SHORTEST = 0.3  # seconds before a kill
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


@dataclass
class Setting:
    """Where it happens, and what has happened.

    Attributes
    ----------
    blocks, calm, output, scratch : Path
        Input; results of the undisturbed run, and of the disturbed ones; other files.
    rng : Random
    seconds, shortest : float
        Longest and shortest time before a kill.
    killed : Counter
        How often whom.
    n_ends : int
        How often the disturbed runs came to their end and were compared.
    """

    blocks: Path
    calm: Path
    output: Path
    scratch: Path
    rng: Random
    seconds: float = 0.0
    shortest: float = SHORTEST
    killed: Counter = field(default_factory=Counter)
    n_ends: int = 0


class LocalRun:
    """A batch on the processes of this computer."""

    def __init__(self, setting):
        self.runner = _batch(setting.blocks, setting.output, "--workers", "2")

    def victims(self):
        """Name and number of each process that can be killed."""
        named = [("worker", pid) for pid in children(self.runner.pid)]
        return [("runner", self.runner.pid), *named]

    def has_finished(self, seconds):
        """Whether the batch comes to its end within so many seconds."""
        try:
            return self.runner.wait(seconds) in FINISHED
        except subprocess.TimeoutExpired:
            return False

    def end(self):
        """End what still runs."""
        self.runner.kill()
        self.runner.wait()


class Cluster:
    """A Dask scheduler with two workers, which others find by a ``file``."""

    def __init__(self, file):
        at = ("--scheduler-file", str(file), "--no-dashboard")
        one = ("--nthreads", "1", "--no-nanny")
        self.scheduler = _dask("scheduler", "--host", "127.0.0.1", "--port", "0", *at)
        self.workers = [_dask("worker", *one, *at) for _ in range(2)]
        self.address = _address(file)

    def end(self):
        """End what still runs."""
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


class ClusterRun(LocalRun):
    """A batch on a Dask scheduler with two workers."""

    def __init__(self, setting):
        file = setting.scratch / f"scheduler-{time.monotonic_ns()}.json"
        self.cluster = Cluster(file)
        address = self.cluster.address
        self.runner = _batch(setting.blocks, setting.output, "--scheduler", address)

    def victims(self):
        """Name and number of each process that can be killed."""
        dask = self.cluster
        workers = [("worker", w.pid) for w in dask.workers if w.poll() is None]
        others = [("runner", self.runner.pid), ("scheduler", dask.scheduler.pid)]
        # the last worker must live, or nobody is left to do the work
        return others + (workers if len(workers) > 1 else [])

    def end(self):
        """End what still runs."""
        super().end()
        self.cluster.end()


def _address(file):
    while True:
        with suppress(FileNotFoundError, json.JSONDecodeError):  # not whole yet
            return json.loads(file.read_text(encoding="utf-8"))["address"]
        time.sleep(0.05)


def _dask(*arguments):
    call = [sys.executable, "-m", "dask", *arguments]
    return subprocess.Popen(call, **QUIET)


def _batch(blocks, output, *options):
    call = [sys.executable, "-m", "einschalt", "batch", blocks, "-o", output, *options]
    return subprocess.Popen([str(part) for part in call], **QUIET)


def children(pid):
    """Numbers of the processes that a process has started.

    Parameters
    ----------
    pid : int

    Returns
    -------
    list of int
    """
    try:
        threads = list(Path(f"/proc/{pid}/task").iterdir())
        lists = [(thread / "children").read_text() for thread in threads]
    except (FileNotFoundError, ProcessLookupError):
        return []
    return [int(number) for text in lists for number in text.split()]


def make_blocks(folder, n_blocks):
    """Write simulated blocks, the last of them without a table.

    Parameters
    ----------
    folder : Path
    n_blocks : int
    """
    for seed in range(n_blocks):
        es.simulate_block("demo", seed=seed).write(folder / f"block_{seed:02d}")
    (folder / f"block_{n_blocks - 1:02d}" / "low_flight.csv").unlink()


def disturb(setting, start, n_kills):
    """Kill so many times; whenever a run comes to its end, compare and begin anew.

    Parameters
    ----------
    setting : Setting
    start : callable
        LocalRun or ClusterRun.
    n_kills : int

    Raises
    ------
    AssertionError
        The results of a disturbed run differ from those of the undisturbed one.
    """
    while setting.killed.total() < n_kills:
        run = start(setting)
        try:
            if not run.has_finished(
                setting.rng.uniform(setting.shortest, setting.seconds)
            ):
                _kill_one(run, setting)
            # one that lost a worker goes on, one that lost its scheduler says so
            if run.has_finished(setting.seconds) or _was_killed_too_late(setting):
                compare(setting)
                shutil.rmtree(setting.output)
        finally:
            run.end()
    run = start(setting)
    try:
        assert run.has_finished(20.0 * setting.seconds + 60.0), "it does not end"
    finally:
        run.end()
    compare(setting)


def _was_killed_too_late(setting):
    """Whether the batch had come to its end before it was killed."""
    has_table = (setting.output / "blocks.html").exists()
    return has_table and not (setting.output / MARKS).exists()


def _kill_one(run, setting):
    name, pid = setting.rng.choice(run.victims())
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:  # it was quicker
        return
    setting.killed[name] += 1


def compare(setting):
    """Compare the results with those of the undisturbed run, byte for byte.

    Parameters
    ----------
    setting : Setting

    Raises
    ------
    AssertionError
    """
    calm, disturbed = tree(setting.calm), tree(setting.output)
    assert set(calm) == set(disturbed), set(calm) ^ set(disturbed)
    different = [name for name in calm if calm[name] != disturbed[name]]
    first = next(iter(different), None)
    assert not different, f"{different}: {disturbed[first]} instead of {calm[first]}"
    setting.n_ends += 1


def run(n_kills=N_KILLS, n_blocks=N_BLOCKS, starts=(LocalRun, ClusterRun)):
    """Kill on this computer, then on a cluster.

    Parameters
    ----------
    n_kills, n_blocks : int
    starts : sequence, optional

    Returns
    -------
    list of Setting
        What has happened.
    """
    settings = []
    with TemporaryDirectory() as folder:
        seconds = undisturbed(Path(folder), n_blocks)
        for start in starts:
            setting = setting_in(Path(folder), seconds, n_kills)
            disturb(setting, start, n_kills)
            settings.append(setting)
            who = ", ".join(f"{k} {name}s" for name, k in setting.killed.items())
            print(f"{start.__name__}: killed {who}; {setting.n_ends} ends are the same")
    return settings


def undisturbed(root, n_blocks, make=make_blocks):
    """Make blocks and compute them while nobody is killed.

    Parameters
    ----------
    root : Path
        Gets the folders blocks and calm.
    n_blocks : int
    make : callable, optional
        Writes so many blocks into a folder.

    Returns
    -------
    float
        How long it took [s].
    """
    make(root / "blocks", n_blocks)
    begin = time.monotonic()
    _batch(root / "blocks", root / "calm", "--workers", "2").wait()
    return time.monotonic() - begin


def setting_in(root, seconds, seed, shortest=SHORTEST):
    """What is to be disturbed beside an undisturbed run.

    Parameters
    ----------
    root : Path
        Folder with what :func:`undisturbed` has made.
    seconds : float
        Longest time before a kill.
    seed : int
    shortest : float, optional
        Shortest time before one.

    Returns
    -------
    Setting
        With an output of its own, beside the calm one: results name their inputs by
        the way that leads there.
    """
    scratch = Path(mkdtemp(dir=root))
    output = root / f"out_{scratch.name}"
    return Setting(
        root / "blocks",
        root / "calm",
        output,
        scratch,
        Random(seed),
        seconds,
        shortest,
    )


if __name__ == "__main__":
    run()
