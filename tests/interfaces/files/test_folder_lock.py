"""One writer per folder."""

import errno
import os
import subprocess
import sys
import textwrap
import threading
import time

import pytest

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.folder_lock import LOCK, locked

HOLDER = """
    import sys
    from einschalt.interfaces.files.folder_lock import locked
    with locked(sys.argv[1]):
        print("held", flush=True)
        sys.stdin.read()
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that holds the lock."""
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(HOLDER), tmp_path],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def test_lock_leaves_nothing_behind(tmp_path):
    for _ in range(2):
        with locked(tmp_path):
            assert (tmp_path / LOCK).exists()
        assert list(tmp_path.iterdir()) == []


def test_the_second_is_told_who_is_first(tmp_path, holder):
    said = rf"another run writes into this folder; process {holder.pid} on "
    with pytest.raises(FileError, match=said), locked(tmp_path):
        pass


def test_a_killed_holder_holds_nothing(tmp_path, holder):
    holder.kill()
    holder.wait()
    assert (tmp_path / LOCK).exists()
    with locked(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_waiting_until_the_other_has_ended(tmp_path):
    inside, order = threading.Event(), []

    def second():
        inside.wait()
        with locked(tmp_path, waits=True):
            order.append("second")

    thread = threading.Thread(target=second)
    thread.start()
    with locked(tmp_path):
        inside.set()
        thread.join(0.2)
        order.append("first")
    thread.join()
    assert order == ["first", "second"]


def test_many_at_once_are_one_at_a_time(tmp_path):
    """Removing the file at the end lets nobody in beside the next holder."""
    n_inside, most = 0, 0

    def work():
        nonlocal n_inside, most
        for _ in range(20):
            with locked(tmp_path, waits=True):
                n_inside += 1
                most = max(most, n_inside)
                time.sleep(1e-4)  # room for another one to come in
                n_inside -= 1

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert (most, n_inside) == (1, 0)


def test_a_full_disk_leaves_the_lock_free(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(os, "write", full)
        with pytest.raises(FileError, match="no space left"), locked(tmp_path):
            pass
    with locked(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_folder_that_is_not_there(tmp_path):
    with (
        pytest.raises(FileError, match="cannot be written: no such file or directory"),
        locked(tmp_path / "nowhere"),
    ):
        pass


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may write")
def test_folder_that_may_not_be_written(tmp_path):
    tmp_path.chmod(0o500)
    with (
        pytest.raises(FileError, match="Choose a folder that you may write into"),
        locked(tmp_path),
    ):
        pass
    tmp_path.chmod(0o700)
