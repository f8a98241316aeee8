"""Files are written whole or not at all, also when the writer is killed."""

import errno
import os
import pickle
import re
import resource
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from tests.changed_results import changed

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files import atomic, result_folder
from einschalt.interfaces.files.result_folder import write_result
from einschalt.pipeline.result import Stopwatch

DAY = 24 * 3600


def leftover_of(pid, name="points.csv"):
    return f".einschalt-{atomic._place()}-{pid}-0123abcd-{name}"


def pid_of_ended_process():
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    return process.pid


def test_write_gives_the_file_and_nothing_else(tmp_path):
    atomic.write_text(tmp_path / "a.txt", "Mürz\n")
    assert (tmp_path / "a.txt").read_bytes() == "Mürz\n".encode()
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_older_file_is_replaced(tmp_path):
    atomic.write_bytes(tmp_path / "a.bin", b"old")
    atomic.write_bytes(tmp_path / "a.bin", b"new")
    assert (tmp_path / "a.bin").read_bytes() == b"new"


def test_link_is_replaced_and_its_target_stays(tmp_path):
    (tmp_path / "target.txt").write_text("old")
    (tmp_path / "link.txt").symlink_to("target.txt")
    atomic.write_text(tmp_path / "link.txt", "new")
    assert not (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "link.txt").read_text() == "new"
    assert (tmp_path / "target.txt").read_text() == "old"


def write_half(path):
    with atomic.replacing(path) as hidden:
        assert hidden.suffix == path.suffix
        assert hidden.name.startswith(".")
        hidden.write_text("half of the new")
        raise ZeroDivisionError


def test_failing_writer_leaves_the_older_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError):
        write_half(path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("number", "said"),
    [
        (errno.ENOSPC, "no space left on device. Free some space, or choose another"),
        (errno.EACCES, "permission denied. Choose a folder that you may write into"),
        (errno.EROFS, "read-only file system. Choose a folder that you may write into"),
        (errno.ENOLCK, "no locks available. Choose a folder on a file system that"),
    ],
)
def test_what_the_system_refuses_is_said(tmp_path, monkeypatch, number, said):
    def refuse(_descriptor):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(FileError, match=re.escape(f"a.txt: cannot be written: {said}")):
        atomic.write_text(tmp_path / "a.txt", "new")
    assert list(tmp_path.iterdir()) == []


def test_full_disk_leaves_nothing_half_written(tmp_path):
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    script = (
        "import sys; from einschalt.interfaces.files.atomic import write_bytes\n"
        "try: write_bytes(sys.argv[1], bytes(2000))\n"
        "except Exception as error: print(type(error).__name__, error)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", script, tmp_path / "a.bin"],
        preexec_fn=limit,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "a.bin: cannot be written: file too large. Raise the limit" in run.stdout
    assert run.stdout.startswith("FileError")
    assert list(tmp_path.iterdir()) == []


def test_folder_that_is_a_file(tmp_path):
    (tmp_path / "out").write_text("")
    with pytest.raises(FileError, match=r"file exists\. Choose another folder: a file"):
        atomic.make_folder(tmp_path / "out")
    with pytest.raises(
        FileError, match=r"not a directory\. Choose another folder: a p"
    ):
        atomic.make_folder(tmp_path / "out" / "block")


def test_missing_folder(tmp_path):
    with pytest.raises(FileError, match="Make the folder first"):
        atomic.write_text(tmp_path / "out" / "a.txt", "")


def test_name_of_a_folder(tmp_path):
    (tmp_path / "a.txt").mkdir()
    with pytest.raises(FileError, match=r"is a directory\. Choose another name"):
        atomic.write_text(tmp_path / "a.txt", "")


def test_leftover_of_an_ended_process_is_removed(tmp_path):
    names = [leftover_of(pid_of_ended_process(), n) for n in ("a.csv", "b.gpkg-wal")]
    for name in names:
        (tmp_path / name).write_text("half")
    atomic.write_text(tmp_path / "a.txt", "")
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


@pytest.mark.parametrize(
    "name",
    [
        leftover_of(os.getpid()),  # of another thread of ours
        leftover_of(1),
        ".einschalt-ffffff-1-0123abcd-a.csv",  # of another computer
        ".einschalt-notes.txt",
        "einschalt-0-0-0-a.csv",
    ],
    # the names hold the process: each one that runs tests would collect other tests
    ids=["ours", "running", "other_computer", "notes", "not_hidden"],
)
def test_what_may_still_be_written_stays(tmp_path, name):
    (tmp_path / name).write_text("half")
    atomic.write_text(tmp_path / "a.txt", "")
    assert (tmp_path / name).exists()


@pytest.mark.skipif(not Path("/proc").exists(), reason="asks /proc")
def test_leftover_of_a_killed_process_that_nobody_waits_for_is_removed(tmp_path):
    """As in a container whose first process asks for nobody's end."""
    process = subprocess.Popen(["sleep", "60"])
    leftover = tmp_path / leftover_of(process.pid)
    leftover.write_text("half")
    atomic.write_text(tmp_path / "new.csv", "1")
    assert leftover.exists()
    process.kill()
    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)  # dead, not taken away
    atomic.write_text(tmp_path / "new.csv", "1")
    assert not leftover.exists()
    process.wait()


@pytest.mark.parametrize("place", [atomic._place(), "ffffff"], ids=["here", "there"])
def test_old_leftover_is_removed_whoever_made_it(tmp_path, place):
    leftover = tmp_path / f".einschalt-{place}-1-0123abcd-a.csv"
    leftover.write_text("half")
    long_ago = time.time() - 1.01 * DAY
    os.utime(leftover, (long_ago, long_ago))
    atomic.write_text(tmp_path / "a.txt", "")
    assert not leftover.exists()


def test_an_old_session_stays_while_its_process_runs(tmp_path):
    long_ago = time.time() - 1.01 * DAY
    sessions = [
        tmp_path / leftover_of(pid, atomic.SESSION)
        for pid in (1, pid_of_ended_process())
    ]
    for session in sessions:
        session.mkdir()
        os.utime(session, (long_ago, long_ago))
    atomic.remove_leftovers(tmp_path)
    assert [session.exists() for session in sessions] == [True, False]


WRITER = """
import os, pickle, sys
from pathlib import Path
from einschalt.interfaces.files import result_folder
import pyogrio, shapely
result = pickle.loads(Path(sys.argv[1]).read_bytes())
report = result_folder.render(result)  # drawn once: the children only write
result_folder.render = lambda _: report
for line in sys.stdin:  # one child for each folder: only the first has to import
    child = os.fork()
    if child == 0:
        while True:
            result_folder.write_result(result, line.strip())
    print(child, flush=True)
    os.waitpid(child, 0)
    print("ended", flush=True)
"""


@pytest.fixture(scope="module")
def large_result(good_result):
    """A result whose files take long enough to be cut in the middle."""
    residuals = pd.concat([good_result.residuals] * 25, ignore_index=True)
    result = changed(good_result, residuals=residuals)
    result = replace(result, stopwatch=Stopwatch())  # that every process knows
    assert result.assessment  # once, not by each writer
    return result


@pytest.fixture
def writer(tmp_path, large_result):
    """A process that writes the result again and again, until it is killed."""
    pickled = tmp_path / "result.pickle"
    pickled.write_bytes(pickle.dumps(large_result))
    with subprocess.Popen(
        [sys.executable, "-c", WRITER, pickled],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        yield process
        process.stdin.close()


def kill_after(writer, folder, pattern, n_files, seconds):
    """Kill the child some time after it has so many files of a pattern."""
    writer.stdin.write(f"{folder}\n")
    writer.stdin.flush()
    child = int(writer.stdout.readline())
    while len(list(folder.glob(pattern))) < n_files:
        os.kill(child, 0)  # is an error where it has ended by itself
        time.sleep(1e-4)
    time.sleep(seconds)
    os.kill(child, signal.SIGKILL)
    assert writer.stdout.readline() == "ended\n"


STAGED, NAMED = ".einschalt-*/*", "[!.]*"


def named_files(folder):
    return list(folder.glob(NAMED))


def without_time(name, data):
    """provenance.json tells when it was written, once, and its seal depends on that."""
    if name != "provenance.json":
        return data
    timed = (b'"created":', b'"seal":')
    return b"\n".join(
        line for line in data.splitlines() if not line.strip().startswith(timed)
    )


@pytest.mark.slow
def test_killed_writers_leave_only_whole_files(
    tmp_path, writer, large_result, good_result, monkeypatch
):
    write_result(large_result, tmp_path / "undisturbed")
    report = (tmp_path / "undisturbed" / "report.html").read_text(encoding="utf-8")
    monkeypatch.setattr(result_folder, "render", lambda _: report)
    whole = {
        path.name: without_time(path.name, path.read_bytes())
        for path in (tmp_path / "undisturbed").iterdir()
    }
    random = np.random.default_rng(1971)
    folders = [tmp_path / f"killed_{k}" for k in range(24)]
    n_cut = 0
    for place, folder in enumerate(folders):
        # by what is there, not by the clock: computers are slow, fast and busy. Before
        # the files have their places, and while they are given them or later
        pattern = STAGED if place % 2 else NAMED
        n_files = 1 + place % (len(whole) - 1)
        kill_after(writer, folder, pattern, n_files, random.uniform(0.0, 0.03))
        named = named_files(folder)
        for path in named:
            data = without_time(path.name, path.read_bytes())
            assert data == whole[path.name], f"{path.name} is not whole"
        n_cut += len(named) < len(whole)
    assert n_cut >= 3  # otherwise nothing was cut, and nothing shown
    hidden = [p for folder in folders for p in folder.glob(".*")]
    for folder in {Path(path).parent for path in hidden}:
        write_result(good_result, folder)  # of the same block, with as many files
        assert {path.name for path in folder.iterdir()} == set(whole)
