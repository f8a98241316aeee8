"""The line of a CSV table that names its columns.

Blank lines and comments may stand before it, and it may be a comment itself, as some
programs write it.
"""

import csv
import io
import re
from dataclasses import dataclass

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.input_files import HEAD_BYTES
from einschalt.interfaces.files.understood_tables import is_header

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}
COMMENT = "#"
BLANKS = re.compile(rb"[ \t]+")
MOST_COLUMNS = 1000


@dataclass(frozen=True)
class Header:
    """Names of the columns, and how they are parted."""

    names: list[str]
    separator: str
    row: int  # its line
    is_first: bool  # whether only comments stand before it


def read_header(data, schema, source):
    """Find the line of the names; columns parted by blanks are parted by tabs then."""
    lines = io.StringIO(
        data[:HEAD_BYTES].decode("utf-8", errors="replace"), newline=None
    )
    row, line, is_first, comment = 0, "", True, None
    for row, line in enumerate(lines, 1):
        if not line.startswith(COMMENT):
            is_first &= bool(line.strip())
            if line.strip():
                break
        comment = row, line.removeprefix(COMMENT)
    words = line.split()
    counts = {separator: line.count(separator) for separator in SEPARATORS}
    separator = max(counts, key=counts.get)
    if not any(counts.values()) and len(words) > 1 and is_header(words, schema):
        names = [word.encode() for word in words]
        data = b"\n".join(BLANKS.sub(b"\t", one.strip()) for one in data.splitlines())
        return data, Header([n.decode() for n in names], "\t", row, is_first)
    names = _parted(line, separator)
    if comment is not None and not is_header(names, schema):
        above = _parted(comment[1], separator)
        if len(above) == len(names) and is_header(above, schema):
            return data, Header(above, separator, comment[0], is_first)
    _refuse_header(names, line, separator, {"file": source, "row": row})
    return data, Header(names, separator, row, is_first)


def _parted(line, separator):
    try:
        return [name.strip() for name in next(csv.reader([line], delimiter=separator))]
    except csv.Error:
        return [""] * (MOST_COLUMNS + 1)


def _refuse_header(names, line, separator, where):
    if len(names) > MOST_COLUMNS:
        # of a long line no more than its beginning is here
        is_many = line.count(separator) >= MOST_COLUMNS
        raise FileError(
            f"the header has more than {MOST_COLUMNS} columns"
            if is_many
            else "the header has a name that is longer than any line",
            expected=f"at most {MOST_COLUMNS}, each with a short name",
            remedy="Leave out the columns that are no part of the table",
            **where,
        )
    if len(names) == 1 and len(line.split()) > 1:
        raise FileError(
            f"the header is {shortened(line.strip(), 80)!r}",
            expected="columns separated by commas, semicolons or tabs",
            remedy="Separate the columns by commas",
            **where,
        )
