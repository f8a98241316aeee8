"""One writer per folder: a lock that the operating system lets go when its holder ends.

The lock lies on a hidden file. It says who holds it, and is removed at the end; after
a crash it stays, unlocked, and the next one takes it over. Locks of a network file
system hold between computers as well.
"""

import os
import platform
import re
import stat
import sys
import threading
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from einschalt.foundations.errors import OutputError
from einschalt.foundations.kept_texts import retold
from einschalt.interfaces.files.atomic import said_as_file_error

LOCK = ".einschalt-lock"
PATIENCE_SECONDS = 600.0
POLL_SECONDS = 0.02
OURS = re.compile(rb"(process \d+ on [^\n]*)?")
MOST_BYTES = 1024
# a run that has locked a folder writes into it through several doors
HELD = threading.local()


@contextmanager
def locked(folder, *, waits=False):
    """Hold the lock of a folder that exists.

    With ``waits``, until the other one has ended, for ten minutes at most, and it is
    said on standard error; without, or after that, an OutputError tells who holds it.
    """
    path = Path(os.path.realpath(folder)) / LOCK
    held = HELD.__dict__.setdefault("paths", set())
    if path in held:
        yield
        return
    _require_own(path)
    # where the file system knows no locks that is said, nothing weaker is taken
    lock = FileLock(path, mode=0o644, thread_local=False, fallback_to_soft=False)
    with said_as_file_error(path):
        path.parent.stat()  # the library would make it
        is_ours = _is_acquired(lock, path, PATIENCE_SECONDS if waits else 0.0)
    if not is_ours:
        found = ["another run writes into this folder", _holder(path)]
        if waits:
            found.append(f"waited {PATIENCE_SECONDS:g} s for it to end")
        raise OutputError(
            "; ".join(filter(None, found)),
            expected="one run at a time",
            remedy="Wait until it has ended, or choose another folder",
            file=folder,
        )
    held.add(path)
    try:
        with said_as_file_error(path):
            _sign(path)
        yield
    finally:
        held.discard(path)
        with suppress(OSError):  # Windows removes no file that is open
            path.unlink()
        lock.release()


def _require_own(path):
    """Refuse to write into a file that is no lock of ours, or that others share."""
    try:
        status = path.lstat()
        data = path.read_bytes() if _is_small_file(status) else None
    except OSError:  # none is there, or it may not be read: locking will say it
        return
    if data is None or not OURS.fullmatch(data.strip()):
        raise OutputError(
            "is no lock of einschalt, but has its name",
            expected="no file of this name, and no link",
            remedy="Remove it, or choose another folder",
            file=path,
        )


def _is_small_file(status):
    # a link, also a hard one, leads to a file of somebody else
    is_alone = stat.S_ISREG(status.st_mode) and status.st_nlink <= 1
    return is_alone and status.st_size <= MOST_BYTES


def _is_acquired(lock, path, patience):
    for timeout in dict.fromkeys((0.0, patience)):
        if timeout:
            _say(f"waiting for at most {timeout:g} s: {path.parent} is in use", path)
        with suppress(Timeout):
            lock.acquire(timeout=timeout, poll_interval=POLL_SECONDS)
            return True
    return False


def _say(text, path):
    with suppress(OSError, AttributeError):  # nobody listens
        said = "; ".join(filter(None, [text, _holder(path)]))
        print(f"einschalt: {retold(said)}", file=sys.stderr, flush=True)


def _sign(path):
    flags = os.O_WRONLY | getattr(os, "O_NOFOLLOW", 0)
    descriptor = os.open(path, flags)
    try:
        os.truncate(descriptor, 0)
        os.write(descriptor, f"process {os.getpid()} on {platform.node()}".encode())
    finally:
        os.close(descriptor)


def _holder(path):
    try:
        return path.read_bytes()[:MOST_BYTES].decode("utf-8", errors="replace").strip()
    except OSError:
        return ""
