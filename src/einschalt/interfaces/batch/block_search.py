"""Which blocks there are below a folder, and what their results are called."""

import os
from pathlib import Path

from einschalt.foundations.display_names import as_unicode
from einschalt.foundations.errors import FileError, SettingsError
from einschalt.foundations.system_errors import reason_of
from einschalt.interfaces.files.block_toml import BLOCK_FILE
from einschalt.interfaces.files.input_files import is_folder, is_there
from einschalt.interfaces.files.output_folder import CLUTTER

TABLE_FILES = ("blocks.csv", "blocks.parquet", "blocks.html")


def find_blocks(folder, output=None) -> list[Path]:
    """Find all blocks below a folder, itself included, sorted.

    Hidden folders and the folder of the results are passed over; links are followed,
    each folder once. A link to a folder above is not: it would bring in blocks that lie
    beside the folder that was named. A folder that cannot be read counts as a block,
    since one in it would be lost from view.
    """
    folder = Path(folder)
    if not is_folder(folder):
        raise FileError(
            "is no folder" if is_there(folder) else "there is no such folder",
            expected="a folder below which the blocks lie",
            remedy="Correct the path",
            file=folder,
        )
    not_here = None if output is None else Path(os.path.realpath(output))
    if not_here == Path(os.path.realpath(folder)):
        raise FileError(
            "the results would fall among the blocks",
            expected="a folder of its own for the results",
            remedy="Name another folder",
            file=output,
        )
    found = sorted(_below(folder, not_here))
    if not found:
        raise FileError(
            f"the folder holds no block: no {BLOCK_FILE} in it or below it",
            expected=f"folders with {BLOCK_FILE} and its tables",
            remedy="Name the folder below which the blocks lie",
            file=folder,
        )
    return found


def _below(folder, not_here):
    above = set(Path(os.path.realpath(folder)).parents)
    seen, closed = set(), []
    walk = os.walk(folder, followlinks=True, onerror=closed.append)
    for path, folders, files in walk:
        real = Path(os.path.realpath(path))
        if real in seen or real in above or real == not_here:
            folders.clear()
            continue
        seen.add(real)
        # a block.toml that is a folder is a mistake in a block
        is_block = BLOCK_FILE in files or BLOCK_FILE in folders
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        if is_block:
            yield Path(path)
    for error in closed:
        path = Path(error.filename)
        if path == folder:
            raise FileError(
                f"cannot be read: {reason_of(error)}",
                remedy="See to the permissions of the folder",
                file=folder,
            ) from error
        real = Path(os.path.realpath(path))
        if real not in seen | above | {not_here} and path.name not in CLUTTER:
            seen.add(real)
            yield path


def name_blocks(paths) -> dict[str, Path]:
    """Name each block after its folder; after more of its path where that is not one's.

    A name has ``/`` where it has several parts, and none leads out of the folder of the
    results. Raises where a block is named twice. Names of folders that differ in case
    only stay, and that of a table: see :func:`case_twins`, :func:`named_like_tables`.
    """
    folders = [_folder_of(path) for path in paths]
    depth = 1
    names = [_end_of(folder, depth) for folder in folders]
    while twice := _named_like_others(folders, names):
        depth += 1
        longer = [
            _end_of(folder, depth) if name in twice else name
            for folder, name in zip(folders, names, strict=True)
        ]
        if longer == names:
            raise _named_twice(folders, names, twice)
        names = longer
    return dict(zip(names, folders, strict=True))


def named_like_tables(named) -> dict[str, SettingsError]:
    """Blocks whose results would go into a table of the batch, by name, with why not.

    ``named`` as :func:`name_blocks` gives them.
    """
    firsts = {name: name.partition("/")[0] for name in named}
    return {
        name: SettingsError(
            f"the result of the block {named[name]} would go into {first!r}, which is "
            "called like the table of all blocks",
            expected="another name",
            remedy="Rename the folder",
        )
        for name, first in firsts.items()
        if first.casefold() in TABLE_FILES
    }


def case_twins(named) -> dict[str, SettingsError]:
    """Blocks whose folders differ in case only, by name, and what is wrong with each.

    On many systems the results of both would go into one folder.
    """
    alike = {}
    for name in named:
        alike.setdefault(name.casefold(), []).append(name)
    return {
        name: SettingsError(
            f"the blocks {named[names[0]]} and {named[names[1]]} differ in case only",
            expected="names that differ on every system",
            remedy="Rename one of the folders",
        )
        for names in alike.values()
        if len(names) > 1
        for name in names
    }


def _named_like_others(folders, names):
    """Names that more of the path would tell apart, on every system if it can."""
    alike = {}
    for folder, name in zip(folders, names, strict=True):
        alike.setdefault(name.casefold(), []).append((folder, name))
    found = set()
    for group in alike.values():
        is_twice = len({name for _, name in group}) < len(group)
        if is_twice or len({str(one).casefold() for one, _ in group}) > 1:
            found.update(name for _, name in group)
    return found


def _folder_of(path):
    path = Path(path).absolute()
    if path.name == BLOCK_FILE:
        path = path.parent
    if path.name == "..":
        return Path(os.path.realpath(path))
    if ".." in path.parts:  # the last part stays, also where it is a link
        return Path(os.path.realpath(path.parent)) / path.name
    return path


def _end_of(folder, depth):
    """Join the last parts of a path, without the root, which would lead elsewhere."""
    parts = folder.relative_to(folder.anchor).parts[-depth:]
    return as_unicode("/".join(parts)) or "block"


def _named_twice(folders, names, twice):
    place = next(k for k, name in enumerate(names) if name in twice)
    return SettingsError(
        f"the block {folders[place]} is given twice",
        expected="each block once",
        remedy="Leave one of them out",
    )
