"""Which files of a folder einschalt wrote itself: known by evidence, never by name.

provenance.json lists what was written with its SHA-256, and carries a seal over its own
content. A file that differs from what is listed has been changed since, and is the
user's. While files are exchanged, two hidden lists stand in for provenance.json: what
lay there before, and what will lie there.
"""

import hashlib
import json
import os
import stat
from dataclasses import dataclass
from pathlib import Path

from einschalt.foundations.display_names import as_unicode
from einschalt.interfaces.files.input_files import checksum, is_endless
from einschalt.interfaces.provenance import digest

PROVENANCE = "provenance.json"
COMING = ".einschalt-coming.json"
FORMER = ".einschalt-former.json"
FAILURE = "failure.json"
GEOPACKAGE = "block.gpkg"
MARKS = ".einschalt-batch.json"
SELF_EVIDENT = (COMING, PROVENANCE, FORMER, FAILURE, MARKS)
# a batch of the first version listed neither of them
UNLISTED_AT_FIRST = (FAILURE, "changes.csv", "previous_points.parquet")
# a crash may leave files without content, in which nothing can be lost
EMPTY = hashlib.sha256(b"").hexdigest()
NOT_KNOWN = "not known"  # to the first version, which told blocks by their names
ORIGIN = {"command", "name", "place", "inputs"}
SEAL = "seal"
BLOCKS = "blocks"
PROGRAM = "einschalt"


@dataclass(frozen=True)
class Source:
    """What results come from, by which they are told from those of another block."""

    command: str
    name: str = ""  # of the block, or of what was asked
    files: tuple[Path, ...] = ()  # block.toml, or the tables; none for a script
    inputs: str | None = None  # digest of the content of all inputs

    def origin(self, folder):
        """Describe it as it stands in the provenance.json of results in a folder.

        ``place`` is a digest of the way from the results to the block, which names no
        folder.
        """
        ways = [_way(path, folder) for path in self.files]
        return {
            "command": self.command,
            "name": self.name,
            "place": digest(ways) if ways else None,
            "inputs": self.inputs,
        }


def _way(path, folder):
    path, folder = os.path.realpath(path), os.path.realpath(folder)
    try:
        return os.path.relpath(path, folder)
    except ValueError:  # on another drive
        return path


def is_same_source(one, other) -> bool:
    """Whether results are of the same block, perhaps of other input or settings.

    The block lies where it lay; or it lies elsewhere, has the same name, and not a byte
    of its input is another one.
    """
    if one["command"] != other["command"]:
        return False
    places = {one["place"], other["place"]}
    if len(places) == 1 and None not in places:
        return True
    if one["name"] != other["name"]:
        return False
    # tables of a script have no place
    is_unplaced = places == {None} or NOT_KNOWN in places
    return is_unplaced or one["inputs"] == other["inputs"]


def sealed_text(content) -> str:
    """JSON with a ``seal``: whoever changes anything makes it his own file."""
    content = json.loads(as_unicode(json.dumps(content, ensure_ascii=False)))
    whole = {**content, SEAL: _seal(content)}
    return json.dumps(whole, indent=2, ensure_ascii=False) + "\n"


def _seal(content):
    text = json.dumps(
        {key: value for key, value in content.items() if key != SEAL}, sort_keys=True
    )
    return hashlib.sha256(text.encode("ascii")).hexdigest()


@dataclass(frozen=True)
class Evidence:
    """What is known of the files that einschalt wrote into a folder."""

    folder: Path
    checksums: dict  # what each file may hold, a set by name
    origin: dict | None  # None where there is no sign of results

    def vouches_for(self, name):
        """Whether a file is there as einschalt has written it."""
        return self.checksum_of(name) is not None

    def checksum_of(self, name):
        """SHA-256 of a file; None if missing, a link, changed, or of somebody else."""
        known = self.checksums.get(name, ())
        path = self.folder / name
        try:
            if not known or not stat.S_ISREG(path.lstat().st_mode):
                return None
            found = checksum(path)
            known = {*known, EMPTY}
        except (OSError, ValueError):  # a name that cannot be one of a file
            return None
        return found if found in known else None

    def present(self):
        """SHA-256 by name of the files that are there as einschalt wrote them."""
        found = {name: self.checksum_of(name) for name in self.checksums}
        return {name: sign for name, sign in found.items() if sign is not None}


def evidence_of(folder) -> Evidence:
    """Look for what einschalt has written into a folder."""
    folder = Path(folder)
    checksums, origins = {}, []
    for name in SELF_EVIDENT:
        data, content = _own_file(folder / name)
        if content is None:
            continue
        origins.append(_origin_in(content, name))
        listed = {name: hashlib.sha256(data).hexdigest(), **_outputs(content)}
        if name == PROVENANCE and SEAL not in content:
            listed |= _unlisted_at_first(folder)
        for file, sign in listed.items():
            checksums.setdefault(file, set()).add(sign)
    return Evidence(folder, checksums, origins[0] if origins else None)


def is_interrupted(folder) -> bool:
    """Whether results were being put in place, or nothing says any more what they are.

    A list of an exchange of files is there; or provenance.json is missing, or cut off,
    so that it is no JSON.
    """
    if any(_own_file(folder / name)[1] is not None for name in (COMING, FORMER)):
        return True
    path = folder / PROVENANCE
    if not path.is_file():
        return not os.path.lexists(path)
    try:
        if not is_endless(path):
            json.loads(path.read_bytes())
    except ValueError:
        return True
    except (OSError, RecursionError):
        pass
    return False


def names_of_batch(folder) -> frozenset:
    """Names of the blocks whose results a batch has put below its folder.

    By its own provenance.json, and while it runs by its marks.
    """
    names = set()
    for name in (PROVENANCE, MARKS):
        content = _own_file(folder / name)[1] or {}
        known = content.get(BLOCKS)
        if SEAL in content and isinstance(known, (list, dict)):
            names.update(as_unicode(name) for name in known)
    return frozenset(names)


def _own_file(path):
    """Bytes and content of a file that bears our seal, or is of the first version."""
    try:
        if not stat.S_ISREG(path.lstat().st_mode) or is_endless(path):
            return None, None
        data = path.read_bytes()
        content = json.loads(data)
        is_own = isinstance(content, dict) and _is_own(content, path.name)
        # brackets may be nested more deeply than Python can follow
    except (OSError, ValueError, RecursionError):
        return None, None
    return (data, content) if is_own else (None, None)


def _is_own(content, name):
    if SEAL in content:
        return content[SEAL] == _seal(content)
    return content.get("program") == PROGRAM or name == MARKS


def _outputs(content):
    outputs = content.get("outputs")
    if not isinstance(outputs, dict):
        return {}
    return {
        name: sign
        for name, sign in outputs.items()
        # no path, which would lead elsewhere
        if Path(name).name == name and isinstance(sign, str)
    }


def _origin_in(content, name):
    origin = content.get("origin")
    if isinstance(origin, dict) and set(origin) == ORIGIN:
        return {key: value and str(value) for key, value in origin.items()}
    block = content.get("block")
    known = block.get("name") if isinstance(block, dict) else None
    known = known if isinstance(known, str) else ""
    command = "batch" if name == MARKS else "densify"
    return {"command": command, "name": known, "place": NOT_KNOWN, "inputs": None}


def _unlisted_at_first(folder):
    found = {}
    for name in UNLISTED_AT_FIRST:
        path = folder / name
        if path.is_file() and not path.is_symlink():
            found[name] = checksum(path)
    return found
