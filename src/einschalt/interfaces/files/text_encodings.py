"""Text of tables in the encoding that it has, told by its bytes.

UTF-8 and UTF-16 can be told for certain, the one byte encodings of Windows by what they
would make of the bytes: letters, degree signs and quotation marks where there are such.
Those of Central Europe, Japan and China are taken where they make more names of columns
of the first lines.
"""

import codecs
import re
import unicodedata

from einschalt.foundations.column_words import is_word_of_a_table
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.input_files import (
    UTF16_MARKS,
    read_once,
    read_text_bytes,
    require_text,
)

# two and more bytes that are one letter in UTF-8, and two odd ones in Windows-1252
UTF8_LETTER = re.compile(rb"[\xc3-\xf4][\x80-\xbf]")
USUAL_SIGNS = "°µ§²³´·±«»–—‘’“”„€…\xa0"
# in MS-DOS these bytes are umlauts, which stand in words
DOS_UMLAUTS = "„”“‚†‡ˆŠ‹Œ"
IN_WORD = re.compile(rf"[^\W\d_][{DOS_UMLAUTS}][^\W\d_]")
ASCII = bytes(range(128))
MOST_SHOWN = 30
HEAD_OF_UTF16 = 4096
# encodings that only names of columns speak for, and what they are called
BY_WORDS = {
    "cp1250": "Windows-1250",
    "iso8859-2": "ISO 8859-2",
    "cp932": "Shift-JIS",
    "gbk": "GBK",
}
AS_WINDOWS = "read as Windows-1252 text, since it is no UTF-8"
HEAD_LINES = 40  # in which the names of the columns stand
BETWEEN_CELLS = re.compile(r"[;,|\t]|  +")


def read_table_text(path, source):
    """Read the text of a table as UTF-8, and say in which encoding it was found.

    Returns the bytes, and a note or None. A FileError where no encoding fits.
    """
    file = read_once(path, source)
    data = file.data
    name = _utf16_of(data)
    if name is not None:
        encoded = _decoded(data, name, source).encode("utf-8")
        return require_text(encoded, source), f"{source}: read as UTF-16 text"
    if _is_utf8(data):
        return require_text(data, source, is_utf8=True), None
    text, said = (None, "") if b"\0" in data else _of_windows(data)
    if text is None:
        return read_text_bytes(file, source), None  # which says what is no UTF-8
    encoded = require_text(text.encode("utf-8"), source)
    return encoded, f"{source}: {said}: {_first_word(text)!r}"


def _of_windows(data):
    """Text in an encoding of Windows, or another one of old, and how that is told."""
    text = None if UTF8_LETTER.search(data) else _as_windows(data)
    most, found = _n_words(text), (text, AS_WINDOWS)
    lines = data.split(b"\n", HEAD_LINES)[:HEAD_LINES]
    for encoding, called in BY_WORDS.items():
        head = b"\n".join(lines).decode(encoding, errors="replace")
        if _n_words(head) <= most:
            continue
        try:
            known = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        said = f"read as {called} text, since only so its columns have names"
        most, found = _n_words(head), (known, said)
    return found


def _n_words(text):
    """How many words of columns with other letters than ASCII begin a text."""
    lines = [] if text is None else text.split("\n", HEAD_LINES)[:HEAD_LINES]
    cells = {cell.strip(" \"'\r") for one in lines for cell in BETWEEN_CELLS.split(one)}
    return sum(not cell.isascii() and is_word_of_a_table(cell) for cell in cells)


def _is_utf8(data):
    if data.isascii():
        return True
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True


def _utf16_of(data):
    """Name of the UTF-16 that it is: by its mark, or by the place of its zeros."""
    if data.startswith(UTF16_MARKS):
        return "utf-16"
    head = data[:HEAD_OF_UTF16]
    even, odd = head[::2], head[1::2]
    if len(head) < len(codecs.BOM_UTF16) * 2 or b"\0" not in head:
        return None
    # digits and separators, most of a table, have one byte that is zero
    if odd.count(0) > 0.9 * len(odd) and even.count(0) == 0:
        return "utf-16-le"
    if even.count(0) > 0.9 * len(even) and odd.count(0) == 0:
        return "utf-16-be"
    return None


def _decoded(data, name, source):
    try:
        return data.decode(name)
    except UnicodeDecodeError as error:
        raise FileError(
            "is UTF-16 text that is damaged or truncated",
            expected="whole characters",
            remedy="Export it again",
            file=source,
        ) from error


def _as_windows(data):
    """Text in Windows-1252, where that makes letters of the bytes; otherwise None."""
    try:
        text = data.decode("cp1252")
    except UnicodeDecodeError:
        return None
    # the distinct ones alone: a table may have millions
    odd = bytes(set(data.translate(None, ASCII))).decode("cp1252")
    is_usual = all(c in USUAL_SIGNS or unicodedata.category(c)[0] == "L" for c in odd)
    if not is_usual or (set(odd) & set(DOS_UMLAUTS) and IN_WORD.search(text)):
        return None
    return text


def _first_word(text):
    """The first word with a letter that is no ASCII, for a note."""
    place = next(re.finditer(r"[^\x00-\x7f]", text)).start()
    start, end = max(place - MOST_SHOWN, 0), place + MOST_SHOWN
    before = re.split(r"[;,\s]", text[start:place])[-1]
    after = re.split(r"[;,\s]", text[place:end])[0]
    return shortened(before + after)
