"""One writer per folder: a lock that the operating system lets go when its holder ends.

The lock lies on a hidden file. It says who holds it, and is removed at the end; after
a crash it stays, unlocked, and the next one takes it over.
"""

import os
import platform
from contextlib import contextmanager, suppress
from pathlib import Path

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.atomic import said_as_file_error

if os.name == "nt":
    import msvcrt
else:
    import fcntl

LOCK = ".einschalt-lock"


@contextmanager
def locked(folder, *, waits=False):
    """Hold the lock of a folder.

    Parameters
    ----------
    folder : str or Path
        It exists.
    waits : bool, optional
        Wait until the other one has ended, instead of saying that there is one.

    Raises
    ------
    FileError
        Another process holds it, or the folder cannot be written.
    """
    path = Path(folder) / LOCK
    with said_as_file_error(path):
        descriptor = _taken(path, waits)
    try:
        if descriptor is None:
            raise FileError(
                f"another run writes into this folder{_holder(path)}",
                expected="one run at a time",
                remedy="Wait until it has ended, or choose another folder",
                file=folder,
            )
        yield
    finally:
        if descriptor is not None:
            with suppress(OSError):  # Windows removes no file that is open
                path.unlink()
            os.close(descriptor)


def _taken(path, waits):
    """Open and lock the file; None where somebody else holds it."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        is_taken = False
        try:
            if not _lock(descriptor, waits):
                return None
            if _is_same(descriptor, path):  # or its holder has removed it meanwhile
                said = f"process {os.getpid()} on {platform.node()}".encode()
                os.truncate(descriptor, 0)
                os.write(descriptor, said)
                is_taken = True
                return descriptor
        finally:  # on a full disk as well: what is left open stays locked
            if not is_taken:
                os.close(descriptor)


def _lock(descriptor, waits):
    try:
        if os.name == "nt":
            mode = msvcrt.LK_LOCK if waits else msvcrt.LK_NBLCK
            msvcrt.locking(descriptor, mode, 1)
        else:
            mode = fcntl.LOCK_EX if waits else fcntl.LOCK_EX | fcntl.LOCK_NB
            fcntl.flock(descriptor, mode)
    except (BlockingIOError, PermissionError):
        return False
    return True


def _is_same(descriptor, path):
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False


def _holder(path):
    try:
        said = path.read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""
    return f" ({said})" if said else ""
