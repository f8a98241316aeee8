"""Files that were dropped into the page: kept in the folder of the session.

They come one by one, as they are, and are counted while they come: what is too large is
refused before it is stored, and what breaks off leaves nothing.
"""

from dataclasses import dataclass, field
from pathlib import Path

from einschalt.foundations.system_errors import reason_of
from einschalt.interfaces.local_page.refusals import (
    MissingError,
    RefusedError,
    TooLargeError,
    UnstoredError,
)
from einschalt.interfaces.local_page.rooted_paths import Root

MOST_FILES = 500
MOST_DROPS = 100
BYTES_PER_MB = 1e6


@dataclass(eq=False)
class Drop:
    """Files that were dropped together."""

    number: int
    root: Root
    names: list = field(default_factory=list)


class Drops:
    """All that was dropped, up to ``most_bytes`` in one session."""

    def __init__(self, folder, most_bytes):
        self.folder = Path(folder)
        self.most_bytes = most_bytes
        self.n_bytes = 0
        self.all = {}

    def new(self) -> Drop:
        """Make room for files."""
        if len(self.all) >= MOST_DROPS:
            raise TooLargeError(
                f"{MOST_DROPS} drops in one session",
                remedy="Start einschalt serve again",
            )
        number = len(self.all) + 1
        folder = self.folder / f"dropped-{number}"
        try:
            folder.mkdir(mode=0o700)
        except (
            OSError
        ) as error:  # such as a folder for temporary files that was cleared
            raise _unstored(folder, error) from None
        self.all[number] = Drop(number, Root(folder))
        return self.all[number]

    def get(self, number) -> Drop:
        """The files that were dropped under a number."""
        is_number = f"{number}".isascii() and f"{number}".isdecimal()
        known = self.all.get(int(number)) if is_number else None
        if known is None:
            raise MissingError("there are no such files", remedy="Drop them again")
        return known

    async def take(self, drop, name, announced, chunks):
        """Store a file of a drop; nothing of it, where it cannot be whole.

        ``announced``: its size [bytes], None where it was not said; ``chunks``: what
        comes of it.
        """
        self._require_room(announced or 0)
        if len(drop.names) >= MOST_FILES:
            raise TooLargeError(
                f"more than {MOST_FILES} files", remedy="Drop the block alone"
            )
        path = drop.root.find(name, is_new=True)
        n_own, is_whole = 0, False
        file = _new_file(path)
        try:
            with file:
                async for chunk in chunks:
                    self._require_room(len(chunk))
                    self.n_bytes += len(chunk)
                    n_own += len(chunk)
                    file.write(chunk)
            is_whole = True
        except OSError as error:  # such as a disk that is full
            raise _unstored(path, error) from None
        finally:
            if not is_whole:
                self.n_bytes -= n_own  # others may come at the same time
                path.unlink(missing_ok=True)
        drop.names.append(name)

    def _require_room(self, n_bytes):
        if self.n_bytes + n_bytes > self.most_bytes:
            raise TooLargeError(
                f"more than {self.most_bytes / BYTES_PER_MB:.0f} MB were dropped",
                expected="no more in one session",
                remedy="Put the files into the folder of einschalt serve, and open "
                "them there; or start it with a larger --most-upload",
            )


def _new_file(path):
    """Open a file that is not there yet."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        return path.open("xb")
    except FileExistsError:
        raise RefusedError(
            "two files of the same name", remedy="Drop one of them", file=path.name
        ) from None
    except OSError as error:  # such as a name that is too long
        raise _unstored(path, error) from None


def _unstored(path, error):
    return UnstoredError(f"cannot be stored: {reason_of(error)}", file=path.name)
