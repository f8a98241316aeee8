"""Where results go: into a folder in which nothing is lost by it.

Nothing that was read is ever written. A folder that holds what einschalt did not write,
or results of another block, is refused unless the user says ``overwrite``. All files
are first written into a hidden folder within the folder, and given their places when
the last one is whole: until then the older result stands as it was.
"""

import os
import shutil
from collections.abc import Callable
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from einschalt.foundations.errors import EinschaltError, OutputError, name_some
from einschalt.foundations.interruptions import uninterrupted
from einschalt.interfaces.files.atomic import (
    LEFTOVER,
    hidden_name,
    make_folder,
    remove_leftovers,
    said_as_file_error,
    write_text,
)
from einschalt.interfaces.files.block_toml import BLOCK_FILE
from einschalt.interfaces.files.folder_lock import LOCK, locked
from einschalt.interfaces.files.input_files import checksum, checksum_or_none
from einschalt.interfaces.files.inputs_of_blocks import block_reading, signs_of_inputs
from einschalt.interfaces.files.written_files import (
    COMING,
    FORMER,
    GEOPACKAGE,
    MARKS,
    PROVENANCE,
    Evidence,
    Source,
    evidence_of,
    is_interrupted,
    is_same_source,
    sealed_text,
)

# what systems and file managers put into a folder by themselves
CLUTTER = {".ds_store", "thumbs.db", "desktop.ini", "lost+found", ".directory"}
# a database that was open when its program ended; another one must not meet them
SIDECARS = ("-wal", "-shm", "-journal")
PREVIOUS = "previous_points.parquet"  # kept before the points that it was are replaced
OTHER_FOLDER = "a new or empty folder, or one with results of the same input"
NAME_ANOTHER = "Name another folder"
OR_OVERWRITE = f"{NAME_ANOTHER}, or give --overwrite (in Python overwrite=True)"


class InputFiles:
    """Files that a run reads, known by what they are and not by how they are called."""

    def __init__(self, paths=()):
        self.paths = tuple(Path(path) for path in paths)

    @cached_property
    def _identities(self):
        known = set()
        for path in self.paths:
            known.add(os.path.realpath(path))
            with suppress(OSError):
                known.add(_identity(path.stat()))
        return known

    @cached_property
    def _signs(self):
        """What a result that is read was computed from: those that lie elsewhere."""
        listing = [path for path in self.paths if path.name == PROVENANCE]
        return set().union(*map(signs_of_inputs, listing))

    def were_read(self, path):
        """Whether a result among them was computed from a file of this content."""
        return bool(self._signs) and checksum_or_none(path) in self._signs

    def has(self, path):
        """Whether a path leads to one of them: itself, by a link, or a hard link."""
        if os.path.realpath(path) in self._identities:
            return True
        try:
            return _identity(path.stat()) in self._identities
        except OSError:
            return False

    def signed(self):
        """Name and SHA-256 of each, for provenance.json."""
        return [{"file": p.name, "sha256": checksum_or_none(p)} for p in self.paths]


def _identity(status):
    # a file system that counts no files gives all of them 0
    return (status.st_dev, status.st_ino) if status.st_ino else None


@dataclass(frozen=True)
class Output:
    """What a command is about to write."""

    source: Source
    names: frozenset  # files that it may write, as far as that is known before
    inputs: InputFiles
    overwrite: bool = False  # replace what lies there, inputs excepted
    folders: frozenset = frozenset()  # known ones in it: of the blocks of a batch
    # the batch that made the folder says so: where a run was interrupted, or its
    # provenance.json is lost, files are known by their names then
    is_known: bool = False


def refuse_block_folder(folder, inputs=None):
    """Refuse a folder that holds a block as the place for results.

    Tables of a block and of a result have the same names: its measurements would be
    overwritten. The first of the inputs is the block's own file, whatever its name.
    """
    folder = Path(folder)
    own = inputs.paths[:1] if inputs is not None else ()
    is_home = any(_is_same_folder(folder, path.parent) for path in own)
    if is_home or os.path.lexists(folder / BLOCK_FILE):
        raise OutputError(
            "the folder holds a block, whose tables would be overwritten",
            expected="a folder of its own for the results",
            remedy=NAME_ANOTHER,
            file=folder,
        )


def _is_same_folder(one, other):
    try:
        return one.samefile(other)
    except OSError:
        return False


def require_free(folder, output):
    """Refuse a folder in which something would be lost; nothing is written.

    An input would be replaced; or it holds what einschalt did not write, or results of
    something else, and ``overwrite`` was not said.
    """
    folder = Path(folder)
    if not os.path.lexists(folder):
        # new/.. is there as soon as new is made
        folder = Path(os.path.realpath(folder))
        if not os.path.lexists(folder):
            return
    if not folder.is_dir():
        raise OutputError(
            "cannot be written: it is no folder",
            remedy="Choose another folder: a file or a broken link has this name",
            file=folder,
        )
    if output.source.command != "block":
        is_of_block = output.source.command == "densify"
        refuse_block_folder(folder, output.inputs if is_of_block else None)
    taken = _taken_names(folder, {*output.names, COMING, FORMER})
    for name in taken:
        refuse_input(folder / name, output)
    for name in taken:
        if (folder / name).is_dir() and not (folder / name).is_symlink():
            raise OutputError(
                "is a folder",
                expected="a file, or none",
                remedy=NAME_ANOTHER,
                file=folder / name,
            )
    if not output.overwrite:
        _refuse_foreign(folder, output, taken)


def _taken_names(folder, names):
    """Names of the output that are taken: of files, links or folders."""
    return sorted(name for name in names if os.path.lexists(folder / name))


def _names_in(folder):
    with said_as_file_error(folder):
        return sorted(path.name for path in folder.iterdir())


def refuse_input(path, output):
    """Refuse to replace an input, also where the user says overwrite.

    Of this run; of the result that it reads; or of any block, but where a block is
    written in place of another one.
    """
    found = None
    is_block = output.source.command == "block"
    if output.inputs.has(path):
        found = "the run reads this file, and would write it"
    elif output.inputs.were_read(path):
        found = "the result was computed from this file, and would replace it"
    elif not is_block and (toml := block_reading(path)) is not None:
        found = f"is an input of the block {toml.parent}, and would be replaced"
    if found is not None:
        said = [found, "inputs are never overwritten"]
        raise OutputError(
            "; ".join(said if output.overwrite else said[:1]),
            expected="a folder of its own for the results",
            remedy=NAME_ANOTHER,
            file=path,
        )


def _refuse_foreign(folder, output, taken):
    evidence = _evidence(folder, output)
    foreign = [name for name in taken if not evidence.vouches_for(name)]
    # other programs write into it when they open it
    is_opened = foreign == [GEOPACKAGE] and GEOPACKAGE in evidence.checksums
    if foreign and not (is_opened and not (folder / GEOPACKAGE).is_symlink()):
        changed = [name for name in foreign if name in evidence.checksums]
        if PROVENANCE in foreign:  # it vouches for the others, if for itself
            foreign = changed = [PROVENANCE]
        if changed:
            held = name_some(changed)
            found = f"the folder holds {held}, changed since einschalt wrote it"
        else:
            held = name_some(foreign)
            found = f"the folder holds {held}, not written by einschalt"
        raise OutputError(
            found,
            expected=OTHER_FOLDER,
            remedy=OR_OVERWRITE,
            file=folder,
        )
    if evidence.origin is None:
        _refuse_content(folder, output)
    elif not is_same_source(evidence.origin, output.source.origin(folder)):
        command, name = evidence.origin["command"], evidence.origin["name"]
        is_block = command == "densify"
        what = f"another block, {name!r}" if is_block else "other input"
        raise OutputError(
            f"the folder holds results of {what} (einschalt {command})",
            expected=OTHER_FOLDER,
            remedy=OR_OVERWRITE,
            file=folder,
        )


def _evidence(folder, output):
    """What is known of a folder; of a half-written one that is known, all its files."""
    evidence, origin = evidence_of(folder), output.source.origin(folder)
    is_same = evidence.origin is None or is_same_source(evidence.origin, origin)
    if not (output.is_known and is_same and is_interrupted(folder)):
        return evidence
    names = [name for name in _names_in(folder) if not _may_lie(folder, name, output)]
    paths = [folder / name for name in names]
    is_ours = {*names} <= {*output.names, COMING, FORMER}
    if not is_ours or any(path.is_symlink() or not path.is_file() for path in paths):
        return evidence
    with said_as_file_error(folder):
        return Evidence(folder, {p.name: {checksum(p)} for p in paths}, origin)


def _refuse_content(folder, output):
    """Refuse a folder that is somebody's: all that lies in it is not ours."""
    others = [name for name in _names_in(folder) if not _may_lie(folder, name, output)]
    if others:
        raise OutputError(
            f"the folder holds {name_some(others)}, not written by einschalt",
            expected=OTHER_FOLDER,
            remedy=OR_OVERWRITE,
            file=folder,
        )


def _may_lie(folder, name, output):
    if name.casefold() in CLUTTER or name == LOCK or LEFTOVER.match(name):
        return True
    if not (folder / name).is_dir():
        return False
    is_result = output.folders and evidence_of(folder / name).origin is not None
    return name in output.folders or is_result


@contextmanager
def held_folder(folder, output):
    """Keep a folder for a run that computes first, and writes at its end.

    It is made where it does not exist, and removed again where nothing was written.
    """
    folder = Path(folder)
    require_free(folder, output)
    is_new = not folder.exists()
    make_folder(folder)
    try:
        with locked(folder):
            yield
    except BaseException:
        if is_new:
            with suppress(OSError):  # it holds something by now
                folder.rmdir()
        raise


def write_folder(folder, output, facts, write: Callable, *, beside=False):
    """Write results, all of them or none; on an error older files are as they were.

    ``facts`` is what provenance.json says beside ``outputs``, None of a block, which
    has none. ``write`` writes all files into the folder that it is given. With
    ``beside``, where the folder must be refused, the results go into a new one beside
    it, so that nothing is lost, and the OutputError says so.
    """
    folder = Path(folder)
    try:
        # what is no folder is said by make_folder
        with locked(make_folder(folder), waits=True):
            require_free(folder, output)
            _write(folder, output, facts, write)
    except OutputError as refusal:
        if not beside:
            raise
        other = _folder_beside(folder)
        with locked(other):
            _write(other, output, facts, write)
        raise refusal.with_facts(
            remedy=f"The results of this run are in {other}. {refusal.remedy}"
        ) from None


def _folder_beside(folder):
    """Make OUT-2 beside OUT, or the next that is free."""
    folder = Path(os.path.realpath(folder))
    number = 2
    while True:
        other = folder.with_name(f"{folder.name}-{number}")
        with said_as_file_error(other):
            try:
                other.mkdir()
            except FileExistsError:
                number += 1
                continue
        return other


def _write(folder, output, facts, write):
    """Write into a hidden folder, look again, and put everything into its place."""
    remove_leftovers(folder)
    staging = folder / hidden_name("new")
    with said_as_file_error(folder):
        staging.mkdir(mode=0o700)
    try:
        with said_of(folder, staging):
            write(staging)
        names = sorted(path.name for path in staging.iterdir())
        # much may have happened meanwhile, and all names are known only now
        require_free(folder, replace(output, names=output.names.union(names)))
        with said_as_file_error(folder):
            facts = _provenance(folder, output, facts)
            older = {} if facts is None else _evidence(folder, output).present()
            with uninterrupted():
                _put_in_place(folder, staging, names, facts, older)
    finally:
        shutil.rmtree(staging, ignore_errors=True)


@contextmanager
def said_of(folder, staging):
    """Tell errors of the place where a file belongs, not of where it is prepared."""
    try:
        yield
    except EinschaltError as error:
        if error.file is None or Path(error.file).parent != staging:
            raise
        file = folder / Path(error.file).name
        raise error.with_facts(file=file) from error.__cause__


def _provenance(folder, output, facts):
    if facts is None:
        return None
    return {**facts, "origin": output.source.origin(folder)}


def _put_in_place(folder, staging, names, facts, older):
    """Give all files their names, so that at any moment it is known whose they are."""
    stale = () if facts is None else _announce(folder, staging, names, facts, older)
    if GEOPACKAGE in names:
        for suffix in SIDECARS:
            (folder / f"{GEOPACKAGE}{suffix}").unlink(missing_ok=True)
    if PREVIOUS in names:
        (staging / PREVIOUS).replace(folder / PREVIOUS)
    if facts is not None:
        (folder / PROVENANCE).unlink(missing_ok=True)
    last = [BLOCK_FILE] if BLOCK_FILE in names else []
    for name in [*(n for n in names if n not in {PREVIOUS, BLOCK_FILE}), *last]:
        (staging / name).replace(folder / name)
    for name in stale:
        (folder / name).unlink(missing_ok=True)
    if facts is not None:
        (folder / FORMER).unlink(missing_ok=True)
        (folder / COMING).replace(folder / PROVENANCE)


def _announce(folder, staging, names, facts, older):
    """Say what lies there and what will; give the files that must go."""
    hidden = {COMING, FORMER, PROVENANCE}
    older = {name: sign for name, sign in older.items() if name not in hidden}
    if older:
        origin = evidence_of(folder).origin or facts["origin"]
        former = {"program": "einschalt", "origin": origin, "outputs": older}
        write_text(folder / FORMER, sealed_text(former))
    outputs = {name: checksum(staging / name) for name in names}
    write_text(folder / COMING, sealed_text({**facts, "outputs": outputs}))
    kept = {*names, *hidden, MARKS}  # a batch removes its marks when it is done
    return [name for name in older if name not in kept]
