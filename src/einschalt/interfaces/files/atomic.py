"""Files that are written whole or not at all.

A file is written under a hidden name in its own folder, forced to the disk, and only
then given its name, which no reader ever sees half-written. What a killed run leaves
behind is removed by the next run that writes into the same folder.
"""

import errno
import hashlib
import os
import platform
import re
import secrets
import shutil
import time
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

from einschalt.foundations.errors import FileError
from einschalt.foundations.system_errors import reason_of

# place: a digest of the computer's name, since process numbers mean nothing elsewhere
LEFTOVER = re.compile(r"^\.einschalt-(?P<place>[0-9a-f]{6})-(?P<pid>\d+)-[0-9a-f]{8}-")
OLD_SECONDS = 24 * 3600
SESSION = "session"  # what ends so is in use as long as its process runs
REMEDIES = {
    errno.ENOSPC: "Free some space, or choose another folder",
    errno.EDQUOT: "Free some space, or choose another folder",
    errno.EFBIG: "Raise the limit on the size of files, or choose another folder",
    errno.EACCES: "Choose a folder that you may write into",
    errno.EPERM: "Choose a folder that you may write into",
    errno.EROFS: "Choose a folder that you may write into",
    errno.ENOENT: "Make the folder first",
    errno.ENOTDIR: "Choose another folder: a part of the path is a file",
    errno.EEXIST: "Choose another folder: a file has this name",
    errno.EISDIR: "Choose another name: a folder has this one",
    errno.ENAMETOOLONG: "Choose a shorter name",
    # file systems of clusters, as they are mounted by default
    errno.ENOLCK: "Choose a folder on a file system that knows locks",
    errno.ENOSYS: "Choose a folder on a file system that knows locks",
}


@contextmanager
def replacing(path):
    """Give a hidden place to write a file whole; at the end it gets its own name.

    The hidden file lies in the same folder and has the same suffix. An older file is
    replaced, also where it is a link, whose target stays. On a FileError (the folder
    cannot be written, the disk is full) nothing has changed.
    """
    path = Path(path)
    # a link is replaced itself: what it leads to may be anything
    path = Path(os.path.realpath(path.parent)) / path.name
    hidden = path.with_name(hidden_name(path.name))
    with said_as_file_error(path):
        try:
            remove_leftovers(path.parent)
            yield hidden
            _force_to_disk(hidden)
            hidden.replace(path)
        finally:
            _remove_with_sidecars(hidden)


@contextmanager
def said_as_file_error(path):
    """Turn what the operating system refuses into a FileError with a remedy."""
    try:
        yield
    except OSError as error:
        raise FileError(
            f"cannot be written: {reason_of(error)}",
            remedy=REMEDIES.get(error.errno, "Choose another folder"),
            file=path,
        ) from error


def write_bytes(path, data):
    """Write bytes whole or not at all."""
    with replacing(path) as hidden:
        hidden.write_bytes(data)


def write_text(path, text):
    r"""Write text as UTF-8, lines ending with ``\n``, whole or not at all."""
    write_bytes(path, text.encode("utf-8"))


def make_folder(folder) -> Path:
    """Make a folder with its parents, where it does not exist."""
    folder = Path(folder)
    with said_as_file_error(folder):
        folder.mkdir(parents=True, exist_ok=True)
    return folder


def set_aside(path) -> Path:
    """Rename what stands in the way of a file, and give its new name.

    That is a free one: block.toml.1.bak, where there is none before.
    """
    path = Path(path)
    names = (path.with_name(f"{path.name}.{number}.bak") for number in count(1))
    kept = next(name for name in names if not os.path.lexists(name))
    with said_as_file_error(path):
        path.rename(kept)
    return kept


def require_writable(folder, *, file=None):
    """Refuse a place in which nothing can be made, before the work for it is done.

    A folder that is not there yet is made below the first of its parents that is.
    Nothing stays. ``file``: which is named instead of the folder, and whose folder has
    to be there.
    """
    place = Path(os.path.realpath(folder))
    while file is None and not os.path.lexists(place):
        place = place.parent
    with said_as_file_error(folder if file is None else file):
        probe = place / hidden_name("new")
        probe.mkdir(mode=0o700)
        probe.rmdir()


def hidden_name(name):
    """Name, of this process alone, under which something is written until whole."""
    return f"{_own_prefix()}-{secrets.token_hex(4)}-{name}"


def remove_leftovers(folder):
    """Remove hidden files and folders of runs that were killed.

    One goes only if it bears our pattern and its process is gone; where that cannot be
    known (another computer, Windows), only after a day. After a day another process may
    have its number, so that it goes too, but for sessions, which may last longer.
    """
    with os.scandir(folder) as entries:
        names = [entry.name for entry in entries if LEFTOVER.match(entry.name)]
    for name in names:
        if _is_abandoned(folder / name):
            _remove(folder / name)


def _own_prefix():
    return f".einschalt-{_place()}-{os.getpid()}"


def _place():
    return hashlib.sha256(platform.node().encode()).hexdigest()[:6]


def _is_abandoned(leftover):
    match = LEFTOVER.match(leftover.name)
    if os.name == "posix" and match["place"] == _place():
        if int(match["pid"]) == os.getpid():  # whatever the clock says
            return False
        if _is_running(int(match["pid"])):
            is_lasting = leftover.name[match.end() :] == SESSION
            return _is_old(leftover) and not is_lasting
        return True
    return _is_old(leftover)


def _is_old(leftover):
    try:
        return time.time() - leftover.stat().st_mtime > OLD_SECONDS
    except FileNotFoundError:  # its own process has just finished with it
        return False


def _is_running(pid):
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass
    return not _has_ended(pid)


def _has_ended(pid):
    """Whether a process is dead, and its parent has not asked how it ended."""
    try:
        status = Path(f"/proc/{pid}/stat").read_bytes()
    except OSError:  # no Linux, or gone by now: to be on the safe side it runs
        return False
    # the name of the program, in brackets, may hold anything
    return status.rpartition(b")")[2].split()[:1] == [b"Z"]


def _force_to_disk(path):
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _remove_with_sidecars(hidden):
    """Remove the hidden file, and SQLite's journals beside it."""
    for suffix in ("", "-journal", "-wal", "-shm"):
        _remove(hidden.with_name(hidden.name + suffix))


def _remove(path):
    with suppress(OSError):  # read-only by now, or gone: it does no harm
        try:
            path.unlink()
        except FileNotFoundError:  # as most are
            return
        except OSError:
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
