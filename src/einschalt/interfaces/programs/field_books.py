"""Field books of total stations as text: SDR of Sokkia, raw data of Nikon and Ruide.

Both hold points with coordinates among measurements, which are no points until they are
computed. Which coordinate comes first is a setting of the instrument that the book
states: in two real books of SDR33 and one of Ruide the azimuths of the backsights agree
with eastings first, as their headers have it.
"""

import re
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd

from einschalt.foundations.errors import FileError
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.number_parsing import is_number
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.programs.foreign import METRES, Foreign

PLACE = ["easting", "northing", "height"]
EAST_FIRST, NORTH_FIRST = ("easting", "northing"), ("northing", "easting")
# record: code, derivation, then columns of fixed width: a name and three numbers
SDR_HEADER, SDR_POINT, SDR_MEASURED = "00NM", "08", "09"
# the last six characters of the header: angles, lengths, pressure, temperature, order
SDR_SETTINGS = re.compile(r"([1-9])([1-9])[1-9]{2}([1-9])[1-9]\s*$")
SDR_METRES, SDR_ORDERS = "1", {"1": NORTH_FIRST, "2": EAST_FIRST}
SDR_WIDTHS = {"3": (16, 16), "2": (4, 10)}  # of name and number, by version
SDR_HEAD = re.compile(rb"[^0]{0,12}00NM")  # instruments send a sign of start before
SDR_VERSION = re.compile(r"00NM\s*SDR([23])")
NIKON_POINTS = ("UP", "MP", "MC", "CC", "RE")  # sent, typed, computed, resected
NIKON_MEASURED = ("SS", "SO", "F1", "F2", "CP")
NIKON_ORDERS = {"NEZ": NORTH_FIRST, "ENZ": EAST_FIRST}
NIKON_HEAD = re.compile(rb"\s*CO,\s*(Nikon|Ruide) raw data", re.IGNORECASE)


def is_sdr(head) -> bool:
    """Whether first bytes are those of a book of SDR."""
    return SDR_HEAD.match(head) is not None


def is_nikon(head) -> bool:
    """Whether first bytes are those of raw data of Nikon or Ruide."""
    return NIKON_HEAD.match(head) is not None


@dataclass
class _Book:
    """What stands in a book, and the settings that hold from a line on."""

    source: str
    order: tuple | None = None
    names: list = None
    places: list = None
    n_measured: int = 0
    n_bare: int = 0  # points without coordinates

    def add(self, name, values, row):
        """Add a point with its numbers as they stand; without plane ones it is none."""
        wrong = next((one for one in values if one and not _is_finite(one)), None)
        if wrong is not None or not name:
            found = (
                f"the point {name!r} has {wrong!r}" if name else "a point has no name"
            )
            raise damaged(self.source, found, "a name and its coordinates", row)
        numbers = [float(one) if one else np.nan for one in values]
        is_missing = np.isnan(numbers[:2])
        if is_missing.all():
            self.n_bare += 1
            return
        if is_missing.any():
            raise damaged(
                self.source, f"the point {name!r} has one coordinate", row=row
            )
        place = dict(zip((*self.order, "height"), numbers, strict=True))
        self.names.append(name)
        self.places.append([place[one] for one in PLACE])


def _is_finite(text):
    return is_number(text) and np.isfinite(float(text))


def read_sdr(file) -> Foreign:
    """Read the points of a book of SDR2x or SDR33 that have coordinates."""
    book, widths = _Book(file.source, names=[], places=[]), None
    for row, line in _lines(file):
        if line.startswith(SDR_HEADER):
            widths, book.order = _sdr_settings(line, file.source, row)
        elif line.startswith(SDR_POINT) and widths is not None:
            name, number = widths
            edges = np.cumsum([4, name, number, number, number])
            parts = [line[a:b].strip() for a, b in pairwise(edges)]
            book.add(parts[0], parts[1:], row)
        book.n_measured += line.startswith(SDR_MEASURED)
    return _points_of(book)


def _sdr_settings(line, source, row):
    """Widths of name and number, and order of the coordinates, of a header."""
    settings, version = SDR_SETTINGS.search(line), SDR_VERSION.match(line)
    is_known = settings is not None and version is not None
    if not is_known or settings[3] not in SDR_ORDERS:
        found = f"the header {line.strip()!r} does not tell its version and units"
        raise damaged(source, found, "SDR33 or SDR20, and six digits at its end", row)
    if settings[2] != SDR_METRES:
        raise _feet(source, row)
    return SDR_WIDTHS[version[1]], SDR_ORDERS[settings[3]]


def read_nikon(file) -> Foreign:
    """Read the points of raw data of Nikon or Ruide that have coordinates."""
    book = _Book(file.source, names=[], places=[])
    for row, line in _lines(file):
        kind, _, rest = line.partition(",")
        if kind == "CO":
            key, _, value = rest.partition(":")
            if key.strip() == "Coord Order":
                _set_order(book, value.strip(), row)
            if key.strip() == "Dist Units":
                _require_metres(value.strip(), file.source, row)
        elif kind in NIKON_POINTS:
            if book.order is None:
                found = "nothing tells which coordinate comes first"
                raise damaged(file.source, found, "CO,Coord Order: NEZ or ENZ", row)
            name, _, *values = f"{rest},,,,".split(",")[:5]
            book.add(name.strip(), [one.strip() for one in values], row)
        book.n_measured += kind in NIKON_MEASURED
    return _points_of(book)


def _set_order(book, word, row):
    """Take the order of coordinates from a line on: one that is known, and no other."""
    order = NIKON_ORDERS.get(word.upper())
    if order is None or (book.names and order != book.order):
        found = f"the order of the coordinates is {word!r}"
        raise damaged(book.source, found, "NEZ or ENZ, the same in all of it", row)
    book.order = order


def _require_metres(word, source, row):
    """Refuse lengths in another unit, or in one that nobody knows."""
    if word.lower().startswith("met"):
        return
    if "f" in word.lower():
        raise _feet(source, row)
    raise damaged(source, f"the unit of lengths is {word!r}", "Metres or Feet", row)


def _lines(file):
    """Rows and lines; remarks are in the code page of the instrument."""
    text = file.data.decode("utf-8-sig", errors="replace")
    for row, line in enumerate(text.splitlines(), 1):
        yield row, line.lstrip("\x02").rstrip()


def _feet(source, row):
    return FileError(
        "the book is in feet",
        expected="metres",
        remedy="Set the instrument to metres, and export it again",
        file=source,
        row=row,
    )


def _points_of(book):
    """What was read, each point once; refused where no point has coordinates."""
    if not book.names:
        raise FileError(
            "holds no coordinates: angles and distances alone are no points",
            expected="records of points with coordinates",
            remedy="Export coordinates from the instrument, or compute them first",
            file=book.source,
        )
    table = pd.DataFrame(book.places, columns=PLACE)
    table.insert(0, "point_id", book.names)
    # an instrument writes a point anew whenever it is looked at
    table = table.drop_duplicates(ignore_index=True).dropna(axis=1, how="all")
    first = book.order[0]
    notes = [f"{book.source}: the {first} comes first, as the header has it"]
    if book.n_measured:
        left_out = kept("{n:measurement|measurements} left out", n=book.n_measured)
        notes.append(f"{book.source}: {left_out}")
    if book.n_bare:
        left_out = kept("{n:point|points} without coordinates left out", n=book.n_bare)
        notes.append(f"{book.source}: {left_out}")
    tables = {"control_points": table}
    return Foreign(tables, None, tuple(notes), unit=METRES, unit_m=1.0)
