"""Which files are inputs, by what block.toml and provenance.json say of them.

A command that never read a block must not replace what another one is computed from.
"""

import tomllib
from pathlib import Path

from einschalt.interfaces.files.block_toml import BLOCK_FILE
from einschalt.interfaces.files.input_files import companions, is_endless
from einschalt.interfaces.files.plain_json import read_own_json


def block_reading(path) -> Path | None:
    """Give the block.toml beside a file, or above it, that names it; None without one.

    It is understood as little as needed, since a block with an error in it is a block:
    whatever text in it leads to the file names it.
    """
    path = Path(path).resolve()
    for folder in path.parents:
        toml = folder / BLOCK_FILE
        if path == toml or path in _named_by(toml):
            return toml
    return None


def _named_by(toml):
    """All files that the texts of a block.toml could lead to, resolved."""
    try:
        data = toml.read_bytes() if toml.is_file() and not is_endless(toml) else b""
    except (OSError, ValueError):  # nothing in it can be read
        return set()
    try:
        texts = _texts(tomllib.loads(data.decode("utf-8-sig")))
    except (ValueError, RecursionError):  # the words between its quotes name files
        texts = data.decode(errors="replace").replace("'", '"').split('"')
    return {path for text in texts for path in _files_of(toml.parent, text)}


def _texts(value):
    if isinstance(value, str):
        return [value]
    values = value.values() if isinstance(value, dict) else value
    is_nested = isinstance(value, (dict, list))
    return [text for one in values for text in _texts(one)] if is_nested else []


def _files_of(folder, text):
    """The file that a text names, with those that belong to it; none without one."""
    try:
        path = folder / text
        if not text.strip() or not path.is_file():
            return []
        return [one.resolve() for one in (path, *companions(path))]
    except (OSError, ValueError):  # no name of a file
        return []


def signs_of_inputs(provenance) -> set[str]:
    """SHA-256 of all inputs that a provenance.json lists; none where it is damaged."""
    listed = (read_own_json(Path(provenance)) or {}).get("inputs", ())
    try:
        return {one["sha256"] for one in listed if isinstance(one["sha256"], str)}
    except (KeyError, TypeError):
        return set()
