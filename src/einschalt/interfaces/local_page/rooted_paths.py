"""Paths that a page names: below the folder that was given at the start, or refused."""

import os
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath

from einschalt.foundations.display_names import shortened
from einschalt.interfaces.files.block_toml import BLOCK_FILE
from einschalt.interfaces.files.written_files import PROVENANCE, evidence_of
from einschalt.interfaces.local_page.refusals import (
    MissingError,
    OutsideError,
    RefusedError,
)

REPORT = "report.html"
MOST_ENTRIES = 400  # of a folder that are shown
MOST_FOLDERS = 2_000  # in which results are looked for
DEEPEST = 4


@dataclass(frozen=True)
class Entry:
    """A folder as it is listed."""

    name: str
    path: str  # from the root, with slashes
    kind: str  # block, result or folder


class Root:
    """A folder out of which no path leads: no link, and no ``..``."""

    def __init__(self, folder):
        self.path = Path(os.path.realpath(folder))

    def find(self, text, *, is_new=False) -> Path:
        """Path that a page names from the root, links followed.

        OutsideError where it is absolute, hidden, or leads out; MissingError where
        nothing is there, unless it is to be made; RefusedError where it cannot be made.
        """
        path = Path(os.path.realpath(self.path.joinpath(*_parts_of(text))))
        self.require_inside(path, text)
        if is_new:
            _require_possible(path, text)
        elif not _is_there(path):
            raise MissingError(
                f"there is no {shortened(text) or path.name}",
                expected="a file or folder that is there",
                remedy="It may have been moved: go back, and open it again",
            )
        return path

    def folder(self, text) -> Path:
        """Folder that a page names from the root."""
        path = self.find(text)
        if not path.is_dir():
            raise MissingError(f"{shortened(text)} is no folder", expected="a folder")
        return path

    def require_inside(self, path, said=None):
        """Refuse a file that does not lie below the root, by whatever links."""
        if not Path(os.path.realpath(path)).is_relative_to(self.path):
            raise _outside(said or Path(path).name)

    def name(self, path) -> str:
        """Path from the root, as pages name it; the root itself is empty."""
        text = Path(path).relative_to(self.path).as_posix()
        return "" if text == "." else text

    def entries(self, folder):
        """Folders in a folder, the blocks and results first told; how many are cut."""
        found = []
        for path in sorted(_folders_in(folder), key=lambda one: one.name.casefold()):
            real = Path(os.path.realpath(path))
            if real.is_relative_to(self.path) and is_name(path.name):
                found.append(Entry(path.name, self.name(real), kind_of(real)))
        return found[:MOST_ENTRIES], max(len(found) - MOST_ENTRIES, 0)

    def results(self):
        """Folders with results, by their paths from the root."""
        found, waiting, n_seen = [], [(self.path, 0)], 0
        while waiting and n_seen < MOST_FOLDERS:
            folder, depth = waiting.pop(0)
            n_seen += 1
            if kind_of(folder) == "result":
                found.append(self.name(folder))
            elif depth < DEEPEST:
                below = sorted(_folders_in(folder))
                waiting += [(one, depth + 1) for one in below if not one.is_symlink()]
        return sorted(name for name in found if is_name(name))


def kind_of(folder):
    """What a folder is."""
    if (folder / BLOCK_FILE).is_file():
        return "block"
    if (folder / REPORT).is_file() and (folder / PROVENANCE).is_file():
        return "result"
    return "folder"


def require_result(folder):
    """Refuse a folder whose report einschalt has not written as it is now."""
    if not evidence_of(folder).vouches_for(REPORT):
        raise MissingError(
            "the folder holds no report as einschalt has written it",
            expected="a folder with the results of einschalt densify",
            remedy="Compute the block again",
            file=folder.name,
        )


def is_name(text):
    """Whether a name can be written into a page: some names of files are no text."""
    return not any("\ud800" <= char <= "\udfff" for char in text)


def _is_there(path):
    try:
        return path.exists()
    except OSError:  # such as a name that is too long
        return False


def _require_possible(path, text):
    """Refuse what the system takes for no name of a file or folder."""
    try:
        path.lstat()
    except FileNotFoundError:
        return
    except OSError as error:  # a name that is too long, a file where a folder must be
        raise RefusedError(
            f"{shortened(text)} cannot be the name of a file or folder",
            expected="a short name, with no file where a folder must be",
            remedy="Give another name",
        ) from error


def _parts_of(text):
    parts = [part for part in text.split("/") if part not in ("", ".")]
    is_hidden = any(part.startswith(".") for part in parts)
    is_elsewhere = text.startswith("/") or PureWindowsPath(text).drive
    if is_hidden or is_elsewhere or "\\" in text or "\0" in text:
        raise _outside(text)
    return parts


def _outside(text):
    return OutsideError(
        f"{shortened(text)!r} is not below the folder that einschalt serve was given",
        expected="a file or folder in it, named from there and not hidden",
        remedy="Start einschalt serve with a folder that holds it",
    )


def _folders_in(folder):
    try:
        with os.scandir(folder) as entries:
            return [
                Path(entry.path)
                for entry in entries
                if not entry.name.startswith(".") and entry.is_dir()
            ]
    except OSError:  # not ours to look into
        return []
