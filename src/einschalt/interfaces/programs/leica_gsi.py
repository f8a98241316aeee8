"""GSI of Leica: lines of words with eight or sixteen digits, after its manual.

A word is an index of two digits, four characters on it, a sign and the digits, as
``81..10+00013826``: the easting 13.826 m. A line with ``*`` before it has sixteen. The
unit is the last of the four: millimetres, tenths or hundredths of them.
"""

import re

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.programs.foreign import (
    Foreign,
    lines_of,
    require_rows,
    unseen,
)

WORD = re.compile(r"(\d\d)(..)(.)(.)([+-])(\S+)")
NAMED = re.compile(r"(11)(....)([+-])(\S+)")
EXPECTED = "words such as 81..10+00013826, the first of them a name of index 11"
AXES = {"81": 0, "82": 1, "83": 2, "84": 0, "85": 1, "86": 2}  # of targets, stations
METRES = {"0": 1e-3, "6": 1e-4, "8": 1e-5}
FEET = ("1", "7")


def read_gsi(file) -> Foreign:
    """Read the points that have coordinates; lines of angles and codes have none."""
    lines = lines_of(file, comments=("\0",))
    require_rows(lines, file.source, EXPECTED)
    names, places, n_others = [], [], 0
    for line in lines:
        name, place = _point(line, file.source)
        if name is None or np.isnan(place[:2]).any():
            n_others += 1
        else:
            names.append(name)
            places.append(place)
    if not names:
        raise FileError(
            "holds no coordinates: angles and distances alone are no points",
            expected="words of the indices 81 and 82, easting and northing",
            remedy="Export coordinates from the instrument, or compute them first",
            file=file.source,
        )
    table = pd.DataFrame({"point_id": names})
    table[["easting", "northing", "height"]] = np.array(places)
    # an instrument writes a point anew whenever it is looked at
    table = table.drop_duplicates(ignore_index=True).dropna(axis=1, how="all")
    notes = [unseen(file.source)]
    notes.append(f"{file.source}: without the zeros that lead the names")
    if n_others:
        notes.append(f"{file.source}: {n_others} lines without coordinates left out")
    return Foreign({"control_points": table}, None, tuple(notes))


def _point(line, source):
    """Name of a point, None of another line, and its coordinates, NaN where none."""
    is_long = line.text.startswith("*")
    first, *rest = line.text.removeprefix("*").split()
    n_digits, place = 16 if is_long else 8, np.full(3, np.nan)
    named = NAMED.fullmatch(first)
    if named is None:
        if not WORD.fullmatch(first):
            raise _unreadable(first, line, source)
        return None, place
    if len(named[4]) != n_digits:
        raise _unreadable(first, line, source)
    for word in rest:
        found = WORD.fullmatch(word)
        if found is None or len(found[6]) != n_digits:
            raise _unreadable(word, line, source)
        if found[1] in AXES:
            place[AXES[found[1]]] = _metres(found, line, source)
    return named[4].lstrip("0") or "0", place


def _metres(found, line, source):
    _, _, _, unit, sign, digits = found.groups()
    if unit in FEET:
        raise FileError(
            f"word {found[0]} is in feet",
            expected="metres",
            remedy="Set the instrument to metres, and export it again",
            file=source,
            row=line.row,
        )
    if unit not in METRES or not digits.isdecimal():
        raise _unreadable(found[0], line, source)
    # exact, as the digits are: 13826180 * 1e-3 is not 13826.18
    value = int(digits) / round(1.0 / METRES[unit])
    return -value if sign == "-" else value


def _unreadable(word, line, source):
    said = f"{shortened(word)!r} is no word of GSI"
    return damaged(source, said, EXPECTED, line.row)
