"""Values of one column of an input table: numbers, words and names.

What pandas would take for a number without being told (True, dates) is none here, and
what would make it raise (whole numbers of a thousand digits) is described instead.
"""

import re
from datetime import date
from numbers import Number

import numpy as np
import pandas as pd
import pyarrow as pa

from einschalt.foundations.arguments import described
from einschalt.foundations.display_names import shortened
from einschalt.foundations.key_columns import are_tidy
from einschalt.foundations.names import is_among
from einschalt.foundations.near_words import nearest
from einschalt.foundations.number_parsing import LARGEST_NUMBER, describe_fault

TEXT = pd.StringDtype(na_value=np.nan)  # what pandas makes of "str"
LARGEST_BITS = 1000  # of a whole number that a float can hold
BYTES_OF_DOUBLE = 8
# tabs, and what parts lines, of whatever script
BREAK = "[\t\n\x0b\x0c\r\x1c\x1d\x1e\x85\u2028\u2029]"
FIRST_SIGN, LAST_SIGN = 0x20, 0x7F  # of ASCII
COARSE = 1e-3  # what numbers of fewer bytes may be apart, in whatever unit


def are_blank(raw):
    """Which cells of a column are empty, or hold nothing but blanks, ndarray."""
    blank = raw.isna() | (raw.astype(str).str.strip() == "")
    return blank.to_numpy(dtype=bool)


def numbers(raw, column):
    """Numbers of a column, as they were read into a Series.

    Values, NaN where there is none; which of them are bad; and a function that says of
    a raw value what was found, what is expected and how to mend it.
    """
    values = _to_float(raw)
    is_bad = np.zeros(len(values), dtype=bool)
    if not _are_small(values):
        is_bad = ~(np.abs(values) <= LARGEST_NUMBER)
    if column.may_be_missing and is_bad.any():
        is_bad &= ~(raw.isna() | (raw.astype(str).str.strip() == "")).to_numpy()
    if column.is_positive:
        is_bad |= values <= 0.0

    def say(value):
        return describe_fault(value, column.unit, is_positive=column.is_positive)

    return values, is_bad, say


def _are_small(values):
    """Whether all are numbers of a usual size, told without an array of all of them."""
    with np.errstate(invalid="ignore"):  # a NaN of a damaged file may signal itself
        low, high = values.min(initial=0.0), values.max(initial=0.0)
    return bool(low >= -LARGEST_NUMBER and high <= LARGEST_NUMBER)  # no NaN, either


def _to_float(raw):
    if raw.dtype == np.float64:
        return raw.to_numpy()
    # pandas would count True as 1, dates as ns, and leave out what is imaginary
    is_textual = raw.dtype == object or pd.api.types.is_string_dtype(raw)
    is_other = pd.api.types.is_bool_dtype(raw) or pd.api.types.is_complex_dtype(raw)
    if is_other or not (pd.api.types.is_numeric_dtype(raw) or is_textual):
        return np.full(len(raw), np.nan)
    if raw.dtype == object:
        raw = raw.map(_plain)
    return pd.to_numeric(raw, errors="coerce").to_numpy(dtype=float, na_value=np.nan)


def _plain(value):
    """Leave what pandas can make a number of, or refuse without raising."""
    if isinstance(value, (bool, complex)) or not isinstance(value, (str, Number)):
        return None
    if isinstance(value, int) and value.bit_length() > LARGEST_BITS:
        return np.inf
    return value


def choices(raw, column):
    """Words of a column that allows a few; as :func:`numbers` gives them."""
    text, is_bad = raw, np.zeros(len(raw), dtype=bool)
    if not (is_text(raw) and is_among(raw, column.choices).all()):
        text = raw.astype("object").where(raw.notna(), column.default)
        text = text.astype(str).str.strip()
        text = text.where(text != "", column.default)
        is_bad = ~text.isin(column.choices).to_numpy()
    expected = " or ".join(column.choices)

    def say(value):
        word = shortened(str(value).strip())
        near = nearest(word, column.choices)
        mend = f"Write {near}" if near else f"Write one of {expected}"
        return f"'{word}' is unknown", expected, mend

    return text.to_numpy(dtype=object), is_bad, say


def is_text(raw):
    """Whether a column holds text alone, by its type."""
    return pd.api.types.is_string_dtype(raw) and raw.dtype != object


def identifiers(raw, *, is_tidy=None):
    """Names as text without blanks around them; as :func:`numbers` gives them.

    Those with line breaks or tabs in them, as Alt+Enter makes in a cell, are faulty:
    these end the row or the cell in lists of other programs. ``is_tidy``: whether no
    name is missing or has blanks around it, where that was looked at before.
    """
    is_textual = is_text(raw)
    is_tidy = is_textual and are_tidy(raw) if is_tidy is None else is_tidy
    if is_tidy:
        text = raw if raw.dtype == TEXT else raw.astype(TEXT)
        if not _may_break(text):
            return text, np.zeros(len(raw), dtype=bool), described
    text = raw if is_textual else raw.astype(object).map(_name, na_action="ignore")
    text = text.fillna("").astype(str).str.strip()
    is_bad = (text == "").to_numpy(dtype=bool)
    if _may_break(text):
        is_bad = is_bad | text.str.contains(BREAK, regex=True).to_numpy(dtype=bool)

    def say(value):
        if isinstance(value, str) and re.search(BREAK, value.strip()):
            return (
                f"{described(value)} has a line break or a tab in it",
                "a name in one line, without tabs",
                "Write a blank or nothing in its place, in all tables alike",
            )
        if is_textual or _name(value) or not np.all(pd.notna(value)):
            return "is missing", "a name", "Give the name or delete the row"
        return f"{described(value)} is no name", "a text", "Write the name as text"

    return text, is_bad, say


def _may_break(text):
    """Whether a column of text has bytes that may be those of a line break or a tab.

    False is certain, and is seen without looking at each name.
    """
    column = pa.array(text, from_pandas=True)
    for part in column.chunks if isinstance(column, pa.ChunkedArray) else [column]:
        data = part.buffers()[-1]
        if data is None or not data.size:
            continue
        signs = np.frombuffer(data, dtype=np.uint8)
        if signs.min() < FIRST_SIGN or signs.max() > LAST_SIGN:
            return True
    return False


def _name(value):
    """Text of a name; empty where the value is none, or cannot be written as UTF-8."""
    is_plain = isinstance(value, (str, Number, np.generic, date))
    text = whole_text(value) if is_plain else ""
    return text if text.isprintable() or _is_unicode(text) else ""


def _is_unicode(text):
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        return False
    return True


def whole_text(value):
    """Text of a value; a whole number has no decimals, a huge one is described."""
    is_measure = isinstance(value, Number) and not isinstance(value, (bool, complex))
    if isinstance(value, int) and value.bit_length() > LARGEST_BITS:
        return described(value)
    is_whole = is_measure and np.isfinite(float(value)) and value == int(value)
    return str(int(value)) if is_whole else str(value)


def note_on_digits(column, source) -> str | None:
    """Say that the numbers of a column have too few digits for what they hold."""
    kind = column.dtype
    if not (pd.api.types.is_float_dtype(kind) and kind.itemsize < BYTES_OF_DOUBLE):
        return None
    values = column.to_numpy(f"f{kind.itemsize}", na_value=np.nan)
    largest = np.abs(values[np.isfinite(values)]).max(initial=0.0)
    if (apart := np.spacing(largest)) <= COARSE:
        return None
    return (
        f"{source}: numbers of {8 * kind.itemsize} bits in column {column.name} are "
        f"as far as {apart:.2g} apart. Give numbers of 64 bits"
    )
