"""Where the block.toml of a block is, and what is said where it is not."""

import os
from pathlib import Path

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.block_toml import BLOCK_FILE
from einschalt.interfaces.files.input_files import is_folder, is_there, require_file

CLOSED = "See to the permissions of the folder"


def block_file(path):
    """Find the block.toml of a block, which is named by its folder or by it."""
    path = Path(path)
    if is_folder(path):
        return _in_folder(path)
    try:
        return require_file(path, str(path))
    except FileError as error:
        if is_there(path):
            raise
        raise error.with_facts(found="there is no such folder or file") from None


def _in_folder(folder):
    path = folder / BLOCK_FILE
    if not is_there(path):
        raise FileError(
            f"the folder holds no {BLOCK_FILE}",
            expected=f"a folder with {BLOCK_FILE} and its tables",
            remedy=f"Name the folder of a block, or write {BLOCK_FILE}",
            file=folder,
        )
    try:
        return require_file(path, BLOCK_FILE)
    except FileError as error:
        if isinstance(error.__cause__, PermissionError) and not os.access(
            folder, os.R_OK | os.X_OK
        ):
            error = error.with_facts(file=folder, remedy=CLOSED)
        elif is_folder(path):
            error = error.with_facts(remedy="Rename that folder, or remove it")
        raise error from error.__cause__
