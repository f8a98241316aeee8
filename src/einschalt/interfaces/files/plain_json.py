"""JSON of other programs, which are told where theirs is none, and our own."""

import json

from einschalt.foundations.display_names import shortened
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.input_files import is_endless, read_text_bytes
from einschalt.interfaces.files.json_text import parsed_json


def read_json(file, source, expected):
    """Read the JSON of a file; a FileError with the line where it is none.

    ``file`` is a path or what was read of it; ``source`` and ``expected`` are for the
    error.
    """
    try:
        return parsed_json(read_text_bytes(file, source))
    except (ValueError, RecursionError) as error:
        found = f"is no whole JSON: {shortened(str(error), 80)}"
        row = getattr(error, "lineno", None)
        raise damaged(source, found, expected, row) from error


def read_own_json(path) -> dict | None:
    """Read a JSON file of ours; None where it is missing or damaged."""
    try:
        is_read = path.is_file() and not is_endless(path)
        content = json.loads(path.read_bytes()) if is_read else None
    # brackets may be nested more deeply than Python can follow
    except (OSError, ValueError, RecursionError):
        return None
    return content if isinstance(content, dict) else None
