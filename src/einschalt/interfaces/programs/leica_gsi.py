"""GSI of Leica: lines of words with eight or sixteen digits.

A word is an index of two digits, four characters on it, a sign and the digits, as
``81..10+00013826``: the easting 13.826 m. A line with ``*`` before it has sixteen. The
unit is the last of the four: millimetres, tenths or hundredths of them. Words have a
fixed width, so that names and remarks may hold blanks. Instruments write hyphens where
they have no value, such as ``83..10+000-----``, and some programs several points in
one line.
"""

import re
from itertools import pairwise

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError
from einschalt.foundations.kept_texts import kept
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.programs.foreign import (
    METRES,
    Foreign,
    lines_of,
    points_on_ground,
    require_rows,
)

# the digits, of their width; a remark that has another one ends where a word begins
WORD = (
    r"\s*(?P<index>\d\d)(?P<more>\S{{3}})(?P<unit>\S)(?P<sign>[+-])"
    r"(?P<digits>.{{{0}}}(?=\s|$)|.*?(?=\s\d\d\S{{4}}[+-]|$))"
)
WORDS = {n_digits: re.compile(WORD.format(n_digits)) for n_digits in (8, 16)}
NAME = "11"
EXPECTED = "words such as 81..10+00013826, the first of them a name of index 11"
TARGET, STATION = ("81", "82", "83"), ("84", "85", "86")
# of a line with them the point is the target, and stands elsewhere than the station
MEASUREMENTS = ("21", "22", "31", "32", "33")
UNITS = {"0": 1e-3, "6": 1e-4, "8": 1e-5}  # [m]
FEET = ("1", "7")
NO_VALUE = re.compile(r"0*-+")


def read_gsi(file) -> Foreign:
    """Read the points that have coordinates; lines of angles and codes have none."""
    lines = lines_of(file, comments=("\0",))
    require_rows(lines, file.source, EXPECTED)
    names, places, n_lines, n_points = [], [], 0, 0
    for line in lines:
        found = [one for one in _points(line, file.source) if one[0] is not None]
        good = [one for one in found if not np.isnan(one[1][:2]).any()]
        names += [name for name, _ in good]
        places += [place for _, place in good]
        n_lines += not good
        n_points += len(found) - len(good) if good else 0
    if not names:
        raise FileError(
            "holds no coordinates: angles and distances alone are no points",
            expected="words of the indices 81 and 82, easting and northing",
            remedy="Export coordinates from the instrument, or compute them first",
            file=file.source,
        )
    table = points_on_ground(names, places)
    table = _once(table).dropna(axis=1, how="all")
    notes = [f"{file.source}: without the zeros that lead the names"]
    if n_lines:
        left_out = kept("{n:line|lines} without coordinates left out", n=n_lines)
        notes.append(f"{file.source}: {left_out}")
    if n_points:
        left_out = kept("{n:point|points} without coordinates left out", n=n_points)
        notes.append(f"{file.source}: {left_out}")
    tables = {"control_points": table}
    return Foreign(tables, None, tuple(notes), unit=METRES, unit_m=1.0)


def _once(table):
    """Each point once, with its height where it was written with one and without.

    An instrument writes a point anew whenever it is looked at.
    """
    table = table.drop_duplicates(ignore_index=True)
    plane = ["point_id", "easting", "northing"]
    is_bare = table["height"].isna()
    has_height = table[~is_bare].groupby(plane)["height"].size()
    is_said = pd.MultiIndex.from_frame(table[plane]).isin(has_height.index)
    return table[~(is_bare & is_said)].reset_index(drop=True)


def _points(line, source):
    """Names and coordinates of the points of a line, mostly of one."""
    n_digits = 16 if line.text.startswith("*") else 8
    words = _words(line.text.removeprefix("*"), n_digits, line, source)
    # a name begins a point: the words of a second one are not those of the first
    starts = [k for k, word in enumerate(words) if k and word["index"] == NAME]
    for start, stop in pairwise([0, *starts, len(words)]):
        yield _point(words[start:stop], n_digits, line, source)


def _point(words, n_digits, line, source):
    """Name of a point, None of another line, and its coordinates, NaN where none."""
    place = np.full(3, np.nan)
    first, *rest = words
    if first["index"] != NAME:
        return None, place
    if len(first["digits"]) != n_digits:
        raise _unreadable(first[0], line, source)
    given = {word["index"]: word for word in rest}
    is_station = given.keys().isdisjoint((*TARGET, *MEASUREMENTS))
    for axis, index in enumerate(STATION if is_station else TARGET):
        if index in given:
            place[axis] = _metres(given[index], n_digits, line, source)
    return first["digits"].strip().lstrip("0") or "0", place


def _words(text, n_digits, line, source):
    """Words of a line, each as a match of its parts."""
    words, start = [], 0
    while start < len(text):
        word = WORDS[n_digits].match(text, start)
        if word is None:
            raise _unreadable(text[start:].split()[0], line, source)
        words.append(word)
        start = word.end()
    return words


def _metres(word, n_digits, line, source):
    said, unit, digits = word[0].strip(), word["unit"], word["digits"]
    if unit in FEET:
        raise FileError(
            f"word {said} is in feet",
            expected="metres",
            remedy="Set the instrument to metres, and export it again",
            file=source,
            row=line.row,
        )
    is_whole = len(digits) == n_digits and digits.isdecimal()
    if len(digits) == n_digits and NO_VALUE.fullmatch(digits):
        return np.nan
    if unit not in UNITS or not is_whole:
        raise _unreadable(said, line, source)
    # exact, as the digits are: 13826180 * 1e-3 is not 13826.18
    value = int(digits) / round(1.0 / UNITS[unit])
    return -value if word["sign"] == "-" else value


def _unreadable(word, line, source):
    said = f"{shortened(word.strip())!r} is no word of GSI"
    return damaged(source, said, EXPECTED, line.row)
