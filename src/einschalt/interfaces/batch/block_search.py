"""Which blocks there are below a folder, and what their results are called."""

import os
from collections import Counter
from pathlib import Path

from einschalt.foundations.display_names import as_unicode
from einschalt.foundations.errors import FileError, SettingsError
from einschalt.interfaces.files.block_toml import BLOCK_FILE

TABLE_FILES = ("blocks.csv", "blocks.parquet", "blocks.html")


def find_blocks(folder, output=None) -> list[Path]:
    """Find all blocks below a folder, itself included, sorted.

    Hidden folders and the folder of the results are passed over; links are followed,
    each folder once. A link to a folder above is not: it would bring in blocks that lie
    beside the folder that was named.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise FileError(
            "is no folder" if folder.exists() else "there is no such folder",
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
    seen = set()
    for path, folders, files in os.walk(folder, followlinks=True):
        real = Path(os.path.realpath(path))
        if real in seen or real in above or real == not_here:
            folders.clear()
            continue
        seen.add(real)
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        if BLOCK_FILE in files:
            yield Path(path)


def name_blocks(paths) -> dict[str, Path]:
    """Name each block after its folder; after more of its path where that is not one's.

    A name has ``/`` where it has several parts, and none leads out of the folder of the
    results. Raises where a block is named twice, two differ in case only, or one is
    called as the table of the batch is.
    """
    folders = [_folder_of(path) for path in paths]
    depth = 1
    names = [_end_of(folder, depth) for folder in folders]
    while twice := {n for n, k in Counter(map(str.casefold, names)).items() if k > 1}:
        depth += 1
        longer = [
            _end_of(folder, depth) if name.casefold() in twice else name
            for folder, name in zip(folders, names, strict=True)
        ]
        if longer == names:
            raise _named_twice(folders, names, twice)
        names = longer
    for name, folder in zip(names, folders, strict=True):
        first = name.partition("/")[0]
        if first.casefold() in TABLE_FILES:
            raise SettingsError(
                f"the result of the block {folder} would go into {first!r}, which is "
                "called like the table of all blocks",
                expected="another name",
                remedy="Rename the folder",
            )
    return dict(zip(names, folders, strict=True))


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
    place = next(k for k, name in enumerate(names) if name.casefold() in twice)
    same = [k for k, n in enumerate(names) if n.casefold() == names[place].casefold()]
    other = next((folders[k] for k in same if folders[k] != folders[place]), None)
    if other is not None:
        return SettingsError(
            f"the blocks {folders[place]} and {other} differ in case only",
            expected="names that differ on every system",
            remedy="Rename one of the folders",
        )
    return SettingsError(
        f"the block {folders[place]} is given twice",
        expected="each block once",
        remedy="Leave one of them out",
    )
