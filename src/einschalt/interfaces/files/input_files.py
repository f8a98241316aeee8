"""Files as they come in: whether they are there, and whether they are text."""

import codecs
import errno
import hashlib
import os
import re
import stat
from dataclasses import dataclass, field
from pathlib import Path

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import ChangedFileError, FileError, name_some
from einschalt.foundations.limited_memory import gigabytes
from einschalt.foundations.near_words import nearest
from einschalt.foundations.system_errors import reason_of
from einschalt.interfaces.files import opf_parts
from einschalt.pipeline.block.memory import allowed_bytes

ZIP = b"PK\x03\x04"
SIGNATURES = {
    ZIP: ("is a workbook or a zip archive", "Save the sheet as CSV UTF-8"),
    b"\xd0\xcf\x11\xe0": ("is an old Excel workbook", "Save the sheet as CSV UTF-8"),
    b"PAR1": ("is a Parquet file", "Give it the suffix .parquet"),
    b"\x1f\x8b": ("is compressed with gzip", "Unpack it"),
    b"SQLite format 3": ("is an SQLite database", "Export the table as CSV"),
    codecs.BOM_UTF16_LE: ("is UTF-16 text", "Save it as UTF-8"),
    codecs.BOM_UTF16_BE: ("is UTF-16 text", "Save it as UTF-8"),
}
UTF16_MARKS = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
OPENSFM_TRACKS = b"OPENSFM_TRACKS_VERSION_v"
# the first line of older ones has no version: image, track, feature, x y and a colour
OLD_TRACKS = re.compile(
    rb"[^\t\r\n]+\.[A-Za-z]\w*\t\d+\t\d+"
    rb"(\t-?(0?\.\d+|[01]|\d(\.\d+)?e-\d+)){2}(\t\d{1,3}){3}[\r\n]"
)
TRACKS_HEAD = 1024  # bytes that hold the first line
TEXT_SUFFIXES = (".csv", ".txt")
HEAD_BYTES = 2**20  # in which a file must have said something
LARGE_BYTES = 2**28  # read at once, holes or not
LEAST_WRITTEN = 0.01  # share of a file that is no hole


def require_file(path, source, *, taken=()):
    """See that a file is there and can be read.

    ``source`` is its name in messages; files in ``taken`` are named elsewhere, and thus
    cannot have been meant.
    """
    path = Path(path)
    if "\0" in str(path):
        raise FileError(
            f"{shortened(str(path))!r} holds a NUL, so it is no name of a file",
            expected="the name of a file",
            remedy="Correct the name",
        )
    mode = _mode(path, source)
    if mode is None:
        raise _missing(path, source, set(taken))
    if stat.S_ISDIR(mode):
        raise FileError(
            "is a folder", expected="a file", remedy="Name the file in it", file=source
        )
    if not stat.S_ISREG(mode):
        # a device or a pipe may never end, or never begin
        raise FileError(
            "is a device or a pipe",
            expected="a file",
            remedy="Save what it gives as a file",
            file=source,
        )
    try:
        with path.open("rb") as file:
            file.read(1)
        _require_size(path, source)
    except OSError as error:
        raise _refused(error, source) from error
    return path


def _require_size(path, source):
    """Refuse what would not end: more than memory can hold, or nothing but holes."""
    if not is_endless(path):
        return
    size = gigabytes(path.stat().st_size)
    if _is_hollow(path):
        raise FileError(
            f"is {size} large, most of it holes",
            expected="a file of which everything is written",
            remedy="See whether it was copied as a whole",
            file=source,
        )
    raise FileError(
        f"is {size} large",
        expected=f"at most {gigabytes(allowed_bytes() / 2.0)}, half of the memory",
        remedy="See whether it was copied as a whole, or part it",
        file=source,
    )


def is_endless(path) -> bool:
    """Whether a file is too large to be read or hashed.

    A table takes at least twice its size in memory; a file with holes has any size.
    """
    size = path.stat().st_size
    is_large = size > LARGE_BYTES
    return is_large and (size > allowed_bytes() / 2.0 or _is_hollow(path))


def _is_hollow(path):
    """Whether next to nothing of a file is written, as far as the system tells."""
    status = path.stat()
    written = 512 * getattr(status, "st_blocks", status.st_size)
    # file systems that compress keep more of a file than that; those of a network may
    # tell of no blocks, but then of no holes either
    if written > LEAST_WRITTEN * status.st_size or not hasattr(os, "SEEK_HOLE"):
        return False
    with path.open("rb") as file:
        return os.lseek(file.fileno(), 0, os.SEEK_HOLE) < status.st_size


def _mode(path, source):
    """What kind of file it is; None where there is none."""
    try:
        return path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        raise _refused(error, source) from error


def _refused(error, source):
    is_name = error.errno in {errno.ENAMETOOLONG, errno.ELOOP}
    return FileError(
        f"cannot be read: {reason_of(error)}",
        remedy="Correct the name" if is_name else "See to the permissions of the file",
        file=source,
    )


def is_there(path):
    """Whether there is something of that name, be it readable or not."""
    try:
        path.stat()
    except (FileNotFoundError, NotADirectoryError, ValueError):
        return False
    except OSError as error:  # the system refuses to look, or to take such a name
        return error.errno != errno.ELOOP
    return True


def is_folder(path):
    """Whether it is a folder, as far as the system lets one look."""
    try:
        return stat.S_ISDIR(Path(path).stat().st_mode)
    except (OSError, ValueError):
        return False


def _missing(path, source, taken):
    folder = path.parent
    if not folder.is_dir():
        return FileError(
            "the file does not exist, nor does its folder",
            remedy="Correct the path",
            file=source,
        )
    names = sorted(name for name in _names_in(folder) if not name.startswith("."))
    near = _near_file(path, [name for name in names if name not in taken])
    if near:
        remedy = f"Did you mean '{near}'?"
    else:
        remedy = f"Its folder holds {name_some(names) or 'nothing'}"
    return FileError("the file does not exist", remedy=remedy, file=source)


def _near_file(path, names):
    """Name of a file that may be meant: alike without its suffix as well."""
    near = nearest(path.name, names)
    # that both are tables makes no names alike
    return near if near and nearest(path.stem, [Path(near).stem]) else None


def _names_in(folder):
    try:
        return [path.name for path in folder.iterdir()]
    except OSError:  # a folder that one may pass through, and not look into
        return []


@dataclass(frozen=True)
class ReadFile(os.PathLike):
    """A file that was read once: what is signed for is what is understood.

    Every reader takes it in place of the path.
    """

    path: Path
    source: str
    data: bytes = field(repr=False)

    def __fspath__(self):
        """Path of the file, for its name and its suffix."""
        return str(self.path)

    def checksum(self):
        """SHA-256 of what was read, in hexadecimal digits."""
        return hashlib.sha256(self.data).hexdigest()

    def require_unchanged(self):
        """Raise where another program has written the file since it was read."""
        try:
            is_same = checksum(self.path) == self.checksum()
        except OSError:  # it is gone, or is being replaced
            is_same = False
        if not is_same:
            raise ChangedFileError(
                "the file changed while it was read",
                expected="a file that nobody writes",
                remedy="Run it again when the other program has ended",
                file=self.source,
            )


def read_once(path, source) -> ReadFile:
    """Read a file as a whole; what was read before is not read again."""
    if isinstance(path, ReadFile):
        return path
    path = require_file(path, source)
    try:
        return ReadFile(path, source, path.read_bytes())
    except OSError as error:
        raise _refused(error, source) from error


def read_text_bytes(path, source):
    """Read a text file that is UTF-8 and not empty, without a byte order mark."""
    return require_text(read_once(path, source).data, source)


def require_text(data, source, *, is_utf8=False):
    """See that bytes are UTF-8 text and not empty; without a byte order mark.

    ``is_utf8``: this has been seen already.
    """
    refuse_other_kinds(data, source, "UTF-8 text")
    if b"\0" in data:
        raise FileError(
            "holds NUL bytes, so it is no text",
            expected="UTF-8 text",
            remedy="Export the table as CSV UTF-8",
            file=source,
            row=_line_of(data, data.index(b"\0")),
        )
    data = data.removeprefix(codecs.BOM_UTF8)
    # blanks of Unicode as well
    if not data[:HEAD_BYTES].decode("utf-8", errors="replace").strip():
        raise FileError(
            "the file is empty", remedy="Fill it, or name another file", file=source
        )
    if not is_utf8 and not data.isascii():
        _require_utf8(data, source)
    return data


def refuse_other_kinds(data, source, expected):
    """Refuse what its first bytes show to be no table of text, and say what it is."""
    if data.startswith(ZIP) and source.lower().endswith(".zip"):
        raise FileError(
            "is a zip archive", expected=expected, remedy="Unpack it", file=source
        )
    for signature, (found, remedy) in SIGNATURES.items():
        if data.startswith(signature):
            raise FileError(found, expected=expected, remedy=remedy, file=source)


def _require_utf8(data, source):
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        start = data.rfind(b"\n", 0, error.start) + 1
        text = data[start:].split(b"\n", 1)[0].decode("cp1252", errors="replace")
        raise FileError(
            f"{text.strip()[:60]!r} is not UTF-8",
            expected="UTF-8 text",
            remedy="Save the file as UTF-8; it seems to be in a Windows or Latin-1 "
            "encoding",
            file=source,
            row=_line_of(data, error.start),
        ) from error


def _line_of(data, place):
    return data.count(b"\n", 0, place) + 1


def companions(path):
    """Files without which one cannot be understood.

    Those beside a shapefile, those of which a project of OPF consists, and
    reconstructions beside control or tracks of OpenSfM, which have the sizes of its
    images.
    """
    path = Path(path)
    if path.suffix.lower() == opf_parts.SUFFIX:
        return opf_parts.files_beside(path)
    if path.suffix.lower() == ".json" or _is_tracks(path):
        return reconstructions(path)
    if path.suffix.lower() != ".shp":
        return []
    suffixes = (".shx", ".dbf", ".prj", ".cpg")
    beside = [path.with_suffix(s) for s in suffixes]
    if path.suffix.isupper():
        beside = [path.with_suffix(s.upper()) for s in suffixes]
    return [one for one in beside if one.is_file()]


def reconstructions(path):
    """Reconstructions of OpenSfM beside a file."""
    return sorted(Path(path).parent.glob("reconstruction*.json"))


def are_opensfm_tracks(head):
    """Whether the first bytes of a file are those of tracks of OpenSfM."""
    return head.startswith(OPENSFM_TRACKS) or OLD_TRACKS.match(head) is not None


def _is_tracks(path):
    """Whether a file holds tracks of OpenSfM, whatever its name."""
    if path.suffix.lower() not in TEXT_SUFFIXES:
        return False
    try:
        if not path.is_file():  # a device or a pipe may never end
            return False
        with path.open("rb") as file:
            return are_opensfm_tracks(file.read(TRACKS_HEAD))
    except (OSError, ValueError):  # who reads the file will say it
        return False


def checksum(path):
    """SHA-256 of a file, in hexadecimal digits; empty where it is little but holes."""
    path = Path(path)
    if path.stat().st_size > LARGE_BYTES and _is_hollow(path):
        return ""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def checksum_or_none(path):
    """SHA-256 of a file; None where it is missing, or cannot be read."""
    try:
        # a device or a pipe may never end, and a file with holes has any size
        is_read = path.is_file() and not is_endless(path)
        return checksum(path) if is_read else None
    except (OSError, ValueError):  # the computation will say it
        return None
