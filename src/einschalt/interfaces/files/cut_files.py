"""Texts that end within a row: what a copy that was broken off leaves.

A row with too few values is refused where it is read. One that was cut within its last
number has as many as the others, and the number is wrong; only that no line end follows
and that it has fewer decimals than all above it tells.
"""

import re

import numpy as np

from einschalt.foundations.errors import TableError
from einschalt.foundations.frame_columns import columns_of
from einschalt.foundations.typesetting import count

TAIL_BYTES = 2**16  # that are looked at
# rows above that tell: all with as many decimals, which few rows of numbers whose zeros
# are left out have by chance, or with several numbers of them
FEWEST_ROWS, FEWEST_OF_SEVERAL = 30, 100
# of models; a last one with less than that share of the points of the smallest other
FEWEST_MODELS, SMALL_SHARE = 10, 0.5
NUMBER = re.compile(r"[+-]?\d*(?:[.,](\d*))?")


def require_whole_end(data, header, source):
    """Refuse a text whose last number was cut off; a TableError.

    ``data``: bytes of the text as they were read, its header with the separator.
    """
    if not data or data[-1] in b"\r\n":
        return
    tail = data[-TAIL_BYTES:].decode("utf-8", errors="replace")
    n_lines = 1 + (data.count(b"\n") or data.count(b"\r"))
    n_rows = n_lines - header.end
    lines = tail.splitlines()[-max(n_rows, 1) :]
    if n_rows <= FEWEST_ROWS or len(lines) <= FEWEST_ROWS or '"' in tail:
        return
    *above, last = (_last_number(line, header.separator) for line in lines)
    above = above[1:]  # the first line of the tail may be a part of one
    known = {n for _, n in above}
    fewest = FEWEST_ROWS if len(known) == 1 else FEWEST_OF_SEVERAL
    if len(above) < fewest or None in known:
        return
    n_decimals, (text, n_of_last) = min(known), last
    if n_of_last is not None and n_of_last < n_decimals:
        raise TableError(
            f"the file ends within this row: no line end follows, and {text!r} has "
            f"fewer decimals ({n_of_last}) than all above ({n_decimals} or more)",
            expected="whole rows",
            remedy="Copy or export the file again; end the line if the row is whole",
            file=source,
            row=n_lines,
        )


def _last_number(line, separator):
    """The last value of a line, and its number of decimals; None where it is none."""
    parts = line.split(separator) if separator in line else line.split()
    text = parts[-1].strip() if parts else ""
    found = NUMBER.fullmatch(text)
    if not text or found is None or (separator == "," and "," in text):
        return text, None
    return text, len(found[1] or "")


def note_on_last_model(frame, key, source):
    """Say that the last model or image is far smaller than all; None where it is not.

    Whole rows that are lacking leave no other trace. ``key``: ``model_id`` or
    ``image_id``; models must stand one after the other.
    """
    names = list(frame.columns)
    if names.count(key) != 1 or names.count("coverage") > 1 or not len(frame):
        return None
    # from row to row: to code all names takes as long as to read them
    keys = columns_of(frame, [name for name in ("coverage", key) if name in names])
    is_first = np.zeros(len(keys), dtype=bool)
    for name in keys:
        is_first |= (keys[name] != keys[name].shift()).to_numpy(
            dtype=bool, na_value=True
        )
    starts = np.flatnonzero(is_first)
    *others, last = np.diff(starts, append=len(keys))
    is_small = len(others) >= FEWEST_MODELS and last < min(others) * SMALL_SHARE
    if not is_small or keys.iloc[starts].duplicated().any():
        return None
    name, points = frame[key].iloc[-1], count(int(last), "point")
    if key == "image_id":
        return (
            f"{source}: the last image, {name}, has {points}, every other one "
            f"{min(others)} or more: was the file cut off? Compare it with its source"
        )
    return (
        f"{source}: the last model, {name}, has {points}, every other one "
        f"{min(others)} or more: was the file cut off? Compare it with its source"
    )
