"""Files that a block names and that lie elsewhere: messages quote nothing of them.

A block may come from anybody, and what is said of it may be sent back. A path in its
block.toml, or a link in its folder, can lead to every file that its reader may read.
"""

from contextlib import contextmanager
from pathlib import Path

from einschalt.foundations.errors import ChangedFileError, EinschaltError, FileError
from einschalt.interfaces.files.input_files import is_there, require_file


def is_elsewhere(path, folder) -> bool:
    """Whether a file lies neither with a block nor in a folder beside it.

    Links are followed; hidden files and folders are elsewhere wherever they are.
    """
    try:
        path, folder = Path(path).resolve(), Path(folder).resolve()
    except (OSError, RuntimeError, ValueError):  # links in a circle
        return True
    job = folder.parent if folder.parent.parent != folder.parent else folder
    if not path.is_relative_to(job):
        return True
    return any(part.startswith(".") for part in path.relative_to(job).parts)


def require_named_file(folder, source, key, taken):
    """See that a file is there that a ``key`` of block.toml names, from ``folder``.

    Of one that lies elsewhere it is not told what else its folder holds.
    """
    path = Path(folder) / source
    try:
        return require_file(path, source, taken=taken)
    except FileError as error:
        if is_there(path):
            raise
        error = error.with_facts(expected=f"the table of {key}")
        if is_elsewhere(path, folder):
            error = error.with_facts(remedy="Correct the path")
        raise error from None


@contextmanager
def discreetly(path, folder, source):
    """Say of a file elsewhere that it could not be understood, and nothing more."""
    try:
        yield
    except ChangedFileError:
        raise
    except EinschaltError as error:
        if not is_elsewhere(path, folder):
            raise
        raise FileError(
            "cannot be read as what it is named for",
            expected="a table or a camera; it lies elsewhere, so nothing of it is "
            "quoted",
            remedy="Put it into the folder of the block, or beside that, and check "
            "again",
            file=source,
            row=getattr(error, "row", None),
        ) from None


def require_some_column(path, folder, frame, schema):
    """Refuse a table elsewhere without one column that it ought to have."""
    if is_elsewhere(path, folder) and not set(schema.names) & set(frame.columns):
        raise FileError("has no column of such a table", file=path)
