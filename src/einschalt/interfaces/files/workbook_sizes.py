"""What the parts of a workbook would unpack to, refused before anything reads them.

A few kilobytes may be a million rows of a thousand empty cells, or a long text to which
each of them points. Cells that are all alike pack to a twentieth of a byte, measured
ones to several bytes. What is not written as spreadsheets write it counts as the worst.
"""

import re

import numpy as np

from einschalt.foundations.errors import FileError
from einschalt.foundations.kernels import compiled
from einschalt.pipeline.block.memory import allowed_bytes

HARMLESS_BYTES = 2**28  # a million rows of ten columns
MOST_PACKED = 100
MOST_MEMBERS = 5000
MOST_CELLS = 2**24
HARMLESS_CELLS = 2**21  # a quarter of a gigabyte, as GDAL and pandas hold them
BYTES_OF_A_CELL = 110  # measured: 2 and 13.5 million cells of one digit
# that rows lack, of columns which the widest has: half a gigabyte, or as many in a byte
HARMLESS_EMPTY, EMPTY_IN_A_BYTE = 2**23, 8
BYTES_OF_AN_EMPTY_CELL = 55  # measured: 16 million, in rows of 100 to 1000
LARGEST_TEXT = 2**27  # of all cells that point to texts
LONGEST_TEXT = 2**18  # bytes of one cell; spreadsheets write 32 767 letters
CELL = re.compile(rb"<c\s([^<>]*)>\s*(?:<v>(\d{1,9})<)?")
OF_TEXT = (b'"s"', b"'s'", b"&")  # in its attributes: it points to a text, or may
TAG, END, SLASH, BLANK, QUOTES = ord("<"), ord(">"), ord("/"), ord(" "), (34, 39)
SMALL_C, SMALL_R, SMALL_O = ord("c"), ord("r"), ord("o")
FIRST, LAST, N_LETTERS, MOST_LETTERS = ord("A"), ord("Z"), 26, 3


def refuse_size(members, n_bytes, source):
    """Refuse an archive that unpacks to what no workbook does."""
    unpacked = sum(member.file_size for member in members)
    is_large = unpacked > max(HARMLESS_BYTES, MOST_PACKED * n_bytes)
    if is_large or len(members) > MOST_MEMBERS:
        raise FileError(
            f"{n_bytes} bytes would unpack to {unpacked} bytes in {len(members)} files",
            expected=f"a workbook that is packed at most {MOST_PACKED} times",
            remedy="Check where the file comes from, or give the table as CSV",
            file=source,
        )


def refuse_entities(text, source):
    """Refuse XML in other letters, and that defines words, which may be gigabytes."""
    head = text[:4096].upper()
    if b"\0" in text:  # UTF-16, in which nothing here would be found
        raise FileError(
            "the workbook is no UTF-8 text inside",
            expected="a workbook as a spreadsheet saves it",
            remedy="Check where the file comes from, or give the table as CSV",
            file=source,
        )
    if b"<!DOCTYPE" in head or b"<!ENTITY" in head:
        raise FileError(
            "the workbook defines XML entities, as no spreadsheet does",
            expected="a workbook as a spreadsheet saves it",
            remedy="Check where the file comes from, or give the table as CSV",
            file=source,
        )


def refuse_cells(texts, n_bytes, source):
    """Refuse long texts, texts that many cells share, and more cells than are measured.

    ``texts``: the parts of a workbook of so many bytes, by their names in the archive.
    """
    n_cells = n_empty = 0
    for text in texts.values():
        longest, width, n_filled = _extent(np.frombuffer(text, np.uint8))
        n_rows = text.count(b"<row")
        _refuse_long(longest, source)
        _refuse_width(n_rows, width, source)
        n_cells += n_filled
        n_empty += max(0, n_rows * width - n_filled)
    _refuse_number(n_cells, n_empty, n_bytes, source)
    shared = [text for text in texts.values() if b"<si" in text]
    sizes = [np.array([len(p) for p in text.split(b"<si")[1:]]) for text in shared]
    if not sizes:
        return
    # which of several parts is meant, nobody knows
    sizes = sizes[0] if len(sizes) == 1 else np.array([max(map(np.max, sizes))])
    if sizes.max() * _most_pointing(texts.values()) <= LARGEST_TEXT:
        return
    n_bytes = sum(_bytes_pointed_to(text, sizes) for text in texts.values())
    if n_bytes > LARGEST_TEXT:
        raise FileError(
            f"cells share texts, {n_bytes} bytes in all",
            expected=f"names and numbers, of at most {LARGEST_TEXT} bytes",
            remedy="Take long remarks out, or give the table as CSV",
            file=source,
        )


def _most_pointing(texts):
    return sum(text.count(b"<c ") + text.count(b"<c\n") for text in texts)


def _bytes_pointed_to(text, sizes):
    """Bytes of the texts to which the cells of a sheet point."""
    cells = (cell.groups() for cell in CELL.finditer(text))
    places = np.fromiter(
        (
            len(sizes) if place is None else int(place)
            for attributes, place in cells
            if any(sign in attributes for sign in OF_TEXT)
        ),
        dtype=np.int64,
    )
    is_known = places < len(sizes)
    return int(sizes[places[is_known]].sum() + (~is_known).sum() * sizes.max())


def _refuse_long(longest, source):
    if longest > LONGEST_TEXT:
        raise FileError(
            f"a cell holds {longest} bytes",
            expected=f"at most {LONGEST_TEXT} bytes in a cell",
            remedy="Take long remarks out, or give the table as CSV",
            file=source,
        )


def _refuse_width(n_rows, width, source):
    """Refuse a sheet of .xlsx whose rows are filled up with too many empty cells."""
    if n_rows * width > MOST_CELLS:
        raise FileError(
            f"a sheet has {n_rows} rows and {width} columns",
            expected=f"at most {MOST_CELLS} cells",
            remedy="Leave out the columns that are no part of the table, or give the "
            "table as CSV",
            file=source,
        )


def _refuse_number(n_cells, n_empty, n_bytes, source):
    """Refuse sheets whose cells would fill the memory, or that nobody has measured.

    ``n_empty``: those with which rows are filled up, of which the file has nothing.
    """
    memory = allowed_bytes() / 2.0
    packed = max(HARMLESS_CELLS, n_bytes)  # measured ones have more than a byte each
    most = min(packed, MOST_CELLS, int(memory / BYTES_OF_A_CELL))
    left = max(0.0, memory - n_cells * BYTES_OF_A_CELL)
    harmless = max(HARMLESS_EMPTY, EMPTY_IN_A_BYTE * n_bytes)
    most_empty = min(harmless, int(left / BYTES_OF_AN_EMPTY_CELL))
    remedy = (
        "Leave out the rows, columns and sheets that are no part of the table, or "
        "give the table as CSV"
    )
    if n_cells > most:
        raise FileError(
            f"{n_bytes} bytes would unpack to {n_cells} cells",
            expected=f"at most {most} cells in a workbook of this size",
            remedy=remedy,
            file=source,
        )
    if n_empty > most_empty:
        raise FileError(
            f"rows of {n_bytes} bytes would be filled up with {n_empty} empty cells",
            expected=f"at most {most_empty} empty cells in a workbook of this size",
            remedy=remedy,
            file=source,
        )


def too_many_in_ods(n_cells, source):
    """An .ods that GDAL does not read: it holds ten megabytes of cells at most."""
    return FileError(
        f"has {n_cells} cells, some of them perhaps repeated, which are too many for "
        "an .ods",
        expected="at most 300000 cells in an .ods",
        remedy="Save the table as .xlsx or as CSV",
        file=source,
    )


@compiled
def _extent(text):
    """Most bytes from one tag to the next, columns of the widest row, and cells.

    Columns are counted, and named by cells: ``<c r="AB7"/>`` is the 28th.
    """
    longest = last = width = n_in_row = n_cells = 0
    is_cell = False
    for k in range(len(text) - 2):
        sign = text[k]
        if sign == TAG:
            longest, last = max(longest, k - last), k
            first, second = text[k + 1], text[k + 2]
            is_cell = first == SMALL_C and (second <= BLANK or second in (SLASH, END))
            is_row = first == SMALL_R and second == SMALL_O
            n_in_row = 0 if is_row else n_in_row + is_cell
            n_cells += is_cell
            width = max(width, n_in_row)
        elif is_cell and sign in QUOTES:
            column, place = 0, k + 1
            end = min(place + MOST_LETTERS, len(text))
            while place < end and FIRST <= text[place] <= LAST:
                column = N_LETTERS * column + text[place] - FIRST + 1
                place += 1
            width = max(width, column)
    return max(longest, len(text) - last), width, n_cells
