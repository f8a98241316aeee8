"""What must hold however hostile a file is: of messages, and of the files opened."""

import os
import site
import sys
import tempfile
import tomllib
from contextlib import contextmanager
from pathlib import Path

from einschalt.foundations.display_names import printable
from einschalt.foundations.errors import BlockError
from einschalt.interfaces.files.gdal_files import COPIES

LONGEST_MESSAGE = 20_000
LONGEST_OUTPUT = 200_000
ROOT = Path(__file__).parents[1]
CHANGES = {"os.remove", "os.rename", "os.rmdir", "os.link", "os.symlink"}
LOOKS = {"open", "os.listdir", "os.scandir"}
WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
# what Python and its libraries read of themselves
LIBRARIES = tuple(
    os.path.realpath(path)
    for path in (
        *(ROOT / "src", sys.prefix, sys.base_prefix, *site.getsitepackages()),
        *("/proc", "/sys", "/usr/share", "/usr/lib", "/usr/local/share", "/etc/fonts"),
        *(os.devnull, Path.home() / ".cache", Path.home() / ".config/matplotlib"),
        *("/etc/mime.types", "/etc/localtime"),
        # where matplotlib looks for fonts, once on each computer
        *("/usr/X11", "/usr/X11R6", Path.home() / ".fonts"),
        os.environ.get("XDG_DATA_HOME") or Path.home() / ".local/share",
    )
)
# of sheets and layers, for GDAL, which takes no bytes
OWN_COPIES = os.path.join(os.path.realpath(tempfile.gettempdir()), COPIES)  # noqa: PTH118
SEARCHED = {os.path.realpath(path or ".") for path in sys.path}


class Breach(AssertionError):  # noqa: N818 - no error of the program: a finding
    """Something ended otherwise than it must."""


def judge_error(error, name=""):
    """See that an error is short, can be written, and names the file.

    Parameters
    ----------
    error : EinschaltError
    name : str, optional
        Of the file; left out where another one may be at fault.

    Raises
    ------
    Breach
        It is not so.
    """
    judge_text(str(error))
    for problem in error.problems if isinstance(error, BlockError) else (error,):
        judge_text(str(problem))
        if name not in str(problem):
            raise Breach(f"does not name the file: {str(problem)[:200]}")


def judge_text(text, longest=LONGEST_MESSAGE):
    """See that a text is short, and can be written as UTF-8.

    Parameters
    ----------
    text : str
    longest : int, optional

    Raises
    ------
    Breach
        It is not so.
    """
    if len(text) > longest:
        raise Breach(f"a message of {len(text)} characters: {text[:200]}")
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        raise Breach(f"a message that no UTF-8 can hold: {text[:200]!a}") from None


def judge_output(text):
    """See that what a command prints is no traceback, and does not steer a terminal.

    Parameters
    ----------
    text : str

    Raises
    ------
    Breach
        It is not so.
    """
    judge_text(text, LONGEST_OUTPUT)
    if "Traceback (most recent" in text:
        raise Breach(f"a traceback is printed: {text[-200:]}")
    for line in text.split("\n"):
        if printable(line) != line:
            raise Breach(f"the line steers a terminal: {line[:200]!a}")


class _Watch:
    """Keeps which files are opened, while it is asked to."""

    def __init__(self):
        self.opened = None
        sys.addaudithook(self._hear)

    def _hear(self, event, facts):
        if self.opened is None:
            return
        if event in CHANGES:
            # names within an open folder: the removal of a whole one
            if all(_is_path(fact) or fact < 0 for fact in facts if fact is not None):
                self.opened += [(path, True) for path in facts if _is_path(path)]
        elif event == "os.mkdir":
            self.opened.append((facts[0], True))
        elif event in LOOKS and _is_path(facts[0]):
            flags = facts[2] if event == "open" else 0
            self.opened.append((facts[0], bool((flags or 0) & WRITES)))


_watches = []


def _is_path(path):
    return isinstance(path, (str, bytes, os.PathLike))


@contextmanager
def watched(folder, data):
    """See that nothing outside a folder is opened but what the file names itself.

    Parameters
    ----------
    folder : Path
    data : bytes
        Of the hostile file; only block.toml names others.

    Raises
    ------
    Breach
        Another file was opened, or one that is named was written.
    """
    if not _watches:
        _watches.append(_Watch())
    watch = _watches[0]
    watch.opened = []
    try:
        yield
    finally:
        opened, watch.opened = watch.opened, None
    inside = os.path.realpath(folder) + os.sep
    outside = [
        (path, is_written)
        for path, is_written in set(opened)
        if not (os.path.realpath(os.fsdecode(path)) + os.sep).startswith(inside)
    ]
    for path, is_written in outside:
        real = os.path.realpath(os.fsdecode(path))
        # libraries may keep what they have compiled
        is_library = real.startswith((*LIBRARIES, OWN_COPIES)) or real in SEARCHED
        is_named = not is_written and real in _named(folder, data)
        if not (is_library or is_named):
            raise Breach(f"{'writes' if is_written else 'reads'} {real[:200]}")


def _named(folder, data):
    """Files that a block.toml names, and folders in which near names are sought."""
    try:
        parts = [tomllib.loads(data.decode("utf-8-sig", "replace"))]
    except (ValueError, RecursionError):
        return set()
    named = set()
    while parts:
        part = parts.pop()
        if isinstance(part, dict):
            parts += part.values()
        elif isinstance(part, str) and "\0" not in part:
            path = folder / part
            named |= {os.path.realpath(path), os.path.realpath(path.parent)}
    return named
